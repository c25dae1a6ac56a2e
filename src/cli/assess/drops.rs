//! `samara assess --autopilot`: a campaign of whole drops, by the reference autopilot or by PX4, several side by side.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use anyhow::Context;

use super::AssessArgs;
use crate::assess::{DropMeasure, RandomDrop};
use crate::cli::args::{AutopilotArg, ChoiceArgs, EstimatorChoice};
use crate::cli::drop::{Flown, Pilot, tell_if_stopped, tell_verdict};
use crate::cli::flight_files::write_flight;
use crate::cli::narrative::Narrator;
use crate::cli::outcome::{Answer, BadInput, Failure};
use crate::cli::output::{OutputFolder, print, tell};
use crate::cli::plan::{plan_mission, write_plan};
use crate::cli::px4::flight::Px4Drop;
use crate::cli::{px4, sessions};
use crate::config::Mission;
use crate::link::Lockstep;
use crate::link::shell::ports::MAX_INSTANCE;
use crate::link::shell::{Speed, system_of_instance};
use crate::plan::Status;
use crate::report::drops::{DropTally, DropTrial, drops_json, drops_text, header, row};
use crate::report::plan_text;
use crate::trajectory::Trajectory;

/// Drops flown side by side unless it is said otherwise: each is a PX4 and a simulator that wait for each other.
const SIDE_BY_SIDE: u16 = 2;

/// What every trial shares.
struct Campaign<'a> {
    args: &'a AssessArgs,
    pilot: Pilot,
    mission: Mission,
    plan: Trajectory,
    folder: &'a std::path::Path,
}

/// Flies the campaign, or one trial of it.
///
/// # Errors
/// [`Failure::BadInput`] when PX4 is not there, the mission does not suit, or a file cannot be written.
pub fn run(args: &AssessArgs, autopilot: &AutopilotArg, stop: &AtomicBool) -> Result<Answer, Failure> {
    let (pilot, mission) = Pilot::of(autopilot, &args.mission.mission, &args.choice, &args.state)?;
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        tell(&format!("no plan to fly: {}", plan_text(&timed.plan, &mission.limits, None)));
        return Ok(Answer::No);
    }
    let plan = timed.plan.trajectory;
    let campaign = Campaign { args, pilot, mission, plan, folder: folder.path() };
    match args.only {
        Some(trial) => campaign.only(trial),
        None => campaign.fly_all(&folder, stop),
    }
}

impl Campaign<'_> {
    fn autopilot(&self) -> &'static str {
        match self.pilot {
            Pilot::Reference(_) if self.args.state.estimator == EstimatorChoice::Ekf => "reference_ekf",
            Pilot::Reference(_) => "reference",
            Pilot::Px4(..) => "px4",
            Pilot::Px4Model(_) => "px4-model",
        }
    }

    fn name(&self) -> String {
        let gains = self.mission.gains_name.trim_end_matches(".params");
        format!("drops_{}_{gains}", self.autopilot())
    }

    /// One trial, told as `samara drop` tells it, all files kept.
    fn only(&self, trial: u64) -> Result<Answer, Failure> {
        let drawn = self.mission.draw_drop(trial);
        let folder = self.kept(trial)?;
        let narrator = Narrator::together(self.args.mission.json);
        let mission = self.mission.with_drop(&drawn);
        let (trial, flown) = self.fly(&drawn, &mission, self.args.instance, &folder, &narrator)?;
        let verdict = trial.outcome.as_ref().map(|o| &o.verdict);
        write_flight(&folder, &mission, &flown.log, Some(&self.plan), verdict)?;
        if let Some(verdict) = verdict {
            tell_verdict(&narrator, &mission, verdict, &flown.log, &folder)?;
        }
        let mut tally = DropTally::default();
        tally.push(&trial);
        if self.args.mission.json {
            print(&drops_json(&self.mission, self.autopilot(), &tally))?;
        } else {
            print(&format!("\n{}{}", header(&self.mission, self.autopilot()), row(&trial)))?;
        }
        Ok(if tally.any_failed() { Answer::No } else { Answer::Yes })
    }

    /// The folder of a trial whose files are kept, empty.
    fn kept(&self, trial: u64) -> Result<OutputFolder, Failure> {
        let path = self.folder.join(format!("trial_{trial}"));
        remove_folder(&path)?;
        OutputFolder::create(Some(&path), &self.mission.name)
    }

    fn fly_all(&self, folder: &OutputFolder, stop: &AtomicBool) -> Result<Answer, Failure> {
        let trials = self.args.trials.unwrap_or(self.mission.monte_carlo.trials as u64);
        let places = MAX_INSTANCE + 1 - self.args.instance;
        let workers = self.args.threads.unwrap_or(SIDE_BY_SIDE).min(places);
        let csv = format!("{}.csv", self.name());
        let mut file = folder.continued(&csv, 0)?;
        let mut write = |text: &str| file.write_all(text.as_bytes()).context(csv.clone()).bad_input();
        write(&header(&self.mission, self.autopilot()))?;
        let (next, mut tally) = (AtomicU64::new(0), DropTally::default());
        let (done, comes) = mpsc::channel();
        let told = std::thread::scope(|scope| {
            for place in 0..workers {
                let (done, next) = (done.clone(), &next);
                scope.spawn(move || {
                    while !stop.load(Ordering::Relaxed) {
                        let trial = next.fetch_add(1, Ordering::Relaxed);
                        // Nobody listens any more when a file could not be written.
                        if trial >= trials || done.send(self.trial(trial, place)).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(done);
            // Lines are in order, whichever trial is over first.
            let (mut early, mut wanted) = (BTreeMap::new(), 0);
            for trial in comes {
                if stop.load(Ordering::Relaxed) {
                    continue;
                }
                early.insert(trial.drawn.trial, trial);
                while let Some(trial) = early.remove(&wanted) {
                    write(&row(&trial))?;
                    tally.push(&trial);
                    wanted += 1;
                    self.tell(&trial, trials);
                }
            }
            Ok::<(), Failure>(())
        });
        told?;
        folder.write_manifest(&self.name(), &self.mission, &[("trials", trials.to_string())])?;
        if self.args.mission.json {
            print(&drops_json(&self.mission, self.autopilot(), &tally))?;
        } else {
            let place = folder.path().join(&csv);
            print(&format!(
                "{}\nlines in {}\n",
                drops_text(&self.mission, self.autopilot(), &tally),
                place.display()
            ))?;
        }
        let complete = tally.flown() == trials;
        if !complete {
            tell(&format!("stopped after {} of {trials} drops\n", tally.flown()));
        }
        // Last: a folder that cannot be removed takes no result away.
        for place in 0..workers {
            remove_folder(&self.folder.join(format!("place_{place}")))?;
        }
        Ok(if complete && !tally.any_failed() { Answer::Yes } else { Answer::No })
    }

    fn tell(&self, trial: &DropTrial, trials: u64) {
        let number = trial.drawn.trial;
        let text = match (&trial.failure, &trial.outcome) {
            (Some(failure), _) => format!("FAILED: {failure}"),
            (None, Some(o)) => format!(
                "J_TPF {:.4}, steady after {:.2} s",
                o.verdict.j_tpf,
                o.verdict.steady_after_s.unwrap_or(f64::NAN)
            ),
            (None, None) => "nothing".to_owned(),
        };
        tell(&format!("trial {number} of {trials}: {text}\n"));
    }

    /// A trial at one of the places; whatever goes wrong is its failure. The files of one that failed are kept.
    fn trial(&self, number: u64, place: u16) -> DropTrial {
        let drawn = self.mission.draw_drop(number);
        let failed = |why: Failure| DropTrial { drawn, outcome: None, failure: Some(why.text()) };
        let scratch = self.folder.join(format!("place_{place}"));
        let folder = match OutputFolder::create(Some(&scratch), &self.mission.name) {
            Ok(folder) => folder,
            Err(why) => return failed(why),
        };
        let mission = self.mission.with_drop(&drawn);
        let flown = self.fly(&drawn, &mission, self.args.instance + place, &folder, &Narrator::silent());
        let (mut trial, log) = match flown {
            Ok((trial, flown)) => (trial, Some(flown.log)),
            Err(why) => (failed(why), None),
        };
        if let Some(failure) = &mut trial.failure {
            let verdict = trial.outcome.as_ref().map(|o| &o.verdict);
            let written =
                log.map_or(Ok(()), |log| write_flight(&folder, &mission, &log, Some(&self.plan), verdict));
            if let Err(why) = written.and_then(|()| self.keep(number, &folder)) {
                *failure = format!("{failure}; {}", why.text());
            }
        }
        trial
    }

    /// Keeps the files of a trial that failed.
    fn keep(&self, trial: u64, folder: &OutputFolder) -> Result<(), Failure> {
        let kept = self.folder.join(format!("trial_{trial}"));
        remove_folder(&kept)?;
        fs::rename(folder.path(), &kept)
            .with_context(|| format!("cannot keep the files in {}", kept.display()))
            .bad_input()
    }

    fn fly(
        &self,
        drawn: &RandomDrop,
        mission: &Mission,
        instance: u16,
        folder: &OutputFolder,
        narrator: &Narrator,
    ) -> Result<(DropTrial, Flown), Failure> {
        let flown = match &self.pilot {
            Pilot::Reference(_) => self.fly_reference(mission)?,
            Pilot::Px4(build, parameters) => {
                let drop = Px4Drop {
                    build,
                    instance,
                    cpu: px4::Cpu::Auto,
                    speed: Speed::Max,
                    parameters: parameters.as_ref(),
                    feed_forward: self.args.feed_forward,
                };
                px4::fly(&drop, mission, &self.plan, folder, narrator)?
            }
            Pilot::Px4Model(parameters) => {
                px4::model::fly(mission, &self.plan, parameters.as_ref(), self.args.feed_forward)?
            }
        };
        let measure = DropMeasure {
            limits: mission.limits,
            target_v_ned: mission.target_v_ned,
            steady_within_m_s: mission.steady_within_m_s,
            plan: &self.plan,
        };
        let outcome = measure.of(&flown.log);
        let stopped = tell_if_stopped(&Narrator::silent(), mission, &flown.log)?;
        let failure = match (&outcome, &flown.trouble) {
            (None, None) => Some("never released".to_owned()),
            (None, Some(trouble)) => Some(format!("never released: {trouble}")),
            (Some(_), Some(trouble)) => Some(trouble.clone()),
            (Some(o), None) if !o.verdict.limits_passed.is_empty() => {
                Some(format!("limits passed: {}", o.verdict.limits_passed.join(", ")))
            }
            (Some(_), None) if flown.record.failsafe => Some("a failsafe flew".to_owned()),
            (Some(_), None) if stopped => Some("stopped before the mission's end".to_owned()),
            (Some(o), None) if o.verdict.steady_after_s.is_none() => Some("never steady".to_owned()),
            (Some(_), None) => None,
        };
        Ok((DropTrial { drawn: *drawn, outcome, failure }, flown))
    }

    /// The reference autopilot, over the wire in memory.
    fn fly_reference(&self, mission: &Mission) -> Result<Flown, Failure> {
        let system = system_of_instance(self.args.instance).bad_input()?;
        let choice =
            ChoiceArgs { gains: None, params: self.args.choice.params.clone(), seed: None, case: None };
        let mut wire = Lockstep::new(
            sessions::simulator(mission, system, None),
            sessions::autopilot(mission, &choice, &self.args.state, system, false)?,
            sessions::streamer(mission, self.plan.clone(), system, sessions::StreamerChoice::default()),
        );
        while wire.step(&mut |_, _, _| {}).map_err(anyhow::Error::from)? {
            while wire.simulator.poll_event().is_some() || wire.streamer.poll_event().is_some() {}
            while wire.autopilot.poll_log().is_some() {}
        }
        let record = wire.simulator.record().clone();
        let trouble = wire.streamer.failure().map(str::to_owned);
        Ok(Flown { log: wire.simulator.into_log(), record, real_time_factor: f64::NAN, trouble })
    }
}

/// Removes a folder with all that is in it, if it is there.
fn remove_folder(path: &std::path::Path) -> Result<(), Failure> {
    match fs::remove_dir_all(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
            Err(e).with_context(|| format!("cannot remove {}", path.display())).bad_input()
        }
        _ => Ok(()),
    }
}
