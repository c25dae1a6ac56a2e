//! Starting points of the solver: a straight line, a flown trajectory, or an earlier plan moved on in time.

use std::any::Any;

use nalgebra::SVector;

use super::dynamics::{BODY_STATES, Dynamics as _};
use super::extended::PlannedVehicle;
use super::problem::{Nodes, Problem};
use super::slacks::PathDuals;
use super::solver::{Iterate, StartFrom};
use crate::trajectory::Trajectory;

/// The starting point of the solver, in the terms of a vehicle.
#[derive(Clone, Debug)]
pub enum Guess<'a> {
    /// A straight line from the initial state to x_ss over 8 s, thrusts ramped to 0.8 of the hover thrust.
    StraightLine,
    /// A flown trajectory, sampled at the nodes; its thrusts are clipped to the bounds.
    Flown(&'a Trajectory),
    /// An earlier plan, moved on by whole nodes: primal and dual variables are kept
    /// ([`Plan::moved_on`](super::vehicle::Plan::moved_on)).
    Warm {
        /// The solver's variables of the earlier plan.
        iterate: &'a AnyIterate,
        /// Number of nodes by which time has moved on since.
        shift: usize,
    },
    /// The rest of an earlier plan, on nodes that lie closer, up to the same end: primal and dual variables
    /// are taken between the old nodes ([`Plan::rest`](super::vehicle::Plan::rest)).
    Rest {
        /// The solver's variables of the earlier plan.
        iterate: &'a AnyIterate,
        /// Share of the earlier plan's horizon that has passed, from 0 to below 1.
        passed: f64,
    },
}

/// The solver's variables of a plan, kept for a warm start: an [`Iterate`] for the number of rotors that the
/// plan was made for.
pub type AnyIterate = dyn Any + Send + Sync;

/// The starting point, in the transcribed problem's terms, that a guess stands for. `hover_n` is the thrust
/// of a rotor in hover [N].
pub(super) fn start_from<D: PlannedVehicle<NX, NU>, const NX: usize, const NU: usize>(
    nlp: &Problem<D, NX, NU>,
    guess: &Guess<'_>,
    hover_n: f64,
) -> StartFrom<NX, NU> {
    let with_body = |body: Vec<SVector<f64, BODY_STATES>>, u: Vec<SVector<f64, NU>>| {
        StartFrom::Guess(Nodes { x: D::states(body, &nlp.x_initial, nlp.dt_s), u })
    };
    let straight = || {
        let (body, u) = straight_line(nlp, hover_n);
        with_body(body, u)
    };
    match guess {
        Guess::StraightLine => straight(),
        Guess::Flown(flight) => with_body(
            (0..=nlp.intervals).map(|k| flown_state(flight, k as f64 * nlp.dt_s)).collect(),
            (0..=nlp.intervals)
                .map(|k| {
                    let thrust = flight.thrust_n(k as f64 * nlp.dt_s);
                    SVector::from_fn(|i, _| thrust[i].clamp(0.0, nlp.bounds.u_max[i]))
                })
                .collect(),
        ),
        Guess::Warm { iterate, shift } => match iterate.downcast_ref::<Iterate<NX, NU>>() {
            Some(iterate) if iterate.nodes.fits(nlp.intervals) => {
                let mut moved = shifted(iterate, *shift);
                if *shift > 0 {
                    let body = moved.nodes.x.iter().map(D::body_state).collect();
                    let kept = first_of(&nlp.x_initial, &moved.nodes.x[0], &nlp.x_initial_free);
                    moved.nodes.x = D::states(body, &kept, nlp.dt_s);
                }
                StartFrom::Warm(moved)
            }
            _ => straight(),
        },
        Guess::Rest { iterate, passed } => match iterate.downcast_ref::<Iterate<NX, NU>>() {
            Some(iterate) if iterate.nodes.fits(nlp.intervals) && (0.0..1.0).contains(passed) => {
                let mut rest = rest_of(iterate, *passed);
                let body = rest_of_states(nlp, iterate, *passed);
                let kept = first_of(&nlp.x_initial, &rest.nodes.x[0], &nlp.x_initial_free);
                rest.nodes.x = D::states(body, &kept, nlp.dt_s);
                StartFrom::Warm(rest)
            }
            _ => straight(),
        },
    }
}

/// A place between items of a list: the index of the item before it, and the share of the way to the next.
fn between(at: f64, last: usize) -> (usize, f64) {
    let at = at.clamp(0.0, last as f64);
    let i = (at as usize).min(last.saturating_sub(1));
    (i, at - i as f64)
}

/// States of the body on the nodes of the rest of a plan, on the cubics (36) through its own nodes.
fn rest_of_states<D: PlannedVehicle<NX, NU>, const NX: usize, const NU: usize>(
    nlp: &Problem<D, NX, NU>,
    iterate: &Iterate<NX, NU>,
    passed: f64,
) -> Vec<SVector<f64, BODY_STATES>> {
    let (n, nodes) = (nlp.intervals, &iterate.nodes);
    let h = nlp.dt_s / (1.0 - passed);
    let body: Vec<_> = nodes.x.iter().map(D::body_state).collect();
    let slope: Vec<_> = body.iter().zip(&nodes.u).map(|(x, u)| nlp.dynamics.body().value(x, u) * h).collect();
    (0..=n)
        .map(|k| {
            let (i, s) = between(passed * n as f64 + (1.0 - passed) * k as f64, n);
            let (far, near) = (s * s * (3.0 - 2.0 * s), s * (1.0 - s));
            body[i] + (body[i + 1] - body[i]) * far + (slope[i] * (1.0 - s) - slope[i + 1] * s) * near
        })
        .collect()
}

/// The inputs and the multipliers of an iterate on the nodes of its rest; the states are left as they are.
/// Multipliers of what holds at a node go with the time between nodes, which the cost at a node does; those
/// of the defects, the costate, and of the moves do not.
fn rest_of<const NX: usize, const NU: usize>(iterate: &Iterate<NX, NU>, passed: f64) -> Iterate<NX, NU> {
    let (n, left) = (iterate.lambda.len(), 1.0 - passed);
    let (old, mut rest) = (iterate, iterate.clone());
    let mix = |a: f64, b: f64, s: f64| a + s * (b - a);
    for k in 0..=n {
        let (i, s) = between(passed * n as f64 + left * k as f64, n);
        rest.nodes.u[k] = old.nodes.u[i].zip_map(&old.nodes.u[i + 1], |a, b| mix(a, b, s));
        let (from, to) = (&old.z_u[i], &old.z_u[i + 1]);
        rest.z_u[k].lo = from.lo.zip_map(&to.lo, |a, b| left * mix(a, b, s));
        rest.z_u[k].hi = from.hi.zip_map(&to.hi, |a, b| left * mix(a, b, s));
        if k < n {
            // What holds at the end alone is not mixed in.
            let near = if i + 1 == n || s < 0.5 { i } else { i + 1 };
            rest.z_x[k].lo = old.z_x[near].lo * left;
            rest.z_x[k].hi = old.z_x[near].hi * left;
            let (i, s) = between(passed * n as f64 + left * (k as f64 + 0.5) - 0.5, n - 1);
            rest.lambda[k] = old.lambda[i].zip_map(&old.lambda[i + 1], |a, b| mix(a, b, s));
            let (from, to) = (&old.z_w[i], &old.z_w[i + 1]);
            rest.z_w[k].lo = from.lo.zip_map(&to.lo, |a, b| mix(a, b, s));
            rest.z_w[k].hi = from.hi.zip_map(&to.hi, |a, b| mix(a, b, s));
        }
    }
    // Those of the constraints on the path are found anew.
    rest.path = PathDuals::default();
    rest
}

/// The given state, with the components that are free as they were.
fn first_of<const NX: usize>(
    given: &SVector<f64, NX>,
    was: &SVector<f64, NX>,
    free: &SVector<bool, NX>,
) -> SVector<f64, NX> {
    SVector::from_fn(|i, _| if free[i] { was[i] } else { given[i] })
}

/// Straight line to x_ss over 8 s (or a quarter of a shorter horizon), thrust `min(0.8 hover, 0.6 of the
/// greatest rate)`.
fn straight_line<D: PlannedVehicle<NX, NU>, const NX: usize, const NU: usize>(
    nlp: &Problem<D, NX, NU>,
    hover_n: f64,
) -> (Vec<SVector<f64, BODY_STATES>>, Vec<SVector<f64, NU>>) {
    let over = 8.0f64.min(0.27 * nlp.dt_s * nlp.intervals as f64);
    let at = |k: usize| k as f64 * nlp.dt_s;
    let (from, to) = (D::body_state(&nlp.x_initial), D::body_state(&nlp.cost.x_ref));
    let x = (0..=nlp.intervals).map(|k| from + (to - from) * (at(k) / over).min(1.0));
    let u = (0..=nlp.intervals)
        .map(|k| nlp.bounds.u_rate.map(|rate| (0.8 * hover_n).min(0.6 * rate * at(k).max(1e-300))));
    (x.collect(), u.collect())
}

fn flown_state(flight: &Trajectory, t_s: f64) -> SVector<f64, BODY_STATES> {
    let q = flight.attitude(t_s);
    let v = flight.velocity_ned(t_s);
    let w = flight.body_rates(t_s);
    SVector::from([q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z])
}

/// The iterate `shift` nodes later. The horizon moves along, and what is special about its end (the thrust
/// falls off before t_f) stays with the end: not the last node is repeated but, each time, the one at which
/// least happens.
fn shifted<const NX: usize, const NU: usize>(iterate: &Iterate<NX, NU>, shift: usize) -> Iterate<NX, NU> {
    let mut moved = iterate.clone();
    for _ in 0..shift.min(iterate.lambda.len()) {
        let nodes = &moved.nodes;
        let change = |k: &usize| {
            (nodes.x[k + 1] - nodes.x[*k]).norm_squared()
                + (nodes.u[k + 1] - nodes.u[*k]).norm_squared() / nodes.u[*k].norm_squared().max(1e-12)
        };
        let calm = (1..moved.lambda.len()).min_by(|a, b| change(a).total_cmp(&change(b))).unwrap_or(1);
        fn repeat<T: Clone>(items: &mut Vec<T>, calm: usize) {
            items.insert(calm, items[calm].clone());
            items.remove(0);
        }
        repeat(&mut moved.nodes.x, calm);
        repeat(&mut moved.nodes.u, calm);
        repeat(&mut moved.lambda, calm);
        repeat(&mut moved.z_x, calm);
        repeat(&mut moved.z_u, calm);
        repeat(&mut moved.z_w, calm);
    }
    // Those of the constraints on the path are found anew.
    moved.path = PathDuals::default();
    moved
}
