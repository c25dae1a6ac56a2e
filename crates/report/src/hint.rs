//! A hint beside a no: what mostly causes it, or what does so here, and the command for it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use samara_core::hints::No;
use samara_mission::Mission;

use super::shell::command_line;

/// What there is to say beside a no.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Hint {
    /// Name of the no in the table of noes.
    pub no: String,
    /// What causes it, as far as that is known, a sentence without a full stop.
    pub cause: String,
    /// The command that looks closer or mends it.
    pub command: String,
}

impl Hint {
    /// The hint of a no of a mission, with its usual cause.
    pub fn of(no: No, mission: &Mission) -> Self {
        let hint = no.hint();
        let command = command_line(hint.command_for(&mission.inputs.typed));
        Self { no: hint.name.to_owned(), cause: hint.cause.to_owned(), command }
    }

    /// The hint as lines for the terminal.
    pub fn lines(&self) -> String {
        format!("  cause: {}\n  {}\n", self.cause, self.command)
    }

    /// The hint in a line, for a page, without the marks about its keys.
    pub fn sentence(&self) -> String {
        format!("Cause: {}. Then: {}", self.cause.replace('`', ""), self.command)
    }
}
