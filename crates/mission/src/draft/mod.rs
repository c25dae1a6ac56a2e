//! First drafts of files: a vehicle from what a data sheet or files of other programs say, and a mission for
//! it at a place. What is not given is estimated, and the files say how.
//!
//! | file | holds |
//! |---|---|
//! | `ledger` | where each number of a draft is from |
//! | `frame` | arrangements of rotors |
//! | `vehicle` | a vehicle file from mass, rotors, propeller and thrust |
//! | `mission` | a mission file for a vehicle on a planet at an altitude |

mod frame;
mod ledger;
mod mission;
mod vehicle;

pub use frame::{Frame, FrameRotor, OnArm};
pub use mission::{DRAFT_NODES, MissionDraft, ReleasedFrom, mission_draft_json};
pub use vehicle::{
    DraftRotors, DraftThrust, VehicleDraft, mass_by_hover, needs_propeller, vehicle_draft_json,
};

/// A number rounded to four significant digits: no more is known of what is estimated.
fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// A text as JSON has it.
fn text(s: &str) -> String {
    serde_json::Value::from(s).to_string()
}
