//! Tuning: gains by search, on the flights that they shall be good at.
//!
//! | file | holds | paper |
//! |---|---|---|
//! | [`release_cases`] | states at t = 0: the mission's cases, a sampled swing | Table 3, (40)-(44) |
//! | [`gain_judge`] | what a set of gains costs: its flights | (45)-(46), (51) |
//! | [`unknowns`] | what the controller does not know of | |
//! | [`gain_space`] | ranges of the gains, around a rule for the vehicle's lag |
//! | [`objective`] | the costs of flights, and the number to be made small | (46) |
//! | [`swarm`] | particle swarm | IV.C |
//! | [`cma_es`] | evolution strategy that learns the shape of the valley | |
//! | [`search`] | an optimiser on an objective, with the best and the front of all that was tried | |
//! | [`range_ends`] | which numbers of a result stand at an end of their range | |
//! | [`px4`] | gains for PX4, on the model of its own law | |
//! | [`near_hover`](mod@near_hover) | Ziegler and Nichols on the vehicle's own loops | IV.D |
//!
//! Optimisers give candidates and take their costs. They own no threads, no clock and nothing to print;
//! random numbers come from ChaCha8, a stream for each particle, so that a search is its seed and the costs
//! it was given: a search that is given the same costs again is where it was.

pub mod cma_es;
pub mod gain_judge;
pub mod gain_space;
pub mod near_hover;

pub mod objective;
pub mod px4;
pub mod range_ends;
pub mod release_cases;
pub mod search;
pub mod swarm;
pub mod unknowns;

pub use cma_es::CmaEs;
pub use gain_judge::GainJudge;
pub use gain_space::GainSpace;
pub use objective::{Evaluation, Objective};
pub use range_ends::{RangeEnds, SearchedNumber};
pub use release_cases::ReleaseCase;
pub use search::{Method, Search, SearchSettings};
pub use swarm::ParticleSwarm;

/// The seven longitudinal gains in Table 4's order, as [`crate::control::Gains::longitudinal`] takes them.
pub type Longitudinal = [f64; 7];

/// An optimiser in `N` dimensions: it gives candidates and takes their costs. A cost that is not a number
/// counts as infinite.
pub trait Optimiser<const N: usize> {
    /// The candidates to be judged next; the same until [`Self::update`] is called.
    fn candidates(&self) -> &[[f64; N]];

    /// Takes the costs of the candidates, in their order, and makes new ones.
    fn update(&mut self, costs: &[f64]);

    /// A candidate that costs more than this might as well cost infinitely much: what costs it exactly makes
    /// no difference.
    fn to_beat(&self, _candidate: usize) -> f64 {
        f64::INFINITY
    }

    /// Whether more of it is of no use.
    fn has_converged(&self) -> bool;
}

/// A search under way: it gives candidates and takes their judgements. Given the same again it is where it
/// was.
pub trait CandidateSearch {
    /// Candidate to be judged.
    type Candidate;
    /// Judgement of a candidate.
    type Judgement;

    /// The candidates to be judged next; `None` when the search is over.
    fn candidates(&self) -> Option<&[Self::Candidate]>;

    /// Takes the judgements of the candidates, in their order, and makes new ones.
    fn update(&mut self, judgements: &[Self::Judgement]);
}

/// Gains that differ by no more than this part of each other are the same: a search that goes through
/// logarithms and roots comes back to where it began but for the last digits.
const SAME_GAIN: f64 = 1e-9;

/// Whether two numbers of a search are the same but for what arithmetic leaves.
pub fn is_same_number(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_GAIN * a.abs().max(b.abs())
}

/// Whether two sets of gains are the same but for what arithmetic leaves.
pub fn are_same_gains(a: &Longitudinal, b: &Longitudinal) -> bool {
    a.iter().zip(b).all(|(a, b)| is_same_number(*a, *b))
}

/// Cost as an optimiser takes it: infinite when it is not a number.
fn usable(cost: f64) -> f64 {
    if cost.is_nan() { f64::INFINITY } else { cost }
}

#[cfg(test)]
mod optimiser_tests;
