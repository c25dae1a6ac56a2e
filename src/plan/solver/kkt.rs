//! Optimality: the Lagrangian's gradient, the residuals, and the terms of the Newton system.

use nalgebra::{SMatrix, SVector};

use super::super::box_bounds::move_out;
use super::super::dynamics::{Curvature, Dynamics};
use super::super::riccati::{Defects, NodeGradient, NodeTerms, Sweep};
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

impl<D: Dynamics<NX, NU>, const NX: usize, const NU: usize> Run<'_, D, NX, NU> {
    /// Gradient of the Lagrangian by states and inputs, node by node (the first node is fixed).
    pub(super) fn lagrangian_gradient(
        &self,
        linearised: &Linearised<NX, NU>,
    ) -> (Vec<SVector<f64, NX>>, Vec<SVector<f64, NU>>) {
        let (p, it) = (self.problem, &self.iterate);
        let n = p.intervals;
        let mut x = vec![SVector::zeros(); n + 1];
        let mut u = vec![SVector::zeros(); n + 1];
        for k in 1..=n {
            let (gx, gu) = self.cost_gradient(k);
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
        (x, u)
    }

    #[inline(always)]
    pub(super) fn cost_gradient(&self, k: usize) -> (SVector<f64, NX>, SVector<f64, NU>) {
        let (p, nodes) = (self.problem, &self.iterate.nodes);
        let x = (nodes.x[k] - p.cost.x_ref).component_mul(&p.state_weight(k)) * 2.0;
        let u = (nodes.u[k] - p.cost.u_ref).component_mul(&p.cost.r) * (2.0 * p.node_weight(k));
        (x, u)
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
        Residuals { dual, defect: now.defect_max, complementarity }
    }

    /// Factors the Newton system, with the exact Hessian if that is convex enough, else with Gauss-Newton's.
    pub(super) fn factor(
        &mut self,
        sweep: &mut Sweep<NX, NU>,
        linearised: &Linearised<NX, NU>,
    ) -> Option<Vec<NodeGradient<NX, NU>>> {
        let (terms, gradients) = self.first_order_terms();
        self.counts.factorisations += 1;
        let (exact, middles) = self.with_curvature(linearised, &terms);
        let dt_s = self.problem.dt_s;
        if sweep.factor(linearised, dt_s, Defects::Closed, &exact, &middles).is_ok() {
            return Some(gradients);
        }
        self.counts.gauss_newton += 1;
        self.counts.factorisations += 1;
        let none = vec![Curvature::zero(); middles.len()];
        sweep.factor(linearised, dt_s, Defects::Closed, &terms, &none).ok()?;
        Some(gradients)
    }

    /// Hessian and gradient of cost and barrier.
    pub(super) fn first_order_terms(&self) -> (Vec<NodeTerms<NX, NU>>, Vec<NodeGradient<NX, NU>>) {
        let (p, it, n) = (self.problem, &self.iterate, self.problem.intervals);
        let mut terms = Vec::with_capacity(n + 1);
        let mut gradients = Vec::with_capacity(n + 1);
        for k in 0..=n {
            let mut hessian = Curvature::<NX, NU>::zero();
            let mut gradient =
                NodeGradient::<NX, NU> { x: SVector::zeros(), u: SVector::zeros(), w: SVector::zeros() };
            if k > 0 {
                (gradient.x, gradient.u) = self.cost_gradient(k);
                hessian.xx = diagonal(&(p.state_weight(k) * 2.0));
                let (g, h) = self.boxes.u.terms(&it.nodes.u[k], &it.z_u[k], self.mu);
                gradient.u += g;
                hessian.uu = diagonal(&(p.cost.r * (2.0 * p.node_weight(k)) + h));
                if self.boxes.on_state {
                    let (g, h) = self.boxes.at(k).terms(&it.nodes.x[k], &it.z_x[k], self.mu);
                    gradient.x += g;
                    for i in 0..NX {
                        hessian.xx[(i, i)] += h[i];
                    }
                }
            }
            let mut move_barrier = SVector::zeros();
            if k < n {
                (gradient.w, move_barrier) = self.boxes.w.terms(&move_out(&it.nodes, k), &it.z_w[k], self.mu);
            }
            terms.push(NodeTerms { hessian, move_barrier });
            gradients.push(gradient);
        }
        (terms, gradients)
    }

    /// Adds the curvature of the defects, weighted with their multipliers, at nodes and midpoints.
    pub(super) fn with_curvature(
        &self,
        linearised: &Linearised<NX, NU>,
        terms: &[NodeTerms<NX, NU>],
    ) -> (Vec<NodeTerms<NX, NU>>, Vec<Curvature<NX, NU>>) {
        let (p, nodes, n) = (self.problem, &self.iterate.nodes, self.problem.intervals);
        let mut terms = terms.to_vec();
        let mut weights = vec![SVector::<f64, NX>::zeros(); n + 1];
        let mut middles = Vec::with_capacity(n);
        let (w, h12) = (p.dt_s / 6.0, p.dt_s * p.dt_s / 12.0);
        for k in 0..n {
            let lambda = &self.iterate.lambda[k];
            let m = linearised.middles[k].a.tr_mul(lambda) * h12;
            weights[k] += lambda * w + m;
            weights[k + 1] += lambda * w - m;
            let (l, r) = (&linearised.nodes[k], &linearised.nodes[k + 1]);
            let (x_c, u_c) = midpoint(nodes, k, p.dt_s, &l.f, &r.f);
            middles.push(p.dynamics.curvature(&x_c, &u_c, &(lambda * (4.0 * w))));
        }
        for k in 1..=n {
            let c = p.dynamics.curvature(&nodes.x[k], &nodes.u[k], &weights[k]);
            let own = &mut terms[k].hessian;
            own.xx += c.xx;
            own.ux += c.ux;
            own.uu += c.uu;
        }
        (terms, middles)
    }
}

fn diagonal<const N: usize>(d: &SVector<f64, N>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| if i == j { d[i] } else { 0.0 })
}
