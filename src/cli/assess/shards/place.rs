//! Where the file of a part is. It is written under a name of this process alone, made safe on the disk and
//! renamed: whatever ends a process, and however many fly the same part, what bears the part's name is whole.

use std::fs::{self, File};
use std::hash::{BuildHasher as _, RandomState};
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::results::gone;
use crate::cli::terminal::print_err;
use samara::report::shard::{Shard, ShardError, ShardHead, ShardReader};

/// Folder of the parts within a campaign's.
pub const FOLDER: &str = "shards";
/// Endings of what a process writes to.
const PARTIAL: &str = ".partial";
const FLYING: &str = ".flying";

/// The file of a part.
pub struct Place {
    folder: PathBuf,
    name: String,
}

impl Place {
    /// The part's place in a campaign's folder, which is made.
    pub fn new(out: &Path, shard: Shard) -> Result<Self, Failure> {
        let folder = out.join(FOLDER);
        let made = fs::create_dir_all(&folder);
        made.with_context(|| format!("cannot make the folder {}", folder.display())).bad_input()?;
        Ok(Self { folder, name: shard.file_name() })
    }

    /// The file.
    pub fn path(&self) -> PathBuf {
        self.folder.join(&self.name)
    }

    /// Whether the part is there and whole. One that is cut short is not; one of another campaign is refused.
    pub fn is_whole(&self, wanted: &ShardHead) -> Result<bool, Failure> {
        let path = self.path();
        let found = match open(&path) {
            Ok(None) => return Ok(false),
            Ok(Some(reader)) => reader.head().clone(),
            Err(error) => {
                let why = anyhow::Error::from(error);
                print_err(&format!("samara: {}: not whole, flown again: {why:#}\n", path.display()));
                return Ok(false);
            }
        };
        wanted
            .check_same_campaign(&found)
            .with_context(|| {
                format!("{}: another folder (--out) is expected for another campaign", path.display())
            })
            .bad_input()?;
        if found.range() != wanted.range() {
            return Err(Failure::input(format!(
                "{}: trials {:?} are expected in this shard, found {:?}",
                path.display(),
                wanted.range(),
                found.range()
            )));
        }
        Ok(true)
    }

    /// Begins the file aside; what processes that were killed have left of it is removed.
    pub fn begin(&self) -> Result<Aside, Failure> {
        self.remove_leftovers();
        let stem = format!(".{}.{}-{:016x}", self.name, std::process::id(), RandomState::new().hash_one(0));
        let partial = self.folder.join(format!("{stem}{PARTIAL}"));
        let file = File::options().create_new(true).write(true).open(&partial);
        let file = file.with_context(|| format!("cannot write {}", partial.display())).bad_input()?;
        // Where there are no locks, leftovers stay.
        let _ = file.try_lock();
        let scratch = self.folder.join(format!("{stem}{FLYING}"));
        Ok(Aside { partial, scratch, path: self.path(), folder: self.folder.clone(), file: Some(file) })
    }

    /// Removes the files of this part that no process writes: a lock tells, and one that was just made has no
    /// byte yet. What cannot be removed is in nobody's way.
    fn remove_leftovers(&self) {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        for path in entries.map(|entry| entry.path()) {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            let own = name.strip_prefix('.').is_some_and(|name| name.starts_with(&self.name));
            let Some(stem) = name.strip_suffix(PARTIAL).filter(|_| own) else { continue };
            let Ok(file) = File::options().read(true).write(true).open(&path) else { continue };
            let begun = file.metadata().is_ok_and(|data| data.len() > 0);
            if begun && file.try_lock().is_ok() {
                let _ = fs::remove_dir_all(self.folder.join(format!("{stem}{FLYING}")));
                let _ = fs::remove_file(&path);
            }
        }
    }
}

/// The part in a file; `None` where there is none.
pub fn open(path: &Path) -> Result<Option<ShardReader>, ShardError> {
    match File::options().read(true).open(path) {
        Ok(file) => ShardReader::new(file).map(Some),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(ShardError::Parquet(e.into())),
    }
}

/// A part's file while it is written; unless it is finished, nothing remains of it.
pub struct Aside {
    partial: PathBuf,
    scratch: PathBuf,
    path: PathBuf,
    folder: PathBuf,
    file: Option<File>,
}

impl Aside {
    /// The file, to be written. It is the one that is locked.
    pub fn file(&self) -> Result<File, Failure> {
        let file = self.file.as_ref().map(File::try_clone).transpose();
        let file = file.and_then(|file| file.ok_or_else(|| io::ErrorKind::NotFound.into()));
        file.with_context(|| self.partial.display().to_string()).bad_input()
    }

    /// A folder for files of flights, which goes with this file.
    pub fn scratch(&self) -> &Path {
        &self.scratch
    }

    /// An error of writing, with the file's path.
    pub fn named<T>(&self, written: Result<T, ShardError>) -> Result<T, Failure> {
        written.with_context(|| format!("cannot write {}", self.path.display())).bad_input()
    }

    /// Makes what was written safe and gives it the part's name.
    pub fn finish(mut self) -> Result<(), Failure> {
        let file = self.file.take();
        let safe = file.as_ref().map_or(Ok(()), File::sync_all);
        let named =
            safe.and_then(|()| fs::rename(&self.partial, &self.path)).and_then(|()| sync(&self.folder));
        named.with_context(|| format!("cannot write {}", self.path.display())).bad_input()
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        // What was renamed is gone from here.
        let _ = gone(fs::remove_file(&self.partial));
        let _ = gone(fs::remove_dir_all(&self.scratch));
    }
}

/// Makes the names in a folder safe on the disk.
#[cfg(unix)]
fn sync(folder: &Path) -> io::Result<()> {
    File::options().read(true).open(folder)?.sync_all()
}

/// Names in a folder are the system's own business.
#[cfg(not(unix))]
fn sync(_folder: &Path) -> io::Result<()> {
    Ok(())
}
