//! Optimality: the Lagrangian's gradient, the residuals, and the terms of the Newton system.

use nalgebra::{SMatrix, SVector};

use super::super::box_bounds::move_out;
use super::super::dynamics::{Curvature, Dynamics};
use super::super::path::MoveTerms;
use super::super::riccati::{Defects, Hessian, NodeGradient, NodeTerms, Sweep};
use super::super::slacks::PathHessian;
use super::super::transcription::{Evaluation, Linearised, midpoint};
use super::state::Run;

/// Optimality measures of an iterate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Residuals {
    pub(super) dual: f64,
    pub(super) defect: f64,
    pub(super) complementarity: f64,
}

impl Residuals {
    pub(super) fn worst(&self) -> f64 {
        self.dual.max(self.defect).max(self.complementarity)
    }
}

/// By how much the constraints on the path give way in the Newton step, one after another until it can be
/// solved for.
const GIVES: [f64; 4] = [0.0, 1e-10, 1e-8, 1e-6];

impl<D: Dynamics<NX, NU> + Copy, const NX: usize, const NU: usize> Run<'_, D, NX, NU> {
    /// Gradient of the Lagrangian by states and inputs, node by node (the first node is given, but for the
    /// components of its state that are free).
    pub(super) fn lagrangian_gradient(
        &self,
        linearised: &Linearised<NX, NU>,
    ) -> (Vec<SVector<f64, NX>>, Vec<SVector<f64, NU>>) {
        let (p, it) = (self.problem, &self.iterate);
        let n = p.intervals;
        let mut x = vec![SVector::zeros(); n + 1];
        let mut u = vec![SVector::zeros(); n + 1];
        for k in 1..=n {
            let (gx, gu) = p.cost_gradient(&it.nodes, k);
            x[k] = gx + it.z_x[k].net();
            u[k] = gu + it.z_u[k].net() + it.z_w[k - 1].net();
            if k < n {
                u[k] -= it.z_w[k].net();
            }
        }
        // J' lambda without forming J: with m = A_c' lambda, the defect's transpose products are
        // dt/6 A' lambda + dt^2/12 A' m + dt/3 m + lambda, and so on.
        let (w, h12, h3) = (p.dt_s / 6.0, p.dt_s * p.dt_s / 12.0, p.dt_s / 3.0);
        for k in 0..n {
            let lambda = &it.lambda[k];
            let middle = &linearised.middles[k];
            let m_x = middle.a.tr_mul(lambda);
            let m_u = middle.b.tr_mul(lambda) * h3;
            let (left, right) = (lambda * w + m_x * h12, lambda * w - m_x * h12);
            let (l, r) = (&linearised.nodes[k], &linearised.nodes[k + 1]);
            x[k] += l.a.tr_mul(&left) + m_x * h3 + lambda;
            u[k] += l.b.tr_mul(&left) + m_u;
            x[k + 1] += r.a.tr_mul(&right) + m_x * h3 - lambda;
            u[k + 1] += r.b.tr_mul(&right) + m_u;
        }
        if !linearised.path.is_empty() {
            self.add_path_forces(linearised, (&mut x, &mut u));
        }
        if p.has_free_initial() {
            let by_first = x[0] + p.cost_gradient(&it.nodes, 0).0;
            x[0] = by_first.zip_map(&p.x_initial_free, |g, free| if free { g } else { 0.0 });
        }
        (x, u)
    }

    /// Adds the gradient of the constraints on the path, weighted with their multipliers.
    fn add_path_forces(
        &self,
        linearised: &Linearised<NX, NU>,
        (x, u): (&mut [SVector<f64, NX>], &mut [SVector<f64, NU>]),
    ) {
        let n = self.problem.intervals;
        let mut forces = vec![NodeGradient::zero(); n + 1];
        self.problem.add_path_gradient(linearised, &self.iterate.path.z, &mut forces);
        for k in 0..=n {
            x[k] += forces[k].x;
            u[k] += forces[k].u;
            if k < n {
                u[k] -= forces[k].w;
                u[k + 1] += forces[k].w;
            }
        }
    }

    pub(super) fn residuals(
        &self,
        gradient: &(Vec<SVector<f64, NX>>, Vec<SVector<f64, NU>>),
        now: &Evaluation<NX>,
        mu: f64,
    ) -> Residuals {
        let it = &self.iterate;
        let (mut dual, mut complementarity) = (0.0f64, 0.0f64);
        let worse = |a: f64, b: f64| if b <= a { a } else { b };
        if self.problem.has_free_initial() {
            dual = worse(dual, gradient.0[0].amax());
        }
        for k in 1..=self.problem.intervals {
            dual = worse(dual, gradient.0[k].amax());
            dual = worse(dual, gradient.1[k].amax());
            complementarity =
                worse(complementarity, self.boxes.u.complementarity(&it.nodes.u[k], &it.z_u[k], mu));
            let w = move_out(&it.nodes, k - 1);
            complementarity = worse(complementarity, self.boxes.w.complementarity(&w, &it.z_w[k - 1], mu));
            if self.boxes.on_state {
                let at = self.boxes.at(k).complementarity(&it.nodes.x[k], &it.z_x[k], mu);
                complementarity = worse(complementarity, at);
            }
        }
        let mut defect = now.defect_max;
        if !now.path.is_empty() {
            complementarity = worse(complementarity, it.path.complementarity(mu));
            defect = worse(defect, it.path.violation_max(&now.path));
        }
        Residuals { dual, defect, complementarity }
    }

    /// Factors the Newton system, with the exact Hessian if that is convex enough, else with Gauss-Newton's;
    /// where rounding leaves neither, with constraints on the path that give way. Returns the gradients of
    /// cost and bounds.
    pub(super) fn factor(
        &mut self,
        sweep: &mut Sweep<NX, NU>,
        linearised: &Linearised<NX, NU>,
    ) -> Option<Vec<NodeGradient<NX, NU>>> {
        let gives = if linearised.path.is_empty() { &GIVES[..1] } else { &GIVES };
        for &give in gives {
            self.give = give;
            let (first_order, gradients) = self.first_order_hessian(linearised);
            self.counts.factorisations += 1;
            let exact = self.with_curvature(linearised, &first_order);
            let dt_s = self.problem.dt_s;
            if sweep.factor(linearised, dt_s, Defects::Closed, &exact).is_ok() {
                return Some(gradients);
            }
            self.counts.gauss_newton += 1;
            self.counts.factorisations += 1;
            if sweep.factor(linearised, dt_s, Defects::Closed, &first_order).is_ok() {
                return Some(gradients);
            }
        }
        None
    }

    /// Hessian and gradient of cost and bounds; the Hessian with the first derivatives of the constraints on
    /// the path, the gradient without.
    pub(super) fn first_order_hessian(
        &self,
        linearised: &Linearised<NX, NU>,
    ) -> (Hessian<NX, NU>, Vec<NodeGradient<NX, NU>>) {
        let (p, it, n) = (self.problem, &self.iterate, self.problem.intervals);
        let mut nodes = Vec::with_capacity(n + 1);
        let mut gradients = Vec::with_capacity(n + 1);
        for k in 0..=n {
            let mut hessian = Curvature::<NX, NU>::zero();
            let mut gradient = NodeGradient::<NX, NU>::zero();
            if k > 0 {
                let (by_x, by_u) = p.cost_hessian(&it.nodes, k);
                (gradient.x, gradient.u) = p.cost_gradient(&it.nodes, k);
                hessian.xx = diagonal(&by_x);
                let (g, h) = self.boxes.u.terms(&it.nodes.u[k], &it.z_u[k], self.mu);
                gradient.u += g;
                hessian.uu = diagonal(&(by_u + h));
                if self.boxes.on_state {
                    let (g, h) = self.boxes.at(k).terms(&it.nodes.x[k], &it.z_x[k], self.mu);
                    gradient.x += g;
                    for i in 0..NX {
                        hessian.xx[(i, i)] += h[i];
                    }
                }
            } else if p.has_free_initial() {
                gradient.x = p.cost_gradient(&it.nodes, 0).0;
                hessian.xx = diagonal(&p.cost_hessian(&it.nodes, 0).0);
            }
            let mut move_barrier = SVector::zeros();
            if k < n {
                (gradient.w, move_barrier) = self.boxes.w.terms(&move_out(&it.nodes, k), &it.z_w[k], self.mu);
            }
            nodes.push(NodeTerms { hessian, move_barrier });
            gradients.push(gradient);
        }
        let mut hessian = Hessian { nodes, middles: vec![Curvature::zero(); n], moves: Vec::new() };
        if !linearised.path.is_empty() {
            hessian.moves = vec![MoveTerms::zero(); n];
            let Hessian { nodes, middles, moves } = &mut hessian;
            let weights = self.iterate.path.weights(self.give);
            p.add_path_hessian(linearised, &weights, &mut PathHessian { nodes, middles, moves });
        }
        (hessian, gradients)
    }

    /// Adds the curvature of the defects, weighted with their multipliers, at nodes and midpoints, and that
    /// of the constraints on the path.
    pub(super) fn with_curvature(
        &self,
        linearised: &Linearised<NX, NU>,
        first_order: &Hessian<NX, NU>,
    ) -> Hessian<NX, NU> {
        let (p, nodes, n) = (self.problem, &self.iterate.nodes, self.problem.intervals);
        let mut exact = first_order.clone();
        let mut weights = vec![SVector::<f64, NX>::zeros(); n + 1];
        let (w, h12) = (p.dt_s / 6.0, p.dt_s * p.dt_s / 12.0);
        for k in 0..n {
            let lambda = &self.iterate.lambda[k];
            let m = linearised.middles[k].a.tr_mul(lambda) * h12;
            weights[k] += lambda * w + m;
            weights[k + 1] += lambda * w - m;
            let (l, r) = (&linearised.nodes[k], &linearised.nodes[k + 1]);
            let (x_c, u_c) = midpoint(nodes, k, p.dt_s, &l.f, &r.f);
            exact.middles[k] += p.dynamics.curvature(&x_c, &u_c, &(lambda * (4.0 * w)));
        }
        if !linearised.path.is_empty() {
            let Hessian { nodes: terms, middles, moves } = &mut exact;
            let mut terms = PathHessian { nodes: terms, middles, moves };
            p.add_path_curvature(nodes, linearised, &self.iterate.path.z, &mut terms, &mut weights);
        }
        let first = usize::from(!p.has_free_initial());
        for (k, weights) in weights.iter().enumerate().skip(first) {
            let c = p.dynamics.curvature(&nodes.x[k], &nodes.u[k], weights);
            let own = &mut exact.nodes[k].hessian;
            *own += c;
            p.add_stretch_coupling(nodes, k, own);
        }
        exact
    }
}

fn diagonal<const N: usize>(d: &SVector<f64, N>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| if i == j { d[i] } else { 0.0 })
}
