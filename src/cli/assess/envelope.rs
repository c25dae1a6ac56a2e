//! `samara assess --envelope`: how far from the nominal release a drop may begin and be safe, two quantities
//! at a time.

use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
use rayon::prelude::*;

use super::args::AssessArgs;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_one_at_a_time;
use crate::cli::mission::{chosen_mission, origin};
use crate::cli::narrator::Narrator;
use crate::cli::planning::{plan_mission, write_plan};
use crate::cli::progress::Progress;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::assess::envelope::{Edge, EdgeSearch, EnvelopeAxis, Fan, Ray, Stopped};
use samara::assess::plan_j_tpf;
use samara::config::{ENVELOPE_LIMITS, Mission, MissionEnvelope};
use samara::plan::{Plan, Status};
use samara::report::envelope::{EnvelopeReport, FanEdges};
use samara::report::figure::envelope_figure;
use samara::report::{plan_json, plan_text};

/// About how many flights a ray takes, of both limits.
const FLIGHTS_OF_A_RAY: u64 = 3000;

/// Searches the edges, writes and reports them.
pub fn run(args: &AssessArgs, pairs: &[[EnvelopeAxis; 2]], stop: &AtomicBool) -> Result<Answer, Failure> {
    let mission = chosen_mission(&args.mission.mission, &args.choice)?;
    mission.faults.check_from_t0().bad_input()?;
    if mission.release.standing {
        let message = "--envelope is about drops, and this mission begins on the ground";
        return Err(Failure::input(format!("{}: {message}", mission.file.display())));
    }
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(&args.mission.mission, &mission));
    mission.two_bodies_remark().into_iter().for_each(|remark| narrator.say(&remark));
    mission.rotor_start_remark().into_iter().for_each(|remark| narrator.say(remark));
    mission.battery_remark().into_iter().for_each(|remark| narrator.say(&format!("{remark}\n")));
    let folder = OutputFolder::create(args.mission.out.as_deref(), &mission.name)?;
    let timed = plan_mission(&mission, false)?;
    write_plan(&folder, &mission, &timed.plan)?;
    if timed.plan.status != Status::Converged {
        narrator.say(&format!("no plan to fly: {}", plan_text(&timed.plan, &mission.limits.safety, None)));
        narrator.check()?;
        if args.mission.json {
            print(&plan_json(&mission, &timed.plan, Some(timed.solve_ms)))?;
        }
        return Ok(Answer::No);
    }
    let Ok(report) = searched(args, pairs, &mission, &timed.plan, stop)? else {
        narrator.say("stopped: nothing is kept of an envelope that is not complete\n");
        narrator.check()?;
        if args.mission.json {
            let reason = Stopped.to_string();
            let object = serde_json::json!({ "mission": mission.name, "pairs": null, "reason": reason });
            print(&format!("{object:#}\n"))?;
        }
        return Ok(Answer::No);
    };
    folder.write_text("envelope.txt", &report.text())?;
    folder.write_text("envelope.csv", &report.csv())?;
    folder.write_text("envelope.json", &report.json())?;
    folder.write_text("envelope.svg", &envelope_figure(&report).context("the figure of the envelope")?)?;
    let asked: Vec<String> = pairs.iter().map(|pair| pair.map(EnvelopeAxis::name).join(":")).collect();
    let circumstances = [("envelope", asked.join(",")), ("rays", args.rays.to_string())];
    folder.write_manifest("assess_envelope", &mission, &circumstances)?;
    print(&if args.mission.json {
        report.json()
    } else {
        format!("\n{}every edge in {}\n", report.text(), folder.path().join("envelope.csv").display())
    })?;
    Ok(Answer::from(report.nominal_is_safe()))
}

/// The edges of every fan, on all threads.
fn searched<'a>(
    args: &AssessArgs,
    pairs: &[[EnvelopeAxis; 2]],
    mission: &'a Mission,
    plan: &Plan,
    stop: &AtomicBool,
) -> Result<Result<EnvelopeReport<'a>, Stopped>, Failure> {
    let envelope = MissionEnvelope::new(mission, &plan.trajectory).bad_input()?;
    let (search, pool) = (EdgeSearch::default(), thread_pool(args.threads)?);
    let fans: Vec<Fan> = pairs.iter().map(|axes| envelope.fan(*axes, args.rays)).collect();
    // A ray along one quantity is that of several fans.
    let mut rays: Vec<Ray> = Vec::new();
    for (_, ray) in fans.iter().flat_map(|fan| &fan.rays) {
        if !rays.contains(ray) {
            rays.push(*ray);
        }
    }
    let stopped = || stop.load(Ordering::Relaxed);
    // The two beginnings that there may be: in the mission's own turbulence, and in the point's.
    let mut nominal: Vec<(bool, [bool; 2])> = Vec::new();
    for ray in &rays {
        let of = ray.from.sets_turbulence;
        if nominal.iter().all(|(known, _)| *known != of) {
            match envelope.nominal(&search, ray, &stopped) {
                Ok(safe) => nominal.push((of, safe)),
                Err(stopped) => return Ok(Err(stopped)),
            }
        }
    }
    let nominal_of = |ray: &Ray| {
        let found = nominal.iter().find(|(of, _)| *of == ray.from.sets_turbulence);
        found.map_or([false; 2], |(_, safe)| *safe)
    };
    if let (Some(reason), Some(ray)) = (envelope.one_at_a_time(), rays.first()) {
        let one = EdgeSearch { flights: 1, ..search.clone() };
        let fly_one = || envelope.nominal(&one, ray, &stopped);
        let count = rays.len() as u64 * FLIGHTS_OF_A_RAY / ENVELOPE_LIMITS.len() as u64;
        warn_one_at_a_time(reason, count, pool.current_num_threads(), fly_one);
    }
    let progress = Progress::new("assess", "rays", rays.len() as u64);
    let numbered: Vec<(u64, Ray)> = (0..).zip(rays.iter().copied()).collect();
    let along = |(number, ray): &(u64, Ray)| {
        let limits = ENVELOPE_LIMITS.into_iter().zip(nominal_of(ray)).filter(|(_, safe)| *safe);
        let limits: Vec<f64> = limits.map(|(limit, _)| limit).collect();
        let edges = envelope.edges(&search, (*number, ray), &limits, &stopped);
        progress.inc(1);
        edges
    };
    let edges: Result<Vec<Vec<Edge>>, Stopped> = pool.install(|| numbered.par_iter().map(along).collect());
    progress.finish();
    let edges = match edges {
        Ok(edges) => edges,
        Err(stopped) => return Ok(Err(stopped)),
    };
    let of_ray = |(_, ray): &(usize, Ray)| {
        let place = rays.iter().position(|known| known == ray);
        place.and_then(|place| edges.get(place)).cloned().unwrap_or_default()
    };
    let fans = fans.into_iter().map(|fan| FanEdges {
        nominal: fan.rays.first().map_or([false; 2], |(_, ray)| nominal_of(ray)),
        edges: fan.rays.iter().map(of_ray).collect(),
        fan,
    });
    Ok(Ok(EnvelopeReport {
        mission,
        fans: fans.collect(),
        ranges: *envelope.ranges(),
        plan_j_tpf: plan_j_tpf(&plan.trajectory, &mission.limits.safety),
        search,
    }))
}
