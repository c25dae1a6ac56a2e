//! The gains found beside others, on flights that no tuning saw.

use samara_core::control::Gains;
use samara_core::design::Unknown;
use samara_core::model::rigid_body::BodyState;
use samara_core::tune::gain_judge::MeasuredFlight;
use samara_core::tune::{Evaluation, GainJudge, Longitudinal, Objective};
use samara_mission::Mission;

use super::report::{Contender, Contest, UnseenFlights};
use super::{Tuning, TuningObjective};
use crate::designing::design_flights;
use crate::jobs::{Jobs, Round, Stage, Stopped};

/// Gains that are shown as a warning: the optimum of the paper's problem on the ideal plant.
const IDEAL: &str = "ideal_rms";
/// The name of the mission's own gains where theirs is taken.
const OWN: &str = "mission's own";
/// Flights that are flown without a look at whether to stop.
const PORTION: u64 = 64;

/// Tries the gains found, of this name, and those to compare them with, on so many flights each: `tuning`
/// is the judge of the search, `real` that of the same flights with real actuators.
///
/// # Errors
/// [`Stopped`] when the study is to end.
pub fn contest(
    jobs: &mut dyn Jobs,
    (mission, of, robust): (&Mission, &Tuning, bool),
    (tuning, real): (&GainJudge<'_>, &GainJudge<'_>),
    (name, found): (&str, &Longitudinal),
    unseen: u64,
) -> Result<Contest, Stopped> {
    let (sets, own) = named(mission, name, found);
    jobs.stage(&Stage {
        unit: "flights",
        jobs: sets.len() as u64 * (1 + 2 * unseen),
        hangs_on: &serde_json::json!({ "unseen": unseen, "gains": sets }).to_string(),
    })?;
    let objective = match of.objective.means {
        TuningObjective::Rms => Objective::Rms,
        TuningObjective::JTpf => Objective::JTpf,
        TuningObjective::Safety | TuningObjective::Pareto => {
            Objective::Safety { rms_bound: of.rms_bound(mission, real), penalty: of.penalty }
        }
    };
    let known: Vec<(Evaluation, Evaluation)> =
        jobs.fly("release cases", Round::of(sets.len() as u64, 1), &|some, stop| {
            let judged = some.map(|set| {
                let (_, k) = sets.get(set as usize).filter(|_| !stop())?;
                Some((tuning.evaluate(k), real.evaluate(k)))
            });
            judged.collect()
        })?;
    let judge = design_flights(mission);
    let mut flown = vec![UnseenFlights::default(); 2 * sets.len()];
    jobs.fold_sets(
        "unseen flights",
        (flown.len(), unseen),
        PORTION,
        &|set, some, stop| {
            let (_, k) = sets.get(set / 2).filter(|_| !stop())?;
            // In the air that the mission names, as campaigns fly the trial of this number.
            let unknown = Unknown { vehicle: set % 2 == 1, air: true };
            let trials: Vec<_> = some.map(|number| judge.draw(number, unknown)).collect();
            let judged = |((start, _), flight): (&(BodyState, _), &MeasuredFlight)| {
                (flight.evaluation, judge.is_safe(start, flight))
            };
            Some(trials.iter().zip(&real.measure_others(k, &trials)).map(judged).collect())
        },
        |set, (flight, safe): (Evaluation, bool)| flown[set].push(&flight, safe),
    )?;
    let mut flown = flown.into_iter();
    let contenders = sets.into_iter().zip(known).map(|((name, k), (tuning, cases))| Contender {
        name,
        k,
        tuning,
        cases,
        unseen: flown.next().unwrap_or_default(),
        varied: flown.next().unwrap_or_default(),
    });
    Ok(Contest { contenders: contenders.collect(), own, objective, robust })
}

/// Gains by name: beside the paper's study near-hover's and the paper's, and the warning; the mission's own,
/// the ones found; and the place of the mission's own.
fn named(mission: &Mission, name: &str, found: &Longitudinal) -> (Vec<(String, Longitudinal)>, usize) {
    let mut named = Vec::new();
    let mut shelf = mission.clone();
    let is_the_papers = mission.is_the_papers_study();
    if is_the_papers {
        named.push(("near_hover".to_owned(), Gains::near_hover().as_longitudinal()));
        named.push(("paper_pso".to_owned(), Gains::paper_pso().as_longitudinal()));
    }
    let beside = is_the_papers && shelf.gains_beside().iter().any(|name| name == IDEAL);
    if name != IDEAL && beside && shelf.use_gains(IDEAL).is_ok() {
        named.push((shelf.control.gains_name, shelf.control.gains.as_longitudinal()));
    }
    let (own_name, own_k) = (&mission.control.gains_name, mission.control.gains.as_longitudinal());
    let own = named.iter().position(|(_, k)| *k == own_k).unwrap_or_else(|| {
        let taken = own_name == name || named.iter().any(|(name, _)| name == own_name);
        named.push((if taken { OWN.to_owned() } else { own_name.clone() }, own_k));
        named.len() - 1
    });
    named.push((name.to_owned(), *found));
    (named, own)
}
