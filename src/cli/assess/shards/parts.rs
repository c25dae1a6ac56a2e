//! The parts of a campaign that are there.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use super::place::{ENDING, FOLDER, open};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::terminal::print_err;
use samara::config::Mission;
use samara::report::json::VERSION;
use samara::study::campaign::settings::CampaignSettings;
use samara::study::cut::{Cut, ranges};
use samara::study::shard::{ShardError, ShardHead, ShardReader, Table};

/// The parts of a campaign: each trial is in one of them.
pub struct Parts {
    /// The parts in order of their trials.
    pub parts: Vec<Part>,
    /// What they belong to, all trials.
    pub head: ShardHead,
    /// What was asked of the campaign.
    pub settings: CampaignSettings,
}

impl Parts {
    /// The parts of a campaign's folder, in any order.
    pub fn of(files: Vec<PathBuf>, dir: &Path) -> Result<Self, Failure> {
        let mut parts = Vec::new();
        for path in files {
            let Some(file) = open(&path)? else { continue };
            let reader = ShardReader::checked(file).with_context(|| {
                format!("{}: fly it again (`samara merge --missing` has its number)", path.display())
            });
            parts.push(Part { head: reader.bad_input()?.head().clone(), path });
        }
        parts.sort_by_key(|part| (part.head.first, part.head.end));
        let (head, settings) = check(&parts, dir)?;
        Ok(Self { parts, head, settings })
    }

    /// Refuses a mission that is not the one that was flown.
    pub fn check_mission(&self, mission: &Mission) -> Result<(), Failure> {
        let asked = &self.head.asked;
        let pairs = [
            ("seed", mission.seed.to_string(), asked.seed.to_string()),
            ("hash of the inputs", mission.inputs.hash.clone(), asked.input_hash.clone()),
        ];
        match pairs.into_iter().find(|(_, found, expected)| found != expected) {
            None => Ok(()),
            Some((what, found, expected)) => Err(Failure::input(format!(
                "{}: {what} {expected} is expected, as in the shards, found {found}: the mission that was flown is \
                 needed, from where it was flown or with --mission",
                mission.file.display()
            ))),
        }
    }
}

/// A part that is there.
pub struct Part {
    path: PathBuf,
    /// What the part belongs to.
    pub head: ShardHead,
}

impl Part {
    /// The part, to be read.
    fn reader(&self) -> Result<ShardReader, Failure> {
        let file = open(&self.path)?;
        let file = file.ok_or_else(|| Failure::input(format!("{} is gone", self.path.display())))?;
        self.named(ShardReader::new(file))
    }

    /// An error of reading, with the file's path.
    fn named<T>(&self, read: Result<T, ShardError>) -> Result<T, Failure> {
        read.with_context(|| self.path.display().to_string()).bad_input()
    }

    /// The statistics.
    pub fn summary<T: serde::de::DeserializeOwned>(&self) -> Result<T, Failure> {
        self.named(self.reader()?.summary())
    }

    /// Takes something of the part's statistics, with the file's path on an error.
    pub fn take<T>(&self, taken: Result<T, ShardError>) -> Result<T, Failure> {
        self.named(taken)
    }

    /// Does something with the rows of each row group, in their order.
    pub fn rows<T>(
        &self,
        of: impl Fn(&Table) -> Result<Vec<T>, ShardError>,
        mut each: impl FnMut(T) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        for table in self.reader()?.tables() {
            let rows = self.named(table.and_then(|table| of(&table)))?;
            rows.into_iter().try_for_each(&mut each)?;
        }
        Ok(())
    }

    /// Refuses a part that does not hold the rows that it is to hold.
    pub fn check_rows(&self, found: u64, expected: u64) -> Result<(), Failure> {
        if found == expected {
            return Ok(());
        }
        let path = self.path.display();
        Err(Failure::input(format!("{path}: {expected} rows are expected, found {found}: fly it again")))
    }
}

/// The files of the parts in a campaign's folder, in the order of their names.
pub fn files(dir: &Path) -> Result<Vec<PathBuf>, Failure> {
    let folder = dir.join(FOLDER);
    let entries = fs::read_dir(&folder).and_then(Iterator::collect::<Result<Vec<_>, _>>);
    let entries = entries.with_context(|| {
        format!("{}: shards are expected, as `samara assess --shard I/N --out` writes them", folder.display())
    });
    let paths = entries.bad_input()?.into_iter().map(|entry| entry.path());
    let ours = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.ends_with(ENDING) && !name.starts_with('.')
    };
    let mut paths: Vec<PathBuf> = paths.filter(ours).collect();
    paths.sort();
    if paths.is_empty() {
        return Err(Failure::input(format!("{}: no shard is there yet", folder.display())));
    }
    Ok(paths)
}

/// What the campaign is, of parts that are each trial once.
fn check(parts: &[Part], dir: &Path) -> Result<(ShardHead, CampaignSettings), Failure> {
    let Some(first) = parts.first() else {
        return Err(Failure::input(format!("{}: no shard is there yet", dir.display())));
    };
    let mut head = first.head.clone();
    if head.asked.version != VERSION {
        return Err(Failure::input(format!(
            "{}: a shard by samara {} is expected, found one by {}",
            first.path.display(),
            VERSION,
            head.asked.version
        )));
    }
    let mut before: Option<&Part> = None;
    let gap = |from: u64, to: u64| {
        let dir = dir.display();
        Failure::input(format!(
            "{dir}: trials {from} to {} are in no shard; `samara merge {dir} --missing` prints what is left to fly",
            to - 1
        ))
    };
    for part in parts {
        let place = || format!("{} beside {}", part.path.display(), first.path.display());
        head.check_same_campaign(&part.head).with_context(place).bad_input()?;
        if head.autopilot_version.is_none() {
            head.autopilot_version.clone_from(&part.head.autopilot_version);
        }
        let next = before.map_or(0, |before| before.head.end);
        match before {
            Some(before) if part.head.first < next => {
                return Err(Failure::input(format!(
                    "{}: its trials, {} to {}, are in {}, too: a campaign is cut one way (--shard I/N)",
                    part.path.display(),
                    part.head.first,
                    part.head.end.saturating_sub(1),
                    before.path.display()
                )));
            }
            _ if part.head.first > next => return Err(gap(next, part.head.first)),
            _ => before = Some(part),
        }
    }
    let end = before.map_or(0, |before| before.head.end);
    let settings = first.take(head.settings())?;
    if end < settings.trials {
        return Err(gap(end, settings.trials));
    }
    (head.first, head.end) = (0, settings.trials);
    Ok((head, settings))
}

/// Numbers of the parts that are not there, or not whole, as `0-3,17`.
pub fn missing(files: &[PathBuf]) -> Result<String, Failure> {
    let (mut there, mut campaign): (BTreeSet<u64>, Option<ShardHead>) = (BTreeSet::new(), None);
    let mut cut: Option<u64> = None;
    for path in files {
        let Some(shard) = number(path) else {
            return Err(Failure::input(format!(
                "{}: the name of a shard is expected, such as 00017-of-01000.parquet",
                path.display()
            )));
        };
        if let Some(of) = cut.filter(|of| *of != shard.of) {
            return Err(Failure::input(format!(
                "{}: one of {of} shards is expected beside the others, found one of {}",
                path.display(),
                shard.of
            )));
        }
        cut = Some(shard.of);
        let Some(file) = open(path)? else { continue };
        let head = match ShardReader::checked(file) {
            Ok(reader) => reader.head().clone(),
            Err(error) => {
                let why = anyhow::Error::from(error);
                print_err(&format!("samara: {}: not whole: {why:#}\n", path.display()));
                continue;
            }
        };
        if let Some(campaign) = &campaign {
            campaign.check_same_campaign(&head).with_context(|| path.display().to_string()).bad_input()?;
        }
        let trials = head.settings().with_context(|| path.display().to_string()).bad_input()?.trials;
        if head.range() != shard.range(trials) {
            return Err(Failure::input(format!("{}: its trials are not those of its name", path.display())));
        }
        there.insert(shard.part);
        campaign.get_or_insert(head);
    }
    let left: Vec<u64> = (0..cut.unwrap_or(0)).filter(|shard| !there.contains(shard)).collect();
    Ok(ranges(&left))
}

/// The part that a file is by its name.
fn number(path: &Path) -> Option<Cut> {
    Cut::of_name(path.file_name()?.to_str()?.strip_suffix(ENDING)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parts_number_is_in_its_name() {
        let of = |name: &str| number(Path::new(name)).map(|shard| (shard.part, shard.of));
        assert_eq!(of("out/00017-of-01000.parquet"), Some((17, 1000)));
        for bad in ["17-of-1000.parquet", "01000-of-01000.parquet", "00017-of-01000.csv", "x.parquet"] {
            assert_eq!(of(bad), None, "{bad}");
        }
    }
}
