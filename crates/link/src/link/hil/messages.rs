//! Sensors, truth and battery of the vehicle as HIL messages.
//!
//! [`crate::sim::sensors`] has what sensors read; here it becomes messages, in their units and integers. The
//! truth (HIL_STATE_QUATERNION, ODOMETRY) has no errors.

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use super::super::wire;
use super::super::wire::{
    ACCELEROMETER, GYROSCOPE, MAGNETOMETER, UNKNOWN_BATTERY, degrees_e7_and_mm, single,
};
use super::rates::HilRates;
use crate::control::Measurement;
use crate::math;
use crate::model::Environment;
use crate::model::supply::BusState;
use crate::sim::faults::{Sensor, SensorFault};
use crate::sim::sensors::barometer::pressure_altitude_m;
use crate::sim::sensors::{FaultySensors, Fix, Sensors};
use crate::sim::{Battery, DropRun, DropSimulation, ElectricBattery, SensorSettings};
use crate::time::{TimeUs, seconds};
use crate::units::{DEG_PER_RAD, SEA_LEVEL_DENSITY_KG_M3, STANDARD_GRAVITY_M_S2, ZERO_DEG_C_K};

/// Fields of HIL_SENSOR that the barometer makes: pressure, pressure altitude and temperature. A multirotor
/// has no airspeed sensor: the differential pressure (0x400) is never there.
const BAROMETER: HilSensorUpdatedFlags = HilSensorUpdatedFlags::from_bits_retain(0x1A00);
/// Below this ground speed [m/s] there is no course.
const COURSE_SPEED_M_S: f64 = 0.1;

/// The vehicle's state at an instant as the messages need it.
#[derive(Clone, Copy, Debug)]
pub struct Truth<'a> {
    /// Simulated time.
    pub at: TimeUs,
    /// The simulation, standing at that time.
    pub sim: &'a DropSimulation,
    /// What the accelerometer reads, body [m/s^2]; [`DropSimulation::specific_force_body`], once for all
    /// messages.
    pub specific_force_body: Vector3<f64>,
}

/// The sensors of one vehicle at its site.
#[derive(Clone, Debug)]
pub struct HilSensors {
    sensors: Sensors,
    /// The last HIL_SENSOR: what has not been read again stands in the next as it was.
    last: HIL_SENSOR_DATA,
    faulty: FaultySensors,
}

impl HilSensors {
    /// Sensors at the site, read every `step_us`; `seed` draws their errors.
    pub fn new(environment: &Environment, settings: SensorSettings, seed: u64, step_us: TimeUs) -> Self {
        let last = HIL_SENSOR_DATA { id: 0, ..HIL_SENSOR_DATA::default() };
        let faulty = FaultySensors::new(seed);
        Self { sensors: Sensors::new(environment, settings, seed, step_us), last, faulty }
    }

    /// Makes the messages of a step, HIL_SENSOR last, and hands each to `send`.
    pub(super) fn messages(
        &mut self,
        run: &DropRun,
        rates: &mut HilRates,
        send: &mut impl FnMut(&MavMessage),
    ) {
        let (at, sim) = (run.now(), run.simulation());
        let truth = Truth { at, sim, specific_force_body: sim.specific_force_body() };
        self.note(&truth);
        if rates.state_quaternion.due(at) {
            send(&MavMessage::HIL_STATE_QUATERNION(self.state_quaternion(&truth)));
        }
        if rates.odometry.due(at) {
            send(&MavMessage::ODOMETRY(self.odometry(&truth)));
        }
        if let Some(battery) = run.battery()
            && rates.battery.due(at)
        {
            send(&MavMessage::BATTERY_STATUS(battery_status(battery)));
        }
        if let Some(battery) = sim.battery()
            && rates.voltage.due(at)
        {
            let bus = sim.loads().bus.unwrap_or_default();
            send(&MavMessage::BATTERY_STATUS(electric_battery_status(battery, &bus)));
        }
        if rates.gps.due(at) {
            let fix = self.gps(&truth);
            if !is_off(sim, Sensor::Gps) {
                send(&MavMessage::HIL_GPS(fix));
            }
        }
        let (magnetometer, barometer) = (rates.magnetometer.due(at), rates.barometer.due(at));
        send(&MavMessage::HIL_SENSOR(self.sensor(&truth, magnetometer, barometer)));
    }

    /// Notes the truth of a step, for what is reported with a delay.
    pub fn note(&mut self, truth: &Truth<'_>) {
        self.sensors.note(truth.at, &truth.sim.state().body);
    }

    /// HIL_SENSOR: accelerometer and gyroscope, and what else is due; body FRD, `id` 0, which drives PX4's
    /// clock.
    pub fn sensor(&mut self, truth: &Truth<'_>, magnetometer: bool, barometer: bool) -> HIL_SENSOR_DATA {
        let body = &truth.sim.state().body;
        let m = &mut self.last;
        m.time_usec = truth.at;
        m.fields_updated = HilSensorUpdatedFlags::empty();
        let (faults, faulty) = (truth.sim.faults(), &mut self.faulty);
        let mut given = |sensor, reading| match faults {
            None => Some(reading),
            Some(faults) => faulty.reading(faults, sensor, reading, seconds(truth.at)),
        };
        let force_body = self.sensors.accelerometer(truth.specific_force_body, truth.at);
        if let Some(force_body) = given(Sensor::Accelerometer, force_body) {
            m.fields_updated |= ACCELEROMETER;
            [m.xacc, m.yacc, m.zacc] = single(force_body);
        }
        if let Some(omega_body) = given(Sensor::Gyro, self.sensors.gyroscope(body.omega_body, truth.at)) {
            m.fields_updated |= GYROSCOPE;
            [m.xgyro, m.ygyro, m.zgyro] = single(omega_body);
        }
        if magnetometer
            && let Some(field_body) =
                given(Sensor::Magnetometer, self.sensors.magnetometer(body.q_ned_from_body))
        {
            m.fields_updated |= MAGNETOMETER;
            [m.xmag, m.ymag, m.zmag] = single(field_body);
        }
        let altitude_m = truth.sim.environment().geo_point(&body.p_ned).altitude_m;
        let mut pressure_hpa = || Vector3::new(self.sensors.barometer(altitude_m, truth.at), 0.0, 0.0);
        if barometer && let Some(pressure_hpa) = given(Sensor::Barometer, pressure_hpa()) {
            m.fields_updated |= BAROMETER;
            let pressure_hpa = pressure_hpa.x;
            m.abs_pressure = pressure_hpa as f32;
            m.pressure_alt = pressure_altitude_m(pressure_hpa) as f32;
            let air = truth.sim.environment().atmosphere.at(altitude_m);
            let standard_deg_c = || 15.0 - 0.0065 * altitude_m.clamp(-1_000.0, 11_000.0);
            m.temperature = air.map_or_else(standard_deg_c, |air| air.temperature_k - ZERO_DEG_C_K) as f32;
        }
        m.clone()
    }

    /// HIL_GPS: a 3D fix, as old as the receiver's delay, stamped with the time of its sending; or, of a
    /// receiver that has none, that.
    pub fn gps(&mut self, truth: &Truth<'_>) -> HIL_GPS_DATA {
        let mut fix = self.sensors.satellite(&truth.sim.state().body, truth.at);
        if let Some(faults) = truth.sim.faults() {
            match self.faulty.fix(faults, [fix.p_ned, fix.v_ned], seconds(truth.at)) {
                Some([p_ned, v_ned]) => fix = Fix { p_ned, v_ned },
                None => return no_fix(truth.at),
            }
        }
        let ground_speed = fix.v_ned.xy().norm();
        let course_deg = math::atan2(fix.v_ned.y, fix.v_ned.x) * DEG_PER_RAD;
        let accuracy_m = self.sensors.settings().satellite.reported_accuracy_m();
        let [eph, epv] = accuracy_m.map(|m| (m * 100.0).round() as u16);
        let mut m = HIL_GPS_DATA {
            time_usec: truth.at,
            eph,
            epv,
            vel: (ground_speed * 100.0).round() as u16,
            cog: if ground_speed < COURSE_SPEED_M_S {
                u16::MAX
            } else {
                // 360.00 deg would be 36000, which the field does not have.
                ((course_deg.rem_euclid(360.0) * 100.0).round() as u16) % 36_000
            },
            fix_type: GpsFixType::GPS_FIX_TYPE_3D_FIX as u8,
            satellites_visible: 12,
            ..HIL_GPS_DATA::DEFAULT
        };
        [m.lat, m.lon, m.alt] = degrees_e7_and_mm(&truth.sim.environment().geo_point(&fix.p_ned));
        [m.vn, m.ve, m.vd] = (fix.v_ned * 100.0).map(|v| v.round() as i16).into();
        m
    }

    /// HIL_STATE_QUATERNION: the truth, velocities and accelerations in coarse integers, for logs and
    /// viewers.
    pub fn state_quaternion(&self, truth: &Truth<'_>) -> HIL_STATE_QUATERNION_DATA {
        let body = &truth.sim.state().body;
        let site = truth.sim.environment();
        let higher = site.at(&body.p_ned);
        let environment = higher.as_ref().unwrap_or(site);
        let true_airspeed_m_s = (body.v_ned - environment.wind_ned_m_s).norm();
        // What a pitot tube shows: the speed that makes the same dynamic pressure in the standard air of sea
        // level.
        let indicated_airspeed_m_s =
            true_airspeed_m_s * (environment.density_kg_m3 / SEA_LEVEL_DENSITY_KG_M3).sqrt();
        let cm_s = |speed_m_s: f64| (speed_m_s * 100.0).round() as u16;
        let milli_g = truth.specific_force_body * (1e3 / STANDARD_GRAVITY_M_S2);
        let mut m = HIL_STATE_QUATERNION_DATA {
            time_usec: truth.at,
            attitude_quaternion: body.q_ned_from_body.map(|c| c as f32),
            ind_airspeed: cm_s(indicated_airspeed_m_s),
            true_airspeed: cm_s(true_airspeed_m_s),
            ..HIL_STATE_QUATERNION_DATA::DEFAULT
        };
        [m.rollspeed, m.pitchspeed, m.yawspeed] = single(body.omega_body);
        [m.lat, m.lon, m.alt] = degrees_e7_and_mm(&environment.geo_point(&body.p_ned));
        [m.vx, m.vy, m.vz] = (body.v_ned * 100.0).map(|v| v.round() as i16).into();
        [m.xacc, m.yacc, m.zacc] = milli_g.map(|a| a.round() as i16).into();
        m
    }

    /// ODOMETRY: the truth in single precision; position in the local NED frame, velocities in body FRD.
    pub fn odometry(&self, truth: &Truth<'_>) -> ODOMETRY_DATA {
        let body = &truth.sim.state().body;
        wire::odometry(truth.at, body.p_ned, &Measurement::from(body))
    }
}

fn is_off(sim: &DropSimulation, sensor: Sensor) -> bool {
    let fault = sim.faults().and_then(|faults| faults.of_sensor(sensor));
    fault.is_some_and(|(fault, _)| fault == SensorFault::Off)
}

/// HIL_GPS of a receiver without a fix; what is not known is told as unknown.
fn no_fix(at: TimeUs) -> HIL_GPS_DATA {
    HIL_GPS_DATA {
        time_usec: at,
        fix_type: GpsFixType::GPS_FIX_TYPE_NO_FIX as u8,
        eph: u16::MAX,
        epv: u16::MAX,
        vel: u16::MAX,
        cog: u16::MAX,
        ..HIL_GPS_DATA::DEFAULT
    }
}

/// BATTERY_STATUS of a store of energy: what is left and what has been taken; no volts, no amperes. PX4 does
/// not listen to it here (it has a battery of its own, SIM_BAT_DRAIN); samara's autopilot does.
fn battery_status(battery: &Battery) -> BATTERY_STATUS_DATA {
    BATTERY_STATUS_DATA {
        // hJ
        energy_consumed: (battery.consumed_j() / 100.0).round() as i32,
        battery_remaining: (battery.charge() * 100.0).ceil() as i8,
        ..UNKNOWN_BATTERY
    }
}

/// BATTERY_STATUS of a pack on its bus. The cells are not known: its voltage stands in the first of them, and
/// what is more than the field has in those that follow, as MAVLink wants it.
fn electric_battery_status(battery: &ElectricBattery, bus: &BusState) -> BATTERY_STATUS_DATA {
    const MOST_MV: u16 = u16::MAX - 1;
    let mut voltages = [u16::MAX; 10];
    let mut left_mv = (bus.bus_v * 1e3).round();
    for voltage in &mut voltages {
        // `as u16` saturates.
        *voltage = (left_mv as u16).min(MOST_MV);
        left_mv -= f64::from(*voltage);
        if left_mv <= 0.0 {
            break;
        }
    }
    BATTERY_STATUS_DATA {
        voltages,
        // cA
        current_battery: (bus.pack_a * 100.0).round() as i16,
        // mAh
        current_consumed: (battery.consumed_c() / 3.6).round() as i32,
        // hJ
        energy_consumed: (battery.consumed_j() / 100.0).round() as i32,
        battery_remaining: (battery.charge() * 100.0).ceil() as i8,
        ..UNKNOWN_BATTERY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MAX_ROTORS;
    use crate::model::supply::{Pack, PackLimits, Throttle};
    use crate::test_site;

    fn ideal(sim: &DropSimulation, seed: u64) -> HilSensors {
        HilSensors::new(sim.environment(), SensorSettings::default(), seed, 4_000)
    }

    fn hanging(at: TimeUs) -> (HilSensors, DropSimulation, Vector3<f64>) {
        let mut sim = test_site::drop_simulation();
        sim.step(&[0.0; MAX_ROTORS], seconds(at));
        let f = sim.specific_force_body();
        (ideal(&sim, 1), sim, f)
    }

    #[test]
    fn closed_form_a_hanging_vehicle_feels_its_weight_upwards() {
        let (mut sensors, sim, specific_force_body) = hanging(8_000);
        let m = sensors.sensor(&Truth { at: 8_000, sim: &sim, specific_force_body }, true, true);
        assert!((m.zacc + 9.80665).abs() < 1e-6 && m.xacc.abs() < 1e-6, "{m:?}");
        assert_eq!((m.time_usec, m.id, m.fields_updated.bits()), (8_000, 0, 0x1BFF));
        // 47.4 deg north: the field points down and north.
        assert!((f64::from(m.xmag) - 0.312 * math::cos(47.4f64.to_radians())).abs() < 1e-7 && m.zmag > 0.4);
    }

    /// By hand: 140.25 V are 65 534, 65 534 and 9 182 mV; 3.6 kC are 1 A h.
    #[test]
    fn closed_form_a_pack_in_mavlinks_units() {
        let limits = PackLimits {
            resistance_ohm: 0.0,
            current_max_a: f64::INFINITY,
            esc_current_max_a: f64::INFINITY,
            esc_efficiency: 1.0,
            motor_efficiency: 1.0,
            nominal_v: 1.0,
            throttle: Throttle::Speed,
        };
        let pack = Pack::new(vec![(0.0, 140.25)], limits).unwrap();
        let battery = ElectricBattery::new(pack, 3600.0 * 140.25, 0.254);
        let m = electric_battery_status(&battery, &BusState { pack_a: 12.345, ..battery.at_rest() });
        assert_eq!(m.voltages[..4], [65_534, 65_534, 9_182, u16::MAX]);
        assert_eq!((m.current_battery, m.current_consumed, m.battery_remaining), (1_235, 0, 26));
        let small = electric_battery_status(&battery, &BusState { bus_v: 15.2, ..BusState::default() });
        assert_eq!(small.voltages[..2], [15_200, u16::MAX]);
    }

    #[test]
    fn the_barometer_never_repeats_itself_and_its_noise_is_small_and_repeatable() {
        let (_, sim, specific_force_body) = hanging(8_000);
        let pressures = |seed| -> Vec<f64> {
            let mut sensors = ideal(&sim, seed);
            let mut at = |at| sensors.sensor(&Truth { at, sim: &sim, specific_force_body }, true, true);
            (1..2_000).map(|i| f64::from(at(i * 4_000).abs_pressure)).collect()
        };
        let p = pressures(1);
        assert!(p.windows(20).all(|w| w.iter().any(|x| *x != w[0])));
        let mean = p.iter().sum::<f64>() / p.len() as f64;
        let std = (p.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / p.len() as f64).sqrt();
        assert!((0.008..0.012).contains(&std), "{std}");
        assert_eq!(pressures(1), p);
        assert_ne!(pressures(2), p, "another seed, another noise");
    }

    #[test]
    fn what_has_not_been_read_is_not_flagged_and_stands_as_it_was() {
        let (mut sensors, sim, specific_force_body) = hanging(8_000);
        let mut read = |at, magnetometer, barometer| {
            sensors.sensor(&Truth { at, sim: &sim, specific_force_body }, magnetometer, barometer)
        };
        let first = read(8_000, true, true);
        for (at, magnetometer, barometer, flags) in
            [(12_000, false, false, 0x3F), (16_000, true, false, 0x1FF), (20_000, false, true, 0x1A3F)]
        {
            let m = read(at, magnetometer, barometer);
            assert_eq!((m.time_usec, m.fields_updated.bits()), (at, flags));
            assert_eq!((m.xmag, m.ymag, m.zmag), (first.xmag, first.ymag, first.zmag), "no noise of its own");
            assert_eq!(m.abs_pressure != first.abs_pressure, barometer);
        }
    }

    #[test]
    fn closed_form_scaled_integers_hold_the_descent() {
        let (mut sensors, sim, specific_force_body) = hanging(500_000);
        let truth = Truth { at: 500_000, sim: &sim, specific_force_body };
        let gps = sensors.gps(&truth);
        // 5 m/s down from 10 m above the point of release, at 600 m.
        assert_eq!((gps.lat, gps.lon, gps.alt), (474_000_000, 85_000_000, 607_500));
        assert_eq!((gps.vn, gps.ve, gps.vd, gps.cog, gps.fix_type), (0, 0, 500, u16::MAX, 3));
        let state = sensors.state_quaternion(&truth);
        // The site has the density of the standard atmosphere at sea level.
        assert_eq!((state.vz, state.zacc, state.true_airspeed, state.ind_airspeed), (500, -1000, 500, 500));
        let odometry = sensors.odometry(&truth);
        assert_eq!((odometry.vz, odometry.z, odometry.q), (5.0, -7.5, [1.0, 0.0, 0.0, 0.0]));
    }

    /// The fix is that of two steps ago, under the stamp of now.
    #[test]
    fn closed_form_a_late_fix_bears_the_time_of_its_sending() {
        let mut settings = SensorSettings::default();
        settings.satellite.delay_us = 8_000;
        let mut sim = test_site::drop_simulation();
        let mut sensors = HilSensors::new(sim.environment(), settings, 1, 4_000);
        let mut altitudes_mm = Vec::new();
        for step in 1..=10 {
            sim.step(&[0.0; MAX_ROTORS], 0.004);
            let truth = Truth { at: step * 4_000, sim: &sim, specific_force_body: Vector3::zeros() };
            sensors.note(&truth);
            let gps = sensors.gps(&truth);
            assert_eq!((gps.time_usec, gps.eph, gps.epv), (step * 4_000, 90, 120));
            altitudes_mm.push((gps.alt, ideal(&sim, 1).gps(&truth).alt));
        }
        for (i, (sent, _)) in altitudes_mm.iter().enumerate() {
            assert_eq!(*sent, altitudes_mm[i.saturating_sub(2)].1, "{i}");
        }
        // 2 m of noise are sent as an accuracy of 2 m; the rest of the message's accuracy stays.
        settings.satellite.horizontal_noise_m = 2.0;
        let mut sensors = HilSensors::new(sim.environment(), settings, 1, 4_000);
        let truth = Truth { at: 40_000, sim: &sim, specific_force_body: Vector3::zeros() };
        let gps = sensors.gps(&truth);
        assert_eq!((gps.eph, gps.epv), (200, 120));
    }

    /// IAS = TAS sqrt(rho / 1.225): air four times as thick, as on Titan, pushes like twice the speed.
    #[test]
    fn closed_form_indicated_airspeed_is_that_of_the_dynamic_pressure() {
        for (density_kg_m3, indicated) in [(4.9, 1000), (1.225, 500), (0.30625, 250)] {
            let environment = Environment { density_kg_m3, ..test_site::environment() };
            let sim = test_site::drop_simulation_at(environment, 2.0);
            let truth = Truth { at: 4_000, sim: &sim, specific_force_body: Vector3::zeros() };
            let state = ideal(&sim, 1).state_quaternion(&truth);
            assert_eq!((state.true_airspeed, state.ind_airspeed), (500, indicated), "{density_kg_m3}");
        }
    }
}
