//! For the tests: the shipped files in a place where they can be spoilt, and what is said of the spoilt ones.

use std::path::{Path, PathBuf};

use super::{ConfigError, Mission, load_mission};

/// The paper's mission.
pub(super) const TITAN: &str = "mission/titan_paper.json";
/// Gains of the paper's mission.
pub(super) const OURS: &str = "params/gains/ours.json";

/// A file of the repository.
pub(super) fn shipped(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

/// The shipped missions, vehicles and gains: every file there is.
pub(super) fn shipped_files() -> Vec<String> {
    let mut files = Vec::new();
    for directory in ["mission", "params/vehicles", "params/gains"] {
        for entry in std::fs::read_dir(shipped(directory)).unwrap() {
            files.push(format!("{directory}/{}", entry.unwrap().file_name().to_str().unwrap()));
        }
    }
    files.sort();
    files
}

/// A directory with copies of them.
pub(super) fn copy() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    for file in shipped_files() {
        let to = dir.path().join(&file);
        std::fs::create_dir_all(to.parent().unwrap()).unwrap();
        std::fs::copy(shipped(&file), to).unwrap();
    }
    dir
}

/// Line and column of the character `skip` bytes after the first occurrence of `needle`.
fn place(text: &str, needle: &str, skip: usize) -> (usize, usize) {
    let at = text.find(needle).unwrap() + skip;
    let start = text[..at].rfind('\n').map_or(0, |i| i + 1);
    (text[..at].matches('\n').count() + 1, text[start..at].chars().count() + 1)
}

/// What came of loading a spoilt file.
pub(super) struct Spoilt<T> {
    text: String,
    pub(super) loaded: Result<T, ConfigError>,
}

/// Replaces the first `from` in a copy of `file` by `to`, then loads `main` (which may be another file that
/// names it).
pub(super) fn spoil<T>(
    load: impl Fn(&Path) -> Result<T, ConfigError>,
    main: &str,
    file: &str,
    from: &str,
    to: &str,
) -> Spoilt<T> {
    let dir = copy();
    let path = dir.path().join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file} has no {from}");
    let text = text.replacen(from, to, 1);
    std::fs::write(&path, &text).unwrap();
    Spoilt { loaded: load(&dir.path().join(main)), text }
}

/// The paper's mission, itself spoilt.
pub(super) fn titan(from: &str, to: &str) -> Spoilt<Mission> {
    titan_with(TITAN, from, to)
}

/// The paper's mission where a file that it goes by is spoilt.
pub(super) fn titan_with(file: &str, from: &str, to: &str) -> Spoilt<Mission> {
    spoil(load_mission, TITAN, file, from, to)
}

impl<T> Spoilt<T> {
    /// A JSON error at the place `skip` bytes after `needle`, for the value at `path`, that says `says`.
    #[track_caller]
    pub(super) fn refused_at(self, (needle, skip): (&str, usize), path: &str, says: &str) {
        let error = self.loaded.err().expect("it was accepted");
        let shown = error.to_string();
        match error {
            ConfigError::Content { file, line, column, json_path, message } => {
                assert_eq!((line, column), place(&self.text, needle, skip), "{json_path}: {message}");
                assert_eq!(json_path, path, "{message}");
                assert!(message.contains(says), "{message}");
                assert!(
                    shown.starts_with(&format!("{}:{line}:{column}: {json_path}", file.display())),
                    "{shown}"
                );
                assert!(shown.ends_with(&message), "{shown}");
            }
            other => panic!("{other}"),
        }
    }
}
