//! A study with its host: threads, progress, and rows that are kept in the folder while it flies, so that the
//! same command with `--resume` goes on after it was stopped or killed, and ends in the same bytes.

use std::cell::RefCell;
use std::io::{self, Read as _};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;

use super::asked::StudyOf;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use crate::cli::progress::ProgressLine;
use crate::cli::results::{GrowingFile, OutputFolder};
use crate::cli::system::{self, Stopwatch};
use crate::cli::terminal::{print, print_err};
use samara::config::Mission;
use samara::host::kept::{Earlier, KeptRows, RowsFile, going_on};
#[cfg(feature = "shards")]
use samara::host::shards::{Ended, Shards};
use samara::host::{FirstStage, Host, Progress, Threads};
use samara::study::kind::{About, Results, Study, Unfinished};

impl RowsFile for GrowingFile {
    fn cut(&mut self, bytes: u64) -> io::Result<()> {
        self.inner_mut().cut(bytes)
    }
}

/// Name of a study's file of rows.
pub fn rows_of(name: &str) -> String {
    format!("{name}_rows.csv")
}

/// A study of a mission on its host.
pub struct Hosted<'a> {
    of: &'a StudyOf,
    about: About,
    mission: &'a Mission,
    folder: &'a OutputFolder,
    threads: Threads,
    progress: Shown,
    stop: &'a AtomicBool,
    watch: Stopwatch,
}

/// How a study ended.
pub enum Ran {
    /// Ctrl-C stopped it, and its rows are kept.
    Stopped,
    /// Nothing was found: what was looked for, and why.
    Nothing { of: &'static str, why: String },
    /// It has results, and rows of a first stage that may go on for longer, or none.
    Found { found: Box<Results>, first_stage: Option<FirstStage> },
}

/// How far a study is, shown stage by stage.
struct Shown {
    what: String,
    line: RefCell<ProgressLine>,
}

impl Progress for ProgressLine {
    fn begins(&self, what: &str) {
        self.set_message(what);
    }

    fn done(&self, jobs: u64, kept: bool) {
        if kept { self.skip(jobs) } else { self.inc(jobs) }
    }
}

impl Progress for Shown {
    fn begins(&self, what: &str) {
        self.line.borrow().begins(what);
    }

    fn done(&self, jobs: u64, kept: bool) {
        self.line.borrow().done(jobs, kept);
    }

    fn stage(&self, unit: &'static str, jobs: u64) {
        self.line.borrow().finish();
        *self.line.borrow_mut() = ProgressLine::new(&self.what, unit, jobs);
    }
}

impl<'a> Hosted<'a> {
    /// A host for a study whose results go to `folder`.
    pub fn new(
        of: &'a StudyOf,
        (mission, folder): (&'a Mission, &'a OutputFolder),
        (threads, stop): (Option<u16>, &'a AtomicBool),
        study: &dyn Study,
    ) -> Result<Self, Failure> {
        let (about, threads) = (of.kind.about(), system::threads(threads)?);
        let what = format!("study {}", about.name.replace('_', "-"));
        let line = RefCell::new(ProgressLine::new(&what, about.unit, study.jobs()));
        let (progress, watch) = (Shown { what, line }, Stopwatch::start());
        Ok(Self { of, about, mission, folder, threads, progress, stop, watch })
    }

    /// Says what is to be known before it flies, and how long it takes, where that is long.
    pub fn warn(&self, study: &dyn Study) {
        study.remarks().iter().for_each(|remark| print_err(&format!("samara: {remark}\n")));
        if let Some(slow) = study.slow() {
            let count = (slow.flights, slow.tried);
            warn_in_space(&slow.reason, count, self.threads.count(), || (slow.try_some)());
        }
    }

    /// Runs a study to where the shards that are there lead: to its results, or to how it ended.
    #[cfg(feature = "shards")]
    pub fn run_in_shards(
        &self,
        study: &dyn Study,
        shards: Shards<'_>,
    ) -> Result<Result<Ran, Option<Ended>>, Failure> {
        let is_stopped = || self.stop.load(Ordering::Relaxed);
        let mut host = Host::in_shards(&self.threads, &is_stopped, &self.progress, shards);
        let found = study.run(&mut host);
        Ok(match self.ran(found, (&mut host, "shards"))? {
            Ran::Stopped => Err(host.ended()),
            ran => Ok(ran),
        })
    }

    /// Runs a study to its end, or to where Ctrl-C stops it.
    pub fn run(&self, study: &dyn Study) -> Result<Ran, Failure> {
        let is_stopped = || self.stop.load(Ordering::Relaxed);
        let watch = self.watch;
        let mut host = Host::new(&self.threads, &is_stopped, &self.progress, self.kept()?)
            .with_clock(Arc::new(move || 1e-3 * watch.ms()));
        let found = study.run(&mut host);
        self.ran(found, (&mut host, &rows_of(self.about.name)))
    }

    /// How a study ended; the error of its rows, in this place, where that is why.
    fn ran(
        &self,
        found: Result<Results, Unfinished>,
        (host, place): (&mut Host<'_>, &str),
    ) -> Result<Ran, Failure> {
        self.progress.line.borrow().finish();
        let at = || self.folder.path().join(place).display().to_string();
        Ok(match (found, host.failure()) {
            (Ok(found), _) => {
                let (found, first_stage) =
                    (Box::new(found), host.first_stage().with_context(at).bad_input()?);
                Ran::Found { found, first_stage }
            }
            (Err(Unfinished::Nothing { of, why }), _) => Ran::Nothing { of, why },
            (Err(Unfinished::Figure(e)), _) => Err(e).context("a figure of the study")?,
            (Err(Unfinished::Stopped), None) => Ran::Stopped,
            (Err(Unfinished::Stopped), Some(error)) => Err(error).with_context(at).bad_input()?,
            (Err(e @ Unfinished::File(_)), _) => Err(anyhow::Error::from(e))?,
        })
    }

    /// Writes the manifest.
    fn write_manifest(&self, found: &Results) -> Result<(), Failure> {
        let mut circumstances = self.of.values.in_order(self.about.settings);
        circumstances.extend(found.noted.iter().cloned());
        self.folder.write_manifest(self.about.manifest, self.mission, &circumstances)
    }

    /// Ends a study whose results are written: with its manifest, and without its rows, which are needed
    /// until then, unless they are kept. Those of a study that was stopped stay, and those of a first stage
    /// that may go on for longer: they are results.
    pub fn finish(&self, found: &Results, first_stage: Option<FirstStage>) -> Result<(), Failure> {
        let rows = rows_of(self.about.name);
        match if found.stopped || self.of.keep { Some(FirstStage::Kept(u64::MAX)) } else { first_stage } {
            None => {
                self.write_manifest(found)?;
                return self.folder.clear(&rows).map(|_| ());
            }
            Some(FirstStage::Kept(bytes)) => _ = self.folder.continued(&rows, bytes)?,
            Some(FirstStage::Text(text)) => _ = self.folder.write_text(&rows, &text)?,
        }
        self.write_manifest(found)
    }

    /// The answer of a study that was stopped.
    pub fn stopped(&self, narrator: &Narrator) -> Result<Answer, Failure> {
        narrator.say("stopped; the same command with --resume goes on\n");
        narrator.check()?;
        if self.of.args.mission.json {
            let (mission, study) = (&self.mission.name, self.about.name);
            let object = serde_json::json!({ "mission": mission, "study": study, "reason": "stopped" });
            print(&format!("{object:#}\n"))?;
        }
        Ok(Answer::No)
    }

    /// The rows of an earlier run where it is to be gone on with, and the file that takes those to come.
    fn kept(&self) -> Result<KeptRows, Failure> {
        let (name, head) = (rows_of(self.about.name), self.of.head(self.mission)?);
        let path = self.folder.path().join(&name);
        let mut earlier = Earlier::default();
        if self.of.args.resume {
            let mut text = String::new();
            let file = self.folder.open(&name)?;
            let mut file = file.ok_or_else(|| {
                Failure::input(format!(
                    "{}: no such file: nothing to go on with; the same command without --resume begins anew, and the folder of \
                     a study that was stopped is named by --out",
                    path.display()
                ))
            })?;
            file.read_to_string(&mut text).with_context(|| path.display().to_string()).bad_input()?;
            earlier = going_on(&text, &head).map_err(|why| {
                Failure::input(format!(
                    "{}:1: {why}: begin anew without --resume, or in another folder with --out",
                    path.display()
                ))
            })?;
        }
        let file = self.folder.continued(&name, earlier.whole())?;
        self.folder.unlist(&name);
        KeptRows::going_on(&head, earlier, Box::new(file))
            .with_context(|| format!("cannot write {}", path.display()))
            .bad_input()
    }
}
