//! What a flight would tell of a vehicle that is known: so the errors of flights that are put together from
//! several are known before they are flown.

use nalgebra::DMatrix;

use super::asked::{IdentifyError, Settings};
use super::course::Course;
use super::fit::{Fit, Part, Told, no_sharper};
use super::parameter::{PARAMETERS, Parameter};
use super::{FEWEST, LONG_S};
use crate::logged_flight::LoggedFlight;
use crate::model::Vehicle;

/// What a flight says of the parameters, as a sum over its stretches: how sharply, and how that scatters.
#[derive(Clone, Debug, PartialEq)]
pub struct Information {
    sharp: DMatrix<f64>,
    scatter: DMatrix<f64>,
    is_of: [bool; PARAMETERS],
}

impl Information {
    /// The information of a flight of a vehicle that is as it is known, but for a delay of its commands [s].
    ///
    /// # Errors
    /// [`IdentifyError`] where the flight has not what is needed.
    pub fn of(
        flight: &LoggedFlight,
        vehicle: &Vehicle,
        settings: &Settings,
        delay_s: f64,
    ) -> Result<Self, IdentifyError> {
        let course = Course::of(flight, vehicle, settings)?;
        let stretches = course.stretches(LONG_S);
        if stretches.len() < FEWEST {
            return Err(IdentifyError::NotFlown);
        }
        let parts = [Part { course: &course, gravity_m_s2: settings.gravity_m_s2, stretches }];
        let mut deviations = [0.0; PARAMETERS];
        deviations[Parameter::Delay as usize] = delay_s;
        let mut fit = Fit::new(vehicle, &parts, deviations);
        fit.run(2, 3);
        let Told { matrix: sharp, moves, known, .. } = fit.told();
        let mut scatter = DMatrix::zeros(sharp.nrows(), sharp.nrows());
        for moved in moves.iter().map(|(moved, _)| moved).chain(&known) {
            let pushed = &sharp * moved;
            scatter += &pushed * pushed.transpose();
        }
        Ok(Self { sharp, scatter, is_of: Parameter::ALL.map(|parameter| parameter.is_of(vehicle)) })
    }

    /// The information of so many times this flight, and that of another.
    #[must_use]
    pub fn and(&self, times: f64, other: Option<Self>) -> Self {
        let (mut sharp, mut scatter) = (&self.sharp * times, &self.scatter * times);
        if let Some(other) = other {
            sharp += other.sharp;
            scatter += other.scatter;
        }
        Self { sharp, scatter, is_of: self.is_of }
    }

    /// Standard errors in the order of [`Parameter::ALL`], in each parameter's own terms; infinite where
    /// nothing is said, NaN where the vehicle has no such number.
    pub fn errors(&self) -> [f64; PARAMETERS] {
        let Some(root) = self.sharp.clone().cholesky() else { return [f64::INFINITY; PARAMETERS] };
        let inverse = root.inverse();
        let covariance = no_sharper(&inverse * &self.scatter * &inverse, self.sharp.clone());
        std::array::from_fn(|i| if self.is_of[i] { covariance[(i, i)].sqrt() } else { f64::NAN })
    }
}
