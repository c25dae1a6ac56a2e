//! Closed forms of the rigid body: free fall, the precession of a symmetric body, what a tumble conserves.

use nalgebra::{Matrix3, Vector3};

use super::motion::{Load, advance, fly, level};
use super::{Check, CheckGroup};
use crate::frames::{
    Quaternion, conjugate, product, quaternion_from_euler, quaternion_from_rotation_vector,
    rotate_ned_from_body, rotation_vector, wrap_pi,
};
use crate::math;
use crate::model::ModelError;
use crate::model::rigid_body::{BodyState, MassProperties};
use crate::units::DEG_PER_RAD;

/// Step of the simulator behind the wire [s].
const DT_S: f64 = 0.004;

/// Free fall: `p = v_0 t + g t^2/2`, which a fourth-order integrator meets to rounding.
///
/// # Errors
/// [`ModelError`], never in fact: the body is given.
pub fn free_fall(gravity_m_s2: f64) -> Result<CheckGroup, ModelError> {
    let mass = MassProperties::new(3.0, Matrix3::identity())?;
    let v_0 = Vector3::new(2.0, -1.0, 3.0);
    let end =
        fly(&mass, level(v_0, Vector3::new(0.3, 0.2, -0.1)), DT_S, 7500, |_| Load::gravity(gravity_m_s2));
    let t = 30.0;
    Ok(CheckGroup {
        title: "Free fall, 30 s",
        source: "closed form: p = v_0 t + g t^2/2, v = v_0 + g t, at the lander's site",
        checks: vec![
            Check::new("distance down", "m", end.p_ned.z, v_0.z * t + 0.5 * gravity_m_s2 * t * t, 1e-9),
            Check::new("distance east", "m", end.p_ned.y, v_0.y * t, 1e-9),
            Check::new("speed down", "m/s", end.v_ned.z, v_0.z + gravity_m_s2 * t, 1e-10),
        ],
    })
}

/// A torque-free body with two equal moments of inertia.
#[derive(Clone, Debug)]
pub struct SymmetricTop {
    mass: MassProperties,
    transverse: f64,
    axial: f64,
    start: BodyState,
}

impl SymmetricTop {
    /// A flat top that turns about an axis some 0.6 rad/s off its own.
    ///
    /// # Errors
    /// [`ModelError`], never in fact: the body is given.
    pub fn flat() -> Result<Self, ModelError> {
        let (transverse, axial) = (2.0, 3.2);
        let mass =
            MassProperties::new(1.0, Matrix3::from_diagonal(&Vector3::new(transverse, transverse, axial)))?;
        let start = BodyState {
            q_ned_from_body: quaternion_from_euler(0.3, -0.4, 1.1),
            ..level(Vector3::zeros(), Vector3::new(0.6, 0.0, 1.5))
        };
        Ok(Self { mass, transverse, axial, start })
    }

    /// Angular momentum over the transverse inertia, NED: rate and axis of the precession [rad/s].
    fn precession_ned(&self) -> Vector3<f64> {
        let momentum_body = self.mass.inertia_kg_m2 * self.start.omega_body;
        rotate_ned_from_body(self.start.q_ned_from_body, momentum_body) / self.transverse
    }

    /// Rate of the body's rates around its own axis [rad/s].
    fn body_cone_rate(&self) -> f64 {
        (self.axial - self.transverse) / self.transverse * self.start.omega_body.z
    }

    /// Attitude and body rates at `t_s`: a turn about the angular momentum and one back about the axis.
    pub fn exact(&self, t_s: f64) -> (Quaternion, Vector3<f64>) {
        let precessed = quaternion_from_rotation_vector(self.precession_ned() * t_s);
        let spun = quaternion_from_rotation_vector(Vector3::z() * (-self.body_cone_rate() * t_s));
        let (sin, cos) = math::sin_cos(self.body_cone_rate() * t_s);
        let omega = self.start.omega_body;
        let turned = Vector3::new(omega.x * cos - omega.y * sin, omega.x * sin + omega.y * cos, omega.z);
        (product(product(precessed, self.start.q_ned_from_body), spun), turned)
    }

    /// State after `steps` steps of `dt_s` of the integrator.
    pub fn flown(&self, dt_s: f64, steps: u32) -> BodyState {
        fly(&self.mass, self.start, dt_s, steps, |_| Load::gravity(0.0))
    }

    /// Angle between the flown attitude and the exact one [rad].
    pub fn attitude_error_rad(&self, dt_s: f64, steps: u32) -> f64 {
        let (exact, _) = self.exact(dt_s * f64::from(steps));
        rotation_vector(product(conjugate(exact), self.flown(dt_s, steps).q_ned_from_body)).norm()
    }

    /// Mean rate [rad/s] at which the axis goes round the angular momentum, as flown.
    fn measured_precession_rad_s(&self, dt_s: f64, steps: u32) -> f64 {
        let along = self.precession_ned().normalize();
        let across = along.cross(&Vector3::x()).normalize();
        let azimuth = |state: &BodyState| {
            let axis = rotate_ned_from_body(state.q_ned_from_body, Vector3::z());
            math::atan2(axis.dot(&along.cross(&across)), axis.dot(&across))
        };
        let (mut state, mut swept) = (self.start, 0.0);
        for _ in 0..steps {
            let next = advance(&self.mass, &state, dt_s, |_| Load::gravity(0.0));
            swept += wrap_pi(azimuth(&next) - azimuth(&state));
            state = next;
        }
        swept / (dt_s * f64::from(steps))
    }
}

/// The torque-free precession of a symmetric body.
///
/// # Errors
/// [`ModelError`], never in fact: the body is given.
pub fn precession() -> Result<CheckGroup, ModelError> {
    let top = SymmetricTop::flat()?;
    let steps = 7500;
    let (_, omega) = top.exact(30.0);
    let flown = top.flown(DT_S, steps);
    let of_rate = |i: usize| (flown.omega_body[i] * DEG_PER_RAD, omega[i] * DEG_PER_RAD);
    Ok(CheckGroup {
        title: "Torque-free precession of a symmetric body, 30 s",
        source: "Goldstein, Classical Mechanics, 5.6: the axis turns about H at |H|/J_t",
        checks: vec![
            Check::new(
                "rate of precession",
                "rad/s",
                top.measured_precession_rad_s(DT_S, steps),
                top.precession_ned().norm(),
                1e-10,
            ),
            Check::worst("body rates", "deg/s", (0..3).map(of_rate), 1e-8),
            Check::new(
                "attitude, angle off the exact one",
                "deg",
                top.attitude_error_rad(DT_S, steps) * DEG_PER_RAD,
                0.0,
                2e-8,
            ),
        ],
    })
}

/// A body that tumbles for a minute: energy and angular momentum in NED are conserved.
pub fn tumble(mass: &MassProperties) -> CheckGroup {
    let start = level(Vector3::zeros(), Vector3::new(0.4, 1.0, -0.3));
    let end = fly(mass, start, DT_S, 15_000, |_| Load::gravity(0.0));
    let momentum = |s: &BodyState| rotate_ned_from_body(s.q_ned_from_body, mass.inertia_kg_m2 * s.omega_body);
    let energy = |s: &BodyState| 0.5 * s.omega_body.dot(&(mass.inertia_kg_m2 * s.omega_body));
    let (h, h_0) = (momentum(&end), momentum(&start));
    let along = |i: usize| (h[i], h_0[i]);
    CheckGroup {
        title: "Tumbling lander, torque-free, 60 s",
        source: "Euler's equations conserve the kinetic energy and, in NED, the angular momentum",
        checks: vec![
            Check::new("kinetic energy", "J", energy(&end), energy(&start), 1e-9),
            Check::worst("angular momentum, worst axis", "N m s", (0..3).map(along), 1e-8),
        ],
    }
}
