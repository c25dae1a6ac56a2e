//! PX4 parameters: files of QGroundControl, PX4's own ranges, and what samara's gains are in PX4's terms.
//!
//! | file | holds |
//! |---|---|
//! | [`mod@file`] | the parameters of a file, and QGroundControl's `.params` written |
//! | [`reading`] | files of any format that holds PX4's parameters |
//! | [`metadata`] | type, default, range of PX4's parameters, by version |
//! | [`against`] | the version of PX4 that parameters are held against |
//! | [`purpose`] | purposes of a file, and the factors between samara's gains and theirs |
//! | [`normalised`] | PX4's normalised torque and thrust in N m and N, for any rotor set |
//! | [`mod@export`] | gains, limits and vehicle to parameters |
//! | [`mod@import`] | parameters to gains and limits |
//! | [`px4_required`] | parameters that a drop requires of PX4, and why |
//! | [`compatibility`] | whether a file may be used for an autopilot at a site |
//! | [`mod@px4_model_parameters`] | parameters of the model of PX4's controller |
//! | [`upload`] | the parameters that PX4 gets before a drop |
//! | [`mod@check`] | a file against PX4's ranges |
//! | [`mod@diff`] | two files against each other |
//!
//! Text in, text out: files are opened elsewhere.

pub mod against;
pub mod check;
pub mod compatibility;
pub mod diff;
pub mod export;
pub mod file;
pub mod import;
pub mod metadata;
pub mod normalised;
pub mod purpose;
pub mod px4_model_parameters;
pub mod px4_required;
pub mod reading;
pub mod upload;

#[cfg(test)]
mod import_tests;

pub use against::{Against, NamedBy};
pub use check::{Check, Class, Finding, check};
pub use diff::{Difference, diff};
pub use export::{Export, Subject, export, export_for_law, export_for_mixing, export_for_version};
pub use file::{ParameterFile, Value};
pub use import::{Import, Scale, adopt, import};
pub use metadata::{Metadata, Parameter};
pub use normalised::{Mixing, NormalisedUnits};
pub use purpose::Purpose;
pub use px4_model_parameters::{
    believed_speed_noise_m_s, px4_model_export, px4_model_parameters, px4_receiver,
};
pub use upload::Upload;

/// Why a parameter file is refused. Errors of a line start with its number, so that `file:` before them makes
/// a place.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ParamsError {
    /// A row does not have five columns.
    #[error(
        "{line}: expected five columns separated by tabs (vehicle id, component id, name, value, type), found {found}; rows of a name and a \
         value are read too, what `param show` prints, and scripts of `param set`"
    )]
    Columns {
        /// Line of the file, from 1.
        line: usize,
        /// Number of columns.
        found: usize,
    },
    /// A column does not hold what it should.
    #[error("{line}: {column}: expected {expected}, found `{found}`")]
    Field {
        /// Line of the file, from 1.
        line: usize,
        /// Name of the column.
        column: &'static str,
        /// What was expected.
        expected: &'static str,
        /// Text of the column, shortened.
        found: String,
    },
    /// A row does not have a name and a value.
    #[error("{line}: expected a name and a value, as the rows before have them")]
    Pair {
        /// Line of the file, from 1.
        line: usize,
    },
    /// The file has more rows than any autopilot has parameters.
    #[error("{line}: more than {most} parameters")]
    TooMany {
        /// Line of the file, from 1.
        line: usize,
        /// The greatest number of them.
        most: usize,
    },
    /// A parameter occurs twice, with different values.
    #[error("{line}: {name} stands on line {first} already, with another value")]
    Twice {
        /// Line of the second occurrence, from 1.
        line: usize,
        /// Name of the parameter.
        name: String,
        /// Line of the first occurrence.
        first: usize,
    },
    /// The file has a format that is not read; the words say which.
    #[error("{0}")]
    Format(String),
    /// The file was written for another autopilot, gravity or vehicle.
    #[error("{0}")]
    DoesNotBelong(String),
    /// The mission asks for what PX4 does not have.
    #[error(
        "{key}: {found} has no counterpart in PX4 before {since}, where {parameter} came: `{expected}` is expected, or PX4 {since} or later"
    )]
    NoCounterpart {
        /// Key of the mission.
        key: &'static str,
        /// Value of the key.
        found: &'static str,
        /// Value that PX4 has.
        expected: &'static str,
        /// Name of the parameter that later versions have.
        parameter: &'static str,
        /// The first version that has it.
        since: &'static str,
    },
    /// The file holds none of the gains.
    #[error(
        "none of the gains of samara's autopilot stands in it (MPC_XY_VEL_P_ACC, MC_PITCH_P, MC_PITCHRATE_P, ...)"
    )]
    NoGains,
    /// Gains or limits that the autopilot does not take, or rotors that cannot be controlled.
    #[error(transparent)]
    Control(#[from] crate::control::ControlError),
    /// PX4's mixer has no unit for this axis.
    #[error("PX4's mixer finds no {axis} for this rotor set")]
    NoUnit {
        /// The axis: "roll moment", "pitch moment" or "thrust".
        axis: &'static str,
    },
}
