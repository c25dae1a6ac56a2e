//! The vehicle: the state machine with its controller, and all that it knows of where it is and how it moves.

use mavlink::dialects::common::MavMessage;

use super::hil::{HilInput, STATE_LIFETIME_US, VehicleState};
use super::home::Home;
use super::sensing::sense;
use crate::autopilot::estimator::{Estimator, EstimatorSettings};
use crate::autopilot::{Autopilot, FlightMode, Severity};
use crate::control::Measurement;
use crate::model::{Environment, PerRotor};
use crate::time::TimeUs;

/// Slower than this, disarmed, the vehicle counts as standing on something [m/s], as PX4's landing detector
/// has it.
const STANDING_SPEED_M_S: f64 = 0.3;

/// What never changes of a vehicle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facts {
    /// MAVLink system.
    pub system_id: u8,
    /// Number of rotors.
    pub rotors: usize,
    /// Unix time of simulated time 0 [us].
    pub epoch_unix_us: u64,
}

/// What the simulator wants to know at once: it may release on "armed in OFFBOARD", and a failsafe spoils the
/// drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Condition {
    mode: FlightMode,
    armed: bool,
    failsafe: bool,
}

/// The vehicle's state machine, its sources of the state, and home.
#[derive(Clone, Debug)]
pub(super) struct Vehicle {
    pub autopilot: Autopilot,
    pub environment: Environment,
    pub facts: Facts,
    pub hil: HilInput,
    /// The estimator to fly by; `None` flies by the simulator's truth.
    pub estimator: Option<Estimator>,
    pub home: Home,
    /// It has been reported that there is no state to fly by.
    flies_blind: bool,
}

impl Vehicle {
    /// A vehicle that has heard nothing of its simulator.
    pub(super) fn new(
        autopilot: Autopilot,
        environment: Environment,
        facts: Facts,
        estimator: Option<Estimator>,
    ) -> Self {
        let (hil, home) = (HilInput::default(), Home::default());
        Self { autopilot, environment, facts, hil, estimator, home, flies_blind: false }
    }

    /// The newest state, however old: the truth, or the estimate.
    pub(super) fn latest_state(&self) -> Option<VehicleState> {
        let Some(estimator) = &self.estimator else { return self.hil.latest() };
        let (at, p_ned, measurement) = estimator.estimate()?;
        Some(VehicleState { at, p_ned, measurement })
    }

    /// The state to fly by at `now`, if there is one that is young enough.
    pub(super) fn state(&self, now: TimeUs) -> Option<VehicleState> {
        match self.estimator {
            Some(_) => self.latest_state().filter(|s| now.saturating_sub(s.at) <= STATE_LIFETIME_US),
            None => self.hil.state(now),
        }
    }

    /// Whether the vehicle stands: not in the air by command, and without speed.
    pub(super) fn is_standing(&self, state: &VehicleState) -> bool {
        !self.autopilot.is_in_air() && state.measurement.v_ned.norm() <= STANDING_SPEED_M_S
    }

    /// Mode, arming and failsafe.
    pub(super) fn condition(&self) -> Condition {
        let Self { autopilot, .. } = self;
        Condition { mode: autopilot.mode(), armed: autopilot.is_armed(), failsafe: autopilot.in_failsafe() }
    }

    /// Takes a message of the simulator.
    pub(super) fn take(&mut self, message: &MavMessage) {
        self.hil.take(message, &self.environment);
        if let MavMessage::BATTERY_STATUS(m) = message
            && m.battery_remaining >= 0
        {
            self.autopilot.guard.set_charge(f64::from(m.battery_remaining) / 100.0);
        }
    }

    /// Simulated time has started over and is at `now`: the flight that was is forgotten.
    pub(super) fn start_over(&mut self, now: TimeUs, gps_delay_us: TimeUs) {
        self.autopilot.restart();
        self.hil.start_over(now);
        self.restart_estimator(gps_delay_us);
        self.home = Home::default();
    }

    /// Begins the estimate anew, with satellite fixes that are late by `gps_delay_us`.
    pub(super) fn restart_estimator(&mut self, gps_delay_us: TimeUs) {
        if let Some(estimator) = &mut self.estimator {
            *estimator = Estimator::new(EstimatorSettings { gps_delay_us, ..*estimator.settings() });
        }
    }

    /// One control step at the time of the latest HIL_SENSOR: the throttles, and the state that they were
    /// made for.
    pub(super) fn step(&mut self, now: TimeUs) -> (PerRotor, Option<VehicleState>) {
        if let (Some(estimator), Some(sensor)) = (&mut self.estimator, &self.hil.sensor) {
            sense(estimator, sensor, self.hil.gps.as_ref(), &self.environment);
            self.autopilot.watch_estimator(now, estimator);
        }
        let Some(state) = self.state(now) else { return (self.step_blind(now), None) };
        self.flies_blind = false;
        self.home.follow(&state, self.autopilot.is_armed());
        if let Some(home) = self.home.place_ned() {
            self.autopilot.set_home(home);
        }
        let measurement = Measurement { bus_v: self.hil.bus_v(), ..state.measurement };
        (self.autopilot.step(now, &state.p_ned, &measurement), Some(state))
    }

    fn step_blind(&mut self, now: TimeUs) -> PerRotor {
        if !self.flies_blind && self.autopilot.is_armed() {
            self.flies_blind = true;
            let text = match self.estimator {
                Some(_) => "no estimate: flying blind",
                None => "no ODOMETRY or HIL_STATE_QUATERNION: flying blind",
            };
            self.autopilot.say(Severity::Emergency, text);
        }
        self.autopilot.coast(now)
    }
}
