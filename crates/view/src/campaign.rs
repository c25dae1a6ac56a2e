//! Whole drops of a changed mission from its random numbers, batch after batch.

use std::ops::Range;

use super::Stop;
use super::flown::{Planned, short_cause};
use super::viewed::Refused;
use samara_core::assess::{Share, Verdict};
use samara_core::sim::ABREAST;
use samara_host::Threads;
use samara_report::json::object;
use samara_study::effects::EffectFlights;

/// Drops of the first batch; each that follows has as many as are there, up to [`BATCH_MOST`].
pub const BATCH_FIRST: u64 = 64;
/// Most drops of a batch.
pub const BATCH_MOST: u64 = 512;
/// Most drops of a campaign.
pub const DROPS_MOST: u64 = 10_000;

/// Flies drops 0 to `drops` of a planned mission, in its own air, on many threads, and gives each batch to
/// `take` as a line of JSON, the last of which says how many failed. Ends before when `stop` says so, within
/// a few drops, or `take` says no.
///
/// # Errors
/// [`Refused`]: the vehicle cannot be controlled, or it was stopped.
pub fn fly_drops(
    planned: &Planned,
    drops: u64,
    threads: &Threads,
    stop: Stop<'_>,
    take: &mut dyn FnMut(String) -> bool,
) -> Result<(), Refused> {
    let Planned { mission, plan } = planned;
    let flights = EffectFlights::new(mission, &mission.effects(), &plan.trajectory);
    let flights = flights.map_err(|why| Refused::Unflown(why.to_string()))?;
    let (mut flown, mut failed) = (0, 0);
    while flown < drops.min(DROPS_MOST) {
        let batch = flown..drops.min(DROPS_MOST).min(flown + flown.clamp(BATCH_FIRST, BATCH_MOST));
        let groups: Vec<Range<u64>> =
            batch.clone().step_by(ABREAST).map(|from| from..batch.end.min(from + ABREAST as u64)).collect();
        let groups = threads.each(&groups, |group| (!stop()).then(|| flights.verdicts(group.clone())));
        let groups: Option<Vec<Vec<Option<Verdict>>>> = groups.into_iter().collect();
        let verdicts = groups.ok_or(Refused::Overtaken)?.concat();
        let causes: Vec<Option<String>> =
            verdicts.iter().map(|verdict| short_cause(verdict.as_ref())).collect();
        let outcomes = || verdicts.iter().map(|verdict| verdict.as_ref().map(|verdict| &verdict.outcome));
        failed += causes.iter().flatten().count() as u64;
        let line = object! {
            from: flown,
            cost: outcomes().map(|outcome| Some(outcome?.j_tpf)).collect::<Vec<_>>(),
            steady_s: outcomes().map(|outcome| outcome?.steady_after_s).collect::<Vec<_>>(),
            passed: causes.iter().map(Option::is_none).collect::<Vec<_>>(),
            cause: causes,
            interval95: <[f64; 2]>::from(Share::of(failed, batch.end).interval()),
        };
        if !take(serde_json::to_string(&line).unwrap_or_default()) {
            return Err(Refused::Overtaken);
        }
        flown = batch.end;
    }
    let (low, high) = Share::of(failed, flown).interval();
    let last = object! { done: true, flown: flown, failed: failed, interval95: [low, high] };
    take(serde_json::to_string(&last).unwrap_or_default());
    Ok(())
}
