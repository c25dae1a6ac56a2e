//! The simulator's messages, read: the state of the vehicle by ODOMETRY (float32, preferred) or
//! HIL_STATE_QUATERNION of the HIL_SENSOR's time, and the latest sensors, satellite fix and battery.
//!
//! The state is the simulator's truth, as fine as the message that carries it: the vehicle flies by it where
//! there is no estimator (`sensing`), and the flight log sets it beside an estimate. What is not finite is
//! not taken; quaternions are scaled to unit length.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use crate::control::Measurement;
use crate::frames::{normalized, rotate_ned_from_body};
use crate::link::wire::{geo_point, vector};
use crate::model::Environment;
use crate::time::TimeUs;

/// A state older than this is no state to fly by [us].
pub(super) const STATE_LIFETIME_US: TimeUs = 100_000;

/// Where the vehicle is and how it moves, at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VehicleState {
    /// Simulated time.
    pub at: TimeUs,
    /// Position from the local origin, NED [m].
    pub p_ned: Vector3<f64>,
    /// Attitude, velocity, rates.
    pub measurement: Measurement,
}

/// The simulator's latest messages.
#[derive(Clone, Debug, Default)]
pub(super) struct HilInput {
    odometry: Option<VehicleState>,
    coarse: Option<VehicleState>,
    pub sensor: Option<HIL_SENSOR_DATA>,
    pub vibration: Vibration,
    pub gps: Option<HIL_GPS_DATA>,
    /// Whose charge is known.
    pub battery: Option<BATTERY_STATUS_DATA>,
}

/// How much the IMU's readings change from one to the next, as PX4 has it (VehicleIMU.cpp of v1.14): lengths
/// of the changes, each filtered with a hundredth of the new one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Vibration {
    /// Of the rates [rad/s].
    pub gyroscope: f32,
    /// Of the specific force [m/s^2].
    pub accelerometer: f32,
}

impl Vibration {
    fn take(&mut self, before: &HIL_SENSOR_DATA, now: &HIL_SENSOR_DATA) {
        let filtered = |old: f32, a: [f32; 3], b: [f32; 3]| {
            let change = vector(b) - vector(a);
            let new = 0.99 * old + 0.01 * change.norm() as f32;
            if new.is_finite() { new } else { old }
        };
        let rates = |m: &HIL_SENSOR_DATA| [m.xgyro, m.ygyro, m.zgyro];
        let forces = |m: &HIL_SENSOR_DATA| [m.xacc, m.yacc, m.zacc];
        self.gyroscope = filtered(self.gyroscope, rates(before), rates(now));
        self.accelerometer = filtered(self.accelerometer, forces(before), forces(now));
    }
}

impl HilInput {
    /// Takes a message; all but HIL_SENSOR, ODOMETRY, HIL_STATE_QUATERNION, HIL_GPS and BATTERY_STATUS are
    /// left alone.
    pub(super) fn take(&mut self, message: &MavMessage, environment: &Environment) {
        match message {
            MavMessage::HIL_SENSOR(m) => {
                if let Some(before) = &self.sensor {
                    self.vibration.take(before, m);
                }
                self.sensor = Some(m.clone());
            }
            MavMessage::ODOMETRY(m) => self.take_odometry(m),
            MavMessage::HIL_STATE_QUATERNION(m) => self.take_coarse(m, environment),
            MavMessage::HIL_GPS(m) => self.gps = Some(m.clone()),
            MavMessage::BATTERY_STATUS(m) if m.battery_remaining >= 0 => self.battery = Some(m.clone()),
            _ => {}
        }
    }

    fn take_odometry(&mut self, message: &ODOMETRY_DATA) {
        let linear = vector([message.vx, message.vy, message.vz]);
        let q = normalized(message.q.map(f64::from));
        // Velocities are in the child frame: LOCAL_NED, or the body's (BODY_NED, BODY_FRD).
        #[expect(deprecated, reason = "simulators send it")]
        let v_ned = match message.child_frame_id {
            MavFrame::MAV_FRAME_LOCAL_NED => linear,
            MavFrame::MAV_FRAME_BODY_NED | MavFrame::MAV_FRAME_BODY_FRD => rotate_ned_from_body(q, linear),
            _ => return,
        };
        let omega_body = vector([message.rollspeed, message.pitchspeed, message.yawspeed]);
        let p_ned = vector([message.x, message.y, message.z]);
        let measurement = Measurement { q_ned_from_body: q, v_ned, omega_body, bus_v: None, pack_a: None };
        self.odometry = checked(message.time_usec, p_ned, measurement).or(self.odometry);
    }

    fn take_coarse(&mut self, message: &HIL_STATE_QUATERNION_DATA, environment: &Environment) {
        let p_ned = environment.local_ned(&geo_point(message.lat, message.lon, message.alt));
        let v_ned = vector([message.vx, message.vy, message.vz].map(f32::from)) / 100.0;
        let omega_body = vector([message.rollspeed, message.pitchspeed, message.yawspeed]);
        let q_ned_from_body = normalized(message.attitude_quaternion.map(f64::from));
        let measurement = Measurement { q_ned_from_body, v_ned, omega_body, bus_v: None, pack_a: None };
        self.coarse = checked(message.time_usec, p_ned, measurement).or(self.coarse);
    }

    /// Voltage of the battery's bus [V], where it is known.
    pub(super) fn bus_v(&self) -> Option<f64> {
        let known_mv = self.battery.as_ref()?.voltages.iter().take_while(|mv| **mv != u16::MAX);
        let bus_v = known_mv.map(|mv| f64::from(*mv)).sum::<f64>() / 1e3;
        (bus_v > 0.0).then_some(bus_v)
    }

    /// The state to fly by at `now`: the finer of those of this very time, else the newest that is young
    /// enough.
    pub(super) fn state(&self, now: TimeUs) -> Option<VehicleState> {
        let of_now = |s: &VehicleState| s.at == now;
        self.odometry
            .filter(of_now)
            .or(self.coarse.filter(of_now))
            .or_else(|| self.latest().filter(|s| now.saturating_sub(s.at) <= STATE_LIFETIME_US))
    }

    /// Forgets what is from after `now`: simulated time has started over, and what came ahead of the
    /// HIL_SENSOR that shows it is already of the new time.
    pub(super) fn start_over(&mut self, now: TimeUs) {
        self.odometry = self.odometry.filter(|s| s.at <= now);
        self.coarse = self.coarse.filter(|s| s.at <= now);
        self.gps.take_if(|gps| gps.time_usec > now);
    }

    /// The newest state, however old.
    pub(super) fn latest(&self) -> Option<VehicleState> {
        match (self.odometry, self.coarse) {
            (Some(fine), Some(coarse)) if coarse.at > fine.at => Some(coarse),
            (fine, coarse) => fine.or(coarse),
        }
    }
}

/// The state, if all of it is finite.
fn checked(at: TimeUs, p_ned: Vector3<f64>, measurement: Measurement) -> Option<VehicleState> {
    let Measurement { q_ned_from_body, v_ned, omega_body, .. } = &measurement;
    let vectors = p_ned.iter().chain(v_ned).chain(omega_body);
    // A zero quaternion has become NaN in `normalized`.
    let sound = vectors.chain(q_ned_from_body).all(|x| x.is_finite());
    sound.then_some(VehicleState { at, p_ned, measurement })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::quaternion_from_euler;
    use crate::math;
    use crate::model::environment::GeoPoint;
    use approx::assert_relative_eq;

    fn odometry(at: TimeUs) -> ODOMETRY_DATA {
        ODOMETRY_DATA {
            time_usec: at,
            q: quaternion_from_euler(0.0, 0.0, 0.5).map(|c| c as f32),
            vx: 2.0,
            frame_id: MavFrame::MAV_FRAME_LOCAL_NED,
            child_frame_id: MavFrame::MAV_FRAME_BODY_FRD,
            ..Default::default()
        }
    }

    fn coarse(at: TimeUs) -> HIL_STATE_QUATERNION_DATA {
        HIL_STATE_QUATERNION_DATA {
            time_usec: at,
            attitude_quaternion: [1.0, 0.0, 0.0, 0.0],
            vz: 366,
            ..Default::default()
        }
    }

    fn somewhere() -> Environment {
        let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
        Environment::new(9.8, 1.2, Vector3::zeros(), anchor).unwrap()
    }

    #[test]
    fn closed_form_body_velocities_of_odometry_are_turned_into_ned() {
        let mut input = HilInput::default();
        input.take_odometry(&odometry(4_000));
        let v = input.state(4_000).unwrap().measurement.v_ned;
        assert_relative_eq!(
            v,
            Vector3::new(2.0 * math::cos(0.5f64), 2.0 * math::sin(0.5f64), 0.0),
            epsilon = 1e-6
        );
        let ned = ODOMETRY_DATA { child_frame_id: MavFrame::MAV_FRAME_LOCAL_NED, ..odometry(8_000) };
        input.take_odometry(&ned);
        assert_eq!(input.state(8_000).unwrap().measurement.v_ned, Vector3::new(2.0, 0.0, 0.0));
    }

    #[test]
    fn closed_form_the_finest_state_of_the_time_is_flown_by() {
        let mut input = HilInput::default();
        input.take_coarse(&coarse(4_000), &somewhere());
        assert_eq!(input.state(4_000).unwrap().measurement.v_ned.z, 3.66);
        input.take_odometry(&odometry(4_000));
        assert_eq!(input.state(4_000).unwrap().measurement.v_ned.z, 0.0);
        input.take_coarse(&coarse(8_000), &somewhere());
        assert_eq!(input.state(8_000).unwrap().measurement.v_ned.z, 3.66);
        assert!(input.state(8_000 + STATE_LIFETIME_US).is_some());
        assert!(input.state(8_001 + STATE_LIFETIME_US).is_none());
    }

    #[test]
    fn closed_form_what_is_no_state_is_not_taken() {
        let mut input = HilInput::default();
        input.take_odometry(&ODOMETRY_DATA { vx: f32::NAN, ..odometry(1) });
        input.take_odometry(&ODOMETRY_DATA { q: [0.0; 4], ..odometry(1) });
        input.take_odometry(&ODOMETRY_DATA { q: [f32::NAN; 4], ..odometry(1) });
        input.take_odometry(&ODOMETRY_DATA { child_frame_id: MavFrame::MAV_FRAME_GLOBAL, ..odometry(1) });
        assert!(input.latest().is_none());
    }
}
