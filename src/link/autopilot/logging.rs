//! What goes into the flight log: a record of each control step, and everything that is said.

use std::collections::VecDeque;

use mavlink::dialects::common::{HIL_GPS_DATA, HIL_SENSOR_DATA};
use nalgebra::Vector3;

use super::super::flight_log::{LogEntry, Pose, SatelliteFix, Sensors, StepRecord};
use super::AutopilotSession;
use super::hil::VehicleState;
use super::telemetry::is_standing;
use crate::autopilot::Event;
use crate::frames::rotate_ned_from_body;
use crate::model::environment::GeoPoint;
use crate::params::Value;

/// Entries that wait to be fetched. Bounded: when nobody fetches, the oldest go, and a gap stands for them.
#[derive(Clone, Debug, Default)]
pub(super) struct LogQueue {
    waiting: VecDeque<LogEntry>,
}

impl LogQueue {
    const MOST: usize = 512;

    fn push(&mut self, entry: LogEntry) {
        if self.waiting.len() == Self::MOST {
            self.waiting.pop_front();
            self.waiting.pop_front();
            self.waiting.push_front(LogEntry::Gap);
        }
        self.waiting.push_back(entry);
    }
}

impl AutopilotSession {
    /// The next entry of the flight log; fetch until `None` after each `handle_input`.
    pub fn poll_log(&mut self) -> Option<LogEntry> {
        self.log.waiting.pop_front()
    }

    /// A flight begins: the log of the one before, if any, is complete.
    pub(super) fn log_begin(&mut self) {
        self.log.push(LogEntry::Begin(self.clock, self.parameters.values()));
    }

    pub(super) fn log_said(&mut self, event: Event) {
        // Before simulated time runs there is no flight.
        if self.running {
            self.log.push(LogEntry::Said(self.clock, event));
        }
    }

    /// A parameter has another value.
    pub(super) fn log_parameter(&mut self, name: &str, value: Value) {
        if self.running {
            self.log.push(LogEntry::Parameter(name.to_owned(), value));
        }
    }

    /// Logs the control step that was made on this state, and the simulator's truth beside it.
    pub(super) fn log_step(&mut self, state: &VehicleState, sensor: &HIL_SENSOR_DATA) {
        let sensors = sensors(sensor);
        let gravity_ned = self.environment.gravity_ned();
        let pose = |state: &VehicleState| {
            let m = &state.measurement;
            Pose {
                p_ned: state.p_ned,
                q_ned_from_body: m.q_ned_from_body,
                v_ned: m.v_ned,
                a_ned: rotate_ned_from_body(m.q_ned_from_body, sensors.specific_force_body) + gravity_ned,
                omega_body: m.omega_body,
            }
        };
        let (estimate, truth) =
            (pose(state), self.hil.state(self.clock).as_ref().map_or(Pose::UNKNOWN, pose));
        let autopilot = &self.autopilot;
        let output = *autopilot.output();
        let record = StepRecord {
            at: self.clock,
            epoch_unix_us: self.epoch_unix_us,
            origin: self.environment.anchor,
            gravity_m_s2: self.environment.gravity_m_s2,
            density_kg_m3: self.environment.density_kg_m3,
            estimate,
            truth,
            accuracy: self.sensing.as_ref().and_then(|sensing| sensing.estimator().accuracy()),
            sensors,
            fix: self.hil.gps.as_ref().map(satellite_fix),
            output,
            collective: output.collective_n / autopilot.cascade().airframe().lift_max_n,
            target: autopilot.velocity_target().map(|t| (t.v_ned, t.a_ff_ned, t.yaw_rad)),
            rotors: self.rotors,
            mode: autopilot.mode(),
            armed: autopilot.is_armed(),
            failsafe: autopilot.in_failsafe(),
            landed: is_standing(autopilot, state),
            system_id: self.system_id,
        };
        self.log.push(LogEntry::Step(Box::new(record)));
    }
}

fn sensors(m: &HIL_SENSOR_DATA) -> Sensors {
    Sensors {
        specific_force_body: vector([m.xacc, m.yacc, m.zacc]),
        gyro_body: vector([m.xgyro, m.ygyro, m.zgyro]),
        magnetic_field_body: vector([m.xmag, m.ymag, m.zmag]),
        pressure_pa: f64::from(m.abs_pressure) * 100.0,
        pressure_altitude_m: f64::from(m.pressure_alt),
        temperature_c: f64::from(m.temperature),
    }
}

fn satellite_fix(m: &HIL_GPS_DATA) -> SatelliteFix {
    SatelliteFix {
        point: GeoPoint {
            latitude_deg: f64::from(m.lat) * 1e-7,
            longitude_deg: f64::from(m.lon) * 1e-7,
            altitude_m: f64::from(m.alt) * 1e-3,
        },
        v_ned: Vector3::new(f64::from(m.vn), f64::from(m.ve), f64::from(m.vd)) * 0.01,
        satellites: m.satellites_visible,
    }
}

fn vector(v: [f32; 3]) -> Vector3<f64> {
    Vector3::from(v.map(f64::from))
}
