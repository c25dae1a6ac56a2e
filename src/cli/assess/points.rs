//! What `--rare`, `--sobol` and `--envelope` share: a mission with a drop, flights at points of its trials,
//! and the answer when they are stopped.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPool;
use rayon::prelude::*;

use super::args::AssessArgs;
use super::study;
use crate::cli::answer::{Answer, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use crate::cli::progress::ProgressLine;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::assess::Outcome;
use samara::assess::coordinates::TrialSpace;
use samara::config::Mission;
use samara::sim::planar::LANES;

/// The mission of an `option` that is about drops.
pub fn mission(args: &AssessArgs, option: &str, narrator: &Narrator) -> Result<Mission, Failure> {
    let mission = study::mission(args, narrator)?;
    if mission.release.standing {
        let message = format!("{option} is about drops, and this mission begins on the ground");
        return Err(Failure::input(format!("{}: {message}", mission.file.display())));
    }
    Ok(mission)
}

/// Ctrl-C ended the flights.
pub struct Stopped;

/// Flies points on many threads, until Ctrl-C.
pub struct Flights<'a> {
    space: &'a TrialSpace,
    pool: ThreadPool,
    progress: ProgressLine,
    stop: &'a AtomicBool,
}

impl<'a> Flights<'a> {
    /// Begins flights, at most so many; reports how long they take where they are flown in six degrees of
    /// freedom.
    pub fn new(
        space: &'a TrialSpace,
        threads: Option<u16>,
        most: u64,
        stop: &'a AtomicBool,
    ) -> Result<Self, Failure> {
        let pool = thread_pool(threads)?;
        if let Some(reason) = space.one_at_a_time() {
            let nominal = vec![vec![0.0; space.dimensions()]; LANES];
            warn_in_space(reason, (most, LANES), pool.current_num_threads(), || space.fly(&nominal));
        }
        Ok(Self { space, pool, progress: ProgressLine::new("assess", "flights", most), stop })
    }

    /// The outcomes at some points.
    pub fn fly(&self, points: &[Vec<f64>]) -> Result<Vec<Outcome>, Stopped> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(Stopped);
        }
        let fly = |some: &[Vec<f64>]| self.space.fly(some);
        let flown: Vec<Vec<Outcome>> = self.pool.install(|| points.par_chunks(LANES).map(fly).collect());
        self.progress.inc(points.len() as u64);
        Ok(flown.into_iter().flatten().collect())
    }

    /// Ends the report of how far the flights are.
    pub fn finish(&self) {
        self.progress.finish();
    }
}

/// The answer of flights that were stopped, with an object whose `key` has no value.
pub fn stopped(
    args: &AssessArgs,
    mission: &Mission,
    key: &str,
    narrator: &Narrator,
) -> Result<Answer, Failure> {
    narrator.say("stopped: nothing is kept of flights that are not complete\n");
    narrator.check()?;
    if args.mission.json {
        let object = serde_json::json!({ "mission": mission.name, key: null, "reason": "stopped" });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}
