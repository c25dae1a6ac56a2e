//! Where PX4's topics of v1.12 to v1.18 have a flight's quantities.

use super::{LoggedFlight, MOST_ROTORS, Series, commands};
use crate::ulog::{Topic, Ulog};

/// A place in a log: topic, columns, the name of both.
type Place<'p> = (&'p str, &'p [&'p str], &'static str);

impl LoggedFlight {
    /// What a ULog has, each quantity from the first of the places that have it.
    pub fn of_ulog(log: &Ulog<'_>) -> Self {
        let moved = |series: &Series<MOST_ROTORS>| series.moved() >= FEWEST_ROTORS;
        let commanded = [("actuator_motors", &CONTROL[..], "actuator_motors.control")];
        let put_out = [("actuator_outputs", &OUTPUT[..], "actuator_outputs.output")];
        let speeds = [("esc_status", &ESC_RPM[..], "esc_status.esc_rpm")];
        let asked = |series: &Series<3>| series.values.iter().flatten().any(|x| x.is_finite());
        Self {
            motors: commands::throttles(
                &log.parameters,
                series_that(log, &commanded, moved),
                series_that(log, &put_out, moved),
            ),
            thrust: series(
                log,
                &[(
                    "vehicle_thrust_setpoint",
                    &["xyz[0]", "xyz[1]", "xyz[2]"],
                    "vehicle_thrust_setpoint.xyz",
                )],
            ),
            force_body_m_s2: quickest([
                series(log, &[("vehicle_acceleration", &XYZ, "vehicle_acceleration.xyz")]),
                series(log, &[("sensor_combined", &ACCELEROMETER, "sensor_combined.accelerometer_m_s2")]),
            ]),
            rates_body_rad_s: quickest([
                series(log, &[("vehicle_angular_velocity", &XYZ, "vehicle_angular_velocity.xyz")]),
                series(log, &[("sensor_combined", &GYRO, "sensor_combined.gyro_rad")]),
            ]),
            attitude: series(
                log,
                &[("vehicle_attitude", &["q[0]", "q[1]", "q[2]", "q[3]"], "vehicle_attitude.q")],
            ),
            velocity_ned_m_s: series(
                log,
                &[("vehicle_local_position", &VELOCITY, "vehicle_local_position.v")],
            ),
            position_ned_m: series(
                log,
                &[("vehicle_local_position", &["x", "y", "z"], "vehicle_local_position.xyz")],
            ),
            velocity_sp_ned_m_s: series_that(
                log,
                &[
                    ("vehicle_local_position_setpoint", &VELOCITY, "vehicle_local_position_setpoint.v"),
                    ("trajectory_setpoint", &VELOCITIES, "trajectory_setpoint.velocity"),
                    ("trajectory_setpoint", &VELOCITY, "trajectory_setpoint.v"),
                ],
                asked,
            ),
            rotor_speeds_rad_s: series_that(log, &speeds, |_| true).map(|mut series| {
                series.values.iter_mut().flatten().for_each(|speed| *speed *= RAD_S_PER_RPM);
                series
            }),
            density_kg_m3: series_that(
                log,
                &[
                    ("vehicle_air_data", &["rho"], "vehicle_air_data.rho"),
                    ("vehicle_air_data", &["baro_pressure_pa", "baro_temp_celcius"], AIR),
                ],
                |_| true,
            )
            .map(density),
            battery: series(log, &[("battery_status", &["voltage_v", "current_a"], "battery_status")]),
            armed: series(
                log,
                &[
                    ("actuator_armed", &["armed"], "actuator_armed.armed"),
                    ("vehicle_status", &["arming_state"], "vehicle_status.arming_state"),
                ],
            )
            .map(|mut series| {
                // ARMED is the second of the states.
                if series.from == "vehicle_status.arming_state" {
                    series.values.iter_mut().for_each(|[state]| *state = f64::from(*state == 2.0));
                }
                series
            }),
            landed: series(log, &[("vehicle_land_detected", &["landed"], "vehicle_land_detected.landed")]),
        }
    }
}

/// A time that is so much later than the one before is none [us].
const JUMP_US: u64 = 3_600_000_000;
/// Rotors of the least multirotor.
const FEWEST_ROTORS: usize = 3;
const CONTROL: [&str; MOST_ROTORS] = [
    "control[0]",
    "control[1]",
    "control[2]",
    "control[3]",
    "control[4]",
    "control[5]",
    "control[6]",
    "control[7]",
];
const OUTPUT: [&str; MOST_ROTORS] =
    ["output[0]", "output[1]", "output[2]", "output[3]", "output[4]", "output[5]", "output[6]", "output[7]"];
const ESC_RPM: [&str; MOST_ROTORS] = [
    "esc[0].esc_rpm",
    "esc[1].esc_rpm",
    "esc[2].esc_rpm",
    "esc[3].esc_rpm",
    "esc[4].esc_rpm",
    "esc[5].esc_rpm",
    "esc[6].esc_rpm",
    "esc[7].esc_rpm",
];
const RAD_S_PER_RPM: f64 = std::f64::consts::PI / 30.0;
const AIR: &str = "vehicle_air_data.baro_pressure_pa";
/// Gas constant of dry air [J/(kg K)], and zero Celsius [K].
const GAS_J_KG_K: f64 = 287.053;
const CELSIUS_K: f64 = 273.15;
const VELOCITY: [&str; 3] = ["vx", "vy", "vz"];
const VELOCITIES: [&str; 3] = ["velocity[0]", "velocity[1]", "velocity[2]"];
const XYZ: [&str; 3] = ["xyz[0]", "xyz[1]", "xyz[2]"];
const ACCELEROMETER: [&str; 3] = ["accelerometer_m_s2[0]", "accelerometer_m_s2[1]", "accelerometer_m_s2[2]"];
const GYRO: [&str; 3] = ["gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]"];

/// That of two series which has more values.
fn quickest<const N: usize>(series: [Option<Series<N>>; 2]) -> Option<Series<N>> {
    series.into_iter().flatten().max_by_key(|series| series.t_s.len())
}

/// The first place of a log that has rows.
fn series<const N: usize>(log: &Ulog<'_>, places: &[Place<'_>]) -> Option<Series<N>> {
    series_that(log, places, |_| true)
}

/// The first place of a log, of any instance, whose rows are as they are to be. Columns that are not there
/// are NaN, but for the first, which is to be there; rows that go back in time, or jump, are left out.
fn series_that<const N: usize>(
    log: &Ulog<'_>,
    places: &[Place<'_>],
    fits: impl Fn(&Series<N>) -> bool,
) -> Option<Series<N>> {
    places.iter().find_map(|place| {
        let topics = log.topics().filter(|topic| topic.name == place.0);
        topics.filter_map(|topic| rows(log, topic, place)).find(&fits)
    })
}

fn rows<const N: usize>(log: &Ulog<'_>, topic: &Topic, (_, columns, from): &Place<'_>) -> Option<Series<N>> {
    let mut columns: Vec<_> = columns.iter().map(|column| log.values(topic, column)).collect();
    columns.first().filter(|column| column.is_some())?;
    let mut series = Series { from, t_s: Vec::new(), values: Vec::new() };
    let mut newest = None;
    for time in log.times_us(topic) {
        let mut values = [f64::NAN; N];
        for (value, column) in values.iter_mut().zip(&mut columns) {
            *value = column.as_mut().and_then(Iterator::next).unwrap_or(f64::NAN);
        }
        if newest.is_some_and(|newest| time <= newest || time - newest > JUMP_US) {
            continue;
        }
        newest = Some(time);
        series.t_s.push((time as f64 - log.start_us as f64) * 1e-6);
        series.values.push(values);
    }
    Some(series)
}

/// The density of the air where it was logged, or by the law of gases.
fn density(series: Series<2>) -> Series<1> {
    let of = |[first, temperature_c]: [f64; 2]| {
        let is_pressure = series.from == AIR;
        [if is_pressure { first / (GAS_J_KG_K * (temperature_c + CELSIUS_K)) } else { first }]
    };
    Series { from: series.from, values: series.values.iter().copied().map(of).collect(), t_s: series.t_s }
}
