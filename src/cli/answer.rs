//! How a verb ends: with an answer, or with a failure that says whose it is.

/// What a verb found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// All is well: exit code 0.
    Yes,
    /// The result says no (not converged, limits passed, a check failed): exit code 1.
    No,
    /// A search has candidates that others are to judge: exit code 4.
    Asks,
}

impl From<bool> for Answer {
    fn from(all_well: bool) -> Self {
        if all_well { Self::Yes } else { Self::No }
    }
}

/// Why a verb did not get to an answer.
#[derive(Debug)]
pub enum Failure {
    /// A file, a flag, a peer or a place to write to is at fault: exit code 2.
    BadInput(anyhow::Error),
    /// The program is at fault: exit code 3.
    Internal(anyhow::Error),
}

impl Failure {
    /// A fault of the input, in words.
    pub fn input(text: String) -> Self {
        Self::BadInput(anyhow::Error::msg(text))
    }

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
