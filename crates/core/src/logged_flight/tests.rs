//! Flights made by hand, of which is known what was flown when.

use super::phases::{Doing, Phase, phases};
use super::tells::tells;
use super::*;
use crate::math;

fn series<const N: usize>(hz: f64, length_s: f64, value: impl Fn(f64) -> [f64; N]) -> Option<Series<N>> {
    let t_s: Vec<f64> = (0..(hz * length_s) as u64).map(|i| i as f64 / hz).collect();
    let values = t_s.iter().map(|t| value(*t)).collect();
    Some(Series { from: "made", t_s, values })
}

/// On the ground to 5 s, a hover to 15 s, a fall of half a second, then turns with thrust to the end at 30 s.
fn flight(hz: f64) -> LoggedFlight {
    let is_falling = |t: f64| (15.0..15.5).contains(&t);
    LoggedFlight {
        motors: series(hz, 30.0, |_| [0.5, 0.5, 0.5, 0.5, f64::NAN, f64::NAN, f64::NAN, f64::NAN]),
        force_body_m_s2: series(hz, 30.0, |t| match () {
            () if is_falling(t) => [0.0, 0.0, -0.2],
            () if t > 15.5 => [0.0, 0.0, -9.8 - 3.0 * math::sin(7.0 * t)],
            () => [0.0, 0.0, -9.8],
        }),
        rates_body_rad_s: series(
            hz,
            30.0,
            |t| if t > 15.5 { [math::sin(9.0 * t), 0.5, 0.0] } else { [0.0; 3] },
        ),
        velocity_ned_m_s: series(10.0, 30.0, |t| if t > 15.5 { [4.0, 0.0, 0.0] } else { [0.0; 3] }),
        armed: series(1.0, 30.0, |t| [f64::from(t >= 2.0)]),
        landed: series(1.0, 30.0, |t| [f64::from(t < 5.0)]),
        ..LoggedFlight::default()
    }
}

/// By hand: what was flown when.
#[test]
fn closed_form_phases_are_what_was_flown() {
    let found = phases(&flight(250.0));
    let doing: Vec<Doing> = found.iter().map(|phase| phase.doing).collect();
    assert_eq!(doing, [Doing::Disarmed, Doing::Ground, Doing::Hovering, Doing::Falling, Doing::Manoeuvring]);
    for (phase, from_s) in found.iter().zip([0.0, 2.0, 5.0, 15.0, 15.5]) {
        assert!((phase.from_s - from_s).abs() < 0.11, "{phase:?}");
    }
    assert!(phases(&LoggedFlight::default()).is_empty());
}

/// By hand: rates that are too low and what was not flown are the reasons, and the only ones.
#[test]
fn closed_form_a_log_tells_what_was_flown_at_its_rates() {
    let told = |record: &LoggedFlight| -> Vec<(&'static str, Vec<String>)> {
        let phases: Vec<Phase> = phases(record);
        tells(record, &phases).into_iter().map(|tells| (tells.quantity.words(), tells.lacks)).collect()
    };
    let quick = told(&flight(250.0));
    let untold: Vec<&str> =
        quick.iter().filter(|(_, lacks)| !lacks.is_empty()).map(|(name, _)| *name).collect();
    // It never turned about yaw.
    assert_eq!(untold, ["inertia of yaw and torque over thrust", "mass"], "{quick:?}");
    let slow = told(&flight(10.0));
    let lag = slow.iter().find(|(name, _)| name.starts_with("lag")).unwrap();
    assert!(lag.1[0].contains("are of 10 Hz, and 100 Hz are needed"), "{lag:?}");
    assert!(slow[0].1.is_empty(), "{slow:?}");
    let nothing = told(&LoggedFlight::default());
    assert!(nothing.iter().all(|(_, lacks)| !lacks.is_empty()));
}

/// By hand: rate and longest gap are those of the times, values those of the time or before.
#[test]
fn closed_form_series_are_looked_up_by_time() {
    let mut series = series(10.0, 1.0, |t| [t]).unwrap();
    assert!((series.rate_hz() - 10.0).abs() < 1e-9);
    series.t_s[9] = 2.0;
    assert!((series.longest_gap_s() - 1.2).abs() < 1e-9);
    assert_eq!(series.at(0.25).unwrap(), &[0.2]);
    assert!(series.at(-0.1).is_none());
    assert_eq!(series.between(0.15, 0.35).len(), 2);
}
