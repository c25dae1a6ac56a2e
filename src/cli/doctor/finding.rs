//! What was found, whether it is as it should be, and what to do.

use serde_json::{Value, json};

/// Whether something is as it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// As it should be.
    Ok,
    /// Needed, and not as it should be.
    No,
    /// Not there, and needed for some things alone.
    Absent,
}

impl State {
    /// Whether it is as it should be or not.
    pub const fn ok_or_no(ok: bool) -> Self {
        if ok { Self::Ok } else { Self::No }
    }

    /// The word at the beginning of a line.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::No => "NO",
            Self::Absent => "-",
        }
    }
}

/// Something that was looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Name of it.
    pub of: String,
    /// Whether it is as it should be.
    pub state: State,
    /// Sentence about what was found.
    pub found: String,
    /// Sentence about what to do, where there is something.
    pub advice: Option<String>,
}

impl Finding {
    /// Something with nothing to do about it.
    pub fn new(of: &str, state: State, found: impl Into<String>) -> Self {
        Self { of: of.to_owned(), state, found: found.into(), advice: None }
    }

    /// The finding with what to do.
    pub fn advising(self, advice: impl Into<String>) -> Self {
        Self { advice: Some(advice.into()), ..self }
    }

    /// Whether nothing needed is missing.
    pub fn is_no_trouble(&self) -> bool {
        self.state != State::No
    }

    /// The finding as an object.
    pub fn object(&self) -> Value {
        json!({ "of": self.of, "state": self.state.word(), "found": self.found, "advice": self.advice })
    }
}
