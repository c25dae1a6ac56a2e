//! Whether the vehicle falls, watched in every flight: a release in a mode in which nobody starts the motors
//! is said, and any mode that is chosen in the fall starts them. Where nothing else reports the release, it
//! is found by the fall too.
//!
//! The accelerometer shows where a fall begins ([`FreeFallDetector`]). Its end the accelerometer alone does
//! not show: what falls at its terminal velocity is carried by the air as by a canopy. It is over
//!
//! - when the vehicle sinks no faster than when it was found: on the ground, under a canopy that had only
//!   slackened, or on its motors;
//! - when it began at rest and something carries the vehicle again at a canopy's speed: it was let go by a
//!   hook or a carrier, into its canopy.

use nalgebra::Vector3;

use super::event::{EventQueue, Severity};
use crate::control::{self, FreeFallDetector, FreeFallSettings};
use crate::time::{TimeUs, seconds};

/// Fastest descent under a canopy into which a vehicle falls from rest [m/s].
const CANOPY_M_S: f64 = 10.0;
/// Share of gravity that carries.
const CARRIES: f64 = 0.7;
/// So long it must carry [us].
const CARRIED_US: TimeUs = 500_000;
/// A fall from rest sinks, when it is found, no faster than this many times gravity allows in the time that
/// finding it takes.
const AT_REST: f64 = 2.0;

/// How far it has fallen.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fall {
    /// It does not fall.
    None,
    /// The accelerometer has shown a fall, at a speed that the next state tells.
    Found,
    /// It falls, since it sank with this speed [m/s].
    From(f64),
}

/// A watch for falls; without gravity there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FallWatch {
    gravity_m_s2: f64,
    detector: Option<FreeFallDetector>,
    /// Finds the release, where nothing else reports it.
    release: Option<FreeFallDetector>,
    fall: Fall,
    /// Since when something carries the vehicle.
    carried_since: Option<TimeUs>,
    is_carried: bool,
}

impl FallWatch {
    /// A watch under gravity [m/s^2], with the detector's usual settings.
    pub fn new(gravity_m_s2: f64) -> Self {
        let settings =
            FreeFallSettings::of(gravity_m_s2, FreeFallSettings::LEVEL, 0.0, FreeFallSettings::TIME_S);
        let detector = settings.map(FreeFallDetector::new);
        let (release, fall, carried_since, is_carried) = (None, Fall::None, None, false);
        Self { gravity_m_s2, detector, release, fall, carried_since, is_carried }
    }

    /// From now on the release is looked for.
    pub fn look_for_release(&mut self, settings: FreeFallSettings) {
        self.release = Some(FreeFallDetector::new(settings));
    }

    /// Time has started over: neither a fall nor the release has been found yet.
    pub fn restart(&mut self) {
        let release = self.release.map(|detector| FreeFallDetector::new(*detector.settings()));
        *self = Self { release, ..Self::new(self.gravity_m_s2) };
    }

    /// Takes the accelerometer's reading, body [m/s^2]; whether a fall is found by it.
    pub fn feel(&mut self, now_us: TimeUs, specific_force_body: &Vector3<f64>) -> bool {
        let carries = specific_force_body.norm() >= CARRIES * self.gravity_m_s2;
        self.carried_since = carries.then(|| self.carried_since.unwrap_or(now_us));
        self.is_carried = self.carried_since.is_some_and(|since| now_us.saturating_sub(since) >= CARRIED_US);
        let found = self.detector.as_mut().is_some_and(|d| d.take(now_us, specific_force_body).is_some());
        if found {
            self.fall = Fall::Found;
        }
        found
    }

    /// Takes the accelerometer's reading, body [m/s^2]; the release, where it is looked for and when this
    /// reading shows it.
    pub fn feel_release(
        &mut self,
        now_us: TimeUs,
        specific_force_body: &Vector3<f64>,
        events: &mut EventQueue,
    ) -> Option<control::Fall> {
        let fall = self.release.as_mut()?.take(now_us, specific_force_body)?;
        let [began_s, found_s] = [fall.began_at, fall.found_at].map(seconds);
        events.say(Severity::Notice, format!("Falls since {began_s:.3} s, found at {found_s:.3} s"));
        Some(fall)
    }

    /// Takes the speed of descent [m/s] of a step.
    pub fn look(&mut self, v_down_m_s: f64) {
        let from_m_s = match self.fall {
            Fall::None => return,
            Fall::Found => {
                self.fall = Fall::From(v_down_m_s);
                return;
            }
            Fall::From(from_m_s) => from_m_s,
        };
        let from_rest = from_m_s < AT_REST * self.gravity_m_s2 * FreeFallSettings::TIME_S;
        if v_down_m_s < from_m_s || (from_rest && self.is_carried && v_down_m_s < CANOPY_M_S) {
            // The detector finds one fall; the next one is another's.
            *self = Self { release: self.release, ..Self::new(self.gravity_m_s2) };
        }
    }

    /// Whether it falls by its accelerometer, and sinks faster than when that was found.
    pub fn falls(&self) -> bool {
        self.fall != Fall::None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.81;

    /// A watch that has been carried for 2 s at 5 m/s and then dropped for `fall_s`, in steps of 4 ms; the
    /// speed that it has come to.
    fn dropped(fall_s: f64) -> (FallWatch, TimeUs, f64) {
        let (mut watch, mut now, mut v_down) = (FallWatch::new(G), 0, 5.0);
        let steps = (250.0 * fall_s).round() as u64;
        for i in 0..500 + steps {
            now = 4_000 * i;
            let falls = i >= 500;
            v_down += if falls { 0.004 * G } else { 0.0 };
            watch.feel(now, &Vector3::new(0.0, 0.0, if falls { 0.0 } else { -G }));
            watch.look(v_down);
        }
        (watch, now, v_down)
    }

    /// 0.3 g of level, and 0.1 s of it, as the detector's settings say.
    #[test]
    fn closed_form_a_fall_is_found_after_a_tenth_of_a_second() {
        assert!(!dropped(0.088).0.falls());
        assert!(dropped(0.112).0.falls());
    }

    /// At terminal velocity the accelerometer reads gravity again, and the vehicle still falls.
    #[test]
    fn it_falls_as_long_as_it_sinks_faster_than_when_it_was_found() {
        let (mut watch, mut now, v_down) = dropped(1.0);
        for _ in 0..5_000 {
            now += 4_000;
            watch.feel(now, &Vector3::new(0.0, 0.0, -G));
            watch.look(v_down);
            assert!(watch.falls());
        }
        watch.look(0.0);
        assert!(!watch.falls(), "stopped");
    }

    /// A canopy that has gone slack for a moment is no release; the next fall is found like the first.
    #[test]
    fn a_fall_that_ends_under_the_canopy_is_over() {
        let (mut watch, mut now, _) = dropped(0.112);
        watch.look(4.9);
        assert!(!watch.falls());
        let mut found = 0;
        for i in 0..1_000 {
            now += 4_000;
            let force = if i < 500 { -G } else { 0.0 };
            found += usize::from(watch.feel(now, &Vector3::new(0.0, 0.0, force)));
        }
        assert!(found == 1 && watch.falls());
    }

    /// As x500_drop hangs: from a hook at rest into a canopy that it then sinks under with 5 m/s. That was
    /// taken for a fall without an end, and HOLD started the motors under the canopy.
    #[test]
    fn regress_a_fall_from_a_hook_into_the_canopy_is_over() {
        let released = |terminal_m_s: f64| {
            let (mut watch, mut now, mut v_down) = (FallWatch::new(G), 0, 0.0);
            // On the hook, then with drag: f = g (v/v_t)^2.
            for i in 0..3_000 {
                now = 4_000 * i;
                let share = if i < 500 { 1.0 } else { (v_down / terminal_m_s).powi(2) };
                v_down += 0.004 * G * (1.0 - share);
                watch.feel(now, &Vector3::new(0.0, 0.0, -G * share));
                watch.look(v_down);
            }
            (watch, now)
        };
        let (mut watch, mut now) = released(5.0);
        assert!(!watch.falls(), "under its canopy");
        for _ in 0..50 {
            now += 4_000;
            watch.feel(now, &Vector3::zeros());
        }
        assert!(watch.falls(), "released from it");
        assert!(released(16.0).0.falls(), "from a balloon, at its terminal velocity");
    }

    #[test]
    fn without_gravity_nothing_falls() {
        let mut watch = FallWatch::new(0.0);
        assert!((0..1_000).all(|i| !watch.feel(4_000 * i, &Vector3::zeros())));
    }
}
