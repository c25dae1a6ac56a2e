//! Other values in, plan, flight and verdict out.

use std::ops::ControlFlow;

use serde::Serialize;

use super::Stop;
use super::viewed::{Refused, Viewed, with_causes};
use samara_core::assess::{Course, Verdict, judge};
use samara_core::design::{LOOPS, WorstLoop};
use samara_core::plan::{Plan, SolverOptions, Status};
use samara_core::sim::{self, Flight, FlightRecord, Sample};
use samara_host::Threads;
use samara_mission::{Mission, Override};
use samara_report::hint::Hint;
use samara_report::json::object;
use samara_report::replay::view::{drop_data, drop_words};
use samara_report::{DropRun, FlownDrop, ShownDrop, judge_drop, plan_text};
use samara_study::checking::{CheckedPlan, LATENCY_MOST_S, checked_by};
use samara_study::designing::{LOOP_STATES_MOST, joined, least_margins, own_loops_in};
use samara_study::effects::EffectFlights;
use samara_study::hinted;

/// A mission with its plan.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The mission, with the values that were asked for.
    pub mission: Mission,
    /// The mission's plan, which converged.
    pub plan: Plan,
}

impl Planned {
    /// Plans the mission with other values.
    ///
    /// # Errors
    /// [`Refused`]: a value is refused, there is no plan, or `stop` said so.
    pub fn new(viewed: &Viewed, changes: &[Override], stop: Stop<'_>) -> Result<Self, Refused> {
        let mission = viewed.with(changes)?;
        let go_on = || if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let plan = mission.solve(&SolverOptions::default(), &mut |_| go_on());
        let plan = plan.map_err(|unplanned| Refused::Unflown(with_causes(&unplanned)))?;
        match plan.status {
            Status::Converged => Ok(Self { mission, plan }),
            _ if stop() => Err(Refused::Overtaken),
            _ => {
                let hint = hinted::of_plan(&mission, &plan).map_or_else(String::new, |hint| hint.sentence());
                let why = plan_text(&mission, &plan, None);
                Err(Refused::Unflown(format!("no plan to fly: {}. {hint}", why.trim())))
            }
        }
    }

    /// Flies the mission's own drop, of which nothing is drawn, from the hang to its end in the mission's own
    /// air - by its own gains, at 250 Hz, on the true state - and looks at its loops meanwhile.
    ///
    /// # Errors
    /// [`Refused`]: the vehicle cannot be controlled, or `stop` said so.
    pub fn fly(&self, threads: &Threads, stop: Stop<'_>) -> Result<Flown<'_>, Refused> {
        enum Part<'a> {
            Drop(Box<Result<Flown<'a>, Refused>>),
            Loops(Vec<WorstLoop>),
        }
        let (mission, plan) = (&self.mission, Some(&self.plan.trajectory));
        // Commands that come too late have loops that take long.
        let states = if mission.vehicle.latency_s > LATENCY_MOST_S { 0 } else { LOOP_STATES_MOST };
        let parts: Vec<Option<usize>> = std::iter::once(None).chain((0..states).map(Some)).collect();
        let parts = threads.each(&parts, |part| match *part {
            None => Part::Drop(Box::new(self.fly_drop(stop))),
            Some(_) if stop() => Part::Loops(Vec::new()),
            Some(state) => Part::Loops(own_loops_in(mission, plan, state)),
        });
        let (mut flown, mut loops) = (Err(Refused::Overtaken), Vec::new());
        for part in parts {
            match part {
                Part::Drop(drop) => flown = *drop,
                Part::Loops(others) if loops.is_empty() => loops = others,
                Part::Loops(others) if others.is_empty() => {}
                Part::Loops(others) => loops = joined(loops, others),
            }
        }
        if stop() {
            return Err(Refused::Overtaken);
        }
        let (flown, least) = (flown?, least_margins(mission));
        let objections = flown.run.objections(flown.verdict.as_ref());
        let look =
            || checked_by(mission, CheckedPlan::Solved(Box::new(self.plan.clone())), loops.clone(), least);
        let hint = objections.first().map(|first| hinted::of_no(first.no(), mission, look));
        let loops = loops.into_iter().map(|of| (of, of.keeps(&least))).collect();
        Ok(Flown { loops, hint, ..flown })
    }

    fn fly_drop(&self, stop: Stop<'_>) -> Result<Flown<'_>, Refused> {
        let Self { mission, plan } = self;
        let flights = EffectFlights::new(mission, &mission.effects(), &plan.trajectory);
        let flights = flights.map_err(|why| Refused::Unflown(why.to_string()))?;
        let Flight { mut simulation, mut controller, plan: flight } = flights.nominal();
        let mut samples = Vec::with_capacity(flight.steps() as usize + 1);
        let flown = sim::fly(&mut simulation, &mut *controller, &flight, &mut |sample| {
            samples.push(*sample);
            if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        if flown.is_break() {
            return Err(Refused::Overtaken);
        }
        let (log, record) = (&samples, &FlightRecord::of_motors(&simulation));
        let along = Some(&plan.trajectory);
        let (verdict, run) =
            judge_drop(mission, &FlownDrop { log, record, plan: along, by: None, trouble: None });
        Ok(Flown { planned: self, samples, verdict, run, loops: Vec::new(), hint: None })
    }
}

/// A drop that was flown and judged.
#[derive(Clone, Debug)]
pub struct Flown<'a> {
    /// What was to be flown.
    pub planned: &'a Planned,
    /// The flight log.
    pub samples: Vec<Sample>,
    /// The verdict; `None` where nothing was released.
    pub verdict: Option<Verdict>,
    /// What else is known of the flight.
    pub run: DropRun,
    /// The loops of the mission's gains along the plan, each where it keeps least to instability, and whether
    /// that is enough; none of commands that come too late.
    pub loops: Vec<(WorstLoop, bool)>,
    /// What causes it that the drop was not safe; `None` where it was.
    pub hint: Option<Hint>,
}

impl Flown<'_> {
    /// Why the drop was not safe, in a line; `None` where it was.
    pub fn cause(&self) -> Option<String> {
        judge::words(&self.run.objections(self.verdict.as_ref()))
    }

    fn shown(&self) -> ShownDrop<'_> {
        let mission = &self.planned.mission;
        ShownDrop {
            mission,
            title: &mission.name,
            gains: &mission.control.gains_name,
            samples: &self.samples,
            plan: Some(&self.planned.plan.trajectory),
            verdict: self.verdict.as_ref(),
            run: &self.run,
        }
    }
}

/// A loop's margins, as the page shows them.
fn loop_shown((of, passed): &(WorstLoop, bool)) -> impl Serialize {
    let stable = of.unstable.is_none();
    object! {
        name: LOOPS.get(of.index).map_or("", |(name, _)| name),
        modulus: if stable { of.modulus.0 } else { 0.0 },
        delay_margin_s: of.delay_s.filter(|_| stable).map(|(delay_s, _)| delay_s),
        passed: *passed,
    }
}

/// What the page is answered: the object of the number that it asked by, after so many milliseconds.
pub fn answer(flown: &Flown<'_>, command: &str, number: u64, took_ms: f64) -> String {
    let (shown, cause) = (flown.shown(), flown.cause());
    let outcome = flown.verdict.as_ref().map(|verdict| &verdict.outcome);
    let rest = object! {
        words: drop_words(&shown),
        passed: cause.is_none(),
        verdict: if cause.is_none() { "SAFE" } else { "NOT SAFE" },
        cause: cause,
        hint: flown.hint.as_ref().map(Hint::sentence),
        cost: outcome.map(|outcome| outcome.j_tpf),
        steady_s: outcome.and_then(|outcome| outcome.steady_after_s),
        loops: flown.loops.iter().map(loop_shown).collect::<Vec<_>>(),
        command: command,
    };
    // Structs of strings, numbers and lists of them always serialise. The drop is JSON already.
    let rest = serde_json::to_string(&rest).unwrap_or_default();
    let rest = rest.strip_prefix('{').unwrap_or_default();
    format!("{{\"number\":{number},\"took_ms\":{took_ms:.1},\"drop\":{},{rest}", drop_data(&shown))
}

/// Why a drop of a campaign counts as failed, in a word or a few; `None`: it does not.
pub(crate) fn short_cause(verdict: Option<&Verdict>) -> Option<String> {
    let first = judge(verdict, &Course::WHOLE).into_iter().next()?;
    let limit = first.limits_passed().first().map(|name| name.replace('_', " "));
    Some(limit.unwrap_or_else(|| first.to_string()))
}
