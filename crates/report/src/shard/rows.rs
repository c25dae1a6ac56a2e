//! The rows of a part: the columns of the campaign's CSV file, under the same names, and why a trial failed.

use super::{Column, ShardError, Table, Values};
use crate::drops::DropTrial;
use crate::study::campaign_csv::{columns, drawn, outcome_of};
use samara_core::assess::outcome::{QUANTITIES, of_flights};
use samara_core::assess::{Outcome, RandomRelease};
use samara_core::units::DEG_PER_RAD;
use samara_mission::Mission;

const CAMPAIGN: &str = "campaign";
const TRIAL: &str = "trial";
const FAILURE: &str = "failure";
const LIMITS: &str = "limits_passed";
/// Between the names of limits; no name has it.
const BETWEEN: &str = ", ";

/// A flight from t = 0 that is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRow {
    /// What was drawn.
    pub release: RandomRelease,
    /// What came of it.
    pub outcome: Outcome,
    /// Why it counts as failed, if it does.
    pub failure: Option<String>,
}

fn column(name: &str, values: Values) -> Column {
    Column { name: name.to_owned(), values }
}

/// A trial's number, as Parquet's signed integers have it.
fn signed(trial: u64) -> i64 {
    i64::try_from(trial).unwrap_or(i64::MAX)
}

/// The table of a campaign's rows.
pub fn study_table(campaign: &str, rows: &[StudyRow]) -> Table {
    let mut table = vec![
        column(CAMPAIGN, Values::Text(vec![Some(campaign.to_owned()); rows.len()])),
        column(TRIAL, Values::Whole(rows.iter().map(|row| signed(row.release.trial)).collect())),
    ];
    let mut measured: Vec<Vec<Option<f64>>> = columns().map(|_| Vec::with_capacity(rows.len())).collect();
    for StudyRow { release, outcome, .. } in rows {
        let flown = of_flights().map(|quantity| quantity.of(outcome));
        let values = drawn(release).into_iter().map(Some).chain(flown);
        measured.iter_mut().zip(values).for_each(|(column, x)| column.push(x));
    }
    table.extend(columns().zip(measured).map(|(name, values)| column(name, Values::Number(values))));
    table.push(column(FAILURE, Values::Text(rows.iter().map(|row| row.failure.clone()).collect())));
    Table { columns: table }
}

/// The rows of a campaign in a table: the number of the trial and what came of it; each must be the trial
/// that `draw` draws.
///
/// # Errors
/// [`ShardError`] where a column is missing, or a trial was drawn otherwise.
pub fn study_rows(
    table: &Table,
    campaign: &str,
    draw: impl Fn(u64) -> RandomRelease,
) -> Result<Vec<(RandomRelease, Outcome)>, ShardError> {
    let (names, trials) = (table.texts(CAMPAIGN)?, table.wholes(TRIAL)?);
    let measured = columns().map(|name| table.numbers(name)).collect::<Result<Vec<_>, _>>()?;
    let mut rows = Vec::new();
    for (row, trial) in trials.iter().enumerate() {
        if names[row].as_deref() != Some(campaign) {
            continue;
        }
        let release = draw(u64::try_from(*trial).map_err(|_| ShardError::NotAShard(TRIAL))?);
        let values: Vec<Option<f64>> = measured.iter().map(|column| column[row]).collect();
        let outcome = outcome_of(&values, &release);
        rows.push((release, outcome.map_err(|_| ShardError::NotAShard("trials of this mission and seed"))?));
    }
    Ok(rows)
}

/// Columns of what was drawn for a drop.
const DRAWN: [&str; 4] = ["theta_0_deg", "phi_deg", "wind_n_m_s", "wind_e_m_s"];
const RELEASED: &str = "released";

/// The table of drops.
pub fn drop_table(trials: &[DropTrial]) -> Table {
    let whole = |of: &dyn Fn(&DropTrial) -> i64| Values::Whole(trials.iter().map(of).collect());
    let drawn = |trial: &DropTrial| {
        let drawn = &trial.drawn;
        let (amplitude_deg, phase_deg) = (drawn.amplitude_rad * DEG_PER_RAD, drawn.phase_rad * DEG_PER_RAD);
        [amplitude_deg, phase_deg, drawn.wind_ned_m_s.x, drawn.wind_ned_m_s.y]
    };
    let mut table = vec![column(TRIAL, whole(&|trial| signed(trial.drawn.trial)))];
    for (place, name) in DRAWN.into_iter().enumerate() {
        let values = trials.iter().map(|trial| Some(drawn(trial)[place]));
        table.push(column(name, Values::Number(values.collect())));
    }
    table.push(column(RELEASED, whole(&|trial| i64::from(trial.outcome.is_some()))));
    for quantity in &QUANTITIES {
        let value = |trial: &DropTrial| quantity.of(trial.outcome.as_ref()?);
        table.push(column(quantity.key, Values::Number(trials.iter().map(value).collect())));
    }
    let limits = |trial: &DropTrial| trial.outcome.map(|_| trial.limits_passed.join(BETWEEN));
    table.push(column(LIMITS, Values::Text(trials.iter().map(limits).collect())));
    table.push(column(FAILURE, Values::Text(trials.iter().map(|trial| trial.failure.clone()).collect())));
    Table { columns: table }
}

/// The drops of a table, with what a mission draws for each.
///
/// # Errors
/// [`ShardError`] where a column is missing, or a trial was drawn otherwise.
pub fn drop_rows(table: &Table, mission: &Mission) -> Result<Vec<DropTrial>, ShardError> {
    let (trials, released) = (table.wholes(TRIAL)?, table.wholes(RELEASED)?);
    let (limits, failures) = (table.texts(LIMITS)?, table.texts(FAILURE)?);
    let amplitudes = table.numbers(DRAWN[0])?;
    let measured = QUANTITIES.iter().map(|quantity| Ok((quantity, table.numbers(quantity.key)?)));
    let measured = measured.collect::<Result<Vec<_>, ShardError>>()?;
    let mut drops = Vec::new();
    for (row, trial) in trials.iter().enumerate() {
        let trial = u64::try_from(*trial).map_err(|_| ShardError::NotAShard(TRIAL))?;
        let drawn = mission.draw_drop(trial);
        if amplitudes[row] != Some(drawn.amplitude_rad * DEG_PER_RAD) {
            return Err(ShardError::NotAShard("trials of this mission and seed"));
        }
        let outcome = (released[row] != 0).then(|| {
            let mut outcome = Outcome::default();
            measured.iter().for_each(|(quantity, values)| quantity.put(&mut outcome, values[row]));
            outcome
        });
        let passed = limits[row].as_deref().unwrap_or_default().split(BETWEEN);
        let limits_passed = passed.filter(|name| !name.is_empty()).map(str::to_owned).collect();
        drops.push(DropTrial { drawn, outcome, limits_passed, failure: failures[row].clone() });
    }
    Ok(drops)
}
