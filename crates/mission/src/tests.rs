//! The files that are shipped, and copies of them that are spoilt.

mod built_in;
mod choices;
mod drafts;
mod foreign;
mod missions;
mod overrides;
mod random;
mod refusals;
mod schemas;
mod spoil;
mod study_identity;
mod trajectories;
mod uncertain;
mod vehicles;

use super::*;
