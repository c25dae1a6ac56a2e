//! Why a verb has no answer, and the exception of `samara_tpf` that says so.

use std::error::Error;
use std::path::PathBuf;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use samara::config::ConfigError;
use samara::plan::Plan;
use samara::report::json::status_name;

/// Why there is no answer.
#[derive(Debug)]
pub enum Fault {
    /// What was given is at fault: `MissionError`.
    Given {
        /// The message, as the program prints it.
        message: String,
        /// The file that is at fault, where one is.
        file: Option<PathBuf>,
        /// Line and column, from 1.
        place: Option<(usize, usize)>,
        /// Where in the document.
        path: Option<String>,
    },
    /// No plan was found to fly: `PlanError`.
    NoPlan {
        /// The solver's status.
        status: &'static str,
        /// Why, in words.
        diagnosis: String,
    },
    /// No gains were found: `TuneError`.
    NoGains(String),
    /// The program is at fault: `RuntimeError`.
    Internal(String),
}

impl Fault {
    /// A fault of what was given, with its causes.
    pub fn given(error: &(dyn Error + 'static)) -> Self {
        let (mut message, mut cause) = (error.to_string(), error.source());
        while let Some(error) = cause {
            message += &format!(": {error}");
            cause = error.source();
        }
        let (mut file, mut place, mut path) = (None, None, None);
        match error.downcast_ref::<ConfigError>() {
            Some(ConfigError::Content { file: at, line, column, json_path, .. }) => {
                (file, place) = (Some(at.clone()), Some((*line, *column)));
                path = Some(json_path.clone()).filter(|path| !path.is_empty());
            }
            Some(ConfigError::Read { path: at, .. } | ConfigError::Parameters { file: at, .. }) => {
                file = Some(at.clone());
            }
            Some(ConfigError::Unknown { .. } | ConfigError::Override { .. }) | None => {}
        }
        Self::Given { message, file, place, path }
    }

    /// A fault of what was given, in words.
    pub fn in_words(message: String) -> Self {
        Self::Given { message, file: None, place: None, path: None }
    }

    /// Nobody waits for the answer any more.
    pub fn stopped() -> Self {
        Self::Internal("stopped".to_owned())
    }

    /// A plan that was not found.
    pub fn no_plan(plan: &Plan) -> Self {
        let diagnosis = plan.diagnosis.clone().unwrap_or_else(|| "not converged".to_owned());
        Self::NoPlan { status: status_name(plan.status), diagnosis }
    }

    /// The exception.
    pub fn raised(self, py: Python<'_>) -> PyErr {
        let made = || {
            let module = py.import("samara_tpf._errors")?;
            match self {
                Self::Given { message, file, place, path } => {
                    let file = file.map(|file| file.display().to_string());
                    let (line, column) = place.unzip();
                    module.getattr("MissionError")?.call1((message, file, line, column, path))
                }
                Self::NoPlan { status, diagnosis } => module.getattr("PlanError")?.call1((status, diagnosis)),
                Self::NoGains(why) => module.getattr("TuneError")?.call1((why,)),
                Self::Internal(message) => {
                    Ok(PyRuntimeError::new_err(message).into_value(py).into_bound(py).into_any())
                }
            }
        };
        made().map_or_else(|error| error, PyErr::from_value)
    }
}

/// Marks errors as a fault of what was given.
pub trait OrGiven<T> {
    /// The error as [`Fault::Given`].
    fn or_given(self) -> Result<T, Fault>;
}

impl<T, E: Error + 'static> OrGiven<T> for Result<T, E> {
    fn or_given(self) -> Result<T, Fault> {
        self.map_err(|error| Fault::given(&error))
    }
}
