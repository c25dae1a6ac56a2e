//! The planner: against an independent implementation's optima, closed forms, differences and hard problems.
#![cfg(feature = "files")]

mod between_nodes;
mod convergence;
mod demand_derivatives;
mod demands;
mod derivatives;
mod limits;
mod problems;
mod reference;
mod robustness;
