//! Choices in place of a mission's own: gains, parameters, a release case, a seed, a trajectory. The hash of
//! the inputs follows each.

use std::path::Path;

use super::{CaseError, Mission};
use crate::error::ConfigError;
use crate::params_file::{self, refuse};
use crate::source::Source;
use crate::trajectory_csv::{TrajectoryFile, load_trajectory};
use samara_core::params::compatibility::written_for;
use samara_core::params::{ParameterFile, import};
use samara_core::printable::printable;

impl Mission {
    /// Puts other gains in: those of the file `name_or_path`, or of that name beside the mission's own gains
    /// file, or the built-in ones of that name. The input hash follows.
    ///
    /// # Errors
    /// [`ConfigError`] when nothing has the name, or the file cannot be read or does not hold gains; the
    /// mission is unchanged then.
    pub fn use_gains(&mut self, name_or_path: &str) -> Result<(), ConfigError> {
        let file = self.inputs.other_gains(name_or_path)?;
        self.inputs.type_gains("--gains", name_or_path);
        (self.control.gains, self.control.gains_name) = (file.gains, file.name);
        Ok(())
    }

    /// Puts other gains in: those of the text of a gains file, as if `file` held it. The input hash follows.
    ///
    /// # Errors
    /// [`ConfigError::Content`] when the text does not hold gains; the mission is unchanged then.
    pub fn use_gains_text(&mut self, text: &str, file: &Path) -> Result<(), ConfigError> {
        let file = self.inputs.given_gains(&Source::of_text(text, file))?;
        (self.control.gains, self.control.gains_name) = (file.gains, file.name);
        Ok(())
    }

    /// Puts the gains and limits of a parameter file in; what the file leaves out stays. The input hash
    /// follows. Returns remarks on the file.
    ///
    /// # Errors
    /// [`ConfigError`] when the file cannot be read or does not belong to the mission's vehicle and site; the
    /// mission is unchanged then.
    pub fn use_parameters(&mut self, path: &Path) -> Result<Vec<String>, ConfigError> {
        let (source, file) = params_file::read(path)?;
        let import = import(&file, &self.parameter_subject()).map_err(|error| refuse(path, error))?;
        (self.control.gains, self.control.limits) = (import.gains, import.limits);
        self.control.gains_name = file_name(path);
        self.inputs.absorb_file("parameters", &source);
        self.inputs.type_gains("--params", path.display().to_string());
        Ok(file.remarks().iter().cloned().chain(import.remarks).collect())
    }

    /// Notes that a parameter file is flown which is another autopilot's: name and input hash follow, the
    /// gains stay. Returns the file.
    ///
    /// # Errors
    /// [`ConfigError`] when the file cannot be read or is not for a PX4 that flies this mission; the mission
    /// is unchanged then.
    pub fn note_parameters(&mut self, path: &Path) -> Result<ParameterFile, ConfigError> {
        let (source, file) = params_file::read(path)?;
        written_for(&file, self.site.environment.gravity_m_s2, self.px4_purpose())
            .map_err(|error| refuse(path, error))?;
        self.control.gains_name = file_name(path);
        self.inputs.absorb_file("parameters", &source);
        self.inputs.type_gains("--params", path.display().to_string());
        Ok(file)
    }

    /// Lets the vehicle swing so that a release at the end of the hang brings it to t = 0 with the pitch and
    /// the pitch rate of the case `name`. The input hash follows.
    ///
    /// # Errors
    /// [`CaseError`] when there is no such case or no swing leads to it; the mission is unchanged then.
    pub fn use_release_case(&mut self, name: &str) -> Result<(), CaseError> {
        let cases = &self.study.cases;
        let Some(case) = cases.iter().find(|case| case.name == name) else {
            let known = cases.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(CaseError::Unknown { name: name.to_owned(), known });
        };
        let swinging = self.release.swinging_to(case, &self.vehicle, &self.site.environment);
        self.release.parachute = swinging.ok_or_else(|| CaseError::OutOfReach { name: name.to_owned() })?;
        self.note_choice("release case", name);
        Ok(())
    }

    /// Puts another seed in. The input hash follows.
    pub fn use_seed(&mut self, seed: u64) {
        if seed != self.seed {
            self.seed = seed;
            if let Some(turbulence) = self.site.wind.turbulence.as_mut().filter(|t| t.follows_mission) {
                turbulence.seed = seed;
            }
            if let Some(ring) = self.site.wind.ring.as_mut().filter(|r| r.follows_mission) {
                ring.seed = seed;
            }
            self.note_choice("seed", &seed.to_string());
        }
    }

    /// Puts the gains for renewed plans in (`replan.gains`), where the mission has some.
    pub fn use_replan_gains(&mut self) {
        if let Some(file) = self.replan.gains.clone() {
            (self.control.gains, self.control.gains_name) = (file.gains, file.name);
        }
    }

    /// Has a trajectory for the mission's vehicle flown instead of a plan: that of a file, or of a text as if
    /// the file held it. The input hash follows.
    ///
    /// # Errors
    /// [`ConfigError`] when the file is wrong or for another number of rotors; the mission is unchanged then.
    pub fn use_trajectory(&mut self, path: &Path, text: Option<&str>) -> Result<TrajectoryFile, ConfigError> {
        let source = text.map(|text| Source::of_text(text, path));
        let file = load_trajectory(path, source, self.vehicle.rotors.len())?;
        self.note_choice("trajectory sha256", &file.sha256);
        Ok(file)
    }

    /// Hash of mission, vehicle and tables without the gains: the inputs of a search for gains.
    pub fn hash_without_gains(&self) -> String {
        self.inputs.hash_without_gains()
    }
}

/// The name of a file as a label: fit to be printed.
fn file_name(path: &Path) -> String {
    printable(&path.file_name().unwrap_or_default().to_string_lossy()).into_owned()
}
