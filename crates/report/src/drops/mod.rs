//! Campaigns of whole drops: a line for each in a CSV file, and the table of all.
//!
//! | file | holds |
//! |---|---|
//! | [`trial`] | what is kept of a drop, and its file |
//! | this one | lines, table and JSON of all |

pub mod trial;

use std::fmt::Write as _;

use crate::columns::columns;
use crate::json::{Head, object, text};
use crate::outcome::{column_names, push_cells};
use samara_core::assess::outcome::{QUANTITIES, TALLIED};
use samara_core::assess::{BlockError, BlockSummary, RandomDrop};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
pub use trial::{DropTrial, TrialFile, TrialFileError};

const DRAWN: &str = "trial,theta_0_deg,phi_deg,wind_n_m_s,wind_e_m_s,noise_seed";

/// Columns of what the cut gave the vehicle, where that is random.
const TIP_OFF: &str =
    ",tip_off_p_deg_s,tip_off_q_deg_s,tip_off_r_deg_s,tip_off_vx_m_s,tip_off_vy_m_s,tip_off_vz_m_s";

/// The lines before the first trial.
pub fn header(mission: &Mission, autopilot: &str) -> String {
    format!(
        "{}# drops of {} by {autopilot}, gains {}\n{DRAWN},{},limits_passed,failure{}\n",
        mission.stamp().csv_comment(),
        mission.name,
        mission.control.gains_name,
        column_names(&QUANTITIES),
        if mission.study.monte_carlo.tip_off_sigma.is_none() { "" } else { TIP_OFF },
    )
}

/// The line of a trial; what it has not got is left empty.
pub fn row(mission: &Mission, trial: &DropTrial) -> String {
    let RandomDrop { trial: number, amplitude_rad, phase_rad, wind_ned_m_s: wind, tip_off, seed } =
        &trial.drawn;
    let (amplitude_deg, phase_deg) = (amplitude_rad * DEG_PER_RAD, phase_rad * DEG_PER_RAD);
    let mut line = format!("{number},{amplitude_deg:?},{phase_deg:?},{:?},{:?},{seed}", wind.x, wind.y);
    push_cells(&mut line, trial.outcome.as_ref(), &QUANTITIES);
    let limits = trial.limits_passed.join(" ");
    let failure = trial.failure.as_deref().unwrap_or_default().replace('"', "'").replace('\n', "; ");
    // Writing to a String cannot fail.
    let _ = write!(line, ",{limits},\"{failure}\"");
    if !mission.study.monte_carlo.tip_off_sigma.is_none() {
        let rates = tip_off.omega_body.iter().map(|rate| rate * DEG_PER_RAD);
        rates.chain(tip_off.v_body.iter().copied()).for_each(|x| {
            let _ = write!(line, ",{x:?}");
        });
    }
    line.push('\n');
    line
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

/// The campaign as a table, and each failure with its reason.
pub fn drops_text(mission: &Mission, autopilot: &str, tally: &DropTally) -> String {
    const WIDTHS: [usize; 6] = [35, 9, 9, 9, 9, 6];
    let mut out = format!(
        "{} drops of {}, flown by {autopilot}, gains {}, seed {}: {} failed\n\n",
        tally.flown,
        mission.name,
        mission.control.gains_name,
        mission.seed,
        tally.failures.len(),
    );
    out += &columns(&WIDTHS, ["", "mean", "std", "min", "max", "drops"]);
    for (quantity, s) in TALLIED.iter().zip(tally.summaries.iter().map(BlockSummary::summary)) {
        let number = |x: f64| if x.is_finite() { format!("{x:.4}") } else { "-".to_owned() };
        let [mean, std, min, max] = [s.mean(), s.std(), s.min(), s.max()].map(number);
        out += &columns(&WIDTHS, [&*quantity.head(), &mean, &std, &min, &max, &s.count().to_string()]);
    }
    for (trial, failure) in &tally.failures {
        let _ = writeln!(out, "trial {trial} failed: {failure}");
    }
    out
}

/// The campaign as a JSON object.
pub fn drops_json(mission: &Mission, autopilot: &str, tally: &DropTally) -> String {
    let failures = tally.failures.iter();
    let failures = failures.map(|(trial, failure)| object! { trial: trial, failure: failure });
    let measures = TALLIED.iter().zip(&tally.summaries).map(|(quantity, s)| {
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
