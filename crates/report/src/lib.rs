//! Results of a run: the flight log, the verdict in words and as JSON, the figures.
//!
//! | file | holds |
//! |---|---|
//! | `flight_columns` | columns of the flight log and of a plan beside it, and the log's arrays |
//! | [`flight_csv`] | the flight log: every sample, every term of the balance of forces |
//! | [`verdict`] | the verdict for the terminal |
//! | [`plan`] | the plan for the terminal and as JSON |
//! | [`verify`] | the checks of `samara verify` |
//! | [`faults`] | the list of `samara faults` |
//! | `checked`, `odd` | what a mission amounts to, and what is odd about it |
//! | [`cut`] | work cut into parts, each with a file of its own |
//! | `columns` | numbers for people |
//! | `judged_drop` | a drop that is over, judged |
//! | [`json`] | the objects of `--json` |
//! | [`outcome`] | what a flight came to: cells of a row, keys of an object |
//! | [`paper`] | the paper's study: tables, claims, page |
//! | [`params`] | exports, checks and differences of parameter files |
//! | [`tune`] | searches of gains |
//! | [`uncertain`] | what was uncertain in each trial of a campaign |
//! | [`design`] | searches of plan and gains together |
//! | [`px4_gains`] | gains for PX4 beside its defaults |
//! | [`figure`] | SVG figures |
//! | [`mcap`] | the drop for Foxglove, Rerun and PlotJuggler |
//! | [`document`] | what a study says as a value, and what it is rendered as |
//! | [`replay`] | the page on which a drop is seen again |
//! | [`shell`] | commands as a shell reads them back |
//! | [`card`] | the release card: all evidence on one page |
//! | `shown_drop` | what figure and page show of a drop |
//! | `marks` | the instants of a drop that have names |
//! | [`plan_grid`] | grids of plans: tables, JSON |
//! | `plan_motion` | the motion along a plan, for both |
//! | [`campaign`] | campaigns of a mission's own gains: tables, page, footprint |
//! | [`drops`] | campaigns of whole drops: lines and tables |
//! | [`fidelity`] | one campaign by several ways to fly it: means, bounds |
//! | [`free_fall`] | finding the fall from the accelerometer alone: tables |
//! | [`envelope`] | the safe-release envelope: tables, edges |
//! | [`range_ends`] | numbers of a search at an end of their range |
//! | [`rare`] | probabilities of rare failures: tables, the most likely failure |
//! | [`repeats`] | one drop flown again and again: lines, the table of the spread |
//! | [`replan`] | drops along one plan and along plans that are renewed: the table |
//! | [`rows`] | the columns of a table, declared once, and what is made of them |
//! | [`schema`] | schemas of the results' objects
//! | `shard` | parts of a campaign that are flown apart: rows as Parquet, statistics (feature `shards`) |
//! | [`sobol`] | what decides a drop: Sobol's indices |
//!
//! Everything here is text made from its arguments: the same arguments give the same bytes. Wall-clock times
//! come from the caller and go to the terminal and to `--json` only, never into a file.

pub mod campaign;
pub mod card;
mod checked;
mod columns;
pub mod cut;
pub mod design;
pub mod document;
pub mod drops;
pub mod effects;
pub mod envelope;
pub mod faults;
pub mod fidelity;
pub mod figure;
mod flight_columns;
pub mod flight_csv;
pub mod free_fall;
pub mod html;
pub mod json;
mod judged_drop;
mod marks;
pub mod mcap;
mod odd;
pub mod outcome;
pub mod paper;
pub mod params;
pub mod plan;
pub mod plan_grid;
mod plan_motion;
pub mod px4_gains;
pub mod range_ends;
pub mod rare;
pub mod repeats;
pub mod replan;
pub mod replay;
pub mod rows;
pub mod schema;
#[cfg(feature = "shards")]
pub mod shard;
pub mod shell;
mod shown_drop;
pub mod sobol;
#[cfg(test)]
mod table_tests;
pub mod truth;
pub mod tune;
pub mod uncertain;
pub mod verdict;
pub mod verify;

pub use card::manifest::manifest_json;
pub use checked::{checked_json, checked_text};
pub use faults::{faults_json, faults_text};
pub use figure::{FigureError, bode_figure, convergence_figure, drop_figure, plan_figure};
pub use flight_columns::flight_arrays;
pub use flight_csv::FlightCsv;
pub use json::{DropEvent, DropRun, FlownBy, FlownFault, FlownReplan, FlownTrajectory, drop_json};
pub use judged_drop::{FlownDrop, judge_drop};
pub use mcap::{Attachment, drop_mcap};
pub use odd::odd;
pub use plan::{plan_json, plan_shortfall, plan_text};
pub use replay::drop_page;
pub use shown_drop::ShownDrop;
pub use verdict::verdict_text;
pub use verify::{verify_json, verify_text};
