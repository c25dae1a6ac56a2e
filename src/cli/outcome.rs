//! How a verb ends: exit codes and the message that goes with them.

use std::process::ExitCode;

use super::output::tell;

/// What a verb found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// All is well: exit code 0.
    Yes,
    /// The result says no (not converged, limits passed, a check failed): exit code 1.
    No,
}

/// Why a verb did not get to an answer.
#[derive(Debug)]
pub enum Failure {
    /// A file, a flag, a peer or a place to write to is at fault: exit code 2.
    BadInput(anyhow::Error),
    /// We are: exit code 3.
    Internal(anyhow::Error),
}

impl Failure {
    /// The error with its causes, on a line.
    pub fn text(&self) -> String {
        let (Self::BadInput(error) | Self::Internal(error)) = self;
        format!("{error:#}")
    }
}

/// Marks errors as the input's fault.
pub trait BadInput<T> {
    /// Turns an error into [`Failure::BadInput`].
    fn bad_input(self) -> Result<T, Failure>;
}

impl<T, E: Into<anyhow::Error>> BadInput<T> for Result<T, E> {
    fn bad_input(self) -> Result<T, Failure> {
        self.map_err(|e| Failure::BadInput(e.into()))
    }
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Internal(error)
    }
}

/// Prints a failure and gives the exit code.
pub fn report(result: Result<Answer, Failure>) -> ExitCode {
    match result {
        Ok(Answer::Yes) => ExitCode::SUCCESS,
        Ok(Answer::No) => ExitCode::from(1),
        Err(Failure::BadInput(e)) => {
            tell(&format!("samara: {e:#}\n"));
            ExitCode::from(2)
        }
        Err(Failure::Internal(e)) => {
            tell(&format!("samara: internal error: {e:#}\n"));
            ExitCode::from(3)
        }
    }
}
