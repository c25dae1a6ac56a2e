//! Faults: what fails in a flight, and when.

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use super::release::Release;
use crate::error::ConfigError;
use crate::number::{Count, Exactly, NonNegative, Positive, Within};
use crate::source::Source;
use samara_core::sim::Start;
use samara_core::sim::faults::{Fault, FaultKind, FaultUnit, MotorFault, Sensor, SensorFault};

/// What fails, and when. Faults act in drops and in campaigns of whole drops; those of motors also in flights
/// from t = 0. Plans are made and gains are tuned without them.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct FaultsJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// The faults, in any order. A motor, a sensor, the setpoints, the parachute and its riser each have one
    /// at a time: a fault that begins ends the one before it.
    #[serde(default)]
    #[schemars(length(max = 100))]
    list: Vec<FaultJson>,
    /// Whether MAV_CMD_INJECT_FAILURE may begin and end faults in flight; false when left out.
    #[serde(default)]
    allow_command: bool,
}

/// A fault.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct FaultJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// What fails.
    fault: KindJson,
    /// Beginning, from the nominal t = 0, when the rotors are freed; negative: before [s].
    at_s: Within<900>,
    /// End, likewise [s]; it stays when left out.
    until_s: Option<Within<900>>,
}

/// What fails. `samara faults` lists what each does.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum KindJson {
    /// No current flows in the motor.
    MotorOff(RotorJson),
    /// The rotor keeps the speed that it has.
    MotorStuck(RotorJson),
    /// The motor follows its command late.
    MotorSlow {
        /// Number of the rotor, from 1.
        rotor: Count<1, 8>,
        /// Time constant of a first-order lag of the command [s].
        lag_s: Positive<100>,
    },
    /// The motor turns slower than it is commanded to.
    MotorWeak {
        /// Number of the rotor, from 1.
        rotor: Count<1, 8>,
        /// Speed that it goes for over the speed commanded.
        factor: NonNegative<1>,
    },
    /// The speed controller does not start a motor that is at rest.
    EscNoStart(RotorJson),
    /// No body rates are read.
    GyroOff,
    /// The last body rates are repeated.
    GyroStuck,
    /// An error of the body rates grows.
    GyroDrift {
        /// Rate of the error, body [rad/s^2].
        rate_rad_s2: Exactly<Within<1000>, 3>,
    },
    /// The body rates are wrong.
    GyroWrong {
        /// Error that is added, body [rad/s]; 0 when left out.
        offset_rad_s: Option<Exactly<Within<1000>, 3>>,
        /// Factor on them; 1 when left out.
        scale: Option<Within<1000>>,
    },
    /// The body rates are random.
    GyroGarbage,
    /// No specific force is read.
    AccelerometerOff,
    /// The last specific force is repeated.
    AccelerometerStuck,
    /// An error of the specific force grows.
    AccelerometerDrift {
        /// Rate of the error, body [m/s^3].
        rate_m_s3: Exactly<Within<1000>, 3>,
    },
    /// The specific force is wrong.
    AccelerometerWrong {
        /// Error that is added, body [m/s^2]; 0 when left out.
        offset_m_s2: Option<Exactly<Within<1000>, 3>>,
        /// Factor on it; 1 when left out.
        scale: Option<Within<1000>>,
    },
    /// The specific force is random.
    AccelerometerGarbage,
    /// No magnetic field is read.
    MagnetometerOff,
    /// The last field is repeated.
    MagnetometerStuck,
    /// An error of the field grows.
    MagnetometerDrift {
        /// Rate of the error, body [gauss/s].
        rate_gauss_s: Exactly<Within<1000>, 3>,
    },
    /// The field is wrong.
    MagnetometerWrong {
        /// Error that is added, body [gauss]; 0 when left out.
        offset_gauss: Option<Exactly<Within<1000>, 3>>,
        /// Factor on it; 1 when left out.
        scale: Option<Within<1000>>,
    },
    /// The field is random.
    MagnetometerGarbage,
    /// No pressure is read.
    BarometerOff,
    /// The last pressure is repeated.
    BarometerStuck,
    /// An error of the pressure grows.
    BarometerDrift {
        /// Rate of the error [hPa/s].
        rate_hpa_s: Within<1000>,
    },
    /// The pressure is wrong.
    BarometerWrong {
        /// Error that is added [hPa]; 0 when left out.
        offset_hpa: Option<Within<10_000>>,
        /// Factor on it; 1 when left out.
        scale: Option<Within<1000>>,
    },
    /// The pressure is random.
    BarometerGarbage,
    /// The satellite receiver reports that it has no fix.
    GpsLoss,
    /// Nothing comes from the satellite receiver.
    GpsOff,
    /// The last position and velocity are repeated.
    GpsStuck,
    /// An error of the position grows; the velocity is right.
    GpsDrift {
        /// Rate of the error, NED [m/s].
        rate_ned_m_s: Exactly<Within<1000>, 3>,
    },
    /// The position is wrong; the velocity is right.
    GpsWrong {
        /// Error that is added, NED [m].
        offset_ned_m: Exactly<Within<100_000>, 3>,
    },
    /// Position and velocity are random.
    GpsGarbage,
    /// The streamer sends nothing.
    SetpointLoss,
    /// The parachute's component sends no HEARTBEAT, as one that leaves with its canopy.
    ParachuteSilent,
    /// The parachute does not let go, whatever asks it to; at the fault's end it does what it was asked to.
    ParachuteHolds,
    /// The parachute lets go later than it is asked to.
    LateRelease {
        /// By how much [s].
        delay_s: Positive<900>,
    },
    /// One leg of the bridle stays fixed at the release, and the canopy (parachute.canopy) pulls by it until
    /// the fault's end.
    RiserHungUp {
        /// Where the leg is fixed, from the centre of mass, body axes [m].
        attachment_body_m: Exactly<Within<1000>, 3>,
    },
}

/// A rotor.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct RotorJson {
    /// Number of the rotor, from 1, in the order of the vehicle's file.
    rotor: Count<1, 8>,
}

impl KindJson {
    /// What fails; the error is of numbers that say nothing.
    fn meaning(self) -> Result<FaultKind, &'static str> {
        use Sensor::{Accelerometer, Barometer, Gps, Gyro, Magnetometer};
        let motor = |rotor: Count<1, 8>, fault| Ok(FaultKind::Motor { rotor: rotor.get(), fault });
        let sensor = |sensor, fault| Ok(FaultKind::Sensor { sensor, fault });
        let vector = |vector: Exactly<Within<1000>, 3>| Vector3::from(vector.get());
        let drift = |of, rate| sensor(of, SensorFault::Drift { rate });
        let wrong = |of, offset: Option<Vector3<f64>>, scale: Option<Within<1000>>| {
            if offset.is_none() && scale.is_none() {
                return Err("expected an offset, a scale or both, found neither");
            }
            let (offset, scale) = (offset.unwrap_or_default(), scale.map_or(1.0, Within::get));
            sensor(of, SensorFault::Wrong { offset, scale })
        };
        match self {
            Self::MotorOff(RotorJson { rotor }) => motor(rotor, MotorFault::Off),
            Self::MotorStuck(RotorJson { rotor }) => motor(rotor, MotorFault::Stuck),
            Self::MotorSlow { rotor, lag_s } => motor(rotor, MotorFault::Slow { lag_s: lag_s.get() }),
            Self::MotorWeak { rotor, factor } => motor(rotor, MotorFault::Weak { factor: factor.get() }),
            Self::EscNoStart(RotorJson { rotor }) => motor(rotor, MotorFault::NoStart),
            Self::GyroOff => sensor(Gyro, SensorFault::Off),
            Self::GyroStuck => sensor(Gyro, SensorFault::Stuck),
            Self::GyroDrift { rate_rad_s2 } => drift(Gyro, vector(rate_rad_s2)),
            Self::GyroWrong { offset_rad_s, scale } => wrong(Gyro, offset_rad_s.map(vector), scale),
            Self::GyroGarbage => sensor(Gyro, SensorFault::Garbage),
            Self::AccelerometerOff => sensor(Accelerometer, SensorFault::Off),
            Self::AccelerometerStuck => sensor(Accelerometer, SensorFault::Stuck),
            Self::AccelerometerDrift { rate_m_s3 } => drift(Accelerometer, vector(rate_m_s3)),
            Self::AccelerometerWrong { offset_m_s2, scale } => {
                wrong(Accelerometer, offset_m_s2.map(vector), scale)
            }
            Self::AccelerometerGarbage => sensor(Accelerometer, SensorFault::Garbage),
            Self::MagnetometerOff => sensor(Magnetometer, SensorFault::Off),
            Self::MagnetometerStuck => sensor(Magnetometer, SensorFault::Stuck),
            Self::MagnetometerDrift { rate_gauss_s } => drift(Magnetometer, vector(rate_gauss_s)),
            Self::MagnetometerWrong { offset_gauss, scale } => {
                wrong(Magnetometer, offset_gauss.map(vector), scale)
            }
            Self::MagnetometerGarbage => sensor(Magnetometer, SensorFault::Garbage),
            Self::BarometerOff => sensor(Barometer, SensorFault::Off),
            Self::BarometerStuck => sensor(Barometer, SensorFault::Stuck),
            Self::BarometerDrift { rate_hpa_s } => drift(Barometer, Vector3::x() * rate_hpa_s.get()),
            Self::BarometerWrong { offset_hpa, scale } => {
                wrong(Barometer, offset_hpa.map(|offset| Vector3::x() * offset.get()), scale)
            }
            Self::BarometerGarbage => sensor(Barometer, SensorFault::Garbage),
            Self::GpsLoss => sensor(Gps, SensorFault::NoFix),
            Self::GpsOff => sensor(Gps, SensorFault::Off),
            Self::GpsStuck => sensor(Gps, SensorFault::Stuck),
            Self::GpsDrift { rate_ned_m_s } => drift(Gps, vector(rate_ned_m_s)),
            Self::GpsWrong { offset_ned_m } => wrong(Gps, Some(Vector3::from(offset_ned_m.get())), None),
            Self::GpsGarbage => sensor(Gps, SensorFault::Garbage),
            Self::SetpointLoss => Ok(FaultKind::SetpointLoss),
            Self::ParachuteSilent => Ok(FaultKind::ParachuteSilent),
            Self::ParachuteHolds => Ok(FaultKind::ParachuteHolds),
            Self::LateRelease { delay_s } => Ok(FaultKind::LateRelease { delay_s: delay_s.get() }),
            Self::RiserHungUp { attachment_body_m } => {
                Ok(FaultKind::RiserHungUp { attachment_body_m: vector(attachment_body_m) })
            }
        }
    }
}

/// What fails in a flight.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faults {
    /// The faults that are known beforehand.
    pub list: Vec<Fault>,
    /// Whether MAV_CMD_INJECT_FAILURE may begin and end faults in flight.
    pub allow_command: bool,
}

impl Faults {
    /// The faults of a mission's section, of a vehicle with so many rotors.
    pub(super) fn from_json(
        source: &Source,
        json: &FaultsJson,
        release: &Release,
        duration_s: f64,
        rotors: usize,
    ) -> Result<Self, ConfigError> {
        let t0_s = if release.standing { 0.0 } else { release.hang_s + release.parachute.delay_s };
        let mut list = Vec::with_capacity(json.list.len());
        for (i, fault) in json.list.iter().enumerate() {
            let refuse = |key: &str, why: String| source.refuse(&format!("faults.list[{i}]{key}"), why);
            let kind = fault.fault.meaning().map_err(|why| refuse(".fault", why.to_owned()))?;
            match kind.unit() {
                FaultUnit::Motor(rotor) if rotor > rotors => {
                    let why =
                        format!("expected a rotor from 1 to {rotors}, which the vehicle has, found {rotor}");
                    return Err(refuse(".fault", why));
                }
                FaultUnit::Parachute | FaultUnit::ParachuteHeartbeat if release.standing => {
                    let why = format!(
                        "expected no {} where release.start is \"ground\": nothing hangs",
                        kind.name()
                    );
                    return Err(refuse(".fault", why));
                }
                FaultUnit::Riser => {
                    let needed = [
                        (release.parachute.suspension.is_some(), "a parachute.canopy that pulls"),
                        (release.start == Start::Release, "release.start \"release\""),
                    ];
                    if let Some((_, needed)) = needed.iter().find(|(there, _)| !there) {
                        let why = format!("expected {needed} with {}, found none", kind.name());
                        return Err(refuse(".fault", why));
                    }
                }
                _ => {}
            }
            let (at_s, until_s) = (fault.at_s.get(), fault.until_s.map(Within::get));
            if at_s >= duration_s - t0_s {
                let end_s = duration_s - t0_s;
                let why = format!(
                    "expected less than {end_s} s, when the simulation ends (duration_s), found {at_s} s"
                );
                return Err(refuse(".at_s", why));
            }
            // One that is over before the simulation begins would never be.
            let from_s = at_s.max(-t0_s);
            if let Some(until_s) = until_s.filter(|until_s| *until_s <= from_s) {
                let why = format!("expected more than {from_s} s, when it begins, found {until_s} s");
                return Err(refuse(".until_s", why));
            }
            list.push(Fault { kind, at_s, until_s });
        }
        Ok(Self { list, allow_command: json.allow_command })
    }

    /// Whether flights from t = 0, on the truth and without a wire, can have the faults: those of motors.
    ///
    /// # Errors
    /// [`UnfitFault`] with the first that they cannot have.
    pub fn check_from_t0(&self) -> Result<(), UnfitFault> {
        let why = "flights from t = 0 have no sensors, no link and no parachute: fly whole drops (`samara assess --autopilot reference`)";
        self.check(why, |kind| matches!(kind, FaultKind::Motor { .. }))
    }

    /// Whether a drop on the truth and without a wire can have the faults: those of motors and of the
    /// parachute.
    ///
    /// # Errors
    /// [`UnfitFault`] with the first that it cannot have.
    pub fn check_without_wire(&self) -> Result<(), UnfitFault> {
        let why = "the model of PX4's control law has no sensors and no link: fly it with `--autopilot reference --estimator ekf` or px4=DIR";
        self.check(why, |kind| {
            matches!(
                kind,
                FaultKind::Motor { .. }
                    | FaultKind::ParachuteHolds
                    | FaultKind::LateRelease { .. }
                    | FaultKind::RiserHungUp { .. }
            )
        })
    }

    fn check(&self, why: &'static str, fits: impl Fn(&FaultKind) -> bool) -> Result<(), UnfitFault> {
        match self.list.iter().position(|fault| !fits(&fault.kind)) {
            Some(place) => Err(UnfitFault { place, name: self.list[place].kind.name(), why }),
            None => Ok(()),
        }
    }

    /// What there is to remark on faults of sensors where the autopilot flies by the simulator's truth.
    pub fn remarks_on_truth(&self) -> Vec<String> {
        let of_sensor = |fault: &&Fault| matches!(fault.kind, FaultKind::Sensor { .. });
        let remark = |fault: &Fault| {
            format!(
                "{}: the autopilot flies by the simulator's truth and does not feel it; with --estimator ekf it does",
                fault.kind.name()
            )
        };
        self.list.iter().filter(of_sensor).map(remark).collect()
    }
}

/// A fault that flights of some kind cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("faults.list[{place}].fault: {name}: {why}")]
pub struct UnfitFault {
    /// Place in the mission's list, from 0.
    pub place: usize,
    /// Name of the fault.
    pub name: &'static str,
    /// Reason, and the way out.
    pub why: &'static str,
}
