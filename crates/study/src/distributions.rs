//! The figure of how quantities of several campaigns are distributed.

use samara_core::assess::outcome::Quantity;
use samara_core::assess::{Limits, Outcome};
use samara_mission::Mission;
use samara_report::document::Figure;
use samara_report::figure::{Distribution, FigureError, distribution_figure};

/// Draws the quantities of campaigns, each with its label and the outcomes of its trials; none where no trial
/// has a number. `remark` says which trials are shown.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn distributions(
    (mission, limits): (&Mission, &Limits),
    (file, remark): (&str, &str),
    quantities: &[&Quantity],
    campaigns: &[(String, Vec<Outcome>)],
) -> Result<Option<Figure>, FigureError> {
    let of = |quantity: &&Quantity| {
        let values = |(label, outcomes): &(String, Vec<Outcome>)| {
            let values = outcomes.iter().filter_map(|outcome| quantity.of(outcome)).collect();
            (label.clone(), values, outcomes.len())
        };
        Distribution {
            name: quantity.head(),
            limit: (quantity.limit)(limits),
            controllers: campaigns.iter().map(values).collect(),
        }
    };
    let measures: Vec<Distribution> = quantities.iter().map(of).collect();
    let remark = format!("{remark} A line that ends below 100 % has trials without a value.");
    distribution_of(mission, (file, &remark), &measures)
}

/// Draws distributions; none where no trial has a number. `remark` says which trials are shown.
///
/// # Errors
/// [`FigureError`] when the backend fails.
pub fn distribution_of(
    mission: &Mission,
    (file, remark): (&str, &str),
    measures: &[Distribution],
) -> Result<Option<Figure>, FigureError> {
    let title = format!("Distributions: {}", mission.name);
    match distribution_figure(&mission.stamp().csv_comment(), &title, remark, measures) {
        Ok(svg) => Ok(Some(Figure { file: file.to_owned(), caption: format!("{title}. {remark}"), svg })),
        Err(FigureError::Empty) => Ok(None),
        Err(error) => Err(error),
    }
}
