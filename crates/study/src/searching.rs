//! Searches as studies: each generation of candidates is a round of jobs, each judgement a row.

use samara_core::design::{FreshFlight, Judgement};
use samara_core::tune::px4::Measures;
use samara_core::tune::{CandidateSearch, Evaluation};

use crate::jobs::{Jobs, Round, Row, Stopped, row_of};

row_of!(Evaluation { rms, j_tpf, unrest });
row_of!(Judgement {
    j_tpf,
    mean,
    steady_share,
    worst,
    over_limit,
    unrest,
    most,
    energy_j,
    modulus,
    delay_s,
    flights
});
row_of!(FreshFlight { outcome, safe, within_limits, end_error_m_s });
row_of!(Measures { measured, velocity_rms_m_s, unsafe_share, steady_share });

/// Has a search's candidates judged until it is over. `how` says how well it goes; `judge` gives the
/// judgement on a candidate, by its place among those at hand, or `None` where there is nothing to judge it
/// by.
///
/// # Errors
/// [`Stopped`] when the search is to end, or has nothing to go on with.
pub fn search<S>(
    jobs: &mut dyn Jobs,
    search: &mut S,
    how: impl Fn(&S) -> String,
    judge: impl Fn(&S, usize, &S::Candidate) -> Option<S::Judgement> + Sync,
) -> Result<(), Stopped>
where
    S: CandidateSearch + Sync,
    S::Candidate: Sync,
    S::Judgement: Row,
{
    while let Some(candidates) = search.candidates() {
        let round = Round::of(candidates.len() as u64, 1);
        let searched = &*search;
        let judged = jobs.fly(&how(searched), round, &|some, stop| {
            some.map(|place| {
                let candidate = candidates.get(place as usize).filter(|_| !stop())?;
                judge(searched, place as usize, candidate)
            })
            .collect()
        })?;
        search.update(&judged);
    }
    Ok(())
}

/// How many candidates a search has at hand.
pub fn candidates<S: CandidateSearch>(search: &S) -> u64 {
    search.candidates().map_or(0, |candidates| candidates.len() as u64)
}
