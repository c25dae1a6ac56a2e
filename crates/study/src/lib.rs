//! Studies of a mission: what flies it without a wire, what judges its designs and gains, and what is told of
//! them. A kind of study is a folder: what is flown, its document, its figure.
//!
//! | file | holds |
//! |---|---|
//! | [`jobs`] | jobs out, rows in: who flies what a study asks for |
//! | [`kind`], [`mod@settings`], [`kinds`] | what a kind of study is, its settings, all kinds |
//! | [`feature`] | what kinds have, and why one has not what it has not |
//! | [`asked`] | what was asked of a study or a campaign, as it was typed |
//! | [`controller`] | the mission's controller, made in this one place |
//! | [`checking`] | what a mission amounts to, with its plan and its loops |
//! | [`hinted`] | what to say beside a no of a mission |
//! | [`own`] | campaigns of the mission's own gains, release cases, trials by their coordinates |
//! | [`campaign`] | campaigns of a mission's own gains: tables, page, footprint |
//! | [`paper`] | the paper's study: tables, claims, page |
//! | [`distributions`] | the figure of how quantities of campaigns are distributed |
//! | [`drops`] | campaigns of whole drops: lines and tables |
//! | [`fidelity`] | one campaign by several ways to fly it: means, bounds |
//! | [`compare`] | two runs or two missions held against each other |
//! | [`effects`] | drops with and without each effect |
//! | [`envelope`] | how far from the nominal release a drop may begin and be safe |
//! | [`free_fall`] | how well the fall is found by the accelerometer alone |
//! | [`rare`] | how rare failures are, and the most likely one |
//! | [`replan`] | drops along one plan and along renewed ones |
//! | [`sobol`] | what decides a drop |
//! | [`plan_grid`] | the releases that a grid of plans spans, and what interpolated plans cost |
//! | [`first_gains`] | gains that fly a drafted mission |
//! | [`manoeuvre`] | a mission's vehicle in manoeuvres that tell what it is |
//! | [`uncertain`] | what is uncertain of a mission |
//! | [`searching`] | searches as studies: candidates out, judgements in |
//! | [`tuning`] | how gains are tuned |
//! | [`designing`] | how plan and gains are designed together |
//! | [`range_ends`] | numbers at an end of their range |
//! | `flight_parquet` | a flight's table as Parquet, read (feature `shards`) |
//! | [`cut`], `shard` | parts that are flown apart: rows as Parquet (feature `shards`) |
//! | [`card`] | the release card: all evidence on one page |
//! | [`schema`] | schemas of the results' objects |

pub mod asked;
pub mod campaign;
pub mod card;
pub mod checking;
pub mod compare;
pub mod controller;
pub mod cut;
pub mod designing;
pub mod distributions;
pub mod drops;
pub mod effects;
pub mod envelope;
pub mod feature;
pub mod fidelity;
pub mod first_gains;
#[cfg(feature = "shards")]
pub mod flight_parquet;
pub mod free_fall;
pub mod hinted;
pub mod jobs;
pub mod kind;
pub mod kinds;
pub mod manoeuvre;
pub mod own;
pub mod paper;
pub mod plan_grid;
pub mod range_ends;
pub mod rare;
pub mod replan;
pub mod schema;
pub mod searching;
pub mod settings;
#[cfg(feature = "shards")]
pub mod shard;
pub mod sobol;
#[cfg(test)]
mod table_tests;
pub mod tuning;
pub mod uncertain;
