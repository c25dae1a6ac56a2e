//! Margins of the cascade's loops on a vehicle in flight: linearised in the vertical plane at a state, with
//! rotors and motors as they are and the control period's sampling.
//!
//! The states are `v_N, v_D, theta, Q`, the speed of each rotor, and the integrals of the cascade. Each loop
//! is broken at one signal while all others stay closed. Away from the target the state is none of rest: the
//! flight is then taken as if it stood still there, as is usual for margins along a path.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::linear_loop::{LinearLoop, Margins, sampled};
use super::operating_point::rotor_speeds;
use crate::control::{Airframe, ControlError, Gains, TiltFrom};
use crate::frames::{pitch, quaternion_from_euler};
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::{Environment, MAX_ROTORS, PerRotor, Vehicle};

/// Where each loop is broken: name of the loop, and of the signal.
pub const LOOPS: [(&str, &str); 4] = [
    ("pitch rate", "angular acceleration command"),
    ("pitch", "pitch rate command"),
    ("velocity north", "acceleration command north"),
    ("velocity down", "acceleration command down"),
];

/// A state in which loops are linearised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OperatingPoint {
    /// Name of the state: "release", "plan's peak", "target".
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
    /// The vehicle.
    pub vehicle: &'a Vehicle,
    /// The site.
    pub environment: &'a Environment,
    /// Gains of the cascade.
    pub gains: &'a Gains,
    /// What the cascade's tilt comes from.
    pub tilt_from: TiltFrom,
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
    let airframe = Airframe::new(setting.vehicle, setting.environment)?;
    let cut = |signal: usize| {
        let broken = linearised(setting, &airframe, point, signal);
        let margins = broken.margins();
        (broken, margins)
    };
    Ok(LoopsAt { name: point.name, loops: (0..LOOPS.len()).map(cut).collect() })
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
    let (per_lift, per_moment) = allocation(&Airframe::new(vehicle, environment)?);
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

/// Number of states of the body in the plane.
const BODY: usize = 4;
/// Number of integrals of the cascade: velocity north and down, pitch rate.
const INTEGRALS: usize = 3;

fn linearised(
    setting: &LoopSetting<'_>,
    airframe: &Airframe,
    point: &OperatingPoint,
    signal: usize,
) -> LinearLoop {
    let LoopSetting { vehicle, environment, gains: k, period_s, .. } = *setting;
    let rotors = vehicle.rotors.len();
    let weight_n = vehicle.mass.mass_kg * environment.gravity_m_s2 / rotors.max(1) as f64;
    let thrust_n = point.thrust_n.map(|thrust| thrust.max(LEAST_SHARE * weight_n));
    let speeds = rotor_speeds(vehicle, environment, &point.body, &thrust_n);
    let throttles = holding_throttles(setting, &point.body, &speeds);
    let (f, g) = {
        let (a, b) = derivatives(setting, &point.body, &speeds, &throttles);
        sampled(&a, &b, period_s)
    };

    let (plant, own) = (BODY + rotors, BODY + rotors + INTEGRALS);
    let (integral_n, integral_d, integral_q) = (plant, plant + 1, plant + 2);
    // Commands of earlier periods, of which the last ones are on their way: lifts, then moments.
    let periods = vehicle.latency_s / period_s;
    let (whole, part) = (periods.floor(), periods.fract());
    let earlier = if part > 0.0 { whole + 1.0 } else { whole } as usize;
    let whole = whole as usize;
    let all = own + 2 * earlier;
    // Rows over the states and, last, the signal at the cut.
    let row = |entries: &[(usize, f64)]| {
        let mut row = DVector::<f64>::zeros(all + 1);
        entries.iter().for_each(|&(i, x)| row[i] += x);
        row
    };
    let at_cut = row(&[(all, 1.0)]);
    let mut out = DVector::zeros(all + 1);
    let mut broken = |which: usize, command: DVector<f64>| {
        if which == signal {
            out = command;
            at_cut.clone()
        } else {
            command
        }
    };
    let limit_n = airframe.mixer.thrust_limit_n();
    let commanded_n: Vec<f64> = throttles[..rotors].iter().map(|u| u * u * limit_n).collect();
    let collective = commanded_n.iter().sum::<f64>() / vehicle.mass.mass_kg;
    let (sin, cos) = math::sin_cos(pitch(point.body.q_ned_from_body));
    let up = match setting.tilt_from {
        TiltFrom::Thrust => collective,
        TiltFrom::Gravity => environment.gravity_m_s2,
    };
    let level = -up * sin / cos;

    let a_n = broken(2, row(&[(0, -k.k_pvx), (integral_n, 1.0)]));
    let a_d = broken(3, row(&[(1, -k.k_pvz), (integral_d, 1.0)]));
    let squares = up * up + level * level;
    let (theta_c, lift) = match setting.tilt_from {
        // theta_c = atan2(-a_N, up), up = g - a_D
        TiltFrom::Thrust => (&a_n * (-up / squares) - &a_d * (level / squares), -&a_d),
        // theta_c = atan2(-a_N, g), collective = (g - a_D)/cos(theta_c)
        TiltFrom::Gravity => {
            let theta_c = &a_n * (-up / squares);
            let lift = &theta_c * (collective * sin / cos) - &a_d / cos;
            (theta_c, lift)
        }
    };
    let rate_c = broken(1, (theta_c - row(&[(2, 1.0)])) * k.k_ptheta);
    let error_q = &rate_c - row(&[(3, 1.0)]);
    let turn = broken(0, &error_q * k.k_pq + row(&[(integral_q, 1.0)]));

    let lift = lift * airframe.mass_kg;
    let moment = turn * airframe.inertia_kg_m2[(1, 1)];
    let (per_lift, per_moment) = allocation(airframe);
    let mut a = DMatrix::zeros(all, all + 1);
    a.view_mut((0, 0), (plant, plant)).copy_from(&f);
    let [lift, moment] = [(lift, own), (moment, own + earlier)].map(|(now, before)| {
        let given = |back: usize| match back {
            0 => now.clone(),
            back if back <= earlier => row(&[(before + back - 1, 1.0)]),
            _ => row(&[]),
        };
        (0..earlier).for_each(|back| a.set_row(before + back, &given(back).transpose()));
        given(whole) * (1.0 - part) + given(whole + 1) * part
    });
    for i in 0..rotors {
        let thrust = &lift * per_lift[i] + &moment * per_moment[i];
        // u = sqrt(T/T_lim)
        let throttle = thrust / (2.0 * (commanded_n[i] * limit_n).max(f64::MIN_POSITIVE).sqrt());
        for r in 0..plant {
            for c in 0..=all {
                a[(r, c)] += g[(r, i)] * throttle[c];
            }
        }
    }
    for (integral, gain, rate) in [
        (integral_n, k.k_ivx, row(&[(0, -k.k_ivx)])),
        (integral_d, k.k_ivz, row(&[(1, -k.k_ivz)])),
        (integral_q, k.k_iq, error_q * k.k_iq),
    ] {
        for c in 0..=all {
            a[(integral, c)] += period_s * rate[c];
        }
        // Without a gain it stays zero, and is no state that would have to die away.
        a[(integral, integral)] += if gain == 0.0 { 0.0 } else { 1.0 };
    }
    LinearLoop {
        b: a.column(all).into_owned(),
        a: a.columns(0, all).into_owned(),
        c: out.rows(0, all).into_owned(),
        period_s,
    }
}

/// Thrust of each rotor per newton of lift, and per newton metre of pitch moment, well within its limits.
fn allocation(airframe: &Airframe) -> (PerRotor, PerRotor) {
    let half_n = 0.5 * airframe.lift_max_n;
    let small = 1e-3;
    let slope = |more: PerRotor, less: PerRotor, step: f64| -> PerRotor {
        std::array::from_fn(|i| (more[i] - less[i]) / (2.0 * step))
    };
    let lift = |by: f64| airframe.mixer.thrusts(half_n * (1.0 + by), &Vector3::zeros());
    let moment_nm = small * half_n;
    let moment = |by: f64| airframe.mixer.thrusts(half_n, &Vector3::new(0.0, by * moment_nm, 0.0));
    (slope(lift(small), lift(-small), small * half_n), slope(moment(1.0), moment(-1.0), moment_nm))
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
    body: &BodyState,
    speeds: &PerRotor,
    throttles: &PerRotor,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let LoopSetting { vehicle, environment, .. } = *setting;
    let rotors = vehicle.rotors.len();
    let n = BODY + rotors;
    let theta = pitch(body.q_ned_from_body);
    let rates = |x: &DVector<f64>, u: &PerRotor| -> DVector<f64> {
        let body = BodyState {
            q_ned_from_body: quaternion_from_euler(0.0, theta + x[2], 0.0),
            v_ned: body.v_ned + Vector3::new(x[0], 0.0, x[1]),
            omega_body: body.omega_body + Vector3::new(0.0, x[3], 0.0),
            ..*body
        };
        let mut turning = *speeds;
        (0..rotors).for_each(|i| turning[i] += x[BODY + i]);
        let rate = vehicle.powered_derivative(environment, &body, &turning, u, false);
        let of_body =
            [rate.body.v_dot_ned.x, rate.body.v_dot_ned.z, body.omega_body.y, rate.body.omega_dot_body.y];
        let all = of_body.into_iter().chain(rate.rotor_acceleration[..rotors].iter().copied());
        DVector::from_iterator(n, all)
    };
    // Across a cell of the tables on the mean, for a table's slope jumps from cell to cell.
    let steps = |i: usize| match i {
        0 | 1 => 0.05,
        2 => 0.01,
        3 => 0.02,
        rotor => 0.01 * speeds[rotor - BODY].max(1.0),
    };
    let (mut a, mut b) = (DMatrix::zeros(n, n), DMatrix::zeros(n, rotors));
    for i in 0..n {
        let mut x = DVector::zeros(n);
        x[i] = steps(i);
        let slope = (rates(&x, throttles) - rates(&-&x, throttles)) / (2.0 * steps(i));
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
    /// of the pitch rate and `L = K_pvz/s/(1 + 0.15 s)` downwards; sampling delays by half a period, and the
    /// latency comes on top. The gain
    /// of the velocity north is so small that it changes no loop, and lets that velocity die away.
    #[test]
    fn closed_form_loops_of_a_hover_without_air() {
        let options = VehicleOptions { reaction_torque: false, rotor_momentum: false };
        // Seven and a half periods.
        for (tilt_from, latency_s) in
            [(TiltFrom::Thrust, 0.0), (TiltFrom::Gravity, 0.0), (TiltFrom::Thrust, 0.015)]
        {
            let vehicle = quadrotor([ARM_M, 1.1], [620.0, J_YY, 1160.0], [0.0; 3], options);
            let vehicle = Vehicle { latency_s, ..vehicle };
            are_those_of_a_hover(&vehicle, tilt_from);
        }
    }

    fn are_those_of_a_hover(vehicle: &Vehicle, tilt_from: TiltFrom) {
        let gains = Gains::longitudinal([4.0, 0.0, 1.5, 2.0, 0.0, 3e-4, 0.0]);
        let (environment, period_s) = (site(), 0.002);
        let setting = LoopSetting { vehicle, environment: &environment, gains: &gains, tilt_from, period_s };
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
            let lag = Complex::new(cos, sin) / (one + s * 0.15);
            let wanted = [(0usize, (s + 1.5) * 4.0 / (s * s) * lag), (3, one * 2.0 / s * lag)];
            for (i, wanted) in wanted {
                let found = at.loops[i].0.response(omega);
                let off = found - wanted;
                let share = math::hypot(off.re, off.im) / math::hypot(wanted.re, wanted.im);
                assert!(share < 2e-3, "loop {i} at {omega}: {found} for {wanted}");
            }
        }
        assert!(at.loops[0].1.stable && at.loops[3].1.stable);
    }
}
