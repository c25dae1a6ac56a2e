//! `--set KEY=VALUE`: keys of the mission's, the vehicle's and the gains' files with other values.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, Args, Command};

use samara::config::{Override, settable_keys};

/// The heading of what stands in place of the mission's own.
pub const CHOICES: &str = "In place of the mission's own";

/// Keys of the mission's and the vehicle's files with other values.
#[derive(Args, Clone, Debug, Default)]
pub struct SetArgs {
    /// Another value of a key of the mission or its vehicle; may be repeated.
    ///
    /// The key as a path: limits.pitch_deg=40, mass_kg=2.1, tuning.cases[0].pitch_deg=5. A number may have a
    /// unit (limits.speed_m_s=30kt), numbers stand in a list with commas (target_v_ned_m_s=3,0,1), all else
    /// is JSON or a text. Where both files have the key, the mission's is meant; `vehicle.` before it means
    /// the vehicle's, `gains.` the gains'.
    #[arg(long = "set", value_name = "KEY=VALUE", value_parser = SetParser, help_heading = CHOICES, hide_possible_values = true)]
    pub set: Vec<Override>,
}

impl SetArgs {
    /// The options as they are typed.
    pub fn words(&self) -> impl Iterator<Item = String> {
        self.set.iter().flat_map(|given| ["--set".to_owned(), given.to_string()])
    }
}

/// Reads the value of `--set`, and has shells complete the keys.
#[derive(Clone)]
struct SetParser;

impl TypedValueParser for SetParser {
    type Value = Override;

    fn parse_ref(
        &self,
        command: &Command,
        arg: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Override, clap::Error> {
        let parse: fn(&str) -> Result<Override, String> = str::parse;
        parse.parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(settable_keys().map(|key| PossibleValue::new(format!("{}=", key.path)))))
    }
}
