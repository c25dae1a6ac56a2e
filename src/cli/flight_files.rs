//! The files of a flight: log and figure.

use std::io::Write as _;

use anyhow::Context;

use super::mission::stamp_of;
use super::outcome::Failure;
use super::output::OutputFolder;
use samara::assess::Verdict;
use samara::config::Mission;
use samara::report::{FlightCsv, drop_figure};
use samara::sim::Sample;
use samara::trajectory::Trajectory;

/// Writes `flight.csv` and `drop.svg`; `by`: who flew it, unless it was the reference autopilot.
///
/// # Errors
/// [`Failure::BadInput`] when a file cannot be written.
pub fn write_flight(
    folder: &OutputFolder,
    mission: &Mission,
    log: &[Sample],
    plan: Option<&Trajectory>,
    verdict: Option<&Verdict>,
    by: Option<&str>,
) -> Result<(), Failure> {
    folder.write("flight.csv", |out| {
        let begin = if mission.site.ground.is_some() { FlightCsv::with_ground } else { FlightCsv::new };
        let mut csv = begin(out, mission.vehicle.rotors.len(), mission.limits.safety, &stamp_of(mission))?;
        log.iter().try_for_each(|sample| csv.write(sample))?;
        csv.finish().map(|_| ())
    })?;
    let figure = drop_figure(mission, log, plan, verdict, by).context("the figure of the drop")?;
    folder.write("drop.svg", |out| out.write_all(figure.as_bytes()))?;
    Ok(())
}
