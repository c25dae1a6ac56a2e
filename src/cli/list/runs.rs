//! Results below a folder: every run that has left a manifest.

use std::cmp::Reverse;
use std::collections::{BTreeSet, VecDeque};
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::system::utc;
use samara::config::bounded::text_at_most;
use samara::study::card::manifest::{MANIFEST, RunManifest};

/// Larger files of results are not looked into [bytes].
const LARGEST: u64 = 64 << 20;
/// Folders deeper than this are not looked into.
const DEEPEST: usize = 8;
/// Most folders that are looked into.
const FOLDERS: usize = 20_000;

/// A run.
#[derive(Clone, Debug)]
pub struct Run {
    /// The folder of its results.
    pub folder: String,
    /// The verb of its manifest.
    pub verb: String,
    /// The mission; `-` where the manifest cannot be read.
    pub mission: String,
    /// The version of samara, likewise.
    pub version: String,
    /// What its results say, where they judge.
    pub verdict: Option<Verdict>,
    /// When its manifest was written.
    pub written: String,
}

/// What results say, by their key `safe` or `holds`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Whether it was safe.
    Safe(bool),
    /// Whether what was asked holds.
    Holds(bool),
}

impl Verdict {
    /// The verdict in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Safe(true) => "safe",
            Self::Safe(false) => "NOT safe",
            Self::Holds(true) => "holds",
            Self::Holds(false) => "does NOT hold",
        }
    }

    const fn holds(self) -> bool {
        match self {
            Self::Safe(yes) | Self::Holds(yes) => yes,
        }
    }
}

impl Run {
    /// The run as an object.
    pub fn object(&self) -> Value {
        json!({
            "folder": self.folder,
            "verb": self.verb,
            "mission": self.mission,
            "version": self.version,
            "verdict": self.verdict.map(Verdict::words),
            "holds": self.verdict.map(Verdict::holds),
            "written": self.written,
        })
    }
}

/// The runs below a folder, and in it, the newest first; none where there is no such folder. Links are not
/// followed.
pub fn below(folder: &Path) -> Result<Vec<Run>, Failure> {
    if !folder.exists() {
        return Ok(Vec::new());
    }
    fs::read_dir(folder)
        .with_context(|| format!("--out {}: a folder of results is expected", folder.display()))
        .bad_input()?;
    let (mut found, mut looked) = (Vec::new(), 0);
    let mut left = VecDeque::from([(folder.to_owned(), 0)]);
    while let Some((folder, depth)) = left.pop_front().filter(|_| looked < FOLDERS) {
        looked += 1;
        let entries = fs::read_dir(&folder).into_iter().flatten().filter_map(Result::ok);
        let entries: BTreeSet<PathBuf> = entries.map(|entry| entry.path()).collect();
        for path in entries {
            let Ok(there) = fs::symlink_metadata(&path) else { continue };
            if there.is_dir() && depth < DEEPEST {
                left.push_back((path, depth + 1));
            } else if there.is_file()
                && let Some(verb) =
                    path.file_name().and_then(|name| name.to_str()?.strip_suffix(MANIFEST).map(str::to_owned))
                && let Ok(modified) = there.modified()
            {
                found.push((modified, run(&folder, &path, verb, utc(modified))));
            }
        }
    }
    found.sort_by_key(|(modified, _)| Reverse(*modified));
    Ok(found.into_iter().map(|(_, run)| run).collect())
}

/// The runs in a folder itself, the newest first.
pub fn in_folder(folder: &Path) -> Result<Vec<Run>, Failure> {
    let own = folder.display().to_string();
    Ok(below(folder)?.into_iter().filter(|run| run.folder == own).collect())
}

fn run(folder: &Path, manifest: &Path, verb: String, written: String) -> Run {
    let text = text_at_most(manifest, LARGEST).unwrap_or_default();
    let read: Option<RunManifest> = serde_json::from_str(&text).ok();
    let of = |field: fn(&RunManifest) -> &str| read.as_ref().map_or("-", field).to_owned();
    Run {
        folder: folder.display().to_string(),
        verb,
        mission: of(|manifest| manifest.mission.as_str()),
        version: of(|manifest| manifest.version.as_str()),
        verdict: read.as_ref().and_then(|manifest| verdict(folder, manifest)),
        written,
    }
}

/// What is read of a result.
#[derive(Deserialize)]
struct Judged {
    safe: Option<bool>,
    holds: Option<bool>,
}

/// The verdict of the first file of the run that has one.
fn verdict(folder: &Path, manifest: &RunManifest) -> Option<Verdict> {
    let is_result = |name: &&String| name.ends_with(".json") && Path::new(name).components().count() == 1;
    manifest.files.keys().filter(is_result).find_map(|name| {
        let judged: Judged = serde_json::from_str(&text_at_most(&folder.join(name), LARGEST).ok()?).ok()?;
        judged.safe.map(Verdict::Safe).or(judged.holds.map(Verdict::Holds))
    })
}
