//! Two bodies that descend and swing a little: the steady descent, and the linearised double pendulum.
//!
//! In the north-down plane, with the riser at its stretched length l under the steady tension T, alpha its
//! angle, theta the vehicle's pitch, x the canopy's way north, a the distance of the confluence point from
//! the vehicle's centre of mass, M and I the vehicle's mass and inertia in pitch, m the canopy's mass with
//! the apparent one, and d the canopy's drag across its descent, `(1/2) rho CdS V` per m/s:
//!
//! ```text
//! m x_ddot               = T alpha - d x_dot
//! M (x + l alpha + a theta)_ddot = -T alpha
//! I theta_ddot           = -T a (theta - alpha)
//! ```
//!
//! With exp(s t) these leave, where sigma = T a/I, kappa = d/m:
//!
//! ```text
//! (s + kappa) (l s^4 + (l sigma + T/M + T a^2/I) s^2 + T sigma/M) + (T/m) s (s^2 + sigma) = 0
//! ```
//!
//! The faster oscillation under a canopy that is held, `m` without end, is the swing of (40): the vehicle's,
//! about the confluence point, the riser hardly moving; the slower one is the pendulum of the whole chain.
//! The vehicle's own drag across the descent and the air's moment on it are left out here, not in the
//! motion.

use nalgebra::{Complex, Vector3};

use super::super::rigid_body::{BodyState, MassProperties};
use super::super::{Environment, MAX_ROTORS, ModelError, Vehicle, check};
use super::Suspension;
use crate::frames::LEVEL;
use crate::real::Real;

/// Steady descents faster than this are none [m/s].
const FASTEST_M_S: f64 = 1000.0;
/// A canopy that is held comes free in so many steps.
const RELEASE_STEPS: u32 = 64;

/// Steady descent of vehicle and canopy through still air, the vehicle level, rotors locked at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteadyDescent {
    /// Rate of descent [m/s].
    pub speed_m_s: f64,
    /// Tension of the riser [N].
    pub tension_n: f64,
}

/// What small swings of two bodies depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmallSwings {
    /// Tension of the riser [N].
    pub tension_n: f64,
    /// Length of the riser under that tension [m].
    pub length_m: f64,
    /// Distance of the confluence point from the vehicle's centre of mass [m].
    pub arm_m: f64,
    /// Mass of the vehicle [kg].
    pub mass_kg: f64,
    /// Inertia of the vehicle in pitch [kg m^2].
    pub inertia_kg_m2: f64,
    /// Mass of the canopy with its apparent mass [kg]; infinite: the canopy is held.
    pub canopy_kg: f64,
    /// Drag of the canopy across its descent, per speed [N s/m].
    pub canopy_drag_n_s_m: f64,
}

/// An oscillation of both bodies, per radian of the vehicle's pitch: `theta = Re(exp(rate t))`, and so on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SwingMode {
    /// Decay (the real part, negative) and angular frequency (the imaginary part) [1/s].
    pub rate: Complex<f64>,
    /// Angle of the riser from the vertical.
    pub riser: Complex<f64>,
    /// Way of the canopy [m].
    pub canopy_m: Complex<f64>,
    /// Way of the vehicle's centre of mass [m].
    pub vehicle_m: Complex<f64>,
}

/// A site without its wind.
fn still(site: &Environment) -> Environment {
    Environment { wind_ned_m_s: Vector3::zeros(), ..site.clone() }
}

/// Acceleration of a vehicle that sinks level with its rotors at rest, in still air and pulled by nothing,
/// NED [m/s^2].
pub fn sinking_v_dot_ned(vehicle: &Vehicle, site: &Environment, speed_m_s: f64) -> Vector3<f64> {
    let state = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: LEVEL,
        v_ned: Vector3::new(0.0, 0.0, speed_m_s),
        omega_body: Vector3::zeros(),
    };
    let rest = [0.0; MAX_ROTORS];
    vehicle.powered_derivative(&still(site), &state, &rest, &rest, true).body.v_dot_ned
}

impl Suspension {
    /// The steady descent of a vehicle at a site.
    ///
    /// # Errors
    /// [`ModelError`] when the vehicle would sink more slowly than its canopy: then the riser is slack.
    pub fn steady_descent(&self, vehicle: &Vehicle, site: &Environment) -> Result<SteadyDescent, ModelError> {
        let calm = still(site).ambient();
        let pull_n = |speed_m_s| sinking_v_dot_ned(vehicle, site, speed_m_s).z * vehicle.mass.mass_kg;
        let falls_on = |speed_m_s: f64| {
            let v_ned = Vector3::new(0.0, 0.0, speed_m_s);
            let canopy_n = self.canopy.outer_force_ned(&calm, v_ned.into(), f64::INFINITY);
            pull_n(speed_m_s) + canopy_n.z > 0.0
        };
        let (mut low, mut high) = (0.0, FASTEST_M_S);
        check(!falls_on(high), "rate of descent", "at most 1000 m/s", high)?;
        loop {
            let middle = 0.5 * (low + high);
            if !(low < middle && middle < high) {
                break;
            }
            if falls_on(middle) { low = middle } else { high = middle }
        }
        let tension_n = pull_n(low);
        let expected = "positive: the vehicle must fall faster than its canopy";
        check(tension_n > 0.0, "tension of the riser in the steady descent", expected, tension_n)?;
        Ok(SteadyDescent { speed_m_s: low, tension_n })
    }

    /// What the small swings under a full canopy depend on.
    pub fn small_swings(
        &self,
        mass: &MassProperties,
        site: &Environment,
        descent: &SteadyDescent,
    ) -> SmallSwings {
        let SteadyDescent { speed_m_s, tension_n } = *descent;
        SmallSwings {
            tension_n,
            length_m: self.riser.length_m + tension_n / self.riser.stiffness_n_m,
            arm_m: self.riser.attachment_body_m.norm(),
            mass_kg: mass.mass_kg,
            inertia_kg_m2: mass.inertia_kg_m2[(1, 1)],
            canopy_kg: self.canopy.inertia_kg(f64::INFINITY),
            canopy_drag_n_s_m: 0.5 * site.density_kg_m3 * self.canopy.drag_area_m2 * speed_m_s,
        }
    }

    /// One over the least mass that the confluence point of a vehicle feels like [1/kg].
    pub fn confluence_per_kg(&self, mass: &MassProperties) -> f64 {
        let arm_m = self.riser.attachment_body_m.norm();
        let turning = arm_m * arm_m * mass.inertia_inverse.symmetric_eigenvalues().max();
        1.0 / mass.mass_kg + turning
    }

    /// Highest angular frequency of the riser between both bodies at `t_s` from the beginning of the hang
    /// [rad/s], and the rate at which its damper acts [1/s], of a vehicle with this
    /// [`Self::confluence_per_kg`].
    #[inline(always)]
    pub fn riser_rates_per_s<S: Real>(&self, confluence_per_kg: f64, t_s: S) -> (S, S) {
        let per_kg = t_s.of(1.0) / self.canopy.inertia_kg(t_s) + confluence_per_kg;
        ((per_kg * self.riser.stiffness_n_m).sqrt(), per_kg * self.riser.damping_n_s_m)
    }
}

impl SmallSwings {
    /// The canopy held in its place.
    pub fn with_canopy_held(self) -> Self {
        Self { canopy_kg: f64::INFINITY, canopy_drag_n_s_m: 0.0, ..self }
    }

    /// `sigma`, `B` and `C` of the polynomial.
    fn coefficients(&self) -> (f64, f64, f64) {
        let Self { tension_n: t, length_m: l, arm_m: a, mass_kg, inertia_kg_m2: i, .. } = *self;
        let sigma = t * a / i;
        (sigma, l * sigma + t / mass_kg + t * a * a / i, t * sigma / mass_kg)
    }

    /// The angular frequencies of both oscillations without drag, the slower one first [rad/s].
    pub fn frequencies_rad_s(&self) -> [f64; 2] {
        let (sigma, b, c) = self.coefficients();
        let canopy = self.tension_n / self.canopy_kg;
        let (b, c) = ((b + canopy) / self.length_m, (c + canopy * sigma) / self.length_m);
        let fast_2 = 0.5 * (b + (b * b - 4.0 * c).max(0.0).sqrt());
        [(c / fast_2).sqrt(), fast_2.sqrt()]
    }

    /// The vehicle's swing about the confluence point: the faster oscillation under a canopy that is held, as
    /// it becomes when the canopy is free to move.
    pub fn swing(&self) -> SwingMode {
        let (sigma, b, c) = self.coefficients();
        let [_, fast] = self.with_canopy_held().frequencies_rad_s();
        let mut s = Complex::new(0.0, fast);
        // The canopy grows lighter, from a held one to this, and Newton's method follows the root.
        for step in 1..=RELEASE_STEPS {
            let free = f64::from(step) / f64::from(RELEASE_STEPS) / self.canopy_kg;
            let (canopy, kappa, l) = (self.tension_n * free, self.canopy_drag_n_s_m * free, self.length_m);
            let polynomial = [l, l * kappa, b + canopy, b * kappa, c + canopy * sigma, c * kappa];
            for _ in 0..6 {
                let zero = Complex::new(0.0, 0.0);
                let (value, slope) = polynomial
                    .iter()
                    .fold((zero, zero), |(value, slope), x| (value * s + x, slope * s + value));
                if slope.norm_sqr() > 0.0 {
                    s -= value / slope;
                }
            }
        }
        let (canopy, kappa) = (self.tension_n / self.canopy_kg, self.canopy_drag_n_s_m / self.canopy_kg);
        let riser = (s * s + sigma) / sigma;
        let canopy_m = riser * canopy / (s * (s + kappa));
        SwingMode { rate: s, riser, canopy_m, vehicle_m: canopy_m + riser * self.length_m + self.arm_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn titan() -> SmallSwings {
        SmallSwings {
            tension_n: 790.0 * 1.35,
            length_m: 10.0,
            arm_m: 1.0,
            mass_kg: 790.0,
            inertia_kg_m2: 890.0,
            canopy_kg: 270.0,
            canopy_drag_n_s_m: 360.0,
        }
    }

    /// The double pendulum held above, by hand: `w^4 l k^2 - w^2 g (k^2 + a^2 + a l) + g^2 a = 0`. A riser of
    /// no length leaves the rigid pendulum, `w^2 = g a/(a^2 + k^2)`; one without end lets the vehicle turn
    /// about its centre of mass, `w^2 = g a/k^2`.
    #[test]
    fn closed_form_frequencies_of_the_double_pendulum() {
        let held = titan().with_canopy_held();
        let (g, k2) = (1.35, 890.0 / 790.0);
        for w in held.frequencies_rad_s() {
            let w2 = w * w;
            let left = w2 * w2 * 10.0 * k2 - w2 * g * (k2 + 1.0 + 10.0) + g * g;
            assert!(left.abs() < 1e-12, "{w}: {left}");
        }
        let [pendulum, _] = SmallSwings { length_m: 1e-9, ..held }.frequencies_rad_s();
        assert!((pendulum * pendulum - g / (1.0 + k2)).abs() < 1e-8);
        let [_, turns] = SmallSwings { length_m: 1e9, ..held }.frequencies_rad_s();
        assert!((turns * turns - g / k2).abs() < 1e-8);
    }

    /// The confluence point that lets the lander swing at the paper's 2 rad/s, canopy held, by hand: `a^2 +
    /// (l - g/w^2) a + k^2 = w^2 l k^2/g` is solved by 2.62 m under 10 m of riser; rigid on a pivot, at most
    /// `sqrt(g/(2 k))`, 0.80 rad/s.
    #[test]
    fn closed_form_attachment_of_the_papers_swing() {
        let (g, k2, l) = (1.35f64, 890.0 / 790.0, 10.0f64);
        let half = 0.5 * (l - g / 4.0);
        let arm_m = (half * half + 4.0 * l * k2 / g - k2).sqrt() - half;
        assert!((arm_m - 2.625).abs() < 1e-3, "{arm_m}");
        let [_, fast] = SmallSwings { arm_m, ..titan().with_canopy_held() }.frequencies_rad_s();
        assert!((fast - 2.0).abs() < 1e-12, "{fast}");
        let pivot = |arm_m| {
            SmallSwings { arm_m, length_m: 1e-9, ..titan().with_canopy_held() }.frequencies_rad_s()[0]
        };
        let most = pivot(k2.sqrt());
        assert!((most - (g / (2.0 * k2.sqrt())).sqrt()).abs() < 1e-8 && (most - 0.797).abs() < 1e-3);
        assert!(pivot(0.9 * k2.sqrt()) < most && pivot(1.1 * k2.sqrt()) < most);
    }

    /// A swing satisfies the three equations that it was made of, canopy free, light or held.
    #[test]
    fn closed_form_a_swing_satisfies_the_equations_of_motion() {
        for (canopy_kg, drag) in [(270.0, 360.0), (270.0, 0.0), (1e12, 360.0), (5.0, 360.0), (270.0, 5e3)] {
            let swings = SmallSwings { canopy_kg, canopy_drag_n_s_m: drag, ..titan() };
            let SwingMode { rate: s, riser, canopy_m, vehicle_m } = swings.swing();
            let t = swings.tension_n;
            let misses = [
                s * s * canopy_m * canopy_kg - (riser * t - s * canopy_m * drag),
                s * s * vehicle_m * 790.0 + riser * t,
                s * s * 890.0 + (Complex::new(1.0, 0.0) - riser) * t,
            ];
            for miss in misses {
                assert!(miss.norm_sqr().sqrt() < 1e-9 * t, "{canopy_kg} {drag}: {miss}");
            }
            // The vehicle's, not the canopy's: 1.15 rad/s under a canopy that is held.
            assert!(s.re <= 1e-12 && s.im > 1.0 && s.im < 1.4, "{canopy_kg} {drag}: {s}");
        }
    }
}
