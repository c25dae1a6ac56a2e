//! The bounds on states, inputs and moves of a whole problem, as the barrier uses them.

use nalgebra::SVector;

use super::barrier::Limits;
use super::problem::{Nodes, Problem};
use super::riccati::Step;

/// Move `w_k = u_k+1 - u_k` of the inputs from node `k` to the next.
#[inline(always)]
pub(super) fn move_out<const NX: usize, const NU: usize>(
    nodes: &Nodes<NX, NU>,
    k: usize,
) -> SVector<f64, NU> {
    nodes.u[k + 1] - nodes.u[k]
}

/// The lower and upper bounds on states, inputs and moves, as the barrier uses them.
#[derive(Clone, Debug)]
pub(super) struct BoxBounds<const NX: usize, const NU: usize> {
    pub(super) x: Limits<NX>,
    pub(super) x_end: Limits<NX>,
    pub(super) u: Limits<NU>,
    pub(super) w: Limits<NU>,
    pub(super) last: usize,
    /// Whether any state is bounded; if not, the state's barrier costs nothing.
    pub(super) on_state: bool,
}

impl<const NX: usize, const NU: usize> BoxBounds<NX, NU> {
    pub(super) fn new<D>(problem: &Problem<D, NX, NU>) -> Self {
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

    /// The number of bounds, all nodes and moves together.
    pub(super) fn count(&self) -> usize {
        let of = |lo: &[f64], hi: &[f64]| lo.iter().chain(hi).filter(|bound| bound.is_finite()).count();
        let every = of(self.u.lo.as_slice(), self.u.hi.as_slice())
            + of(self.w.lo.as_slice(), self.w.hi.as_slice())
            + of(self.x.lo.as_slice(), self.x.hi.as_slice());
        let end = of(self.x_end.lo.as_slice(), self.x_end.hi.as_slice());
        self.last * every + end
    }

    #[inline(always)]
    pub(super) fn at(&self, k: usize) -> &Limits<NX> {
        if k == self.last { &self.x_end } else { &self.x }
    }

    /// Sum of the logarithms of the distances from all bounds; `None` on or beyond a bound.
    pub(super) fn log_distance(&self, nodes: &Nodes<NX, NU>) -> Option<f64> {
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
    pub(super) fn longest_step(&self, nodes: &Nodes<NX, NU>, step: &Step<NX, NU>, tau: f64) -> f64 {
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
