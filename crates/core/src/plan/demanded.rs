//! The constraints that a plan's [`Demands`] come to: of the peak of J_state (47)-(50), of the motion, of the
//! rotors' acceleration, and of the vortex ring (NASA/TP-2005-213477). Each is one on the path
//! ([`super::path`]) of the [`extended`](super::extended) states, held at nodes and midpoints from the second
//! node on: the first is given.

use std::sync::Arc;

use nalgebra::{Matrix4, SVector, Vector3, Vector4};

use super::demands::{Demands, RingBounds};
use super::dynamics::{BODY_STATES, rotation_gradient, rotation_hessian};
use super::extended::{ALTITUDE_LOST, EXTENDED_STATES, PEAK, STRETCH};
use super::path::{PathConstraint, PathPlace, Point, PointCurvature, PointGradient};
use crate::frames::dcm_body_from_ned;
use crate::math;
use crate::model::{Environment, Rotor, RotorMount, Vehicle};

impl Demands {
    /// The demands as constraints on the path of a vehicle with at most `NU` rotors, whose thrusts change by
    /// no more than `thrust_rate_n_s` [N/s]; the vortex ring is left out where the rotors' blades are not
    /// known.
    pub fn constraints<const NU: usize>(
        &self,
        vehicle: &Vehicle,
        environment: &Environment,
        thrust_rate_n_s: f64,
    ) -> Vec<Arc<dyn PathConstraint<EXTENDED_STATES, NU>>> {
        let mut all: Vec<Arc<dyn PathConstraint<EXTENDED_STATES, NU>>> = Vec::new();
        if let Some(peak) = &self.peak {
            let limits = [peak.speed_m_s, peak.pitch_rad, peak.pitch_rate_rad_s].map(Some);
            add_state_limits(&mut all, limits, Share::Peak);
        }
        let m = &self.motion;
        add_state_limits(&mut all, [m.speed_m_s, m.pitch_rad, m.pitch_rate_rad_s], Share::Whole);
        for (index, bounds) in [(4, m.v_north_m_s), (5, m.v_east_m_s), (6, m.v_down_m_s)] {
            let Some([least, greatest]) = bounds else { continue };
            let scale = 1.0 / (greatest - least);
            all.push(Arc::new(Linear { index, scale, offset: -greatest * scale, share: None }));
            all.push(Arc::new(Linear { index, scale: -scale, offset: least * scale, share: None }));
        }
        if let Some(most) = m.altitude_lost_m {
            all.push(Arc::new(Linear { index: ALTITUDE_LOST, scale: 1.0 / most, offset: -1.0, share: None }));
        }
        let rotors = vehicle.rotors.len();
        let hover_n = vehicle.mass.mass_kg * environment.gravity_m_s2 / rotors as f64;
        if let Some(limit) = self.rotor_acceleration_rad_s2 {
            let per_speed2 = thrust_per_speed2(vehicle, environment);
            let square_per_n = 4.0 * limit * limit * per_speed2;
            for rotor in 0..rotors {
                all.push(Arc::new(RotorAcceleration {
                    rotor,
                    square_per_n,
                    scale: 1.0 / (square_per_n * hover_n),
                }));
            }
        }
        if let (Some(ring), Rotor::BladeElement(table)) = (&self.vortex_ring, &vehicle.rotor) {
            let area_m2 = std::f64::consts::PI * table.radius_m() * table.radius_m();
            let per_n = 0.5 / (environment.density_kg_m3 * area_m2);
            for (rotor, RotorMount { axis_body, .. }) in vehicle.rotors.iter().enumerate() {
                all.push(Arc::new(RingKeepOut {
                    rotor,
                    axis_body: *axis_body,
                    wind_ned: environment.wind_ned_m_s,
                    per_n,
                    least_n: 1e-3 * hover_n,
                    scale: 1.0 / (per_n * hover_n),
                    bounds: *ring,
                }));
            }
        }
        if self.horizon.is_some() && thrust_rate_n_s.is_finite() {
            for rotor in 0..rotors {
                for sign in [1.0, -1.0] {
                    all.push(Arc::new(ThrustRate { rotor, scale: sign / thrust_rate_n_s }));
                }
            }
        }
        all
    }

    /// Largest share of the peak's limits that a state takes; 0 without a peak.
    pub(super) fn peak_of(&self, state: &[f64; BODY_STATES]) -> f64 {
        let Some(peak) = &self.peak else { return 0.0 };
        let q = Vector4::new(state[0], state[1], state[2], state[3]);
        let speed = Vector3::new(state[4], state[5], state[6]).norm() / peak.speed_m_s;
        let angles = [Angle::PITCH, Angle::ROLL].map(|a| a.of(&q).abs() / peak.pitch_rad);
        let rates = [state[7], state[8]].map(|w| w.abs() / peak.pitch_rate_rad_s);
        angles.into_iter().chain(rates).fold(speed, f64::max)
    }
}

/// Thrust of a rotor over the square of its speed [N s^2], at rest in the site's air, at its motor's greatest
/// speed.
fn thrust_per_speed2(vehicle: &Vehicle, environment: &Environment) -> f64 {
    let omega = vehicle.motor.omega_max_rad_s();
    vehicle.rotor.static_load(omega, environment.density_kg_m3).thrust_n / (omega * omega)
}

/// Of what a constraint may take no more than a share: of a limit, or of the limit times the peak.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Share {
    Whole,
    Peak,
}

impl Share {
    fn of<const NU: usize>(self, at: &Point<'_, EXTENDED_STATES, NU>) -> f64 {
        match self {
            Self::Whole => 1.0,
            Self::Peak => at.x[PEAK],
        }
    }
}

/// Limits `[speed, pitch, pitch rate]`, each where it is given, as constraints.
fn add_state_limits<const NU: usize>(
    all: &mut Vec<Arc<dyn PathConstraint<EXTENDED_STATES, NU>>>,
    [speed_m_s, pitch_rad, pitch_rate_rad_s]: [Option<f64>; 3],
    share: Share,
) {
    if let Some(limit_m_s) = speed_m_s {
        all.push(Arc::new(Speed { limit_m_s, share }));
    }
    for sign in [1.0, -1.0] {
        for angle in [Angle::PITCH, Angle::ROLL] {
            if let Some(limit) = pitch_rad {
                all.push(Arc::new(AngleLimit { angle, scale: sign / limit, share }));
            }
        }
        for index in [7, 8] {
            if let Some(limit) = pitch_rate_rad_s {
                let (offset, share) = match share {
                    Share::Whole => (-1.0, None),
                    Share::Peak => (0.0, Some(PEAK)),
                };
                all.push(Arc::new(Linear { index, scale: sign / limit, offset, share }));
            }
        }
    }
}

/// `|v|^2/limit^2 - share^2 <= 0`.
#[derive(Debug)]
struct Speed {
    limit_m_s: f64,
    share: Share,
}

impl<const NU: usize> PathConstraint<EXTENDED_STATES, NU> for Speed {
    fn applies(&self, _: &PathPlace) -> bool {
        true
    }

    fn value(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> f64 {
        let (v, share) = (at.x.fixed_rows::<3>(4) / self.limit_m_s, self.share.of(at));
        v.norm_squared() - share * share
    }

    fn gradient(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> PointGradient<EXTENDED_STATES, NU> {
        let mut gradient = PointGradient::zero();
        for i in 4..7 {
            gradient.x[i] = 2.0 * at.x[i] / (self.limit_m_s * self.limit_m_s);
        }
        if self.share == Share::Peak {
            gradient.x[PEAK] = -2.0 * at.x[PEAK];
        }
        gradient
    }

    fn add_curvature(
        &self,
        _: &Point<'_, EXTENDED_STATES, NU>,
        weight: f64,
        sum: &mut PointCurvature<EXTENDED_STATES, NU>,
    ) {
        for i in 4..7 {
            sum.states.xx[(i, i)] += 2.0 * weight / (self.limit_m_s * self.limit_m_s);
        }
        if self.share == Share::Peak {
            sum.states.xx[(PEAK, PEAK)] -= 2.0 * weight;
        }
    }
}

/// `scale x_i + offset - share <= 0`, the share being that of the peak where there is one.
#[derive(Debug)]
struct Linear {
    index: usize,
    scale: f64,
    offset: f64,
    share: Option<usize>,
}

impl<const NU: usize> PathConstraint<EXTENDED_STATES, NU> for Linear {
    fn applies(&self, _: &PathPlace) -> bool {
        true
    }

    fn value(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> f64 {
        self.scale * at.x[self.index] + self.offset - self.share.map_or(0.0, |i| at.x[i])
    }

    fn gradient(&self, _: &Point<'_, EXTENDED_STATES, NU>) -> PointGradient<EXTENDED_STATES, NU> {
        let mut gradient = PointGradient::zero();
        gradient.x[self.index] = self.scale;
        if let Some(i) = self.share {
            gradient.x[i] = -1.0;
        }
        gradient
    }
}

/// An angle `atan2(q' S q, q' C q)` of the attitude, S and C constant: the same for every length of q, and
/// smooth but where both are zero.
#[derive(Clone, Copy, Debug)]
struct Angle {
    sine: Matrix4<f64>,
    cosine: Matrix4<f64>,
}

/// The cosine of pitch and roll together, `C_33`.
const UPRIGHT: Matrix4<f64> = Matrix4::new(
    1.0, 0.0, 0.0, 0.0, //
    0.0, -1.0, 0.0, 0.0, //
    0.0, 0.0, -1.0, 0.0, //
    0.0, 0.0, 0.0, 1.0,
);

impl Angle {
    /// Pitch in (-180, 180] deg where there is no roll; beside roll a little more than pitch, its tangent
    /// divided by the cosine of the roll.
    const PITCH: Self = Self {
        sine: Matrix4::new(
            0.0, 0.0, 1.0, 0.0, //
            0.0, 0.0, 0.0, -1.0, //
            1.0, 0.0, 0.0, 0.0, //
            0.0, -1.0, 0.0, 0.0,
        ),
        cosine: UPRIGHT,
    };
    /// Roll, in (-180, 180] deg.
    const ROLL: Self = Self {
        sine: Matrix4::new(
            0.0, 1.0, 0.0, 0.0, //
            1.0, 0.0, 0.0, 0.0, //
            0.0, 0.0, 0.0, 1.0, //
            0.0, 0.0, 1.0, 0.0,
        ),
        cosine: UPRIGHT,
    };

    fn of(&self, q: &Vector4<f64>) -> f64 {
        math::atan2(q.dot(&(self.sine * q)), q.dot(&(self.cosine * q)))
    }

    fn gradient(&self, q: &Vector4<f64>) -> Vector4<f64> {
        let (by_sine, by_cosine) = (self.sine * q, self.cosine * q);
        let (s, c) = (q.dot(&by_sine), q.dot(&by_cosine));
        (by_sine * c - by_cosine * s) * (2.0 / (s * s + c * c))
    }

    fn hessian(&self, q: &Vector4<f64>) -> Matrix4<f64> {
        let (by_sine, by_cosine) = (self.sine * q * 2.0, self.cosine * q * 2.0);
        let (s, c) = (0.5 * q.dot(&by_sine), 0.5 * q.dot(&by_cosine));
        let per = 1.0 / (s * s + c * c);
        let (twice, mixed) = (2.0 * s * c * per * per, (s * s - c * c) * per * per);
        let cross = by_sine * by_cosine.transpose();
        (self.sine * c - self.cosine * s) * (2.0 * per)
            + (by_cosine * by_cosine.transpose() - by_sine * by_sine.transpose()) * twice
            + (cross + cross.transpose()) * mixed
    }
}

/// `scale angle - share <= 0`.
#[derive(Debug)]
struct AngleLimit {
    angle: Angle,
    scale: f64,
    share: Share,
}

fn attitude(x: &SVector<f64, EXTENDED_STATES>) -> Vector4<f64> {
    Vector4::new(x[0], x[1], x[2], x[3])
}

impl<const NU: usize> PathConstraint<EXTENDED_STATES, NU> for AngleLimit {
    fn applies(&self, _: &PathPlace) -> bool {
        true
    }

    fn value(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> f64 {
        self.scale * self.angle.of(&attitude(at.x)) - self.share.of(at)
    }

    fn gradient(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> PointGradient<EXTENDED_STATES, NU> {
        let mut gradient = PointGradient::<EXTENDED_STATES, NU>::zero();
        let by_q = self.angle.gradient(&attitude(at.x)) * self.scale;
        gradient.x.fixed_rows_mut::<4>(0).copy_from(&by_q);
        if self.share == Share::Peak {
            gradient.x[PEAK] = -1.0;
        }
        gradient
    }

    fn add_curvature(
        &self,
        at: &Point<'_, EXTENDED_STATES, NU>,
        weight: f64,
        sum: &mut PointCurvature<EXTENDED_STATES, NU>,
    ) {
        let own = self.angle.hessian(&attitude(at.x)) * (weight * self.scale);
        let mut all = sum.states.xx.fixed_view_mut::<4, 4>(0, 0);
        all += own;
    }
}

/// A rotor's speed changes no faster than a limit `a`: with `T = k w^2`, `T'^2 <= 4 a^2 k T`, over an
/// interval with the thrust at its middle.
#[derive(Debug)]
struct RotorAcceleration {
    rotor: usize,
    /// `4 a^2 k` [N/s^2].
    square_per_n: f64,
    /// One over what the square of the rate may be in hover [s^2/N^2].
    scale: f64,
}

impl<const NU: usize> PathConstraint<EXTENDED_STATES, NU> for RotorAcceleration {
    fn applies(&self, place: &PathPlace) -> bool {
        place.middle
    }

    fn value(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> f64 {
        let (rate, stretch) = (at.u_dot[self.rotor], at.x[STRETCH]);
        (rate * rate - self.square_per_n * at.u[self.rotor] * stretch * stretch) * self.scale
    }

    fn gradient(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> PointGradient<EXTENDED_STATES, NU> {
        let (i, stretch) = (self.rotor, at.x[STRETCH]);
        let mut gradient = PointGradient::zero();
        gradient.u_dot[i] = 2.0 * at.u_dot[i] * self.scale;
        gradient.u[i] = -self.square_per_n * stretch * stretch * self.scale;
        gradient.x[STRETCH] = -2.0 * self.square_per_n * at.u[i] * stretch * self.scale;
        gradient
    }

    fn add_curvature(
        &self,
        at: &Point<'_, EXTENDED_STATES, NU>,
        weight: f64,
        sum: &mut PointCurvature<EXTENDED_STATES, NU>,
    ) {
        let (i, weight) = (self.rotor, weight * self.scale);
        sum.moves.ww[(i, i)] += 2.0 * weight;
        sum.states.ux[(i, STRETCH)] -= 2.0 * weight * self.square_per_n * at.x[STRETCH];
        sum.states.xx[(STRETCH, STRETCH)] -= 2.0 * weight * self.square_per_n * at.u[i];
    }
}

/// `scale T' - stretch <= 0`: the limit on a rotor's thrust where time is stretched.
#[derive(Debug)]
struct ThrustRate {
    rotor: usize,
    scale: f64,
}

impl<const NU: usize> PathConstraint<EXTENDED_STATES, NU> for ThrustRate {
    fn applies(&self, place: &PathPlace) -> bool {
        place.middle
    }

    fn value(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> f64 {
        self.scale * at.u_dot[self.rotor] - at.x[STRETCH]
    }

    fn gradient(&self, _: &Point<'_, EXTENDED_STATES, NU>) -> PointGradient<EXTENDED_STATES, NU> {
        let mut gradient = PointGradient::zero();
        gradient.u_dot[self.rotor] = self.scale;
        gradient.x[STRETCH] = -1.0;
        gradient
    }
}

/// Climb in the middle of Johnson's ring, between N and X, in units of `v_h`.
const RING_MIDDLE: f64 = -0.975;
/// Half the distance from N to X.
const RING_HALF_CLIMB: f64 = 0.525;
/// Greatest edgewise velocity in the ring.
const RING_EDGEWISE: f64 = 0.95;

/// A rotor stays outside the ellipse about the middle of the vortex ring:
/// `share^2 v_h^2 - (in plane/0.95)^2 - ((climb + 0.975 v_h)/0.525)^2 <= 0`, `v_h^2 = T/(2 rho A)`. The
/// vehicle's rates, which move its rotors differently, are left out.
#[derive(Debug)]
struct RingKeepOut {
    rotor: usize,
    axis_body: Vector3<f64>,
    wind_ned: Vector3<f64>,
    /// `v_h^2` per newton of thrust [m^2/(s^2 N)].
    per_n: f64,
    /// Added to the thrust, so that the root has a derivative at rest [N].
    least_n: f64,
    /// One over `v_h^2` in hover.
    scale: f64,
    bounds: RingBounds,
}

/// The climb of a rotor and `v_h`, with what their derivatives take.
struct Disk {
    v_air: Vector3<f64>,
    climb: f64,
    v_h: f64,
}

impl RingKeepOut {
    fn disk<const NU: usize>(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> Disk {
        let x = at.x;
        let v_air = Vector3::new(x[4], x[5], x[6]) - self.wind_ned;
        let climb = (dcm_body_from_ned([x[0], x[1], x[2], x[3]]) * v_air).dot(&self.axis_body);
        Disk { v_air, climb, v_h: (self.per_n * (at.u[self.rotor] + self.least_n).max(0.0)).sqrt() }
    }

    /// First and second derivatives by climb and `v_h^2`: `[c, V, cc, cV, VV]`.
    fn derivatives(&self, climb: f64, v_h: f64) -> [f64; 5] {
        let (edge, half, middle) =
            (1.0 / (RING_EDGEWISE * RING_EDGEWISE), 1.0 / (RING_HALF_CLIMB * RING_HALF_CLIMB), -RING_MIDDLE);
        let share = self.bounds.share;
        [
            2.0 * climb * edge - 2.0 * (climb + middle * v_h) * half,
            share * share - (climb + middle * v_h) * middle * half / v_h,
            2.0 * edge - 2.0 * half,
            -middle * half / v_h,
            0.5 * climb * middle * half / (v_h * v_h * v_h),
        ]
    }

    /// Derivatives of the climb by attitude and velocity.
    fn climb_by<const NU: usize>(
        &self,
        at: &Point<'_, EXTENDED_STATES, NU>,
        v_air: &Vector3<f64>,
    ) -> SVector<f64, EXTENDED_STATES> {
        let q = [at.x[0], at.x[1], at.x[2], at.x[3]];
        let mut by = SVector::<f64, EXTENDED_STATES>::zeros();
        let by_q = rotation_gradient(&q, v_air, -1.0).tr_mul(&self.axis_body);
        by.fixed_rows_mut::<4>(0).copy_from(&by_q);
        by.fixed_rows_mut::<3>(4).copy_from(&dcm_body_from_ned(q).tr_mul(&self.axis_body));
        by
    }
}

impl<const NU: usize> PathConstraint<EXTENDED_STATES, NU> for RingKeepOut {
    fn applies(&self, place: &PathPlace) -> bool {
        (self.bounds.from_s..=self.bounds.to_s).contains(&place.t_s)
    }

    fn value(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> f64 {
        let Disk { v_air, climb, v_h } = self.disk(at);
        let edge = (v_air.norm_squared() - climb * climb) / (RING_EDGEWISE * RING_EDGEWISE);
        let along = (climb - RING_MIDDLE * v_h) / RING_HALF_CLIMB;
        let share = self.bounds.share * v_h;
        (share * share - edge - along * along) * self.scale
    }

    fn gradient(&self, at: &Point<'_, EXTENDED_STATES, NU>) -> PointGradient<EXTENDED_STATES, NU> {
        let Disk { v_air, climb, v_h } = self.disk(at);
        let [by_climb, by_v2, ..] = self.derivatives(climb, v_h);
        let mut gradient = PointGradient::zero();
        gradient.x = self.climb_by(at, &v_air) * (by_climb * self.scale);
        for i in 0..3 {
            gradient.x[4 + i] -= 2.0 * v_air[i] / (RING_EDGEWISE * RING_EDGEWISE) * self.scale;
        }
        gradient.u[self.rotor] = by_v2 * self.per_n * self.scale;
        gradient
    }

    fn add_curvature(
        &self,
        at: &Point<'_, EXTENDED_STATES, NU>,
        weight: f64,
        sum: &mut PointCurvature<EXTENDED_STATES, NU>,
    ) {
        let Disk { v_air, climb, v_h } = self.disk(at);
        let [by_climb, _, climb_twice, mixed, v2_twice] = self.derivatives(climb, v_h);
        let (weight, i) = (weight * self.scale, self.rotor);
        let climb_by = self.climb_by(at, &v_air);
        sum.states.xx += climb_by * climb_by.transpose() * (weight * climb_twice);
        let q = [at.x[0], at.x[1], at.x[2], at.x[3]];
        let own = weight * by_climb;
        let mut attitude = sum.states.xx.fixed_view_mut::<4, 4>(0, 0);
        attitude += rotation_hessian(&self.axis_body, &v_air) * own;
        let by_velocity = rotation_gradient(&q, &self.axis_body, 1.0) * own;
        let mut below = sum.states.xx.fixed_view_mut::<3, 4>(4, 0);
        below += by_velocity;
        let mut above = sum.states.xx.fixed_view_mut::<4, 3>(0, 4);
        above += by_velocity.transpose();
        for j in 4..7 {
            sum.states.xx[(j, j)] -= 2.0 * weight / (RING_EDGEWISE * RING_EDGEWISE);
        }
        for j in 0..EXTENDED_STATES {
            sum.states.ux[(i, j)] += weight * mixed * self.per_n * climb_by[j];
        }
        sum.states.uu[(i, i)] += weight * v2_twice * self.per_n * self.per_n;
    }
}
