//! Faults by name: what fails in a flight, and when.
//!
//! | file | holds |
//! |---|---|
//! | here | what a fault is, in data and in words |
//! | [`course`] | the faults of a flight in time: which are in force, what they make of motors and release |
//! | [`catalogue`] | every fault with its name, its keys, what it does and the command that injects it |
//!
//! What a fault makes of a sensor's readings is in [`crate::sim::sensors::faulty`].

use std::fmt;

use nalgebra::Vector3;

pub mod catalogue;
pub mod course;

#[cfg(test)]
mod tests;

pub use catalogue::{CATALOGUE, Entry};
pub use course::{FaultCourse, FaultSpan};

/// What fails, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// A motor with its speed controller.
    Motor {
        /// Number of the rotor, from 1.
        rotor: usize,
        /// How it fails.
        fault: MotorFault,
    },
    /// A sensor.
    Sensor {
        /// The sensor.
        sensor: Sensor,
        /// How it fails.
        fault: SensorFault,
    },
    /// Nothing is heard of the companion that streams setpoints.
    SetpointLoss,
    /// The parachute's component sends no HEARTBEAT, as one that has left with its canopy.
    ParachuteSilent,
    /// The parachute does not let go, whatever asks it to.
    ParachuteHolds,
    /// The parachute lets go later than it is asked to.
    LateRelease {
        /// By how much [s].
        delay_s: f64,
    },
    /// One leg of the bridle does not come free at the release: the canopy goes on pulling by it.
    RiserHungUp {
        /// Where the leg is fixed, from the vehicle's centre of mass, body axes [m].
        attachment_body_m: Vector3<f64>,
    },
}

/// How a motor with its speed controller fails.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotorFault {
    /// No current flows: the air brakes the rotor, or drives it.
    Off,
    /// The rotor keeps the speed that it has.
    Stuck,
    /// The motor follows its command late.
    Slow {
        /// Time constant of a first-order lag of the command [s].
        lag_s: f64,
    },
    /// The motor turns slower than it is commanded to.
    Weak {
        /// Speed that it goes for over the speed commanded, 0..1.
        factor: f64,
    },
    /// The speed controller does not start a motor that is at rest; one that turns goes on.
    NoStart,
}

/// A sensor that can fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensor {
    /// Gyroscope [rad/s].
    Gyro,
    /// Accelerometer [m/s^2].
    Accelerometer,
    /// Magnetometer [gauss].
    Magnetometer,
    /// Barometer [hPa].
    Barometer,
    /// Satellite receiver: position, NED [m].
    Gps,
}

impl Sensor {
    /// All sensors in the order of their declaration.
    pub const ALL: [Self; 5] =
        [Self::Gyro, Self::Accelerometer, Self::Magnetometer, Self::Barometer, Self::Gps];

    /// Name in words, which is also the beginning of its faults' names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gyro => "gyro",
            Self::Accelerometer => "accelerometer",
            Self::Magnetometer => "magnetometer",
            Self::Barometer => "barometer",
            Self::Gps => "gps",
        }
    }
}

/// How a sensor fails. Vectors are in the sensor's unit; of a barometer the first component counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SensorFault {
    /// Nothing is read.
    Off,
    /// The last reading is repeated.
    Stuck,
    /// An error grows from zero.
    Drift {
        /// Rate of the error [unit/s].
        rate: Vector3<f64>,
    },
    /// An error is there at once.
    Wrong {
        /// What is added.
        offset: Vector3<f64>,
        /// What the truth with its usual errors is multiplied by.
        scale: f64,
    },
    /// Random numbers all over the range of the sensor.
    Garbage,
    /// A satellite receiver that runs and has no fix.
    NoFix,
}

/// What has one fault at a time: a fault that begins ends the one that is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultUnit {
    /// The motor of this rotor, from 1.
    Motor(usize),
    /// A sensor.
    Sensor(Sensor),
    /// The link of the companion that streams setpoints.
    Setpoints,
    /// The parachute.
    Parachute,
    /// The HEARTBEAT of the parachute's component.
    ParachuteHeartbeat,
    /// The riser, below the parachute.
    Riser,
}

impl FaultKind {
    /// The unit that fails.
    pub fn unit(&self) -> FaultUnit {
        match *self {
            Self::Motor { rotor, .. } => FaultUnit::Motor(rotor),
            Self::Sensor { sensor, .. } => FaultUnit::Sensor(sensor),
            Self::SetpointLoss => FaultUnit::Setpoints,
            Self::ParachuteSilent => FaultUnit::ParachuteHeartbeat,
            Self::ParachuteHolds | Self::LateRelease { .. } => FaultUnit::Parachute,
            Self::RiserHungUp { .. } => FaultUnit::Riser,
        }
    }

    /// Name in missions, the results and the [catalogue](CATALOGUE).
    pub fn name(&self) -> &'static str {
        const SENSORS: [[&str; 5]; 5] = [
            ["gyro_off", "gyro_stuck", "gyro_drift", "gyro_wrong", "gyro_garbage"],
            [
                "accelerometer_off",
                "accelerometer_stuck",
                "accelerometer_drift",
                "accelerometer_wrong",
                "accelerometer_garbage",
            ],
            [
                "magnetometer_off",
                "magnetometer_stuck",
                "magnetometer_drift",
                "magnetometer_wrong",
                "magnetometer_garbage",
            ],
            ["barometer_off", "barometer_stuck", "barometer_drift", "barometer_wrong", "barometer_garbage"],
            ["gps_off", "gps_stuck", "gps_drift", "gps_wrong", "gps_garbage"],
        ];
        match *self {
            Self::Motor { fault, .. } => match fault {
                MotorFault::Off => "motor_off",
                MotorFault::Stuck => "motor_stuck",
                MotorFault::Slow { .. } => "motor_slow",
                MotorFault::Weak { .. } => "motor_weak",
                MotorFault::NoStart => "esc_no_start",
            },
            Self::Sensor { fault: SensorFault::NoFix, .. } => "gps_loss",
            Self::Sensor { sensor, fault } => {
                let how = match fault {
                    SensorFault::Off | SensorFault::NoFix => 0,
                    SensorFault::Stuck => 1,
                    SensorFault::Drift { .. } => 2,
                    SensorFault::Wrong { .. } => 3,
                    SensorFault::Garbage => 4,
                };
                SENSORS[sensor as usize][how]
            }
            Self::SetpointLoss => "setpoint_loss",
            Self::ParachuteSilent => "parachute_silent",
            Self::ParachuteHolds => "parachute_holds",
            Self::LateRelease { .. } => "late_release",
            Self::RiserHungUp { .. } => "riser_hung_up",
        }
    }
}

/// In words: `rotor 2 off`, `gyro stuck`, `release 2 s late`.
impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motor { rotor, fault } => match fault {
                MotorFault::Off => write!(f, "rotor {rotor} off"),
                MotorFault::Stuck => write!(f, "rotor {rotor} stuck at its speed"),
                MotorFault::Slow { lag_s } => write!(f, "rotor {rotor} slow by {lag_s} s"),
                MotorFault::Weak { factor } => write!(f, "rotor {rotor} at {factor} of its command"),
                MotorFault::NoStart => write!(f, "rotor {rotor} not started by its ESC"),
            },
            Self::Sensor { sensor, fault } => {
                let how = match fault {
                    SensorFault::Off => "off",
                    SensorFault::Stuck => "stuck",
                    SensorFault::Drift { .. } => "drifting",
                    SensorFault::Wrong { .. } => "wrong",
                    SensorFault::Garbage => "reads garbage",
                    SensorFault::NoFix => "without a fix",
                };
                write!(f, "{} {how}", sensor.name())
            }
            Self::SetpointLoss => f.write_str("setpoints lost"),
            Self::ParachuteSilent => f.write_str("parachute silent"),
            Self::ParachuteHolds => f.write_str("parachute does not let go"),
            Self::LateRelease { delay_s } => write!(f, "release {delay_s} s late"),
            Self::RiserHungUp { attachment_body_m: at } => {
                write!(f, "riser hung up at [{} {} {}] m", at.x, at.y, at.z)
            }
        }
    }
}

/// A fault of a flight that is known beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// What fails.
    pub kind: FaultKind,
    /// Beginning, from the nominal t = 0 at which the rotors are freed [s]; negative: before.
    pub at_s: f64,
    /// End, likewise [s]; `None`: it stays.
    pub until_s: Option<f64>,
}

/// A fault that is ordered in flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultOrder {
    /// It begins now.
    Begin(FaultKind),
    /// The fault of this unit, if it has one, ends now.
    End(FaultUnit),
}
