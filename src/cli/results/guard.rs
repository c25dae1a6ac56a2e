//! What a run does with what lies in its folder already.
//!
//! - A file that is written again with the same bytes loses nothing.
//! - The next plan or flight of the same verb takes the place of the one before, and a plan gives way to any
//!   run.
//! - Whatever else an earlier run has written - a campaign, a search, a card, another verb's flight - is set
//!   aside whole, with its manifest, before the first of its files is overwritten.
//! - A file that no manifest lists as it is, somebody's own, is set aside.
//! - What is no file - a link, a device, a pipe - is refused.

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use super::earlier::{EARLIER, EarlierRun, MANIFEST, move_aside};
use super::written::sha256_of_file;
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::terminal::print_err;

/// An earlier run of whose files this one overwrites some.
#[derive(Debug)]
struct Touched {
    run: EarlierRun,
    /// Whether this run has set it aside.
    newly_aside: bool,
}

impl Touched {
    /// Whether all that it had written is in a place of its own.
    fn is_aside(&self, folder: &Path) -> bool {
        self.run.place(folder).is_dir()
    }

    /// Whether what it had written besides goes from where it lies: results of the same verb do, a search's
    /// that goes before another verb's plan does not, nor what is of the same inputs.
    fn goes(&self, verb: &str, input_hash: &str) -> bool {
        let (kept, same_inputs) = (self.run.is_kept(), self.run.input_hash() == input_hash);
        if self.run.verb() == verb { kept || !same_inputs } else { !kept && !same_inputs }
    }
}

/// The guard of a folder of results.
#[derive(Debug)]
pub struct Guard {
    folder: PathBuf,
    verb: String,
    /// Whether what is done is said; the part of another folder's results says nothing.
    says: bool,
    resumes: Cell<bool>,
    /// Names that are this run's.
    ours: RefCell<BTreeSet<String>>,
    touched: RefCell<Vec<Touched>>,
    moved: RefCell<BTreeSet<String>>,
}

impl Guard {
    /// Guards a folder in a run of `verb`, which says what it does, or not.
    pub fn new(folder: &Path, verb: &str, says: bool) -> Self {
        Self {
            folder: folder.to_owned(),
            verb: verb.to_owned(),
            says,
            resumes: Cell::new(false),
            ours: RefCell::default(),
            touched: RefCell::default(),
            moved: RefCell::default(),
        }
    }

    /// The run goes on from an earlier one of the same verb: that one's results are this one's, and so are
    /// the named files, which no manifest lists yet.
    pub fn resume(&self, names: impl IntoIterator<Item = String>) {
        self.resumes.set(true);
        self.take_over(names);
    }

    /// The named files are this run's, which an earlier one may have left for it.
    pub fn take_over(&self, names: impl IntoIterator<Item = String>) {
        self.ours.borrow_mut().extend(names);
    }

    /// Makes room for a file of this run, or for none where one was; `sha256`: of what is to be written,
    /// where that is known.
    pub fn make_room(&self, name: &str, sha256: Option<&str>) -> Result<(), Failure> {
        if self.ours.borrow().contains(name) {
            return Ok(());
        }
        if self.is_a_file(name)? {
            let named = || format!("cannot make room for {}", self.folder.join(name).display());
            let lies = sha256_of_file(&self.folder.join(name)).with_context(named).bad_input()?;
            if sha256 != Some(&lies) {
                self.give_way(name, &lies).with_context(named).bad_input()?;
            }
        }
        self.ours.borrow_mut().insert(name.to_owned());
        Ok(())
    }

    /// Makes room for a folder that holds files of this verb's runs.
    pub fn make_room_for_folder(&self, name: &str) -> Result<(), Failure> {
        let path = self.folder.join(name);
        if fs::symlink_metadata(&path).is_err() {
            return Ok(());
        }
        let of_run = EarlierRun::all(&self.folder).into_iter().find(|run| run.verb() == name);
        let made = match of_run {
            Some(run) => {
                let to = run.place(&self.folder).join(name);
                let set_aside = self.touch(run);
                match set_aside {
                    Ok(()) if fs::symlink_metadata(&to).is_err() => fs::rename(&path, &to),
                    Ok(()) => self.move_aside(name),
                    failed => failed,
                }
            }
            None => self.move_aside(name),
        };
        made.with_context(|| format!("cannot make room for {}", path.display())).bad_input()
    }

    /// Whether there is a file; what is none is refused.
    pub fn is_a_file(&self, name: &str) -> Result<bool, Failure> {
        let path = self.folder.join(name);
        let there = match fs::symlink_metadata(&path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(false),
            there => there.with_context(|| format!("cannot write {}", path.display())).bad_input()?,
        };
        let found = match there.file_type() {
            kind if kind.is_file() => return Ok(true),
            kind if kind.is_symlink() => {
                let target = fs::read_link(&path).unwrap_or_default();
                format!("a link to {}", target.display())
            }
            kind if kind.is_dir() => "a folder".to_owned(),
            _ => "a device, a pipe or a socket".to_owned(),
        };
        Err(Failure::input(format!(
            "cannot write {}: a file is expected there, or nothing, and it is {found}; another folder (--out) is expected",
            path.display()
        )))
    }

    /// Lets no bytes be lost of a file that is to be overwritten: those whose it is are set aside.
    fn give_way(&self, name: &str, lies: &str) -> io::Result<()> {
        let runs = EarlierRun::all(&self.folder);
        let mut of_runs = runs.into_iter().filter(|run| run.has_written(name, lies)).peekable();
        if of_runs.peek().is_none() {
            return self.move_aside(name);
        }
        of_runs
            .filter(|run| !(self.resumes.get() && run.verb() == self.verb))
            .try_for_each(|run| self.touch(run))
    }

    fn move_aside(&self, name: &str) -> io::Result<()> {
        move_aside(&self.folder, name)?;
        self.moved.borrow_mut().insert(name.to_owned());
        Ok(())
    }

    /// Notes a run of which a file is overwritten, and sets it aside unless this one takes its place.
    fn touch(&self, run: EarlierRun) -> io::Result<()> {
        let is_known = self.touched.borrow().iter().any(|touched| touched.run.manifest == run.manifest);
        if !is_known {
            let newly_aside = !run.gives_way_to(&self.verb) && run.set_aside(&self.folder)?;
            self.touched.borrow_mut().push(Touched { run, newly_aside });
        }
        Ok(())
    }

    /// The run has come to its end, with a manifest of this verb, inputs and hash: removes what is left of
    /// those whose place it takes, and says what was done.
    pub fn finish(&self, verb: &str, input_hash: &str, sha256: &str) -> Result<(), Failure> {
        let manifest = format!("{verb}{MANIFEST}");
        let mut touched = self.touched.take();
        // The same run again: what was set aside is what is there.
        for same in touched.extract_if(.., |touched| touched.run.sha256 == sha256) {
            if same.newly_aside {
                let _ = fs::remove_dir_all(same.run.place(&self.folder));
                let _ = fs::remove_dir(self.folder.join(EARLIER));
            }
        }
        let stays = |run: &EarlierRun| {
            run.manifest != manifest
                && !touched.iter().any(|t| t.run.manifest == run.manifest && t.goes(verb, input_hash))
        };
        let stay: Vec<EarlierRun> =
            EarlierRun::all(&self.folder).into_iter().filter(|run| stays(run)).collect();
        for Touched { run, .. } in touched.iter().filter(|touched| touched.goes(verb, input_hash)) {
            let is_another = |name: &str| {
                self.ours.borrow().contains(name)
                    || stay.iter().any(|other| other.is_as_written(&self.folder, name))
            };
            let gone = run.as_written(&self.folder).into_iter().filter(|name| !is_another(name));
            for path in gone.filter(|name| *name != manifest).map(|name| self.folder.join(name)) {
                fs::remove_file(&path)
                    .with_context(|| format!("cannot remove {}, which is of an earlier run", path.display()))
                    .bad_input()?;
            }
        }
        for touched in &touched {
            self.say(&self.words(touched, touched.goes(verb, input_hash)));
        }
        self.say_moved();
        Ok(())
    }

    /// What was done with a run.
    fn words(&self, touched: &Touched, goes: bool) -> String {
        let (name, folder) = (touched.run.name(), self.folder.display());
        if touched.is_aside(&self.folder) {
            let place = touched.run.place(&self.folder);
            let rest = if goes { "" } else { ", and what was not overwritten stays where it is, too" };
            return format!("the results of {name} are set aside in {}{rest}", place.display());
        }
        match goes {
            true => format!("replaces the results of {name} in {folder}; --out keeps both"),
            false => String::new(),
        }
    }

    fn say_moved(&self) {
        let moved = self.moved.take();
        if !moved.is_empty() {
            let names = moved.into_iter().collect::<Vec<_>>().join(", ");
            let folder = self.folder.display();
            self.say(&format!(
                "{names}: no manifest in {folder} lists it as it is; set aside in {folder}/{EARLIER}"
            ));
        }
    }

    fn say(&self, text: &str) {
        if self.says && !text.is_empty() {
            print_err(&format!("samara: {text}\n"));
        }
    }
}

/// A run that ended before its manifest says what it has set aside.
impl Drop for Guard {
    fn drop(&mut self) {
        for touched in self.touched.take().iter().filter(|touched| touched.is_aside(&self.folder)) {
            self.say(&self.words(touched, false));
        }
        self.say_moved();
    }
}
