//! Files in: vehicles, missions, gains and trajectories, read strictly.
//!
//! | file | holds |
//! |---|---|
//! | `vehicle_file` | `params/vehicles/*.json` and the rotor table beside it |
//! | `source` | a file's text, strict JSON, the place of anything refused, the hash of the inputs |
//! | `number` | numbers with a range |
//! | `table`, `rotor_table` | CSV |
//!
//! A file is refused with `file:line:column`, the path of the value in the document, and what was expected there.
//! Unknown and repeated keys, numbers out of their range, NaN and text after the document are all refused.

mod error;
mod number;
mod rotor_table;
mod source;
mod table;
mod vehicle_file;
#[cfg(test)]
mod vehicle_tests;

pub use error::ConfigError;
pub use vehicle_file::{VehicleFile, load_vehicle};
