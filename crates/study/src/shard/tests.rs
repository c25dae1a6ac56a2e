//! Cuts, heads, and files that are written and read.

use std::io::{Seek as _, Write as _};

use proptest::prelude::*;

use super::rows::{StudyRow, drop_rows, drop_table, study_rows, study_table};
use super::summary::SummaryRecord;
use super::*;
use crate::campaign::settings::OWN;
use crate::campaign::{CampaignSummary, TrialRecord};
use crate::drops::DropTrial;
use crate::settings::Values;
use samara_core::assess::Outcome;
use samara_mission::Mission;

fn head() -> ShardHead {
    let mission = Mission::shipped("x500_drop").unwrap();
    let mut values = Values::usual(OWN);
    values.put(OWN, "trials", "100").unwrap();
    let (_, values) = CampaignSettings::of_mission(&values, &mission).unwrap();
    ShardHead {
        asked: Asked { seed: u64::MAX, ..Asked::of("own", OWN, &values, &mission) },
        mission: "x500_drop".to_owned(),
        autopilot: None,
        autopilot_version: None,
        first: 10,
        end: 20,
    }
}

#[test]
fn another_campaign_says_what_differs() {
    let campaign = head();
    assert_eq!(campaign.check_same_campaign(&ShardHead { first: 0, end: 5, ..head() }), Ok(()));
    let why = |part: ShardHead| campaign.check_same_campaign(&part).unwrap_err().to_string();
    let asked = |asked: Asked| why(ShardHead { asked, ..head() });
    let text = asked(Asked { seed: 2, ..head().asked });
    assert_eq!(text, "this shard is of another campaign: seed 2, expected 18446744073709551615");
    let text = asked(Asked { version: "0.0.2".to_owned(), ..head().asked });
    assert!(text.contains("version of samara 0.0.2"), "{text}");
    assert!(
        why(ShardHead { autopilot: Some("px4".to_owned()), ..head() })
            .contains("autopilot px4, expected none")
    );
    let settings = [("trials", "100"), ("keep", "summary"), ("bound", "1")];
    let settings = settings.map(|(name, text)| (name.to_owned(), text.to_owned())).to_vec();
    assert!(asked(Asked { settings, ..head().asked }).contains("keep summary, expected all"));
    // A part that holds no drop knows no version.
    let of = |version: Option<&str>| ShardHead { autopilot_version: version.map(str::to_owned), ..head() };
    assert_eq!(of(None).check_same_campaign(&of(Some("v1.16.0"))), Ok(()));
    assert!(of(Some("v1.12.3")).check_same_campaign(&of(Some("v1.16.0"))).is_err());
}

pub(crate) fn written(tables: &[Table], columns: &Table) -> std::fs::File {
    let file = tempfile::tempfile().unwrap();
    let mut writer = ShardWriter::new(file.try_clone().unwrap(), columns).unwrap();
    tables.iter().for_each(|table| writer.write(table).unwrap());
    writer.finish(&head(), &["summary"]).unwrap();
    file
}

fn study_of(trials: Range<u64>) -> (Mission, Vec<StudyRow>) {
    let mission = Mission::shipped("x500_drop").unwrap();
    let releases = mission.releases();
    let row = |trial: u64| StudyRow {
        release: releases.draw(mission.seed, trial),
        outcome: Outcome {
            j_tpf: if trial == 12 { f64::INFINITY } else { 0.1 + 0.2 },
            peak_roll_rate_deg_s: 1e-300,
            way_north_m: -0.0,
            steady_after_s: (trial != 11).then_some(1.0 / 3.0),
            ..Outcome::default()
        },
        failure: (trial == 11).then(|| "never steady, \"ever\"".to_owned()),
    };
    let rows = trials.map(row).collect();
    (mission, rows)
}

/// A property: rows are read as they were written, to the last bit, campaign by campaign; so are the head and
/// a file without rows.
#[test]
fn prop_rows_are_read_as_they_were_written() {
    let (mission, rows) = study_of(10..20);
    let (first, second) = (study_table("optimal", &rows), study_table("step", &rows[2..4]));
    let reader = ShardReader::new(written(&[first, second], &study_table("", &[]))).unwrap();
    assert_eq!(
        (reader.head(), reader.summary::<Vec<String>>().unwrap()),
        (&head(), vec!["summary".to_owned()])
    );
    let draw = |trial| mission.releases().draw(mission.seed, trial);
    for (name, expected) in [("optimal", &rows[..]), ("step", &rows[2..4]), ("none", &[])] {
        let tables = reader.tables().map(|table| study_rows(&table.unwrap(), name, draw).unwrap());
        let read: Vec<_> = tables.flatten().collect();
        let expected: Vec<_> = expected.iter().map(|row| (row.release, row.outcome)).collect();
        assert_eq!(read, expected);
    }
    let other = |trial| mission.releases().draw(mission.seed + 1, trial);
    let table = reader.tables().next().unwrap().unwrap();
    assert!(study_rows(&table, "optimal", other).is_err());
    let empty = ShardReader::new(written(&[], &study_table("", &[]))).unwrap();
    assert_eq!(empty.tables().count(), 0);
}

/// A property of whole drops too: those that were never released, and those that passed limits.
#[test]
fn prop_drops_are_read_as_they_were_written() {
    let mission = Mission::shipped("x500_drop").unwrap();
    let limits_passed = ["speed", "state is not finite"].map(str::to_owned).to_vec();
    let lost = Outcome { altitude_lost_m: 0.1 + 0.2, ..Outcome::lost() };
    let drop = |trial: u64, outcome: Option<Outcome>, failure: Option<&str>| DropTrial {
        drawn: mission.draw_drop(trial),
        limits_passed: if outcome == Some(lost) { limits_passed.clone() } else { Vec::new() },
        outcome,
        failure: failure.map(str::to_owned),
    };
    let drops = [
        drop(3, Some(lost), Some("limits passed")),
        drop(4, None, Some("never released")),
        drop(
            5,
            Some(Outcome { way_north_m: 1.5, way_east_m: f64::NAN, j_tpf: 0.5, ..Outcome::default() }),
            None,
        ),
    ];
    let reader = ShardReader::new(written(&[drop_table(&drops)], &drop_table(&[]))).unwrap();
    let read: Vec<DropTrial> =
        reader.tables().flat_map(|table| drop_rows(&table.unwrap(), &mission).unwrap()).collect();
    assert_eq!(read, drops);
}

/// A property: a summary is read as it was written, of whatever trials.
#[test]
fn prop_a_summary_is_read_as_it_was_written() {
    let (mission, rows) = study_of(10..900);
    let limits = mission.limits;
    let mut summary = CampaignSummary::from_trial(10);
    for row in &rows {
        summary.push(&TrialRecord::of_flight(row.release.trial, &row.outcome, &limits));
    }
    let text = serde_json::to_string(&SummaryRecord::of(&summary)).unwrap();
    let read: SummaryRecord = serde_json::from_str(&text).unwrap();
    assert_eq!(read.summary(&(10..900)).unwrap(), summary);
    for other in [10..899, 11..900, 0..890] {
        assert!(read.summary(&other).is_err(), "{other:?}");
    }
}

fn read_all(bytes: &[u8], mission: &Mission) {
    let mut file = tempfile::tempfile().unwrap();
    file.write_all(bytes).unwrap();
    file.rewind().unwrap();
    let draw = |trial| mission.releases().draw(mission.seed, trial);
    if let Ok(reader) = ShardReader::new(file) {
        for table in reader.tables() {
            let _ = table.and_then(|table| study_rows(&table, "optimal", draw));
        }
    }
}

proptest! {
    /// Every changed byte is noticed; whoever does not look reads the file or is refused, and nothing panics.
    #[test]
    fn prop_damaged_files_are_read_or_refused(
        cut in 0.0..1.0f64,
        changes in prop::collection::vec((0.0..1.0f64, any::<u8>()), 1..4),
    ) {
        use std::io::Read as _;
        let (mission, rows) = study_of(10..14);
        let mut file = written(&[study_table("optimal", &rows)], &study_table("", &[]));
        let mut bytes = Vec::new();
        file.rewind().unwrap();
        file.read_to_end(&mut bytes).unwrap();
        let made = |bytes: &[u8]| {
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(bytes).unwrap();
            file
        };
        prop_assert!(ShardReader::checked(made(&bytes)).is_ok());
        let short = &bytes[..(cut * bytes.len() as f64) as usize];
        prop_assert!(ShardReader::new(made(short)).is_err() && ShardReader::checked(made(short)).is_err());
        let whole = bytes.clone();
        for (place, byte) in changes {
            let place = (place * bytes.len() as f64) as usize;
            bytes[place] = byte;
        }
        prop_assert_eq!(ShardReader::checked(made(&bytes)).is_ok(), bytes == whole);
        read_all(&bytes, &mission);
    }
}
