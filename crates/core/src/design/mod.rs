//! Design: a plan and the gains that fly it, searched as one.
//!
//! | file | holds |
//! |---|---|
//! | [`plan_design`] | what a design changes of the planner's problem |
//! | [`space`] | which numbers are searched, and the cube that an optimiser searches |
//! | [`settings`] | what a mission says of it |
//! | [`objective`] | what a design costs, and its bounds |
//! | [`judge`] | a design planned and flown |
//! | [`drops`] | whole drops that judge it |
//! | [`operating_point`] | rotor speeds of thrusts, energy of a plan |
//! | [`linear_loop`], [`margins`] | a sampled loop with its margins; those of a vehicle in flight |
//! | [`worst_loop`] | a loop where it keeps least to instability |
//! | [`search`] | the search, resumable to the bit |
//! | [`fresh`] | what was chosen, on flights that chose nothing |
//!
//! Each design is planned by the planner as it is, and flown by [`crate::tune::GainJudge`]. Where the planner
//! learns to do more, that is another number of [`PlanDesign`] and another coordinate of [`space`].

pub mod drops;
pub mod fresh;
pub mod judge;
pub mod linear_loop;
pub mod margins;
pub mod objective;
pub mod operating_point;
pub mod plan_design;
pub mod search;
pub mod settings;
pub mod space;
pub mod worst_loop;

pub use drops::{DrawnDrop, FlownDrop, FreshFlight, RandomDrops, Unknown, fly_drops};
pub use fresh::{CONDITIONS, Finalist, FreshPilot, FreshResults, PORTION, best_finalist, finalist_numbers};
pub use judge::{DesignFlights, DesignJudge};
pub use linear_loop::{LinearLoop, Margins};
pub use margins::{LOOPS, LoopSetting, LoopsAt, OperatingPoint, RELEASE, TARGET, loops_at};
pub use objective::{BOUNDED, DesignBounds, DesignObjective, Judgement, LeastMargins};
pub use plan_design::{PlanDesign, WEIGHT_GROUPS};
pub use search::{DesignSearch, DesignSearchSettings, Generation, TriedDesign};
pub use settings::{DesignSettings, LightTurbulence};
pub use space::{Design, DesignSpace, Range};
pub use worst_loop::{LoopPlace, WorstLoop};
