//! The telemetry messages, each built from what is known when it is due. A message that needs a state is not
//! sent before there is one. `time_boot_ms` is simulated time.
//!
//! | file | messages about |
//! |---|---|
//! | here | the vehicle's condition |
//! | `motion` | where it is and how it moves |
//! | `health` | how good the state is |
//! | `identity` | version, modes, plans |
//!
//! A new message is a row of [`TABLE`] and the method that builds it.

mod health;
mod identity;
mod motion;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use nalgebra::Vector3;
use num_traits::FromPrimitive as _;

use self::health::{SENSORS, ailing, estimator_status};
use self::identity::{autopilot_version, component_metadata, current_mode, mission_current};
use super::files::FileServer;
use super::hil::VehicleState;
use super::missions::Missions;
use super::sensing::FIX_3D;
use super::vehicle::Vehicle;
use crate::autopilot::FlightMode;
use crate::link::wire::{UNKNOWN_BATTERY, degrees_e7_and_mm, single};
use crate::time::TimeUs;

pub(super) use self::identity::{available_modes, mode_of_standard};

/// Microseconds in a second.
const US_PER_SECOND: TimeUs = 1_000_000;

/// PING, which MAVLink has given up and PX4 has not.
const PING_ID: u32 = 4;

type Build = fn(&Telemetry<'_>) -> Option<MavMessage>;

/// Every telemetry message: its number, its rates on ground stations' and companions' links [Hz] (none: only
/// on request), and how it is built. Rates are those of PX4 v1.14, the version that AUTOPILOT_VERSION
/// reports: `normal` with what its simulation's start script asks for beside (init.d-posix/px4-rc.mavlink),
/// and `onboard` (mavlink_main.cpp). What PX4 sends there as often as it is measured comes at 10 Hz. Of PX4
/// v1.15 are CURRENT_MODE and AVAILABLE_MODES_MONITOR.
pub(super) const TABLE: [(u32, f64, f64, Build); 30] = [
    (HEARTBEAT_DATA::ID, 1.0, 1.0, |t| Some(t.heartbeat())),
    (SYS_STATUS_DATA::ID, 1.0, 5.0, |t| Some(t.sys_status())),
    (SYSTEM_TIME_DATA::ID, 1.0, 1.0, |t| Some(t.system_time())),
    (GPS_RAW_INT_DATA::ID, 1.0, 10.0, |t| t.gps_raw_int()),
    (ATTITUDE_DATA::ID, 50.0, 100.0, |t| Some(t.attitude(&t.state()?))),
    (ATTITUDE_QUATERNION_DATA::ID, 50.0, 50.0, |t| Some(t.attitude_quaternion(&t.state()?))),
    (LOCAL_POSITION_NED_DATA::ID, 50.0, 30.0, |t| Some(t.local_position_ned(&t.state()?))),
    (GLOBAL_POSITION_INT_DATA::ID, 50.0, 50.0, |t| Some(t.global_position_int(&t.state()?))),
    (SERVO_OUTPUT_RAW_DATA::ID, 50.0, 10.0, |t| Some(t.servo_output_raw())),
    (MISSION_CURRENT_DATA::ID, 1.0, 1.0, |t| Some(mission_current(t.missions, &t.vehicle.autopilot))),
    (VFR_HUD_DATA::ID, 4.0, 10.0, |t| Some(t.vfr_hud(&t.state()?))),
    (ATTITUDE_TARGET_DATA::ID, 50.0, 10.0, |t| t.attitude_target()),
    (POSITION_TARGET_LOCAL_NED_DATA::ID, 50.0, 10.0, |t| t.position_target()),
    (POSITION_TARGET_GLOBAL_INT_DATA::ID, 1.0, 10.0, |t| t.global_position_target()),
    (HIGHRES_IMU_DATA::ID, 0.0, 50.0, |t| t.highres_imu()),
    (TIMESYNC_DATA::ID, 0.0, 10.0, |t| Some(t.timesync())),
    (ALTITUDE_DATA::ID, 1.0, 10.0, |t| Some(t.altitude(&t.state()?))),
    (BATTERY_STATUS_DATA::ID, 0.5, 0.5, |t| Some(t.battery_status())),
    (ESTIMATOR_STATUS_DATA::ID, 0.5, 1.0, |t| estimator_status(t.now, t.vehicle)),
    (HOME_POSITION_DATA::ID, 0.5, 0.5, |t| t.vehicle.home.message(&t.vehicle.environment)),
    (EXTENDED_SYS_STATE_DATA::ID, 1.0, 5.0, |t| t.extended_sys_state()),
    (SCALED_PRESSURE_DATA::ID, 1.0, 1.0, |t| t.scaled_pressure()),
    (VIBRATION_DATA::ID, 0.1, 0.5, |t| t.vibration()),
    (UTM_GLOBAL_POSITION_DATA::ID, 0.5, 1.0, |t| Some(t.utm_global_position(&t.state()?))),
    (PING_ID, 0.1, 1.0, |t| Some(t.ping())),
    (ODOMETRY_DATA::ID, 0.0, 30.0, |t| Some(t.odometry(&t.state()?))),
    (CURRENT_MODE_DATA::ID, 0.5, 0.5, |t| {
        let autopilot = &t.vehicle.autopilot;
        Some(current_mode(autopilot.mode(), autopilot.intended_mode()))
    }),
    (AVAILABLE_MODES_MONITOR_DATA::ID, 0.3, 0.3, |_| Some(identity::available_modes_monitor())),
    (AUTOPILOT_VERSION_DATA::ID, 0.0, 0.0, |_| Some(autopilot_version())),
    (COMPONENT_METADATA_DATA::ID, 0.0, 0.0, |t| component_metadata(t.boot_ms(), t.files)),
];

/// What telemetry is made from.
pub(super) struct Telemetry<'a> {
    pub now: TimeUs,
    pub vehicle: &'a Vehicle,
    pub missions: &'a Missions,
    pub files: &'a FileServer,
}

impl Telemetry<'_> {
    /// The message with this number; `None` when there is no such one or it needs a state that is not there
    /// yet.
    pub(super) fn message(&self, message_id: u32) -> Option<MavMessage> {
        let (.., build) = TABLE.iter().find(|row| row.0 == message_id)?;
        build(self)
    }

    fn boot_ms(&self) -> u32 {
        // Wraps after 49 days, as the wire's number does.
        (self.now / 1000) as u32
    }

    fn state(&self) -> Option<VehicleState> {
        self.vehicle.latest_state()
    }

    fn system_time(&self) -> MavMessage {
        let time_unix_usec = self.vehicle.facts.epoch_unix_us.saturating_add(self.now);
        MavMessage::SYSTEM_TIME(SYSTEM_TIME_DATA { time_unix_usec, time_boot_ms: self.boot_ms() })
    }

    /// The request by which a peer may set its clock.
    fn timesync(&self) -> MavMessage {
        let ts1 = i64::try_from(self.now).unwrap_or(i64::MAX).saturating_mul(1000);
        MavMessage::TIMESYNC(TIMESYNC_DATA { tc1: 0, ts1, target_system: 0, target_component: 0 })
    }

    /// The request by which a peer may be known to answer; numbered by seconds.
    fn ping(&self) -> MavMessage {
        #[expect(deprecated, reason = "PX4 sends it")]
        let m = PING_DATA {
            time_usec: self.now,
            seq: (self.now / US_PER_SECOND) as u32,
            target_system: 0,
            target_component: 0,
        };
        #[expect(deprecated, reason = "PX4 sends it")]
        MavMessage::PING(m)
    }

    /// As PX4 uses the message, which is not as it is specified: y of the gyroscope, z of the accelerometer;
    /// no coning, no clipping.
    fn vibration(&self) -> Option<MavMessage> {
        let hil = &self.vehicle.hil;
        hil.sensor.as_ref()?;
        Some(MavMessage::VIBRATION(VIBRATION_DATA {
            time_usec: self.now,
            vibration_y: hil.vibration.gyroscope,
            vibration_z: hil.vibration.accelerometer,
            ..VIBRATION_DATA::DEFAULT
        }))
    }

    /// The barometer's pressure, without a pitot tube's.
    fn scaled_pressure(&self) -> Option<MavMessage> {
        let sensor = self.vehicle.hil.sensor.as_ref()?;
        Some(MavMessage::SCALED_PRESSURE(SCALED_PRESSURE_DATA {
            time_boot_ms: self.boot_ms(),
            press_abs: sensor.abs_pressure,
            temperature: (100.0 * sensor.temperature).round() as i16,
            ..SCALED_PRESSURE_DATA::DEFAULT
        }))
    }

    fn battery_status(&self) -> MavMessage {
        let battery = self.vehicle.hil.battery.as_ref();
        // Ground stations wait for it, also where a mission has none.
        MavMessage::BATTERY_STATUS(battery.map_or(UNKNOWN_BATTERY, Clone::clone))
    }

    /// HEARTBEAT of a quadrotor, hexarotor or octorotor by the number of rotors.
    fn heartbeat(&self) -> MavMessage {
        let Vehicle { autopilot, facts, .. } = self.vehicle;
        let armed = autopilot.is_armed();
        let mut base_mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
        if armed {
            base_mode |= MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
        }
        let system_status = match (armed, autopilot.in_failsafe(), self.state().is_some()) {
            _ if autopilot.guard.is_terminated() => MavState::MAV_STATE_FLIGHT_TERMINATION,
            (true, true, _) => MavState::MAV_STATE_CRITICAL,
            (true, false, _) => MavState::MAV_STATE_ACTIVE,
            (false, _, true) => MavState::MAV_STATE_STANDBY,
            (false, _, false) => MavState::MAV_STATE_BOOT,
        };
        MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: autopilot.mode().custom_mode(),
            mavtype: match facts.rotors {
                4 => MavType::MAV_TYPE_QUADROTOR,
                6 => MavType::MAV_TYPE_HEXAROTOR,
                8 => MavType::MAV_TYPE_OCTOROTOR,
                _ => MavType::MAV_TYPE_GENERIC_MULTIROTOR,
            },
            autopilot: MavAutopilot::MAV_AUTOPILOT_PX4,
            base_mode,
            system_status,
            mavlink_version: 3,
        })
    }

    fn sys_status(&self) -> MavMessage {
        let sensors = MavSysStatusSensor::from_bits_retain(SENSORS);
        let (fence, autopilot) = (MavSysStatusSensor::MAV_SYS_STATUS_GEOFENCE, &self.vehicle.autopilot);
        let mut present = sensors;
        present.set(fence, autopilot.guard.has_fence(&autopilot.settings));
        let mut health = MavSysStatusSensor::from_bits_retain(SENSORS & !ailing(self.now, self.vehicle));
        // Ground stations take a fence that is not healthy for one that is breached, even where there is
        // none.
        health.set(fence, !autopilot.guard.fence_is_breached());
        let battery = self.vehicle.hil.battery.as_ref().unwrap_or(&UNKNOWN_BATTERY);
        // "Not known" in each field's own way where no volts and amperes are modelled; the voltage of several
        // cells, or more than the field has, too.
        let voltage_battery = if battery.voltages[1] == u16::MAX { battery.voltages[0] } else { u16::MAX };
        MavMessage::SYS_STATUS(SYS_STATUS_DATA {
            onboard_control_sensors_present: present,
            onboard_control_sensors_enabled: present,
            onboard_control_sensors_health: health,
            voltage_battery,
            current_battery: battery.current_battery,
            battery_remaining: battery.battery_remaining,
            onboard_control_sensors_present_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_enabled_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_health_extended: MavSysStatusSensorExtended::empty(),
            ..SYS_STATUS_DATA::DEFAULT
        })
    }

    fn extended_sys_state(&self) -> Option<MavMessage> {
        let autopilot = &self.vehicle.autopilot;
        let landed_state = if self.vehicle.is_standing(&self.state()?) {
            MavLandedState::MAV_LANDED_STATE_ON_GROUND
        } else if autopilot.is_taking_off() && autopilot.is_flying() {
            MavLandedState::MAV_LANDED_STATE_TAKEOFF
        } else if autopilot.is_landing() {
            MavLandedState::MAV_LANDED_STATE_LANDING
        } else {
            MavLandedState::MAV_LANDED_STATE_IN_AIR
        };
        Some(MavMessage::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
            vtol_state: MavVtolState::MAV_VTOL_STATE_UNDEFINED,
            landed_state,
        }))
    }

    /// The simulator's fix, once a HIL_GPS has come.
    fn gps_raw_int(&self) -> Option<MavMessage> {
        let gps = self.vehicle.hil.gps.as_ref()?;
        Some(MavMessage::GPS_RAW_INT(GPS_RAW_INT_DATA {
            time_usec: gps.time_usec,
            lat: gps.lat,
            lon: gps.lon,
            alt: gps.alt,
            eph: gps.eph,
            epv: gps.epv,
            vel: gps.vel,
            cog: gps.cog,
            fix_type: GpsFixType::from_u8(gps.fix_type.min(FIX_3D)).unwrap_or_default(),
            satellites_visible: gps.satellites_visible,
            alt_ellipsoid: gps.alt,
            ..GPS_RAW_INT_DATA::DEFAULT
        }))
    }

    fn highres_imu(&self) -> Option<MavMessage> {
        let s = self.vehicle.hil.sensor.as_ref()?;
        let mut m = HIGHRES_IMU_DATA {
            time_usec: s.time_usec,
            abs_pressure: s.abs_pressure,
            diff_pressure: s.diff_pressure,
            pressure_alt: s.pressure_alt,
            temperature: s.temperature,
            // The bits mean the same in both messages, up to the temperature's.
            fields_updated: HighresImuUpdatedFlags::from_bits_retain(
                (s.fields_updated.bits() & 0x1FFF) as u16,
            ),
            id: s.id,
            ..HIGHRES_IMU_DATA::DEFAULT
        };
        [m.xacc, m.yacc, m.zacc] = [s.xacc, s.yacc, s.zacc];
        [m.xgyro, m.ygyro, m.zgyro] = [s.xgyro, s.ygyro, s.zgyro];
        [m.xmag, m.ymag, m.zmag] = [s.xmag, s.ymag, s.zmag];
        Some(MavMessage::HIGHRES_IMU(m))
    }

    /// Motor commands as pulse widths: 1000 us stopped, 2000 us full; 900 us disarmed.
    fn servo_output_raw(&self) -> MavMessage {
        let Vehicle { autopilot, facts, .. } = self.vehicle;
        let pulse_us = |i: usize| match (i < facts.rotors, autopilot.is_armed()) {
            (false, _) => 0,
            (true, false) => 900,
            (true, true) => 1000 + (1000.0 * autopilot.output().throttle[i]).round() as u16,
        };
        let mut m = SERVO_OUTPUT_RAW_DATA { time_usec: self.now as u32, ..SERVO_OUTPUT_RAW_DATA::DEFAULT };
        [m.servo1_raw, m.servo2_raw, m.servo3_raw, m.servo4_raw] = [0, 1, 2, 3].map(pulse_us);
        [m.servo5_raw, m.servo6_raw, m.servo7_raw, m.servo8_raw] = [4, 5, 6, 7].map(pulse_us);
        MavMessage::SERVO_OUTPUT_RAW(m)
    }

    fn attitude_target(&self) -> Option<MavMessage> {
        let autopilot = Some(&self.vehicle.autopilot).filter(|autopilot| autopilot.is_armed())?;
        let out = autopilot.output();
        let lift_max_n = autopilot.control_settings().airframe.lift_max_n;
        let mut m = ATTITUDE_TARGET_DATA {
            time_boot_ms: self.boot_ms(),
            q: out.q_sp.map(|c| c as f32),
            thrust: (out.collective_n / lift_max_n) as f32,
            type_mask: AttitudeTargetTypemask::empty(),
            ..ATTITUDE_TARGET_DATA::DEFAULT
        };
        [m.body_roll_rate, m.body_pitch_rate, m.body_yaw_rate] = single(out.rate_sp_body);
        Some(MavMessage::ATTITUDE_TARGET(m))
    }

    fn position_target(&self) -> Option<MavMessage> {
        let target = self.vehicle.autopilot.velocity_target()?;
        // Bits 0 to 2: an axis without a position.
        let no_position = (0..3).filter(|&i| target.p_ned[i].is_none()).fold(0, |mask, i| mask | 1 << i);
        let no_yaw_rate = PositionTargetTypemask::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE;
        let mut m = POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: self.boot_ms(),
            yaw: target.yaw_rad as f32,
            type_mask: PositionTargetTypemask::from_bits_retain(no_position) | no_yaw_rate,
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            ..POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        };
        [m.x, m.y, m.z] = target.p_ned.map(|p| p.map_or(0.0, |p| p as f32));
        [m.vx, m.vy, m.vz] = single(target.v_ned);
        [m.afx, m.afy, m.afz] = single(target.a_ff_ned);
        Some(MavMessage::POSITION_TARGET_LOCAL_NED(m))
    }

    /// The place that an automatic mode flies to, if it has one: as PX4, not that of OFFBOARD.
    fn global_position_target(&self) -> Option<MavMessage> {
        let autopilot = &self.vehicle.autopilot;
        let target = autopilot.velocity_target().filter(|_| autopilot.mode() != FlightMode::Offboard)?;
        let [Some(north), Some(east), Some(down)] = target.p_ned else { return None };
        let point = self.vehicle.environment.geo_point(&Vector3::new(north, east, down));
        let [lat_int, lon_int, _] = degrees_e7_and_mm(&point);
        #[expect(deprecated, reason = "PX4 sends it")]
        let coordinate_frame = MavFrame::MAV_FRAME_GLOBAL_INT;
        let mut m = POSITION_TARGET_GLOBAL_INT_DATA {
            time_boot_ms: self.boot_ms(),
            lat_int,
            lon_int,
            alt: point.altitude_m as f32,
            yaw: target.yaw_rad as f32,
            coordinate_frame,
            ..POSITION_TARGET_GLOBAL_INT_DATA::DEFAULT
        };
        [m.vx, m.vy, m.vz] = single(target.v_ned);
        [m.afx, m.afy, m.afz] = single(target.a_ff_ned);
        Some(MavMessage::POSITION_TARGET_GLOBAL_INT(m))
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that reads the documentation")]
mod tests {
    use mavlink::Message as _;

    use super::*;

    /// The page has the rates that are here: what it lacks is printed.
    #[test]
    fn the_documentation_has_these_rates() {
        let mut table = "| message | 14550 | 14540 |\n|---|---|---|\n".to_owned();
        for (id, ground_hz, api_hz, _) in TABLE {
            let name = MavMessage::default_message_from_id(id).unwrap().message_name().to_owned();
            let hz = |hz: f64| if hz > 0.0 { hz.to_string() } else { "on request".to_owned() };
            table += &format!("| {name} | {} | {} |\n", hz(ground_hz), hz(api_hz));
        }
        let page = std::fs::read_to_string("../../docs/px4_differences.md").unwrap();
        assert!(page.contains(&table), "docs/px4_differences.md is to have\n{table}");
    }

    /// Closed form: readings that change by the same again and again have that for their vibration at last;
    /// after one of them it is a hundredth.
    #[test]
    fn closed_form_vibration_is_the_filtered_change() {
        let mut hil = crate::link::autopilot::hil::HilInput::default();
        let anchor =
            crate::model::environment::GeoPoint { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 0.0 };
        let environment = crate::model::Environment::new(9.8, 1.2, Vector3::zeros(), anchor).unwrap();
        let mut take = |i: u8| {
            let sign = if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            let m = HIL_SENSOR_DATA { xacc: 1.5 * sign, ygyro: 0.25 * sign, ..Default::default() };
            hil.take(&MavMessage::HIL_SENSOR(m), &environment);
            hil.vibration
        };
        take(0);
        let once = take(1);
        assert!((once.accelerometer - 0.03).abs() < 1e-7 && (once.gyroscope - 0.005).abs() < 1e-8);
        let settled = (0..10).flat_map(|_| 0..200).map(take).last().unwrap();
        assert!((settled.accelerometer - 3.0).abs() < 1e-4 && (settled.gyroscope - 0.5).abs() < 1e-4);
    }
}
