//! `campaign_<name>.csv`: every trial of a campaign, its random numbers and its outcome, a line each.
//!
//! Comment lines at the top hold version, seed, hash of the inputs, controller and gains; the header row
//! names each column with its unit. They leave out the number of trials: a campaign that is broken off
//! is the beginning of a longer one, and [`parse_row`] reads back, to the bit, what [`write_row`] wrote.

use std::fmt::Write as _;

use nalgebra::Vector3;

use crate::assess::{RandomRelease, StudyEntry, StudyReference, TrialOutcome};
use crate::config::Mission;
use crate::frames::pitch;

const COLUMNS: &str = "trial,theta_0_rad,phi_rad,vn_m_s,vd_m_s,pitch_rad,pitch_rate_rad_s,j_tpf,peak_speed_m_s,\
                       peak_pitch_rad,peak_pitch_rate_rad_s,peak_roll_rad,peak_roll_rate_rad_s,vn_end_m_s,ve_end_m_s,vd_end_m_s,\
                       peak_tilt_rad,way_north_m,way_east_m,altitude_lost_m,steady_after_s";
const COLUMN_COUNT: usize = 21;

/// Name of a campaign's file.
pub fn file_name(entry: &StudyEntry) -> String {
    format!("campaign_{}.csv", entry.name)
}

/// The lines before the first trial.
pub fn header(mission: &Mission, entry: &StudyEntry) -> String {
    let stamp = mission.stamp();
    let reference = match entry.reference {
        StudyReference::Step => "target velocity as a step",
        StudyReference::Optimal => "velocity of the optimal trajectory",
    };
    let gains = entry.gains().map_or(String::new(), |gains| format!(" {:?}", gains.as_longitudinal()));
    let StudyEntry { name, gains_name, .. } = entry;
    let stamp = stamp.csv_comment();
    format!("{stamp}# campaign {name}: gains {gains_name}{gains}, {reference}\n{COLUMNS}\n")
}

/// Appends a trial's line.
pub fn write_row(text: &mut String, release: &RandomRelease, outcome: &TrialOutcome) {
    // Writing to a String cannot fail. `{:?}` is the shortest text that reads back to the same number.
    let _ = write!(text, "{}", release.trial);
    for x in numbers(release, outcome) {
        let _ = write!(text, ",{x:?}");
    }
    // Empty where the flight was never steady.
    text.push(',');
    if let Some(t_s) = outcome.steady_after_s {
        let _ = write!(text, "{t_s:?}");
    }
    text.push('\n');
}

/// The columns of a campaign's file behind the trial's number: the name, which ends in the unit, and a value
/// for each trial. Not a number: the flight was never steady.
pub fn trial_columns<'a>(
    trials: impl IntoIterator<Item = (&'a RandomRelease, &'a TrialOutcome)>,
) -> Vec<(&'static str, Vec<f64>)> {
    let mut columns: Vec<_> = columns().map(|name| (name, Vec::new())).collect();
    for (release, outcome) in trials {
        let steady_after_s = outcome.steady_after_s.unwrap_or(f64::NAN);
        let values = numbers(release, outcome).into_iter().chain([steady_after_s]);
        columns.iter_mut().zip(values).for_each(|((_, column), x)| column.push(x));
    }
    columns
}

/// Names of the columns behind the trial's number.
pub fn columns() -> impl Iterator<Item = &'static str> {
    COLUMNS.split(',').skip(1)
}

/// The numbers of a trial's line between the first and the last.
pub fn numbers(release: &RandomRelease, outcome: &TrialOutcome) -> [f64; COLUMN_COUNT - 2] {
    let state = &release.state;
    let end = &outcome.final_v_ned;
    [
        release.amplitude_rad,
        release.phase_rad,
        state.v_ned.x,
        state.v_ned.z,
        pitch(state.q_ned_from_body),
        state.omega_body.y,
        outcome.j_tpf,
        outcome.peak_speed_m_s,
        outcome.peak_pitch_rad,
        outcome.peak_pitch_rate_rad_s,
        outcome.peak_roll_rad,
        outcome.peak_roll_rate_rad_s,
        end.x,
        end.y,
        end.z,
        outcome.peak_tilt_rad,
        outcome.way_ned_m.x,
        outcome.way_ned_m.y,
        outcome.way_ned_m.z,
    ]
}

/// Why a line is not the expected trial.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RowError {
    /// The line does not consist of numbers.
    #[error("{COLUMN_COUNT} numbers are expected")]
    NotNumbers,
    /// The trial was drawn by another seed or distribution, or is out of order.
    #[error("this is not trial {0} of this mission and seed")]
    OtherTrial(u64),
}

/// Reads a trial's line (without its end) back; it must be that of `expected`.
///
/// # Errors
/// [`RowError`] when it is not.
pub fn parse_row(line: &str, expected: &RandomRelease) -> Result<TrialOutcome, RowError> {
    let (trial, rest) = line.split_once(',').ok_or(RowError::NotNumbers)?;
    let (rest, steady) = rest.rsplit_once(',').ok_or(RowError::NotNumbers)?;
    let steady: Option<Result<f64, _>> = (!steady.is_empty()).then(|| steady.parse());
    let steady_after_s = steady.transpose().map_err(|_| RowError::NotNumbers)?;
    let numbers: Result<Vec<f64>, _> = rest.split(',').map(str::parse).collect();
    let numbers = numbers.map_err(|_| RowError::NotNumbers)?;
    let outcome = outcome_of(&numbers, steady_after_s, expected)?;
    if trial.parse() == Ok(expected.trial) { Ok(outcome) } else { Err(RowError::OtherTrial(expected.trial)) }
}

/// What came of a trial, from what [`numbers`] gives of it and the time to steady flight; it must be that of
/// `expected`.
///
/// # Errors
/// [`RowError`] when it is not.
pub fn outcome_of(
    numbers: &[f64],
    steady_after_s: Option<f64>,
    expected: &RandomRelease,
) -> Result<TrialOutcome, RowError> {
    let &[
        amplitude,
        phase,
        _,
        _,
        _,
        _,
        j_tpf,
        speed,
        pitch,
        rate,
        roll,
        roll_rate,
        vn,
        ve,
        vd,
        tilt,
        way_north,
        way_east,
        way_down,
    ] = numbers
    else {
        return Err(RowError::NotNumbers);
    };
    if (amplitude, phase) != (expected.amplitude_rad, expected.phase_rad) {
        return Err(RowError::OtherTrial(expected.trial));
    }
    Ok(TrialOutcome {
        j_tpf,
        peak_speed_m_s: speed,
        peak_pitch_rad: pitch,
        peak_pitch_rate_rad_s: rate,
        peak_roll_rad: roll,
        peak_roll_rate_rad_s: roll_rate,
        final_v_ned: Vector3::new(vn, ve, vd),
        peak_tilt_rad: tilt,
        way_ned_m: Vector3::new(way_north, way_east, way_down),
        steady_after_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frames::quaternion_from_euler;
    use crate::model::rigid_body::BodyState;

    fn trial() -> (RandomRelease, TrialOutcome) {
        let state = BodyState {
            p_ned: Vector3::zeros(),
            q_ned_from_body: quaternion_from_euler(0.0, 0.1, 0.0),
            v_ned: Vector3::new(1.0 / 3.0, 0.0, 3.675),
            omega_body: Vector3::new(0.0, -0.2, 0.0),
        };
        let release = RandomRelease { trial: 41, amplitude_rad: 0.1 + 0.2, phase_rad: -3.0, state };
        let outcome = TrialOutcome {
            j_tpf: 0.55 + 1e-16,
            peak_speed_m_s: 6.6,
            peak_pitch_rad: -0.4,
            peak_pitch_rate_rad_s: -0.0,
            peak_roll_rad: 0.2,
            peak_roll_rate_rad_s: -1e-300,
            final_v_ned: Vector3::new(4.0, 1e-17, f64::INFINITY),
            peak_tilt_rad: 0.4,
            way_ned_m: Vector3::new(-0.0, 1e-7, 20.0 / 3.0),
            steady_after_s: Some(1.9),
        };
        (release, outcome)
    }

    #[test]
    fn prop_a_row_reads_back_to_the_bit() {
        let (release, outcome) = trial();
        let mut text = String::new();
        write_row(&mut text, &release, &outcome);
        assert_eq!(text.split(',').count(), COLUMN_COUNT);
        assert_eq!(COLUMNS.split(',').count(), COLUMN_COUNT);
        assert_eq!(parse_row(text.trim_end(), &release), Ok(outcome));
        let never = TrialOutcome { steady_after_s: None, ..outcome };
        text.clear();
        write_row(&mut text, &release, &never);
        assert!(text.ends_with(",\n"), "{text}");
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
