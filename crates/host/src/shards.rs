//! A study flown in shards: each round of its jobs is cut into parts, and each part's rows lie in a file of
//! their own, written by whoever flies it, anywhere. Whoever has the parts of all rounds before comes to the
//! same jobs, to the bit. A file ends in a line that tells whether it is whole.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io;
use std::sync::Mutex;

use samara_core::checksum::crc32_iso;
use samara_study::cut::Cut;
use samara_study::jobs::Numbers;

use super::kept::{push_line, rows as rows_of};

/// Ending of the name of a part's file.
pub const ENDING: &str = ".rows";

/// Where the files of parts lie.
pub trait ShardFiles {
    /// Names of all files that are there.
    ///
    /// # Errors
    /// Of reading the folder.
    fn names(&self) -> io::Result<Vec<String>>;
    /// The text of a file; `None` where there is none of this name.
    ///
    /// # Errors
    /// Of reading it.
    fn read(&self, name: &str) -> io::Result<Option<String>>;
    /// Writes a file, whole or not at all.
    ///
    /// # Errors
    /// Of writing it.
    fn write(&self, name: &str, text: &str) -> io::Result<()>;
}

/// Files in memory, by their names: for tests, and for hosts that bring the files themselves.
impl ShardFiles for Mutex<BTreeMap<String, String>> {
    fn names(&self) -> io::Result<Vec<String>> {
        Ok(self.lock().map_err(|_| poisoned())?.keys().cloned().collect())
    }

    fn read(&self, name: &str) -> io::Result<Option<String>> {
        Ok(self.lock().map_err(|_| poisoned())?.get(name).cloned())
    }

    fn write(&self, name: &str, text: &str) -> io::Result<()> {
        self.lock().map_err(|_| poisoned())?.insert(name.to_owned(), text.to_owned());
        Ok(())
    }
}

/// A thread that wrote has panicked.
fn poisoned() -> io::Error {
    io::Error::other("the files are not whole")
}

/// How a study in shards ended, where no results came of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// A part is there: flown now, or before.
    Part {
        /// Rows of all rounds before.
        after: u64,
        /// First job of the part.
        first: u64,
        /// Jobs of the part.
        jobs: u64,
        /// Name of its file.
        file: String,
        /// Whether it was flown now.
        flown: bool,
    },
    /// Parts are missing of the round that follows these rows.
    Missing {
        /// Rows of all rounds before.
        after: u64,
        /// Jobs of the round.
        jobs: u64,
        /// What the names of the round's files begin with.
        stem: String,
        /// How many parts there are to be, where one is there, of this round or one before, that tells it.
        of: Option<u64>,
        /// Numbers of those that are missing.
        parts: Vec<u64>,
    },
}

/// The parts of a study.
pub struct Shards<'a> {
    files: &'a dyn ShardFiles,
    /// The first line of each file, which stands for everything that its rows hang on.
    head: Cow<'a, str>,
    /// What the names of files of this stage of the study have behind the rows before.
    mark: String,
    /// The part that is flown here; `None`: none is.
    cut: Option<Cut>,
    /// Rows of the rounds before.
    after: u64,
    /// Names of the parts of the first stage.
    first_stage: Vec<String>,
    /// How many parts the rounds before were cut into.
    of: Option<u64>,
    /// How it ended.
    pub(crate) ended: Option<Ended>,
}

/// A round, as far as its parts are there.
pub(crate) enum RoundThere {
    /// Each row.
    Whole(Vec<Numbers>),
    /// Some parts are missing: how many parts there are to be, if that is known, and which.
    Missing(Option<u64>, Vec<u64>),
}

impl<'a> Shards<'a> {
    /// Shards whose files begin with this line, of which this one is flown here, or none.
    pub fn new(files: &'a dyn ShardFiles, head: &'a str, cut: Option<Cut>) -> Self {
        Self {
            files,
            head: head.into(),
            mark: String::new(),
            cut,
            after: 0,
            first_stage: Vec::new(),
            of: None,
            ended: None,
        }
    }

    /// Another stage of the study begins: its rows hang on this, too, and the names of its files are of it
    /// alone.
    pub(crate) fn stage(&mut self, hangs_on: &str) {
        self.head = format!("{}# {hangs_on}\n", self.head).into();
        self.mark = format!("{:08x}-", crc32_iso(self.head.as_bytes()));
    }

    /// The rows of the first stage, where another one follows, as a file keeps them from which that stage
    /// goes on.
    pub(crate) fn first_stage(&self) -> io::Result<Option<String>> {
        if self.mark.is_empty() || self.first_stage.is_empty() {
            return Ok(None);
        }
        let head = self.head.split_inclusive('\n').next().unwrap_or_default();
        let mut text = head.to_owned();
        for name in &self.first_stage {
            let part = self.files.read(name)?.unwrap_or_default();
            let rows = part.strip_prefix(head).and_then(|rows| rows.rsplit_once('#'));
            text += rows.map_or("", |(rows, _)| rows);
        }
        Ok(Some(text))
    }

    /// What the names of the files of the round at hand begin with.
    fn stem(&self) -> String {
        format!("{:09}-{}", self.after, self.mark)
    }

    /// Name of a part's file, of the round that follows the rows so far.
    fn name(&self, cut: Cut) -> String {
        format!("{}{}{ENDING}", self.stem(), cut.name())
    }

    /// The rows of a part; `None` where it is not there, or not whole.
    fn part(&self, cut: Cut, jobs: u64) -> io::Result<Option<Vec<Numbers>>> {
        let name = self.name(cut);
        let Some(text) = self.files.read(&name)? else { return Ok(None) };
        let Some(rows) = text.strip_prefix(&*self.head) else {
            let found = text.lines().next().unwrap_or_default();
            return if self.head.starts_with(&text) {
                Ok(None)
            } else {
                Err(invalid(format!(
                    "{name}: a shard of another study; expected `{}`, found `{}`: another folder (--out) is expected",
                    self.head.trim_end(),
                    samara_core::printable::printable(found)
                )))
            };
        };
        let whole =
            rows.rsplit_once('#').filter(|(rows, end)| *end == &seal(rows)[1..]).map(|(rows, _)| rows);
        let Some(rows) = whole.map(rows_of) else { return Ok(None) };
        let range = cut.range(jobs);
        Ok((rows.len() as u64 == range.end - range.start).then_some(rows))
    }

    /// The next round, as far as its parts are there.
    pub(crate) fn round(&mut self, jobs: u64) -> io::Result<RoundThere> {
        let prefix = self.stem();
        let mut parts_of = BTreeMap::<u64, Vec<u64>>::new();
        for name in self.files.names()? {
            let cut = name.strip_suffix(ENDING).and_then(|name| Cut::of_name(name.strip_prefix(&prefix)?));
            if let Some(cut) = cut {
                parts_of.entry(cut.of).or_default().push(cut.part);
            }
        }
        if parts_of.len() > 1 {
            return Err(invalid("shards of one round are cut in two ways: remove one".to_owned()));
        }
        let there = parts_of.into_keys().next();
        let of = there.or(self.cut.map(|cut| cut.of)).or(self.of);
        self.of = of;
        let Some(of) = of else { return Ok(RoundThere::Missing(None, Vec::new())) };
        let (mut rows, mut missing) = (Vec::new(), Vec::new());
        for part in 0..of {
            match self.part(Cut { part, of }, jobs)? {
                Some(some) => rows.extend(some),
                None => missing.push(part),
            }
        }
        if missing.is_empty() {
            if self.mark.is_empty() {
                let names: Vec<String> = (0..of).map(|part| self.name(Cut { part, of })).collect();
                self.first_stage.extend(names);
            }
            self.after += jobs;
            return Ok(RoundThere::Whole(rows));
        }
        match self.cut {
            Some(cut) if cut.of != of => {
                Err(invalid(format!("--shard {cut}: there are shards of {of}: one of those is expected")))
            }
            _ => Ok(RoundThere::Missing(Some(of), missing)),
        }
    }

    /// What is to be flown here of a round whose parts are missing: none where it is there, or where nothing
    /// is flown here; then it is said how the study ended.
    pub(crate) fn flown_here(&mut self, jobs: u64, of: Option<u64>, missing: Vec<u64>) -> Option<Cut> {
        let after = self.after;
        let Some(cut) = self.cut else {
            self.ended = Some(Ended::Missing { after, jobs, stem: self.stem(), of, parts: missing });
            return None;
        };
        let flown = missing.contains(&cut.part);
        self.ended = Some(self.part_ended(cut, jobs, flown));
        flown.then_some(cut)
    }

    fn part_ended(&self, cut: Cut, jobs: u64, flown: bool) -> Ended {
        let range = cut.range(jobs);
        let (first, jobs) = (range.start, range.end - range.start);
        Ended::Part { after: self.after, first, jobs, file: self.name(cut), flown }
    }

    /// Writes a part that was flown.
    pub(crate) fn write(&self, cut: Cut, rows: &[Numbers]) -> io::Result<()> {
        let mut text = String::new();
        rows.iter().for_each(|row| push_line(&mut text, row));
        let end = seal(&text);
        self.files.write(&self.name(cut), &format!("{}{text}{end}", self.head))
    }
}

/// The last line of a file, behind these rows.
fn seal(rows: &str) -> String {
    format!("# {} rows, CRC-32 {:08x}\n", rows.lines().count(), crc32_iso(rows.as_bytes()))
}

fn invalid(message: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, message)
}
