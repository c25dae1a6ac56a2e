//! Whether the vehicle stands on something, found as PX4 finds it: not by a sensor, but by a vehicle that
//! does not move although it is commanded to sink, or whose motors do not carry it.
//!
//! ```text
//! still:     |v_D| < 0.25 m/s, |v_H| < 1.5 m/s, |omega| < 20 deg/s
//! commanded: v_sp,D > 1.1 * 0.25 m/s and |v_D| < v_sp,D/2       (it does not follow)
//! unloaded:  collective < 0.3 m g, or that of an idle throttle stick where the stick is the thrust
//! landed:    still and (commanded or unloaded) for 1 s; in the air again as soon as it is neither
//! ```
//!
//! Where the velocity is not known, how it moves over the ground does not count, as in PX4.
//!
//! The thresholds are PX4's LNDMC_Z_VEL_MAX, LNDMC_XY_VEL_MAX, LNDMC_ROT_MAX and its share of the hover
//! thrust; the second is the sum of its three stages (contact, maybe landed, landed). A fall without thrust
//! is no standing: it does not stay still.

use super::flight::VelocityTarget;
use crate::control::{ControlOutput, Measurement};
use crate::units::RAD_PER_DEG;

/// Slowest vertical motion that counts as one [m/s].
const STILL_DOWN_M_S: f64 = 0.25;
/// Slowest horizontal motion that counts as one [m/s].
const STILL_LEVEL_M_S: f64 = 1.5;
/// Slowest turning that counts as one [rad/s].
const STILL_RATE_RAD_S: f64 = 20.0 * RAD_PER_DEG;
/// A setpoint this many times the still velocity is a descent.
const DESCENT_FACTOR: f64 = 1.1;
/// Below this share of the weight the motors do not carry.
const UNLOADED: f64 = 0.3;
/// How long it must look like it [us].
const LANDED_AFTER_US: u64 = 1_000_000;

/// What the detector looks at in a step.
#[derive(Clone, Copy, Debug)]
pub struct Look<'a> {
    /// Attitude, velocity, rates.
    pub measurement: &'a Measurement,
    /// What is flown to.
    pub target: Option<&'a VelocityTarget>,
    /// What is commanded.
    pub output: &'a ControlOutput,
    /// Weight [N].
    pub weight_n: f64,
    /// Whether the velocity over the ground is known.
    pub knows_velocity: bool,
    /// Thrust up to which a throttle stick that is the thrust is idle [N]; 0 where it is not.
    pub idle_n: f64,
}

impl Look<'_> {
    /// Whether the motors do not carry the vehicle.
    pub fn is_unloaded(&self) -> bool {
        self.output.collective_n < (UNLOADED * self.weight_n).max(self.idle_n)
    }
}

/// The detector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LandDetector {
    since_us: Option<u64>,
    landed_at_us: Option<u64>,
}

impl LandDetector {
    /// Takes a step's look.
    pub fn look(&mut self, now_us: u64, look: &Look<'_>) {
        let m = look.measurement;
        let v_down = m.v_ned.z.abs();
        let still = v_down < STILL_DOWN_M_S
            && (!look.knows_velocity || m.v_ned.xy().norm() < STILL_LEVEL_M_S)
            && m.omega_body.norm() < STILL_RATE_RAD_S;
        let v_sp_down = look.target.map_or(0.0, |target| target.v_ned.z);
        let commanded = v_sp_down > DESCENT_FACTOR * STILL_DOWN_M_S && v_down < 0.5 * v_sp_down;
        if !(still && (commanded || look.is_unloaded())) {
            *self = Self::default();
            return;
        }
        let since = *self.since_us.get_or_insert(now_us);
        if now_us.saturating_sub(since) >= LANDED_AFTER_US {
            self.landed_at_us.get_or_insert(now_us);
        }
    }

    /// Whether it stands.
    pub fn is_landed(&self) -> bool {
        self.landed_at_us.is_some()
    }

    /// How long it has stood at `now_us` [us].
    pub fn landed_for_us(&self, now_us: u64) -> Option<u64> {
        self.landed_at_us.map(|at| now_us.saturating_sub(at))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::LEVEL;
    use nalgebra::Vector3;

    /// Steps of 0.1 s; how long until it counts as landed, if within 3 s.
    fn landed_after_s(v_down: f64, v_sp_down: f64, lift: f64, rate: f64) -> Option<f64> {
        let measurement = Measurement {
            q_ned_from_body: LEVEL,
            v_ned: Vector3::new(0.0, 0.0, v_down),
            omega_body: Vector3::new(rate, 0.0, 0.0),
            bus_v: None,
            pack_a: None,
        };
        let target = VelocityTarget { v_ned: Vector3::new(0.0, 0.0, v_sp_down), ..VelocityTarget::ZERO };
        let output = ControlOutput { collective_n: lift, ..ControlOutput::ZERO };
        let mut detector = LandDetector::default();
        (0..30).find_map(|i| {
            let look = Look {
                measurement: &measurement,
                target: Some(&target),
                output: &output,
                weight_n: 10.0,
                knows_velocity: true,
                idle_n: 0.0,
            };
            detector.look(i * 100_000, &look);
            detector.is_landed().then_some(i as f64 * 0.1)
        })
    }

    #[test]
    fn closed_form_landed_is_still_against_the_demand_or_without_load_for_a_second() {
        assert_eq!(landed_after_s(0.0, 0.7, 9.0, 0.0), Some(1.0));
        assert_eq!(landed_after_s(0.0, 0.0, 2.9, 0.0), Some(1.0));
        for (what, in_the_air) in [
            ("hovers", landed_after_s(0.0, 0.0, 10.0, 0.0)),
            ("sinks as commanded", landed_after_s(0.2, 0.28, 10.0, 0.0)),
            ("sinks slowly as commanded", landed_after_s(0.0, 0.27, 10.0, 0.0)),
            ("falls", landed_after_s(2.0, 0.7, 0.0, 0.0)),
            ("turns", landed_after_s(0.0, 0.7, 9.0, 0.4)),
            ("climbs", landed_after_s(-0.3, -1.0, 2.0, 0.0)),
        ] {
            assert_eq!(in_the_air, None, "{what}");
        }
    }

    #[test]
    fn closed_form_it_is_in_the_air_at_once() {
        let m = Measurement {
            q_ned_from_body: LEVEL,
            v_ned: Vector3::zeros(),
            omega_body: Vector3::zeros(),
            bus_v: None,
            pack_a: None,
        };
        let mut detector = LandDetector::default();
        let mut look = |now_us, lift| {
            let output = ControlOutput { collective_n: lift, ..ControlOutput::ZERO };
            let look = Look {
                measurement: &m,
                target: None,
                output: &output,
                weight_n: 10.0,
                knows_velocity: true,
                idle_n: 0.0,
            };
            assert_eq!(look.is_unloaded(), lift < 3.0);
            assert_eq!(Look { idle_n: 4.0, ..look }.is_unloaded(), lift < 4.0);
            detector.look(now_us, &look);
            detector.landed_for_us(now_us)
        };
        look(0, 0.0);
        assert_eq!((look(1_000_000, 0.0), look(1_500_000, 0.0)), (Some(0), Some(500_000)));
        assert_eq!(look(1_504_000, 3.0), None);
    }
}
