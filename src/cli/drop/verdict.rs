//! The verdict of a flight log, and what is told of it: the end of `samara drop`, of `samara sim` and of a study's drops.

use crate::cli::narrative::Narrator;
use crate::cli::outcome::{Answer, Failure};
use crate::cli::output::OutputFolder;
use samara::assess::{Verdict, VerdictBuilder};
use samara::config::Mission;
use samara::link::{FlightEvent, FlightRecord, seconds};
use samara::report::{DropEvent, DropRun, verdict_text};
use samara::sim::Sample;

/// A log whose last row is closer to the mission's end than this [s] is complete.
const STEP_AT_MOST_S: f64 = 0.02;

/// The verdict of a flight log along a plan that ends at `plan_end_s` [s]; `None` when the vehicle was never released.
pub fn judge(mission: &Mission, log: &[Sample], plan_end_s: f64) -> Option<Verdict> {
    let mut verdict = VerdictBuilder::new(mission.limits.safety, mission.target_v_ned)
        .steady_within(mission.limits.steady_within_m_s)
        .to_plans_end(plan_end_s);
    if mission.site.ground.is_some() {
        verdict = verdict.judging_impacts(mission.limits.impact_m_s);
    }
    log.iter().for_each(|sample| verdict.observe(sample));
    verdict.finish()
}

/// Yes: judged, within the limits, to the end and steady there, by the plan alone.
pub fn answer_of(verdict: Option<&Verdict>, run: &DropRun) -> Answer {
    let safe = verdict.is_some_and(|v| v.limits_passed.is_empty());
    if safe && run.reason(verdict).is_none() && !run.failsafe { Answer::Yes } else { Answer::No }
}

/// Whether the mission ended before a plan that ends at `plan_end_s` [s] of powered flight.
pub fn cuts_the_plan(log: &[Sample], plan_end_s: f64) -> bool {
    let flown_s = log.last().and_then(|sample| sample.t_powered_s).unwrap_or(f64::NEG_INFINITY);
    flown_s + STEP_AT_MOST_S < plan_end_s
}

/// Says so when the mission ended before the plan.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn tell_if_cut(narrator: &Narrator, mission: &Mission, run: &DropRun) -> Result<(), Failure> {
    if !run.completed || !run.plan_cut {
        return Ok(());
    }
    let duration_s = mission.duration_s;
    narrator.say(&format!(
        "the mission's duration_s, {duration_s} s, ended before the plan did: whether it becomes steady is not known\n"
    ))
}

/// What the drop's object tells of a flight's record.
pub fn drop_run(record: &FlightRecord) -> DropRun {
    let event = |e: &FlightEvent| DropEvent { t_s: seconds(e.at), text: e.text.clone() };
    let events = record.events.iter().map(event).collect();
    DropRun { failsafe: record.failsafe, events, ..DropRun::default() }
}

/// Says so when a flight has been stopped before the mission's end; whether it has been.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn tell_if_stopped(narrator: &Narrator, mission: &Mission, log: &[Sample]) -> Result<bool, Failure> {
    let flown_s = log.last().map_or(0.0, |sample| sample.t_s);
    let stopped = flown_s + STEP_AT_MOST_S < mission.duration_s;
    if stopped {
        let duration_s = mission.duration_s;
        narrator.say(&format!(
            "stopped at {flown_s:.3} s of {duration_s} s: files and verdict are of what was flown\n"
        ))?;
    }
    Ok(stopped)
}

/// Says so when it was not only the plan that was flown.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn tell_failsafe(narrator: &Narrator, record: &FlightRecord) -> Result<(), Failure> {
    if record.failsafe {
        narrator
            .say("a failsafe of the autopilot flew part of the manoeuvre: this is no drop by the plan\n")?;
    }
    Ok(())
}

/// Says that the vehicle was never released, and where to look for the reason.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn never_released(narrator: &Narrator, mission: &Mission, stopped: bool) -> Result<(), Failure> {
    let duration_s = mission.duration_s;
    narrator.say(&if stopped {
        "the vehicle had not been released\n".to_owned()
    } else {
        format!(
            "the vehicle was never released within the mission's {duration_s} s: check the release trigger, hang_s and what the \
             vehicle said above\n"
        )
    })
}

/// Prints when steady flight was reached, the verdict and where the files are.
///
/// # Errors
/// [`Failure::Internal`] when stdout fails.
pub fn tell_verdict(
    narrator: &Narrator,
    mission: &Mission,
    verdict: &Verdict,
    log: &[Sample],
    run: &DropRun,
    folder: &OutputFolder,
) -> Result<(), Failure> {
    let powered_from_s = log.last().and_then(|sample| Some(sample.t_s - sample.t_powered_s?));
    narrator.steady(verdict, mission, powered_from_s)?;
    let text = verdict_text(verdict, &mission.limits.safety, run.misses_steady_flight(verdict));
    narrator.say(&format!("\n{text}\nresults in {}\n", folder.path().display()))
}
