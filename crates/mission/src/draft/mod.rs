//! First drafts of files: a vehicle from what a data sheet says, and a mission for it at a place. What is not
//! given is estimated, and the files say how.
//!
//! | file | holds |
//! |---|---|
//! | `vehicle` | a vehicle file from mass, frame, arm, propeller and thrust |
//! | `mission` | a mission file for a vehicle on a planet at an altitude |

mod mission;
mod vehicle;

pub use mission::{DRAFT_NODES, MissionDraft, ReleasedFrom, mission_draft_json};
pub use vehicle::{DraftThrust, Frame, FrameRotor, OnArm, VehicleDraft, vehicle_draft_json};

/// A number rounded to four significant digits: no more is known of what is estimated.
fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}
