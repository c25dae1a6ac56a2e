//! Declared columns against what is made of them: lines of CSV, rows of a shard, arrays, and docs/files.md.

use proptest::prelude::*;

use crate::campaign::campaign_csv::{StudyRow, columns, parse_row, trial_columns, write_row};
use crate::designing::report as design;
use crate::drops;
use crate::drops::repeats;
use crate::effects::report as effects;
use crate::envelope::report as envelope;
use crate::free_fall::report as free_fall;
use crate::rare::report as rare;
use crate::replan::report as replan;
use crate::sobol::report as sobol;
use crate::tuning::report as tune;
use samara_core::assess::Outcome;
use samara_core::assess::outcome::of_flights;
use samara_mission::Mission;
use samara_report::flight_columns;
use samara_report::rows::Columns;

/// A table of the page: each column with what it is; columns that are alike stand together, many of them
/// as the first and the last.
fn page_table<R>(columns: &Columns<R>) -> String {
    let mut groups: Vec<(&str, Vec<String>)> = Vec::new();
    for column in &columns.0 {
        let name = format!("`{}`", column.name);
        match groups.last_mut().filter(|(about, _)| *about == column.about) {
            Some((_, names)) => names.push(name),
            None => groups.push((column.about, vec![name])),
        }
    }
    let row = |(about, names): &(&str, Vec<String>)| {
        let shown = match &names[..] {
            [first, .., last] if names.len() > 12 => format!("{first} .. {last}"),
            names => names.join(", "),
        };
        format!("| {shown} | {about} |\n")
    };
    format!("| column | what it is |\n|---|---|\n{}", groups.iter().map(row).collect::<String>())
}

/// The tables of docs/files.md by their marks.
fn tables() -> Vec<(&'static str, String)> {
    let mut mission = Mission::shipped("titan_drop").unwrap();
    mission.study.monte_carlo.tip_off_sigma.v_body.x = 0.1;
    for name in ["x500_drop", "balloon_drop"] {
        let other = Mission::shipped(name).unwrap();
        mission.electric = mission.electric.or(other.electric);
    }
    vec![
        ("flight.csv", page_table(&flight_columns::flight_columns(&mission, true))),
        ("campaign_<name>.csv", page_table(&columns())),
        ("drops_<autopilot>_<gains>.csv", page_table(&drops::columns_of(&mission))),
        ("repeats_<autopilot>_trial_<K>.csv", page_table(&repeats::repeat_columns())),
        ("effects.csv", page_table(&effects::columns())),
        ("replan.csv", page_table(&replan::columns())),
        ("envelope.csv", page_table(&envelope::columns())),
        ("rare.csv", page_table(&rare::columns())),
        ("sobol.csv", page_table(&sobol::columns())),
        ("free_fall_releases.csv", page_table(&free_fall::release_columns())),
        ("free_fall_descents.csv", page_table(&free_fall::descent_columns())),
        ("free_fall_rules.csv", page_table(&free_fall::rule_columns())),
        ("convergence.csv", page_table(&tune::records::convergence_columns())),
        ("front.csv", page_table(&tune::records::front_columns())),
        ("design.csv", page_table(&design::convergence_columns())),
        ("design_front.csv", page_table(&design::front_columns())),
    ]
}

/// The page's tables of columns are those that are declared.
#[test]
fn the_page_of_files_has_the_columns_that_are_declared() {
    let page = include_str!("../../../docs/files.md");
    for (name, table) in tables() {
        let between = page.split_once(&format!("<!-- columns: {name} -->\n"));
        let found =
            between.and_then(|(_, rest)| rest.split_once("<!-- end -->")).map(|(found, _)| found.trim());
        assert!(found == Some(table.trim()), "docs/files.md, {name}: this is expected\n\n{table}");
    }
}

/// What a number of a file is: its bits, or none.
fn bits(outcome: &Outcome) -> Vec<Option<u64>> {
    of_flights().map(|quantity| quantity.of(outcome).map(f64::to_bits)).collect()
}

proptest! {
    /// Any row reads back to the bit, from CSV and from Parquet, and all that is made of it has the same
    /// columns in the same order.
    #[test]
    fn prop_a_row_of_any_numbers_reads_back_to_the_bit(
        trial in 0u64..1_000_000,
        numbers in prop::collection::vec(prop::num::f64::ANY, 20),
    ) {
        let mission = Mission::shipped("x500_drop").unwrap();
        let release = mission.releases().draw(mission.seed, trial);
        let mut outcome = Outcome::default();
        of_flights().zip(numbers).for_each(|(quantity, x)| quantity.put(&mut outcome, Some(x)));
        let mut line = String::new();
        write_row(&mut line, &release, &outcome);
        let read = parse_row(line.trim_end(), &release).unwrap();
        prop_assert_eq!(bits(&read), bits(&outcome));
        let names = columns().names();
        prop_assert_eq!(line.split(',').count(), names.split(',').count());
        let arrays: Vec<String> =
            trial_columns([(&release, &outcome)]).into_iter().map(|(name, _)| name.into_owned()).collect();
        prop_assert_eq!(format!("trial,{}", arrays.join(",")), &*names);
        shards_hold(&[StudyRow::new(&release, &outcome)], &names, &mission)?;
    }
}

#[cfg(not(feature = "shards"))]
fn shards_hold(_: &[StudyRow], _: &str, _: &Mission) -> Result<(), TestCaseError> {
    Ok(())
}

#[cfg(feature = "shards")]
fn shards_hold(rows: &[StudyRow], names: &str, mission: &Mission) -> Result<(), TestCaseError> {
    use crate::shard::rows::{study_rows, study_table};

    let table = study_table("optimal", rows);
    let found: Vec<&str> = table.columns.iter().map(|(name, _)| name.as_str()).collect();
    prop_assert_eq!(found.join(","), format!("campaign,{names},failure"));
    let file = crate::shard::tests::written(&[table], &study_table("", &[]));
    let reader = crate::shard::ShardReader::new(file).unwrap();
    let draw = |trial| mission.releases().draw(mission.seed, trial);
    let read: Vec<_> =
        reader.tables().flat_map(|table| study_rows(&table.unwrap(), "optimal", draw).unwrap()).collect();
    prop_assert_eq!(read.len(), rows.len());
    for ((release, outcome), row) in read.iter().zip(rows) {
        prop_assert_eq!((release, bits(outcome)), (&row.release, bits(&row.outcome)));
    }
    Ok(())
}
