//! One drop flown again and again: a line for each flight in a CSV file, and the table of their spread.

use super::columns::columns;
use super::json::{Head, object, text};
use super::outcome::{cell, column_names, push_cells};
use samara_core::assess::outcome::{J_TPF, STEADY_AFTER};
use samara_core::assess::repeats::{REPEAT_INSTANT_S, RepeatSpread, RepeatedFlight};
use samara_core::assess::{Quantity, Summary};
use samara_mission::Mission;

/// Quantities of a flight that are compared.
const REPEATED: [Quantity; 2] = [J_TPF, STEADY_AFTER];

/// The lines before the first flight.
pub fn repeats_header(mission: &Mission, autopilot: &str, trial: u64) -> String {
    format!(
        "{}# trial {trial} of {} by {autopilot}, gains {}; positions {REPEAT_INSTANT_S} s after t = 0\n\
         flight,{},north_m,east_m,down_m,failure\n",
        mission.stamp().csv_comment(),
        mission.name,
        mission.control.gains_name,
        column_names(&REPEATED),
    )
}

/// The line of a flight, the first of which is number 1; what it has not got is left empty.
pub fn repeats_row(number: u64, flight: Option<&RepeatedFlight>, failure: Option<&str>) -> String {
    let position = flight.and_then(|f| f.position_ned_m);
    let axis = |i: usize| cell(position.map(|p| p[i]));
    let mut line = number.to_string();
    push_cells(&mut line, flight.map(|f| &f.outcome), &REPEATED);
    let failure = failure.unwrap_or_default().replace('"', "'").replace('\n', "; ");
    format!("{line},{},{},{},\"{failure}\"\n", axis(0), axis(1), axis(2))
}

/// Keys, words and summaries of what is compared.
fn measures(spread: &RepeatSpread) -> impl Iterator<Item = (&'static str, String, Summary)> {
    let of = |quantity: Quantity| (quantity.key, quantity.head(), spread.outcomes.of(&quantity));
    let axes = [("north_m", "north, 10 s after t = 0 [m]"), ("east_m", "east [m]"), ("down_m", "down [m]")];
    let positions = axes.into_iter().zip(&spread.position_ned_m);
    let positions = positions.map(|((key, words), summary)| (key, words.to_owned(), *summary));
    REPEATED.map(of).into_iter().chain(positions)
}

/// The spread as a table.
pub fn repeats_text(mission: &Mission, autopilot: &str, trial: u64, spread: &RepeatSpread) -> String {
    const WIDTHS: [usize; 5] = [28, 10, 10, 10, 8];
    let mut out = format!(
        "trial {trial} of {}, flown {} times by {autopilot}, gains {}\n\n",
        mission.name, spread.flights, mission.control.gains_name
    );
    out += &columns(&WIDTHS, ["", "mean", "std", "range", "flights"]);
    for (_, words, s) in measures(spread) {
        let number = |x: f64| if x.is_finite() { format!("{x:.4}") } else { "-".to_owned() };
        let [mean, std, range] = [s.mean(), s.std(), s.max() - s.min()].map(number);
        out += &columns(&WIDTHS, [&*words, &mean, &std, &range, &s.count().to_string()]);
    }
    let [from_mean_cm, apart_cm] = [spread.farthest_from_mean_m, spread.farthest_apart_m].map(|m| 1e2 * m);
    out + &format!("positions at most {from_mean_cm:.2} cm from their mean, {apart_cm:.2} cm apart\n")
}

/// The spread as a JSON object; `failed`: how many flights failed.
pub fn repeats_json(
    mission: &Mission,
    autopilot: &str,
    trial: u64,
    failed: u64,
    spread: &RepeatSpread,
) -> String {
    let measures = measures(spread).map(|(name, _, s)| {
        object! {
            name: name, count: s.count(), mean: s.mean(), std: s.std(), min: s.min(), max: s.max(),
            range: s.max() - s.min(),
        }
    });
    text(&object! {
        #[serde(flatten)] head: Head::of(mission),
        autopilot: autopilot,
        gains: &mission.control.gains_name,
        trial: trial,
        failed: failed,
        measures: measures.collect::<Vec<_>>(),
        farthest_from_mean_m: spread.farthest_from_mean_m,
        farthest_apart_m: spread.farthest_apart_m,
    })
}
