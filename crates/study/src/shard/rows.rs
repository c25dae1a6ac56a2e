//! The rows of a part: the columns of the campaign's CSV file, under the same names, and why a trial failed.

use super::{ShardError, Table, Values};
pub use crate::campaign::campaign_csv::StudyRow;
use crate::campaign::campaign_csv::columns;
use crate::drops::{DropTrial, drawn_columns, outcome_columns};
use samara_core::assess::{Outcome, RandomRelease};
use samara_mission::Mission;
use samara_report::rows::{Columns, Found, Value};

const CAMPAIGN: &str = "campaign";
const TRIAL: &str = "trial";

impl Table {
    /// Rows as a table.
    fn of<R>(all: &Columns<R>, rows: &[R]) -> Self {
        // A whole number as Parquet's signed integers have it.
        let signed = |n: u64| i64::try_from(n).unwrap_or(i64::MAX);
        let values = |value: &Value<R>| match value {
            Value::Number(of) => {
                Values::Number(rows.iter().map(|row| of(row).filter(|x| x.is_finite())).collect())
            }
            Value::Whole(of) => Values::Whole(rows.iter().map(|row| signed(of(row))).collect()),
            Value::Text(of, _) => Values::Text(rows.iter().map(of).collect()),
        };
        Self { columns: all.0.iter().map(|of| (of.name.to_string(), values(&of.value))).collect() }
    }

    /// Rows with what stands in the table; each begins as `begin` makes it of its place and its trial's
    /// number, unless that is none.
    fn rows_of<R>(
        &self,
        all: &Columns<R>,
        begin: impl Fn(usize, u64) -> Option<R>,
    ) -> Result<Vec<R>, ShardError> {
        let columns = all.0.iter().map(|column| Ok((column, self.column(&column.name)?)));
        let columns = columns.collect::<Result<Vec<_>, ShardError>>()?;
        let whole = |n: i64, name: &str| u64::try_from(n).map_err(|_| ShardError::NotAShard(name.to_owned()));
        let mut rows = Vec::new();
        for (place, trial) in self.wholes(TRIAL)?.iter().enumerate() {
            let Some(mut row) = begin(place, whole(*trial, TRIAL)?) else { continue };
            for (column, values) in &columns {
                let found = match (&column.value, values) {
                    (Value::Number(_), Values::Number(values)) => Found::Number(values[place]),
                    (Value::Whole(_), Values::Whole(values)) => {
                        Found::Whole(whole(values[place], &column.name)?)
                    }
                    (Value::Text(..), Values::Text(values)) => Found::Text(values[place].as_deref()),
                    _ => return Err(ShardError::NotAShard(column.name.to_string())),
                };
                if !column.take(&mut row, found) {
                    return Err(ShardError::NotAShard("trials of this mission and seed".into()));
                }
            }
            rows.push(row);
        }
        Ok(rows)
    }
}

/// The columns of a campaign's rows behind its name.
fn study_columns() -> Columns<StudyRow> {
    columns().text("failure", "why it counts as failed", |row| row.failure.clone())
}

/// The table of a campaign's rows.
pub fn study_table(campaign: &str, rows: &[StudyRow]) -> Table {
    let mut table = Table::of(&study_columns(), rows);
    let values = Values::Text(vec![Some(campaign.to_owned()); rows.len()]);
    table.columns.insert(0, (CAMPAIGN.to_owned(), values));
    table
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
    let names = table.texts(CAMPAIGN)?;
    let rows = table.rows_of(&study_columns(), |place, trial| {
        let ours = names[place].as_deref() == Some(campaign);
        ours.then(|| StudyRow::new(&draw(trial), &Outcome::default()))
    });
    Ok(rows?.into_iter().map(|row| (row.release, row.outcome)).collect())
}

/// Between the names of limits; no name has it.
const BETWEEN: &str = ", ";

/// The columns of drops, and how they are read back.
fn drop_columns() -> Columns<DropTrial> {
    let drawn = drawn_columns().flag("released", "whether it was released", |row| row.outcome.is_some());
    outcome_columns(drawn, BETWEEN)
        .checked(&["theta_0_deg"])
        .put("released", |row, found| row.outcome = (found != Found::Whole(0)).then(Outcome::default))
        .put_quantities(|row| row.outcome.as_mut())
        .put("limits_passed", |row, found| {
            let names = found.text().unwrap_or_default().split(BETWEEN).filter(|name| !name.is_empty());
            row.limits_passed = names.map(str::to_owned).collect();
        })
        .put("failure", |row, found| row.failure = found.text().map(str::to_owned))
}

/// The table of drops.
pub fn drop_table(trials: &[DropTrial]) -> Table {
    Table::of(&drop_columns(), trials)
}

/// The drops of a table, with what a mission draws for each.
///
/// # Errors
/// [`ShardError`] where a column is missing, or a trial was drawn otherwise.
pub fn drop_rows(table: &Table, mission: &Mission) -> Result<Vec<DropTrial>, ShardError> {
    table.rows_of(&drop_columns(), |_, trial| Some(DropTrial::drawn(mission.draw_drop(trial))))
}
