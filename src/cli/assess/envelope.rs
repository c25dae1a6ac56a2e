//! `samara assess --envelope`: how far from the nominal release a drop may begin and be safe, two quantities
//! at a time.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
use rayon::prelude::*;

use super::args::AssessArgs;
use super::points::{mission, stopped};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use crate::cli::planning::plan_to_fly;
use crate::cli::progress::ProgressLine;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::assess::envelope::{Edge, EdgeSearch, EnvelopeAxis, Fan, Ray, Reaches, Stopped, reaches_of};
use samara::config::Mission;
use samara::plan::Plan;
use samara::report::envelope::{EnvelopeReport, FanEdges};
use samara::report::figure::envelope_figure;
use samara::study::envelope::{ENVELOPE_LIMITS, MissionEnvelope};

/// Directions along one quantity alone.
const QUARTERS: usize = 4;
/// About how many flights a ray takes, of both limits.
const FLIGHTS_OF_A_RAY: u64 = 3000;

/// Searches the edges, writes and reports them.
pub fn run(args: &AssessArgs, pairs: &[[EnvelopeAxis; 2]], stop: &AtomicBool) -> Result<Answer, Failure> {
    let narrator = Narrator::alone(args.mission.json);
    let mission = mission(args, "--envelope", &narrator)?;
    let folder = OutputFolder::create("assess_envelope", args.mission.out.as_deref(), &mission.name)?;
    let Some(timed) = plan_to_fly(&mission, &folder, &narrator, args.mission.json)? else {
        return Ok(Answer::No);
    };
    let Ok(report) = searched(args, pairs, &mission, &timed.plan, stop)? else {
        return stopped(args, &mission, "pairs", &narrator);
    };
    folder.write_text("envelope.txt", &report.document().text())?;
    folder.write_text("envelope.csv", &report.csv())?;
    folder.write_text("envelope.json", &report.json())?;
    folder.write_text("envelope.svg", &envelope_figure(&report).context("the figure of the envelope")?)?;
    let asked: Vec<String> = pairs.iter().map(|pair| pair.map(EnvelopeAxis::name).join(":")).collect();
    let circumstances = [("envelope", asked.join(",")), ("rays", args.rays().to_string())];
    folder.write_manifest("assess_envelope", &mission, &circumstances)?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!(
            "\n{}every edge in {}\n",
            report.document().text(),
            folder.path().join("envelope.csv").display()
        )
    })?;
    Ok(Answer::from(report.nominal_is_safe()))
}

/// Rays that were searched, with their edges.
struct Searched<'a> {
    envelope: &'a MissionEnvelope,
    search: EdgeSearch,
    pool: rayon::ThreadPool,
    stop: &'a AtomicBool,
    progress: ProgressLine,
    /// By which limits the nominal release is safe: in the mission's own turbulence, or in the point's.
    nominal: Vec<(bool, [bool; 2])>,
    rays: Vec<Ray>,
    edges: Vec<Vec<Edge>>,
}

impl Searched<'_> {
    fn nominal_of(&self, ray: &Ray) -> [bool; 2] {
        let found = self.nominal.iter().find(|(of, _)| *of == ray.from.sets_turbulence);
        found.map_or([false; 2], |(_, safe)| *safe)
    }

    fn edges_of(&self, ray: &Ray) -> Vec<Edge> {
        let place = self.rays.iter().position(|known| known == ray);
        place.and_then(|place| self.edges.get(place)).cloned().unwrap_or_default()
    }

    /// Searches the rays of fans that were not searched yet, on all threads. A ray along one quantity is that
    /// of several fans.
    fn search(&mut self, fans: &[Fan]) -> Result<(), Stopped> {
        let stopped = || self.stop.load(Ordering::Relaxed);
        let first = self.rays.len();
        for (_, ray) in fans.iter().flat_map(|fan| &fan.rays) {
            let of = ray.from.sets_turbulence;
            if self.nominal.iter().all(|(known, _)| *known != of) {
                self.nominal.push((of, self.envelope.nominal(&self.search, ray, &stopped)?));
            }
            if !self.rays.contains(ray) {
                self.rays.push(*ray);
            }
        }
        let numbered: Vec<(u64, Ray)> = (0..).zip(self.rays.iter().copied()).skip(first).collect();
        let along = |(number, ray): &(u64, Ray)| {
            let limits = ENVELOPE_LIMITS.into_iter().zip(self.nominal_of(ray)).filter(|(_, safe)| *safe);
            let limits: Vec<f64> = limits.map(|(limit, _)| limit).collect();
            let edges = self.envelope.edges(&self.search, (*number, ray), &limits, &stopped);
            self.progress.inc(1);
            edges
        };
        let edges: Result<Vec<Vec<Edge>>, Stopped> =
            self.pool.install(|| numbered.par_iter().map(along).collect());
        self.edges.extend(edges?);
        Ok(())
    }

    /// How far each quantity goes by itself, as far as the rays that were searched show it.
    fn reaches(&self) -> Reaches {
        let mut reaches = reaches_of(self.envelope.ranges());
        for (ray, edges) in self.rays.iter().zip(&self.edges) {
            let Some(edge) = edges.last().filter(|edge| edge.safe > 0.0) else { continue };
            let moved =
                EnvelopeAxis::ALL.into_iter().filter(|axis| ray.to.value(*axis) != ray.from.value(*axis));
            let moved: Vec<EnvelopeAxis> = moved.collect();
            if let [axis] = moved[..] {
                let way = ray.at(edge.safe).value(axis) - ray.from.value(axis);
                reaches[axis as usize][usize::from(way > 0.0)] = way.abs();
            }
        }
        reaches
    }
}

/// The edges of every fan: along single quantities first, then along directions that their edges spread.
fn searched<'a>(
    args: &AssessArgs,
    pairs: &[[EnvelopeAxis; 2]],
    mission: &'a Mission,
    plan: &Plan,
    stop: &AtomicBool,
) -> Result<Result<EnvelopeReport<'a>, Stopped>, Failure> {
    let envelope = MissionEnvelope::new(mission, &plan.trajectory).bad_input()?;
    let ranges = envelope.ranges();
    let fans = |reaches: &Reaches, turns: usize| -> Vec<Fan> {
        pairs.iter().map(|axes| Fan::new(*axes, ranges, reaches, turns)).collect()
    };
    let mut rays: Vec<Ray> = Vec::new();
    for (_, ray) in fans(&reaches_of(ranges), args.rays()).iter().flat_map(|fan| &fan.rays) {
        if !rays.contains(ray) {
            rays.push(*ray);
        }
    }
    let mut searched = Searched {
        envelope: &envelope,
        search: EdgeSearch::default(),
        pool: thread_pool(args.threads)?,
        stop,
        progress: ProgressLine::new("assess", "rays", rays.len() as u64),
        nominal: Vec::new(),
        rays: Vec::new(),
        edges: Vec::new(),
    };
    if let (Some(reason), Some(ray)) = (envelope.one_at_a_time(), rays.first()) {
        let one = EdgeSearch { flights: 1, ..EdgeSearch::default() };
        let fly_one = || envelope.nominal(&one, ray, &|| stop.load(Ordering::Relaxed));
        let count = rays.len() as u64 * FLIGHTS_OF_A_RAY / ENVELOPE_LIMITS.len() as u64;
        warn_in_space(reason, (count, 1), searched.pool.current_num_threads(), fly_one);
    }
    let mut run = || {
        searched.search(&fans(&reaches_of(ranges), QUARTERS))?;
        let fans = fans(&searched.reaches(), args.rays());
        let more = fans.iter().flat_map(|fan| &fan.rays).filter(|(_, ray)| !searched.rays.contains(ray));
        searched.progress.set_whole((searched.rays.len() + more.count()) as u64);
        searched.search(&fans)?;
        Ok(fans)
    };
    let found = run();
    searched.progress.finish();
    let fans = match found {
        Ok(fans) => fans,
        Err(stopped) => return Ok(Err(stopped)),
    };
    let fans = fans.into_iter().map(|fan| FanEdges {
        nominal: fan.rays.first().map_or([false; 2], |(_, ray)| searched.nominal_of(ray)),
        edges: fan.rays.iter().map(|(_, ray)| searched.edges_of(ray)).collect(),
        fan,
    });
    Ok(Ok(EnvelopeReport {
        mission,
        fans: fans.collect(),
        ranges: *ranges,
        plan_j_tpf: mission.integrated(&plan.trajectory).j_tpf,
        search: searched.search.clone(),
    }))
}
