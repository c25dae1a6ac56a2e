//! The telemetry messages about the vehicle's condition (`motion` has those about its movement), each built from what is known
//! when it is due. A message that needs a state is not sent before there is one. `time_boot_ms` is simulated time.

use mavlink::dialects::common::*;

use super::super::TimeUs;
use super::files::FileServer;
use super::hil::{HilInput, VehicleState};
use super::home::Home;
use super::identity;
use super::missions::Missions;
use super::streams::id;
use crate::autopilot::estimator::Estimator;
use crate::autopilot::{Autopilot, FlightMode};
use crate::model::Environment;

/// gyroscope, accelerometer, magnetometer, barometer, satellites, ready to arm: what MAVSDK's health looks at.
pub(super) const SENSORS: u32 = 0x1000_002F;
/// Slower than this, disarmed, the vehicle counts as standing on something [m/s]; PX4's landing detector says the same.
const STANDING_SPEED_M_S: f64 = 0.3;

/// What telemetry is made from.
pub(super) struct Telemetry<'a> {
    pub now: TimeUs,
    pub autopilot: &'a Autopilot,
    pub environment: &'a Environment,
    pub hil: &'a HilInput,
    /// What is known of the vehicle, however old; whether it is young enough to fly by; and whose it is, if not the truth.
    pub state: Option<VehicleState>,
    pub ready: bool,
    pub estimator: Option<&'a Estimator>,
    pub home: &'a Home,
    pub rotors: usize,
    pub epoch_unix_us: u64,
    pub missions: &'a Missions,
    pub files: &'a FileServer,
    pub battery: Option<&'a BATTERY_STATUS_DATA>,
}

impl Telemetry<'_> {
    /// The message with this number; `None` when it is none of ours or needs a state that is not there yet.
    pub(super) fn message(&self, message_id: u32) -> Option<MavMessage> {
        Some(match message_id {
            id::HEARTBEAT => self.heartbeat(),
            id::SYS_STATUS => self.sys_status(),
            id::SYSTEM_TIME => MavMessage::SYSTEM_TIME(SYSTEM_TIME_DATA {
                time_unix_usec: self.epoch_unix_us.saturating_add(self.now),
                time_boot_ms: self.boot_ms(),
            }),
            id::TIMESYNC => MavMessage::TIMESYNC(TIMESYNC_DATA {
                tc1: 0,
                ts1: self.now_ns(),
                target_system: 0,
                target_component: 0,
            }),
            id::AUTOPILOT_VERSION => identity::autopilot_version(),
            id::HOME_POSITION => self.home.message(self.environment)?,
            id::BATTERY_STATUS => {
                MavMessage::BATTERY_STATUS(self.battery.map_or_else(unknown_battery, Clone::clone))
            }
            id::EXTENDED_SYS_STATE => self.extended_sys_state()?,
            id::GPS_RAW_INT => self.gps_raw_int()?,
            id::HIGHRES_IMU => self.highres_imu()?,
            id::SERVO_OUTPUT_RAW => self.servo_output_raw(),
            id::ATTITUDE_TARGET => self.attitude_target()?,
            id::POSITION_TARGET_LOCAL_NED => self.position_target()?,
            id::ESTIMATOR_STATUS => self.estimator_status()?,
            id::MISSION_CURRENT => self.mission_current(),
            id::COMPONENT_METADATA => self.component_metadata()?,
            id::CURRENT_MODE => identity::current_mode(self.autopilot.mode()),
            id::AVAILABLE_MODES_MONITOR => {
                MavMessage::AVAILABLE_MODES_MONITOR(AVAILABLE_MODES_MONITOR_DATA {
                    seq: identity::MODES_VERSION,
                })
            }
            _ => return self.motion(message_id),
        })
    }

    pub(super) fn boot_ms(&self) -> u32 {
        // Wraps after 49 days, as the wire's number does.
        (self.now / 1000) as u32
    }

    fn now_ns(&self) -> i64 {
        i64::try_from(self.now).unwrap_or(i64::MAX).saturating_mul(1000)
    }

    /// HEARTBEAT: quadrotor, hexarotor, octorotor by the number of rotors.
    fn heartbeat(&self) -> MavMessage {
        let armed = self.autopilot.is_armed();
        let mut base_mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
        if armed {
            base_mode |= MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
        }
        let system_status = match (armed, self.autopilot.in_failsafe(), self.state.is_some()) {
            (true, true, _) => MavState::MAV_STATE_CRITICAL,
            (true, false, _) => MavState::MAV_STATE_ACTIVE,
            (false, _, true) => MavState::MAV_STATE_STANDBY,
            (false, _, false) => MavState::MAV_STATE_BOOT,
        };
        MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: self.autopilot.mode().custom_mode(),
            mavtype: match self.rotors {
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
        let fence = MavSysStatusSensor::MAV_SYS_STATUS_GEOFENCE;
        let mut present = sensors;
        present.set(fence, self.autopilot.has_fence());
        let mut health = MavSysStatusSensor::from_bits_retain(SENSORS & !self.ailing());
        // Ground stations take a fence that is not healthy for one that is breached, even where there is none.
        health.set(fence, !self.autopilot.fence_is_breached());
        MavMessage::SYS_STATUS(SYS_STATUS_DATA {
            onboard_control_sensors_present: present,
            onboard_control_sensors_enabled: present,
            onboard_control_sensors_health: health,
            // No volts and amperes are modelled: "not known" in each field's own way.
            voltage_battery: u16::MAX,
            current_battery: -1,
            battery_remaining: self.battery.map_or(-1, |battery| battery.battery_remaining),
            onboard_control_sensors_present_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_enabled_extended: MavSysStatusSensorExtended::empty(),
            onboard_control_sensors_health_extended: MavSysStatusSensorExtended::empty(),
            ..SYS_STATUS_DATA::DEFAULT
        })
    }

    fn extended_sys_state(&self) -> Option<MavMessage> {
        let autopilot = self.autopilot;
        let landed_state = match autopilot.mode() {
            _ if is_standing(autopilot, &self.state?) => MavLandedState::MAV_LANDED_STATE_ON_GROUND,
            FlightMode::AutoTakeoff if autopilot.is_flying() => MavLandedState::MAV_LANDED_STATE_TAKEOFF,
            _ if autopilot.is_landing() => MavLandedState::MAV_LANDED_STATE_LANDING,
            _ => MavLandedState::MAV_LANDED_STATE_IN_AIR,
        };
        Some(MavMessage::EXTENDED_SYS_STATE(EXTENDED_SYS_STATE_DATA {
            vtol_state: MavVtolState::MAV_VTOL_STATE_UNDEFINED,
            landed_state,
        }))
    }

    /// The simulator's fix; without HIL_GPS there is none to tell.
    fn gps_raw_int(&self) -> Option<MavMessage> {
        let gps = self.hil.gps.as_ref()?;
        Some(MavMessage::GPS_RAW_INT(GPS_RAW_INT_DATA {
            time_usec: gps.time_usec,
            lat: gps.lat,
            lon: gps.lon,
            alt: gps.alt,
            eph: gps.eph,
            epv: gps.epv,
            vel: gps.vel,
            cog: gps.cog,
            fix_type: match gps.fix_type {
                0 => GpsFixType::GPS_FIX_TYPE_NO_GPS,
                1 => GpsFixType::GPS_FIX_TYPE_NO_FIX,
                2 => GpsFixType::GPS_FIX_TYPE_2D_FIX,
                _ => GpsFixType::GPS_FIX_TYPE_3D_FIX,
            },
            satellites_visible: gps.satellites_visible,
            alt_ellipsoid: gps.alt,
            ..GPS_RAW_INT_DATA::DEFAULT
        }))
    }

    fn highres_imu(&self) -> Option<MavMessage> {
        let s = self.hil.sensor.as_ref()?;
        Some(MavMessage::HIGHRES_IMU(HIGHRES_IMU_DATA {
            time_usec: s.time_usec,
            xacc: s.xacc,
            yacc: s.yacc,
            zacc: s.zacc,
            xgyro: s.xgyro,
            ygyro: s.ygyro,
            zgyro: s.zgyro,
            xmag: s.xmag,
            ymag: s.ymag,
            zmag: s.zmag,
            abs_pressure: s.abs_pressure,
            diff_pressure: s.diff_pressure,
            pressure_alt: s.pressure_alt,
            temperature: s.temperature,
            // The bits mean the same in both messages, up to the temperature's.
            fields_updated: HighresImuUpdatedFlags::from_bits_retain(
                (s.fields_updated.bits() & 0x1FFF) as u16,
            ),
            id: s.id,
        }))
    }

    /// Motor commands as pulse widths: 1000 us stopped, 2000 us full; 900 us disarmed.
    fn servo_output_raw(&self) -> MavMessage {
        let pulse_us = |i: usize| match (i < self.rotors, self.autopilot.is_armed()) {
            (false, _) => 0,
            (true, false) => 900,
            (true, true) => 1000 + (1000.0 * self.autopilot.output().throttle[i]).round() as u16,
        };
        MavMessage::SERVO_OUTPUT_RAW(SERVO_OUTPUT_RAW_DATA {
            time_usec: self.now as u32,
            servo1_raw: pulse_us(0),
            servo2_raw: pulse_us(1),
            servo3_raw: pulse_us(2),
            servo4_raw: pulse_us(3),
            servo5_raw: pulse_us(4),
            servo6_raw: pulse_us(5),
            servo7_raw: pulse_us(6),
            servo8_raw: pulse_us(7),
            ..SERVO_OUTPUT_RAW_DATA::DEFAULT
        })
    }

    fn attitude_target(&self) -> Option<MavMessage> {
        if !self.autopilot.is_armed() {
            return None;
        }
        let out = self.autopilot.output();
        let rates = out.rate_sp_body.map(|x| x as f32);
        let lift_max_n = self.autopilot.cascade().airframe().lift_max_n;
        Some(MavMessage::ATTITUDE_TARGET(ATTITUDE_TARGET_DATA {
            time_boot_ms: self.boot_ms(),
            q: out.q_sp.map(|c| c as f32),
            body_roll_rate: rates.x,
            body_pitch_rate: rates.y,
            body_yaw_rate: rates.z,
            thrust: (out.collective_n / lift_max_n) as f32,
            type_mask: AttitudeTargetTypemask::empty(),
        }))
    }

    fn position_target(&self) -> Option<MavMessage> {
        let target = self.autopilot.velocity_target()?;
        let (v, a) = (target.v_ned.map(|x| x as f32), target.a_ff_ned.map(|x| x as f32));
        // Bits 0 to 2: an axis without a position.
        let no_position = (0..3).filter(|&i| target.p_ned[i].is_none()).fold(0, |mask, i| mask | 1 << i);
        let [x, y, z] = target.p_ned.map(|p| p.map_or(0.0, |p| p as f32));
        Some(MavMessage::POSITION_TARGET_LOCAL_NED(POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: self.boot_ms(),
            x,
            y,
            z,
            vx: v.x,
            vy: v.y,
            vz: v.z,
            afx: a.x,
            afy: a.y,
            afz: a.z,
            yaw: target.yaw_rad as f32,
            type_mask: PositionTargetTypemask::from_bits_retain(0x0800 | no_position),
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            ..POSITION_TARGET_LOCAL_NED_DATA::DEFAULT
        }))
    }
}

/// Whether the vehicle stands: not told to be in the air, and no speed.
pub(super) fn is_standing(autopilot: &Autopilot, state: &VehicleState) -> bool {
    !autopilot.is_in_air() && state.measurement.v_ned.norm() <= STANDING_SPEED_M_S
}

/// Without a battery in the mission; the message says so, for ground stations that wait for it.
fn unknown_battery() -> BATTERY_STATUS_DATA {
    BATTERY_STATUS_DATA {
        current_consumed: -1,
        energy_consumed: -1,
        temperature: i16::MAX,
        voltages: [u16::MAX; 10],
        current_battery: -1,
        battery_remaining: -1,
        fault_bitmask: MavBatteryFault::empty(),
        ..BATTERY_STATUS_DATA::DEFAULT
    }
}

pub(super) fn deg_e7(degrees: f64) -> i32 {
    (degrees * 1e7).round() as i32
}

pub(super) fn millimetres(metres: f64) -> i32 {
    (metres * 1e3).round() as i32
}
