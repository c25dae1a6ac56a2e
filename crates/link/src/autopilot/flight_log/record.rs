//! What the autopilot knew and commanded at one control step: the material of the flight log's rows.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::autopilot::estimator::{Accuracy, TestRatios};
use crate::autopilot::{Event, FlightMode};
use crate::control::ControlOutput;
use crate::frames::Quaternion;
use crate::model::environment::GeoPoint;
use crate::params::Value;
use crate::time::TimeUs;

/// Position, attitude and motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position from the local origin, NED [m].
    pub p_ned: Vector3<f64>,
    /// Attitude, body to NED.
    pub q_ned_from_body: Quaternion,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Acceleration, NED [m/s^2]: what the accelerometer reads, turned by this attitude, and gravity.
    pub a_ned: Vector3<f64>,
    /// Body rates [rad/s].
    pub omega_body: Vector3<f64>,
    /// Angular acceleration, body [rad/s^2]: differences of the rates through a low pass.
    pub alpha_body: Vector3<f64>,
}

impl Default for Pose {
    fn default() -> Self {
        Self::UNKNOWN
    }
}

impl Pose {
    /// A pose that nobody has reported: no numbers.
    pub const UNKNOWN: Self = {
        let nothing = Vector3::new(f64::NAN, f64::NAN, f64::NAN);
        Self {
            p_ned: nothing,
            q_ned_from_body: [f64::NAN; 4],
            v_ned: nothing,
            a_ned: nothing,
            omega_body: nothing,
            alpha_body: nothing,
        }
    };
}

/// What the sensors said last.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sensors {
    /// Specific force, body [m/s^2].
    pub specific_force_body: Vector3<f64>,
    /// Body rates [rad/s].
    pub gyro_body: Vector3<f64>,
    /// Magnetic field, body [gauss].
    pub magnetic_field_body: Vector3<f64>,
    /// Static pressure [Pa].
    pub pressure_pa: f64,
    /// Altitude by the pressure [m].
    pub pressure_altitude_m: f64,
    /// Temperature [deg C].
    pub temperature_c: f64,
}

/// A satellite fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SatelliteFix {
    /// Where.
    pub point: GeoPoint,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Satellites used.
    pub satellites: u8,
    /// Accuracy of the position that the receiver reports, horizontal [m].
    pub horizontal_m: f64,
    /// And vertical [m].
    pub vertical_m: f64,
}

/// The battery, as the simulator reports it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BatteryState {
    /// Voltage of its bus [V]; `None` where no bus is modelled.
    pub bus_v: Option<f64>,
    /// Current drawn from it [A]; `None` where no bus is modelled.
    pub current_a: Option<f64>,
    /// Charge drawn from it [mAh]; `None` where no bus is modelled.
    pub drawn_mah: Option<f64>,
    /// Share of the charge that is left, 0..1.
    pub remaining: f64,
}

/// One control step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepRecord {
    /// Simulated time.
    pub at: TimeUs,
    /// Unix time of simulated time 0 [us].
    pub epoch_unix_us: u64,
    /// Where the local origin is.
    pub origin: GeoPoint,
    /// Gravity [m/s^2].
    pub gravity_m_s2: f64,
    /// Density of the air [kg/m^3].
    pub density_kg_m3: f64,
    /// The state that was flown by.
    pub estimate: Pose,
    /// The simulator's truth; [`Pose::UNKNOWN`] when it does not report it.
    pub truth: Pose,
    /// Quality of the estimate; `None` when the truth was flown by.
    pub accuracy: Option<Accuracy>,
    /// Innovations over their gates, squared; `None` when the truth was flown by.
    pub ratios: Option<TestRatios>,
    /// How much gyroscope [rad/s] and accelerometer [m/s^2] change from one reading to the next, filtered.
    pub vibration: [f64; 2],
    /// Inertial sensors, magnetometer, barometer.
    pub sensors: Sensors,
    /// Satellites; `None` before the first fix.
    pub fix: Option<SatelliteFix>,
    /// Battery; `None` where none is reported.
    pub battery: Option<BatteryState>,
    /// What the controller commanded, and the setpoints in between.
    pub output: ControlOutput,
    /// Collective over the greatest thrust of all rotors, 0..1.
    pub collective: f64,
    /// Roll, pitch and yaw moment of the rotors, over the greatest about each axis, -1..1.
    pub moments: Vector3<f64>,
    /// Velocity [m/s], acceleration fed forward [m/s^2], both NED, and heading [rad] being flown to.
    pub target: Option<(Vector3<f64>, Vector3<f64>, f64)>,
    /// Number of rotors.
    pub rotors: usize,
    /// Mode.
    pub mode: FlightMode,
    /// Whether the motors are armed.
    pub armed: bool,
    /// Whether a failsafe flies.
    pub failsafe: bool,
    /// Whether the vehicle stands on the ground.
    pub landed: bool,
    /// MAVLink system id.
    pub system_id: u8,
}

/// An entry of the flight log.
#[derive(Clone, Debug, PartialEq)]
pub enum LogEntry {
    /// A flight begins, at this time and with these parameters: simulated time has started, or started over.
    Begin(TimeUs, BTreeMap<String, Value>),
    /// A control step.
    Step(Box<StepRecord>),
    /// Something that was said, and when.
    Said(TimeUs, Event),
    /// A parameter has this value from here on.
    Parameter(String, Value),
    /// Entries were lost here: nobody fetched them in time.
    Gap,
}
