//! The solver's variables, and cold and warm starts.

use nalgebra::SVector;

use super::super::barrier::BoundDuals;
use super::super::box_bounds::{BoxBounds, move_out};
use super::super::problem::Nodes;
use super::super::slacks::PathDuals;

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
    /// Slacks and multipliers of the constraints on the path, in the order in which these apply.
    pub path: PathDuals,
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
            path: PathDuals::default(),
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

    /// The multipliers of defects, bounds and constraints times a factor, for a cost that is so many times as
    /// large.
    pub(super) fn scale_duals(&mut self, factor: f64) {
        let scale = |z: &mut BoundDuals<NU>| {
            z.lo *= factor;
            z.hi *= factor;
        };
        self.z_u.iter_mut().for_each(scale);
        self.z_w.iter_mut().for_each(scale);
        for z in &mut self.z_x {
            z.lo *= factor;
            z.hi *= factor;
        }
        for lambda in &mut self.lambda {
            *lambda *= factor;
        }
        for z in &mut self.path.z {
            *z *= factor;
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
