//! `samara tune --for px4`: PX4's own parameters, by the evolution strategy on the model of PX4's
//! controller.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use nalgebra::Vector3;

use super::args::{MethodArg, ModelArg, ObjectiveArg, STALL, TuneArgs, name_of};
use super::results::{CHECKPOINT, no_gains, report_nothing};
use super::settings::particles;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::pilot::px4::upload::suits;
use crate::cli::results::OutputFolder;
use crate::cli::search::{SearchSession, identity_of, run_search};
use samara::config::Mission;
use samara::control::Gains;
use samara::control::px4::{Law, is_quad_x};
use samara::host::Threads;
use samara::params::{ParameterFile, Subject, px4_model_export, px4_model_parameters};
use samara::report::params::params_file;
use samara::study::px4_gains::{PX4S_DEFAULTS, Px4Gains, document, gains_json};
use samara::study::tuning::gain_ends;
use samara::trajectory::Trajectory;
use samara::tune::objective::PENALTY;
use samara::tune::px4::space::{Candidate, names, range_ends};
use samara::tune::px4::{
    LATENCY_S, Measures, Px4Judge, Px4Search, Px4SearchSettings, Px4Setting, drops, drops_from, latency_s,
};
use samara::tune::release_cases::AMPLITUDES;

/// Random drops that a candidate is judged by, besides the mission's release cases.
const DROPS: u64 = 24;
/// The number of the first unseen drop.
const UNSEEN_FROM: u64 = 1_000_000;

/// Refuses options that have no meaning here, and a mission or a vehicle that PX4 cannot fly.
pub fn refuse_unsuitable(args: &TuneArgs, mission: &Mission) -> Result<(), Failure> {
    refuse_meaningless(args)?;
    suits(mission).bad_input()?;
    if law(args).allocates {
        return Ok(());
    }
    let hint = |why| anyhow::anyhow!("{why}: v1.14 and later take any rotors, --px4-version v1.14");
    is_quad_x(&mission.vehicle).map_err(hint).bad_input()
}

/// The law of the version that is tuned for.
fn law(args: &TuneArgs) -> Law {
    args.px4_version.unwrap_or(Law::V1_12)
}

/// Tunes, tries on unseen drops, writes `gains.params` and `px4_gains.txt`.
pub fn run(
    args: &TuneArgs,
    mission: &Mission,
    plan: &Trajectory,
    threads: &Threads,
) -> Result<Answer, Failure> {
    let (purpose, law) = (mission.px4_purpose(), law(args));
    // PX4 as it comes, given only the vehicle; and with the mission's gains.
    let untouched = ParameterFile::default();
    let of = |given| px4_model_parameters(&mission.parameter_subject(), purpose, &law, given).bad_input();
    let (defaults, missions) = (of(Some(&untouched))?, of(None)?);
    let similarity = purpose.factors(mission.site.environment.gravity_m_s2).k;
    let late = on_a_px4_that_flies(mission, similarity);
    let setting = Px4Setting {
        law,
        scenario: late.scenario(),
        air: mission.site.wind_number,
        similarity,
        plan,
        feed_forward: mission.control.feed_forward,
        settle_s: mission.settle_s(plan),
        start: mission.release.start,
        v_error_ned: Vector3::zeros(),
    };
    let releases = mission.releases();
    let wind_sigma_m_s = mission.study.monte_carlo.wind_sigma_m_s;
    let drops = |trials| drops(&setting, &releases, wind_sigma_m_s, mission.seed, trials);
    let references = [(PX4S_DEFAULTS, &defaults), ("the mission's gains", &missions)];
    let folder = args.search.folder("tune", CHECKPOINT, (args.mission.out.as_deref(), &mission.name))?;
    let mut search = Px4Search::new(&defaults, &missions, settings(args, &late, &law)?);
    let mut seen = drops(0..DROPS);
    seen.extend(drops_from(&setting, mission.case_parachutes()));
    let (seen, stop) = (Px4Judge::new(seen, &references), args.search.interrupt_flag()?);
    let judge =
        |search: &Px4Search, _: usize, candidate: &Candidate| Some(seen.cost(&search.parameters(candidate)));
    let session = SearchSession {
        verb: "tune",
        folder: &folder,
        checkpoint: CHECKPOINT,
        identity: &identity(args, mission),
        how: &args.search,
        threads,
        stop: &|| stop.load(Ordering::Relaxed),
    };
    let measured = |search: &Px4Search| progress(search, seen.measured_by);
    let done = match run_search(&session, &mut search, judge, measured)? {
        ControlFlow::Continue(done) => done,
        ControlFlow::Break(answer) => return Ok(answer),
    };
    let Some((_, best)) = search.best().filter(|(cost, _)| cost.is_finite()) else {
        return report_nothing(args, &mission.name, no_gains(done.stopped));
    };
    let found = search.parameters(&best);
    let unseen = drops(UNSEEN_FROM..UNSEEN_FROM + u64::from(args.unseen));
    let on_unseen = |parameters| {
        let flown: Vec<Measures> = threads.each(&unseen, |drop| drop.fly(parameters));
        Measures::mean(&flown)
    };
    let result = Px4Gains {
        law,
        name: args.name.clone(),
        purpose,
        defaults: on_unseen(&defaults),
        measured_by: seen.measured_by,
        found: on_unseen(&found),
        parameters: found,
        range_ends: range_ends(&best, search.bounds()),
        latency_s: late.vehicle.latency_s,
        drops: seen.count() as u64,
        unseen: args.unseen,
        evaluations: search.evaluations(),
        stopped: done.stopped,
    };
    write(args, &folder, mission, &result)?;
    let good = result.found.beats(&result.defaults) && !done.stopped;
    Ok(Answer::from(good))
}

fn refuse_meaningless(args: &TuneArgs) -> Result<(), Failure> {
    let given = [
        (matches!(args.method, MethodArg::Pso | MethodArg::NearHover), "--method"),
        (args.objective != ObjectiveArg::Safety, "--objective"),
        (args.model != ModelArg::Actuator, "--model"),
        (args.rms_bound.is_some(), "--rms-bound"),
        (args.penalty != PENALTY, "--penalty"),
        (args.swing != AMPLITUDES, "--swing"),
        (args.stall != STALL, "--stall"),
        (args.robust, "--robust"),
        (args.start.is_some(), "--start"),
    ];
    match given.iter().find(|(given, _)| *given) {
        Some((_, option)) => Err(Failure::input(format!("{option} has no meaning with --for px4"))),
        None => Ok(()),
    }
}

/// The mission with the latency that gains for PX4 are judged by.
fn on_a_px4_that_flies(mission: &Mission, similarity: f64) -> Mission {
    let mut late = mission.clone();
    let vehicle = Arc::make_mut(&mut late.vehicle);
    vehicle.latency_s = latency_s(vehicle.latency_s, similarity);
    late
}

fn settings(args: &TuneArgs, mission: &Mission, law: &Law) -> Result<Px4SearchSettings, Failure> {
    let [least, most] = gain_ends(mission).map(|gains| {
        let gains = Gains::longitudinal(gains);
        let subject = Subject { gains: &gains, ..mission.parameter_subject() };
        px4_model_parameters(&subject, mission.px4_purpose(), law, None).bad_input()
    });
    Ok(Px4SearchSettings {
        samples: args.particles.map(|n| n as usize),
        iterations: args.iterations as usize,
        tilt_limit_rad: mission.limits.safety.pitch_rad,
        gain_ends: Some([least?, most?]),
        seed: mission.seed,
    })
}

/// Everything that the search depends on; the most iterations only end it.
fn identity(args: &TuneArgs, mission: &Mission) -> Vec<(&'static str, String)> {
    let mut identity = identity_of(mission);
    let start = format!("{} {:?}", mission.control.gains_name, mission.control.gains.as_longitudinal());
    let drops = format!("{DROPS} random, {} release cases", mission.case_parachutes().len());
    let searched = names().collect::<Vec<_>>().join(" ");
    identity.extend([("for", name_of(args.target)), ("start", start), ("particles", particles(args))]);
    let latency = format!("at least {LATENCY_S} s on PX4's clock");
    let range = "around the vehicle's rule, in PX4's";
    identity.extend([
        ("drops", drops),
        ("searched", searched),
        ("latency", latency),
        ("range", range.to_owned()),
    ]);
    if let Some(law) = args.px4_version {
        identity.push(("px4 version", law.since.to_string()));
    }
    identity
}

/// How far the search is, for the progress bar.
fn progress(search: &Px4Search, measured_by: &str) -> (usize, usize, String) {
    let (made, most) = search.iterations();
    let best =
        search.best().map_or_else(String::new, |(cost, _)| format!("best cost {cost:.4} (1: {measured_by})"));
    (made, most, best)
}

fn write(
    args: &TuneArgs,
    folder: &OutputFolder,
    mission: &Mission,
    result: &Px4Gains,
) -> Result<(), Failure> {
    let mut named = mission.clone();
    named.control.gains_name.clone_from(&result.name);
    let export = px4_model_export(
        &result.parameters,
        &result.law,
        result.purpose,
        mission.site.environment.gravity_m_s2,
        result.remarks(),
    );
    folder.write_text("gains.params", &params_file(&named, &export))?;
    let text = document(mission, result).text();
    folder.write_text("px4_gains.txt", &text)?;
    let mut options = vec![
        ("for", "px4".to_owned()),
        ("particles", particles(args)),
        ("iterations", args.iterations.to_string()),
        ("unseen", args.unseen.to_string()),
    ];
    options.extend(args.px4_version.map(|law| ("px4-version", law.since.to_string())));
    folder.write_manifest("tune", mission, &options)?;
    folder.print_result(args.mission.json, || gains_json(mission, result), || text)
}
