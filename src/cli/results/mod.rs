//! The folder that results go to.
//!
//! | file | holds |
//! |---|---|
//! | `lock` | a run owns its folder while it writes |
//! | `written` | hashes of what was written |
//! | `earlier` | what earlier runs have left, and where it is set aside |
//! | `guard` | what becomes of what lies in the folder already |

mod earlier;
mod guard;
mod lock;
mod written;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read as _, Seek as _, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::Context;

use super::answer::{BadInput as _, Failure};
use super::aside::{self, Aside};
use super::terminal::print;
use guard::Guard;
use lock::FolderLock;
pub use lock::Owned;
use samara::config::Mission;
use samara::config::bounded::BoundedLines;
use samara::study::card::manifest::manifest_json;
pub use written::{Hashed, sha256_of};
use written::{WrittenHash, hash_of, sha256_of_file};

/// Longest line of a table that a run goes on from [bytes].
const LINE_MOST: usize = 1 << 16;

/// The folder that a run writes to.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// The files that the run has written, shared by those who write them.
    written: Rc<RefCell<BTreeMap<String, WrittenHash>>>,
    /// What guards earlier results; none in a folder that is not one of results.
    guard: Option<Rc<Guard>>,
    /// Held until nobody writes to the folder any more.
    locks: Rc<Vec<FolderLock>>,
}

/// Removes a folder with all that it holds, if it is there.
pub fn remove_folder(path: &Path) -> Result<(), Failure> {
    gone(fs::remove_dir_all(path)).with_context(|| format!("cannot remove {}", path.display())).bad_input()
}

/// A file that grows while a run goes on.
pub type GrowingFile = Hashed<File>;

fn write_all(
    file: File,
    content: impl FnOnce(&mut Hashed<BufWriter<File>>) -> io::Result<()>,
) -> io::Result<WrittenHash> {
    let hash = WrittenHash::default();
    let mut writer = Hashed::new(BufWriter::new(file), hash.clone());
    content(&mut writer)?;
    writer.flush()?;
    Ok(hash)
}

/// What came of removing something; what was not there is gone, too.
pub fn gone(removed: io::Result<()>) -> io::Result<()> {
    match removed {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

/// The folder that a mission's results go to: the one given, or `out/<mission name>`.
pub fn place_of(out: Option<&Path>, mission_name: &str) -> PathBuf {
    out.map_or_else(|| Path::new("out").join(mission_name), Path::to_owned)
}

fn made(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path)
        .with_context(|| format!("cannot make the output folder {}", path.display()))
        .bad_input()
}

impl OutputFolder {
    /// Makes the folder of a run's results, the one given or `out/<mission name>`, and owns it until the last
    /// who writes to it has ended: a second run is refused. `verb` is that of the run's manifest.
    pub fn create(verb: &str, out: Option<&Path>, mission_name: &str) -> Result<Self, Failure> {
        Self::owned(Owned::Whole, verb, out, mission_name)
    }

    /// As [`OutputFolder::create`], of a party of a drop, which writes beside another one.
    pub fn owned(owned: Owned, verb: &str, out: Option<&Path>, mission_name: &str) -> Result<Self, Failure> {
        Self::locked(owned, verb, verb, place_of(out, mission_name))
    }

    /// As [`OutputFolder::create`], of `samara merge`, which waits for another one that has begun.
    #[cfg(feature = "shards")]
    pub fn merged(verb: &str, out: Option<&Path>, mission_name: &str) -> Result<Self, Failure> {
        Self::locked(Owned::Whole, lock::MERGE, verb, place_of(out, mission_name))
    }

    fn locked(owned: Owned, command: &str, verb: &str, path: PathBuf) -> Result<Self, Failure> {
        made(&path)?;
        let locks = FolderLock::take(&path, owned, command)?;
        aside::tidy(&path);
        let guard = Some(Rc::new(Guard::new(&path, verb, true)));
        Ok(Self { path, written: Rc::default(), guard, locks: Rc::new(locks) })
    }

    /// A folder for files that are asked for by name, or that the caller has to itself: what has such a name
    /// is overwritten, and others may write beside it.
    pub fn plain(path: &Path) -> Result<Self, Failure> {
        made(path)?;
        Ok(Self { path: path.to_owned(), written: Rc::default(), guard: None, locks: Rc::default() })
    }

    /// A folder below this one, for a part of its results by `verb`.
    pub fn part(&self, verb: &str, place: impl AsRef<Path>) -> Result<Self, Failure> {
        let path = self.path.join(place);
        if self.guard.is_some() && fs::symlink_metadata(&path).is_ok_and(|there| there.is_symlink()) {
            let target = fs::read_link(&path).unwrap_or_default();
            let (path, target) = (path.display(), target.display());
            return Err(Failure::input(format!(
                "{path}: a folder is expected there, or nothing, and it is a link to {target}"
            )));
        }
        made(&path)?;
        let guard = self.guard.as_ref().map(|_| Rc::new(Guard::new(&path, verb, false)));
        Ok(Self { path, written: Rc::default(), guard, locks: self.locks.clone() })
    }

    /// Where the folder is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The run goes on from an earlier one of the same verb, whose results are this one's; so are the named
    /// files, which no manifest lists yet.
    pub fn resume(&self, names: impl IntoIterator<Item = String>) {
        if let Some(guard) = &self.guard {
            guard.resume(names);
        }
    }

    /// A file that is written while a run goes on; it is made with the first byte, so that a run that does
    /// not get that far (a busy port) leaves the file of another one alone.
    pub fn late(&self, name: &str) -> LateFile {
        LateFile { folder: self.clone(), name: name.to_owned(), file: None }
    }

    /// A file that is written aside while a run goes on, and is whole or not there; to be given to
    /// [`OutputFolder::finish`].
    pub fn aside(&self, name: &str) -> Result<Aside, Failure> {
        Aside::begin(&self.path.join(name))
    }

    /// Gives a file that was written aside its name.
    pub fn finish(&self, aside: Aside) -> Result<(), Failure> {
        let hash =
            aside.file().and_then(|mut file| aside.named(file.rewind().and_then(|()| hash_of(file))))?;
        let name = aside.name();
        self.make_room(&name, Some(&hash.hex()))?;
        aside.finish()?;
        self.note(&name, hash);
        Ok(())
    }

    /// A file that grows while a run goes on, cut to its first `kept` bytes and continued there; 0 begins it
    /// anew. Writes go straight to the system, so that nothing is lost when the program is killed.
    pub fn continued(&self, name: &str, kept: u64) -> Result<GrowingFile, Failure> {
        let path = self.path.join(name);
        let hash = WrittenHash::default();
        let open = || {
            // What was set aside may be another name of the same file.
            if is_linked(&path)? {
                let mut aside = Aside::new(&path)?;
                io::copy(&mut File::options().read(true).open(&path)?, &mut aside.taken()?)?;
                aside.rename()?;
            }
            let mut file = File::options().read(true).write(true).open(&path)?;
            let mut before = (&mut file).take(kept);
            let mut piece = vec![0; 1 << 16];
            loop {
                match before.read(&mut piece)? {
                    0 => break,
                    n => hash.take(&piece[..n]),
                }
            }
            file.set_len(kept.min(file.metadata()?.len()))?;
            file.seek(io::SeekFrom::End(0))?;
            Ok::<_, io::Error>(file)
        };
        let file = if kept == 0 {
            self.begun(name)?
        } else {
            self.guard.as_ref().map_or(Ok(true), |guard| guard.is_a_file(name))?;
            open().with_context(|| format!("cannot write {}", path.display())).bad_input()?
        };
        self.note(name, hash.clone());
        Ok(Hashed::new(file, hash))
    }

    /// A new file of this name.
    fn begun(&self, name: &str) -> Result<File, Failure> {
        self.make_room(name, None)?;
        let path = self.path.join(name);
        let opened = gone(fs::remove_file(&path))
            .and_then(|()| File::options().create_new(true).read(true).write(true).open(&path));
        opened.with_context(|| format!("cannot write {}", path.display())).bad_input()
    }

    /// A table of an earlier run, to be read; `None` when there is none.
    pub fn open(&self, name: &str) -> Result<Option<BufReader<BoundedLines<File>>>, Failure> {
        let path = self.path.join(name);
        let opened = fs::metadata(&path).and_then(|there| match there.is_file() {
            true => File::options().read(true).open(&path),
            false => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no file")),
        });
        match opened {
            Ok(file) => Ok(Some(BufReader::new(BoundedLines::new(file, LINE_MOST)))),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e).with_context(|| format!("cannot read {}", path.display())).bad_input(),
        }
    }

    /// Writes a file whole: under a temporary name first, so that a reader never sees half of it. In a folder
    /// that is not one of results a link leads to its file, which is written, and a device or a pipe is
    /// written through.
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut Hashed<BufWriter<File>>) -> io::Result<()>,
    ) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        let cannot = || format!("cannot write {}", path.display());
        let there = if self.guard.is_none() { fs::metadata(&path).ok() } else { None };
        if there.as_ref().is_some_and(|there| !there.is_file() && !there.is_dir()) {
            let opened = File::options().write(true).open(&path);
            opened.and_then(|file| write_all(file, content)).with_context(cannot).bad_input()?;
            return Ok(path);
        }
        let through_link = there.and_then(|_| fs::canonicalize(&path).ok());
        let mut aside =
            Aside::new(through_link.as_ref().unwrap_or(&path)).with_context(cannot).bad_input()?;
        let file = aside.taken().with_context(cannot).bad_input()?;
        let hash = write_all(file, content).with_context(cannot).bad_input()?;
        self.make_room(name, Some(&hash.hex()))?;
        aside.rename().with_context(cannot).bad_input()?;
        self.note(name, hash);
        Ok(path)
    }

    /// Writes a file of text, as [`OutputFolder::write`] does.
    pub fn write_text(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        self.write(name, |out| out.write_all(text.as_bytes()))
    }

    /// Removes those of the named files that this run has not written: an earlier run has left them, and they
    /// would be taken for this one's. What is not to be lost is set aside.
    pub fn remove_leftovers(&self, names: &[&str]) -> Result<(), Failure> {
        for name in names.iter().filter(|name| !self.written.borrow().contains_key(**name)) {
            self.clear(name)?;
        }
        Ok(())
    }

    /// A file of this run is no result of it: no manifest lists it.
    pub fn unlist(&self, name: &str) {
        self.written.borrow_mut().remove(name);
    }

    /// Removes a file, of this run or of an earlier one; whether there was one. What is not to be lost is set
    /// aside.
    pub fn clear(&self, name: &str) -> Result<bool, Failure> {
        let path = self.path.join(name);
        if fs::symlink_metadata(&path).is_err() {
            return Ok(false);
        }
        self.make_room(name, None)?;
        self.written.borrow_mut().remove(name);
        gone(fs::remove_file(&path))
            .with_context(|| format!("cannot remove {}, which is of an earlier run", path.display()))
            .bad_input()?;
        Ok(true)
    }

    /// Makes room for a folder that holds files of this verb's runs.
    pub fn clear_folder(&self, name: &str) -> Result<(), Failure> {
        self.guard.as_ref().map_or(Ok(()), |guard| guard.make_room_for_folder(name))
    }

    /// Prints a result: its JSON object, or its text and where the files are.
    pub fn print_result(
        &self,
        json: bool,
        object: impl FnOnce() -> String,
        text: impl FnOnce() -> String,
    ) -> Result<(), Failure> {
        print(&if json { object() } else { format!("{}results in {}\n", text(), self.path.display()) })
    }

    /// SHA-256 of a file of the folder, hexadecimal.
    pub fn sha256(&self, name: &str) -> Result<String, Failure> {
        let path = self.path.join(name);
        sha256_of_file(&path).with_context(|| format!("cannot read {} again", path.display())).bad_input()
    }

    /// Writes `<verb>_manifest.json`: version, seed and hash of the inputs of this run, its circumstances
    /// (which are no inputs), and the SHA-256 of each file as it was written; one that lies there otherwise
    /// is refused. What else lies in the folder is of another run.
    pub fn write_manifest(
        &self,
        verb: &str,
        mission: &Mission,
        circumstances: &[(&str, String)],
    ) -> Result<(), Failure> {
        let written = self.written.borrow().clone();
        let files: BTreeMap<String, String> =
            written.into_iter().map(|(name, hash)| (name, hash.hex())).collect();
        for (name, hash) in &files {
            if self.sha256(name)? != *hash {
                return Err(Failure::input(format!(
                    "{}: it is not what this run has written: something else writes to this folder; no manifest vouches for it",
                    self.path.join(name).display()
                )));
            }
        }
        let text = manifest_json(mission, verb, circumstances, &files);
        let (name, sha256) = (format!("{verb}{}", earlier::MANIFEST), sha256_of(&text));
        self.make_room(&name, Some(&sha256))?;
        if let Some(guard) = &self.guard {
            guard.finish(verb, &mission.inputs.hash, &sha256)?;
        }
        self.write_text(&name, &text).map(|_| ())
    }

    fn make_room(&self, name: &str, sha256: Option<&str>) -> Result<(), Failure> {
        self.guard.as_ref().map_or(Ok(()), |guard| guard.make_room(name, sha256))
    }

    fn note(&self, name: &str, hash: WrittenHash) {
        self.written.borrow_mut().insert(name.to_owned(), hash);
    }
}

/// Whether a file has another name.
#[cfg(unix)]
fn is_linked(path: &Path) -> io::Result<bool> {
    use std::os::unix::fs::MetadataExt as _;
    Ok(fs::symlink_metadata(path)?.nlink() > 1)
}

#[cfg(not(unix))]
fn is_linked(_path: &Path) -> io::Result<bool> {
    Ok(false)
}

/// A file that is made with its first byte, see [`OutputFolder::late`].
#[derive(Debug)]
pub struct LateFile {
    folder: OutputFolder,
    name: String,
    file: Option<Hashed<BufWriter<File>>>,
}

impl LateFile {
    /// An error with the file's path: a full disk is found, a file that is not named is searched for.
    fn named(&self, error: &io::Error) -> io::Error {
        io::Error::new(error.kind(), format!("{}: {error}", self.folder.path.join(&self.name).display()))
    }
}

impl Write for LateFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.file.is_none() {
            let file = self.folder.begun(&self.name).map_err(|failure| io::Error::other(failure.text()))?;
            let hash = WrittenHash::default();
            self.folder.note(&self.name, hash.clone());
            self.file = Some(Hashed::new(BufWriter::new(file), hash));
        }
        self.file.as_mut().map_or(Ok(0), |file| file.write(bytes)).map_err(|e| self.named(&e))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush).map_err(|e| self.named(&e))
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that makes files")]
mod tests {
    use super::*;

    fn mission() -> Mission {
        samara::config::load_mission(Path::new("mission/x500_drop.json")).unwrap()
    }

    fn run(verb: &str, place: &Path) -> OutputFolder {
        OutputFolder::create(verb, Some(place), "any").unwrap()
    }

    /// What something else has written over this run's file, by whatever way it was written, is not vouched
    /// for: the manifest of the run is not made.
    #[test]
    fn no_manifest_vouches_for_what_the_run_has_not_written() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path();
        for torn in [None, Some("whole.txt"), Some("late.tlog"), Some("grows.csv")] {
            let folder = run("drop", path);
            folder.write_text("whole.txt", "1").unwrap();
            let mut late = folder.late("late.tlog");
            late.write_all(b"23").unwrap();
            late.flush().unwrap();
            folder.continued("grows.csv", 0).unwrap().write_all(b"4\n5\n6\n").unwrap();
            folder.continued("grows.csv", 2).unwrap().write_all(b"7\n").unwrap();
            let Some(torn) = torn else {
                folder.write_manifest("drop", &mission(), &[]).unwrap();
                let manifest = fs::read_to_string(path.join("drop_manifest.json")).unwrap();
                assert!(manifest.contains(&sha256_of("4\n7\n")) && manifest.contains(&sha256_of("23")));
                fs::remove_file(path.join("drop_manifest.json")).unwrap();
                continue;
            };
            fs::write(path.join(torn), "torn").unwrap();
            let refused = folder.write_manifest("drop", &mission(), &[]).unwrap_err().text();
            assert!(refused.contains(torn) && refused.contains("not what this run has written"), "{refused}");
            assert!(!path.join("drop_manifest.json").exists());
        }
    }

    /// A campaign is set aside before the first of its files is overwritten, to the byte; the same campaign
    /// again leaves nothing aside; one that goes on from it takes its files over.
    #[test]
    fn a_campaign_is_set_aside_unless_it_is_the_same_or_goes_on() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path();
        let campaign = |rows: &str, resume: bool| {
            let folder = run("assess", path);
            if resume {
                folder.resume(["rows.csv".to_owned()]);
            }
            folder.write_text("plan.json", "plan").unwrap();
            let kept = if resume { 2 } else { 0 };
            folder.continued("rows.csv", kept).unwrap().write_all(&rows.as_bytes()[kept as usize..]).unwrap();
            folder.write_manifest("assess", &mission(), &[]).unwrap();
        };
        let aside = |verb: &str| {
            let entries = fs::read_dir(path.join("earlier")).into_iter().flatten().flatten();
            let of_verb = entries.filter(|e| e.file_name().to_str().unwrap().starts_with(verb));
            of_verb.map(|e| e.path()).collect::<Vec<_>>()
        };
        campaign("1\n", false);
        campaign("1\n", false);
        assert!(aside("").is_empty(), "the same again");
        campaign("1\n2\n", true);
        assert!(aside("").is_empty(), "gone on");
        campaign("1\n3\n", false);
        let [first] = &aside("assess-")[..] else { panic!("one is set aside") };
        assert_eq!(fs::read_to_string(first.join("rows.csv")).unwrap(), "1\n2\n");
        assert_eq!(fs::read_to_string(first.join("plan.json")).unwrap(), "plan");
        // Another verb's plan over the campaign's: the campaign stays, and lies aside as it was.
        let plan = run("plan", path);
        plan.write_text("plan.json", "another plan").unwrap();
        plan.write_manifest("plan", &mission(), &[]).unwrap();
        drop(plan);
        assert_eq!(fs::read_to_string(path.join("rows.csv")).unwrap(), "1\n3\n");
        let second = aside("assess-").into_iter().find(|place| place != first).unwrap();
        for run in [first, &second] {
            let kept = earlier::EarlierRun::all(run);
            assert_eq!(kept[0].as_written(run), ["plan.json", "rows.csv", "assess_manifest.json"]);
        }
        // A run that goes on after that writes to no file that lies aside.
        campaign("1\n4\n", true);
        assert_eq!(fs::read_to_string(second.join("rows.csv")).unwrap(), "1\n3\n");
    }
}
