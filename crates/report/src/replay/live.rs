//! What is shown of a flight while it flies: what is known of it beforehand, its instants as rows of numbers,
//! and what it came to; and the files of the page that shows that.

use serde::Serialize;

use super::view::{drop_data, drop_words};
use super::{PLOT_STYLE, data, served_page};
use crate::flight_columns::flight_columns;
use crate::json::object;
use crate::rows::Column;
use crate::shown_drop::{ShownDrop, air_words};
use nalgebra::Vector3;
use samara_core::assess::StateCost;
use samara_core::model::rigid_body::BodyState;
use samara_core::sim::{Phase, Sample};
use samara_core::trajectory::Trajectory;
use samara_mission::Mission;

const PAGE: &str = include_str!("live.html");
const STYLE: &str = include_str!("live.css");
const SCRIPT: &str = include_str!("bundle/live.js");
const KEYS_OF_LIVE: &str = "<dt>l</dt><dd>the newest instant, and on with the flight</dd>\n";

/// The page, which asks the program that serves it for the flight; its style and script are asked for as
/// `live.css` and `live.js`.
pub fn page() -> String {
    served_page(PAGE, KEYS_OF_LIVE)
}

/// The page's script: that of a drop's page, with three.js and uPlot, and what is beyond it.
pub fn script() -> String {
    [super::SCRIPT, SCRIPT].concat()
}

/// The page's style: that of a drop's page, and what is beyond it.
pub fn style() -> String {
    [PLOT_STYLE, super::STYLE, STYLE].concat()
}

/// What is known of a flight beforehand: its mission, its plan, where that is known, and the names of the
/// numbers in its rows.
pub fn about(mission: &Mission, plan: Option<&Trajectory>, columns: &[String]) -> impl Serialize {
    let gains = &mission.control.gains_name;
    object! {
        #[serde(flatten)] about: data::about(mission, gains),
        columns: columns.to_vec(),
        facts: format!("Vehicle {}, gains {gains}, {}.", mission.vehicle_name, air_words(&mission.site)),
        // From where the rotors are freed, which is not known yet.
        plan: plan.map(|plan| data::plan_from(mission, plan, Vector3::zeros())),
    }
}

/// What a flight came to: all that a drop's page shows of it.
pub fn end(drop: &ShownDrop<'_>, is_safe: bool) -> impl Serialize {
    // Data that was just written is read.
    let data: Option<serde_json::Value> = serde_json::from_str(&drop_data(drop)).ok();
    object! { drop: data, words: drop_words(drop), safe: drop.verdict.map(|_| is_safe) }
}

/// The name of the column of the phase, a number here: 0 hanging, 1 falling, 2 powered.
const PHASE: &str = "phase";

/// The rows of a flight that is simulated: those columns of its log that are shown.
pub struct SimulatedRows(Vec<Column<Sample>>);

impl SimulatedRows {
    /// The rows of a mission's flight.
    pub fn new(mission: &Mission) -> Self {
        let is_shown = |name: &str| name == "t_powered_s" || data::is_shown(name);
        let columns = flight_columns(mission, false).0;
        Self(columns.into_iter().filter(|column| is_shown(&column.name)).collect())
    }

    /// The names of the numbers.
    pub fn names(&self) -> Vec<String> {
        self.0.iter().map(|column| column.name.to_string()).collect()
    }

    /// The numbers of an instant; not a number: there is none.
    pub fn row(&self, sample: &Sample) -> Vec<f64> {
        let number = |column: &Column<Sample>| match &*column.name {
            PHASE => f64::from(sample.phase as u8),
            _ => column.number(sample).unwrap_or(f64::NAN),
        };
        self.0.iter().map(number).collect()
    }
}

/// The names of the numbers in a row of a flight that is known by telemetry alone.
const TOLD: [&str; 17] = [
    "t_s",
    "t_powered_s",
    PHASE,
    "north_m",
    "east_m",
    "down_m",
    "q0",
    "q1",
    "q2",
    "q3",
    "vn_m_s",
    "ve_m_s",
    "vd_m_s",
    "p_rad_s",
    "q_rad_s",
    "r_rad_s",
    "j_state",
];

/// The rows of a flight that is known by telemetry alone.
#[derive(Debug)]
pub struct ToldRows;

impl ToldRows {
    /// The names of the numbers.
    pub fn names() -> Vec<String> {
        TOLD.map(str::to_owned).to_vec()
    }

    /// The numbers of an instant `t_s` [s] of a mission's vehicle that was cut loose at `released_s` [s], if
    /// it was: its rotors are free after the mission's delay.
    pub fn row(mission: &Mission, t_s: f64, released_s: Option<f64>, body: &BodyState) -> Vec<f64> {
        let powered_s = released_s.map(|at_s| t_s - at_s - mission.release.parachute.delay_s);
        let phase = match (powered_s, released_s) {
            (Some(powered_s), _) if powered_s >= 0.0 => Phase::Powered,
            (_, Some(at_s)) if t_s >= at_s => Phase::Falling,
            _ => Phase::Hanging,
        };
        let mut row = vec![t_s, powered_s.unwrap_or(f64::NAN), f64::from(phase as u8)];
        row.extend(&body.p_ned);
        row.extend(body.q_ned_from_body);
        row.extend(&body.v_ned);
        row.extend(&body.omega_body);
        row.push(StateCost::of(body, &mission.limits.safety).max());
        row
    }
}
