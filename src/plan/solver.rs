//! A primal-dual interior point method on the stage structure: monotone barrier, filter line search, second-order
//! correction, restoration.
//!
//! The algorithm is that of IPOPT (Waechter and Biegler 2006), in its order and symbols; the linear algebra is the sweep of
//! [`super::riccati`]. Where the reduced Hessian is not positive definite, that iteration uses the Gauss-Newton Hessian
//! (cost and barrier, no curvature of the dynamics), which always is.

use std::ops::ControlFlow;

use nalgebra::{SMatrix, SVector};

use super::barrier::{BoundDuals, Limits, longest_dual_step};
use super::dynamics::{Curvature, Dynamics};
use super::filter::{Filter, Merit, Verdict};
use super::problem::{Nodes, Problem};
use super::restoration::{self, Restored};
use super::riccati::{NodeGradient, NodeTerms, Step, Sweep};
use super::transcription::{Evaluation, Linearised};

/// Settings of the solver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverOptions {
    /// Bound on the KKT residual, the complementarity and the largest defect, all unscaled.
    pub tolerance: f64,
    /// Iterations, restoration included.
    pub max_iterations: usize,
    /// First barrier parameter of a cold start, in units of the cost. Large enough to hold the first iterates off the bounds:
    /// with IPOPT's 0.1 the median over 300 random releases is 24 iterations, with 30 it is 17.
    pub mu_initial: f64,
    /// First barrier parameter of a warm start, in units of the cost. Over 720 plans renewed in flight, each off a little,
    /// the mean is 5.8 iterations with 1e-4 and 6.9 with 1e-2 (and a wider margin to the bounds). Off in yaw too, which the
    /// Titan lander cannot steer and which adds up, it is 11.7 against 11.0.
    pub mu_warm: f64,
}

impl Default for SolverOptions {
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 300, mu_initial: 30.0, mu_warm: 1e-4 }
    }
}

/// How a solve ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// A point that satisfies the optimality conditions to tolerance.
    Converged,
    /// The iteration budget is used up; the best point found is returned.
    IterationLimit,
    /// The observer asked to stop; the best point found is returned.
    Stopped,
    /// No point near this one satisfies the constraints.
    Infeasible,
    /// The iterates left the region where the model can be evaluated.
    Diverged,
}

/// How a solve stands after an iteration: what an observer sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Iterations so far.
    pub iteration: usize,
    /// J_d.
    pub objective: f64,
    /// Largest defect.
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient.
    pub kkt_residual: f64,
    /// Barrier parameter.
    pub mu: f64,
    /// Length of the last step.
    pub step_length: f64,
}

/// Work done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Interior point iterations.
    pub iterations: usize,
    /// Evaluations of all defects without derivatives.
    pub evaluations: usize,
    /// Sweeps factored.
    pub factorisations: usize,
    /// Iterations that fell back on the Gauss-Newton Hessian.
    pub gauss_newton: usize,
    /// Second-order corrections taken.
    pub corrections: usize,
    /// Restoration phases entered.
    pub restorations: usize,
}

/// Primal and dual variables.
#[derive(Clone, Debug)]
pub struct Iterate<const NX: usize, const NU: usize> {
    /// States and inputs.
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

/// What a solve starts from.
#[derive(Clone, Debug)]
pub enum StartFrom<const NX: usize, const NU: usize> {
    /// Node values only.
    Guess(Nodes<NX, NU>),
    /// Primal and dual variables of a neighbouring problem.
    Warm(Iterate<NX, NU>),
}

/// What a solve ends with.
#[derive(Clone, Debug)]
pub struct Solution<const NX: usize, const NU: usize> {
    /// How it ended.
    pub status: Status,
    /// The solution, or the best point found (feasible with the least cost; else the least infeasible).
    pub iterate: Iterate<NX, NU>,
    /// J_d there.
    pub objective: f64,
    /// Largest defect there.
    pub defect_max: f64,
    /// Largest entry of the Lagrangian's gradient there.
    pub kkt_residual: f64,
    /// Largest product of a bound's multiplier and distance there.
    pub complementarity: f64,
    /// Work done.
    pub work: Work,
}

/// Move of the inputs out of node `k`.
#[inline(always)]
pub(super) fn move_out<const NX: usize, const NU: usize>(
    nodes: &Nodes<NX, NU>,
    k: usize,
) -> SVector<f64, NU> {
    nodes.u[k + 1] - nodes.u[k]
}

/// The bounds as the barrier sees them.
#[derive(Clone, Debug)]
pub(super) struct Fences<const NX: usize, const NU: usize> {
    pub(super) x: Limits<NX>,
    pub(super) x_end: Limits<NX>,
    pub(super) u: Limits<NU>,
    pub(super) w: Limits<NU>,
    pub(super) last: usize,
    /// Whether any state is bounded; if not, the state's barrier costs nothing.
    pub(super) on_state: bool,
}

impl<const NX: usize, const NU: usize> Fences<NX, NU> {
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

    #[inline(always)]
    pub(super) fn at(&self, k: usize) -> &Limits<NX> {
        if k == self.last { &self.x_end } else { &self.x }
    }

    /// Sum of all logarithms; `None` on or beyond a bound.
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

    /// Longest primal step.
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

    /// Moves node values strictly inside all bounds: inputs first into theirs, then within reach of the node before.
    fn interior(&self, nodes: &mut Nodes<NX, NU>, margin: f64) {
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
    fn cold(mut nodes: Nodes<NX, NU>, fences: &Fences<NX, NU>, mu: f64) -> Self {
        fences.interior(&mut nodes, 0.01);
        let last = fences.last;
        let mut iterate = Self {
            lambda: vec![SVector::zeros(); last],
            z_x: vec![BoundDuals::zero(); last + 1],
            z_u: vec![BoundDuals::zero(); last + 1],
            z_w: vec![BoundDuals::zero(); last],
            nodes,
        };
        iterate.centre(fences, mu);
        iterate
    }

    /// Sets all bound multipliers to their central values.
    fn centre(&mut self, fences: &Fences<NX, NU>, mu: f64) {
        for k in 1..=fences.last {
            self.z_u[k] = fences.u.central_duals(&self.nodes.u[k], mu);
            self.z_x[k] = fences.at(k).central_duals(&self.nodes.x[k], mu);
            self.z_w[k - 1] = fences.w.central_duals(&move_out(&self.nodes, k - 1), mu);
        }
    }

    fn warm(mut self, fences: &Fences<NX, NU>, mu: f64) -> Self {
        // Closer to the bounds than a cold start: the neighbouring solution lies on them.
        fences.interior(&mut self.nodes, 1e-3);
        for k in 1..=fences.last {
            // The larger of the old multiplier and the central one: an active bound stays active, none is forgotten.
            let keep = |old: f64, centre: f64| if old.is_finite() { old.max(centre) } else { centre };
            let w = move_out(&self.nodes, k - 1);
            let (u, x) = (self.nodes.u[k], self.nodes.x[k]);
            let merge_u = |z: &mut BoundDuals<NU>, c: BoundDuals<NU>| {
                z.lo = z.lo.zip_map(&c.lo, keep);
                z.hi = z.hi.zip_map(&c.hi, keep);
            };
            merge_u(&mut self.z_u[k], fences.u.central_duals(&u, mu));
            merge_u(&mut self.z_w[k - 1], fences.w.central_duals(&w, mu));
            let c = fences.at(k).central_duals(&x, mu);
            self.z_x[k].lo = self.z_x[k].lo.zip_map(&c.lo, keep);
            self.z_x[k].hi = self.z_x[k].hi.zip_map(&c.hi, keep);
        }
        self
    }

    /// Whether the vectors have the lengths that `intervals` ask for.
    fn fits(&self, intervals: usize) -> bool {
        self.nodes.fits(intervals)
            && self.lambda.len() == intervals
            && self.z_w.len() == intervals
            && self.z_u.len() == intervals + 1
            && self.z_x.len() == intervals + 1
    }
}

impl<const NX: usize, const NU: usize> Nodes<NX, NU> {
    pub(super) fn fits(&self, intervals: usize) -> bool {
        self.x.len() == intervals + 1 && self.u.len() == intervals + 1
    }

    pub(super) fn advanced(&self, step: &Step<NX, NU>, alpha: f64) -> Self {
        let along = |a: &SVector<f64, NX>, d: &SVector<f64, NX>| a + d * alpha;
        Self {
            x: self.x.iter().zip(&step.x).map(|(a, d)| along(a, d)).collect(),
            u: self.u.iter().zip(&step.u).map(|(a, d)| a + d * alpha).collect(),
        }
    }
}

/// Optimality measures of an iterate.
#[derive(Clone, Copy, Debug)]
struct Residuals {
    dual: f64,
    defect: f64,
    complementarity: f64,
}

impl Residuals {
    fn worst(&self) -> f64 {
        self.dual.max(self.defect).max(self.complementarity)
    }
}

/// A problem that cannot be posed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ProblemError {
    /// Fewer than two intervals.
    #[error("at least 3 nodes are needed")]
    TooFewNodes,
    /// Bounds that leave no interior.
    #[error("lower bounds must lie below upper bounds, and rate limits above zero")]
    EmptyBounds,
    /// The start has another number of nodes than the problem.
    #[error("the guess has another number of nodes than the problem")]
    GuessLength,
    /// A number that is not finite in the initial state, the weights or the guess.
    #[error("the initial state, the weights and the step must be finite")]
    NotFinite,
}

fn check<D, const NX: usize, const NU: usize>(problem: &Problem<D, NX, NU>) -> Result<(), ProblemError> {
    if problem.intervals < 2 {
        return Err(ProblemError::TooFewNodes);
    }
    let fences = Fences::new(problem);
    let open = |lo: &[f64], hi: &[f64]| lo.iter().zip(hi).all(|(l, h)| l < h);
    let pairs = [&fences.x, &fences.x_end];
    if !pairs.iter().all(|l| open(l.lo.as_slice(), l.hi.as_slice()))
        || !open(fences.u.lo.as_slice(), fences.u.hi.as_slice())
        || !open(fences.w.lo.as_slice(), fences.w.hi.as_slice())
    {
        return Err(ProblemError::EmptyBounds);
    }
    let c = &problem.cost;
    let finite = problem.dt_s.is_finite()
        && [&problem.x_initial, &c.x_ref, &c.q, &c.s].iter().all(|v| v.iter().all(|x| x.is_finite()))
        && [&problem.u_initial, &c.u_ref, &c.r].iter().all(|v| v.iter().all(|x| x.is_finite()));
    if finite { Ok(()) } else { Err(ProblemError::NotFinite) }
}

/// Solves the problem. After each iteration `observer` sees how it stands and may stop it: budgets of time, which the
/// solver knows nothing of, are kept there.
///
/// # Errors
/// [`ProblemError`] for a problem that cannot be posed. That no solution was found is not an error but a [`Status`].
pub fn solve<D: Dynamics<NX, NU>, const NX: usize, const NU: usize>(
    problem: &Problem<D, NX, NU>,
    start: StartFrom<NX, NU>,
    options: &SolverOptions,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Solution<NX, NU>, ProblemError> {
    check(problem)?;
    let fences = Fences::new(problem);
    let (mut iterate, mu) = match start {
        StartFrom::Guess(nodes) => {
            if !nodes.fits(problem.intervals) {
                return Err(ProblemError::GuessLength);
            }
            let mut nodes = nodes;
            (nodes.x[0], nodes.u[0]) = (problem.x_initial, problem.u_initial);
            (Iterate::cold(nodes, &fences, options.mu_initial), options.mu_initial)
        }
        StartFrom::Warm(mut iterate) => {
            if !iterate.fits(problem.intervals) {
                return Err(ProblemError::GuessLength);
            }
            (iterate.nodes.x[0], iterate.nodes.u[0]) = (problem.x_initial, problem.u_initial);
            (iterate.warm(&fences, options.mu_warm), options.mu_warm)
        }
    };
    // Deviation of a non-finite state in the guess is mended by holding the initial state.
    for x in &mut iterate.nodes.x {
        if !x.iter().all(|c| c.is_finite()) {
            *x = problem.x_initial;
        }
    }
    Ok(Run { problem, fences, options, iterate, mu, work: Work::default(), best: None, step_length: 0.0 }
        .run(observer))
}

/// The best point seen.
struct Best<const NX: usize, const NU: usize> {
    iterate: Iterate<NX, NU>,
    objective: f64,
    defect_max: f64,
}

struct Run<'a, D, const NX: usize, const NU: usize> {
    problem: &'a Problem<D, NX, NU>,
    fences: Fences<NX, NU>,
    options: &'a SolverOptions,
    iterate: Iterate<NX, NU>,
    mu: f64,
    work: Work,
    best: Option<Best<NX, NU>>,
    step_length: f64,
}

/// A barrier problem is solved well enough for the next when its residual is below this multiple of `mu`. (IPOPT's 10 costs
/// a fifth more iterations on this problem.)
const BARRIER_TOLERANCE: f64 = 100.0;

/// What a line search found.
enum Search {
    Moved,
    Failed,
}

impl<D: Dynamics<NX, NU>, const NX: usize, const NU: usize> Run<'_, D, NX, NU> {
    fn run(mut self, observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>) -> Solution<NX, NU> {
        let tolerance = self.options.tolerance;
        let (mut linearised, mut now) = self.problem.linearise(&self.iterate.nodes);
        let mut filter = Filter::new(now.defect_sum);
        let mut sweep = Sweep::new(self.problem.intervals);
        let mu_least = tolerance * 0.05;
        loop {
            let gradient = self.lagrangian_gradient(&linearised);
            let residuals = self.residuals(&gradient, &now, 0.0);
            self.remember(&now);
            if residuals.worst() <= tolerance && self.mu <= tolerance {
                return self.finish(Status::Converged, &now, residuals);
            }
            if !(now.is_finite() && residuals.worst().is_finite()) {
                return self.finish_with_best(Status::Diverged);
            }
            let progress = Progress {
                iteration: self.work.iterations,
                objective: now.objective,
                defect_max: now.defect_max,
                kkt_residual: residuals.dual,
                mu: self.mu,
                step_length: self.step_length,
            };
            if observer(&progress).is_break() {
                return self.finish_with_best(Status::Stopped);
            }
            if self.work.iterations >= self.options.max_iterations {
                return self.finish_with_best(Status::IterationLimit);
            }
            self.work.iterations += 1;
            while self.mu > mu_least
                && self.residuals(&gradient, &now, self.mu).worst() <= BARRIER_TOLERANCE * self.mu
            {
                self.mu = (0.2 * self.mu).min(self.mu.powf(1.5)).max(mu_least);
                filter.clear();
            }
            let Some(gradients) = self.factor(&mut sweep, &linearised) else {
                return self.finish_with_best(Status::Diverged);
            };
            let step = sweep.solve(&gradients, &now.defects);
            match self.line_search(&sweep, &gradients, step, &now, &mut filter) {
                Search::Moved => {}
                Search::Failed => {
                    self.work.restorations += 1;
                    filter.add(self.merit(&now));
                    match restoration::restore(
                        self.problem,
                        &self.fences,
                        &self.iterate.nodes,
                        self.mu,
                        &filter,
                    ) {
                        Restored::Found { nodes, iterations } => {
                            self.work.iterations += iterations;
                            self.iterate.nodes = nodes;
                            self.iterate.centre(&self.fences, self.mu);
                            self.iterate.lambda.fill(SVector::zeros());
                        }
                        Restored::Infeasible => return self.finish_with_best(Status::Infeasible),
                        Restored::Failed => return self.finish_with_best(Status::Diverged),
                    }
                }
            }
            (linearised, now) = self.problem.linearise(&self.iterate.nodes);
        }
    }

    /// Gradient of the Lagrangian by states and inputs, node by node (the first node is fixed).
    fn lagrangian_gradient(
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
    fn cost_gradient(&self, k: usize) -> (SVector<f64, NX>, SVector<f64, NU>) {
        let (p, nodes) = (self.problem, &self.iterate.nodes);
        let x = (nodes.x[k] - p.cost.x_ref).component_mul(&p.state_weight(k)) * 2.0;
        let u = (nodes.u[k] - p.cost.u_ref).component_mul(&p.cost.r) * (2.0 * p.node_weight(k));
        (x, u)
    }

    fn residuals(
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
                worse(complementarity, self.fences.u.complementarity(&it.nodes.u[k], &it.z_u[k], mu));
            let w = move_out(&it.nodes, k - 1);
            complementarity = worse(complementarity, self.fences.w.complementarity(&w, &it.z_w[k - 1], mu));
            if self.fences.on_state {
                let at = self.fences.at(k).complementarity(&it.nodes.x[k], &it.z_x[k], mu);
                complementarity = worse(complementarity, at);
            }
        }
        Residuals { dual, defect: now.defect_max, complementarity }
    }

    /// Factors the Newton system, with the exact Hessian if that is convex enough, else with Gauss-Newton's.
    fn factor(
        &mut self,
        sweep: &mut Sweep<NX, NU>,
        linearised: &Linearised<NX, NU>,
    ) -> Option<Vec<NodeGradient<NX, NU>>> {
        let (terms, gradients) = self.first_order_terms();
        self.work.factorisations += 1;
        let (exact, middles) = self.with_curvature(linearised, &terms);
        let dt_s = self.problem.dt_s;
        if sweep.factor(linearised, dt_s, &exact, &middles).is_ok() {
            return Some(gradients);
        }
        self.work.gauss_newton += 1;
        self.work.factorisations += 1;
        let none = Curvature::zero();
        sweep.factor(linearised, dt_s, &terms, &vec![none; middles.len()]).ok()?;
        Some(gradients)
    }

    /// Hessian and gradient of cost and barrier.
    fn first_order_terms(&self) -> (Vec<NodeTerms<NX, NU>>, Vec<NodeGradient<NX, NU>>) {
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
                let (g, h) = self.fences.u.terms(&it.nodes.u[k], &it.z_u[k], self.mu);
                gradient.u += g;
                hessian.uu = diagonal(&(p.cost.r * (2.0 * p.node_weight(k)) + h));
                if self.fences.on_state {
                    let (g, h) = self.fences.at(k).terms(&it.nodes.x[k], &it.z_x[k], self.mu);
                    gradient.x += g;
                    for i in 0..NX {
                        hessian.xx[(i, i)] += h[i];
                    }
                }
            }
            let mut move_barrier = SVector::zeros();
            if k < n {
                (gradient.w, move_barrier) =
                    self.fences.w.terms(&move_out(&it.nodes, k), &it.z_w[k], self.mu);
            }
            terms.push(NodeTerms { hessian, move_barrier });
            gradients.push(gradient);
        }
        (terms, gradients)
    }

    /// Adds the curvature of the defects, weighted with their multipliers, at nodes and midpoints.
    fn with_curvature(
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
            let (x_c, u_c) = super::transcription::midpoint(nodes, k, p.dt_s, &l.f, &r.f);
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

    fn merit(&self, now: &Evaluation<NX>) -> Merit {
        let barrier = self.fences.log_distance(&self.iterate.nodes).unwrap_or(f64::NEG_INFINITY);
        Merit { violation: now.defect_sum, objective: now.objective - self.mu * barrier }
    }

    fn merit_at(&mut self, nodes: &Nodes<NX, NU>) -> (Merit, Evaluation<NX>) {
        self.work.evaluations += 1;
        let evaluation = self.problem.evaluate(nodes);
        let objective = match self.fences.log_distance(nodes) {
            Some(log) => evaluation.objective - self.mu * log,
            None => f64::INFINITY,
        };
        (Merit { violation: evaluation.defect_sum, objective }, evaluation)
    }

    fn line_search(
        &mut self,
        sweep: &Sweep<NX, NU>,
        gradients: &[NodeGradient<NX, NU>],
        step: Step<NX, NU>,
        now: &Evaluation<NX>,
        filter: &mut Filter,
    ) -> Search {
        let tau = (1.0 - self.mu).max(0.99);
        let from = self.merit(now);
        let slope = slope_of(gradients, &step);
        let mut alpha = self.fences.longest_step(&self.iterate.nodes, &step, tau);
        let least = filter.least_step(from, slope);
        let mut first = true;
        while alpha >= least {
            let nodes = self.iterate.nodes.advanced(&step, alpha);
            let (trial, evaluation) = self.merit_at(&nodes);
            match filter.judge(from, trial, alpha, slope) {
                Verdict::Rejected => {}
                verdict => {
                    if verdict == Verdict::Violation {
                        filter.add(from);
                    }
                    self.accept(nodes, &step, alpha, tau);
                    return Search::Moved;
                }
            }
            if first && trial.violation >= from.violation && evaluation.is_finite() {
                let moved = self.correct(sweep, gradients, now, &evaluation, alpha, (from, slope), filter);
                if let Some((nodes, corrected, length)) = moved {
                    self.work.corrections += 1;
                    self.accept(nodes, &corrected, length, tau);
                    return Search::Moved;
                }
            }
            first = false;
            alpha *= 0.5;
        }
        Search::Failed
    }

    /// Second-order correction: the same sweep with the defects of the rejected trial point added.
    #[expect(clippy::too_many_arguments, reason = "the state of one line search, used once")]
    fn correct(
        &mut self,
        sweep: &Sweep<NX, NU>,
        gradients: &[NodeGradient<NX, NU>],
        now: &Evaluation<NX>,
        trial: &Evaluation<NX>,
        alpha: f64,
        (from, slope): (Merit, f64),
        filter: &mut Filter,
    ) -> Option<(Nodes<NX, NU>, Step<NX, NU>, f64)> {
        let tau = (1.0 - self.mu).max(0.99);
        let mut defects: Vec<_> =
            now.defects.iter().zip(&trial.defects).map(|(c, t)| c * alpha + t).collect();
        let mut violation = trial.defect_sum;
        for _ in 0..4 {
            let step = sweep.solve(gradients, &defects);
            let length = self.fences.longest_step(&self.iterate.nodes, &step, tau);
            let nodes = self.iterate.nodes.advanced(&step, length);
            let (merit, evaluation) = self.merit_at(&nodes);
            match filter.judge(from, merit, alpha, slope) {
                Verdict::Rejected => {}
                verdict => {
                    if verdict == Verdict::Violation {
                        filter.add(from);
                    }
                    return Some((nodes, step, length));
                }
            }
            if !(evaluation.defect_sum <= 0.99 * violation) {
                return None;
            }
            violation = evaluation.defect_sum;
            for (d, e) in defects.iter_mut().zip(&evaluation.defects) {
                *d = *d * length + e;
            }
        }
        None
    }

    fn accept(&mut self, nodes: Nodes<NX, NU>, step: &Step<NX, NU>, alpha: f64, tau: f64) {
        let (it, f, n, mu) = (&mut self.iterate, &self.fences, self.problem.intervals, self.mu);
        let mut d_x = vec![BoundDuals::zero(); n + 1];
        let mut d_u = vec![BoundDuals::zero(); n + 1];
        let mut d_w = vec![BoundDuals::zero(); n];
        let mut dual_alpha = 1.0f64;
        for k in 1..=n {
            d_u[k] = f.u.dual_step(&it.nodes.u[k], &step.u[k], &it.z_u[k], mu);
            d_w[k - 1] = f.w.dual_step(&move_out(&it.nodes, k - 1), &step.w[k - 1], &it.z_w[k - 1], mu);
            dual_alpha = dual_alpha.min(longest_dual_step(&it.z_u[k], &d_u[k], tau));
            dual_alpha = dual_alpha.min(longest_dual_step(&it.z_w[k - 1], &d_w[k - 1], tau));
            if f.on_state {
                d_x[k] = f.at(k).dual_step(&it.nodes.x[k], &step.x[k], &it.z_x[k], mu);
                dual_alpha = dual_alpha.min(longest_dual_step(&it.z_x[k], &d_x[k], tau));
            }
        }
        for (lambda, new) in it.lambda.iter_mut().zip(&step.lambda) {
            *lambda += (new - *lambda) * alpha;
        }
        it.nodes = nodes;
        for k in 1..=n {
            let w = move_out(&it.nodes, k - 1);
            it.z_u[k].lo += d_u[k].lo * dual_alpha;
            it.z_u[k].hi += d_u[k].hi * dual_alpha;
            it.z_w[k - 1].lo += d_w[k - 1].lo * dual_alpha;
            it.z_w[k - 1].hi += d_w[k - 1].hi * dual_alpha;
            f.u.tame(&it.nodes.u[k], &mut it.z_u[k], mu);
            f.w.tame(&w, &mut it.z_w[k - 1], mu);
            if f.on_state {
                it.z_x[k].lo += d_x[k].lo * dual_alpha;
                it.z_x[k].hi += d_x[k].hi * dual_alpha;
                f.at(k).tame(&it.nodes.x[k], &mut it.z_x[k], mu);
            }
        }
        self.step_length = alpha;
    }

    /// Keeps the point if it is the best so far: feasible with the least cost, else the least infeasible.
    fn remember(&mut self, now: &Evaluation<NX>) {
        if !now.is_finite() {
            return;
        }
        let feasible = 1e-6f64.max(self.options.tolerance);
        let better = self.best.as_ref().is_none_or(|best| {
            if now.defect_max <= feasible && best.defect_max <= feasible {
                now.objective < best.objective
            } else {
                now.defect_max < best.defect_max
            }
        });
        if better {
            self.best = Some(Best {
                iterate: self.iterate.clone(),
                objective: now.objective,
                defect_max: now.defect_max,
            });
        }
    }

    fn finish(self, status: Status, now: &Evaluation<NX>, residuals: Residuals) -> Solution<NX, NU> {
        Solution {
            status,
            objective: now.objective,
            defect_max: now.defect_max,
            kkt_residual: residuals.dual,
            complementarity: residuals.complementarity,
            iterate: self.iterate,
            work: self.work,
        }
    }

    fn finish_with_best(mut self, status: Status) -> Solution<NX, NU> {
        if let Some(best) = self.best.take() {
            self.iterate = best.iterate;
        }
        let (linearised, now) = self.problem.linearise(&self.iterate.nodes);
        let gradient = self.lagrangian_gradient(&linearised);
        let residuals = self.residuals(&gradient, &now, 0.0);
        self.finish(status, &now, residuals)
    }
}

fn diagonal<const N: usize>(d: &SVector<f64, N>) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|i, j| if i == j { d[i] } else { 0.0 })
}

fn slope_of<const NX: usize, const NU: usize>(
    gradients: &[NodeGradient<NX, NU>],
    step: &Step<NX, NU>,
) -> f64 {
    let nodes = gradients.iter().zip(step.x.iter().zip(&step.u));
    let by_nodes = nodes.fold(0.0, |sum, (g, (x, u))| sum + g.x.dot(x) + g.u.dot(u));
    gradients.iter().zip(&step.w).fold(by_nodes, |sum, (g, w)| sum + g.w.dot(w))
}
