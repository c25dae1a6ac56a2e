//! Designs on flights that the search did not have.

use std::ops::Range;

use rayon::prelude::*;

use samara::design::{
    CONDITIONS, Design, DesignBounds, DesignJudge, DesignObjective, FINALISTS_FROM, FreshFlight,
    FreshResults, TriedDesign, Unknown, fly_fresh,
};
use samara::report::design::{DesignRun, Finalist};

/// Flights between two looks at Ctrl-C.
const PORTION: u64 = 64;
/// Most flights that each finalist is judged by.
const FINALIST_FLIGHTS: u64 = 2000;

/// The finalists, each on the same flights with everything unknown and turbulence, no more than the last
/// judgement has in a condition; none when Ctrl-C put an end to it.
pub fn judge_finalists(
    judge: &DesignJudge<'_>,
    finalists: &[TriedDesign],
    unseen: u64,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Vec<Finalist> {
    let numbers = FINALISTS_FROM..FINALISTS_FROM + FINALIST_FLIGHTS.min(unseen);
    let (_, unknown) = CONDITIONS[CONDITIONS.len() - 1];
    let judged = finalists.iter().map(|tried| {
        let flown = fly(judge, &tried.design, numbers.clone(), unknown, go_on)?;
        Some(Finalist { tried: *tried, results: FreshResults::of(&flown) })
    });
    judged.collect::<Option<Vec<_>>>().unwrap_or_default()
}

/// The best finalist by the objective, of those that keep the bounds before others, and of the fewest unsafe
/// flights; the first of equals.
pub fn choose(run: &DesignRun, bounds: &DesignBounds) -> Option<TriedDesign> {
    let number = |finalist: &Finalist| match run.objective {
        DesignObjective::Quantile(p) => finalist.results.quantile(p),
        DesignObjective::Worst => finalist.results.j_tpf.max(),
    };
    let order = |a: &&Finalist, b: &&Finalist| {
        let rank = |finalist: &Finalist| {
            (!finalist.tried.judgement.is_allowed(bounds), finalist.results.safe.misses())
        };
        rank(a).cmp(&rank(b)).then(number(a).total_cmp(&number(b)))
    };
    run.finalists.iter().min_by(order).map(|finalist| finalist.tried)
}

/// A design in each condition, on as many flights as campaigns have that are numbered from 0; `None` when it
/// has no plan or Ctrl-C put an end to it.
pub fn judge_fresh(
    judge: &DesignJudge<'_>,
    design: &Design,
    flights: u64,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<FreshResults>> {
    let of = |(_, unknown): &(&str, Unknown)| {
        Some(FreshResults::of(&fly(judge, design, 0..flights, *unknown, go_on)?))
    };
    CONDITIONS.iter().map(of).collect()
}

fn fly(
    judge: &DesignJudge<'_>,
    design: &Design,
    numbers: Range<u64>,
    unknown: Unknown,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<FreshFlight>> {
    let plan = judge.plan(&design.plan)?;
    let pilot = judge.flights().pilot(&plan.trajectory, design.feed_forward).ok()?;
    let portions: Vec<u64> = numbers.clone().step_by(PORTION as usize).collect();
    let flown: Option<Vec<Vec<FreshFlight>>> = portions
        .par_iter()
        .with_max_len(1)
        .map(|&first| {
            let portion = first..(first + PORTION).min(numbers.end);
            go_on().then(|| fly_fresh(judge.flights(), &pilot, &design.gains, portion, unknown))
        })
        .collect();
    flown.map(|portions| portions.concat())
}
