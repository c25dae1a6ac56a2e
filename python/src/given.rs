//! The mission as Python gives it: a name, a path or texts, and what is chosen in place of its own.

use std::path::PathBuf;

use pyo3::prelude::*;
use samara::config::shipped::is_built_in;
use samara::config::{Mission, MissionText, load_mission, mission_path, parse_mission};
use samara::study::asked::Asked;
use samara::study::campaign::settings::OWN;
use samara::study::own;
use samara::study::settings::Values;

use crate::fault::{Fault, OrGiven as _};

/// A mission with its choices: a dictionary whose keys are these.
#[derive(Clone, Debug, FromPyObject)]
#[pyo3(from_item_all)]
pub struct Given {
    /// Name or path; `None` where the text is given.
    name: Option<PathBuf>,
    /// Text of the mission file.
    text: Option<String>,
    /// Path that the text is read under.
    file: PathBuf,
    /// Text of the vehicle file, in place of the file that the mission names.
    vehicle: Option<String>,
    /// Text of the gains file, in place of the file that the mission names.
    own_gains: Option<String>,
    /// Other gains: a name or a path.
    gains: Option<String>,
    /// Other gains: the text of a file.
    gains_text: Option<String>,
    /// Gains and limits from a PX4 parameter file.
    params: Option<PathBuf>,
    /// Seed of everything random.
    seed: Option<u64>,
    /// Name of the release case to swing to.
    case: Option<String>,
}

/// What messages call gains that are on no disk.
const GAINS_TEXT: &str = "<gains dict>";

impl Given {
    /// The mission with the choices made.
    pub fn mission(&self) -> Result<Mission, Fault> {
        let mut mission = self.open()?;
        if let Some(gains) = &self.gains {
            mission.use_gains(gains).or_given()?;
        }
        if let Some(text) = &self.gains_text {
            mission.use_gains_text(text, GAINS_TEXT.as_ref()).or_given()?;
        }
        if let Some(path) = &self.params {
            mission.use_parameters(path).or_given()?;
        }
        if let Some(seed) = self.seed {
            mission.use_seed(seed);
        }
        if let Some(case) = &self.case {
            mission.use_release_case(case).or_given()?;
        }
        Ok(mission)
    }

    /// The mission alone, as its file has it.
    pub fn without_choices(&self) -> Self {
        Self { gains: None, gains_text: None, params: None, seed: None, case: None, ..self.clone() }
    }

    /// Whether gains were chosen in place of the mission's own.
    pub fn has_gains(&self) -> bool {
        self.gains.is_some() || self.gains_text.is_some() || self.params.is_some()
    }

    fn open(&self) -> Result<Mission, Fault> {
        match (&self.name, &self.text) {
            (Some(name), _) => load_mission(&mission_path(name).or_given()?).or_given(),
            (None, Some(mission)) => {
                let (file, vehicle, gains) =
                    (self.file.as_path(), self.vehicle.as_deref(), self.own_gains.as_deref());
                parse_mission(&MissionText { mission, file, vehicle, gains }).or_given()
            }
            (None, None) => {
                Err(Fault::in_words("a mission is expected: a name, a path or a dict".to_owned()))
            }
        }
    }

    /// Campaigns of this mission with these settings, as the program is asked for them. What is on no disk
    /// stands there as in messages.
    pub fn asked(&self, mission: &Mission, values: &Values) -> Asked {
        let gains = self.gains.as_deref().or(self.gains_text.as_deref().and(Some(GAINS_TEXT)));
        let mut asked = Asked::of(own::ABOUT.name, OWN, values, mission);
        if let Some(name) = self.name.as_ref().filter(|_| is_built_in(&mission.file)) {
            asked.mission = name.into();
        }
        Asked { gains: gains.map(str::to_owned), params: self.params.clone(), ..asked }
    }

    /// A parameter file that the autopilot loads besides.
    pub fn params(&self) -> Option<&PathBuf> {
        self.params.as_ref()
    }
}
