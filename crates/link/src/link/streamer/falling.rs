//! The release: reported by the parachute, or, where no wire leads to it, found by the fall that the
//! vehicle's accelerometer shows (HIGHRES_IMU), or taken from an autopilot that has found it itself
//! (NAMED_VALUE_INT `t_release` of its own). And how the vehicle was seen from there on.

use mavlink::dialects::common::{HIGHRES_IMU_DATA, NAMED_VALUE_INT_DATA};
use nalgebra::Vector3;

use super::config::StreamerConfig;
use super::event::StreamerEvent;
use super::flight::Flight;
use super::reports::Reports;
use super::state::StreamerState;
use super::trust::Conduct;
use crate::control::{Fall, FreeFallDetector};
use crate::time::{TimeUs, microseconds};

/// What is known of the release.
#[derive(Clone, Debug, Default)]
pub(super) struct Release {
    /// The instant, once it is known.
    pub at: Option<TimeUs>,
    detector: Option<FreeFallDetector>,
    /// The fall by which it was found, where nothing else reported it.
    pub fall: Option<Fall>,
    conduct: Conduct,
}

impl Release {
    /// Simulated time of t = 0 of the plan.
    pub(super) fn plan_start(&self, config: &StreamerConfig) -> Option<TimeUs> {
        self.at.map(|at| at + microseconds(config.delay_s))
    }

    /// What keeps a drop whose plan was streamed to its end, `end_s` from t = 0, from being a success.
    pub(super) fn shortcoming(&self, config: &StreamerConfig, end_s: f64) -> Option<&'static str> {
        let plan_end = self.plan_start(config).map_or(TimeUs::MAX, |start| start + microseconds(end_s));
        self.conduct.shortcoming(config.commands_release, plan_end)
    }

    /// Whether the parachute has obeyed the command.
    pub(super) fn is_obeyed(&self) -> bool {
        self.conduct.obeyed
    }

    /// The parachute has acknowledged the command.
    pub(super) fn note_obeyed(&mut self) {
        self.conduct.obeyed = true;
    }

    /// The parachute says that the vehicle was not armed.
    pub(super) fn note_unarmed(&mut self) {
        self.conduct.strayed = true;
    }

    /// The vehicle has shown itself by a HEARTBEAT.
    pub(super) fn note_shown(&mut self, flight: &Flight) {
        let plan_is_over = flight.state == StreamerState::Target;
        if plan_is_over || matches!(flight.state, StreamerState::Falling | StreamerState::Tracking) {
            self.conduct.take(flight.now, flight.vehicle.flies_offboard(), plan_is_over);
        }
    }

    /// The release and its instant are known, from the parachute or by its acknowledgement.
    pub(super) fn note(&mut self, flight: &Flight, at: TimeUs, reported: bool, reports: &mut Reports) {
        if self.at.is_none() {
            self.conduct.obeyed |= flight.state == StreamerState::Releasing;
            self.conduct.told |= reported;
            self.begin(flight, at);
            reports.report(flight.now, StreamerEvent::Released { released_at: at, reported });
        }
    }

    /// Looks whether the vehicle falls.
    pub(super) fn feel(&mut self, flight: &Flight, m: &HIGHRES_IMU_DATA, reports: &mut Reports) {
        let Some(settings) = flight.config.free_fall.filter(|_| self.at.is_none()) else { return };
        // Accelerations on the wire are k^2 times the site's.
        let k = flight.config.froude.map_or(1.0, |froude| froude.k());
        let force = Vector3::new(m.xacc, m.yacc, m.zacc).map(|x| f64::from(x) / (k * k));
        let at = flight.config.site_span_us(m.time_usec);
        let detector = self.detector.get_or_insert_with(|| FreeFallDetector::new(settings));
        if let Some(fall) = detector.take(at, &force) {
            self.note_fall(flight, fall, reports);
        }
    }

    /// The autopilot has found the fall.
    pub(super) fn take_told_fall(
        &mut self,
        flight: &Flight,
        m: &NAMED_VALUE_INT_DATA,
        reports: &mut Reports,
    ) {
        if let (Some(_), Ok(ms)) = (flight.config.free_fall, u64::try_from(m.value)) {
            let (began_at, found_at) = (flight.site_us(ms), flight.site_us(u64::from(m.time_boot_ms)));
            self.note_fall(flight, Fall { began_at, found_at }, reports);
        }
    }

    fn note_fall(&mut self, flight: &Flight, fall: Fall, reports: &mut Reports) {
        if self.at.is_none() {
            self.fall = Some(fall);
            self.conduct.told = true;
            self.begin(flight, fall.began_at);
            reports.report(flight.now, StreamerEvent::Falls(fall));
        }
    }

    fn begin(&mut self, flight: &Flight, at: TimeUs) {
        self.at = Some(at);
        self.conduct.note_release(flight.now, flight.vehicle.was_armed_at(at));
    }
}
