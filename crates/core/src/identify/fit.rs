//! Output error: parameters by damped Gauss-Newton steps over all stretches, each stretch's own unknowns
//! eliminated by a Schur complement, and the errors of what was found by clusters of stretches.
//!
//! With the gradients of all residuals along shared unknowns `a` and a stretch's own `c`, the stretch says
//! `[A B; B' C] [da; dc] = [ga; gc]`, and to the shared ones `(A - B C^-1 B') da = ga - B C^-1 gc`.
//! Residuals along a stretch hang together, so that the inverse of the sum of these is too small a
//! covariance by several times; what each cluster of stretches adds to the sum says how large it is.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::course::{Course, MEASURED};
use super::motion::{Air, DIRECTIONS, Flown, LOCAL, LOCAL_WIND, Steep, fly, measured};
use super::parameter::{PARAMETERS, Parameter};
use super::rotors::{Spin, spins};
use crate::model::Vehicle;

/// What belongs to a flight alone: biases of gyroscope and accelerometer, mean wind.
pub(super) const FLIGHT: usize = 9;
/// How far these may be off zero, as standard deviations [rad/s, m/s^2, m/s].
const FLIGHT_WIDE: [f64; FLIGHT] = [0.05, 0.05, 0.05, 0.5, 0.5, 0.5, 5.0, 5.0, 0.05];
/// How far a stretch's beginning may be off what was logged [rad, m/s, rad/s].
const LOCAL_WIDE: [f64; LOCAL_WIND] = [0.1, 0.1, 0.1, 0.5, 0.5, 0.5, 0.3, 0.3, 0.3];
/// Unknowns that stretches of a flight share.
const SHARED: usize = PARAMETERS + FLIGHT;
const UNKNOWNS: usize = SHARED + LOCAL;

/// A stretch whose course hangs on its beginning by more than this [1/s, s, m/s per rad and the like] tells
/// nothing: what noise there was has grown as much. So it is in flow from the side on a body that has no side
/// area, whose drag turns about itself ([`crate::model::BodyAero`]).
const MOST_GROWTH: f64 = 100.0;
/// Residuals further out than this many standard deviations count less.
const OUTLYING: f64 = 3.0;
/// Least standard deviations of residuals [m/s^2, rad/s, rad, m/s].
pub(super) const LEAST_SIGMA: [f64; MEASURED] =
    [0.02, 0.02, 0.02, 0.002, 0.002, 0.002, 0.001, 0.001, 0.001, 0.01, 0.01, 0.01];
/// Standard deviations at first.
const FIRST_SIGMA: [f64; MEASURED] = [0.5, 0.5, 0.5, 0.05, 0.05, 0.05, 0.02, 0.02, 0.02, 0.2, 0.2, 0.2];
/// Wind of a stretch beside its flight's at first, and at least [m/s].
const FIRST_WIND_M_S: f64 = 0.1;
const LEAST_WIND_M_S: f64 = 0.01;
const MOST_WIND_M_S: f64 = 10.0;
/// Air is calm unless more stretches than so many have a wind of their own.
const CALM: f64 = 3.0;
/// Steps towards the winds' standard deviations, at most, and the share by which they move when they stay.
const MOST_WINDS: usize = 200;
const WINDS_STAY: f64 = 0.003;
/// From this component on a velocity is looked at, an estimate: values within such a time say no more than
/// one [s], also where they look as if they did. What it wanders by would be taken for wind.
const VELOCITY: usize = 9;
const LASTS_S: f64 = 0.2;
/// Lags over which residuals may hang together, and most that it comes to.
const MOST_LAGS: usize = 100;
const MOST_TOGETHER: f64 = 100.0;
/// Stretches of a cluster, where there are enough of them.
const CLUSTER: usize = 3;
const ENOUGH: usize = 45;
/// Share of what is said that a cluster leaves to the others, at least: it may say all that there is.
const LEAST_LEFT: f64 = 1e-4;
/// Degrees of freedom of an error, at least.
const LEAST_FREEDOM: f64 = 3.0;

/// Delays that may come out [s]: clocks of a log may be off a little the other way.
const DELAYS_S: [f64; 2] = [-0.02, 0.2];
/// Costs are logarithms of likelihoods: what gains less than this is within the errors of what is found.
const ENOUGH_GAINED: f64 = 0.1;
/// Before weights are renewed this does.
const ROUGHLY: f64 = 3.0;

type Joined = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
type SharedMatrix = SMatrix<f64, SHARED, SHARED>;

/// A flight, and the stretches of it that are fitted.
#[derive(Clone, Debug)]
pub(super) struct Part<'c> {
    pub(super) course: &'c Course,
    pub(super) gravity_m_s2: f64,
    pub(super) stretches: Vec<(usize, usize)>,
}

impl Part<'_> {
    /// How long its stretches last together [s].
    fn length_s(&self) -> f64 {
        let instants = &self.course.instants;
        self.stretches.iter().map(|(from, to)| instants[*to].t_s - instants[*from].t_s).sum()
    }
}

/// Residuals of a stretch, by component; NaN where nothing was measured.
pub(super) type Residuals = Vec<[f64; MEASURED]>;

/// All unknowns, and how large residuals are.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub(super) deviations: [f64; PARAMETERS],
    pub(super) flights: Vec<[f64; FLIGHT]>,
    /// By flight and stretch.
    pub(super) locals: Vec<Vec<[f64; LOCAL]>>,
    pub(super) sigma: [f64; MEASURED],
    /// How many residuals in a row say no more than one.
    pub(super) together: [f64; MEASURED],
    pub(super) wind_sigma_m_s: [f64; 3],
}

/// What is seen of a stretch, along the unknowns that it shares and its own; nothing of one that is lost.
struct Seen {
    flight: usize,
    is_lost: bool,
    joined: Joined,
    gradient: SVector<f64, UNKNOWNS>,
}

/// What a stretch says of the unknowns that it shares, and how its own follow them.
struct Said {
    flight: usize,
    matrix: SharedMatrix,
    gradient: SVector<f64, SHARED>,
    own: SVector<f64, LOCAL>,
    own_by_shared: SMatrix<f64, LOCAL, SHARED>,
    /// Inverse of the stretch's own part.
    own_inverse: SMatrix<f64, LOCAL, LOCAL>,
}

/// What flights say of the unknowns that they share.
pub(super) struct Told {
    pub(super) matrix: DMatrix<f64>,
    /// By how much each cluster of stretches moves the unknowns, and the variance that it adds to each.
    pub(super) moves: Vec<(DVector<f64>, DVector<f64>)>,
    /// By how much an error of what was known before moves them, for each parameter that is looked for.
    pub(super) known: Vec<DVector<f64>>,
    /// By how much an error of each parameter that is held at what was known moves them.
    held: Vec<DVector<f64>>,
}

/// A fit of a vehicle to flights.
pub(super) struct Fit<'f> {
    vehicle: &'f Vehicle,
    parts: &'f [Part<'f>],
    /// Parameters that are looked for.
    free: [bool; PARAMETERS],
    /// Whether a stretch is left out, by flight and stretch: [`MOST_GROWTH`].
    lost: Vec<Vec<bool>>,
    pub(super) state: State,
    pub(super) steps: usize,
}

impl<'f> Fit<'f> {
    /// A fit that begins at deviations.
    pub(super) fn new(vehicle: &'f Vehicle, parts: &'f [Part<'f>], deviations: [f64; PARAMETERS]) -> Self {
        let state = State {
            deviations,
            flights: vec![[0.0; FLIGHT]; parts.len()],
            locals: parts.iter().map(|part| vec![[0.0; LOCAL]; part.stretches.len()]).collect(),
            sigma: FIRST_SIGMA,
            together: [1.0; MEASURED],
            wind_sigma_m_s: [FIRST_WIND_M_S; 3],
        };
        let free = Parameter::ALL.map(|parameter| parameter.is_of(vehicle));
        let lost = parts.iter().map(|part| vec![false; part.stretches.len()]).collect();
        Self { vehicle, parts, free, lost, state, steps: 0 }
    }

    /// Goes on from another fit, of the same flights in other stretches.
    pub(super) fn from(mut self, before: &State) -> Self {
        let State { deviations, flights, sigma, together, .. } = before;
        self.state = State {
            deviations: *deviations,
            flights: flights.clone(),
            sigma: *sigma,
            together: *together,
            wind_sigma_m_s: [FIRST_WIND_M_S; 3],
            ..self.state
        };
        self
    }

    /// Holds a parameter at what was known.
    pub(super) fn hold(&mut self, parameter: Parameter) {
        self.free[parameter as usize] = false;
        self.state.deviations[parameter as usize] = 0.0;
    }

    pub(super) fn is_free(&self, parameter: Parameter) -> bool {
        self.free[parameter as usize]
    }

    /// Gravity where the flights were [m/s^2].
    pub(super) fn gravity_m_s2(&self) -> f64 {
        self.parts.first().map_or(f64::NAN, |part| part.gravity_m_s2)
    }

    fn spins(&self, state: &State) -> Vec<Vec<[Spin; 2]>> {
        self.parts.iter().map(|part| spins(self.vehicle, part.course, &state.deviations)).collect()
    }

    /// Flies a stretch that is not lost, and gives each residual with its component and what the model said
    /// of it.
    fn look<S: Flown>(
        &self,
        state: &State,
        spins: &[Vec<[Spin; 2]>],
        (flight, stretch): (usize, usize),
        mut residual: impl FnMut(usize, f64, S),
        mut row: impl FnMut(),
        value: impl Fn(&S) -> f64,
    ) {
        if self.lost[flight][stretch] {
            return;
        }
        let part = &self.parts[flight];
        let (from, to) = part.stretches[stretch];
        let of_flight = &state.flights[flight];
        let air =
            Air { gravity_m_s2: part.gravity_m_s2, wind_ned_m_s: [of_flight[6], of_flight[7], of_flight[8]] };
        let flown = (&part.course.instants[from..=to], &spins[flight][from..=to]);
        fly(
            self.vehicle,
            flown,
            &air,
            &state.deviations,
            &state.locals[flight][stretch],
            |instant, model| {
                for (component, (seen, model)) in measured(instant).into_iter().zip(model).enumerate() {
                    let bias = match component {
                        0..3 => of_flight[3 + component],
                        3..6 => of_flight[component - 3],
                        _ => 0.0,
                    };
                    if seen.is_finite() {
                        residual(component, seen - value(&model) - bias, model);
                    }
                }
                row();
            },
        );
    }

    /// Weight of a residual, and its cost.
    fn weighed(state: &State, component: usize, residual: f64) -> (f64, f64) {
        let weight = 1.0 / (state.sigma[component] * state.sigma[component] * state.together[component]);
        let out = residual.abs() / (OUTLYING * state.sigma[component]);
        if out <= 1.0 {
            (weight, 0.5 * weight * residual * residual)
        } else {
            (weight / out, weight * residual * residual * (1.0 / out - 0.5 / (out * out)))
        }
    }

    fn local_wide(state: &State) -> [f64; LOCAL] {
        std::array::from_fn(|i| match i.checked_sub(LOCAL_WIND) {
            None => LOCAL_WIDE[i],
            Some(axis) => state.wind_sigma_m_s[axis],
        })
    }

    fn cost(&self, state: &State) -> f64 {
        let spins = self.spins(state);
        let mut cost = 0.0;
        let wide = Self::local_wide(state);
        for flight in 0..self.parts.len() {
            for stretch in 0..self.parts[flight].stretches.len() {
                self.look::<f64>(
                    state,
                    &spins,
                    (flight, stretch),
                    |component, residual, _| cost += Self::weighed(state, component, residual).1,
                    || (),
                    |model| *model,
                );
                cost += prior_cost(&state.locals[flight][stretch], &wide);
            }
            cost += prior_cost(&state.flights[flight], &FLIGHT_WIDE);
        }
        cost + prior_cost(&state.deviations, &Parameter::ALL.map(Parameter::wide))
    }

    /// What is seen of each stretch at the present unknowns.
    fn seen(&self, state: &State) -> Vec<Seen> {
        let spins = self.spins(state);
        let mut all = Vec::new();
        for flight in 0..self.parts.len() {
            for stretch in 0..self.parts[flight].stretches.len() {
                let mut joined = Joined::zeros();
                let mut gradient = SVector::zeros();
                let mut growth: f64 = 0.0;
                self.look::<Steep>(
                    state,
                    &spins,
                    (flight, stretch),
                    |component, residual, model| {
                        let weight = Self::weighed(state, component, residual).0;
                        add(&mut joined, &mut gradient, component, weight, residual, &model.slope);
                        let by_beginning = &model.slope[PARAMETERS..PARAMETERS + LOCAL_WIND];
                        growth = by_beginning.iter().fold(growth, |most, slope| most.max(slope.abs()));
                    },
                    || (),
                    |model| model.value,
                );
                let is_lost = self.lost[flight][stretch] || !(growth <= MOST_GROWTH);
                if is_lost {
                    (joined, gradient) = (Joined::zeros(), SVector::zeros());
                }
                joined.fill_upper_triangle_with_lower_triangle();
                all.push(Seen { flight, is_lost, joined, gradient });
            }
        }
        all
    }

    /// What each stretch says, with what was known before of its own unknowns.
    fn said(state: &State, seen: &[Seen]) -> Vec<Said> {
        let wide = Self::local_wide(state);
        let of = |(Seen { flight, joined, gradient, .. }, local): (&Seen, &[f64; LOCAL])| {
            let (mut joined, mut gradient) = (*joined, *gradient);
            for (i, (value, wide)) in local.iter().zip(&wide).enumerate() {
                let per = 1.0 / (wide * wide);
                joined[(SHARED + i, SHARED + i)] += per;
                gradient[SHARED + i] -= per * value;
            }
            eliminated(*flight, &joined, &gradient)
        };
        seen.iter().zip(state.locals.iter().flatten()).filter_map(of).collect()
    }

    /// The sum of what is said, with what was known before: matrix and gradient of all shared unknowns, but
    /// for what is held.
    fn sum(&self, state: &State, said: &[Said]) -> (DMatrix<f64>, DVector<f64>) {
        let (mut matrix, mut gradient) = self.whole_sum(state, said);
        self.without_held(&mut matrix, &mut gradient, 1.0);
        (matrix, gradient)
    }

    /// That sum with what is held in it.
    fn whole_sum(&self, state: &State, said: &[Said]) -> (DMatrix<f64>, DVector<f64>) {
        let n = PARAMETERS + FLIGHT * self.parts.len();
        let (mut matrix, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
        said.iter().for_each(|one| one.add_to(&mut matrix, &mut gradient));
        let known = Parameter::ALL.map(Parameter::wide).into_iter().zip(state.deviations);
        let flights = state.flights.iter().flat_map(|flight| FLIGHT_WIDE.into_iter().zip(*flight));
        for (i, (wide, value)) in known.chain(flights).enumerate() {
            matrix[(i, i)] += 1.0 / (wide * wide);
            gradient[i] -= value / (wide * wide);
        }
        (matrix, gradient)
    }

    /// Leaves out what is held, with so much in its place.
    fn without_held(&self, matrix: &mut DMatrix<f64>, gradient: &mut DVector<f64>, alone: f64) {
        for i in (0..PARAMETERS).filter(|i| !self.free[*i]) {
            matrix.row_mut(i).fill(0.0);
            matrix.column_mut(i).fill(0.0);
            matrix[(i, i)] = alone;
            gradient[i] = 0.0;
        }
    }

    /// Steps until nothing gets better, then looks how large residuals and gusts are; so often.
    pub(super) fn run(&mut self, rounds: usize, steps: usize) {
        for _ in 0..rounds {
            self.descend(steps, ROUGHLY);
            self.measure();
        }
        self.descend(steps, ENOUGH_GAINED);
    }

    /// Lets stretches begin as they did, with a vehicle as it is.
    pub(super) fn predict(&mut self, deviations: [f64; PARAMETERS]) {
        let free = std::mem::replace(&mut self.free, [false; PARAMETERS]);
        self.state.deviations = deviations;
        self.descend(2, ENOUGH_GAINED);
        self.free = free;
    }

    /// Leaves out what is lost from now on; whether there is any that was not before.
    fn loses(&mut self, seen: &[Seen]) -> bool {
        let mut any = false;
        for (lost, seen) in self.lost.iter_mut().flatten().zip(seen) {
            any |= seen.is_lost && !*lost;
            *lost = seen.is_lost;
        }
        any
    }

    /// How many stretches are left out.
    pub(super) fn lost(&self) -> usize {
        self.lost.iter().flatten().filter(|lost| **lost).count()
    }

    fn descend(&mut self, steps: usize, enough: f64) {
        let mut damping = 1e-4;
        let mut cost = self.cost(&self.state);
        for _ in 0..steps {
            let seen = self.seen(&self.state);
            if self.loses(&seen) {
                cost = self.cost(&self.state);
            }
            let said = Self::said(&self.state, &seen);
            if said.len() != self.state.locals.iter().flatten().count() {
                return;
            }
            let (matrix, gradient) = self.sum(&self.state, &said);
            self.steps += 1;
            let mut better = None;
            for _ in 0..6 {
                let mut damped = matrix.clone();
                for i in 0..damped.nrows() {
                    damped[(i, i)] *= 1.0 + damping;
                }
                let step = damped.cholesky().map(|root| root.solve(&gradient));
                let Some(step) = step else { break };
                let next = self.moved(&said, &step);
                let there = self.cost(&next);
                if there < cost {
                    better = Some((next, there));
                    damping = (0.1 * damping).max(1e-9);
                    break;
                }
                damping = (10.0 * damping).max(1e-3);
            }
            let Some((next, there)) = better else { return };
            let gained = cost - there;
            (self.state, cost) = (next, there);
            if gained < enough {
                return;
            }
        }
    }

    /// The unknowns after a step of the shared ones.
    fn moved(&self, said: &[Said], step: &DVector<f64>) -> State {
        let mut next = self.state.clone();
        for (i, deviation) in next.deviations.iter_mut().enumerate() {
            // A step that goes far goes wrong.
            *deviation += step[i].clamp(-0.7, 0.7);
        }
        let delay_s = &mut next.deviations[Parameter::Delay as usize];
        *delay_s = delay_s.clamp(DELAYS_S[0], DELAYS_S[1]);
        for (flight, unknowns) in next.flights.iter_mut().enumerate() {
            for (i, value) in unknowns.iter_mut().enumerate() {
                *value += step[place(flight, PARAMETERS + i)];
            }
        }
        let locals = next.locals.iter_mut().flatten();
        for (local, one) in locals.zip(said) {
            let shared = SVector::<f64, SHARED>::from_fn(|i, _| step[place(one.flight, i)]);
            let own = one.own - one.own_by_shared * shared;
            local.iter_mut().zip(own.iter()).for_each(|(value, step)| *value += step);
        }
        next
    }

    /// Residuals of each stretch.
    pub(super) fn residuals(&self) -> Vec<Residuals> {
        let spins = self.spins(&self.state);
        let mut all = Vec::new();
        for flight in 0..self.parts.len() {
            for stretch in 0..self.parts[flight].stretches.len() {
                let rows = std::cell::RefCell::new(vec![[f64::NAN; MEASURED]]);
                self.look::<f64>(
                    &self.state,
                    &spins,
                    (flight, stretch),
                    |component, residual, _| {
                        if let Some(row) = rows.borrow_mut().last_mut() {
                            row[component] = residual;
                        }
                    },
                    || rows.borrow_mut().push([f64::NAN; MEASURED]),
                    |model| *model,
                );
                let mut rows = rows.into_inner();
                rows.pop();
                all.push(rows);
            }
        }
        all
    }

    /// Looks how large residuals are, how they hang together, and how the wind differs.
    fn measure(&mut self) {
        let residuals = self.residuals();
        let looked_at_s: f64 = self.parts.iter().map(Part::length_s).sum();
        for component in 0..MEASURED {
            let series = || {
                residuals.iter().map(move |rows| {
                    rows.iter().map(|row| row[component]).filter(|x| x.is_finite()).collect::<Vec<f64>>()
                })
            };
            let mut sizes: Vec<f64> = series().flatten().map(f64::abs).collect();
            if sizes.is_empty() {
                continue;
            }
            sizes.sort_by(f64::total_cmp);
            let sigma = 1.4826 * sizes[sizes.len() / 2];
            self.state.sigma[component] = sigma.max(LEAST_SIGMA[component]);
            let least = if component < VELOCITY { 1.0 } else { LASTS_S * sizes.len() as f64 / looked_at_s };
            self.state.together[component] = together(series()).max(least);
        }
        self.measure_winds();
    }

    /// Looks how far the winds of stretches are off that of their flight: the standard deviations under which
    /// what is seen is likeliest, by MacKay's fixed point (Neural Computation 4, 1992, p. 415), each time
    /// with all unknowns where they would have them. Drag and wind move together: the steps are small.
    fn measure_winds(&mut self) {
        let seen = self.seen(&self.state);
        for _ in 0..MOST_WINDS {
            let said = Self::said(&self.state, &seen);
            let (matrix, gradient) = self.sum(&self.state, &said);
            let step = matrix.cholesky().map(|root| root.solve(&gradient));
            let Some(step) = step.filter(|_| said.len() == seen.len()) else { return };
            let next = self.moved(&said, &step);
            let before = self.state.wind_sigma_m_s;
            for (axis, sigma) in self.state.wind_sigma_m_s.iter_mut().enumerate() {
                let (place, prior) = (LOCAL_WIND + axis, *sigma * *sigma);
                let squares: f64 =
                    next.locals.iter().flatten().map(|local| local[place] * local[place]).sum();
                let told = said.iter().map(|one| (1.0 - one.own_inverse[(place, place)] / prior).max(0.0));
                *sigma = (squares / (told.sum::<f64>() + CALM)).sqrt().clamp(LEAST_WIND_M_S, MOST_WIND_M_S);
            }
            let moved = |(before, after): (&f64, &f64)| (after / before - 1.0).abs();
            if before.iter().zip(&self.state.wind_sigma_m_s).map(moved).fold(0.0, f64::max) < WINDS_STAY {
                break;
            }
        }
    }

    /// Covariance of the parameters, by what clusters of stretches say each by itself, and its degrees of
    /// freedom: as many as clusters that say as much as each other (Satterthwaite), less one. What was known
    /// before is one more of them: where no stretch says anything, it is all there is. So is what is held: a
    /// number that follows it is known as badly.
    pub(super) fn covariance(&self) -> (DMatrix<f64>, [f64; PARAMETERS]) {
        let Told { matrix, moves, known, held } = self.told();
        let mut covariance = DMatrix::zeros(PARAMETERS, PARAMETERS);
        for moved in moves.iter().map(|(moved, _)| moved).chain(&known).chain(&held) {
            let moved = moved.rows(0, PARAMETERS);
            covariance += moved * moved.transpose();
        }
        let freedom = |i: usize| {
            let (sum, squares) =
                moves.iter().fold((0.0, 0.0), |(sum, squares), (_, v)| (sum + v[i], squares + v[i] * v[i]));
            if squares > 0.0 { (sum * sum / squares - 1.0).max(LEAST_FREEDOM) } else { LEAST_FREEDOM }
        };
        (no_sharper(covariance, matrix), std::array::from_fn(freedom))
    }

    /// What is said of all shared unknowns, and by how much each cluster of stretches moves them: by Bell and
    /// McCaffrey's bias-reduced linearisation (Survey Methodology 28, 2002, p. 169), since a manoeuvre that
    /// alone tells a number takes a large part of it, and leaves little of its own error over.
    pub(super) fn told(&self) -> Told {
        let said = Self::said(&self.state, &self.seen(&self.state));
        let (whole, _) = self.whole_sum(&self.state, &said);
        let mut matrix = whole.clone();
        let n = matrix.nrows();
        self.without_held(&mut matrix, &mut DVector::zeros(n), 1.0);
        let Some(root) = matrix.clone().cholesky().map(|root| root.unpack()) else {
            return Told { matrix, moves: Vec::new(), known: Vec::new(), held: Vec::new() };
        };
        // In coordinates in which all that is said is a unit matrix.
        let inner =
            |x: &DMatrix<f64>| root.solve_lower_triangular(x).unwrap_or_else(|| DMatrix::zeros(n, x.ncols()));
        let outer = |x: &DMatrix<f64>| {
            root.tr_solve_lower_triangular(x).unwrap_or_else(|| DMatrix::zeros(n, x.ncols()))
        };
        let size = if said.len() >= ENOUGH { CLUSTER } else { 1 };
        let clusters = said.chunk_by(|a, b| a.flight == b.flight).flat_map(|flight| flight.chunks(size));
        let moved = |cluster: &[Said]| {
            let (mut own, mut gradient) = (DMatrix::zeros(n, n), DVector::zeros(n));
            cluster.iter().for_each(|one| one.add_to(&mut own, &mut gradient));
            self.without_held(&mut own, &mut gradient, 0.0);
            let part = inner(&inner(&own).transpose()).symmetric_eigen();
            let gradient = inner(&DMatrix::from_column_slice(n, 1, gradient.as_slice()));
            let mut along = part.eigenvectors.tr_mul(&gradient);
            for (x, share) in along.iter_mut().zip(&part.eigenvalues) {
                *x /= (1.0 - share).max(LEAST_LEFT).sqrt();
            }
            let back = outer(&part.eigenvectors);
            let variance = back.map(|x| x * x) * &part.eigenvalues;
            ((back * along).column(0).into_owned(), variance)
        };
        let moves = clusters.map(moved).collect();
        let known = (0..PARAMETERS).filter(|i| self.free[*i]).map(|i| {
            let mut gradient = DMatrix::zeros(n, 1);
            gradient[i] = 1.0 / Parameter::ALL[i].wide();
            outer(&inner(&gradient)).column(0).into_owned()
        });
        let known = known.collect();
        let is_held = |i: &usize| !self.free[*i] && Parameter::ALL[*i].is_of(self.vehicle);
        let held = (0..PARAMETERS).filter(is_held).map(|i| {
            let is_free = |j: usize| j >= PARAMETERS || self.free[j];
            let wide = Parameter::ALL[i].wide();
            let gradient =
                DMatrix::from_fn(n, 1, |j, _| if is_free(j) { -wide * whole[(j, i)] } else { 0.0 });
            outer(&inner(&gradient)).column(0).into_owned()
        });
        let held = held.collect();
        Told { matrix, moves, known, held }
    }
}

impl Said {
    /// Adds it to what is said of all shared unknowns.
    fn add_to(&self, matrix: &mut DMatrix<f64>, gradient: &mut DVector<f64>) {
        for i in 0..SHARED {
            gradient[place(self.flight, i)] += self.gradient[i];
            for j in 0..SHARED {
                matrix[(place(self.flight, i), place(self.flight, j))] += self.matrix[(i, j)];
            }
        }
    }
}

/// A covariance with errors that are no smaller than half of those of what was said, of which [`LEAST_SIGMA`]
/// is a part: what moved less than any sensor shows is not known, though all stretches agree on it, since
/// what models leave out is the same in all of them. Half, since residuals that hang together
/// ([`State::together`]) may do so where nothing is told by them. Without end where what was said has none.
pub(super) fn no_sharper(mut covariance: DMatrix<f64>, said: DMatrix<f64>) -> DMatrix<f64> {
    let Some(root) = said.cholesky() else {
        let n = covariance.nrows();
        return DMatrix::from_diagonal_element(n, n, f64::INFINITY);
    };
    let inverse = root.inverse();
    for i in 0..covariance.nrows() {
        let wider = 0.5 * (inverse[(i, i)] / covariance[(i, i)]).sqrt();
        if wider > 1.0 && wider.is_finite() {
            covariance.row_mut(i).scale_mut(wider);
            covariance.column_mut(i).scale_mut(wider);
        }
    }
    covariance
}

/// Place of a shared unknown of a flight among all of them.
fn place(flight: usize, i: usize) -> usize {
    if i < PARAMETERS { i } else { i + FLIGHT * flight }
}

fn prior_cost<const N: usize>(values: &[f64; N], wide: &[f64; N]) -> f64 {
    values.iter().zip(wide).map(|(value, wide)| 0.5 * (value / wide) * (value / wide)).sum()
}

/// Adds a residual with its slopes to the lower triangle of a matrix, and to a gradient.
fn add(
    joined: &mut Joined,
    gradient: &mut SVector<f64, UNKNOWNS>,
    component: usize,
    weight: f64,
    residual: f64,
    slope: &[f64; DIRECTIONS],
) {
    let mut row = [0.0; UNKNOWNS];
    row[..PARAMETERS].copy_from_slice(&slope[..PARAMETERS]);
    match component {
        0..3 => row[PARAMETERS + 3 + component] = 1.0,
        3..6 => row[PARAMETERS + component - 3] = 1.0,
        _ => (),
    }
    row[PARAMETERS + 6..SHARED].copy_from_slice(&slope[PARAMETERS + LOCAL_WIND..]);
    row[SHARED..].copy_from_slice(&slope[PARAMETERS..]);
    for (j, by_j) in row.iter().enumerate() {
        let weighed = weight * by_j;
        if weighed == 0.0 {
            continue;
        }
        gradient[j] += weighed * residual;
        let column = &mut joined.as_mut_slice()[j * UNKNOWNS + j..(j + 1) * UNKNOWNS];
        column.iter_mut().zip(&row[j..]).for_each(|(entry, by_i)| *entry += weighed * by_i);
    }
}

/// What is left of a stretch when its own unknowns are eliminated; `None` where they cannot be.
fn eliminated(flight: usize, joined: &Joined, gradient: &SVector<f64, UNKNOWNS>) -> Option<Said> {
    let shared = joined.fixed_view::<SHARED, SHARED>(0, 0);
    let both = joined.fixed_view::<LOCAL, SHARED>(SHARED, 0);
    let own = joined.fixed_view::<LOCAL, LOCAL>(SHARED, SHARED).into_owned().cholesky()?;
    let own_by_shared = own.solve(&both.into_owned());
    let own_step = own.solve(&gradient.fixed_rows::<LOCAL>(SHARED).into_owned());
    Some(Said {
        flight,
        matrix: shared - both.transpose() * own_by_shared,
        gradient: gradient.fixed_rows::<SHARED>(0) - both.transpose() * own_step,
        own: own_step,
        own_by_shared,
        own_inverse: own.inverse(),
    })
}

/// How many values in a row of series say no more than one: `1 + 2 sum rho_k`.
pub(super) fn together(series: impl Iterator<Item = Vec<f64>> + Clone) -> f64 {
    let square: f64 = series.clone().flatten().map(|x| x * x).sum();
    let count = series.clone().flatten().count() as f64;
    let mut sum = 1.0;
    for lag in 1..=MOST_LAGS {
        let (mut product, mut pairs) = (0.0, 0.0);
        for one in series.clone() {
            for (a, b) in one.iter().zip(one.iter().skip(lag)) {
                product += a * b;
                pairs += 1.0;
            }
        }
        let rho = (product / f64::max(pairs, 1.0)) / (square / count);
        if !(rho > 0.05) {
            break;
        }
        sum += 2.0 * rho;
    }
    sum.min(MOST_TOGETHER)
}
