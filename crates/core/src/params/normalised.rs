//! PX4's normalised torque and thrust in N m and N.
//!
//! PX4's allocator takes `M = pinv(E)` of the effectiveness `E` (moments and forces per rotor command, from
//! CA_ROTORn_*), divides the roll and pitch columns by `s = max over both of sqrt(sum M_i^2/(n/2))`, the yaw
//! column by its largest entry and the thrust column by its mean. Motor commands become thrusts `T_max u`
//! (THR_MDL_FAC = 1). One unit is then
//!
//! ```text
//! G_j = (T_max/C_T) (E M)_jj / s_j
//! ```
//!
//! with `(E M)_jj = 1` for axes that the rotors can drive. An X-quad of half-spans lx, ly has `G_roll =
//! G_pitch = 2 sqrt(2) T_max min(lx, ly)` and `G_yaw = 4 T_max K_M`. With THR_MDL_FAC = 0 motor commands are
//! throttles, and `T_max` is the thrust at full throttle of the line through hover, as
//! [`crate::control::ThrustCurve`] has it.
//!
//! Up to v1.12 PX4 mixes by files instead, and its `quad_x` gives each rotor the same share of roll and of
//! pitch wherever it is: `u_i = (+-roll +-pitch)/sqrt(2) +-yaw + thrust`. Then `G_roll = 2 sqrt(2) T_max ly`
//! and `G_pitch = 2 sqrt(2) T_max lx` ([`Mixing::QuadX`]); the two are the same for a square.

use super::ParamsError;
pub use crate::control::px4::effectiveness::THRUST_COEFFICIENT;
use crate::control::px4::effectiveness::{PseudoInverse, effectiveness, mean_share, spread};
use crate::control::px4::versions::{Allocation, Number};
use crate::control::px4::{Law, Version};
use crate::model::Vehicle;

/// Physical size of one unit of PX4's normalised torques and thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalisedUnits {
    /// Moment of one unit of roll torque [N m].
    pub roll_nm: f64,
    /// Moment of one unit of pitch torque [N m].
    pub pitch_nm: f64,
    /// Moment of one unit of yaw torque [N m]; `None` when the rotors have no torque.
    pub yaw_nm: Option<f64>,
    /// Force of one unit of thrust along the body's up axis [N].
    pub thrust_n: f64,
}

/// PX4's way from normalised torques and thrust to motor commands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mixing {
    /// By control allocation, from the rotors' CA_* parameters.
    #[default]
    Allocated,
    /// By the mixer file `quad_x`, which ignores distances.
    QuadX,
}

impl Mixing {
    /// The way of a PX4 of a law.
    pub fn of(law: &Law) -> Self {
        if law.allocates { Self::Allocated } else { Self::QuadX }
    }

    /// The way of a version of PX4.
    pub fn of_version(px4: Number) -> Self {
        match Version::of(px4).allocation {
            Allocation::Parameters => Self::Allocated,
            Allocation::MixerFiles => Self::QuadX,
        }
    }
}

impl NormalisedUnits {
    /// Units of a vehicle with the given mixing in air of a density [kg/m^3]. `QuadX` applies to four rotors
    /// in an X only; for others [`Self::of`] holds.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn mixed(vehicle: &Vehicle, density_kg_m3: f64, mixing: Mixing) -> Result<Self, ParamsError> {
        let units = Self::of(vehicle, density_kg_m3)?;
        if mixing == Mixing::Allocated {
            return Ok(units);
        }
        // Each rotor gives T_max/sqrt(2) of a unit.
        let share_n = vehicle.static_thrust_n(density_kg_m3) * std::f64::consts::FRAC_1_SQRT_2;
        let arm_m = |axis: usize| vehicle.rotors.iter().map(|r| r.position_body_m[axis].abs()).sum::<f64>();
        Ok(Self { roll_nm: share_n * arm_m(1), pitch_nm: share_n * arm_m(0), ..units })
    }

    /// Units of a vehicle in air of a density [kg/m^3], with rotors as CA_ROTORn_* describe them.
    ///
    /// # Errors
    /// [`ParamsError::NoUnit`] when the rotors cannot make roll, pitch or thrust.
    pub fn of(vehicle: &Vehicle, density_kg_m3: f64) -> Result<Self, ParamsError> {
        let inverse = PseudoInverse::of(&effectiveness(vehicle, density_kg_m3));
        let newton = vehicle.static_thrust_n(density_kg_m3) / THRUST_COEFFICIENT;
        let [roll, pitch, yaw, thrust] = [0, 1, 2, 5].map(|axis| inverse.column(axis));
        let tilt_scale = spread(&roll.m).max(spread(&pitch.m));
        let thrust_scale = mean_share(&thrust.m);
        let unit = |axis, made: f64, scale: f64| {
            let g = newton * made / scale;
            if g.is_finite() && g > 0.0 { Ok(g) } else { Err(ParamsError::NoUnit { axis }) }
        };
        Ok(Self {
            roll_nm: unit("roll moment", roll.made, tilt_scale)?,
            pitch_nm: unit("pitch moment", pitch.made, tilt_scale)?,
            yaw_nm: unit("yaw moment", yaw.made, yaw.m.max()).ok(),
            thrust_n: unit("thrust", thrust.made, thrust_scale)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::test_vehicles::{THRUST_LIMIT_N, lander, quadrotor, ring};
    use crate::model::VehicleOptions;

    const DENSITY: f64 = 5.4;

    fn close(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-9 * b.abs()
    }

    #[test]
    fn closed_form_of_the_x_quad() {
        for (lx, ly) in [(0.95, 1.1), (1.1, 0.95), (0.17678, 0.17678), (0.3, 0.05)] {
            let vehicle = quadrotor([lx, ly], [0.02; 3], [0.0; 3], VehicleOptions::default());
            let units = NormalisedUnits::of(&vehicle, DENSITY).unwrap();
            let g = 2.0 * 2f64.sqrt() * THRUST_LIMIT_N * lx.min(ly);
            assert!(close(units.roll_nm, g) && close(units.pitch_nm, g), "{units:?}, {g}");
            assert!(close(units.yaw_nm.unwrap(), 4.0 * THRUST_LIMIT_N * 0.05), "{units:?}");
            assert!(close(units.thrust_n, 4.0 * THRUST_LIMIT_N), "{units:?}");
        }
    }

    /// The moments that the mixer file makes: u = 1/sqrt(2) on the four rotors of a unit of roll, each with
    /// T_max at its half-span.
    #[test]
    fn closed_form_of_the_mixer_file() {
        for (lx, ly) in [(0.95, 1.1), (1.1, 0.95), (0.3, 0.3)] {
            let vehicle = quadrotor([lx, ly], [0.02; 3], [0.0; 3], VehicleOptions::default());
            let units = NormalisedUnits::mixed(&vehicle, DENSITY, Mixing::QuadX).unwrap();
            let g = 2.0 * 2f64.sqrt() * THRUST_LIMIT_N;
            assert!(close(units.roll_nm, g * ly) && close(units.pitch_nm, g * lx), "{units:?}, {g}");
            let allocated = NormalisedUnits::mixed(&vehicle, DENSITY, Mixing::Allocated).unwrap();
            assert_eq!((units.yaw_nm, units.thrust_n), (allocated.yaw_nm, allocated.thrust_n));
        }
    }

    /// A hexagon of arm r: M = 1/(3 C_T r) times sines and cosines; the roll column has two zeros when a
    /// rotor is ahead.
    #[test]
    fn closed_form_of_the_hexagon() {
        let r = 1.4;
        let units = NormalisedUnits::of(&ring(6, [r, r], 0.0), DENSITY).unwrap();
        // sum of squares 3/(3 C_T r)^2 in both; 4 rotors count for roll, 6 for pitch.
        let s = (3.0 / (4.0 / 2.0f64)).sqrt() / (3.0 * THRUST_COEFFICIENT * r);
        let g = THRUST_LIMIT_N / THRUST_COEFFICIENT / s;
        assert!(close(units.roll_nm, g) && close(units.pitch_nm, g), "{units:?}, {g}");
        assert!(close(units.yaw_nm.unwrap(), 6.0 * THRUST_LIMIT_N * 0.05), "{units:?}");
    }

    #[test]
    fn rotors_that_cannot_steer_are_refused() {
        let mut line = lander(true);
        for rotor in &mut line.rotors {
            rotor.position_body_m.y = 0.0;
        }
        assert_eq!(NormalisedUnits::of(&line, DENSITY), Err(ParamsError::NoUnit { axis: "roll moment" }));
    }
}
