//! Campaigns of whole drops: a line for each in a CSV file, and the table of all.
//!
//! | file | holds |
//! |---|---|
//! | [`trial`] | what is kept of a drop, and its file |
//! | this one | lines, table and JSON of all |

pub mod repeats;
pub mod trial;

use crate::campaign::HELP;
use crate::campaign::settings::DROPS;
use crate::kind::{About, Flies};
use samara_core::assess::outcome::{QUANTITIES, Quantity, STEADY_RMS, TALLIED};
use samara_core::assess::{BlockError, BlockSummary};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::document::{Document, Grid, Passage};
use samara_report::json::{Head, object, text};
use samara_report::rows::Columns;
pub use trial::{DropTrial, TrialFile, TrialFileError};

/// Campaigns of whole drops by an autopilot, for people.
pub const ABOUT: About = About {
    name: "drops",
    manifest: "drops",
    title: "How safe whole drops by an autopilot are",
    help: HELP,
    unit: "drops",
    flies: Flies::WholeDrops,
    settings: DROPS,
    judges: Ok("no drop fails"),
    alone: Ok("K"),
    refuses: &[],
};

/// What was drawn for a drop, the columns that all its tables begin with.
pub(crate) fn drawn_columns() -> Columns<DropTrial> {
    Columns::<DropTrial>::none()
        .whole("trial", "number of the trial", |row| row.drawn.trial)
        .number("theta_0_deg", "the draw: amplitude of the swing", |row| {
            row.drawn.amplitude_rad * DEG_PER_RAD
        })
        .number("phi_deg", "the draw: phase of the swing", |row| row.drawn.phase_rad * DEG_PER_RAD)
        .number("wind_n_m_s", "the draw: wind at the release", |row| row.drawn.wind_ned_m_s.x)
        .number("wind_e_m_s", "the draw: wind at the release", |row| row.drawn.wind_ned_m_s.y)
}

/// Behind some columns those of what came of a drop, with this between the names of limits.
pub(crate) fn outcome_columns(columns: Columns<DropTrial>, between: &'static str) -> Columns<DropTrial> {
    let limits = move |row: &DropTrial| row.outcome.map(|_| row.limits_passed.join(between));
    columns
        .quantities(&QUANTITIES, |row| row.outcome.as_ref())
        .word("limits_passed", "names of the limits that were passed", limits)
        .text("failure", "why it counts as failed, if it does", |row| row.failure.clone())
}

/// The columns of a campaign's file.
pub(crate) fn columns_of(mission: &Mission) -> Columns<DropTrial> {
    const RATES: [&str; 3] = ["tip_off_p_deg_s", "tip_off_q_deg_s", "tip_off_r_deg_s"];
    const VELOCITIES: [&str; 3] = ["tip_off_vx_m_s", "tip_off_vy_m_s", "tip_off_vz_m_s"];
    const ABOUT: &str = "what the cut gave, where that is random: body rates and velocity in body axes";
    let seed = drawn_columns().whole("noise_seed", "the draw: seed of the noise", |row| row.drawn.seed);
    let columns = outcome_columns(seed, " ");
    if mission.study.monte_carlo.tip_off_sigma.is_none() {
        return columns;
    }
    let columns = columns.numbers(RATES, ABOUT, |row, i| row.drawn.tip_off.omega_body[i] * DEG_PER_RAD);
    columns.numbers(VELOCITIES, ABOUT, |row, i| row.drawn.tip_off.v_body[i])
}

/// The lines before the first trial.
pub fn header(mission: &Mission, autopilot: &str) -> String {
    let Mission { name, control, .. } = mission;
    let (stamp, columns) = (mission.stamp().csv_comment(), columns_of(mission).names());
    format!("{stamp}# drops of {name} by {autopilot}, gains {}\n{columns}\n", control.gains_name)
}

/// The line of a trial; what it has not got is left empty.
pub fn row(mission: &Mission, trial: &DropTrial) -> String {
    columns_of(mission).line(trial)
}

/// What a campaign came to.
#[derive(Clone, Debug, Default)]
pub struct DropTally {
    flown: u64,
    failures: Vec<(u64, String)>,
    summaries: [BlockSummary; TALLIED.len()],
}

impl DropTally {
    /// Takes the next trial.
    pub fn push(&mut self, trial: &DropTrial) {
        self.flown += 1;
        if let Some(failure) = &trial.failure {
            self.failures.push((trial.drawn.trial, failure.clone()));
        }
        for (quantity, summary) in TALLIED.iter().zip(&mut self.summaries) {
            summary.push(trial.outcome.as_ref().and_then(|outcome| quantity.of(outcome)));
        }
    }

    /// No trials yet, the first of which will be trial number `first`.
    pub fn from_trial(first: u64) -> Self {
        Self { summaries: std::array::from_fn(|_| BlockSummary::from_trial(first)), ..Self::default() }
    }

    /// Statistics of the quantities, and the trials that failed with their reasons.
    pub fn parts(&self) -> (&[BlockSummary], &[(u64, String)]) {
        (&self.summaries, &self.failures)
    }

    /// The tally of so many trials with such statistics and failures, as [`DropTally::parts`] gives them.
    pub fn from_parts(
        flown: u64,
        summaries: [BlockSummary; TALLIED.len()],
        failures: Vec<(u64, String)>,
    ) -> Self {
        Self { flown, failures, summaries }
    }

    /// Takes the trials of a part that follows.
    ///
    /// # Errors
    /// [`BlockError`] where it does not follow.
    pub fn append(&mut self, part: &Self) -> Result<(), BlockError> {
        for (summary, follows) in self.summaries.iter_mut().zip(&part.summaries) {
            summary.append(follows)?;
        }
        self.flown += part.flown;
        self.failures.extend_from_slice(&part.failures);
        Ok(())
    }

    /// Trials.
    pub fn flown(&self) -> u64 {
        self.flown
    }

    /// Trials that failed.
    pub fn failed(&self) -> usize {
        self.failures.len()
    }

    /// Whether a trial failed.
    pub fn any_failed(&self) -> bool {
        !self.failures.is_empty()
    }
}

/// What is said of the campaign: its numbers in a table, and each failure with its reason.
pub fn document(mission: &Mission, autopilot: &str, tally: &DropTally) -> Document {
    let done = format!(
        "{} drops of {}, flown by {autopilot}, gains {}, seed {}: {} failed",
        tally.flown,
        mission.name,
        mission.control.gains_name,
        mission.seed,
        tally.failures.len(),
    );
    let mut grid = Grid::new("Drops", ["", "mean", "std", "min", "max", "drops"]);
    for (quantity, s) in summaries(mission, tally) {
        let s = s.summary();
        let number = |x: f64| if x.is_finite() { format!("{x:.4}") } else { "-".to_owned() };
        let numbers = [s.mean(), s.std(), s.min(), s.max()].map(number);
        grid.row(&quantity.head(), numbers.into_iter().chain([s.count().to_string()]));
    }
    let failed = |(trial, why): &(u64, String)| Passage::Remark(format!("trial {trial} failed: {why}"));
    let passages = std::iter::once(Passage::Table(grid)).chain(tally.failures.iter().map(failed)).collect();
    Document::of_one(format!("Drops of {}", mission.name), done, passages)
}

/// What is told of a mission's drops: deviations from the mean velocity only where that is judged.
fn summaries<'a>(
    mission: &Mission,
    tally: &'a DropTally,
) -> impl Iterator<Item = (&'static Quantity, &'a BlockSummary)> {
    let by_the_mean = mission.limits.steady_mean_over_s.is_some();
    let all = TALLIED.iter().zip(&tally.summaries);
    all.filter(move |(quantity, _)| by_the_mean || **quantity != STEADY_RMS)
}

/// The campaign as a JSON object.
pub fn drops_json(mission: &Mission, autopilot: &str, tally: &DropTally) -> String {
    let failures = tally.failures.iter();
    let failures = failures.map(|(trial, failure)| object! { trial: trial, failure: failure });
    let measures = summaries(mission, tally).map(|(quantity, s)| {
        let s = s.summary();
        object! {
            name: quantity.key, count: s.count(), mean: s.mean(), std: s.std(), min: s.min(), max: s.max(),
        }
    });
    text(&object! {
        #[serde(flatten)] head: Head::of(mission),
        autopilot: autopilot,
        gains: &mission.control.gains_name,
        trials: tally.flown,
        failed: failures.collect::<Vec<_>>(),
        measures: measures.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests;
