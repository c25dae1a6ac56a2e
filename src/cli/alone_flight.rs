//! One flight of a campaign by itself: flight log, figure and pages.

use anyhow::Context as _;

use super::answer::Failure;
use super::args::PageArgs;
use super::conclusion::write_mcap;
use super::results::OutputFolder;
use samara::assess::{Course, VerdictBuilder};
use samara::config::Mission;
use samara::report::{DropRun, FlightCsv, ShownDrop, drop_figure, drop_page};
use samara::study::kind::FlightFiles;

/// Writes a flight's log, figure and pages: `<name>.csv`, `.svg`, `.html` and `.mcap`.
pub fn write_flight(
    folder: &OutputFolder,
    mission: &Mission,
    flight: &FlightFiles,
    page: &PageArgs,
) -> Result<(), Failure> {
    let FlightFiles { name, title, gains, plan, samples, limits, way_to_t0_ned_m } = flight;
    folder.write(&format!("{name}.csv"), |out| {
        let mut csv = FlightCsv::new(out, mission, false)?;
        samples.iter().try_for_each(|sample| csv.write(sample))?;
        csv.finish().map(|_| ())
    })?;
    let mut verdict =
        VerdictBuilder::judging(*limits, mission.target_v_ned).along(plan).after(*way_to_t0_ned_m);
    samples.iter().for_each(|sample| verdict.observe(sample));
    let verdict = verdict.finish();
    let shown = ShownDrop {
        mission,
        title,
        gains,
        samples,
        plan: Some(plan),
        verdict: verdict.as_ref(),
        run: &DropRun { course: Course::WHOLE, ..DropRun::default() },
    };
    let figure = drop_figure(&shown).context("the figure of the trial")?;
    folder.write_text(&format!("{name}.svg"), &figure)?;
    if !page.no_html {
        folder.write_text(&format!("{name}.html"), &drop_page(&shown))?;
    }
    if page.mcap {
        write_mcap(folder, &format!("{name}.mcap"), &shown, false, None)?;
    }
    Ok(())
}
