//! Gains for PX4: PX4's own parameters, searched within PX4's own ranges on the model of its control law.
//!
//! | file | holds |
//! |---|---|
//! | [`space`] | which parameters are searched, and within which bounds |
//! | [`judge`] | the drops that they are judged by |
//! | [`search`](mod@search) | the evolution strategy, and where it begins |
//! | [`measures`] | what a drop came to, and what that is worth beside PX4's defaults |

pub mod judge;
pub mod measures;
pub mod search;
pub mod space;

pub use judge::{
    FIXED_SCALES, LATENCY_S, Px4Drop, Px4Judge, Px4Setting, Sensing, drops, drops_from, latency_s,
};
pub use measures::{MEASURED, Measures};
pub use search::{Px4Search, Px4SearchSettings};
pub use space::{DIMENSIONS, parameters, start, widest};
