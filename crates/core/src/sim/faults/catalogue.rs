//! Every fault that there is: name, what it does, keys of the mission, and the unit and type of
//! MAV_CMD_INJECT_FAILURE (420) that injects it.
//!
//! A command has no room for a fault's numbers: one that is injected has those of [`Entry::injected`], which
//! are a choice, not anybody's data.

use nalgebra::Vector3;

use super::{FaultKind, FaultUnit, MotorFault, Sensor, SensorFault};
use FailureType::{Garbage, Off, Slow, Stuck, Wrong};
use FailureUnit::{Accelerometer, Barometer, Gps, Gyro, Magnetometer, MavlinkSignal, Motor};

/// A fault as it is listed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Name in missions.
    pub name: &'static str,
    /// Effect, in a sentence without its full stop.
    pub does: &'static str,
    /// Keys of the mission, beside the times.
    pub keys: &'static [&'static str],
    /// Unit and type of the command that injects it; `None`: no command does.
    pub command: Option<(FailureUnit, FailureType)>,
}

/// `FAILURE_UNIT` of MAVLink's common dialect, those that are handled
/// (<https://mavlink.io/en/messages/common.html#FAILURE_UNIT>).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum FailureUnit {
    /// FAILURE_UNIT_SENSOR_GYRO.
    Gyro = 0,
    /// FAILURE_UNIT_SENSOR_ACCEL.
    Accelerometer = 1,
    /// FAILURE_UNIT_SENSOR_MAG.
    Magnetometer = 2,
    /// FAILURE_UNIT_SENSOR_BARO.
    Barometer = 3,
    /// FAILURE_UNIT_SENSOR_GPS.
    Gps = 4,
    /// FAILURE_UNIT_SYSTEM_MOTOR.
    Motor = 101,
    /// FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL.
    MavlinkSignal = 105,
}

impl FailureUnit {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Gyro,
        Self::Accelerometer,
        Self::Magnetometer,
        Self::Barometer,
        Self::Gps,
        Self::Motor,
        Self::MavlinkSignal,
    ];

    /// The unit whose fault ends with an "ok"; `rotor` counts for a motor alone.
    pub fn of(self, rotor: usize) -> FaultUnit {
        match self {
            Self::Gyro => FaultUnit::Sensor(Sensor::Gyro),
            Self::Accelerometer => FaultUnit::Sensor(Sensor::Accelerometer),
            Self::Magnetometer => FaultUnit::Sensor(Sensor::Magnetometer),
            Self::Barometer => FaultUnit::Sensor(Sensor::Barometer),
            Self::Gps => FaultUnit::Sensor(Sensor::Gps),
            Self::Motor => FaultUnit::Motor(rotor),
            Self::MavlinkSignal => FaultUnit::Setpoints,
        }
    }
}

/// `FAILURE_TYPE` of MAVLink's common dialect, those that are handled
/// (<https://mavlink.io/en/messages/common.html#FAILURE_TYPE>); 0, "ok", ends a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum FailureType {
    /// FAILURE_TYPE_OFF.
    Off = 1,
    /// FAILURE_TYPE_STUCK.
    Stuck = 2,
    /// FAILURE_TYPE_GARBAGE.
    Garbage = 3,
    /// FAILURE_TYPE_WRONG.
    Wrong = 4,
    /// FAILURE_TYPE_SLOW.
    Slow = 5,
}

impl FailureType {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Off, Self::Stuck, Self::Garbage, Self::Wrong, Self::Slow];

    /// The name as MAVSDK and PX4's console have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Stuck => "stuck",
            Self::Garbage => "garbage",
            Self::Wrong => "wrong",
            Self::Slow => "slow",
        }
    }
}

impl FailureUnit {
    /// The name as PX4's console has it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Accelerometer => "accel",
            Self::Magnetometer => "mag",
            Self::Barometer => "baro",
            Self::Gps => "gps",
            Self::Motor => "motor",
            Self::MavlinkSignal => "mavlink_signal",
        }
    }
}

/// Lag of an injected `motor_slow` [s].
pub const INJECTED_LAG_S: f64 = 0.2;
/// Factor of an injected `motor_weak`.
pub const INJECTED_FACTOR: f64 = 0.8;

impl Entry {
    /// The fault that the entry's command injects: of a motor, that of `rotor`, from 1. `None`: no command
    /// does.
    pub fn injected(&self, rotor: usize) -> Option<FaultKind> {
        let (unit, kind) = self.command?;
        let motor = |fault| Some(FaultKind::Motor { rotor, fault });
        let sensor = match unit.of(rotor) {
            FaultUnit::Motor(_) => {
                return motor(match kind {
                    Off => MotorFault::Off,
                    Stuck => MotorFault::Stuck,
                    Slow => MotorFault::Slow { lag_s: INJECTED_LAG_S },
                    Wrong => MotorFault::Weak { factor: INJECTED_FACTOR },
                    Garbage => return None,
                });
            }
            FaultUnit::Setpoints => return Some(FaultKind::SetpointLoss),
            FaultUnit::Parachute | FaultUnit::ParachuteHeartbeat | FaultUnit::Riser => return None,
            FaultUnit::Sensor(sensor) => sensor,
        };
        let fault = match kind {
            Off => SensorFault::Off,
            Stuck => SensorFault::Stuck,
            Garbage => SensorFault::Garbage,
            Wrong => SensorFault::Wrong { offset: injected_offset(sensor), scale: 1.0 },
            Slow => return None,
        };
        Some(FaultKind::Sensor { sensor, fault })
    }
}

/// Offset of a sensor that is injected to be wrong, in the sensor's unit.
pub fn injected_offset(sensor: Sensor) -> Vector3<f64> {
    match sensor {
        Sensor::Gyro => Vector3::new(0.1, 0.1, 0.1),
        Sensor::Accelerometer => Vector3::new(1.0, 1.0, 1.0),
        Sensor::Magnetometer => Vector3::new(0.2, 0.2, 0.2),
        Sensor::Barometer => Vector3::new(10.0, 0.0, 0.0),
        Sensor::Gps => Vector3::new(100.0, 0.0, 0.0),
    }
}

const fn entry(
    name: &'static str,
    keys: &'static [&'static str],
    command: Option<(FailureUnit, FailureType)>,
    does: &'static str,
) -> Entry {
    Entry { name, does, keys, command }
}

/// Every fault, in the order in which they are listed.
pub const CATALOGUE: &[Entry] = &[
    entry(
        "motor_off",
        &["rotor"],
        Some((Motor, Off)),
        "no current flows in the motor: the air brakes the rotor",
    ),
    entry("motor_stuck", &["rotor"], Some((Motor, Stuck)), "the rotor keeps the speed that it has"),
    entry(
        "motor_slow",
        &["rotor", "lag_s"],
        Some((Motor, Slow)),
        "the command comes to the motor by a first-order lag",
    ),
    entry(
        "motor_weak",
        &["rotor", "factor"],
        Some((Motor, Wrong)),
        "the motor goes for this part of the speed commanded",
    ),
    entry("esc_no_start", &["rotor"], None, "a motor at rest is not started; one that turns goes on"),
    entry("gyro_off", &[], Some((Gyro, Off)), "no body rates are read"),
    entry("gyro_stuck", &[], Some((Gyro, Stuck)), "the last body rates are repeated"),
    entry("gyro_drift", &["rate_rad_s2"], None, "an error of the body rates grows from zero"),
    entry(
        "gyro_wrong",
        &["offset_rad_s", "scale"],
        Some((Gyro, Wrong)),
        "the body rates are scaled and offset",
    ),
    entry("gyro_garbage", &[], Some((Gyro, Garbage)), "body rates are random within +-2000 deg/s"),
    entry("accelerometer_off", &[], Some((Accelerometer, Off)), "no specific force is read"),
    entry("accelerometer_stuck", &[], Some((Accelerometer, Stuck)), "the last specific force is repeated"),
    entry("accelerometer_drift", &["rate_m_s3"], None, "an error of the specific force grows from zero"),
    entry(
        "accelerometer_wrong",
        &["offset_m_s2", "scale"],
        Some((Accelerometer, Wrong)),
        "the specific force is scaled and offset",
    ),
    entry(
        "accelerometer_garbage",
        &[],
        Some((Accelerometer, Garbage)),
        "the specific force is random within +-16 g",
    ),
    entry("magnetometer_off", &[], Some((Magnetometer, Off)), "no magnetic field is read"),
    entry("magnetometer_stuck", &[], Some((Magnetometer, Stuck)), "the last field is repeated"),
    entry("magnetometer_drift", &["rate_gauss_s"], None, "an error of the field grows from zero"),
    entry(
        "magnetometer_wrong",
        &["offset_gauss", "scale"],
        Some((Magnetometer, Wrong)),
        "the field is scaled and offset",
    ),
    entry("magnetometer_garbage", &[], Some((Magnetometer, Garbage)), "the field is random within +-8 gauss"),
    entry("barometer_off", &[], Some((Barometer, Off)), "no pressure is read"),
    entry("barometer_stuck", &[], Some((Barometer, Stuck)), "the last pressure is repeated"),
    entry("barometer_drift", &["rate_hpa_s"], None, "an error of the pressure grows from zero"),
    entry(
        "barometer_wrong",
        &["offset_hpa", "scale"],
        Some((Barometer, Wrong)),
        "the pressure is scaled and offset",
    ),
    entry("barometer_garbage", &[], Some((Barometer, Garbage)), "the pressure is random from 10 to 1200 hPa"),
    entry("gps_loss", &[], None, "the receiver reports that it has no fix"),
    entry("gps_off", &[], Some((Gps, Off)), "nothing comes from the receiver"),
    entry("gps_stuck", &[], Some((Gps, Stuck)), "the last position and velocity are repeated"),
    entry(
        "gps_drift",
        &["rate_ned_m_s"],
        None,
        "an error of the position grows from zero; the velocity is right",
    ),
    entry(
        "gps_wrong",
        &["offset_ned_m"],
        Some((Gps, Wrong)),
        "the position is offset; the velocity is right",
    ),
    entry(
        "gps_garbage",
        &[],
        Some((Gps, Garbage)),
        "position and velocity are random within +-10 km and +-100 m/s",
    ),
    entry("setpoint_loss", &[], Some((MavlinkSignal, Off)), "the streamer sends nothing"),
    entry("parachute_silent", &[], None, "the parachute's component sends no HEARTBEAT"),
    entry(
        "parachute_holds",
        &[],
        None,
        "the parachute does not let go; what was asked meanwhile it does at the fault's end",
    ),
    entry("late_release", &["delay_s"], None, "the parachute lets go that much later than it is asked to"),
    entry(
        "riser_hung_up",
        &["attachment_body_m"],
        None,
        "one leg of the bridle stays fixed at the release: the canopy pulls by it until the fault's end",
    ),
];
