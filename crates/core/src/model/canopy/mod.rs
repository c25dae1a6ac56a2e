//! The canopy as a body of its own, and the riser that the vehicle hangs from.
//!
//! | file | holds |
//! |---|---|
//! | `riser` | the riser's pull on both bodies |
//! | `swing` | steady descent, and the motions of two bodies that swing a little |
//!
//! The canopy is a point mass with drag from all sides alike, and with the air that it takes along, the
//! apparent mass m_a. With u its velocity through the air at its place and T the riser's pull on it:
//!
//! ```text
//! d/dt ((m + m_a) v) = m g - (1/2) rho CdS |u| u + T + m_a_dot w        u = v - w
//! ```
//!
//! The apparent mass has inertia and no weight. It is the same in all directions, a choice: across its axis a
//! canopy takes less air along. The air that a filling canopy takes in (the last term) comes with the wind's
//! velocity. What an accelerating wind does to the apparent mass is left out: a force `m_a Dw/Dt` (Auton,
//! Hunt and Prud'homme, J. Fluid Mech. 197, 1988), which is nothing in a wind by altitude and in eddies that
//! are carried along, both of which the canopy meets by moving through them.

use nalgebra::Vector3;

use super::environment::Ambient;
use super::{ModelError, check, check_positive};
use crate::real::Real;
use crate::vector::V3;

mod riser;
mod swing;

pub use riser::{Pull, Riser};
pub use swing::{SmallSwings, SteadyDescent, SwingMode, sinking_v_dot_ned};

/// Drag coefficient on the nominal area of the canopy that an inflated radius is guessed from: a choice, of
/// the range 0.75 to 0.9 that handbooks give round canopies.
const NOMINAL_DRAG_COEFFICIENT: f64 = 0.8;
/// Inflated over nominal diameter of that canopy: a choice.
const INFLATED_OVER_NOMINAL: f64 = 0.67;

/// A canopy: a point mass with drag and apparent mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Canopy {
    /// Mass, with that of its riser [kg].
    pub mass_kg: f64,
    /// Drag area C_d S when it is full [m^2].
    pub drag_area_m2: f64,
    /// Apparent mass when it is full [kg].
    pub apparent_mass_kg: f64,
    /// How it fills at the beginning of the hang; `None`: it is full.
    pub opening: Option<Opening>,
}

/// How a canopy fills, from the beginning of the hang: its drag area as the square of the time, its apparent
/// mass, which goes by the volume, as the cube.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Time until it is full [s].
    pub duration_s: f64,
    /// Rate of descent of both bodies at its beginning, through the air [m/s].
    pub descent_m_s: f64,
}

/// Position and velocity of a canopy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CanopyState {
    /// Position from the point of release, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity over ground, NED [m/s].
    pub v_ned: Vector3<f64>,
}

/// A canopy and the riser between it and the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Suspension {
    /// The canopy.
    pub canopy: Canopy,
    /// The riser.
    pub riser: Riser,
}

/// Inflated radius of a round canopy of this drag area [m], where it is not known: that of a nominal area
/// with the drag coefficient 0.8, inflated to 0.67 of the nominal diameter.
pub fn inflated_radius_m(drag_area_m2: f64) -> f64 {
    let nominal_diameter_m = (4.0 * drag_area_m2 / (NOMINAL_DRAG_COEFFICIENT * std::f64::consts::PI)).sqrt();
    0.5 * INFLATED_OVER_NOMINAL * nominal_diameter_m
}

/// Apparent mass [kg] of a canopy: `factor rho (2/3) pi R^3`, the air of a hemisphere of its inflated radius.
/// RocketPy (`parachute.py`) has 1.000 for the factor at its usual porosity, 0.0432.
pub fn apparent_mass_kg(factor: f64, density_kg_m3: f64, inflated_radius_m: f64) -> f64 {
    let r = inflated_radius_m;
    factor * density_kg_m3 * (2.0 / 3.0 * std::f64::consts::PI * r * r * r)
}

/// How much of a canopy is there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Filling<S> {
    drag_area: S,
    apparent_mass: S,
    apparent_mass_per_s: S,
}

impl Canopy {
    /// Checks masses [kg] and drag area [m^2], and how it fills.
    ///
    /// # Errors
    /// [`ModelError`] when mass or drag area is not positive, the apparent mass is negative, or the opening
    /// takes no time or is upwards.
    pub fn new(
        mass_kg: f64,
        drag_area_m2: f64,
        apparent_mass_kg: f64,
        opening: Option<Opening>,
    ) -> Result<Self, ModelError> {
        check_positive("canopy mass", mass_kg)?;
        check_positive("canopy drag area", drag_area_m2)?;
        let possible = apparent_mass_kg.is_finite() && apparent_mass_kg >= 0.0;
        check(possible, "apparent mass", "at least zero", apparent_mass_kg)?;
        if let Some(Opening { duration_s, descent_m_s }) = opening {
            check_positive("opening time", duration_s)?;
            let down = descent_m_s.is_finite() && descent_m_s >= 0.0;
            check(down, "descent at the opening", "at least zero", descent_m_s)?;
        }
        Ok(Self { mass_kg, drag_area_m2, apparent_mass_kg, opening })
    }

    /// How far it has filled at `t_s` from the beginning of the hang [s].
    #[inline(always)]
    fn filling<S: Real>(&self, t_s: S) -> Filling<S> {
        let (zero, one) = (t_s.of(0.0), t_s.of(1.0));
        let full = Filling { drag_area: one, apparent_mass: one, apparent_mass_per_s: zero };
        let Some(Opening { duration_s, .. }) = self.opening else { return full };
        let duration_s = t_s.of(duration_s);
        let fills = t_s.less(duration_s);
        let x = (t_s / duration_s).at_least(zero);
        Filling {
            drag_area: S::select(fills, x * x, one),
            apparent_mass: S::select(fills, x * x * x, one),
            apparent_mass_per_s: S::select(fills, x * 3.0 * x / duration_s, zero),
        }
    }

    /// Mass and apparent mass at `t_s` from the beginning of the hang [kg].
    #[inline(always)]
    pub fn inertia_kg<S: Real>(&self, t_s: S) -> S {
        self.filling(t_s).apparent_mass * self.apparent_mass_kg + self.mass_kg
    }

    /// Force on canopy and apparent mass but for the riser's, NED [N]: weight, drag, and the momentum of the
    /// air taken in, at a velocity over ground [m/s] where it is, `t_s` from the beginning of the hang [s].
    #[inline(always)]
    pub fn outer_force_ned<S: Real>(&self, there: &Ambient<S>, v_ned: V3<S>, t_s: S) -> V3<S> {
        let Filling { drag_area, apparent_mass_per_s, .. } = self.filling(t_s);
        let (zero, wind_ned) = (t_s.of(0.0), there.wind_ned_m_s);
        let u_ned = v_ned - wind_ned;
        let drag = there.density_kg_m3 * 0.5 * (drag_area * self.drag_area_m2) * u_ned.norm();
        let taken_in = apparent_mass_per_s * self.apparent_mass_kg;
        let weight_ned = V3::new(zero, zero, there.gravity_m_s2 * self.mass_kg);
        weight_ned - u_ned * drag + wind_ned * taken_in
    }

    /// Rate at which drag takes the canopy's speed through the air away [1/s], at that speed [m/s].
    #[inline(always)]
    pub fn drag_rate_per_s<S: Real>(&self, density_kg_m3: f64, airspeed_m_s: S, t_s: S) -> S {
        let area_m2 = self.filling(t_s).drag_area * self.drag_area_m2;
        area_m2 * density_kg_m3 * airspeed_m_s / self.inertia_kg(t_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hemisphere of 1 m in air of 1.225 kg/m^3 holds 2.5656 kg. 43.9 m^2, Titan's: a nominal diameter of
    /// 8.36 m, an inflated radius of 2.80 m, 248 kg at 5.4 kg/m^3.
    #[test]
    fn closed_form_apparent_mass() {
        assert!((apparent_mass_kg(1.0, 1.225, 1.0) - 2.565_634).abs() < 1e-6);
        let r = inflated_radius_m(43.9);
        assert!((r - 2.8002).abs() < 1e-4, "{r}");
        assert!((apparent_mass_kg(1.0, 5.4, r) - 248.3).abs() < 0.1);
        assert_eq!(apparent_mass_kg(2.0, 5.4, r), 2.0 * apparent_mass_kg(1.0, 5.4, r));
    }

    /// The rate of the apparent mass is its derivative; full at the end of the opening, and from there on.
    #[test]
    fn closed_form_a_canopy_fills() {
        let opening = Some(Opening { duration_s: 2.0, descent_m_s: 8.0 });
        let canopy = Canopy::new(3.0, 10.0, 20.0, opening).unwrap();
        assert_eq!(canopy.inertia_kg(0.0), 3.0);
        assert_eq!(canopy.inertia_kg(1.0), 3.0 + 20.0 / 8.0);
        assert_eq!((canopy.inertia_kg(2.0), canopy.inertia_kg(9.0)), (23.0, 23.0));
        let h = 1e-6;
        let slope = (canopy.inertia_kg(1.3 + h) - canopy.inertia_kg(1.3 - h)) / (2.0 * h);
        assert!((slope - 20.0 * canopy.filling(1.3).apparent_mass_per_s).abs() < 1e-8);
        assert_eq!(canopy.filling(1.0).drag_area, 0.25);
    }

    #[test]
    fn impossible_canopies_are_refused() {
        let refused = |mass, area, apparent, opening| Canopy::new(mass, area, apparent, opening).is_err();
        assert!(
            refused(0.0, 1.0, 1.0, None) && refused(1.0, 0.0, 1.0, None) && refused(1.0, 1.0, -1.0, None)
        );
        assert!(refused(1.0, 1.0, 1.0, Some(Opening { duration_s: 0.0, descent_m_s: 1.0 })));
        assert!(refused(1.0, 1.0, 1.0, Some(Opening { duration_s: 1.0, descent_m_s: -1.0 })));
        assert!(!refused(1.0, 1.0, 0.0, None));
    }
}
