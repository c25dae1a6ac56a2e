//! What was found of a vehicle, and the vehicle that it is.

use nalgebra::DMatrix;

use super::course::MEASURED;
use super::parameter::Parameter;
use crate::model::rigid_body::MassProperties;
use crate::model::{ModelError, Motor, Vehicle};

/// Share of a normal distribution's error within which 95 % lie.
const WITHIN_95: f64 = 1.959_963_984_540_054;

/// What was found of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// The parameter.
    pub parameter: Parameter,
    /// Deviation from what was known, in the parameter's own terms, its standard error, and the factor on it
    /// that makes half of an interval that holds the truth in 95 % of cases.
    pub deviation: f64,
    /// Standard error of the deviation.
    pub error: f64,
    /// Half of the interval over the standard error.
    pub reach: f64,
}

impl Found {
    /// The ends of the interval that holds the truth in 95 % of cases: factors, or [s], [m].
    pub fn interval(&self) -> [f64; 2] {
        [-1.0, 1.0].map(|side| self.number(self.deviation + side * self.reach * self.error))
    }

    /// The factor, or the deviation itself [s, m].
    pub fn value(&self) -> f64 {
        self.number(self.deviation)
    }

    fn number(&self, deviation: f64) -> f64 {
        if self.parameter.is_factor() { self.parameter.factor(deviation) } else { deviation }
    }
}

/// How a channel was predicted in stretches that were not used, a second at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Predicted {
    /// Place in [`CHANNELS`](super::CHANNELS).
    pub channel: usize,
    /// Root mean square of what was measured less what was predicted.
    pub rms: f64,
    /// Share of the variance that was predicted; NaN where nothing moved.
    pub r_squared: f64,
    /// How many errors in a row say no more than one: 1 of white ones.
    pub together: f64,
    /// Root mean square over the sensor's own noise.
    pub over_noise: f64,
}

/// An instant that was predicted: time [s], measured and predicted channels; NaN where nothing was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Time since the log's start [s].
    pub t_s: f64,
    /// What was measured.
    pub measured: [f64; MEASURED],
    /// What the model had.
    pub predicted: [f64; MEASURED],
}

/// What logs tell of a vehicle.
#[derive(Clone, Debug, Default)]
pub struct Identified {
    /// What was found, in the order of [`Parameter::ALL`].
    pub found: Vec<Found>,
    /// What was not, with the reason.
    pub refused: Vec<(Parameter, String)>,
    /// Covariance of what was found, in its order.
    pub covariance: DMatrix<f64>,
    /// How half of the stretches was predicted by the vehicle of the other half.
    pub predicted: Vec<Predicted>,
    /// Instants of stretches that were not used, of the first log.
    pub shown: Vec<Shown>,
    /// Seconds that were looked at, and stretches.
    pub looked_at_s: f64,
    /// Stretches of flight.
    pub stretches: usize,
    /// Steps of all fits.
    pub steps: usize,
    /// Gusts, from second to second, as standard deviations north, east, down [m/s].
    pub gusts_m_s: [f64; 3],
    /// What holds for the whole result, in sentences.
    pub remarks: Vec<String>,
}

impl Identified {
    /// What was found of a parameter.
    pub fn of(&self, parameter: Parameter) -> Option<&Found> {
        self.found.iter().find(|found| found.parameter == parameter)
    }

    /// How far a parameter is off what was known; not at all where nothing was found.
    pub fn deviation(&self, parameter: Parameter) -> f64 {
        self.of(parameter).map_or(0.0, |found| found.deviation)
    }

    /// The vehicle that was found: the known one where nothing was.
    ///
    /// # Errors
    /// [`ModelError`] where there is no such body: its inertias break the triangle inequality.
    pub fn vehicle(&self, known: &Vehicle) -> Result<Vehicle, ModelError> {
        let mut vehicle = known.clone();
        let factor = |parameter: Parameter| parameter.factor(self.deviation(parameter));
        vehicle.rotor = known.rotor.clone().scaled([factor(Parameter::Thrust), factor(Parameter::Torque)]);
        let roots = [Parameter::InertiaX, Parameter::InertiaY, Parameter::InertiaZ].map(|p| factor(p).sqrt());
        let mut inertia = known.mass.inertia_kg_m2;
        for i in 0..3 {
            for j in 0..3 {
                inertia[(i, j)] *= roots[i] * roots[j];
            }
        }
        vehicle.mass = MassProperties::new(known.mass.mass_kg, inertia)?;
        vehicle.aero = known.aero.along_axes([factor(Parameter::DragAlong), factor(Parameter::DragAcross)]);
        let (up, down) = (factor(Parameter::LagUp), factor(Parameter::LagDown));
        vehicle.motor = match known.motor.clone() {
            Motor::FirstOrder { omega_max_rad_s, tau_up_s, tau_down_s, rotor_inertia_kg_m2 } => {
                Motor::FirstOrder {
                    omega_max_rad_s,
                    tau_up_s: up * tau_up_s,
                    tau_down_s: down * tau_down_s,
                    rotor_inertia_kg_m2,
                }
            }
            motor => motor.with_lag(up),
        };
        for rotor in &mut vehicle.rotors {
            rotor.position_body_m.x -= self.deviation(Parameter::CentreX);
            rotor.position_body_m.y -= self.deviation(Parameter::CentreY);
        }
        Ok(vehicle)
    }
}

/// Half of an interval of 95 % over the standard error, of Student's distribution with so many degrees of
/// freedom (Cornish and Fisher's expansion).
pub(super) fn reach(freedom: f64) -> f64 {
    let (z, n) = (WITHIN_95, freedom.max(1.0));
    let z3 = z * z * z;
    z + (z3 + z) / (4.0 * n) + (5.0 * z3 * z * z + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
}
