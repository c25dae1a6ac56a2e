//! Files in: vehicles, missions, gains, parameters and trajectories, read strictly.
//!
//! | file | holds |
//! |---|---|
//! | `mission` | `mission/*.json`: a mission in sections, a file for each |
//! | `changed` | a mission with other values of its keys, in files of its own |
//! | `derived` | what the numbers of a mission amount to |
//! | `odd` | something odd about a mission |
//! | [`draft`] | first drafts of vehicles and missions |
//! | [`foreign`] | what airframes, parameter files and Gazebo's models say of a vehicle, for drafts |
//! | `designing` | the mission file that a design makes |
//! | `estimated` | where the numbers of a file are from, as it says |
//! | `uncertain` | how far its numbers may be off, as it says |
//! | `plan_grid` | its grid of plans: what it spans, its files |
//! | `flight_table` | a flight's table: `flight.csv`, and columns of its names from elsewhere |
//! | `gains_file` | `params/gains/*.json` |
//! | `identified` | the vehicle file that an identification makes |
//! | `params_file` | PX4 parameter files |
//! | `px4_fit` | whether PX4 can fly a mission, and what it senses there |
//! | `rare_failure` | the most likely way to fail that a search found |
//! | `reader` | documents that are read after every change, to say what is wrong with it |
//! | `vehicle_file` | `params/vehicles/*.json` |
//! | `rotor_table` | the rotor table beside a vehicle |
//! | `coefficient_csv` | the coefficients of a rotor's blades beside a vehicle |
//! | [`schema`] | JSON schemas of these files |
//! | `trajectory_csv` | `trajectory.csv`, read and written |
//! | [`shipped`] | the files that the program brings along |
//! | `names` | which file a plain name means |
//! | `listed` | what can be named |
//! | `source` | a file's text, strict JSON, the place of anything refused, the hash of the inputs |
//! | [`bounded`] | files read with a bound |
//! | `number` | numbers with a range |
//! | `table` | CSV |
//!
//! A file is refused with `file:line:column`, the path of the value in the document, and what was expected
//! there. Unknown and repeated keys, numbers out of their range, NaN and text after the document are all
//! refused.

pub mod bounded;
mod changed;
mod coefficient_csv;
mod derived;
mod designing;
pub mod draft;
mod error;
mod estimated;
mod flight_table;
pub mod foreign;
mod gains_file;
mod identified;
mod listed;
mod mission;
mod names;
mod number;
mod odd;
mod overrides;
mod params_file;
mod plan_grid;
mod px4_fit;
mod rare_failure;
mod reader;
mod rotor_table;
pub mod schema;
mod set_keys;
pub mod shipped;
mod source;
mod table;
mod trajectory_csv;
mod uncertain;
mod vehicle_file;

pub use changed::changed_mission_files;
pub use derived::{Derived, DerivedGroup, DerivedRow, derived};
pub use designing::{DesignError, designed_mission_json, relative};
pub use error::ConfigError;
pub use estimated::{Estimated, Origin, OriginKind};
pub use flight_table::read_flight_table;
pub use gains_file::{GainsFile, gains_json, load_gains};
pub use identified::{IdentifiedError, IdentifiedFile, identified_file};
pub use listed::{Listed, listed_gains, listed_missions, listed_vehicles};
pub use mission::{
    CaseError, Control, Effect, Faults, Inputs, Limits, Mission, MissionText, MonteCarlo, PlanInitial,
    PlanSettings, Px4, Px4Clock, Release, Replan, Site, Study, UnfitFault, UnfitReplan, UnplannedError,
    load_mission, mission_text, parse_mission,
};
pub use names::{gains_path, mission_path, plain_name, vehicle_path};
pub use odd::Odd;
pub use overrides::Override;
pub use params_file::load_parameters;
pub use plan_grid::{
    GRID_COLUMNS, GridFileError, PlanGridFile, decode_plan_grid, encode_plan_grid, write_plan_grid_csv,
};
pub use px4_fit::{UnfitPx4, check_for_px4, check_site_for_px4, px4_receiver, px4_senses, truth_remark};
pub use rare_failure::{RareFailureFile, load_rare_failure};
pub use reader::Reader;
pub use set_keys::{SettableKey, is_of_vehicle, load_mission_with, settable_keys};
pub use source::{NamedFile, input_text};
pub use trajectory_csv::{
    Stamp, TrajectoryFile, read_trajectory_csv, trajectory_columns, write_trajectory_csv,
};
pub use vehicle_file::{BladeFile, VehicleFile, blade_file, load_vehicle};

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "tests read and spoil files")]
mod tests;
