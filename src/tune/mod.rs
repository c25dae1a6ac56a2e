//! Tuning: the releases that gains are tuned on.

pub mod release_cases;
