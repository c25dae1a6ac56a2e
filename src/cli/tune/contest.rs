//! The gains found beside others, on flights that no tuning saw.

use std::sync::atomic::{AtomicBool, Ordering};

use super::args::{ObjectiveArg, TuneArgs};
use super::settings::tuning;
use crate::cli::answer::{BadInput as _, Failure};
use samara::config::Mission;
use samara::control::Gains;
use samara::design::Unknown;
use samara::host::Threads;
use samara::model::rigid_body::BodyState;
use samara::sim::PlantKind;
use samara::study::designing::design_flights;
use samara::study::tuning::report::{Contender, Contest, UnseenFlights};
use samara::trajectory::Trajectory;
use samara::tune::gain_judge::{MeasuredFlight, Setting};
use samara::tune::{Evaluation, GainJudge, Longitudinal, Objective};

/// Gains that are shown as a warning: the optimum of the paper's problem on the ideal plant.
const IDEAL: &str = "ideal_rms";
/// The name of the mission's own gains where theirs is taken.
const OWN: &str = "mission's own";
/// Unseen flights between two looks at Ctrl-C.
const PORTION: usize = 64;

/// Tries the gains found and those to compare them with. `None` when Ctrl-C, now or before, put an end to it.
pub fn contest(
    args: &TuneArgs,
    (mission, plan): (&Mission, &Trajectory),
    tuning: &GainJudge<'_>,
    found: &Longitudinal,
    (threads, stop): (&Threads, &AtomicBool),
) -> Result<Option<Contest>, Failure> {
    // Real actuators, whatever the tuning had.
    let asked = self::tuning(args);
    let real = Setting { plant: PlantKind::Actuator, ..asked.setting(mission, plan) };
    let cases = GainJudge::new(real).bad_input()?.with_cases(&mission.study.cases);
    let objective = match args.objective {
        ObjectiveArg::Rms => Objective::Rms,
        ObjectiveArg::JTpf => Objective::JTpf,
        ObjectiveArg::Safety | ObjectiveArg::Pareto => {
            Objective::Safety { rms_bound: asked.rms_bound(mission, &cases), penalty: args.penalty }
        }
    };
    let judge = design_flights(mission);
    // In the air that the mission names, as campaigns fly the trial of this number.
    let trial = |vary: bool, number: u64| judge.draw(number, Unknown { vehicle: vary, air: true });
    let unseen = u64::from(args.unseen);
    let portions: Vec<u64> = (0..unseen).step_by(PORTION).collect();
    let flown_by = |k: &Longitudinal, vary: bool| -> Option<UnseenFlights> {
        let fly = |&first: &u64| {
            let trials: Vec<_> = (first..unseen).take(PORTION).map(|number| trial(vary, number)).collect();
            let judged = |((start, _), flight): (&(BodyState, _), &MeasuredFlight)| {
                (flight.evaluation, judge.is_safe(start, flight))
            };
            let flown = (!stop.load(Ordering::Relaxed)).then(|| cases.measure_others(k, &trials));
            flown.map(|flown| trials.iter().zip(&flown).map(judged).collect())
        };
        let flown: Option<Vec<Vec<(Evaluation, bool)>>> = threads.each(&portions, fly).into_iter().collect();
        flown.map(|f| UnseenFlights::of(&f.concat()))
    };
    let contender = |(name, k): (String, Longitudinal)| {
        let (unseen, varied) = (flown_by(&k, false)?, flown_by(&k, true)?);
        Some(Contender { name, k, tuning: tuning.evaluate(&k), cases: cases.evaluate(&k), unseen, varied })
    };
    let (sets, own) = named(args, mission, found);
    let contenders: Option<Vec<Contender>> = sets.into_iter().map(contender).collect();
    Ok(contenders.map(|contenders| Contest { contenders, own, objective, robust: args.robust }))
}

/// Gains by name: beside the paper's study near-hover's and the paper's, and the warning; the mission's own,
/// the ones found; and the place of the mission's own.
fn named(args: &TuneArgs, mission: &Mission, found: &Longitudinal) -> (Vec<(String, Longitudinal)>, usize) {
    let mut named = Vec::new();
    let mut shelf = mission.clone();
    let is_the_papers = mission.is_the_papers_study();
    if is_the_papers {
        named.push(("near_hover".to_owned(), Gains::near_hover().as_longitudinal()));
        named.push(("paper_pso".to_owned(), Gains::paper_pso().as_longitudinal()));
    }
    let beside = is_the_papers && shelf.gains_beside().iter().any(|name| name == IDEAL);
    if args.name != IDEAL && beside && shelf.use_gains(IDEAL).is_ok() {
        named.push((shelf.control.gains_name, shelf.control.gains.as_longitudinal()));
    }
    let (own_name, own_k) = (&mission.control.gains_name, mission.control.gains.as_longitudinal());
    let own = named.iter().position(|(_, k)| *k == own_k).unwrap_or_else(|| {
        let taken = *own_name == args.name || named.iter().any(|(name, _)| name == own_name);
        named.push((if taken { OWN.to_owned() } else { own_name.clone() }, own_k));
        named.len() - 1
    });
    named.push((args.name.clone(), *found));
    (named, own)
}
