//! PX4 parameter files for missions: read from disk, and their gains put in.

use std::path::Path;

use super::Px4Clock;
use super::source::Source;
use super::{ConfigError, Mission};
use crate::params::compatibility::to_px4;
use crate::params::{ParameterFile, ParamsError, Purpose, Subject, import};

/// Reads a parameter file of any origin.
///
/// # Errors
/// [`ConfigError`] with the line in the file, when it cannot be read or does not hold parameters.
pub fn load_parameters(path: &Path) -> Result<ParameterFile, ConfigError> {
    Ok(read(path)?.1)
}

fn read(path: &Path) -> Result<(Source, ParameterFile), ConfigError> {
    let source = Source::read(path, "parameter file", None)?;
    let file = ParameterFile::parse(&source.text).map_err(|error| refuse(path, error))?;
    Ok((source, file))
}

fn refuse(path: &Path, error: ParamsError) -> ConfigError {
    ConfigError::Parameters { file: path.to_owned(), error }
}

impl Mission {
    /// What a parameter file of this mission is about.
    pub fn parameter_subject(&self) -> Subject<'_> {
        Subject {
            vehicle: &self.vehicle,
            environment: &self.site.environment,
            gains: &self.control.gains,
            limits: &self.control.limits,
            speed_m_s: self.limits.safety.speed_m_s,
        }
    }

    /// What a parameter file must be for that a PX4 flies this mission with.
    pub fn px4_purpose(&self) -> Purpose {
        match self.px4.clock {
            Px4Clock::Real => Purpose::Px4,
            Px4Clock::Froude => Purpose::Px4Froude,
        }
    }

    /// Puts the gains and limits of a parameter file in; what the file leaves out stays. The input hash follows. Gives remarks on the
    /// file.
    ///
    /// # Errors
    /// [`ConfigError`] when the file cannot be read or does not belong to the mission's vehicle and site; the mission is
    /// unchanged then.
    pub fn use_parameters(&mut self, path: &Path) -> Result<Vec<String>, ConfigError> {
        let (source, file) = read(path)?;
        let import = import(&file, &self.parameter_subject()).map_err(|error| refuse(path, error))?;
        (self.control.gains, self.control.limits) = (import.gains, import.limits);
        self.control.gains_name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.inputs.hash = self.hash_with("parameters", &source);
        Ok(file.remarks().iter().cloned().chain(import.remarks).collect())
    }

    /// Notes that a parameter file is flown which is another autopilot's: name and input hash follow, the gains stay. Gives the file.
    ///
    /// # Errors
    /// [`ConfigError`] when the file cannot be read or is not for a PX4 that flies this mission; the mission is unchanged then.
    pub fn note_parameters(&mut self, path: &Path) -> Result<ParameterFile, ConfigError> {
        let (source, file) = read(path)?;
        to_px4(&file, self.site.environment.gravity_m_s2, self.px4_purpose())
            .map_err(|error| refuse(path, error))?;
        self.control.gains_name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.inputs.hash = self.hash_with("parameters", &source);
        Ok(file)
    }
}
