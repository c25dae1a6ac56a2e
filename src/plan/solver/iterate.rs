//! The solver's variables, the bounds as its barrier sees them, and where it starts from.

use nalgebra::SVector;

use super::super::barrier::{BoundDuals, Limits};
use super::super::problem::{Nodes, Problem};
use super::super::riccati::Step;

/// Primal and dual variables of the solver.
#[derive(Clone, Debug)]
pub struct Iterate<const NX: usize, const NU: usize> {
    /// States and inputs, node by node.
    pub nodes: Nodes<NX, NU>,
    /// Multipliers of the defects, one per interval.
    pub lambda: Vec<SVector<f64, NX>>,
    /// Multipliers of the state bounds, one per node.
    pub z_x: Vec<BoundDuals<NX>>,
    /// Multipliers of the input bounds, one per node.
    pub z_u: Vec<BoundDuals<NU>>,
    /// Multipliers of the rate bounds, one per interval.
    pub z_w: Vec<BoundDuals<NU>>,
}

/// Move `w_k = u_k+1 - u_k` of the inputs from node `k` to the next.
#[inline(always)]
pub(in crate::plan) fn move_out<const NX: usize, const NU: usize>(
    nodes: &Nodes<NX, NU>,
    k: usize,
) -> SVector<f64, NU> {
    nodes.u[k + 1] - nodes.u[k]
}

/// The lower and upper bounds on states, inputs and moves, as the barrier uses them.
#[derive(Clone, Debug)]
pub(in crate::plan) struct BoxBounds<const NX: usize, const NU: usize> {
    pub(in crate::plan) x: Limits<NX>,
    pub(in crate::plan) x_end: Limits<NX>,
    pub(in crate::plan) u: Limits<NU>,
    pub(in crate::plan) w: Limits<NU>,
    pub(in crate::plan) last: usize,
    /// Whether any state is bounded; if not, the state's barrier costs nothing.
    pub(in crate::plan) on_state: bool,
}

impl<const NX: usize, const NU: usize> BoxBounds<NX, NU> {
    pub(in crate::plan) fn new<D>(problem: &Problem<D, NX, NU>) -> Self {
        let b = &problem.bounds;
        let last = problem.intervals;
        let limits = |k| {
            let (lo, hi) = b.on_state(k, last);
            Limits { lo, hi }
        };
        let (x, x_end) = (limits(last - 1), limits(last));
        let on_state = x_end
            .lo
            .iter()
            .chain(x_end.hi.iter())
            .chain(x.lo.iter())
            .chain(x.hi.iter())
            .any(|b| b.is_finite());
        let move_max = b.u_rate * problem.dt_s;
        Self {
            x,
            x_end,
            u: Limits { lo: b.u_min, hi: b.u_max },
            w: Limits { lo: -move_max, hi: move_max },
            last,
            on_state,
        }
    }

    #[inline(always)]
    pub(in crate::plan) fn at(&self, k: usize) -> &Limits<NX> {
        if k == self.last { &self.x_end } else { &self.x }
    }

    /// Sum of the logarithms of the distances from all bounds; `None` on or beyond a bound.
    pub(in crate::plan) fn log_distance(&self, nodes: &Nodes<NX, NU>) -> Option<f64> {
        let mut sum = 0.0;
        for k in 0..=self.last {
            if k > 0 {
                sum += self.u.log_distance(&nodes.u[k])?;
                if self.on_state {
                    sum += self.at(k).log_distance(&nodes.x[k])?;
                }
            }
            if k < self.last {
                sum += self.w.log_distance(&move_out(nodes, k))?;
            }
        }
        Some(sum)
    }

    /// Longest primal step in [0, 1] that keeps the fraction `1 - tau` of the distance from each bound.
    pub(in crate::plan) fn longest_step(&self, nodes: &Nodes<NX, NU>, step: &Step<NX, NU>, tau: f64) -> f64 {
        let mut alpha = 1.0f64;
        for k in 0..=self.last {
            if k > 0 {
                alpha = alpha.min(self.u.longest_step(&nodes.u[k], &step.u[k], tau));
                if self.on_state {
                    alpha = alpha.min(self.at(k).longest_step(&nodes.x[k], &step.x[k], tau));
                }
            }
            if k < self.last {
                alpha = alpha.min(self.w.longest_step(&move_out(nodes, k), &step.w[k], tau));
            }
        }
        alpha
    }

    /// Moves node values strictly inside all bounds: inputs first into theirs, then within reach of the node
    /// before.
    pub(super) fn interior(&self, nodes: &mut Nodes<NX, NU>, margin: f64) {
        for k in 1..=self.last {
            let boxed = self.u.interior(&nodes.u[k], margin);
            let reach = self.w.hi * (1.0 - 5.0 * margin);
            let before = nodes.u[k - 1];
            nodes.u[k] = (boxed - before).sup(&-reach).inf(&reach) + before;
            nodes.x[k] = self.at(k).interior(&nodes.x[k], margin);
        }
    }
}

impl<const NX: usize, const NU: usize> Iterate<NX, NU> {
    pub(super) fn cold(mut nodes: Nodes<NX, NU>, boxes: &BoxBounds<NX, NU>, mu: f64) -> Self {
        boxes.interior(&mut nodes, 0.01);
        let last = boxes.last;
        let mut iterate = Self {
            lambda: vec![SVector::zeros(); last],
            z_x: vec![BoundDuals::zero(); last + 1],
            z_u: vec![BoundDuals::zero(); last + 1],
            z_w: vec![BoundDuals::zero(); last],
            nodes,
        };
        iterate.centre(boxes, mu);
        iterate
    }

    /// Sets all bound multipliers to their central values.
    pub(super) fn centre(&mut self, boxes: &BoxBounds<NX, NU>, mu: f64) {
        for k in 1..=boxes.last {
            self.z_u[k] = boxes.u.central_duals(&self.nodes.u[k], mu);
            self.z_x[k] = boxes.at(k).central_duals(&self.nodes.x[k], mu);
            self.z_w[k - 1] = boxes.w.central_duals(&move_out(&self.nodes, k - 1), mu);
        }
    }

    pub(super) fn warm(mut self, boxes: &BoxBounds<NX, NU>, mu: f64) -> Self {
        // Closer to the bounds than a cold start: the neighbouring solution lies on them.
        boxes.interior(&mut self.nodes, 1e-3);
        for k in 1..=boxes.last {
            // The larger of the old multiplier and the central one: an active bound stays active, none is
            // forgotten.
            let keep = |old: f64, centre: f64| if old.is_finite() { old.max(centre) } else { centre };
            let w = move_out(&self.nodes, k - 1);
            let (u, x) = (self.nodes.u[k], self.nodes.x[k]);
            let merge_u = |z: &mut BoundDuals<NU>, c: BoundDuals<NU>| {
                z.lo = z.lo.zip_map(&c.lo, keep);
                z.hi = z.hi.zip_map(&c.hi, keep);
            };
            merge_u(&mut self.z_u[k], boxes.u.central_duals(&u, mu));
            merge_u(&mut self.z_w[k - 1], boxes.w.central_duals(&w, mu));
            let c = boxes.at(k).central_duals(&x, mu);
            self.z_x[k].lo = self.z_x[k].lo.zip_map(&c.lo, keep);
            self.z_x[k].hi = self.z_x[k].hi.zip_map(&c.hi, keep);
        }
        self
    }

    /// Whether the vectors have the lengths that `intervals` ask for.
    pub(super) fn fits(&self, intervals: usize) -> bool {
        self.nodes.fits(intervals)
            && self.lambda.len() == intervals
            && self.z_w.len() == intervals
            && self.z_u.len() == intervals + 1
            && self.z_x.len() == intervals + 1
    }
}

impl<const NX: usize, const NU: usize> Nodes<NX, NU> {
    pub(in crate::plan) fn fits(&self, intervals: usize) -> bool {
        self.x.len() == intervals + 1 && self.u.len() == intervals + 1
    }

    pub(in crate::plan) fn advanced(&self, step: &Step<NX, NU>, alpha: f64) -> Self {
        let along = |a: &SVector<f64, NX>, d: &SVector<f64, NX>| a + d * alpha;
        Self {
            x: self.x.iter().zip(&step.x).map(|(a, d)| along(a, d)).collect(),
            u: self.u.iter().zip(&step.u).map(|(a, d)| a + d * alpha).collect(),
        }
    }
}
