//! Whatever is done to a file, reading it ends in a value or an error, never in a panic; and an error has a
//! place inside the file.

use std::path::Path;

use proptest::prelude::*;

use super::spoil::{copy, shipped_files};
use super::*;

/// What one byte may become: what JSON and CSV are made of, and what they are not.
const SPOILERS: &[u8] = b"{}[]\",:-+.eE0919 \n\\#NaItfn_\x00\xc3\xff";

fn load(file: &Path) -> Result<(), ConfigError> {
    let text = file.to_string_lossy();
    if text.contains("/mission/") {
        load_mission(file).map(|_| ())
    } else if text.contains("/gains/") {
        load_gains(file).map(|_| ())
    } else if text.ends_with(".csv") {
        let trajectory = read_trajectory_csv(file).map(|_| ());
        load_vehicle(&file.with_file_name("titan.json")).map(|_| ()).and(trajectory)
    } else {
        load_vehicle(file).map(|_| ())
    }
}

fn check(file: &Path) -> Result<(), TestCaseError> {
    let Err(error) = load(file) else { return Ok(()) };
    prop_assert!(!error.to_string().is_empty());
    if let ConfigError::Content { file, line, column, .. } = error {
        let text = std::fs::read_to_string(&file).unwrap();
        let lines: Vec<&str> = text.split('\n').collect();
        prop_assert!((1..=lines.len() + 1).contains(&line), "line {line} of {}", lines.len());
        let width = lines.get(line - 1).map_or(0, |l| l.chars().count());
        prop_assert!((1..=width + 2).contains(&column), "column {column} of {width} in line {line}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn prop_spoilt_files_never_panic(
        which in any::<prop::sample::Index>(),
        edits in prop::collection::vec(
            (any::<prop::sample::Index>(), 0..4usize, prop::sample::select(SPOILERS)),
            1..4,
        ),
    ) {
        let dir = copy();
        let files = shipped_files();
        let file = dir.path().join(&files[which.index(files.len())]);
        let mut bytes = std::fs::read(&file).unwrap();
        for (at, edit, byte) in edits {
            let at = at.index(bytes.len().max(1)).min(bytes.len().saturating_sub(1));
            match edit {
                0 if !bytes.is_empty() => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                2 if !bytes.is_empty() => { bytes.remove(at); }
                _ => bytes.truncate(at),
            }
        }
        std::fs::write(&file, &bytes).unwrap();
        check(&file)?;
    }

    #[test]
    fn prop_swapped_pieces_never_panic(
        which in any::<prop::sample::Index>(),
        cut in any::<[prop::sample::Index; 3]>(),
    ) {
        let dir = copy();
        let files = shipped_files();
        let file = dir.path().join(&files[which.index(files.len())]);
        let bytes = std::fs::read(&file).unwrap();
        let mut at = cut.map(|c| c.index(bytes.len()));
        at.sort_unstable();
        let [a, b, c] = at;
        let swapped = [&bytes[..a], &bytes[b..c], &bytes[a..b], &bytes[c..]].concat();
        std::fs::write(&file, swapped).unwrap();
        check(&file)?;
    }
}
