//! The release where no wire leads to the parachute: found by the fall that the vehicle's accelerometer shows
//! (HIGHRES_IMU), or taken from an autopilot that has found it itself (NAMED_VALUE_INT `t_release` of its
//! own).

use mavlink::dialects::common::{HIGHRES_IMU_DATA, NAMED_VALUE_INT_DATA};
use nalgebra::Vector3;

use super::{StreamerEvent, StreamerSession};
use crate::control::{Fall, FreeFallDetector};
use crate::time::TimeUs;

impl StreamerSession {
    /// Looks whether the vehicle falls.
    pub(super) fn feel(&mut self, m: &HIGHRES_IMU_DATA) {
        let Some(settings) = self.config.free_fall.filter(|_| self.flight.released_at.is_none()) else {
            return;
        };
        // Accelerations on the wire are k^2 times the site's.
        let k = self.config.froude.map_or(1.0, |froude| froude.k());
        let force = Vector3::new(m.xacc, m.yacc, m.zacc).map(|x| f64::from(x) / (k * k));
        let at = self.config.site_span_us(m.time_usec);
        let detector = self.flight.falling.get_or_insert_with(|| FreeFallDetector::new(settings));
        if let Some(fall) = detector.take(at, &force) {
            self.note_fall(fall);
        }
    }

    /// The autopilot has found the fall.
    pub(super) fn take_told_fall(&mut self, m: &NAMED_VALUE_INT_DATA) {
        if let (Some(_), Ok(ms)) = (self.config.free_fall, TimeUs::try_from(m.value)) {
            let (began_at, found_at) = (self.site_us(ms), self.site_us(u64::from(m.time_boot_ms)));
            self.note_fall(Fall { began_at, found_at });
        }
    }

    fn note_fall(&mut self, fall: Fall) {
        if self.flight.released_at.is_none() {
            (self.flight.released_at, self.flight.fall) = (Some(fall.began_at), Some(fall));
            self.flight.conduct.told = true;
            self.flight
                .conduct
                .note_release(self.flight.now, self.flight.vehicle.was_armed_at(fall.began_at));
            self.report(StreamerEvent::Falls(fall));
        }
    }
}
