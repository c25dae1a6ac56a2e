//! The locks of a folder of results: a run owns its folder while it writes.
//!
//! The simulator and the autopilot of one drop, each a process of its own, write different files into one
//! folder: each has its lock, and every other verb takes both. The system lets go of a lock whose process
//! ends, however it ends; the file of one that was killed stays until the next run takes it.

use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::terminal::print_err;

/// What of a folder is a run's own while it writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Owned {
    /// All of it.
    Whole,
    /// The files of a simulator: an autopilot may write its own.
    Simulator,
    /// The files of an autopilot: a simulator may write its own.
    Autopilot,
}

impl Owned {
    fn locks(self) -> &'static [&'static str] {
        match self {
            Self::Whole => &[".simulator.lock", ".autopilot.lock"],
            Self::Simulator => &[".simulator.lock"],
            Self::Autopilot => &[".autopilot.lock"],
        }
    }
}

/// The verb that waits for another one of its kind.
pub const MERGE: &str = "merge";
/// Longest text of a lock that is shown [bytes].
const TEXT_MOST: u64 = 200;

/// A lock that is held until it is dropped, and then gone.
#[derive(Debug)]
pub struct FolderLock {
    file: File,
    path: PathBuf,
}

impl FolderLock {
    /// Takes the locks of a folder; where another run has one, the refusal names that run. Where the file
    /// system has no locks there are none.
    pub fn take(folder: &Path, owned: Owned, verb: &str) -> Result<Vec<Self>, Failure> {
        owned.locks().iter().filter_map(|name| Self::one(folder, name, verb).transpose()).collect()
    }

    fn one(folder: &Path, name: &str, verb: &str) -> Result<Option<Self>, Failure> {
        let path = folder.join(name);
        let cannot = || format!("cannot write {}", path.display());
        loop {
            let opened = open(&path);
            let mut file = opened.with_context(cannot).bad_input()?;
            match file.try_lock() {
                Ok(()) => {}
                // What a driver that was killed has begun comes to its end, and the next one merges again.
                Err(TryLockError::WouldBlock) if verb == MERGE && holder(&mut file).contains(MERGE) => {
                    print_err(&format!("samara: {}: waits for {}\n", folder.display(), holder(&mut file)));
                    file.lock().with_context(cannot).bad_input()?;
                }
                Err(TryLockError::WouldBlock) => return Err(taken(folder, &mut file)),
                Err(TryLockError::Error(_)) => return Ok(None),
            }
            // The one who had it may have removed the file between opening and locking it.
            if is_at(&file, &path) {
                // For whoever is refused; the lock holds without it.
                let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| {
                    write!(file, "process {}, `samara {}`", std::process::id(), verb.replace('_', " "))
                });
                return Ok(Some(Self { file, path }));
            }
        }
    }
}

/// Removed where others look again whether what they have locked is still there.
impl Drop for FolderLock {
    fn drop(&mut self) {
        // Not another run's, who has made the folder anew.
        if cfg!(unix) && is_at(&self.file, &self.path) {
            let _ = std::fs::remove_file(&self.path);
        }
        let _ = self.file.unlock();
    }
}

/// Opens the file of a lock; a link that somebody has put there is not followed.
fn open(path: &Path) -> io::Result<File> {
    let mut options = File::options();
    options.create(true).truncate(false).read(true).write(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt as _;
        options.custom_flags(i32::try_from(rustix::fs::OFlags::NOFOLLOW.bits()).unwrap_or_default());
    }
    options.open(path)
}

/// Whether a file that was opened is the one at the path.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let number = |data: std::fs::Metadata| (data.dev(), data.ino());
    let there = std::fs::symlink_metadata(path).map(number);
    matches!((file.metadata().map(number), there), (Ok(opened), Ok(there)) if opened == there)
}

#[cfg(not(unix))]
fn is_at(_file: &File, _path: &Path) -> bool {
    true
}

/// The run that has a lock, in words.
fn holder(file: &mut File) -> String {
    let mut text = String::new();
    let read = file.rewind().and_then(|()| file.take(TEXT_MOST).read_to_string(&mut text));
    if read.is_ok() && !text.is_empty() { text } else { "another run of samara".to_owned() }
}

/// The refusal, which names who has the lock, and since when.
fn taken(folder: &Path, file: &mut File) -> Failure {
    let who = holder(file);
    let since = file.metadata().and_then(|data| data.modified()).ok().and_then(|at| at.elapsed().ok());
    let since = since.map_or_else(String::new, |age| format!(", begun {} s ago,", age.as_secs()));
    Failure::input(format!(
        "{}: {who}{since} writes its results there; its end is expected, or another folder (--out)",
        folder.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A simulator and an autopilot side by side; nobody beside a run that owns the whole folder; nothing
    /// remains.
    #[test]
    fn a_folder_has_one_owner_and_nothing_remains_of_the_lock() {
        let place = tempfile::tempdir().unwrap();
        let take = |owned, verb| FolderLock::take(place.path(), owned, verb);
        let sim = take(Owned::Simulator, "sim").unwrap();
        let autopilot = take(Owned::Autopilot, "autopilot").unwrap();
        assert!(take(Owned::Autopilot, "autopilot").is_err());
        let refused = take(Owned::Whole, "drop").unwrap_err().text();
        let named = format!("process {}, `samara sim`, begun ", std::process::id());
        assert!(refused.contains(&named) && refused.contains("--out"), "{refused}");
        drop(sim);
        let refused = take(Owned::Whole, "drop").unwrap_err().text();
        assert!(refused.contains("`samara autopilot`"), "{refused}");
        assert!(take(Owned::Simulator, "sim").is_ok(), "what was half taken is let go");
        drop(autopilot);
        let whole = take(Owned::Whole, "assess_rare").unwrap();
        let refused = take(Owned::Simulator, "sim").unwrap_err().text();
        assert!(refused.contains("`samara assess rare`"), "{refused}");
        drop(whole);
        assert_eq!(std::fs::read_dir(place.path()).unwrap().count(), 0);
    }

    /// A merge waits for the end of another one, and for nothing else.
    #[test]
    fn a_merge_waits_for_a_merge_alone() {
        let place = tempfile::tempdir().unwrap();
        let first = FolderLock::take(place.path(), Owned::Whole, MERGE).unwrap();
        assert!(FolderLock::take(place.path(), Owned::Whole, "assess").is_err());
        let (folder, (done, comes)) = (place.path().to_owned(), std::sync::mpsc::channel());
        let second = std::thread::spawn(move || {
            let second = FolderLock::take(&folder, Owned::Whole, MERGE).unwrap();
            done.send(()).unwrap();
            drop(second);
        });
        assert!(comes.recv_timeout(std::time::Duration::from_millis(100)).is_err(), "it waits");
        drop(first);
        comes.recv().unwrap();
        second.join().unwrap();
        let drop_of = FolderLock::take(place.path(), Owned::Whole, "drop").unwrap();
        assert!(FolderLock::take(place.path(), Owned::Whole, MERGE).is_err());
        drop(drop_of);
    }

    /// The file of a run that was killed is nobody's.
    #[test]
    #[cfg(unix)]
    fn a_killed_runs_lock_is_taken_and_a_link_is_not_followed() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        File::options().create(true).write(true).truncate(false).open(at(".simulator.lock")).unwrap();
        drop(FolderLock::take(place.path(), Owned::Whole, "drop").unwrap());
        File::options().create(true).write(true).truncate(false).open(at("precious")).unwrap();
        std::os::unix::fs::symlink("precious", at(".autopilot.lock")).unwrap();
        // Whoever followed it would look for ever for the file that it has locked.
        let (folder, (done, comes)) = (place.path().to_owned(), std::sync::mpsc::channel());
        std::thread::spawn(move || done.send(FolderLock::take(&folder, Owned::Whole, "drop").is_err()));
        assert_eq!(comes.recv_timeout(std::time::Duration::from_secs(30)), Ok(true));
        assert_eq!(std::fs::metadata(at("precious")).unwrap().len(), 0);
    }
}
