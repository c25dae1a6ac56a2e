//! Whether the vehicle falls, found from its accelerometer alone: for those to whom nothing else reports the
//! release.
//!
//! In a steady descent nothing accelerates, so the specific force f is gravity whatever the canopy is;
//! turbulence and swing make it more and less. After the release it is the air's force on the vehicle over
//! its mass, a few hundredths of gravity at first. What tells both apart is how long it lacks, not how low it
//! comes. So the lack is summed, and what is more than carried is taken off again, down to nothing:
//!
//! ```text
//! s := max(0, s + (f_level - |f|) dt)        it falls when s >= s_fall
//! ```
//!
//! Page's cumulative sum (Biometrika 41, 1954), which of all rules with so few false alarms is the fastest to
//! find a change (Moustakides, Ann. Statist. 14, 1986, for readings that do not depend on each other). The
//! sum is a velocity: that which the vehicle has gained on one that `f_level` carries. It was last zero when
//! the fall began, the most likely instant of the change (Hinkley, Biometrika 57, 1970), so that whoever asks
//! for the release gets the release, not the detection: the middle between the readings before and after it.
//!
//! `|f|` needs neither attitude nor gyroscope, and a bias of the accelerometer is a small part of gravity. An
//! accelerometer that is off the centre of mass by r reads `omega^2 r` more in a tumble; where that is not
//! small beside `f_level`, hand over the reading at the centre of mass.

use nalgebra::Vector3;

use crate::time::{TimeUs, seconds};

/// It counts as carried, so that it can fall, after this long without a lack of specific force [us].
const CARRIED_AFTER_US: TimeUs = 500_000;
/// A gap between readings longer than this begins anew [us].
const GAP_US: TimeUs = 100_000;

/// What a detector of the free fall goes by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeFallSettings {
    /// Specific force that is neither carried nor fallen [m/s^2]: below it the lack grows, above it shrinks.
    pub level_m_s2: f64,
    /// The lack that is a fall [m/s].
    pub lack_m_s: f64,
}

impl FreeFallSettings {
    /// Level as a share of gravity, where a mission does not say.
    pub const LEVEL: f64 = 0.3;
    /// Time in which a fall is found that begins at once and without noise, where a mission does not say [s].
    pub const TIME_S: f64 = 0.1;

    /// Settings that find, after `time_s` [s], a fall in which the air carries as much as `fall_m_s2`
    /// [m/s^2] under gravity `gravity_m_s2`, with the level at a share `level` of gravity:
    /// `s_fall = (level g - f_fall) t`. `None` where the air carries as much as the level or more, so that
    /// no fall is ever found.
    pub fn of(gravity_m_s2: f64, level: f64, fall_m_s2: f64, time_s: f64) -> Option<Self> {
        let level_m_s2 = level * gravity_m_s2;
        let lack_m_s = (level_m_s2 - fall_m_s2) * time_s;
        (lack_m_s > 0.0 && lack_m_s.is_finite()).then_some(Self { level_m_s2, lack_m_s })
    }
}

/// A fall that was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fall {
    /// When it began: the release [us].
    pub began_at: TimeUs,
    /// When it was found [us].
    pub found_at: TimeUs,
}

/// A detector of the free fall, fed with an accelerometer's readings at any rate. It finds one fall, after it
/// has been carried; then it is at its end, unless it is started over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeFallDetector {
    settings: FreeFallSettings,
    lack_m_s: f64,
    /// When the lack was last zero.
    since: TimeUs,
    /// Since when it has been carried without a lack.
    carried_since: Option<TimeUs>,
    carried: bool,
    last: Option<TimeUs>,
    fall: Option<Fall>,
}

impl FreeFallDetector {
    /// A detector that has read nothing yet.
    pub fn new(settings: FreeFallSettings) -> Self {
        Self {
            settings,
            lack_m_s: 0.0,
            since: 0,
            carried_since: None,
            carried: false,
            last: None,
            fall: None,
        }
    }

    /// The settings that it goes by.
    pub fn settings(&self) -> &FreeFallSettings {
        &self.settings
    }

    /// The fall, once it has been found.
    pub fn fall(&self) -> Option<Fall> {
        self.fall
    }

    /// Takes the specific force at the centre of mass at a time [us], in any axes [m/s^2], and returns the
    /// fall when this reading shows it. What is not finite, or not later than the last reading, is not taken;
    /// a time that runs back by more than a gap starts over.
    pub fn take(&mut self, at: TimeUs, specific_force: &Vector3<f64>) -> Option<Fall> {
        let force_m_s2 = specific_force.norm();
        if !force_m_s2.is_finite() {
            return None;
        }
        let last = self.last.unwrap_or(at);
        let starts_over = at.saturating_add(GAP_US) < last;
        if starts_over || (self.fall.is_none() && at > last.saturating_add(GAP_US)) {
            *self = Self::new(self.settings);
        }
        let last = self.last.unwrap_or(at);
        if at <= last && self.last.is_some() {
            return None;
        }
        self.last = Some(at);
        if self.fall.is_some() {
            return None;
        }
        if self.lack_m_s == 0.0 {
            // Somewhere between two readings.
            self.since = last + (at - last) / 2;
        }
        let lack_m_s = self.lack_m_s + (self.settings.level_m_s2 - force_m_s2) * seconds(at - last);
        self.lack_m_s = lack_m_s.max(0.0);
        if !self.carried {
            return self.wait_for_a_canopy(at);
        }
        if self.lack_m_s < self.settings.lack_m_s {
            return None;
        }
        self.fall = Some(Fall { began_at: self.since, found_at: at });
        self.fall
    }

    fn wait_for_a_canopy(&mut self, at: TimeUs) -> Option<Fall> {
        if self.lack_m_s > 0.0 {
            self.carried_since = None;
        } else {
            let since = *self.carried_since.get_or_insert(at);
            self.carried = at - since >= CARRIED_AFTER_US;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const G: f64 = 9.80665;

    fn settings() -> FreeFallSettings {
        FreeFallSettings::of(G, 0.3, 0.05 * G, 0.1).unwrap()
    }

    /// Reads `force(t)` every `dt_us` from 0 on for so long.
    fn read(
        settings: FreeFallSettings,
        (dt_us, until_s): (TimeUs, f64),
        force: impl Fn(f64) -> f64,
    ) -> Option<Fall> {
        let mut detector = FreeFallDetector::new(settings);
        let turned = |f: f64| Vector3::new(0.6 * f, 0.0, -0.8 * f);
        let mut times = (0..).map(|i| i * dt_us).take_while(|at| seconds(*at) < until_s);
        times.find_map(|at| detector.take(at, &turned(force(seconds(at)))))
    }

    /// A step from gravity to f_fall is found after the time that the settings were made for, at any rate of
    /// reading, and dated to the middle between the last reading that does not show it and the first one.
    #[test]
    fn closed_form_a_clean_fall_takes_the_time_asked_for() {
        for dt_us in [1_000, 4_000, 10_000, 20_000] {
            let fall = read(settings(), (dt_us, 3.0), |t| if t < 2.0 - 1e-9 { G } else { 0.05 * G }).unwrap();
            assert_eq!(fall.began_at, 2_000_000 - dt_us / 2, "{dt_us}");
            let late = fall.found_at as i64 - 2_100_000;
            assert!((-(dt_us as i64)..=0).contains(&late), "{dt_us}: {late}");
        }
    }

    /// With f = D v^2 rising as the vehicle falls, f/g = (v/v_t)^2 and v = v_t tanh(g t/v_t + c): the lack
    /// after t is `level g t - (g t - (v - v_0))`, by the fall's own equation of motion.
    #[test]
    fn closed_form_a_fall_with_drag_is_found_when_its_velocity_says_so() {
        let (v_t, v_0, level) = (18.0, 5.0, 0.3);
        let c = crate::math::ln((1.0 + v_0 / v_t) / (1.0 - v_0 / v_t)) / 2.0;
        let tanh = |x: f64| 1.0 - 2.0 / (crate::math::exp(2.0 * x) + 1.0);
        let v = |t: f64| v_t * tanh(G * t / v_t + c);
        let s = FreeFallSettings::of(G, level, G * (v_0 / v_t) * (v_0 / v_t), 0.1).unwrap();
        let fall =
            read(s, (1_000, 3.0), |t| if t < 1.0 { G } else { G * (v(t - 1.0) / v_t).powi(2) }).unwrap();
        let lack = |t: f64| level * G * t - (G * t - (v(t) - v_0));
        let (mut low, mut high) = (0.0, 0.3);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if lack(middle) < s.lack_m_s { low = middle } else { high = middle }
        }
        assert!(low > 0.105, "drag makes it later: {low}");
        assert!((seconds(fall.found_at) - 1.0 - low).abs() < 0.002, "{fall:?} {low}");
    }

    /// A riser that goes slack again and again, each time for less than the time asked for, and pulls as long
    /// in between: the sum goes back to zero.
    #[test]
    fn closed_form_spells_shorter_than_the_time_are_no_fall() {
        let slack = |t: f64| (t / 0.076).floor() as u64 % 2 == 1;
        let bounce = |t: f64| {
            if t < 1.0 {
                G
            } else if slack(t) {
                0.0
            } else {
                2.0 * G
            }
        };
        assert_eq!(read(settings(), (4_000, 60.0), bounce), None);
        assert!(read(settings(), (4_000, 60.0), |t| if t < 50.0 { bounce(t) } else { 0.0 }).is_some());
    }

    /// Where nothing has carried it yet, as before an opening, nothing is found; nor after the fall was.
    #[test]
    fn it_must_have_been_carried_and_falls_once() {
        assert_eq!(read(settings(), (4_000, 10.0), |_| 0.0), None);
        let opening = |t: f64| if !(1.0..2.0).contains(&t) { 0.0 } else { G };
        let fall = read(settings(), (4_000, 10.0), opening).unwrap();
        assert_eq!(fall.began_at, 1_998_000);
        let mut detector = FreeFallDetector::new(settings());
        for at in (0..8_000_000).step_by(4_000) {
            let force = if (2_000_000..3_000_000).contains(&at) || at > 5_000_000 { 0.0 } else { G };
            detector.take(at, &Vector3::new(0.0, 0.0, -force));
        }
        assert_eq!(detector.fall().map(|fall| fall.began_at), Some(1_998_000));
    }

    #[test]
    fn settings_that_never_find_a_fall_are_none() {
        assert_eq!(FreeFallSettings::of(G, 0.3, 0.3 * G, 0.1), None);
        assert_eq!(FreeFallSettings::of(G, 0.3, 0.0, 0.0), None);
        assert_eq!(FreeFallSettings::of(f64::NAN, 0.3, 0.0, 0.1), None);
        let of = FreeFallSettings::of(1.35, 0.3, 0.035 * 1.35, 0.1).unwrap();
        assert!((of.lack_m_s - 0.265 * 0.135).abs() < 1e-12);
    }

    proptest! {
        /// Any readings at any times: no panic, at most one fall, and it began before it was found.
        #[test]
        fn prop_a_fall_begins_before_it_is_found(
            rows in proptest::collection::vec(
                (any::<u32>(), -20.0..20.0f64, prop::bool::weighted(0.02)),
                0..400,
            ),
        ) {
            let mut detector = FreeFallDetector::new(settings());
            let mut found = 0;
            let mut at = 0;
            for (jump, force, wild) in rows {
                at = if wild { u64::from(jump) } else { at + u64::from(jump % 30_000) };
                let force = if wild && jump % 3 == 0 { f64::NAN } else { force };
                if let Some(fall) = detector.take(at, &Vector3::new(0.0, force, 0.0)) {
                    found += 1;
                    prop_assert!(fall.began_at < fall.found_at && fall.found_at == at);
                }
            }
            prop_assert!(found <= 1);
        }
    }
}
