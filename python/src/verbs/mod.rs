//! The verbs.
//!
//! | file | holds |
//! |---|---|
//! | [`plan`] | the optimal trajectory |
//! | [`drop`] | a whole drop by the reference autopilot, judged |
//! | [`assess`] | campaigns of random releases |
//! | [`rare`] | how rare failures are, and what decides a drop |
//! | [`replan`] | drops along one plan and along renewed ones |
//! | [`tune`] | gains by search |
//! | [`design`] | plan and gains by one search |
//! | [`names`] | which missions there are, the text of one, what its numbers amount to |

pub mod assess;
pub mod design;
pub mod drop;
pub mod names;
pub mod plan;
pub mod rare;
pub mod replan;
pub mod tune;
