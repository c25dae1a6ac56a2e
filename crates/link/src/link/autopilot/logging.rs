//! What goes into the flight log: a record of each control step, and every event that is reported.

use std::collections::VecDeque;

use mavlink::dialects::common::{BATTERY_STATUS_DATA, HIL_GPS_DATA, HIL_SENSOR_DATA};
use nalgebra::Vector3;

use super::hil::VehicleState;
use super::vehicle::Vehicle;
use crate::autopilot::flight_log::{BatteryState, LogEntry, Pose, SatelliteFix, Sensors, StepRecord};
use crate::control::px4::filter::Derivative;
use crate::frames::rotate_ned_from_body;
use crate::link::wire::vector;
use crate::model::environment::GeoPoint;
use crate::time::{TimeUs, seconds};

/// Entries of a flight's log that wait to be fetched; before simulated time runs there is no flight. Bounded:
/// when nobody fetches, the oldest go, and a gap stands for them. Beginnings of flights stay.
#[derive(Clone, Debug, Default)]
pub(super) struct LogQueue {
    waiting: VecDeque<LogEntry>,
    in_flight: bool,
}

impl LogQueue {
    const MOST: usize = 512;

    /// Begins the log of a flight; that of the one before, if any, is complete.
    pub(super) fn begin(&mut self, entry: LogEntry) {
        self.in_flight = true;
        self.push(entry);
    }

    /// Ends the flight: nothing is logged until the next begins.
    pub(super) fn end(&mut self) {
        self.in_flight = false;
    }

    /// Adds an entry.
    pub(super) fn push(&mut self, entry: LogEntry) {
        if !self.in_flight {
            return;
        }
        while self.waiting.len() >= Self::MOST {
            self.shorten();
        }
        self.waiting.push_back(entry);
    }

    /// Puts a gap in place of the oldest entry that neither begins a flight nor is a gap; where one stands
    /// before it, that stands for both.
    fn shorten(&mut self) {
        let lasting = |entry: &LogEntry| matches!(entry, LogEntry::Begin(..) | LogEntry::Gap);
        match self.waiting.iter().position(|entry| !lasting(entry)) {
            Some(i) if i == 0 || self.waiting[i - 1] != LogEntry::Gap => self.waiting[i] = LogEntry::Gap,
            Some(i) => _ = self.waiting.remove(i),
            // Nothing but beginnings.
            None => _ = self.waiting.pop_front(),
        }
    }

    /// Takes the oldest entry.
    pub(super) fn poll(&mut self) -> Option<LogEntry> {
        self.waiting.pop_front()
    }
}

/// Makes records of control steps.
#[derive(Clone, Debug, Default)]
pub(super) struct Recorder {
    before_us: TimeUs,
    /// Of the rates that are flown by, and of the simulator's.
    alpha_body: [Derivative; 2],
}

impl Recorder {
    /// IMU_DGYRO_CUTOFF, PX4's default [Hz].
    const CUTOFF_HZ: f64 = 30.0;

    /// The record of the control step that was made on this state, with the simulator's truth beside it;
    /// `None` before the first sensors.
    pub(super) fn record(
        &mut self,
        now: TimeUs,
        vehicle: &Vehicle,
        state: &VehicleState,
    ) -> Option<StepRecord> {
        let truth = vehicle.hil.state(now);
        let dt_s = seconds(now.saturating_sub(self.before_us));
        self.before_us = now;
        let states = [Some(state), truth.as_ref()];
        let mut alphas_body = [Vector3::zeros(); 2];
        for ((derivative, state), alpha_body) in self.alpha_body.iter_mut().zip(states).zip(&mut alphas_body)
        {
            if let Some(state) = state.filter(|_| dt_s > 0.0) {
                *alpha_body = derivative.update(state.measurement.omega_body, Self::CUTOFF_HZ, dt_s);
            }
        }
        record(now, vehicle, state, alphas_body)
    }
}

fn record(
    now: TimeUs,
    vehicle: &Vehicle,
    state: &VehicleState,
    [estimated_alpha_body, true_alpha_body]: [Vector3<f64>; 2],
) -> Option<StepRecord> {
    let Vehicle { autopilot, environment, facts, hil, .. } = vehicle;
    let sensors = sensors(hil.sensor.as_ref()?);
    let gravity_ned = environment.gravity_ned();
    let pose = |state: &VehicleState, alpha_body| {
        let m = &state.measurement;
        Pose {
            p_ned: state.p_ned,
            q_ned_from_body: m.q_ned_from_body,
            v_ned: m.v_ned,
            a_ned: rotate_ned_from_body(m.q_ned_from_body, sensors.specific_force_body) + gravity_ned,
            omega_body: m.omega_body,
            alpha_body,
        }
    };
    let output = *autopilot.output();
    Some(StepRecord {
        at: now,
        epoch_unix_us: facts.epoch_unix_us,
        origin: environment.anchor,
        gravity_m_s2: environment.gravity_m_s2,
        density_kg_m3: environment.density_kg_m3,
        estimate: pose(state, estimated_alpha_body),
        truth: hil.state(now).map_or(Pose::UNKNOWN, |state| pose(&state, true_alpha_body)),
        accuracy: vehicle.estimator.as_ref().and_then(|estimator| estimator.accuracy()),
        ratios: vehicle.estimator.as_ref().and_then(|estimator| Some(estimator.filter()?.ratios)),
        vibration: [hil.vibration.gyroscope, hil.vibration.accelerometer].map(f64::from),
        sensors,
        fix: hil.gps.as_ref().map(satellite_fix),
        battery: hil.battery.as_ref().map(|m| battery_state(m, hil.bus_v())),
        output,
        collective: output.collective_n / autopilot.control_settings().airframe.lift_max_n,
        moments: autopilot.control_settings().airframe.mixer.moment_shares(&output.thrust_n),
        target: autopilot.velocity_target().map(|t| (t.v_ned, t.a_ff_ned, t.yaw_rad)),
        rotors: facts.rotors,
        mode: autopilot.mode(),
        armed: autopilot.is_armed(),
        failsafe: autopilot.in_failsafe(),
        landed: vehicle.is_standing(state),
        system_id: facts.system_id,
    })
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
        // Centimetres, as PX4 takes them.
        horizontal_m: f64::from(m.eph) * 0.01,
        vertical_m: f64::from(m.epv) * 0.01,
    }
}

fn battery_state(m: &BATTERY_STATUS_DATA, bus_v: Option<f64>) -> BatteryState {
    // Less than nothing is what is not known.
    let known = |x: f64| (x >= 0.0).then_some(x);
    BatteryState {
        bus_v,
        // Centiamperes.
        current_a: known(f64::from(m.current_battery) * 0.01),
        drawn_mah: known(f64::from(m.current_consumed)),
        remaining: f64::from(m.battery_remaining) * 0.01,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::params::Value;

    fn parameter(n: usize) -> LogEntry {
        LogEntry::Parameter(n.to_string(), Value::Int(0))
    }

    fn fetched(queue: &mut LogQueue) -> Vec<LogEntry> {
        std::iter::from_fn(|| queue.poll()).collect()
    }

    /// Two flights that nobody fetches, each with more than there is room for: both begin, in one entry each,
    /// and the latest entries are there to the last.
    #[test]
    fn regress_a_full_queue_keeps_where_flights_begin() {
        let begin = |at| LogEntry::Begin(at, BTreeMap::new());
        let mut queue = LogQueue::default();
        for at in [4_000, 8_000] {
            queue.begin(begin(at));
            (0..2 * LogQueue::MOST).for_each(|n| queue.push(parameter(n)));
        }
        let kept = LogQueue::MOST - 4;
        let mut expected = vec![begin(4_000), LogEntry::Gap, begin(8_000), LogEntry::Gap];
        expected.extend((2 * LogQueue::MOST - kept..2 * LogQueue::MOST).map(parameter));
        assert_eq!(fetched(&mut queue), expected);
    }

    #[test]
    fn beginnings_alone_are_bounded_too() {
        let mut queue = LogQueue::default();
        (0..2 * LogQueue::MOST as u64).for_each(|at| queue.begin(LogEntry::Begin(at, BTreeMap::new())));
        assert_eq!(fetched(&mut queue).len(), LogQueue::MOST);
    }
}
