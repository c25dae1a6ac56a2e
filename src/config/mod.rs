//! Files in: vehicles, missions, gains, parameters and trajectories, read strictly.
//!
//! | file | holds |
//! |---|---|
//! | `mission` | a mission with its model objects, and the planner's problem |
//! | `mission_file`, `mission_parts`, `mission_ground`, `mission_sensors` | `mission/*.json`, read and checked; `mission_json`: as written |
//! | `mission_choices` | what is chosen in place of its own, and the hash of the inputs |
//! | `mission_releases`, `release_case` | its random releases; its release cases as drops |
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
mod mission_choices;
mod mission_file;
mod mission_ground;
mod mission_json;
mod mission_parts;
mod mission_releases;
mod mission_sensors;
mod number;
mod params_file;
mod release_case;
mod rotor_table;
pub mod schema;
mod source;
mod study_hash;
mod table;
mod trajectory_csv;
mod vehicle_file;
mod vehicle_json;

pub use checkpoint::{SearchIdentity, Told, checkpoint_json, load_checkpoint};
pub use error::ConfigError;
pub use gains_file::{GainsFile, gains_json, gains_path, load_gains};
pub use mission::{Control, Limits, Mission, PlanInitial, PlanSettings, Px4, Px4Clock, Release, Site, Study};
pub use mission_choices::Inputs;
pub use mission_file::load_mission;
pub use mission_releases::MonteCarlo;
pub use params_file::load_parameters;
pub use release_case::CaseError;
pub use trajectory_csv::{Stamp, TrajectoryFile, read_trajectory_csv, write_trajectory_csv};
pub use vehicle_file::{VehicleFile, load_vehicle};

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and spoil files")]
mod tests;
