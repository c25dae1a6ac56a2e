//! The files of a mission's grid of plans.
//!
//! | file | holds |
//! |---|---|
//! | `binary` | `plan_grid.bin`, written and read |
//! | `csv` | `plan_grid.csv`, written |

mod binary;
mod csv;

pub use binary::{GridFileError, PlanGridFile, decode_plan_grid, encode_plan_grid};
pub use csv::{GRID_COLUMNS, write_plan_grid_csv};
