//! What is odd about a mission: a sentence, and what kind of a no it is.

use std::fmt;

use samara_core::hints::No;

/// Something odd about a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct Odd {
    /// What kind of a no it is.
    pub no: No,
    /// A sentence with its key, without a full stop.
    pub text: String,
}

impl Odd {
    /// A kind of no, and its sentence.
    pub fn new(no: No, text: String) -> Self {
        Self { no, text }
    }
}

impl fmt::Display for Odd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
