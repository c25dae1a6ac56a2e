//! Files in: vehicles, missions, gains, parameters and trajectories, read strictly.
//!
//! | file | holds |
//! |---|---|
//! | `mission`, `mission_parts`, `mission_ground`, `mission_json` | `mission/*.json`: checked, with model objects; as written |
//! | `gains_file` | `params/gains/*.json` |
//! | `params_file` | PX4 parameter files, and their gains for a mission |
//! | `checkpoint` | what a search of gains was told so far |
//! | `vehicle_file`, `vehicle_json` | `params/vehicles/*.json` and the rotor table beside it |
//! | [`schema`] | JSON schemas of these files |
//! | `trajectory_csv` | `trajectory.csv`, read and written |
//! | `source` | a file's text, strict JSON, the place of anything refused, the hash of the inputs |
//! | `number` | numbers with a range |
//! | `table`, `rotor_table` | CSV |
//!
//! A file is refused with `file:line:column`, the path of the value in the document, and what was expected there.
//! Unknown and repeated keys, numbers out of their range, NaN and text after the document are all refused.

mod checkpoint;
mod error;
mod gains_file;
mod mission;
mod mission_ground;
mod mission_json;
mod mission_parts;
mod mission_sensors;
mod number;
mod params_file;
mod release_case;
mod rotor_table;
pub mod schema;
mod source;
mod table;
mod trajectory_csv;
mod vehicle_file;
mod vehicle_json;

pub use checkpoint::{SearchIdentity, Told, checkpoint_json, load_checkpoint};
pub use error::ConfigError;
pub use gains_file::{GainsFile, gains_json, gains_path, load_gains};
pub use mission::{Mission, MonteCarlo, PlanInitial, Px4Clock, load_mission};
pub use mission_ground::MissionGround;
pub use params_file::load_parameters;
pub use release_case::CaseError;
pub use trajectory_csv::{Stamp, TrajectoryFile, read_trajectory_csv, write_trajectory_csv};
pub use vehicle_file::{VehicleFile, load_vehicle};

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and spoil files")]
mod mission_tests;
#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and spoil files")]
mod prop_tests;
#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and spoil files")]
mod spoil;
#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and spoil files")]
mod trajectory_tests;
#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and spoil files")]
mod vehicle_tests;
