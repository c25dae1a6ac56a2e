//! Sensors that fail, lie or stay away; arming's reasons.

use nalgebra::Vector3;

use super::super::{Estimator, Fix, NotAligned, Sample};
use super::flight::{EARTH, Site, TITAN, Truth, fly};
use super::sensors::{Random, Sensors};
use super::{error, settings, squared_error};

/// Flies a drop with sensors that are tampered with, and returns the estimator and the last error of
/// position, velocity, attitude.
fn fly_with(
    site: &Site,
    duration_s: f64,
    tamper: impl FnMut(f64, &mut Sample, &mut Option<Fix>) -> bool,
) -> (Estimator, [f64; 3]) {
    fly_swinging(site, 0.1, duration_s, tamper)
}

fn fly_swinging(
    site: &Site,
    swing_rad: f64,
    duration_s: f64,
    mut tamper: impl FnMut(f64, &mut Sample, &mut Option<Fix>) -> bool,
) -> (Estimator, [f64; 3]) {
    let settings = settings(site);
    let flight: Vec<Truth> = fly(site, swing_rad, 0.5, duration_s);
    let mut sensors = Sensors::new(&settings, Random::new(7));
    let mut estimator = Estimator::new(settings);
    let mut last = [f64::NAN; 3];
    for (i, truth) in flight.iter().enumerate() {
        let (mut fix, mut sample) = (sensors.fix(&flight, i), sensors.sample(truth));
        let comes = tamper(truth.at_us as f64 * 1e-6, &mut sample, &mut fix);
        if let Some(fix) = fix {
            estimator.take_fix(&fix);
        }
        if comes {
            estimator.take(&sample);
        }
        if let Some((at_us, p_ned, m)) = estimator.estimate() {
            assert!(p_ned.iter().chain(m.v_ned.iter()).chain(&m.q_ned_from_body).all(|x| x.is_finite()));
            if at_us == truth.at_us {
                let state = sensors.state(truth);
                let guess = super::NominalState {
                    p_ned,
                    v_ned: m.v_ned,
                    q_ned_from_body: m.q_ned_from_body,
                    ..state
                };
                let e = error(&state, &guess);
                let size = |at: usize| Vector3::new(e[at], e[at + 1], e[at + 2]).norm();
                last = [size(0), size(3), size(6)];
            }
            let covariance = &estimator.filter().unwrap().covariance;
            assert!(i % 50 != 0 || squared_error(&[0.0; 16], covariance).is_some(), "step {i}");
        }
    }
    (estimator, last)
}

fn is_close(errors: [f64; 3]) -> bool {
    errors[0] < 2.5 && errors[1] < 0.4 && errors[2] < 0.12
}

#[test]
fn closed_form_it_knows_where_it_is_in_the_present() {
    for site in [EARTH, TITAN] {
        let (estimator, errors) = fly_with(&site, 11.0, |_, _, _| true);
        assert!(is_close(errors), "{errors:?}");
        assert_eq!(estimator.check_aligned(), Ok(()));
    }
}

/// A magnetometer and a barometer of 50 Hz whose samples are not each other's, nor the first one's: none
/// waits for another.
#[test]
fn regress_sensors_with_rates_of_their_own_are_all_taken() {
    for [field_at, altitude_at] in [[0, 3], [3, 0], [2, 2], [4, 1]] {
        let mut i = 0;
        let (estimator, errors) = fly_with(&EARTH, 11.0, |_, sample, _| {
            sample.field_body = sample.field_body.filter(|_| i % 5 == field_at);
            sample.altitude_m = sample.altitude_m.filter(|_| i % 5 == altitude_at);
            i += 1;
            true
        });
        assert_eq!(estimator.check_aligned(), Ok(()), "{field_at} {altitude_at}");
        assert!(is_close(errors), "{field_at} {altitude_at}: {errors:?}");
    }
}

#[test]
fn prop_what_is_no_number_does_no_harm() {
    for site in [EARTH, TITAN] {
        let mut k = 0;
        let (estimator, errors) = fly_with(&site, 11.0, |_, sample, fix| {
            k += 1;
            match k % 11 {
                0 => sample.inertial.specific_force_body.y = f64::NAN,
                3 => sample.inertial.omega_body.z = f64::INFINITY,
                5 => sample.altitude_m = Some(f64::NAN),
                7 => sample.field_body = Some(Vector3::new(f64::NAN, 0.0, 0.0)),
                8 => *fix = fix.map(|f| Fix { v_ned: f.v_ned * f64::NAN, ..f }),
                _ => {}
            }
            true
        });
        assert!(is_close(errors), "{errors:?}");
        assert_eq!(estimator.check_aligned(), Ok(()));
    }
}

#[test]
fn closed_form_absurd_readings_are_gated() {
    let (estimator, errors) = fly_with(&EARTH, 11.0, |t, sample, fix| {
        if t > 6.0 && ((t * 10.0) as u64).is_multiple_of(3) {
            sample.altitude_m = Some(4_000.0);
            sample.field_body = sample.field_body.map(|m| -m);
            *fix =
                fix.map(|f| Fix { p_ned: f.p_ned.add_scalar(500.0), v_ned: -f.v_ned.add_scalar(80.0), ..f });
        }
        true
    });
    assert!(is_close(errors), "{errors:?}");
    assert_eq!(estimator.check_aligned(), Ok(()));
}

/// A quarter of a second of the fall unseen: wrong afterwards, knows it, and finds back.
#[test]
fn closed_form_it_recovers_from_a_gap_and_from_a_jump_of_the_fixes() {
    let (_, errors) = fly_with(&EARTH, 12.0, |t, _, _| !(8.1..8.35).contains(&t));
    assert!(is_close(errors), "{errors:?}");
    // A receiver that has come to another opinion and keeps it is believed in the end.
    let offset = Vector3::new(60.0, 0.0, 0.0);
    let (estimator, _) = fly_with(&EARTH, 8.0, |t, _, fix| {
        if t > 4.0 {
            *fix = fix.map(|f| Fix { p_ned: f.p_ned + offset, ..f });
        }
        true
    });
    let (_, p_ned, _) = estimator.estimate().unwrap();
    assert!((p_ned.x - 60.0).abs() < 2.5, "{p_ned:?}");
}

/// A receiver's latest fix that comes with every sample is one fix.
#[test]
fn closed_form_a_fix_counts_once() {
    let (_, once) = fly_with(&EARTH, 9.0, |_, _, _| true);
    let mut latest = None;
    let (_, repeated) = fly_with(&EARTH, 9.0, |_, _, fix| {
        latest = fix.or(latest);
        *fix = latest;
        true
    });
    assert_eq!(once, repeated);
}

#[test]
fn closed_form_it_is_not_aligned_without_each_sensor_and_says_why() {
    let alone = |tamper: fn(&mut Sample, &mut Option<Fix>)| {
        let (estimator, _) = fly_with(&TITAN, 6.0, |_, sample, fix| {
            tamper(sample, fix);
            true
        });
        estimator.check_aligned()
    };
    assert_eq!(alone(|_, _| {}), Ok(()));
    assert_eq!(alone(|_, fix| *fix = None), Err(NotAligned::NoSatellites));
    assert_eq!(alone(|sample, _| sample.field_body = None), Err(NotAligned::NoMagnetometer));
    assert_eq!(alone(|sample, _| sample.altitude_m = None), Err(NotAligned::NoBarometer));
    // Nothing carries it: where down is cannot be guessed.
    let weightless = |sample: &mut Sample, _: &mut Option<Fix>| sample.inertial.specific_force_body *= 0.1;
    assert_eq!(alone(weightless), Err(NotAligned::NotCarried));
    // At the magnetic pole the field says nothing about heading; a swing would, by the satellite velocity.
    let pole = Site { field_ned_gauss: Vector3::new(0.005, 0.0, 0.5), ..EARTH };
    let (estimator, _) = fly_swinging(&pole, 0.0, 6.0, |_, _, _| true);
    assert_eq!(estimator.check_aligned(), Err(NotAligned::Heading));
    assert_eq!(Estimator::new(settings(&EARTH)).check_aligned(), Err(NotAligned::NoInertial));
    // Satellites that stay away for long.
    let (estimator, _) = fly_with(&TITAN, 8.0, |t, _, fix| {
        *fix = fix.filter(|_| t < 2.5);
        true
    });
    assert!(estimator.check_aligned().is_err());
}
