//! Results of a run: the flight log, the verdict in words and as JSON, the figures.
//!
//! | file | holds |
//! |---|---|
//! | [`flight_columns`] | columns of the flight log and of a plan beside it, and the log's arrays |
//! | [`flight_csv`] | the flight log: every sample, every term of the balance of forces |
//! | [`identified`] | what flight logs have told of a vehicle |
//! | [`manoeuvre`] | what to fly so that they tell it |
//! | [`logged_flight`] | what is in a flight log of others |
//! | [`verdict`] | the verdict for the terminal |
//! | [`plan`] | the plan for the terminal and as JSON |
//! | [`verify`] | the checks of `samara verify` |
//! | [`faults`] | the list of `samara faults` |
//! | [`columns`] | numbers for people |
//! | `judged_drop` | a drop that is over, judged |
//! | [`json`] | the objects of `--json` |
//! | [`hint`] | what causes a no, and the command for it |
//! | [`outcome`] | what a flight came to: cells of a row, keys of an object |
//! | [`params`] | exports, checks and differences of parameter files |
//! | [`uncertain`] | what was uncertain in each trial of a campaign |
//! | [`figure`] | SVG figures |
//! | [`mcap`] | the drop for Foxglove, Rerun and PlotJuggler |
//! | [`document`] | what a study says as a value, and what it is rendered as |
//! | [`replay`] | the page on which a drop is seen again |
//! | [`shell`] | commands as a shell reads them back |
//! | [`shown_drop`] | what figure and page show of a drop |
//! | `marks` | the instants of a drop that have names |
//! | `plan_motion` | the motion along a plan, for both |
//! | [`rows`] | the columns of a table, declared once, and what is made of them |
//!
//! Everything here is text made from its arguments: the same arguments give the same bytes. Wall-clock times
//! come from the caller and go to the terminal and to `--json` only, never into a file.

pub mod columns;
pub mod document;
pub mod faults;
pub mod figure;
pub mod flight_columns;
pub mod flight_csv;
pub mod hint;
pub mod html;
pub mod identified;
pub mod json;
mod judged_drop;
pub mod logged_flight;
pub mod manoeuvre;
mod marks;
pub mod mcap;
pub mod outcome;
pub mod params;
pub mod plan;
mod plan_motion;
pub mod replay;
pub mod rows;
pub mod shell;
pub mod shown_drop;
pub mod truth;
pub mod uncertain;
pub mod verdict;
pub mod verify;

pub use faults::{faults_json, faults_text};
pub use figure::{FigureError, bode_figure, drop_figure, plan_figure};
pub use flight_columns::flight_arrays;
pub use flight_csv::FlightCsv;
pub use json::{DropEvent, DropRun, FlownBy, FlownFault, FlownReplan, FlownTrajectory, drop_json};
pub use judged_drop::{FlownDrop, judge_drop};
pub use mcap::{Attachment, drop_mcap};
pub use plan::{plan_json, plan_shortfall, plan_text};
pub use replay::{drop_page, drop_page_beside};
pub use shown_drop::ShownDrop;
pub use verdict::verdict_text;
pub use verify::{verify_json, verify_text};
