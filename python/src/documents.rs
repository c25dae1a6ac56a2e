//! Missions, vehicles and gains as documents: the text of one, and what is wrong with one.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use samara::config::shipped::GAINS;
use samara::config::{ConfigError, MissionText, gains_path, input_text, mission_path, vehicle_path};

use crate::fault::Fault;

/// The path and the text of a document: of a name, or of a path. The kind is `mission`, `vehicle` or `gains`.
#[pyfunction]
pub fn document_text(py: Python<'_>, kind: &str, name: PathBuf) -> PyResult<(PathBuf, String)> {
    let (path, role) = match kind {
        "mission" => (mission_path(&name), "mission file"),
        "vehicle" => (vehicle_path(&name), "vehicle file"),
        _ => (gains_path(&name.to_string_lossy(), Path::new(GAINS)), "gains file"),
    };
    let found = path.and_then(|path| Ok((input_text(&path, role)?, path)));
    found.map(|(text, path)| (path, text)).map_err(|error| Fault::given(&error).raised(py))
}

/// Reads documents after every change of theirs; what is refused raises.
#[pyclass(frozen, module = "samara_tpf._samara")]
#[derive(Debug, Default)]
pub struct Reader(Mutex<samara::config::Reader>);

#[pymethods]
impl Reader {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Reads a mission under the path `file`, with the texts of vehicle and gains in place of the files that
    /// it names, where they are given.
    #[pyo3(signature = (text, file, vehicle=None, gains=None))]
    fn mission(
        &self,
        py: Python<'_>,
        text: &str,
        file: PathBuf,
        vehicle: Option<&str>,
        gains: Option<&str>,
    ) -> PyResult<()> {
        let text = MissionText { mission: text, file: &file, vehicle, gains };
        self.read(py, |reader| reader.mission(&text))
    }

    /// Reads a vehicle under the path `file`.
    fn vehicle(&self, py: Python<'_>, text: &str, file: PathBuf) -> PyResult<()> {
        self.read(py, |reader| reader.vehicle(text, &file))
    }

    /// Reads gains under the path `file`.
    fn gains(&self, py: Python<'_>, text: &str, file: PathBuf) -> PyResult<()> {
        self.read(py, |reader| reader.gains(text, &file))
    }
}

impl Reader {
    /// Reads with the interpreter's lock held, and makes the exception, which may let it go, behind that.
    fn read(
        &self,
        py: Python<'_>,
        with: impl FnOnce(&mut samara::config::Reader) -> Result<(), ConfigError>,
    ) -> PyResult<()> {
        let read = with(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
        read.map_err(|error| Fault::given(&error).raised(py))
    }
}
