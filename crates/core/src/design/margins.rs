//! Margins of the cascade's loops on a vehicle in flight: linearised at a state in the vertical plane to the
//! north, with rotors and motors as they are, the latency and the control period's sampling.
//!
//! The states are those of the body, `v_N, v_D`, pitch and `Q` or `v_E`, roll, `P`, heading and `R`; the
//! speed of each rotor; the integrals of the cascade; and commands on their way. Motion in the plane and
//! across it is taken apart, as a vehicle with a plane of symmetry has it. Each loop is broken at one signal
//! while all others stay closed. Away from the target the state is none of rest: the flight is then taken as
//! if it stood still there, as is usual for margins along a path.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::linear_loop::{LinearLoop, Margins, sampled};
use super::operating_point::rotor_speeds;
use crate::control::{Airframe, ControlError, Gains, ThrustCurve, TiltFrom};
use crate::frames::{Quaternion, normalized, pitch, product, quaternion_from_euler};
use crate::math;
use crate::model::rigid_body::{BodyRate, BodyState};
use crate::model::{Environment, MAX_ROTORS, PerRotor, Vehicle};

/// Where each loop is broken: name of the loop, and of the signal. Those of yaw are the last: a vehicle whose
/// rotors make no yaw moment has none.
pub const LOOPS: [(&str, &str); 9] = [
    ("pitch rate", "angular acceleration command"),
    ("pitch", "pitch rate command"),
    ("velocity north", "acceleration command north"),
    ("velocity down", "acceleration command down"),
    ("roll rate", "angular acceleration command"),
    ("roll", "roll rate command"),
    ("velocity east", "acceleration command east"),
    ("yaw rate", "angular acceleration command"),
    ("heading", "yaw rate command"),
];
/// How many of them are in the vertical plane, and how many across it without yaw.
const IN_PLANE: usize = 4;
const WITHOUT_YAW: usize = 7;

/// Name of the state at the release.
pub const RELEASE: &str = "release";
/// Name of the state at the target, the only one that is steady.
pub const TARGET: &str = "target";

/// A state in which loops are linearised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Name of the state: [`RELEASE`], "plan's peak", [`TARGET`].
    pub name: &'static str,
    /// State of the body, in the vertical plane to the north.
    pub body: BodyState,
    /// Thrust of each rotor [N].
    pub thrust_n: PerRotor,
}

/// The loops at a state.
#[derive(Clone, Debug)]
pub struct LoopsAt {
    /// Name of the state.
    pub name: &'static str,
    /// The loops in the order of [`LOOPS`], with their margins.
    pub loops: Vec<(LinearLoop, Margins)>,
}

/// Vehicle, site and controller whose loops are linearised.
#[derive(Clone, Copy, Debug)]
pub struct LoopSetting<'a> {
    /// The vehicle as it flies.
    pub vehicle: &'a Vehicle,
    /// The vehicle as the controller knows it.
    pub known: &'a Vehicle,
    /// The site.
    pub environment: &'a Environment,
    /// Gains of the cascade.
    pub gains: &'a Gains,
    /// What the cascade's tilt comes from.
    pub tilt_from: TiltFrom,
    /// Curve that the cascade takes a rotor's thrust for.
    pub thrust_curve: ThrustCurve,
    /// Control period [s].
    pub period_s: f64,
}

/// Least thrust of a rotor at which its response is taken, as a share of its part of the weight: that of a
/// throttle, a square root, is without bound at zero.
const LEAST_SHARE: f64 = 0.1;

/// The loops at a state.
///
/// # Errors
/// [`ControlError`] when the rotors cannot be controlled.
pub fn loops_at(setting: &LoopSetting<'_>, point: &OperatingPoint) -> Result<LoopsAt, ControlError> {
    let airframe = Airframe::new(setting.known, setting.environment)?.with_thrust_curve(setting.thrust_curve);
    let steers_yaw = allocation(&airframe)[3].iter().any(|share| *share != 0.0);
    let across = if steers_yaw { Motion::AcrossWithYaw } else { Motion::Across };
    let both = [Motion::InPlane, across].into_iter();
    let loops = both.flat_map(|motion| LinearPlant::new(setting, &airframe, point, motion).loops());
    let with_margins = |broken: LinearLoop| {
        let margins = broken.margins();
        (broken, margins)
    };
    Ok(LoopsAt { name: point.name, loops: loops.map(with_margins).collect() })
}

/// Most steps of Newton's method for a steady state.
const STEPS: usize = 30;
/// Rates below which a state is steady [m/s^2, rad/s^2].
const STEADY: f64 = 1e-9;

/// The vehicle as it flies steadily with the velocity of `near`: pitch, lift and moment at which its velocity
/// and its pitch rate stay. Forces of the rotors across their axes, which a planner's trim leaves out, shift
/// it. `None` where no such state is found near by.
///
/// # Errors
/// [`ControlError`] when the rotors cannot be controlled.
pub fn steady_near(
    vehicle: &Vehicle,
    environment: &Environment,
    near: &OperatingPoint,
) -> Result<Option<OperatingPoint>, ControlError> {
    let [per_lift, _, per_moment, _] = allocation(&Airframe::new(vehicle, environment)?);
    let at = |x: &Vector3<f64>| OperatingPoint {
        body: BodyState {
            q_ned_from_body: quaternion_from_euler(0.0, pitch(near.body.q_ned_from_body) + x.x, 0.0),
            omega_body: Vector3::zeros(),
            ..near.body
        },
        thrust_n: std::array::from_fn(|i| near.thrust_n[i] + per_lift[i] * x.y + per_moment[i] * x.z),
        ..*near
    };
    let rates = |x: &Vector3<f64>| {
        let OperatingPoint { body, thrust_n, .. } = at(x);
        let speeds = rotor_speeds(vehicle, environment, &body, &thrust_n);
        let rate = vehicle.powered_derivative(environment, &body, &speeds, &[0.0; MAX_ROTORS], true);
        Vector3::new(rate.body.v_dot_ned.x, rate.body.v_dot_ned.z, rate.body.omega_dot_body.y)
    };
    let weight_n = vehicle.mass.mass_kg * environment.gravity_m_s2;
    let steps = [1e-4, 1e-4 * weight_n, 1e-4 * weight_n];
    let mut x = Vector3::zeros();
    for _ in 0..STEPS {
        let off = rates(&x);
        if off.norm() < STEADY {
            return Ok(Some(at(&x)));
        }
        let slope = Matrix3::from_columns(&std::array::from_fn::<_, 3, _>(|i| {
            let mut aside = Vector3::zeros();
            aside[i] = steps[i];
            (rates(&(x + aside)) - rates(&(x - aside))) / (2.0 * steps[i])
        }));
        match slope.lu().solve(&off) {
            Some(step) if step.iter().all(|s| s.is_finite()) => x -= step,
            _ => return Ok(None),
        }
    }
    Ok(None)
}

/// One of the two motions that a vehicle with a plane of symmetry has apart from each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    /// `v_N, v_D`, rotation about body y, `Q`.
    InPlane,
    /// `v_E`, rotation about body x, `P`.
    Across,
    /// `v_E`, rotation about body x, `P`, rotation about body z, `R`.
    AcrossWithYaw,
}

impl Motion {
    /// Number of states of the body.
    fn states(self) -> usize {
        match self {
            Self::InPlane => 4,
            Self::Across => 3,
            Self::AcrossWithYaw => 5,
        }
    }

    /// Step of each state in which slopes are taken: across a cell of the tables on the mean, for a table's
    /// slope jumps from cell to cell.
    fn step(self, state: usize) -> f64 {
        match (self, state) {
            (Self::InPlane, 0 | 1) | (_, 0) => 0.05,
            (Self::InPlane, 2) | (_, 1 | 3) => 0.01,
            _ => 0.02,
        }
    }

    /// The body with its states off by so much.
    fn moved(self, body: &BodyState, x: &DVector<f64>) -> BodyState {
        let (mut v_ned, mut turn, mut omega_body) = (body.v_ned, Vector3::zeros(), body.omega_body);
        match self {
            Self::InPlane => {
                (v_ned.x, v_ned.z) = (v_ned.x + x[0], v_ned.z + x[1]);
                (turn.y, omega_body.y) = (x[2], omega_body.y + x[3]);
            }
            Self::Across | Self::AcrossWithYaw => {
                v_ned.y += x[0];
                (turn.x, omega_body.x) = (x[1], omega_body.x + x[2]);
                if self == Self::AcrossWithYaw {
                    (turn.z, omega_body.z) = (x[3], omega_body.z + x[4]);
                }
            }
        }
        let q_ned_from_body = normalized(product(body.q_ned_from_body, small_turn(&turn)));
        BodyState { q_ned_from_body, v_ned, omega_body, ..*body }
    }

    /// Rates of the states.
    fn rates(self, rate: &BodyRate, x: &DVector<f64>, pitch_rate: f64) -> Vec<f64> {
        let (v, w) = (&rate.v_dot_ned, &rate.omega_dot_body);
        match self {
            Self::InPlane => vec![v.x, v.z, x[3], w.y],
            Self::Across => vec![v.y, x[2], w.x],
            // A rotation in axes that turn with the body.
            Self::AcrossWithYaw => {
                vec![v.y, x[2] - pitch_rate * x[3], w.x, x[4] + pitch_rate * x[1], w.z]
            }
        }
    }
}

/// A rotation by a small vector [rad].
fn small_turn(turn: &Vector3<f64>) -> Quaternion {
    normalized([1.0, 0.5 * turn.x, 0.5 * turn.y, 0.5 * turn.z])
}

/// A vehicle at a state, its plant sampled in one of its motions.
struct LinearPlant<'a> {
    setting: &'a LoopSetting<'a>,
    airframe: &'a Airframe,
    motion: Motion,
    /// Transition over a period, and what a change of each throttle that is held adds.
    transition: DMatrix<f64>,
    input: DMatrix<f64>,
    /// Throttle of each rotor per newton of its thrust.
    per_newton: Vec<f64>,
    /// Acceleration that the rotors are commanded together [m/s^2]; sine and cosine of the pitch.
    collective: f64,
    sin_cos: (f64, f64),
}

impl<'a> LinearPlant<'a> {
    fn new(
        setting: &'a LoopSetting<'a>,
        airframe: &'a Airframe,
        point: &OperatingPoint,
        motion: Motion,
    ) -> Self {
        let LoopSetting { vehicle, environment, period_s, .. } = *setting;
        let rotors = vehicle.rotors.len();
        let weight_n = vehicle.mass.mass_kg * environment.gravity_m_s2 / rotors.max(1) as f64;
        let thrust_n = point.thrust_n.map(|thrust| thrust.max(LEAST_SHARE * weight_n));
        let speeds = rotor_speeds(vehicle, environment, &point.body, &thrust_n);
        let throttles = holding_throttles(setting, &point.body, &speeds);
        let (a, b) = derivatives(setting, motion, &point.body, &speeds, &throttles);
        let (transition, input) = sampled(&a, &b, period_s);
        let (commanded_n, per_newton): (Vec<f64>, Vec<f64>) =
            throttles[..rotors].iter().map(|u| airframe.mixer.thrust_of(*u)).unzip();
        Self {
            setting,
            airframe,
            motion,
            transition,
            input,
            per_newton,
            collective: commanded_n.iter().sum::<f64>() / vehicle.mass.mass_kg,
            sin_cos: math::sin_cos(pitch(point.body.q_ned_from_body)),
        }
    }

    /// The loops of the motion, each broken at its signal.
    fn loops(&self) -> Vec<LinearLoop> {
        let cuts = match self.motion {
            Motion::InPlane => IN_PLANE,
            Motion::Across => WITHOUT_YAW - IN_PLANE,
            Motion::AcrossWithYaw => LOOPS.len() - IN_PLANE,
        };
        (0..cuts).map(|cut| self.broken_at(cut)).collect()
    }

    fn broken_at(&self, cut: usize) -> LinearLoop {
        let rotors = self.input.ncols();
        let plant = self.motion.states() + rotors;
        let mut rows = Rows::new(plant + INTEGRALS, self.setting, cut);
        let moments = match self.motion {
            Motion::InPlane => self.in_plane(&mut rows, plant),
            Motion::Across | Motion::AcrossWithYaw => self.across(&mut rows, plant),
        };
        // What each command changes of the rotors' throttles, now and where it is on its way.
        let moments = moments.map(|moment| rows.arriving(moment));
        let per_unit = allocation(self.airframe);
        let per_unit = match self.motion {
            Motion::InPlane => [per_unit[0], per_unit[2]],
            Motion::Across | Motion::AcrossWithYaw => [per_unit[1], per_unit[3]],
        };
        let a = &mut rows.a;
        a.view_mut((0, 0), (plant, plant)).copy_from(&self.transition);
        for (i, per_newton) in self.per_newton.iter().enumerate() {
            let thrust = &moments[0] * per_unit[0][i] + &moments[1] * per_unit[1][i];
            let throttle = thrust * *per_newton;
            for r in 0..plant {
                for c in 0..a.ncols() {
                    a[(r, c)] += self.input[(r, i)] * throttle[c];
                }
            }
        }
        rows.broken()
    }

    /// Lift and pitch moment that the cascade commands.
    fn in_plane(&self, rows: &mut Rows, plant: usize) -> [DVector<f64>; 2] {
        let LoopSetting { gains: k, environment, .. } = self.setting;
        let (integral_n, integral_d, integral_q) = (plant, plant + 1, plant + 2);
        let (sin, cos) = self.sin_cos;
        let up = match self.setting.tilt_from {
            TiltFrom::Thrust => self.collective,
            TiltFrom::Gravity => environment.gravity_m_s2,
        };
        let level = -up * sin / cos;
        let squares = up * up + level * level;
        let a_n = rows.cut(2, rows.row(&[(0, -k.k_pvx), (integral_n, 1.0)]));
        let a_d = rows.cut(3, rows.row(&[(1, -k.k_pvz), (integral_d, 1.0)]));
        let (theta_c, lift) = match self.setting.tilt_from {
            // theta_c = atan2(-a_N, up), up = g - a_D
            TiltFrom::Thrust => (&a_n * (-up / squares) - &a_d * (level / squares), -&a_d),
            // theta_c = atan2(-a_N, g), collective = (g - a_D)/cos(theta_c)
            TiltFrom::Gravity => {
                let theta_c = &a_n * (-up / squares);
                let lift = &theta_c * (self.collective * sin / cos) - &a_d / cos;
                (theta_c, lift)
            }
        };
        let rate_c = rows.cut(1, (theta_c - rows.row(&[(2, 1.0)])) * k.k_ptheta);
        let error_q = &rate_c - rows.row(&[(3, 1.0)]);
        let turn = rows.cut(0, &error_q * k.k_pq + rows.row(&[(integral_q, 1.0)]));
        rows.integrate(integral_n, k.k_ivx, rows.row(&[(0, -k.k_ivx)]));
        rows.integrate(integral_d, k.k_ivz, rows.row(&[(1, -k.k_ivz)]));
        rows.integrate(integral_q, k.k_iq, error_q * k.k_iq);
        [lift * self.airframe.mass_kg, turn * self.airframe.inertia_kg_m2[(1, 1)]]
    }

    /// Roll and yaw moment that the cascade commands at the heading north.
    fn across(&self, rows: &mut Rows, plant: usize) -> [DVector<f64>; 2] {
        let LoopSetting { gains: k, environment, .. } = self.setting;
        let (integral_e, integral_p) = (plant, plant + 1);
        let up = match self.setting.tilt_from {
            TiltFrom::Thrust => self.collective,
            TiltFrom::Gravity => environment.gravity_m_s2,
        };
        let a_e = rows.cut(2, rows.row(&[(0, -k.k_pvx), (integral_e, 1.0)]));
        // phi_c = atan2(a_E, hypot(a_N, up))
        let phi_c = &a_e * (self.sin_cos.1 / up);
        let rate_x = rows.cut(1, (phi_c - rows.row(&[(1, 1.0)])) * k.k_ptheta);
        let error_p = &rate_x - rows.row(&[(2, 1.0)]);
        let turn_x = rows.cut(0, &error_p * k.k_pq + rows.row(&[(integral_p, 1.0)]));
        rows.integrate(integral_e, k.k_ivx, rows.row(&[(0, -k.k_ivx)]));
        rows.integrate(integral_p, k.k_iq, error_p * k.k_iq);
        let turn_z = if self.motion == Motion::AcrossWithYaw {
            let rate_z = rows.cut(4, rows.row(&[(3, -k.k_ppsi)]));
            rows.cut(3, (rate_z - rows.row(&[(4, 1.0)])) * k.k_pr)
        } else {
            rows.row(&[])
        };
        let inertia = &self.airframe.inertia_kg_m2;
        [
            &turn_x * inertia[(0, 0)] + &turn_z * inertia[(0, 2)],
            &turn_x * inertia[(2, 0)] + &turn_z * inertia[(2, 2)],
        ]
    }
}

/// Most integrals of the cascade in one of the motions.
const INTEGRALS: usize = 3;

/// Rows of a closed loop over its states and, last, the signal at the cut.
struct Rows {
    a: DMatrix<f64>,
    out: DVector<f64>,
    cut: usize,
    period_s: f64,
    /// First of the states that hold commands of earlier periods, and of those the next that is free.
    next: usize,
    /// Whole periods and the part of a further one that commands are on their way, and how many earlier ones
    /// there are.
    late: (usize, f64, usize),
}

impl Rows {
    /// Rows over `own` states and those that hold two commands while they are on their way.
    fn new(own: usize, setting: &LoopSetting<'_>, cut: usize) -> Self {
        let periods = setting.vehicle.latency_s / setting.period_s;
        let (whole, part) = (periods.floor(), periods.fract());
        let earlier = if part > 0.0 { whole + 1.0 } else { whole } as usize;
        let all = own + 2 * earlier;
        let (a, out) = (DMatrix::zeros(all, all + 1), DVector::zeros(all + 1));
        Self { a, out, cut, period_s: setting.period_s, next: own, late: (whole as usize, part, earlier) }
    }

    fn row(&self, entries: &[(usize, f64)]) -> DVector<f64> {
        let mut row = DVector::zeros(self.out.len());
        entries.iter().for_each(|&(i, x)| row[i] += x);
        row
    }

    /// A command as the loop goes on with it: the signal that comes in, where it is broken there.
    fn cut(&mut self, which: usize, command: DVector<f64>) -> DVector<f64> {
        if which != self.cut {
            return command;
        }
        self.out = command;
        self.row(&[(self.out.len() - 1, 1.0)])
    }

    /// An integral with its rate. Without a gain it stays zero, and is no state that would have to die away.
    fn integrate(&mut self, integral: usize, gain: f64, rate: DVector<f64>) {
        for c in 0..self.out.len() {
            self.a[(integral, c)] += self.period_s * rate[c];
        }
        self.a[(integral, integral)] += if gain == 0.0 { 0.0 } else { 1.0 };
    }

    /// What of a command arrives, whose earlier values become states.
    fn arriving(&mut self, command: DVector<f64>) -> DVector<f64> {
        let (whole, part, earlier) = self.late;
        let before = self.next;
        self.next += earlier;
        let given: Vec<DVector<f64>> = std::iter::once(command)
            .chain((0..earlier).map(|back| self.row(&[(before + back, 1.0)])))
            .collect();
        (0..earlier).for_each(|back| self.a.set_row(before + back, &given[back].transpose()));
        let older = given.get(whole + 1).map_or_else(|| self.row(&[]), Clone::clone);
        &given[whole] * (1.0 - part) + older * part
    }

    fn broken(self) -> LinearLoop {
        let all = self.a.nrows();
        LinearLoop {
            b: self.a.column(all).into_owned(),
            a: self.a.columns(0, all).into_owned(),
            c: self.out.rows(0, all).into_owned(),
            period_s: self.period_s,
        }
    }
}

/// Thrust of each rotor per newton of lift, and per newton metre of roll, pitch and yaw moment, well within
/// its limits.
fn allocation(airframe: &Airframe) -> [PerRotor; 4] {
    let half_n = 0.5 * airframe.lift_max_n;
    let small = 1e-3;
    let moment_nm = small * half_n;
    let slope = |more: PerRotor, less: PerRotor, step: f64| -> PerRotor {
        std::array::from_fn(|i| (more[i] - less[i]) / (2.0 * step))
    };
    let lift = |by: f64| airframe.mixer.thrusts(half_n * (1.0 + by), &Vector3::zeros());
    let of_moment = |axis: usize| {
        let moment = |by: f64| {
            let mut moment = Vector3::zeros();
            moment[axis] = by * moment_nm;
            airframe.mixer.thrusts(half_n, &moment)
        };
        slope(moment(1.0), moment(-1.0), moment_nm)
    };
    let of_lift = slope(lift(small), lift(-small), small * half_n);
    [of_lift, of_moment(0), of_moment(1), of_moment(2)]
}

/// The throttle at which each rotor keeps its speed, from 0.02 to 1.
fn holding_throttles(setting: &LoopSetting<'_>, body: &BodyState, speeds: &PerRotor) -> PerRotor {
    let LoopSetting { vehicle, environment, .. } = *setting;
    let (mut low, mut high) = ([0.02; MAX_ROTORS], [1.0; MAX_ROTORS]);
    for _ in 0..40 {
        let middle: PerRotor = std::array::from_fn(|i| 0.5 * (low[i] + high[i]));
        let rate = vehicle.powered_derivative(environment, body, speeds, &middle, false);
        for i in 0..vehicle.rotors.len() {
            let end = if rate.rotor_acceleration[i] < 0.0 { &mut low[i] } else { &mut high[i] };
            *end = middle[i];
        }
    }
    std::array::from_fn(|i| 0.5 * (low[i] + high[i]))
}

/// Derivatives of the states' rates by the states and by the throttles, by central differences.
fn derivatives(
    setting: &LoopSetting<'_>,
    motion: Motion,
    body: &BodyState,
    speeds: &PerRotor,
    throttles: &PerRotor,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let LoopSetting { vehicle, environment, .. } = *setting;
    let (rotors, states) = (vehicle.rotors.len(), motion.states());
    let n = states + rotors;
    let rates = |x: &DVector<f64>, u: &PerRotor| -> DVector<f64> {
        let mut turning = *speeds;
        (0..rotors).for_each(|i| turning[i] += x[states + i]);
        let moved = motion.moved(body, x);
        let rate = vehicle.powered_derivative(environment, &moved, &turning, u, false);
        let of_body = motion.rates(&rate.body, x, body.omega_body.y);
        DVector::from_iterator(
            n,
            of_body.into_iter().chain(rate.rotor_acceleration[..rotors].iter().copied()),
        )
    };
    let step = |i: usize| match i.checked_sub(states) {
        Some(rotor) => 0.01 * speeds[rotor].max(1.0),
        None => motion.step(i),
    };
    let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, rotors));
    for i in 0..n {
        let mut x = DVector::zeros(n);
        x[i] = step(i);
        let slope = (rates(&x, throttles) - rates(&-&x, throttles)) / (2.0 * step(i));
        a.set_column(i, &slope);
    }
    for i in 0..rotors {
        let with = |by: f64| {
            let mut u = *throttles;
            u[i] += by;
            rates(&DVector::zeros(n), &u)
        };
        // Within the throttle's range.
        let step = 0.005f64.min(0.5 * (1.0 - throttles[i])).max(1e-6);
        b.set_column(i, &((with(step) - with(-step)) / (2.0 * step)));
    }
    (a, b)
}

#[cfg(test)]
mod tests {
    use nalgebra::Complex;

    use super::*;
    use crate::control::test_vehicles::{ARM_M, GRAVITY_M_S2, J_YY, MASS_KG, quadrotor, site};
    use crate::frames::LEVEL;
    use crate::model::VehicleOptions;

    #[test]
    fn closed_form_steady_hover_carries_the_weight() {
        let vehicle = quadrotor([ARM_M, 1.1], [620.0, J_YY, 1160.0], [0.0; 3], VehicleOptions::default());
        let body = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: quaternion_from_euler(0.0, 0.1, 0.0),
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
        };
        let near = OperatingPoint {
            name: "hover",
            body,
            thrust_n: [0.8 * MASS_KG * GRAVITY_M_S2 / 4.0; MAX_ROTORS],
        };
        let found = steady_near(&vehicle, &site(), &near).unwrap().unwrap();
        assert!(pitch(found.body.q_ned_from_body).abs() < 1e-9);
        let wanted = MASS_KG * GRAVITY_M_S2 / 4.0;
        assert!(found.thrust_n[..4].iter().all(|thrust| (thrust / wanted - 1.0).abs() < 1e-8), "{found:?}");
    }

    /// Hover without air: `J Q' = M` and `m v_D' = -T` behind rotors that follow with a lag of 0.15 s, the
    /// inverse of the mean rate of speeding up and slowing down. `L = K_pq (s + K_ptheta)/s^2/(1 + 0.15 s)`
    /// of the pitch and roll rate and `L = K_pvz/s/(1 + 0.15 s)` downwards; sampling delays by half a period,
    /// and the latency comes on top. The gain of the velocity north is so small that it changes no loop, and
    /// lets that velocity die away.
    #[test]
    fn closed_form_loops_of_a_hover_without_air() {
        let options = VehicleOptions { reaction_torque: false, rotor_momentum: false };
        // Seven and a half periods.
        use ThrustCurve::{Linear, Quadratic};
        for (tilt_from, thrust_curve, latency_s) in [
            (TiltFrom::Thrust, Quadratic, 0.0),
            (TiltFrom::Gravity, Quadratic, 0.0),
            (TiltFrom::Thrust, Quadratic, 0.015),
            (TiltFrom::Gravity, Linear, 0.0),
        ] {
            let vehicle = quadrotor([ARM_M, 1.1], [620.0, J_YY, 1160.0], [0.0; 3], options);
            let vehicle = Vehicle { latency_s, ..vehicle };
            are_those_of_a_hover(&vehicle, tilt_from, thrust_curve);
        }
    }

    /// With a linear throttle a rotor at hover makes two newtons of one that is wanted more, T^2/T_hover.
    fn are_those_of_a_hover(vehicle: &Vehicle, tilt_from: TiltFrom, thrust_curve: ThrustCurve) {
        let gains = Gains::longitudinal([4.0, 0.0, 1.5, 2.0, 0.0, 3e-4, 0.0]);
        let (environment, period_s) = (site(), 0.002);
        let setting = LoopSetting {
            vehicle,
            known: vehicle,
            environment: &environment,
            gains: &gains,
            tilt_from,
            thrust_curve,
            period_s,
        };
        let body = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: LEVEL,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
        };
        let thrust_n = [MASS_KG * GRAVITY_M_S2 / 4.0; MAX_ROTORS];
        let at = loops_at(&setting, &OperatingPoint { name: "hover", body, thrust_n }).unwrap();
        for omega in [0.5, 3.0, 20.0] {
            let s = Complex::new(0.0, omega);
            let one = Complex::new(1.0, 0.0);
            let (sin, cos) = math::sin_cos(-omega * (0.5 * period_s + vehicle.latency_s));
            let slope = if thrust_curve == ThrustCurve::Linear { 2.0 } else { 1.0 };
            let lag = Complex::new(cos, sin) / (one + s * 0.15) * slope;
            let turning = (s + 1.5) * 4.0 / (s * s) * lag;
            let wanted = [(0usize, turning), (4, turning), (3, one * 2.0 / s * lag)];
            for (i, wanted) in wanted {
                let found = at.loops[i].0.response(omega);
                let off = found - wanted;
                let share = math::hypot(off.re, off.im) / math::hypot(wanted.re, wanted.im);
                assert!(share < 2e-3, "loop {i} at {omega}: {found} for {wanted}");
            }
        }
        // Without reaction torques nothing turns it about its axis.
        assert!(at.loops.len() == WITHOUT_YAW && at.loops.iter().all(|(_, margins)| margins.stable));
    }
}
