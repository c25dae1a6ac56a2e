//! The folder that results go to.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Read, Seek as _, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::Context;
use serde::Deserialize;
use sha2::{Digest, Sha256};

use super::answer::{BadInput as _, Failure};
use super::aside::Aside;
use super::terminal::{print, print_err};
use samara::config::Mission;
use samara::report::manifest_json;

/// The folder that a run writes to.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    path: PathBuf,
    /// Names of the files that the run has written, shared by those who write them.
    written: Rc<RefCell<BTreeSet<String>>>,
    /// Whether it is a part of another folder's results, which says what it replaces.
    part: bool,
}

/// What is read of an earlier run's manifest.
#[derive(Deserialize)]
struct Earlier {
    verb: String,
    mission: String,
    gains: String,
    input_hash: String,
    choices: BTreeMap<String, String>,
    files: BTreeMap<String, String>,
}

impl Earlier {
    /// The run, in words.
    fn name(&self) -> String {
        let choices = self.choices.iter().map(|(name, value)| format!(", {name} {value}"));
        let choices: String = choices.collect();
        format!(
            "`samara {}` of {} with gains {}{choices}",
            self.verb.replace('_', " "),
            self.mission,
            self.gains
        )
    }

    /// Whether it took minutes or hours: it is not removed for another verb's plan.
    fn is_long(&self) -> bool {
        self.verb.starts_with("assess") || self.verb == "tune" || self.verb == "design"
    }
}

fn write_all(file: File, content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let mut writer = BufWriter::new(file);
    content(&mut writer)?;
    writer.flush()
}

fn write_aside(path: &Path, content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<()> {
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    #[expect(clippy::disallowed_methods, reason = "one of two places that make result files")]
    let made = File::create(&partial).and_then(|file| write_all(file, content));
    made.and_then(|()| fs::rename(&partial, path)).inspect_err(|_| {
        // Half a file is of no use to anybody; if it cannot be removed either, the error is the same.
        let _ = fs::remove_file(&partial);
    })
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// SHA-256 of a text, hexadecimal.
pub fn sha256_of(text: &str) -> String {
    hexadecimal(Sha256::new_with_prefix(text))
}

/// What came of removing something; what was not there is gone, too.
pub fn gone(removed: io::Result<()>) -> io::Result<()> {
    match removed {
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(()),
        other => other,
    }
}

impl OutputFolder {
    /// Makes the folder: the one given, or `out/<mission name>`.
    pub fn create(out: Option<&Path>, mission_name: &str) -> Result<Self, Failure> {
        let path = out.map_or_else(|| Path::new("out").join(mission_name), Path::to_owned);
        fs::create_dir_all(&path)
            .with_context(|| format!("cannot make the output folder {}", path.display()))
            .bad_input()?;
        Ok(Self { path, written: Rc::default(), part: false })
    }

    /// A folder below this one, for a part of its results.
    pub fn part(&self, place: impl AsRef<Path>, mission_name: &str) -> Result<Self, Failure> {
        Ok(Self { part: true, ..Self::create(Some(&self.path.join(place)), mission_name)? })
    }

    /// Where the folder is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A file that is written while a run goes on; it is made with the first byte, so that a run that does
    /// not get that far (a busy port) leaves the file of another one alone.
    pub fn late(&self, name: &str) -> LateFile {
        LateFile { folder: self.clone(), name: name.to_owned(), file: None }
    }

    /// A file that is written aside while a run goes on, and is whole or not there.
    pub fn aside(&self, name: &str) -> Result<Aside, Failure> {
        self.written.borrow_mut().insert(name.to_owned());
        Aside::begin(&self.path.join(name))
    }

    /// A file that grows while a run goes on, cut to its first `kept` bytes and continued there; 0 begins it
    /// anew. Writes go straight to the system, so that nothing is lost when the program is killed.
    pub fn continued(&self, name: &str, kept: u64) -> Result<File, Failure> {
        let path = self.path.join(name);
        let open = || {
            let mut file = File::options().create(true).truncate(false).write(true).open(&path)?;
            file.set_len(kept)?;
            file.seek(io::SeekFrom::End(0))?;
            Ok::<_, io::Error>(file)
        };
        self.written.borrow_mut().insert(name.to_owned());
        open().with_context(|| format!("cannot write {}", path.display())).bad_input()
    }

    /// A file of an earlier run, to be read; `None` when there is none.
    pub fn open(&self, name: &str) -> Result<Option<BufReader<File>>, Failure> {
        let path = self.path.join(name);
        match File::options().read(true).open(&path) {
            Ok(file) => Ok(Some(BufReader::new(file))),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e).with_context(|| format!("cannot read {}", path.display())).bad_input(),
        }
    }

    /// Writes a file whole: under a temporary name first, so that a reader never sees half of it. A link
    /// leads to its file, which is written. A device or a pipe is written through, and counts as none of the
    /// run's files: it cannot be read again.
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        match fs::metadata(&path) {
            Ok(there) if !there.is_file() && !there.is_dir() => {
                let opened = File::options().write(true).open(&path);
                opened.and_then(|file| write_all(file, content))
            }
            there => {
                let through_link = there.and_then(|_| fs::canonicalize(&path));
                let made = write_aside(through_link.as_ref().unwrap_or(&path), content);
                self.written.borrow_mut().extend(made.is_ok().then(|| name.to_owned()));
                made
            }
        }
        .with_context(|| format!("cannot write {}", path.display()))
        .bad_input()?;
        Ok(path)
    }

    /// Writes a file of text, as [`OutputFolder::write`] does.
    pub fn write_text(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        self.write(name, |out| out.write_all(text.as_bytes()))
    }

    /// Writes a file of text that others may write at the same time, and that a power cut leaves whole; other
    /// than that as [`OutputFolder::write`].
    pub fn write_safely(&self, name: &str, text: &str) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        if fs::metadata(&path).is_ok_and(|there| !there.is_file()) {
            return self.write_text(name, text);
        }
        let aside = Aside::begin(&fs::canonicalize(&path).unwrap_or_else(|_| path.clone()))?;
        aside.named(aside.file()?.write_all(text.as_bytes()))?;
        aside.finish()?;
        self.written.borrow_mut().insert(name.to_owned());
        Ok(path)
    }

    /// Removes those of the named files that this run has not written: an earlier run has left them, and they
    /// would be taken for this one's.
    pub fn remove_leftovers(&self, names: &[&str]) -> Result<(), Failure> {
        let written = self.written.borrow();
        for name in names.iter().filter(|name| !written.contains(**name)) {
            self.remove(name)?;
        }
        Ok(())
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
        let read = || {
            let mut hash = Sha256::new();
            let mut piece = vec![0; 1 << 16];
            #[expect(clippy::disallowed_methods, reason = "a result that was just written")]
            let mut file = File::open(&path)?;
            loop {
                match file.read(&mut piece)? {
                    0 => return Ok(hash),
                    n => hash.update(&piece[..n]),
                }
            }
        };
        let hash: io::Result<Sha256> = read();
        let hash = hash.with_context(|| format!("cannot read {} again", path.display())).bad_input()?;
        Ok(hexadecimal(hash))
    }

    /// Writes `<verb>_manifest.json`: version, seed and hash of the inputs of this run, its circumstances
    /// (which are no inputs), and the SHA-256 of each file that it has written. What else lies in the folder
    /// is of another run; of one with other inputs whose files this one has overwritten nothing remains.
    pub fn write_manifest(
        &self,
        verb: &str,
        mission: &Mission,
        circumstances: &[(&str, String)],
    ) -> Result<(), Failure> {
        self.replace_earlier(verb, &mission.inputs.hash)?;
        let names = self.written.borrow().clone();
        let files = names
            .into_iter()
            .map(|name| Ok((name.clone(), self.sha256(&name)?)))
            .collect::<Result<BTreeMap<_, _>, Failure>>()?;
        let text = manifest_json(mission, verb, circumstances, &files);
        self.write_text(&format!("{verb}_manifest.json"), &text).map(|_| ())
    }
}

impl OutputFolder {
    /// Removes what is left of runs with other inputs of whose files some were overwritten, and says so. A
    /// file that is no longer as its manifest has it is somebody's own and stays; so does another verb's long
    /// work, of which only the plan was overwritten.
    fn replace_earlier(&self, verb: &str, input_hash: &str) -> Result<(), Failure> {
        let own = format!("{verb}_manifest.json");
        for name in self.manifests() {
            let Some(earlier) = self.earlier(&name)? else { continue };
            let written = self.written.borrow();
            let overwritten: Vec<&str> =
                earlier.files.keys().map(String::as_str).filter(|file| written.contains(*file)).collect();
            if earlier.input_hash == input_hash || overwritten.is_empty() {
                continue;
            }
            let place = self.path.display();
            if earlier.is_long() && name != own {
                self.say(&format!(
                    "{} in {place} replaced what {} had written, whose other results stay; --out keeps both",
                    overwritten.join(", "),
                    earlier.name()
                ));
                continue;
            }
            for (file, sha256) in earlier.files.iter().filter(|(file, _)| !written.contains(*file)) {
                let is_a_name = Path::new(file).file_name().is_some_and(|name| name == file.as_str());
                if is_a_name && self.path.join(file).is_file() && self.sha256(file)? == *sha256 {
                    self.remove(file)?;
                }
            }
            if name != own {
                self.remove(&name)?;
            }
            self.say(&format!("replaces the results of {} in {place}; --out keeps both", earlier.name()));
        }
        Ok(())
    }

    /// Names of the manifests in the folder, in order.
    fn manifests(&self) -> BTreeSet<String> {
        let entries = fs::read_dir(&self.path).into_iter().flatten();
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        names.filter(|name| name.ends_with("_manifest.json")).collect()
    }

    /// The run of a manifest; `None` for what is none.
    fn earlier(&self, name: &str) -> Result<Option<Earlier>, Failure> {
        Ok(self.open(name)?.and_then(|file| serde_json::from_reader(file).ok()))
    }

    fn remove(&self, name: &str) -> Result<(), Failure> {
        let path = self.path.join(name);
        gone(fs::remove_file(&path))
            .with_context(|| format!("cannot remove {}, which is of an earlier run", path.display()))
            .bad_input()
    }

    fn say(&self, text: &str) {
        if !self.part {
            print_err(&format!("samara: {text}\n"));
        }
    }
}

/// A file that is made with its first byte, see [`OutputFolder::late`].
#[derive(Debug)]
pub struct LateFile {
    folder: OutputFolder,
    name: String,
    file: Option<BufWriter<File>>,
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
            #[expect(clippy::disallowed_methods, reason = "one of two places that make result files")]
            let file = File::create(self.folder.path.join(&self.name)).map_err(|e| self.named(&e))?;
            self.file = Some(BufWriter::new(file));
            self.folder.written.borrow_mut().insert(self.name.clone());
        }
        self.file.as_mut().map_or(Ok(0), |file| file.write(bytes)).map_err(|e| self.named(&e))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush).map_err(|e| self.named(&e))
    }
}
