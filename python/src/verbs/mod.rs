//! The verbs.
//!
//! | file | holds |
//! |---|---|
//! | [`plan`] | the optimal trajectory |
//! | [`drop`] | a whole drop by the reference autopilot, judged |
//! | [`assess`] | campaigns of random releases |
//! | [`tune`] | gains by search |
//! | [`names`] | which missions there are, the text of one, what its numbers amount to |

pub mod assess;
pub mod drop;
pub mod names;
pub mod plan;
pub mod tune;
