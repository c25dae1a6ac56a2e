//! PX4's parameters that a drop from a parachute requires, and why: one table, from which they are uploaded
//! and by which a vehicle is checked.
//!
//! PX4 expects a takeoff from the ground, which a drop does not have; most of these parameters disable an
//! automatic reaction that would therefore stop the rotors or spoil the flight. The gains are not here: see
//! [`mod@super::export`].

use super::Value;
use crate::control::px4::versions::{Number, ToldBy};

/// The quantities of a drop on which the required parameters depend.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DropEnvelope {
    /// Fastest descent in the setpoints from t = 0 on [m/s].
    pub fastest_descent_m_s: f64,
    /// Fastest horizontal speed in the setpoints [m/s].
    pub fastest_horizontal_m_s: f64,
    /// Thrust in hover as a part of the greatest thrust; `None`: unknown.
    pub hover_thrust: Option<f64>,
    /// Age of the vehicle's satellite fixes, on PX4's clock [s]; `None`: unknown.
    pub satellite_delay_s: Option<f64>,
}

/// A parameter of the table, and the values that it may have.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Name of the parameter.
    pub name: &'static str,
    /// Value to upload; `None`: none, the parameter is only checked.
    pub wanted: fn(&DropEnvelope) -> Option<Value>,
    /// Whether a value meets the requirement.
    pub holds: fn(f64, &DropEnvelope) -> bool,
    /// Consequence of a value that does not, in a few words that follow "NAME = x: ".
    pub otherwise: &'static str,
    /// Why it must not be released then, in words that follow "with this NAME"; `None`: it may.
    pub grave: Option<&'static str>,
    /// A parameter that has this name in other versions of PX4: one of the two is always absent.
    pub succeeds: Option<&'static str>,
    /// The first version of PX4 that has the parameter; `None`: all have it, by one of its names.
    pub since: Option<Number>,
    /// Whether it is so with PX4 only: samara's own autopilot looks for a landing once its rotors have
    /// turned.
    pub of_px4_only: bool,
}

/// A hover thrust that is off by more than this part breaks the rule: 17 % made a drop steady after 5.3 s
/// instead of 2.4 s.
const HOVER_TOLERANCE: f64 = 0.03;
/// An age of satellite fixes that is off by more than this [s] breaks the rule: 0.1 s made a drop steady
/// after 5.5 s instead of 1.9 s. PX4 takes its fixes in steps of 10 ms.
const SATELLITE_TOLERANCE_S: f64 = 0.02;

/// The longest that PX4's estimator looks back [ms], of v1.15 and later; it is read at PX4's start.
pub const ESTIMATORS_WINDOW: &str = "EKF2_DELAY_MAX";
/// How many times the age of a satellite fix the estimator must look back. Fixes of 0.4 s on v1.16.0: with a
/// window as long, steady after 3.9 s; with 0.45 s 2.9 s, 0.5 s 2.2 s, 0.6 s 1.9 s, 0.8 s 2.0 s.
const WINDOW_PER_AGE: f64 = 1.5;

/// How long PX4's estimator must look back at the least [ms]; `None`: unknown.
pub fn estimators_window_ms(of: &DropEnvelope) -> Option<f64> {
    of.satellite_delay_s.map(|s| 1e3 * WINDOW_PER_AGE * s)
}

/// Shortest window of PX4's estimator, and longest that widens v1.14's [ms].
const WINDOW_MS: [f64; 2] = [200.0, 300.0];

/// Parameters that PX4's estimator reads once, at its start: the age of satellite fixes, and a window of the
/// past that holds them. v1.14 sizes it by the oldest sensor, in steps of 10 ms; with samples of 4 ms its
/// steps are shorter, and fixes of 110 ms would lie beyond its end. EKF2_AVEL_DELAY is of a sensor that is
/// not there. Later versions have a window of their own, EKF2_DELAY_MAX, which must be longer than any age of
/// a sensor.
pub fn estimators_window(envelope: &DropEnvelope, by: ToldBy) -> Vec<(&'static str, f64)> {
    let (Some(delay_s), Some(needed_ms)) = (envelope.satellite_delay_s, estimators_window_ms(envelope))
    else {
        return Vec::new();
    };
    let [least, most] = WINDOW_MS;
    let (age_ms, window_ms) = ((1e3 * delay_s).round(), needed_ms.round().max(least));
    match by {
        ToldBy::Script => {
            let other_ms = (2.0 * age_ms).clamp(least, most);
            vec![
                ("EKF2_GPS_DELAY", age_ms),
                ("EKF2_AVEL_DELAY", other_ms),
                (ESTIMATORS_WINDOW, window_ms.max(other_ms)),
            ]
        }
        ToldBy::Environment => {
            vec![("EKF2_GPS_DELAY", age_ms), ("SENS_GPS0_DELAY", age_ms), (ESTIMATORS_WINDOW, window_ms)]
        }
    }
}

fn int(i: i32) -> Option<Value> {
    Some(Value::Int(i))
}

fn real(x: f64) -> Option<Value> {
    Some(Value::Real(x as f32))
}

fn satellite_delay_ms(of: &DropEnvelope) -> Option<f64> {
    of.satellite_delay_s.map(|s| 1e3 * s)
}

const fn satellite_delay(name: &'static str) -> Rule {
    rule(
        name,
        |c| satellite_delay_ms(c).and_then(real),
        |x, c| satellite_delay_ms(c).is_none_or(|ms| (x - ms).abs() <= 1e3 * SATELLITE_TOLERANCE_S),
        "the estimator takes satellite fixes for so many milliseconds old, and they are not: its velocity is off \
         by what the vehicle accelerates meanwhile",
    )
}

/// PX4's tilt limit at the beginning of a drop, which then slews to [`TILT_AIR`]. Part of the gains, not of
/// the table, but checked with it.
pub const TILT_LND: &str = "MPC_TILTMAX_LND";
/// PX4's tilt limit in flight.
pub const TILT_AIR: &str = "MPC_TILTMAX_AIR";
/// Consequence of a [`TILT_LND`] below [`TILT_AIR`].
pub const TILT_SHUT: &str =
    "the drop begins with no more tilt than that [deg]; 0.2 rad/s are added until it is MPC_TILTMAX_AIR";

const fn rule(
    name: &'static str,
    wanted: fn(&DropEnvelope) -> Option<Value>,
    holds: fn(f64, &DropEnvelope) -> bool,
    otherwise: &'static str,
) -> Rule {
    Rule { name, wanted, holds, otherwise, grave: None, succeeds: None, since: None, of_px4_only: false }
}

impl Rule {
    /// Whether it counts for an autopilot: some are for PX4 alone, not for samara's own.
    pub fn binds(&self, is_samara: bool) -> bool {
        !(is_samara && self.of_px4_only)
    }
}

/// All required parameters: name, value to upload, which values will do, consequence of others.
#[rustfmt::skip]
pub const RULES: [Rule; 16] = [
    rule("COM_DISARM_PRFLT", |_| real(-1.0), |x, _| x <= 0.0,
        "PX4 disarms itself so many seconds after arming when it has not seen a takeoff, and a hook or a slow canopy is none"),
    Rule { of_px4_only: true, ..rule("COM_DISARM_LAND", |_| real(-1.0), |x, _| x <= 0.0,
        "PX4 disarms itself when it takes a slow descent under the canopy for a landing") },
    rule("COM_LKDOWN_TKO", |_| real(-1.0), |x, _| x < 0.0,
        "an attitude beyond FD_FAIL_R or FD_FAIL_P within so many seconds of the takeoff, which is the start of the descent, stops the rotors for good"),
    rule("FD_FAIL_R", |_| int(180), |x, _| x == 0.0 || x >= 180.0,
        "a roll beyond it [deg] counts as a failure; under a canopy it may be a swing"),
    rule("FD_FAIL_P", |_| int(180), |x, _| x == 0.0 || x >= 180.0,
        "a pitch beyond it [deg] counts as a failure; under a canopy it may be a swing"),
    // Bits 5 to 7: drift and speed, which are judged as at rest.
    rule("EKF2_GPS_CHECK", |_| int(21), |x, _| (x as i64) & 0xE0 == 0,
        "the checks of drift and speed (32, 64, 128) never pass while it descends: the estimator stays without a velocity, and velocity setpoints are then refused"),
    satellite_delay("EKF2_GPS_DELAY"),
    Rule { succeeds: Some("EKF2_GPS_DELAY"), wanted: |c| satellite_delay_ms(c).and_then(|ms| int(ms.round() as i32)),
        ..satellite_delay("SENS_GPS0_DELAY") },
    Rule { since: Some(Number { major: 1, minor: 15 }),
        grave: Some("the estimator would not have the satellites' fixes in time: it must be set where PX4 is started"),
        ..rule(ESTIMATORS_WINDOW, |_| None,
        |x, c| estimators_window_ms(c).is_none_or(|ms| x + 1e-3 >= ms),
        "the estimator's past [ms] is too short for satellite fixes of that age: they come late or never into it; it is read at PX4's start, and must be set there") },
    rule("MPC_USE_HTE", |_| int(0), |x, _| x == 0.0,
        "the estimator of the hover thrust learns from the fall, and the flight depends on what it has learnt"),
    rule("COM_RCL_EXCEPT", |_| int(4), |x, _| (x as i64) & 4 != 0,
        "without a remote control PX4 may leave OFFBOARD (bit 2 excepts it)"),
    rule("COM_OF_LOSS_T", |_| real(1.0), |x, _| x >= 0.1,
        "OFFBOARD is lost after so many seconds without a setpoint, and they come every 0.02 s"),
    rule("MPC_THR_HOVER", |c| c.hover_thrust.and_then(real),
        |x, c| c.hover_thrust.is_none_or(|h| (x / h - 1.0).abs() <= HOVER_TOLERANCE),
        "the vehicle hovers at another thrust: vertical gains and thrust are off by that factor"),
    Rule { grave: Some("the vehicle would fall without thrust"),
        ..rule("MPC_THR_MAX", |_| None, |x, c| x > c.hover_thrust.unwrap_or(0.1),
        "the greatest thrust does not carry the vehicle") },
    rule("MPC_Z_VEL_MAX_DN", |c| real(c.fastest_descent_m_s.max(1.0)), |x, c| x + 1e-3 >= c.fastest_descent_m_s,
        "faster descents are clipped to it: the plan is not what will be flown"),
    rule("MPC_XY_VEL_MAX", |c| real(c.fastest_horizontal_m_s.max(12.0)), |x, c| x + 1e-3 >= c.fastest_horizontal_m_s,
        "faster horizontal flight is clipped to it: the plan is not what will be flown"),
];

/// Rules of the parameters to be looked at, of a version of PX4.
pub fn looked_at(px4: Number) -> impl Iterator<Item = &'static Rule> {
    RULES.iter().filter(move |rule| rule.since.is_none_or(|since| since <= px4))
}

/// Names and values of the parameters to upload.
pub fn wanted(envelope: &DropEnvelope) -> impl Iterator<Item = (&'static str, Value)> + '_ {
    RULES.iter().filter_map(|rule| Some((rule.name, (rule.wanted)(envelope)?)))
}

/// The name that a parameter has in other versions of PX4, where it has one: only one of the two is there.
pub fn other_name(name: &str) -> Option<&'static str> {
    RULES.iter().find_map(|rule| match rule.succeeds? {
        before if rule.name == name => Some(before),
        before if before == name => Some(rule.name),
        _ => None,
    })
}

/// The rule that a value of a parameter breaks; `None` when it breaks none.
pub fn broken(name: &str, value: f64, envelope: &DropEnvelope) -> Option<&'static Rule> {
    RULES.iter().find(|rule| rule.name == name && !(rule.holds)(value, envelope))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Metadata;

    #[test]
    fn prop_what_the_table_asks_for_is_what_it_accepts_and_px4_takes() {
        let of = DropEnvelope {
            fastest_descent_m_s: 9.1,
            fastest_horizontal_m_s: 2.0,
            hover_thrust: Some(0.59),
            satellite_delay_s: Some(0.11),
        };
        for (name, value) in wanted(&of) {
            assert!(broken(name, value.as_f64(), &of).is_none(), "{name}");
            for minor in 12..=18 {
                let Some(p) = Metadata::of(Number { major: 1, minor }).get(name) else { continue };
                assert_eq!(value.in_type_of(p.kind.zero()), Some(value), "{name} in v1.{minor}");
                assert!(p.contains(value.as_f64()) || name == "MPC_Z_VEL_MAX_DN", "{name} in v1.{minor}");
            }
        }
    }

    /// Names that PX4 has given up by v1.17, and those that it has taken for them.
    #[test]
    fn a_parameter_that_was_renamed_has_the_other_name() {
        assert_eq!(other_name("EKF2_GPS_DELAY"), Some("SENS_GPS0_DELAY"));
        assert_eq!(other_name("SENS_GPS0_DELAY"), Some("EKF2_GPS_DELAY"));
        assert_eq!(other_name("MPC_THR_HOVER"), None);
    }

    /// What an older PX4 does not have is not asked for: it would not answer.
    #[test]
    fn a_version_is_asked_for_what_it_has() {
        let asked = |minor| looked_at(Number { major: 1, minor }).any(|rule| rule.name == ESTIMATORS_WINDOW);
        assert_eq!([12, 14, 15, 17].map(asked), [false, false, true, true]);
        let of = DropEnvelope { satellite_delay_s: Some(0.2), ..DropEnvelope::default() };
        assert!(broken(ESTIMATORS_WINDOW, 200.0, &of).is_some());
        assert!(broken(ESTIMATORS_WINDOW, 300.0, &of).is_none());
    }

    /// PX4's default of EKF2_DELAY_MAX, 200 ms (`ekf2/module.yaml`), holds fixes of the shipped missions; a
    /// window that is shorter than the fixes are old is never filled, and PX4 is never released.
    #[test]
    fn the_estimators_window_holds_the_fixes() {
        let of = |delay_s: f64, by| {
            let envelope = DropEnvelope { satellite_delay_s: Some(delay_s), ..DropEnvelope::default() };
            estimators_window(&envelope, by)
        };
        let window = |delay_s: f64| of(delay_s, ToldBy::Environment).last().map(|(_, ms)| *ms);
        assert_eq!([0.0, 0.11, 0.13, 0.2, 0.4].map(window), [200.0, 200.0, 200.0, 300.0, 600.0].map(Some));
        for delay_s in [0.0, 0.11, 0.25, 0.4] {
            let told = of(delay_s, ToldBy::Script);
            assert!(told.iter().all(|(_, ms)| *ms <= told[2].1), "no age beyond the window: {told:?}");
        }
        assert_eq!(of(0.11, ToldBy::Script)[1..], [("EKF2_AVEL_DELAY", 220.0), (ESTIMATORS_WINDOW, 220.0)]);
    }

    /// PX4 v1.12's defaults: the traps that are known from drops.
    #[test]
    fn px4s_defaults_break_the_rules_that_a_drop_needs() {
        let of = DropEnvelope {
            fastest_descent_m_s: 9.1,
            fastest_horizontal_m_s: 2.0,
            hover_thrust: Some(0.59),
            satellite_delay_s: Some(0.11),
        };
        for (name, default, breaks) in [
            ("COM_DISARM_PRFLT", 10.0, true),
            ("EKF2_GPS_CHECK", 245.0, true),
            ("MPC_Z_VEL_MAX_DN", 1.0, true),
            ("MPC_XY_VEL_MAX", 12.0, false),
            ("MPC_THR_MAX", 1.0, false),
            ("MPC_THR_HOVER", 0.5, true),
            ("EKF2_GPS_DELAY", 110.0, false),
            ("EKF2_GPS_DELAY", 10.0, true),
            (ESTIMATORS_WINDOW, 200.0, false),
        ] {
            assert_eq!(broken(name, default, &of).is_some(), breaks, "{name}");
        }
        assert!(broken("MPC_THR_MAX", 0.5, &of).unwrap().grave.is_some());
    }
}
