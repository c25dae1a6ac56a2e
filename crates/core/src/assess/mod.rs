//! How safe: what a flight cost, and whether it stayed within its limits.
//!
//! | file | holds | paper |
//! |---|---|---|
//! | [`outcome`] | what a flight came to: the table of quantities | |
//! | [`safety`] | J_TPF, the verdict on a drop | (51) |
//! | [`scenario`] | vehicle, site, air, target and limits of a study | |
//! | [`limits`] | what a flight is judged by | Table 1 |
//! | `steady` | when the mean of a velocity comes to stay at the target | |
//! | [`mod@judge`] | whether a flight was safe, and why not: the one place that says so | V |
//! | [`power`] | what a drop asks of its battery | |
//! | [`tracking`] | RMS distance of a flight from its plan | (45)-(46) |
//! | [`better`] | by which margin one flies better than another | |
//! | [`batch`] | both for many planar flights at once | |
//! | [`releases`] | random releases | (40)-(44), IV.B |
//! | [`coordinates`] | a trial as independent standard-normal coordinates | |
//! | [`drops`] | random drops from the canopy to the end | |
//! | [`envelope`] | how far from the nominal release a drop may begin and be safe | |
//! | [`free_fall`] | how well a fall is found from the accelerometer alone |
//! | [`logged_drop`] | a drop that a log has, as samples | |
//! | [`integrated_plan`] | J_TPF of a plan and its defects, integrated from node to node | (51) |
//! | [`grid_loss`] | what interpolating plans costs against solving for each release | |
//! | [`sobol`] | what decides an output: Sobol's indices | |
//! | [`study`] | controllers flown from many releases | V |
//! | [`statistics`], [`beta`] | mean, deviation, extremes, confidence intervals | V.A |
//! | [`blocks`] | the same of a campaign whose parts are flown apart | |
//! | [`rare`] | probabilities of rare failures, and the most likely one | |
//! | [`quantiles`] | histograms that add up, and exact quantiles | |
//! | [`chosen`] | bounds on what was chosen among several | |
//! | [`fidelity`] | means in a costly way to fly, by trials of a cheaper one | |
//! | [`trends`] | J_TPF by the release, and how far velocities lie apart | V.A |
//! | [`paper`] | what the paper prints of its study | Table 5, V.A |

pub mod batch;
#[cfg(target_arch = "x86_64")]
mod beside;
pub mod beta;
pub mod better;
pub mod blocks;
pub mod chosen;
pub mod coordinates;
pub mod drops;
pub mod envelope;
pub mod fidelity;
pub(crate) mod flights;
pub mod free_fall;
pub mod grid_loss;
pub mod integrated_plan;
pub mod judge;
pub mod limits;
pub mod logged_drop;
pub mod outcome;
pub mod paper;
pub mod power;
pub mod quantiles;
pub mod rare;
pub mod releases;
pub mod repeats;
pub mod safety;
pub mod scenario;
pub mod sobol;
pub mod statistics;
mod steady;
pub mod study;
pub mod tracking;
pub mod trends;
mod verdicts;
mod watched;

pub use batch::{BatchFlight, BatchMeasure, judge_flights};
pub use better::{LEAST_DIFFERENCE, clearly_less};
pub use blocks::{BLOCK_TRIALS, BlockError, BlockNode, BlockSummary, Tally};
pub use chosen::{ChosenAmong, quantile_rank};
pub use drops::RandomDrop;
pub use fidelity::{Agreement, ByTrial, MeanByRungs, MeanEstimate, conformal_margin};
pub use grid_loss::{GRID_LOSS_MOST, GridFlight, GridLoss, MISREAD_RATE_RAD_S, Spread};
pub use integrated_plan::{BETWEEN_NODES_MOST, IntegratedPlan, nodes_enough};
pub use judge::{Course, Objection};
pub use limits::{Limits, SAFE_BELOW, SteadyWithin, TouchLimits};
pub use outcome::{Outcome, Quantity};
pub use power::PowerUse;
pub use quantiles::{Histogram, QUANTILES, Quantile, Quantiles, Selection};
pub use releases::{RandomRelease, ReleaseDistribution};
pub use safety::{Peaks, Verdict, VerdictBuilder, judge, judge_trial, steady_within_m_s};
pub use scenario::Scenario;
pub use statistics::{CONFIDENCE, Share, Summary, rate_bound};
pub use study::{OneAtATime, SafetyStudy, StudyEntry, StudyReference, StudyStart, TraceInstant};
pub use tracking::TrackingError;
pub use trends::{ReleaseTrends, Side};
pub use verdicts::Verdicts;

pub use crate::sim::{SafetyLimits, StateCost};

#[cfg(test)]
mod safety_tests;
