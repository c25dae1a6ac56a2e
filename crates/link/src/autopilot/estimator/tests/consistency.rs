//! Whether the filter knows how wrong it is: normalised squared errors inside their chi-square bounds through
//! hang, fall and pull-out (Bar-Shalom, Li, Kirubarajan 2001, section 5.4.2).

use super::super::error_state::N;
use super::super::{Estimator, Filter, Inertial, NominalState};
use super::flight::{DT_S, EARTH, HANG_S, STEP_US, Site, TITAN, fly};
use super::sensors::{Random, Sensors};
use super::{GPS_DELAY_US, error, settings, squared_error};
use nalgebra::Vector3;

const SEEDS: u64 = 100;
const DURATION_S: f64 = 12.0;
/// Swing, one sigma [rad].
const SWING_RAD: f64 = 0.1;
/// When it is looked at [s]: hang, release, fall, the rotors' start, pull-out.
const LOOKS_S: [f64; 9] = [3.0, 5.0, 7.9, 8.12, 8.3, 8.6, 9.0, 10.0, 12.0];

/// Normalised squared errors of one flight at the looks.
fn flight_of(site: &Site, seed: u64) -> [f64; LOOKS_S.len()] {
    let settings = settings(site);
    let mut random = Random::new(seed);
    let (amplitude, phase) = (SWING_RAD * random.normal(), std::f64::consts::TAU * random.uniform());
    let flight = fly(site, amplitude, phase, DURATION_S);
    let mut sensors = Sensors::new(&settings, random);
    let mut estimator = Estimator::new(settings);
    let late = (GPS_DELAY_US / STEP_US) as usize;
    let (mut looks, mut states) = ([f64::NAN; LOOKS_S.len()], Vec::new());
    for (i, truth) in flight.iter().enumerate() {
        if let Some(fix) = sensors.fix(&flight, i) {
            estimator.take_fix(&fix);
        }
        estimator.take(&sensors.sample(truth));
        states.push(sensors.state(truth));
        let Some(filter) = estimator.filter() else { continue };
        let e = error(&states[i - late], &filter.state);
        if let Some(k) = LOOKS_S.iter().position(|t| (t / DT_S).round() as usize == i + 1) {
            looks[k] = squared_error(&e, &filter.covariance).unwrap();
        } else if i % 25 == 0 {
            assert!(squared_error(&e, &filter.covariance).is_some(), "seed {seed}, step {i}");
        }
    }
    assert_eq!(estimator.check_aligned(), Ok(()), "seed {seed}: {:?}", estimator.accuracy());
    looks
}

/// The sum over the seeds is chi-square of `seeds x N` degrees of freedom; its bounds at 3.3 sigmas (99.9 %)
/// by Wilson and Hilferty's cube.
fn check_consistent(site: &Site) {
    let flights: Vec<_> = (0..SEEDS).map(|seed| flight_of(site, seed)).collect();
    let freedom = (SEEDS as usize * N) as f64;
    let bound = |z: f64| {
        let c = 2.0 / (9.0 * freedom);
        freedom * (1.0 - c + z * c.sqrt()).powi(3) / SEEDS as f64
    };
    let means: Vec<f64> = (0..LOOKS_S.len())
        .map(|k| flights.iter().map(|looks| looks[k]).sum::<f64>() / SEEDS as f64)
        .collect();
    let (least, most) = (bound(-3.3), bound(3.3));
    assert!(means.iter().all(|m| (least..most).contains(m)), "{means:.2?} not in {least:.2}..{most:.2}");
}

#[test]
fn closed_form_errors_are_as_large_as_the_filter_says_on_earth() {
    check_consistent(&EARTH);
}

#[test]
fn closed_form_errors_are_as_large_as_the_filter_says_on_titan() {
    check_consistent(&TITAN);
}

/// Without noise and without measurements the nominal state follows the simulation from the hang to the
/// pull-out, up to the error of the steps: half a step of each jump of the force (release, start of the
/// rotors) and rounding beside it.
#[test]
fn closed_form_inertial_prediction_follows_the_simulation() {
    for site in [EARTH, TITAN] {
        let flight = fly(&site, 0.2, 1.0, DURATION_S);
        let quiet = |i: usize| Inertial {
            specific_force_body: flight[i].specific_force_body,
            omega_body: flight[i].body.omega_body,
        };
        let first = &flight[0].body;
        let mut state = NominalState {
            p_ned: first.p_ned,
            v_ned: first.v_ned,
            q_ned_from_body: first.q_ned_from_body,
            accelerometer_bias: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            baro_offset_m: 0.0,
        };
        let mut filter = Filter::new(0, state, &[1e-4; N]);
        let released = (HANG_S / DT_S).round() as usize;
        for i in 1..flight.len() {
            let dt_s = DT_S;
            filter.predict(&settings(&site), &quiet(i - 1), &quiet(i), dt_s);
            state.predict(&Inertial::mean(&quiet(i - 1), &quiet(i)), site.gravity_m_s2, dt_s);
            assert_eq!(state, filter.state);
            let body = &flight[i].body;
            let truth = NominalState {
                p_ned: body.p_ned,
                v_ned: body.v_ned,
                q_ned_from_body: body.q_ned_from_body,
                ..state
            };
            let e = error(&truth, &state);
            let size = |at: usize| Vector3::new(e[at], e[at + 1], e[at + 2]).norm();
            let (p, v, turn) = if i + 1 < released { (1e-3, 5e-4, 2e-5) } else { (0.15, 0.03, 1e-3) };
            assert!(size(0) < p && size(3) < v && size(6) < turn, "step {i}: {e:?}");
        }
    }
}
