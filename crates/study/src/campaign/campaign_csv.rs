//! `campaign_<name>.csv`: every trial of a campaign, its random numbers and its outcome, a line each.
//!
//! Comment lines at the top hold version, seed, hash of the inputs, controller and gains; the header row
//! names each column with its unit. They leave out the number of trials: a campaign that is broken off
//! is the beginning of a longer one, and [`parse_row`] reads back, to the bit, what [`write_row`] wrote.

use std::sync::LazyLock;

use samara_core::assess::outcome::of_flights;
use samara_core::assess::{Outcome, RandomRelease, StudyEntry, StudyReference};
use samara_core::frames::pitch;
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;
use samara_report::rows::{Arrays, Columns};

/// A flight from t = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRow {
    /// What was drawn.
    pub release: RandomRelease,
    /// What came of it.
    pub outcome: Outcome,
    /// Why it counts as failed, if it does.
    pub failure: Option<String>,
}

impl StudyRow {
    /// A flight of which nothing is known but what came of it.
    pub fn new(release: &RandomRelease, outcome: &Outcome) -> Self {
        Self { release: *release, outcome: *outcome, failure: None }
    }
}

/// Name, meaning and value of a number that was drawn.
type Drawn = (&'static str, &'static str, fn(&RandomRelease) -> f64);

/// Columns of what was drawn, and of the state at t = 0.
const DRAWN: [Drawn; 6] = [
    ("theta_0_deg", "the draw: amplitude of the swing", |release| release.amplitude_rad * DEG_PER_RAD),
    ("phi_deg", "the draw: phase of the swing", |release| release.phase_rad * DEG_PER_RAD),
    ("vn_m_s", "the state at t = 0", |release| release.state.v_ned.x),
    ("vd_m_s", "the state at t = 0", |release| release.state.v_ned.z),
    ("pitch_deg", "the state at t = 0", |release| pitch(release.state.q_ned_from_body) * DEG_PER_RAD),
    ("pitch_rate_deg_s", "the state at t = 0", |release| release.state.omega_body.y * DEG_PER_RAD),
];

static COLUMNS: LazyLock<Columns<StudyRow>> = LazyLock::new(columns);

/// The columns of a campaign's file.
pub(crate) fn columns() -> Columns<StudyRow> {
    let mut columns =
        Columns::none().whole("trial", "number of the trial", |row: &StudyRow| row.release.trial);
    for (name, about, of) in DRAWN {
        columns = columns.number(name, about, move |row| of(&row.release));
    }
    let columns = columns.quantities(of_flights(), |row| Some(&row.outcome));
    columns.checked(&["trial", "theta_0_deg", "phi_deg"]).put_quantities(|row| Some(&mut row.outcome))
}

/// Name of a campaign's file.
pub fn file_name(entry: &StudyEntry) -> String {
    format!("campaign_{}.csv", entry.name)
}

/// The lines before the first trial.
pub fn header(mission: &Mission, entry: &StudyEntry) -> String {
    let stamp = mission.stamp().csv_comment();
    let reference = match entry.reference {
        StudyReference::Step => "target velocity as a step",
        StudyReference::Optimal => "velocity of the optimal trajectory",
    };
    let gains = entry.gains().map_or(String::new(), |gains| format!(" {:?}", gains.as_longitudinal()));
    let StudyEntry { name, gains_name, .. } = entry;
    format!("{stamp}# campaign {name}: gains {gains_name}{gains}, {reference}\n{}\n", COLUMNS.names())
}

/// What was drawn for a trial, amplitude and phase of the swing [deg], and its state at t = 0: velocity north
/// and down [m/s], pitch [deg], pitch rate [deg/s].
pub fn drawn(release: &RandomRelease) -> [f64; DRAWN.len()] {
    DRAWN.map(|(.., of)| of(release))
}

/// Appends a trial's line.
pub fn write_row(text: &mut String, release: &RandomRelease, outcome: &Outcome) {
    COLUMNS.push_line(text, &StudyRow::new(release, outcome));
}

/// The columns of a campaign's file behind the trial's number: the name, which ends in the unit, and a value
/// for each trial; not a number where it has none, and a J_TPF of infinity.
pub fn trial_columns<'a>(trials: impl IntoIterator<Item = (&'a RandomRelease, &'a Outcome)>) -> Arrays {
    columns()
        .arrays(trials.into_iter().map(|(release, outcome)| StudyRow::new(release, outcome)))
        .split_off(1)
}

/// Why a line is not the expected trial.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RowError {
    /// The line does not consist of numbers.
    #[error("{} numbers are expected", COLUMNS.0.len())]
    NotNumbers,
    /// The trial was drawn by another seed or distribution, or is out of order.
    #[error("this is not trial {0} of this mission and seed")]
    OtherTrial(u64),
}

/// Reads a trial's line (without its end) back; it must be that of `expected`.
///
/// # Errors
/// [`RowError`] when it is not.
pub fn parse_row(line: &str, expected: &RandomRelease) -> Result<Outcome, RowError> {
    let mut row = StudyRow::new(expected, &Outcome::default());
    match COLUMNS.read(line, &mut row) {
        Some(true) => Ok(row.outcome),
        Some(false) => Err(RowError::OtherTrial(expected.trial)),
        None => Err(RowError::NotNumbers),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;
    use samara_core::frames::quaternion_from_euler;
    use samara_core::model::rigid_body::BodyState;
    use samara_core::uncertain::Deviations;

    fn trial() -> (RandomRelease, Outcome) {
        let state = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: quaternion_from_euler(0.0, 0.1, 0.0),
            v_ned: Vector3::new(1.0 / 3.0, 0.0, 3.675),
            omega_body: Vector3::new(0.0, -0.2, 0.0),
        };
        let release = RandomRelease {
            trial: 41,
            amplitude_rad: 0.1 + 0.2,
            phase_rad: -3.0,
            state,
            off: Deviations::default(),
        };
        let outcome = Outcome {
            j_tpf: 0.55 + 1e-16,
            peak_speed_m_s: 6.6,
            peak_pitch_deg: 0.4,
            peak_pitch_rate_deg_s: 0.0,
            peak_roll_deg: 0.2,
            peak_roll_rate_deg_s: 1e-300,
            ve_end_m_s: 1e-17,
            vd_end_m_s: f64::INFINITY,
            peak_tilt_deg: 0.4,
            way_east_m: 1e-7,
            altitude_lost_m: 20.0 / 3.0,
            steady_after_s: Some(1.9),
            ..Outcome::default()
        };
        (release, outcome)
    }

    #[test]
    fn prop_a_row_reads_back_to_the_bit() {
        let (release, outcome) = trial();
        let mut text = String::new();
        write_row(&mut text, &release, &outcome);
        assert_eq!(text.split(',').count(), COLUMNS.0.len());
        assert_eq!(parse_row(text.trim_end(), &release), Ok(outcome));
        let never = Outcome { steady_after_s: None, ..outcome };
        text.clear();
        write_row(&mut text, &release, &never);
        assert!(text.contains(",,"), "{text}");
        assert_eq!(parse_row(text.trim_end(), &release), Ok(never));
    }

    #[test]
    fn a_row_of_another_trial_or_seed_is_refused() {
        let (release, outcome) = trial();
        let mut text = String::new();
        write_row(&mut text, &release, &outcome);
        let line = text.trim_end();
        let other = RandomRelease { trial: 42, ..release };
        assert_eq!(parse_row(line, &other), Err(RowError::OtherTrial(42)));
        let other = RandomRelease { phase_rad: 3.0, ..release };
        assert_eq!(parse_row(line, &other), Err(RowError::OtherTrial(41)));
        for bad in ["", "41", &line[..line.len() - 20], &format!("{line},1"), &line.replace("6.6", "six")] {
            assert_eq!(parse_row(bad, &release), Err(RowError::NotNumbers), "{bad}");
        }
    }
}
