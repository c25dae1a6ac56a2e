//! Studies of a mission: what flies it without a wire, and what judges its designs and gains. Reports
//! and files stand apart from it: they fly nothing.
//!
//! | file | holds |
//! |---|---|
//! | [`jobs`] | jobs out, rows in: who flies what a study asks for |
//! | [`controller`] | the mission's controller, made in this one place |
//! | [`checking`] | what a mission amounts to, with its plan and its loops |
//! | [`own`] | campaigns of the mission's own gains, release cases, trials by their coordinates |
//! | [`effects`] | drops with and without each effect |
//! | [`replan`] | drops along one plan and along renewed ones |
//! | [`envelope`] | releases about a point of the safe-release envelope |
//! | [`envelope_search`] | the edges of the envelope, ray by ray |
//! | [`free_fall`] | how well the fall is found by the accelerometer alone |
//! | [`plan_grid`] | the releases that a grid of plans spans, and what interpolated plans cost |
//! | [`first_gains`] | gains that fly a drafted mission |
//! | [`uncertain`] | what is uncertain of a mission |
//! | [`tuning`] | how gains are tuned |
//! | [`designing`] | how plan and gains are designed together |

pub mod checking;
pub mod controller;
pub mod designing;
pub mod effects;
pub mod envelope;
pub mod envelope_search;
pub mod first_gains;
pub mod free_fall;
pub mod jobs;
pub mod own;
pub mod plan_grid;
pub mod replan;
pub mod tuning;
pub mod uncertain;
