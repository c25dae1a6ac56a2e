//! Falls: watched in every flight, and taken for the release where nothing else reports it.

use nalgebra::Vector3;

use super::event::{EventQueue, Severity};
use super::fall_watch::FallWatch;
use crate::control::{Fall, FreeFallDetector, FreeFallSettings};
use crate::time::{TimeUs, seconds};

/// What watches for falls.
#[derive(Clone, Debug)]
pub(super) struct Falls {
    watch: FallWatch,
    /// Finds the release by the fall, where nothing else reports it.
    release: Option<FreeFallDetector>,
}

impl Falls {
    /// Under gravity [m/s^2], with a release that something else reports.
    pub fn new(gravity_m_s2: f64) -> Self {
        Self { watch: FallWatch::new(gravity_m_s2), release: None }
    }

    /// From now on the release is looked for.
    pub fn look_for_release(&mut self, settings: FreeFallSettings) {
        self.release = Some(FreeFallDetector::new(settings));
    }

    /// Time has started over: nothing has fallen yet.
    pub fn restart(&mut self) {
        self.watch.restart();
        if let Some(detector) = &mut self.release {
            *detector = FreeFallDetector::new(*detector.settings());
        }
    }

    /// Takes the speed of descent [m/s] of a step.
    pub fn look(&mut self, v_down_m_s: f64) {
        self.watch.look(v_down_m_s);
    }

    /// Takes the accelerometer's reading, body [m/s^2]; whether a fall is found by it.
    pub fn feel(&mut self, now_us: TimeUs, specific_force_body: &Vector3<f64>) -> bool {
        self.watch.feel(now_us, specific_force_body)
    }

    /// Takes the accelerometer's reading, body [m/s^2]; the release, where it is looked for and when this
    /// reading shows it.
    pub fn feel_release(
        &mut self,
        now_us: TimeUs,
        specific_force_body: &Vector3<f64>,
        events: &mut EventQueue,
    ) -> Option<Fall> {
        let fall = self.release.as_mut()?.take(now_us, specific_force_body)?;
        let [began_s, found_s] = [fall.began_at, fall.found_at].map(seconds);
        events.say(Severity::Notice, format!("Falls since {began_s:.3} s, found at {found_s:.3} s"));
        Some(fall)
    }

    /// Whether it falls by its accelerometer, and sinks faster than when that was found.
    pub fn falls(&self) -> bool {
        self.watch.falls()
    }
}
