//! One flight of a campaign by itself: flight log, figure and pages.

use anyhow::Context as _;
use nalgebra::Vector3;

use super::answer::Failure;
use super::args::PageArgs;
use super::conclusion::write_mcap;
use super::results::OutputFolder;
use samara::assess::{Course, Limits, VerdictBuilder};
use samara::config::Mission;
use samara::report::{DropRun, FlightCsv, ShownDrop, drop_figure, drop_page};
use samara::sim::Sample;
use samara::trajectory::Trajectory;

/// A flight of a campaign, to be looked at by itself.
pub struct AloneFlight<'a> {
    pub mission: &'a Mission,
    pub title: String,
    /// Name of the gains.
    pub gains: &'a str,
    /// The plan that was flown.
    pub plan: &'a Trajectory,
    pub samples: &'a [Sample],
    /// Limits that judge it.
    pub limits: Limits,
    /// Way from the release to t = 0, where the samples begin, NED [m].
    pub way_to_t0_ned_m: Vector3<f64>,
}

impl AloneFlight<'_> {
    /// Writes flight log, figure and pages: `<name>.csv`, `.svg`, `.html` and `.mcap`.
    pub fn write(&self, folder: &OutputFolder, name: &str, page: &PageArgs) -> Result<(), Failure> {
        let Self { mission, samples, plan, .. } = *self;
        folder.write(&format!("{name}.csv"), |out| {
            let mut csv = FlightCsv::new(out, mission, false)?;
            samples.iter().try_for_each(|sample| csv.write(sample))?;
            csv.finish().map(|_| ())
        })?;
        let mut verdict = VerdictBuilder::judging(self.limits, mission.target_v_ned)
            .along(plan)
            .after(self.way_to_t0_ned_m);
        samples.iter().for_each(|sample| verdict.observe(sample));
        let verdict = verdict.finish();
        let shown = ShownDrop {
            mission,
            title: &self.title,
            gains: self.gains,
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
}
