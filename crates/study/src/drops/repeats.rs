//! One drop flown again and again: a line for each flight in a CSV file, and the table of their spread.

use samara_core::assess::outcome::{J_TPF, STEADY_AFTER};
use samara_core::assess::repeats::{REPEAT_INSTANT_S, RepeatSpread, RepeatedFlight};
use samara_core::assess::{Quantity, Summary};
use samara_mission::Mission;
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, object, text};
use samara_report::rows::Columns;

/// Quantities of a flight that are compared.
const REPEATED: [Quantity; 2] = [J_TPF, STEADY_AFTER];

/// Columns of the position, with words for people.
const AXES: [(&str, &str); 3] =
    [("north_m", "north, 10 s after t = 0 [m]"), ("east_m", "east [m]"), ("down_m", "down [m]")];

/// A flight's number, the flight, and why it failed.
type RepeatRow<'a> = (u64, Option<&'a RepeatedFlight>, Option<&'a str>);

/// The columns of the lines.
pub(crate) fn repeat_columns<'a>() -> Columns<RepeatRow<'a>> {
    let position = |(_, flight, _): &RepeatRow<'_>, i: usize| Some(flight.as_ref()?.position_ned_m?[i]);
    Columns::<RepeatRow<'_>>::none()
        .whole("flight", "number of the flight, from 1", |(number, ..)| *number)
        .quantities(&REPEATED, |(_, flight, _)| flight.map(|flight| &flight.outcome))
        .numbers(AXES.map(|(name, _)| name), "position 10 s after t = 0", position)
        .text("failure", "why it counts as failed, if it does", |(.., why)| why.map(str::to_owned))
}

/// The lines before the first flight.
pub fn repeats_header(mission: &Mission, autopilot: &str, trial: u64) -> String {
    let Mission { name, control, .. } = mission;
    let (above, gains) = (mission.stamp().csv_comment(), &control.gains_name);
    let above = format!("{above}# trial {trial} of {name} by {autopilot}, gains {gains}");
    let names = repeat_columns().names();
    format!("{above}; positions {REPEAT_INSTANT_S} s after t = 0\n{names}\n")
}

/// The line of a flight, the first of which is number 1; what it has not got is left empty.
pub fn repeats_row(number: u64, flight: Option<&RepeatedFlight>, failure: Option<&str>) -> String {
    repeat_columns().line(&(number, flight, failure))
}

/// Keys, words and summaries of what is compared.
fn measures(spread: &RepeatSpread) -> impl Iterator<Item = (&'static str, String, Summary)> {
    let of = |quantity: Quantity| (quantity.key, quantity.head(), spread.outcomes.of(&quantity));
    let positions = AXES.into_iter().zip(&spread.position_ned_m);
    let positions = positions.map(|((key, words), summary)| (key, words.to_owned(), *summary));
    REPEATED.map(of).into_iter().chain(positions)
}

/// What is said of the spread, in a table.
pub fn document(mission: &Mission, autopilot: &str, trial: u64, spread: &RepeatSpread) -> Document {
    let done = format!(
        "trial {trial} of {}, flown {} times by {autopilot}, gains {}",
        mission.name, spread.flights, mission.control.gains_name
    );
    let mut grid = Grid::new("Spread", ["", "mean", "std", "range", "flights"]);
    for (_, words, s) in measures(spread) {
        let number = |x: f64| if x.is_finite() { format!("{x:.4}") } else { "-".to_owned() };
        let numbers = [s.mean(), s.std(), s.max() - s.min()].map(number);
        grid.row(&words, numbers.into_iter().chain([s.count().to_string()]));
    }
    let [from_mean_cm, apart_cm] = [spread.farthest_from_mean_m, spread.farthest_apart_m].map(|m| 1e2 * m);
    let apart = format!("positions at most {from_mean_cm:.2} cm from their mean, {apart_cm:.2} cm apart");
    let title = format!("Trial {trial} of {}, flown again and again", mission.name);
    Document::of_one(title, done, vec![Passage::Table(grid), Passage::Remark(apart)])
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
