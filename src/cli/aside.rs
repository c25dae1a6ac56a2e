//! A file that is written aside, under a name of this process alone, made safe on the disk and renamed:
//! whatever ends a process, a power cut included, and however many write the same file at once, what bears
//! the file's name is whole.

use std::fs::{self, File};
use std::hash::{BuildHasher as _, RandomState};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context as _;

use super::answer::{BadInput as _, Failure};

/// Endings of what a process writes to.
const PARTIAL: &str = ".partial";
const SCRATCH: &str = ".scratch";
/// A file without a byte is another process's, not yet locked, unless it is as old as this.
const JUST_MADE: Duration = Duration::from_secs(60);

/// A file while it is written; unless it is finished, nothing remains of it.
pub struct Aside {
    partial: PathBuf,
    scratch: PathBuf,
    path: PathBuf,
    file: Option<File>,
}

impl Aside {
    /// Begins the file that is to be at `path`; what killed processes have left of it is removed.
    pub fn begin(path: &Path) -> Result<Self, Failure> {
        remove_leftovers(folder(path), Some(&name_of(path)));
        let aside = Self::new(path);
        aside.with_context(|| format!("cannot write {}", path.display())).bad_input()
    }

    /// As [`Aside::begin`], what killed processes have left being removed by [`tidy`].
    pub fn new(path: &Path) -> io::Result<Self> {
        let (folder, name) = (folder(path), name_of(path));
        let stem = format!(".{name}.{}-{:016x}", std::process::id(), RandomState::new().hash_one(0));
        let partial = folder.join(format!("{stem}{PARTIAL}"));
        let file = File::options().create_new(true).read(true).write(true).open(&partial)?;
        // Where there are no locks, leftovers stay.
        let _ = file.try_lock();
        let scratch = folder.join(format!("{stem}{SCRATCH}"));
        Ok(Self { partial, scratch, path: path.to_owned(), file: Some(file) })
    }

    /// The file, to be written. It is the one that is locked.
    pub fn file(&self) -> Result<File, Failure> {
        let file = self.file.as_ref().map(File::try_clone).transpose();
        self.named(file.and_then(|file| file.ok_or_else(|| io::ErrorKind::NotFound.into())))
    }

    /// The file, to be written and closed before it is renamed.
    pub fn taken(&mut self) -> io::Result<File> {
        self.file.take().ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    /// The name that the file gets.
    pub fn name(&self) -> String {
        name_of(&self.path)
    }

    /// Path of a folder, not made yet, for other files on the way, which goes with this file.
    pub fn scratch(&self) -> &Path {
        &self.scratch
    }

    /// An error of writing, with the file's path.
    pub fn named<T, E>(&self, written: Result<T, E>) -> Result<T, Failure>
    where
        Result<T, E>: anyhow::Context<T, E>,
    {
        written.with_context(|| format!("cannot write {}", self.path.display())).bad_input()
    }

    /// Gives what was written the file's name; a power cut may still lose it.
    pub fn rename(self) -> io::Result<()> {
        fs::rename(&self.partial, &self.path)
    }

    /// Makes what was written safe and gives it the file's name.
    pub fn finish(mut self) -> Result<(), Failure> {
        let file = self.file.take();
        let safe = file.as_ref().map_or(Ok(()), File::sync_all);
        let renamed = safe.and_then(|()| fs::rename(&self.partial, &self.path));
        self.named(renamed.and_then(|()| sync(folder(&self.path))))
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        // What was renamed is gone from here; what cannot be removed is in nobody's way.
        let _ = fs::remove_file(&self.partial);
        let _ = fs::remove_dir_all(&self.scratch);
    }
}

/// The folder that a file is in.
fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Removes what killed processes have left in a folder.
pub fn tidy(folder: &Path) {
    remove_leftovers(folder, None);
}

/// Removes what no process writes any more of a file, or of any: a lock tells. What cannot be removed is in
/// nobody's way.
fn remove_leftovers(folder: &Path, name: Option<&str>) {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()) {
        let found = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let Some(stem) = found.strip_suffix(PARTIAL) else { continue };
        let own = |rest: &str| {
            rest.rsplit_once('.').is_some_and(|(of, id)| is_an_id(id) && name.is_none_or(|name| of == name))
        };
        if !stem.strip_prefix('.').is_some_and(own) {
            continue;
        }
        let Ok(file) = File::options().read(true).write(true).open(&path) else { continue };
        let is_old = |data: &fs::Metadata| {
            data.modified().is_ok_and(|at| at.elapsed().is_ok_and(|age| age > JUST_MADE))
        };
        let begun = file.metadata().is_ok_and(|data| data.len() > 0 || is_old(&data));
        if begun && file.try_lock().is_ok() {
            let _ = fs::remove_dir_all(folder.join(format!("{stem}{SCRATCH}")));
            let _ = fs::remove_file(&path);
        }
    }
}

/// Whether a text is a process's mark of what it writes to: `<pid>-<random>`.
fn is_an_id(text: &str) -> bool {
    let random = |random: &str| random.len() == 16 && random.bytes().all(|byte| byte.is_ascii_hexdigit());
    text.split_once('-').is_some_and(|(pid, rest)| pid.parse::<u32>().is_ok() && random(rest))
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
