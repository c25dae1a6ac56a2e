//! The verbs.
//!
//! | file | holds |
//! |---|---|
//! | [`plan`] | the optimal trajectory |
//! | [`drop`] | a whole drop by the reference autopilot, judged |
//! | [`assess`] | campaigns of random releases |
//! | [`study`] | studies of any kind |
//! | [`tune`] | gains by search |
//! | [`design`] | plan and gains by one search |
//! | [`judge`] | what judges gains in a search |
//! | [`names`] | which missions there are, what the numbers of one amount to |

pub mod assess;
pub mod design;
pub mod drop;
pub mod judge;
pub mod names;
pub mod plan;
pub mod study;
pub mod tune;
