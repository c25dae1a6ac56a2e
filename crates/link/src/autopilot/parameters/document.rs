//! The declaration as a page: `docs/parameters.md`.

use super::table::{Declaration, Role, table};
use super::{described, metadata, range_in_words};
use crate::autopilot::Settings;
use crate::control::Gains;
use crate::params::Parameter;
use crate::params::metadata::Kind;

const HEAD: &str = "\
# Parameters of the reference autopilot

Made by `samara params list`; `scripts/regenerate` writes it.

Names, types and units are PX4's. A value that a ground station sets is checked (type, NaN, range), refused
with the reason if it does not fit, and in effect at the next control step if the parameter acts; integrals of
the control loops stay. Where the mission brings a value from outside the range, the range reaches to it. `#`
stands for a rotor's number.

| name | type | unit | default | range | what it does | here |
|---|---|---|---|---|---|---|
";

/// A parameter of the reference autopilot, as it is listed.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed {
    /// Name, PX4's; `#` stands for a rotor's number.
    pub name: &'static str,
    /// INT32 or FLOAT.
    pub kind: &'static str,
    /// Unit stated by PX4; empty for none.
    pub unit: &'static str,
    /// Value before anybody sets it; `mission` for what follows gains, vehicle or limits.
    pub default: String,
    /// Range that a change is held against, in words; empty for what cannot be changed.
    pub range: String,
    /// Meaning, PX4's.
    pub about: &'static str,
    /// Part that it plays here, in words.
    pub here: String,
}

/// All parameters of the reference autopilot, in the table's order.
pub fn listed() -> Vec<Listed> {
    table().filter_map(|declared| Some(entry(&declared, &described(&declared, metadata())?))).collect()
}

/// The page, in Markdown.
pub fn markdown() -> String {
    let row = |listed: Listed| {
        let Listed { name, kind, unit, default, range, about, here } = listed;
        format!("| `{name}` | {kind} | {unit} | {default} | {range} | {about} | {here} |\n")
    };
    std::iter::once(HEAD.to_owned()).chain(listed().into_iter().map(row)).collect()
}

const FOLLOWS: [&str; 4] = ["MPC_XY_P", "MPC_XY_VEL_MAX", "MPC_Z_P", "MPC_Z_VEL_MAX_DN"];

fn entry(declared: &Declaration, known: &Parameter) -> Listed {
    let settings = Settings::beside(&Gains::near_hover());
    let kind = if known.kind == Kind::Int { "INT32" } else { "FLOAT" };
    let default = match declared.role {
        Role::Fact(value) => value.to_string(),
        // Those that follow the gains or the mission's limits.
        Role::Setting if FOLLOWS.contains(&declared.name) => "mission".to_owned(),
        Role::Setting => settings.get(declared.name).map_or_else(String::new, |value| value.to_string()),
        Role::SetpointLife => known.default.to_string(),
        // PX4 has nothing else to fly by.
        Role::Estimator => "0".to_owned(),
        Role::Controller
        | Role::Follows(_)
        | Role::Hover
        | Role::Vehicle
        | Role::SystemId
        | Role::AtBeginning(_) => "mission".to_owned(),
    };
    let range = if declared.role.is_settable() { range_in_words(known) } else { String::new() };
    let (name, unit, about) = (declared.name, known.unit, known.description);
    Listed { name, kind, unit, default, range, about, here: declared.role.words() }
}
