//! One rotor by blade elements and momentum theory: thrust, force in the disk's plane and torque at any rotor
//! speed, velocity and angle of the flow.
//!
//! Each element of a blade sees the rotor's turning, the velocity in the disk's plane and one induced
//! velocity, the same over the whole disk ([`super::inflow`]), and has lift and drag of its profile at that
//! angle, all the way round:
//!
//! ```text
//! u_t = Omega r + V_x sin psi       u_p = V_z + v       phi = atan2(u_p, u_t)       alpha = theta - phi
//! dT  = N/(2 pi) rho/2 c U^2 (c_l cos phi - c_d sin phi) dr dpsi
//! dQ  = N/(2 pi) rho/2 c U^2 (c_l sin phi + c_d cos phi) r dr dpsi
//! dH  = N/(2 pi) rho/2 c U^2 (c_l sin phi + c_d cos phi) sin psi dr dpsi
//! ```
//!
//! The induced velocity is that of the thrust: `T = 2 rho A w |w|` with `w` the (signed) hover velocity of T,
//! `v = w f(V_z/w, V_x/|w|)`. A disk that pushes down is the mirror image of one that pushes up.
//!
//! The profile knows neither Reynolds nor Mach number, so that thrust over `rho A ((Omega R)^2 + V^2)`
//! depends on two bounded numbers alone ([`super::coefficient_table`]).
//!
//! Left out: flapping and the moments of a rigid rotor about axes in the disk (in a pair that turns opposite
//! ways the rolling moments cancel), flow along the blades, the inflow's differences over the disk (their
//! mean effect is in the profile's drag), the time that the inflow takes to follow.
//!
//! Source: J. G. Leishman, *Principles of Helicopter Aerodynamics*, 2nd ed. (2006), ch. 2 and 3.

use std::f64::consts::{FRAC_PI_2, PI};

use super::rotor_load::RotorLoad;
use super::{ModelError, check, check_positive, inflow};
use crate::math;

/// Lift and drag of a blade's profile at any angle of attack: a straight line of lift up to the stall, a flat
/// plate beyond it and in reversed flow, and a parabola of drag.
///
/// With `s` the sine of the angle from zero lift: `c_l = a s` as long as that is within the stall's lift,
/// `c_l = c_90 s cos` as a plate, and a smooth step between them over [`STALL_WIDTH`] in `s`; drag is
/// `c_d0 + k (c_l - c_l0)^2`, as a plate `c_d0 + c_90 s^2`. Nothing is measured of this shape: it is a
/// choice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Airfoil {
    /// Slope of the lift coefficient a [1/rad].
    pub lift_slope: f64,
    /// Angle of attack without lift [rad].
    pub zero_lift_rad: f64,
    /// Lift coefficients of the stall, lowest and highest.
    pub stall_lift: [f64; 2],
    /// Least drag coefficient c_d0.
    pub drag_min: f64,
    /// Lift coefficient c_l0 of the least drag.
    pub lift_at_drag_min: f64,
    /// Rise k of the drag coefficient with the square of the lift coefficient.
    pub drag_rise: f64,
    /// Drag coefficient c_90 of the profile across the flow, over the least.
    pub drag_across: f64,
}

/// Width of the smooth step from lift before the stall to that of a plate, in the sine of the angle from zero
/// lift: 6.9 deg.
pub const STALL_WIDTH: f64 = 0.3;

impl Airfoil {
    fn validate(&self) -> Result<(), ModelError> {
        check_positive("the profile's lift slope", self.lift_slope)?;
        let [low, high] = self.stall_lift;
        check(low < 0.0, "the lift coefficient of the negative stall", "negative", low)?;
        check_positive("the lift coefficient of the stall", high)?;
        check_positive("the profile's least drag coefficient", self.drag_min)?;
        check_positive("the drag coefficient across the flow", self.drag_across)
    }

    /// Lift and drag coefficients at the sine and cosine of the angle from zero lift.
    #[inline]
    fn coefficients(&self, sin: f64, cos: f64) -> [f64; 2] {
        let plate = [self.drag_across * sin * cos, self.drag_min + self.drag_across * sin * sin];
        let lift = self.lift_slope * sin;
        let [low, high] = self.stall_lift;
        let beyond = (lift - high).max(low - lift) / (self.lift_slope * STALL_WIDTH);
        if cos <= 0.0 || beyond >= 1.0 {
            return plate;
        }
        let off = lift - self.lift_at_drag_min;
        let attached = [lift, self.drag_min + self.drag_rise * off * off];
        let step = beyond.max(0.0);
        let stalled = step * step * (3.0 - 2.0 * step);
        [0, 1].map(|k| attached[k] + stalled * (plate[k] - attached[k]))
    }
}

/// A place along a blade.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BladeStation {
    /// Distance from the axis over the radius, 0 to 1.
    pub radius_share: f64,
    /// Chord over the radius.
    pub chord_share: f64,
    /// Pitch of the chord against the disk [rad].
    pub pitch_rad: f64,
}

/// The blades of a rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct Blades {
    radius_m: f64,
    count: u32,
    stations: Vec<BladeStation>,
    airfoil: Airfoil,
    tip_loss: f64,
    elements: Vec<Element>,
}

/// A piece of all blades together, in units of radius and disk area.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Element {
    radius: f64,
    /// `N c dr/(2 pi R^2)`: half the blades' area in units of the disk's.
    half_area: f64,
    /// Sine and cosine of the pitch against the direction of zero lift.
    sin: f64,
    cos: f64,
    lifts: bool,
}

/// Elements along the part of a blade that lifts, and from there to the tip.
const ELEMENTS: [usize; 2] = [24, 2];
/// Azimuths from the advancing to the retreating side; the rest of the turn is their mirror image.
const AZIMUTHS: usize = 8;

/// Thrust, force and torque of a rotor over `rho A ((Omega R)^2 + V^2)`; the torque also over R.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorCoefficients {
    /// Of the thrust along the axis.
    pub thrust: f64,
    /// Of the force in the disk's plane, against the motion in that plane.
    pub in_plane: f64,
    /// Of the torque that brakes the rotor.
    pub torque: f64,
}

/// How the disk moves through the air, in units of `sqrt((Omega R)^2 + V^2)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskMotion {
    /// Tip speed; negative: the rotor turns backwards, the blades' trailing edges first.
    pub tip: f64,
    /// Velocity along the thrust.
    pub climb: f64,
    /// Velocity in the disk's plane, zero or more.
    pub in_plane: f64,
}

/// A rotor in hover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hover {
    /// Thrust coefficient `T/(rho A (Omega R)^2)`.
    pub thrust: f64,
    /// Torque coefficient `Q/(rho A R (Omega R)^2)`.
    pub torque: f64,
    /// Induced velocity over tip speed.
    pub induced: f64,
    /// Figure of merit: the power of momentum theory over that taken.
    pub merit: f64,
}

impl Blades {
    /// Blades of `radius_m` [m] between the first and the last station, pitch and chord linear between them.
    /// `tip_loss` is the share of the radius inside which they lift.
    ///
    /// # Errors
    /// [`ModelError::OutOfRange`] for numbers that are not finite or without meaning, [`ModelError::Table`]
    /// for fewer than two stations or radii that do not increase up to at most 1.
    pub fn new(
        radius_m: f64,
        count: u32,
        stations: &[BladeStation],
        airfoil: Airfoil,
        tip_loss: f64,
    ) -> Result<Self, ModelError> {
        check_positive("the rotor's radius", radius_m)?;
        check(count > 0, "the number of blades", "positive", f64::from(count))?;
        check(tip_loss > 0.0 && tip_loss <= 1.0, "the tip loss factor", "in 0 to 1", tip_loss)?;
        airfoil.validate()?;
        let radii: Vec<f64> = stations.iter().map(|s| s.radius_share).collect();
        if radii.len() < 2 || !(radii[0] >= 0.0 && radii[radii.len() - 1] <= 1.0) {
            let message = "at least 2 stations of a blade expected, from 0 to 1 of the radius";
            return Err(ModelError::Table(message.into()));
        }
        super::check_increasing(&radii)?;
        let mut blades =
            Self { radius_m, count, stations: stations.to_vec(), airfoil, tip_loss, elements: Vec::new() };
        blades.elements = blades.elements();
        Ok(blades)
    }

    fn elements(&self) -> Vec<Element> {
        let (root, tip) =
            (self.stations[0].radius_share, self.stations[self.stations.len() - 1].radius_share);
        let lifting_end = self.tip_loss.clamp(root, tip);
        let mut elements = Vec::new();
        for (number, [from, to], lifts) in
            [(ELEMENTS[0], [root, lifting_end], true), (ELEMENTS[1], [lifting_end, tip], false)]
        {
            let width = (to - from) / number as f64;
            for i in 0..number {
                let radius = from + (i as f64 + 0.5) * width;
                let [chord, pitch_rad] = self.at(radius);
                let (sin, cos) = math::sin_cos(pitch_rad - self.airfoil.zero_lift_rad);
                let half_area = 0.5 * f64::from(self.count) * chord * width / PI;
                elements.push(Element { radius, half_area, sin, cos, lifts });
            }
        }
        elements
    }

    /// Chord over radius and pitch [rad] at a share of the radius.
    fn at(&self, radius: f64) -> [f64; 2] {
        let inner = &self.stations[1..self.stations.len() - 1];
        let i = inner.partition_point(|s| s.radius_share <= radius);
        let (a, b) = (&self.stations[i], &self.stations[i + 1]);
        let share = (radius - a.radius_share) / (b.radius_share - a.radius_share);
        [(a.chord_share, b.chord_share), (a.pitch_rad, b.pitch_rad)].map(|(a, b)| a + share * (b - a))
    }

    /// Radius [m].
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Blade area over disk area.
    pub fn solidity(&self) -> f64 {
        2.0 * self.elements.iter().map(|e| e.half_area).sum::<f64>()
    }

    /// Coefficients of the rotor at a motion of its disk.
    pub fn coefficients(&self, motion: &DiskMotion) -> RotorCoefficients {
        let balance = |w: f64| {
            let loads = self.blade_loads(motion, self.through(motion, w));
            (loads, loads.thrust - 2.0 * w * w.abs())
        };
        // Blades give less the greater the flow through the disk, momentum theory more: one crossing. By
        // regula falsi with the Illinois rule, halving now and then.
        let (mut low, mut high) = (-1.5, 1.5);
        let ((_, mut f_low), (mut loads, mut f_high)) = (balance(low), balance(high));
        let mut kept = 0;
        for step in 0..60 {
            let middle = if step % 4 == 3 {
                0.5 * (low + high)
            } else {
                low + (high - low) * f_low / (f_low - f_high)
            };
            let (at_middle, f) = balance(middle);
            loads = at_middle;
            if f.abs() < 1e-13 || high - low < 1e-12 {
                break;
            }
            if f > 0.0 {
                (low, f_low) = (middle, f);
                if kept == 1 {
                    f_high *= 0.5;
                }
                kept = 1;
            } else {
                (high, f_high) = (middle, f);
                if kept == -1 {
                    f_low *= 0.5;
                }
                kept = -1;
            }
        }
        loads
    }

    /// Load at a rotor speed [rad/s] of a hub that moves along the thrust at `climb_m_s` and in the disk's
    /// plane at `in_plane_m_s` [m/s], solved for directly.
    pub fn load(&self, omega_rad_s: f64, climb_m_s: f64, in_plane_m_s: f64, density_kg_m3: f64) -> RotorLoad {
        let tip = omega_rad_s * self.radius_m;
        let square = tip * tip + climb_m_s * climb_m_s + in_plane_m_s * in_plane_m_s;
        if !(square > 0.0) {
            return RotorLoad { thrust_n: 0.0, torque_nm: 0.0, in_plane_n: 0.0 };
        }
        let whole = square.sqrt();
        let motion =
            DiskMotion { tip: tip / whole, climb: climb_m_s / whole, in_plane: in_plane_m_s.abs() / whole };
        let coefficients = self.coefficients(&motion);
        let scale = PI * self.radius_m * self.radius_m * square * density_kg_m3;
        RotorLoad {
            thrust_n: scale * coefficients.thrust,
            in_plane_n: scale * coefficients.in_plane,
            torque_nm: scale * self.radius_m * coefficients.torque,
        }
    }

    /// The rotor in hover.
    pub fn hover(&self) -> Hover {
        let RotorCoefficients { thrust, torque, .. } =
            self.coefficients(&DiskMotion { tip: 1.0, climb: 0.0, in_plane: 0.0 });
        let induced = (0.5 * thrust.max(0.0)).sqrt();
        Hover { thrust, torque, induced, merit: thrust * induced / torque }
    }

    /// Thrust over that of hover at the same rotor speed in a vertical descent at `descent` times the induced
    /// velocity of hover.
    pub fn thrust_in_descent(&self, descent: f64) -> f64 {
        let hover = self.hover();
        let climb = -descent * hover.induced;
        self.load(1.0 / self.radius_m, climb, 0.0, 1.0).thrust_n
            / self.load(1.0 / self.radius_m, 0.0, 0.0, 1.0).thrust_n
    }

    /// Velocity of the air through the disk when its thrust has the signed hover velocity `w`.
    fn through(&self, motion: &DiskMotion, w: f64) -> f64 {
        if w == 0.0 {
            return motion.climb;
        }
        let induced = inflow::induced(motion.climb / w, motion.in_plane / w.abs());
        motion.climb + w * induced
    }

    /// Coefficients of the blades alone when the air goes through the disk at `through`.
    fn blade_loads(&self, motion: &DiskMotion, through: f64) -> RotorCoefficients {
        let mut sum = RotorCoefficients::default();
        let azimuths = if motion.in_plane == 0.0 { 1 } else { AZIMUTHS };
        for k in 0..azimuths {
            let sin_psi = math::sin(FRAC_PI_2 * ((2 * k + 1) as f64 / azimuths as f64 - 1.0));
            for e in &self.elements {
                let u_t = motion.tip * e.radius + motion.in_plane * sin_psi;
                let speed = (u_t * u_t + through * through).sqrt();
                if !(speed > 0.0) {
                    continue;
                }
                let (sin_phi, cos_phi) = (through / speed, u_t / speed);
                let (sin, cos) = (e.sin * cos_phi - e.cos * sin_phi, e.cos * cos_phi + e.sin * sin_phi);
                let [c_l, c_d] = self.airfoil.coefficients(sin, cos);
                let c_l = if e.lifts { c_l } else { 0.0 };
                let force = e.half_area * speed * speed;
                let across = force * (c_l * sin_phi + c_d * cos_phi);
                sum.thrust += force * (c_l * cos_phi - c_d * sin_phi);
                sum.torque += across * e.radius;
                sum.in_plane += across * sin_psi;
            }
        }
        let share = 1.0 / azimuths as f64;
        RotorCoefficients {
            thrust: share * sum.thrust,
            in_plane: if motion.in_plane == 0.0 { 0.0 } else { share * sum.in_plane },
            torque: share * sum.torque,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::blade_tests::{PROFILE, blades, table_of};
    use crate::random::{Purpose, Stream};

    /// Without tip loss and root cut-out, and for small angles, `2 l^2 = sigma a/2 (theta/3 - l/2)`
    /// (Leishman, 3.2.2): the sines of the angles, the finite elements and the root cost 0.4 %.
    #[test]
    fn closed_form_hover_of_blades_without_twist() {
        for pitch in [0.05f64, 0.1, 0.18] {
            let station =
                |radius_share| BladeStation { radius_share, chord_share: 0.1 * PI / 4.0, pitch_rad: pitch };
            let whole = Blades::new(1.0, 4, &[station(0.0), station(1.0)], PROFILE, 1.0).unwrap();
            assert!((whole.solidity() - 0.1).abs() < 1e-14);
            let b = 0.25 * 0.1 * 5.7;
            let induced = 0.25 * ((b * b + 16.0 * b * pitch / 3.0).sqrt() - b);
            let found = whole.hover();
            assert!((found.induced / induced - 1.0).abs() < 4e-3, "{pitch}: {} {induced}", found.induced);
            // C_Q = C_T l + sigma c_d/8, with the drag of the lift by the polar between its ends.
            let ideal = found.thrust * found.induced;
            let drag = (found.torque - ideal) * 8.0 / 0.1;
            assert!(drag > 0.0128 && drag < 0.017, "{pitch}: {drag}");
        }
    }

    /// The thrust of the blades is that of momentum theory at the induced velocity found.
    #[test]
    fn closed_form_blades_and_momentum_agree() {
        let rotor = blades(0.18, 0.97);
        for motion in [
            DiskMotion { tip: 1.0, climb: 0.0, in_plane: 0.0 },
            DiskMotion { tip: 0.99, climb: 0.1, in_plane: 0.05 },
            DiskMotion { tip: 0.99, climb: -0.04, in_plane: 0.1 },
            DiskMotion { tip: 0.5, climb: -0.8, in_plane: 0.1 },
        ] {
            let found = rotor.coefficients(&motion);
            let w = (0.5 * found.thrust.abs()).sqrt().copysign(found.thrust);
            let again = rotor.blade_loads(&motion, rotor.through(&motion, w));
            assert!((again.thrust - found.thrust).abs() < 1e-9, "{motion:?}");
        }
    }

    /// Johnson's figures of thrust at a constant rotor speed in vertical descent, +-0.05, for the rotor
    /// `blades(0.1807, 0.97)`: solidity 0.1, no twist, collective 10.35 deg.
    #[test]
    fn reference_thrust_in_vertical_descent() {
        let rotor = blades(0.1807, 0.97);
        for (descent, wanted) in [(0.5, 1.11), (1.0, 0.97), (1.5, 0.88), (2.0, 1.28)] {
            let found = rotor.thrust_in_descent(descent);
            assert!((found - wanted).abs() < 0.05, "{descent}: {found}");
        }
    }

    /// Heave is damped where thrust rises with the rate of descent: not between N and X.
    #[test]
    fn reference_heave_is_not_damped_in_the_vortex_ring() {
        let rotor = blades(0.1807, 0.97);
        let damped = |d: f64| rotor.thrust_in_descent(d + 0.01) > rotor.thrust_in_descent(d - 0.01);
        // N and X are at -0.45 and -1.5 of the v_h of the thrust there, 1.117 and 0.88 that of hover.
        for (descent, wanted) in
            [(0.2, true), (0.44, true), (0.52, false), (1.0, false), (1.36, false), (1.46, true), (1.8, true)]
        {
            assert_eq!(damped(descent), wanted, "{descent}");
        }
    }

    /// A rotor at rest is a plate with holes: its blades' drag in the flow that momentum theory leaves,
    /// `V/(1 + sigma c_d/4)`, and no torque at pitch 0; one in a climb faster than its pitch pulls back.
    #[test]
    fn closed_form_at_rest_and_beyond_its_pitch() {
        let flat = blades(0.0, 0.97).load(0.0, -3.0, 0.0, 5.4);
        let through = 3.0 / (1.0 + 0.1 * (1.8 + PROFILE.drag_min) / 4.0);
        let area = 0.1 * PI * 0.65 * 0.65;
        let wanted = 0.5 * 5.4 * through * through * area * (1.8 + PROFILE.drag_min);
        assert!((flat.thrust_n / wanted - 1.0).abs() < 1e-5, "{flat:?} {wanted}");
        assert!(flat.torque_nm.abs() < 1e-9);
        assert!(blades(0.18, 0.97).load(100.0, 20.0, 0.0, 5.4).thrust_n < 0.0);
        assert_eq!(blades(0.18, 0.97).load(0.0, 0.0, 0.0, 5.4).thrust_n, 0.0);
    }

    /// A force in the disk's plane is against the motion in it when the blades make drag: closed form of the
    /// profile drag `sigma c_d mu/4` for zero pitch, small advance (Leishman, 5.2: H of constant drag).
    #[test]
    fn closed_form_in_plane_force_of_profile_drag() {
        let rotor = blades(0.0, 0.97);
        let mu = 0.02;
        let found = rotor.coefficients(&DiskMotion { tip: 1.0, climb: 0.0, in_plane: mu });
        let root = 0.1f64 * 0.1;
        let wanted = 0.1 / 0.9 * PROFILE.drag_min * mu / 4.0 * (1.0 - root);
        assert!((found.in_plane / wanted - 1.0).abs() < 0.01, "{} {wanted}", found.in_plane);
    }

    /// The table that flies against direct solutions at random speeds from rest on and flows from anywhere:
    /// relative to the thrust or torque, at least to a tenth of hover's at that `(Omega R)^2 + V^2`.
    #[test]
    fn reference_the_table_is_within_a_percent_of_the_theory() {
        let rotor = blades(0.1807, 0.97);
        let table = table_of(&rotor);
        let hover = rotor.hover();
        for (most_rad_s, bars) in [(133.0, [0.005, 0.02]), (60.0, [0.005, 0.04])] {
            let mut stream = Stream::new(7, Purpose::Dice, 0);
            let mut errors = [Vec::new(), Vec::new(), Vec::new()];
            for _ in 0..1500 {
                let omega = most_rad_s * stream.uniform();
                let v = 8.0 * stream.uniform();
                let climb = v * (2.0 * stream.uniform() - 1.0);
                let in_plane = (v * v - climb * climb).max(0.0).sqrt();
                let direct = rotor.load(omega, climb, in_plane, 5.4);
                let flown = table.load(omega, climb, in_plane, 5.4);
                let tip = 0.65 * omega;
                let scale = 0.1 * 5.4 * PI * 0.65 * 0.65 * (tip * tip + v * v);
                let thrust = direct.thrust_n.abs().max(scale * hover.thrust);
                let torque = direct.torque_nm.abs().max(scale * 0.65 * hover.torque);
                errors[0].push((flown.thrust_n - direct.thrust_n).abs() / thrust);
                errors[1].push((flown.torque_nm - direct.torque_nm).abs() / torque);
                errors[2].push((flown.in_plane_n - direct.in_plane_n).abs() / thrust);
            }
            let p95 = errors.map(|mut e| {
                e.sort_by(f64::total_cmp);
                e[e.len() * 95 / 100]
            });
            println!("up to {most_rad_s} rad/s: p95 {p95:?}");
            assert!(p95[0] < bars[0] && p95[1] < bars[1] && p95[2] < bars[0], "{most_rad_s}: {p95:?}");
        }
    }

    #[test]
    fn blades_without_meaning_are_refused() {
        let station = |radius_share| BladeStation { radius_share, chord_share: 0.1, pitch_rad: 0.1 };
        let two = [station(0.1), station(1.0)];
        assert!(Blades::new(0.0, 2, &two, PROFILE, 0.97).is_err());
        assert!(Blades::new(1.0, 0, &two, PROFILE, 0.97).is_err());
        assert!(Blades::new(1.0, 2, &two, PROFILE, 1.1).is_err());
        assert!(Blades::new(1.0, 2, &two[..1], PROFILE, 0.97).is_err());
        assert!(Blades::new(1.0, 2, &[two[1], two[0]], PROFILE, 0.97).is_err());
        assert!(Blades::new(1.0, 2, &two, Airfoil { stall_lift: [0.1, 1.0], ..PROFILE }, 0.97).is_err());
    }
}
