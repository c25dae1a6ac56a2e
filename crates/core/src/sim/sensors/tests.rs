//! All sensors together: none disturbs another, and each error can be switched on by itself.

use nalgebra::Vector3;

use super::*;
use crate::model::environment::GeoPoint;

const STEP_US: u64 = 4_000;

fn environment() -> Environment {
    let anchor = GeoPoint { latitude_deg: 47.4, longitude_deg: 8.5, altitude_m: 600.0 };
    Environment::new(9.80665, 1.225, Vector3::zeros(), anchor).unwrap()
}

fn silent() -> SensorSettings {
    SensorSettings {
        barometer: Barometer { noise_hpa: 0.0, ..Barometer::default() },
        ..SensorSettings::default()
    }
}

/// Every error at once.
fn noisy() -> SensorSettings {
    let triad =
        Triad { noise_density: 0.01, walk: 0.001, turn_on_bias: 0.1, resolution: 0.001, range: Some(100.0) };
    SensorSettings {
        accelerometer: triad,
        gyroscope: triad,
        magnetometer: Magnetometer { noise_gauss: 0.002, ..Magnetometer::default() },
        barometer: Barometer { noise_hpa: 0.01, drift_hpa_per_sqrt_s: 0.001, ..Barometer::default() },
        satellite: Satellite {
            horizontal_noise_m: 0.5,
            vertical_noise_m: 0.8,
            speed_noise_m_s: 0.1,
            delay_us: 108_000,
            ..Satellite::default()
        },
    }
}

fn body(t_us: u64) -> BodyState {
    let t_s = t_us as f64 * 1e-6;
    BodyState {
        p_ned: Vector3::new(2.0 * t_s, 0.0, 5.0 * t_s),
        v_ned: Vector3::new(2.0, -0.0, 5.0),
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        omega_body: Vector3::new(0.1, -0.0, 0.3),
    }
}

const FORCE: Vector3<f64> = Vector3::new(0.0, -0.0, -9.8);

/// What sensor `which` reads at a time, in bits.
fn read(sensors: &mut Sensors, which: usize, t_us: u64) -> Vec<u64> {
    let body = body(t_us);
    let values: Vec<f64> = match which {
        0 => sensors.accelerometer(FORCE, t_us).iter().copied().collect(),
        1 => sensors.gyroscope(body.omega_body, t_us).iter().copied().collect(),
        2 => sensors.magnetometer(body.q_ned_from_body).iter().copied().collect(),
        3 => vec![sensors.barometer(600.0 - body.p_ned.z, t_us)],
        _ => {
            let fix = sensors.satellite(&body, t_us);
            fix.p_ned.iter().chain(fix.v_ned.iter()).copied().collect()
        }
    };
    values.into_iter().map(f64::to_bits).collect()
}

fn noted(settings: SensorSettings, seed: u64, last: u64) -> Sensors {
    let mut sensors = Sensors::new(&environment(), settings, seed, STEP_US);
    for i in 0..=last {
        sensors.note(i * STEP_US, &body(i * STEP_US));
    }
    sensors
}

#[test]
fn prop_the_order_of_asking_does_not_matter() {
    for seed in [0, 1, 77, u64::MAX] {
        let (mut one, mut other) = (noted(noisy(), seed, 100), noted(noisy(), seed, 100));
        let t_us = 100 * STEP_US;
        let forwards: Vec<_> = (0..5).map(|which| read(&mut one, which, t_us)).collect();
        let mut backwards: Vec<_> = (0..5).rev().map(|which| read(&mut other, which, t_us)).collect();
        backwards.reverse();
        assert_eq!(forwards, backwards);
        let mut reseeded = noted(noisy(), seed ^ 2, 100);
        for (which, reading) in forwards.iter().enumerate() {
            assert_ne!(&read(&mut reseeded, which, t_us), reading, "sensor {which} does not follow the seed");
        }
    }
}

#[test]
fn closed_form_without_errors_every_sensor_reads_the_truth_to_the_bit() {
    let mut sensors = noted(silent(), 1, 50);
    let t_us = 50 * STEP_US;
    let bits = |v: &[f64]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    let body = body(t_us);
    assert_eq!(read(&mut sensors, 0, t_us), bits(FORCE.as_slice()));
    assert_eq!(read(&mut sensors, 1, t_us), bits(body.omega_body.as_slice()));
    assert_eq!(read(&mut sensors, 2, t_us), bits(dipole_ned_gauss(47.4).as_slice()));
    assert_eq!(read(&mut sensors, 3, t_us), bits(&[barometer::pressure_hpa(600.0 - body.p_ned.z)]));
    assert_eq!(read(&mut sensors, 4, t_us), bits(&[body.p_ned.as_slice(), body.v_ned.as_slice()].concat()));
}

/// A sensor's errors change that sensor alone, and leave its neighbours' draws where they are.
#[test]
fn closed_form_errors_are_switched_on_one_by_one() {
    let t_us = 50 * STEP_US;
    let only = [
        SensorSettings { accelerometer: noisy().accelerometer, ..silent() },
        SensorSettings { gyroscope: noisy().gyroscope, ..silent() },
        SensorSettings { magnetometer: noisy().magnetometer, ..silent() },
        SensorSettings { barometer: noisy().barometer, ..silent() },
        SensorSettings { satellite: noisy().satellite, ..silent() },
    ];
    for (on, settings) in only.into_iter().enumerate() {
        let (mut ideal, mut all) = (noted(silent(), 1, 50), noted(noisy(), 1, 50));
        let mut sensors = noted(settings, 1, 50);
        for which in 0..5 {
            let expected = if which == on { &mut all } else { &mut ideal };
            assert_eq!(read(&mut sensors, which, t_us), read(expected, which, t_us), "{on} {which}");
        }
        assert_ne!(read(&mut all, on, t_us), read(&mut ideal, on, t_us), "{on}");
    }
}

/// 110 ms are 27.5 steps of 4 ms, to the nearest: 28. Before anything is old enough, the oldest is reported.
#[test]
fn closed_form_a_fix_is_late_by_whole_steps() {
    let satellite = Satellite { delay_us: 110_000, ..Satellite::default() };
    for (last, seen) in [(100, 72), (28, 0), (5, 0)] {
        let mut sensors = noted(SensorSettings { satellite, ..silent() }, 1, last);
        let fix = sensors.satellite(&body(last * STEP_US), last * STEP_US);
        assert_eq!(fix.p_ned, body(seen * STEP_US).p_ned);
    }
}

/// Earth's field, given, takes the dipole's place; a turn of 90 deg to the east puts north to the left.
#[test]
fn closed_form_the_field_turns_with_the_vehicle() {
    let field = Vector3::new(0.21, 0.013, 0.43);
    let magnetometer = Magnetometer { field_ned_gauss: Some(field), ..Magnetometer::default() };
    let mut sensors = Sensors::new(&environment(), SensorSettings { magnetometer, ..silent() }, 1, STEP_US);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let read = sensors.magnetometer([half, 0.0, 0.0, half]);
    assert!((read - Vector3::new(field.y, -field.x, field.z)).amax() < 1e-15, "{read:?}");
}
