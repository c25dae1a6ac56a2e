//! Flights of a vehicle that is known, identified from another one.

#[path = "../../tests/shared/test_flight.rs"]
pub(crate) mod test_flight;

use nalgebra::{Matrix3, Vector3};

use self::test_flight::{DELAY_S, Flown, Kind, fly, thinned, vehicle};
use super::*;
use crate::model::rigid_body::MassProperties;
use crate::model::{BodyAero, Motor};

/// A vehicle that is known badly, and how far each parameter is off it.
fn known_badly(truth: &Vehicle) -> (Vehicle, [f64; PARAMETERS]) {
    let mut base = truth.clone();
    base.rotor = base.rotor.scaled([1.2, 0.8]);
    let off = Matrix3::from_diagonal(&Vector3::new(1.3, 0.8, 0.9));
    let inertia = truth.mass.inertia_kg_m2.component_mul(&off);
    base.mass = MassProperties::new(truth.mass.mass_kg, inertia).unwrap();
    base.motor = Motor::FirstOrder {
        omega_max_rad_s: 714.0,
        tau_up_s: 0.020,
        tau_down_s: 0.060,
        rotor_inertia_kg_m2: 2.6e-5,
    };
    base.aero = base.aero.along_axes([0.7, 1.3]);
    let ln = crate::math::ln;
    let factors = [1.2, 0.8, 1.3, 0.8, 0.9].map(|factor| -ln(factor));
    let [thrust, torque, xx, yy, zz] = factors;
    let lags = [ln(30.0 / 20.0), ln(45.0 / 60.0)];
    (
        base,
        [thrust, torque, xx, yy, zz, 1.0 / 0.7 - 1.0, 1.0 / 1.3 - 1.0, lags[0], lags[1], DELAY_S, 0.0, 0.0],
    )
}

fn identified(base: &Vehicle, log: LoggedFlight) -> Identified {
    identify(&[log], base, &Settings::default()).unwrap()
}

/// Root mean square errors that are allowed in calm air, in the order of the parameters.
const BARS: [f64; PARAMETERS] = [0.003, 0.02, 0.005, 0.005, 0.02, 0.1, 0.1, 0.02, 0.02, 5e-4, 1e-3, 1e-3];

/// A short flight: everything is found from a vehicle that is 20 to 50 % off, and the vehicle that comes out
/// is the one that flew.
#[test]
fn closed_form_a_flight_tells_the_vehicle_that_flew_it() {
    let truth = vehicle();
    let (base, off) = known_badly(&truth);
    let flown = Flown { length_s: 38.0, ..Flown::manoeuvre(5) };
    let found = identified(&base, thinned(fly(&truth, &flown), [1, 2, 2]));
    assert!(found.refused.is_empty(), "{:?}", found.refused);
    for (one, (off, bar)) in found.found.iter().zip(off.into_iter().zip(BARS)) {
        let error = (one.deviation - off).abs();
        assert!(error < 2.0 * bar && error < 4.5 * one.error + 0.3 * bar, "{one:?} {off}");
        assert!(one.error > 0.0 && one.error < bar, "{one:?}");
    }
    let after = found.vehicle(&base).unwrap();
    let share = after.mass.inertia_kg_m2.m11 / truth.mass.inertia_kg_m2.m11;
    assert!((share - 1.0).abs() < 0.01, "{share}");
    let lift = after.static_thrust_n(1.225) / truth.static_thrust_n(1.225);
    assert!((lift - 1.0).abs() < 0.006, "{lift}");
    let forward = |vehicle: &Vehicle| {
        let load = vehicle.aero.load(crate::vector::V3::new(6.0, 0.0, 0.0), 1.225);
        load.force_body.x
    };
    assert!((forward(&after) / forward(&truth) - 1.0).abs() < 0.2);
    // The rates of the half that was not used are predicted to the noise of the gyroscope that flew, 0.02
    // rad/s: of what yaw did, that is 2 %, and more cannot be predicted.
    let rates = found.predicted.iter().filter(|one| (3..6).contains(&one.channel));
    for one in rates {
        let least = if one.channel == 5 { 0.97 } else { 0.98 };
        assert!(one.rms < 1.1 * 0.02 && one.over_noise < 1.1 && one.r_squared > least, "{one:?}");
    }
}

/// From a vehicle of which inertia, lag and thrust are several times what they were thought to be the same
/// comes out: no other start is needed.
#[test]
fn closed_form_a_vehicle_that_is_far_off_is_found_as_well() {
    let truth = vehicle();
    let mut base = truth.clone();
    let (inertia, lag, thrust) = (5.0, 2.5, 0.7);
    base.mass = MassProperties::new(truth.mass.mass_kg, truth.mass.inertia_kg_m2 / inertia).unwrap();
    base.motor = base.motor.with_lag(lag);
    base.rotor = base.rotor.scaled([thrust, 1.0]);
    let flown = Flown { length_s: 38.0, ..Flown::manoeuvre(5) };
    let found = identified(&base, thinned(fly(&truth, &flown), [1, 2, 2]));
    assert!(found.refused.is_empty(), "{:?}", found.refused);
    let [j, lag, thrust] = [inertia, 1.0 / lag, 1.0 / thrust].map(crate::math::ln);
    let offs = [thrust, 0.0, j, j, j, 0.0, 0.0, lag, lag, DELAY_S, 0.0, 0.0];
    for (one, (off, bar)) in found.found.iter().zip(offs.into_iter().zip(BARS)) {
        let error = (one.deviation - off).abs();
        assert!(error < 2.0 * bar && error < 4.5 * one.error + 0.3 * bar, "{one:?} {off}");
    }
}

/// By hand: of what says 4 an error is 1/2, and no covariance stays below half of that; what cannot be solved
/// leaves no error an end.
#[test]
fn closed_form_no_error_is_below_half_of_what_was_said() {
    let of = |variance: f64, said: f64| {
        let one = |x: f64| DMatrix::from_element(1, 1, x);
        fit::no_sharper(one(variance), one(said))[(0, 0)].sqrt()
    };
    assert!((of(1e-6, 4.0) - 0.25).abs() < 1e-12 && (of(0.09, 4.0) - 0.3).abs() < 1e-12);
    assert_eq!((of(1e-6, -1.0), of(1e-6, f64::NAN)), (f64::INFINITY, f64::INFINITY));
}

/// At PX4's usual rates nothing is told but the thrust, and that rightly.
#[test]
fn closed_form_a_slow_log_tells_the_thrust_of_its_hover_alone() {
    slow_logs_tell_hover_alone(0..4);
}

#[test]
#[ignore = "many flights"]
fn closed_form_sixteen_more_slow_logs_tell_no_more() {
    slow_logs_tell_hover_alone(4..20);
}

fn slow_logs_tell_hover_alone(seeds: std::ops::Range<u64>) {
    let truth = vehicle();
    let (base, off) = known_badly(&truth);
    for seed in seeds {
        let flown = Flown { kinds: &[Kind::Climbs], length_s: 30.0, ..Flown::manoeuvre(seed) };
        let found = identified(&base, thinned(fly(&truth, &flown), [25, 12, 5]));
        assert_eq!(found.refused.len(), PARAMETERS - 1);
        assert!(found.refused.iter().all(|(_, why)| why.contains("logged at 10 Hz")), "{:?}", found.refused);
        let [thrust] = found.found.as_slice() else { panic!("{:?}", found.found) };
        let error = (thrust.deviation - off[0]).abs();
        assert!(error < 0.03 && error < 3.0 * thrust.error, "{thrust:?} {}", off[0]);
    }
}

/// What was not flown is not told: a hover says nothing of drag, and mass is never among what is found.
#[test]
fn what_was_not_flown_is_refused_with_the_reason() {
    let truth = vehicle();
    let (base, _) = known_badly(&truth);
    let flown = Flown { kinds: &[Kind::Climbs], length_s: 24.0, ..Flown::manoeuvre(3) };
    let found = identified(&base, thinned(fly(&truth, &flown), [1, 2, 2]));
    for parameter in [Parameter::DragAlong, Parameter::InertiaZ] {
        assert!(found.of(parameter).is_none(), "{:?}", found.found);
    }
    assert!(found.of(Parameter::Thrust).is_some());
    assert!(found.refused.iter().all(|(_, why)| why.len() > 20), "{:?}", found.refused);
}

/// In gusts a hover tells the thrust.
#[test]
fn gusts_do_not_take_the_thrust_of_a_hover_away() {
    in_gusts(1.0, true, [1, 2, 2]);
}

/// Where gusts do, nothing is told that hangs on it.
#[test]
#[ignore = "fitted many times"]
fn what_follows_a_number_that_is_held_is_known_as_badly() {
    in_gusts(3.0, false, [1; 3]);
}

/// Each number that is told is within four of its standard errors, from a vehicle that is 20 to 50 % off.
fn in_gusts(turbulence_m_s: f64, is_told: bool, every: [usize; 3]) {
    let truth = vehicle();
    let (base, off) = known_badly(&truth);
    let flown = Flown { turbulence_m_s, kinds: &[Kind::Climbs], length_s: 30.0, ..Flown::manoeuvre(7) };
    let found = identified(&base, thinned(fly(&truth, &flown), every));
    for one in &found.found {
        let error = one.deviation - off[one.parameter as usize];
        assert!(error.abs() < 4.0 * one.error, "{one:?} {error}");
    }
    assert_eq!(found.of(Parameter::Thrust).is_some(), is_told, "{:?}", found.refused);
    let of_yaw = (Parameter::InertiaZ, "rates of yaw moved by 0.000 rad/s within a second, and 0.01 rad/s");
    let is_of_yaw = |(one, why): &(Parameter, String)| *one == of_yaw.0 && why.starts_with(of_yaw.1);
    assert!(found.refused.iter().any(is_of_yaw), "{:?}", found.refused);
}

/// On a body without a side area, in flow from the side, drag turns about itself, and a second of flight
/// hangs on its beginning without bound: such seconds are left out, and the others tell what they did.
#[test]
fn seconds_that_hang_on_their_beginning_are_left_out() {
    let truth = vehicle();
    let alpha: Vec<f64> = (0..37).map(|i| (f64::from(i) * 10.0 - 180.0).to_radians()).collect();
    let (flat, none) = (vec![0.6; 37], vec![0.0; 37]);
    let truth = Vehicle { aero: BodyAero::new(0.1, 0.4, &alpha, &flat, &none, &none).unwrap(), ..truth };
    let (base, off) = known_badly(&truth);
    let mut log = fly(&truth, &Flown { length_s: 26.0, ..Flown::manoeuvre(5) });
    // Ten seconds to the right at 7 m/s, level, as a log has it.
    let from_s = log.end_s();
    let hover = (truth.mass.mass_kg * 9.80665 / truth.static_lift_n(1.225)).sqrt();
    for step in 1..2500 {
        let t_s = from_s + 0.004 * f64::from(step);
        let throttle = std::array::from_fn(|i| if i < 4 { hover } else { f64::NAN });
        log.motors.as_mut().unwrap().put(t_s, throttle);
        log.rates_body_rad_s.as_mut().unwrap().put(t_s, [0.0; 3]);
        log.force_body_m_s2.as_mut().unwrap().put(t_s, [0.0, 0.0, -9.80665]);
        log.attitude.as_mut().unwrap().put(t_s, [1.0, 0.0, 0.0, 0.0]);
        log.velocity_ned_m_s.as_mut().unwrap().put(t_s, [1e-6, 7.0, 0.0]);
    }
    let found = identified(&base, thinned(log, [1, 2, 2]));
    // One of them has the end of the flight in it.
    assert!((20..=27).contains(&found.stretches), "{}", found.stretches);
    for one in &found.found {
        let error = (one.deviation - off[one.parameter as usize]).abs();
        assert!(error < 4.5 * one.error, "{one:?} {error}");
    }
    let is_told = |one: Parameter| found.of(one).is_some();
    assert!(is_told(Parameter::Thrust) && is_told(Parameter::InertiaX), "{:?}", found.refused);
}

#[test]
fn logs_that_say_nothing_are_refused() {
    let truth = vehicle();
    let flown = Flown { kinds: &[Kind::Passes], ..Flown::manoeuvre(1) };
    let log = fly(&truth, &Flown { length_s: 3.0, ..flown });
    let refused =
        |log: LoggedFlight, vehicle: &Vehicle| identify(&[log], vehicle, &Settings::default()).unwrap_err().1;
    assert_eq!(refused(LoggedFlight::default(), &truth), IdentifyError::Lacks("commands to the rotors"));
    assert_eq!(
        refused(LoggedFlight { force_body_m_s2: None, ..log.clone() }, &truth),
        IdentifyError::Lacks("specific force")
    );
    let mut three = truth.clone();
    three.rotors.pop();
    assert_eq!(refused(log.clone(), &three), IdentifyError::Rotors { moved: 4, rotors: 3 });
    let short = fly(&truth, &Flown { length_s: 1.2, ..flown });
    assert_eq!(refused(LoggedFlight { armed: None, ..short }, &truth), IdentifyError::NotFlown);
    let told = identified(&truth, log);
    assert!(told.found.is_empty() && told.refused.len() == PARAMETERS, "{:?}", told.refused);
}

/// Errors and intervals over many flights, calm and in turbulence of 0.5 m/s: the bars, and 95 % intervals
/// that hold the truth. `scripts/test --all` runs it.
#[test]
#[ignore = "many flights"]
fn closed_form_intervals_hold_the_truth() {
    let truth = vehicle();
    let (base, off) = known_badly(&truth);
    let mut missed = Vec::new();
    for (turbulence_m_s, times, least) in [(0.0, 1.0, 0.88), (0.5, 4.0, 0.84)] {
        let seeds = 50_u32;
        // Of each parameter: how often told, errors, their squares, variances, and whether it was held.
        let mut sums = [[0.0; 5]; PARAMETERS];
        for seed in 0..seeds {
            let flown = Flown { turbulence_m_s, ..Flown::manoeuvre(u64::from(seed)) };
            let found = identified(&base, fly(&truth, &flown));
            for one in &found.found {
                let error = one.deviation - off[one.parameter as usize];
                let within = f64::from(error.abs() <= one.reach * one.error);
                let sums = &mut sums[one.parameter as usize];
                let values = [1.0, error, error * error, one.error * one.error, within];
                sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            }
        }
        let (mut all, mut held) = (0.0, 0.0);
        for (parameter, ([n, sum, square, errors, within], bar)) in
            Parameter::ALL.iter().zip(sums.into_iter().zip(BARS))
        {
            let (mean, rms, error) = (sum / n, (square / n).sqrt(), (errors / n).sqrt());
            let line = format!(
                "turbulence {turbulence_m_s} m/s: {} told {n} mean {mean:.5} rms {rms:.5} standard error \
                 {error:.5} held {:.2}",
                parameter.key(),
                within / n
            );
            println!("{line}");
            if !(n == f64::from(seeds) && rms < times * bar && within / n >= least) {
                missed.push(line);
            }
            all += n;
            held += within;
        }
        println!("turbulence {turbulence_m_s} m/s: held in all {:.3}", held / all);
        if !(0.92..=0.98).contains(&(held / all)) {
            missed.push(format!("turbulence {turbulence_m_s} m/s: {held} of {all} held"));
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}
