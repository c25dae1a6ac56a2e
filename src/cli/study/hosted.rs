//! A study with its host: threads, progress, and rows that are kept in the folder while it flies, so that the
//! same command with `--resume` goes on after it was stopped or killed, and ends in the same bytes.

use std::io::Read as _;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;

use super::asked::StudyOf;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::estimate::warn_in_space;
use crate::cli::narrator::Narrator;
use crate::cli::progress::ProgressLine;
use crate::cli::results::OutputFolder;
use crate::cli::system;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::host::kept::{KeptRows, going_on};
#[cfg(feature = "shards")]
use samara::host::shards::{Ended, Shards};
use samara::host::{Host, Progress, Threads};
use samara::study::kind::{About, Results, Study, Unfinished};

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
    progress: ProgressLine,
    stop: &'a AtomicBool,
}

impl Progress for ProgressLine {
    fn begins(&self, what: &str) {
        self.set_message(what);
    }

    fn done(&self, jobs: u64, kept: bool) {
        if kept { self.skip(jobs) } else { self.inc(jobs) }
    }
}

impl<'a> Hosted<'a> {
    /// A host for a study whose results go to `folder`; says how long it takes, where it does.
    pub fn new(
        of: &'a StudyOf,
        (mission, folder): (&'a Mission, &'a OutputFolder),
        (threads, stop): (Option<u16>, &'a AtomicBool),
        study: &dyn Study,
    ) -> Result<Self, Failure> {
        let (about, threads) = (of.kind.about(), system::threads(threads)?);
        if let Some(slow) = study.slow() {
            let count = (slow.flights, slow.tried);
            warn_in_space(&slow.reason, count, threads.count(), || (slow.try_some)());
        }
        let progress = ProgressLine::new("study", about.unit, study.jobs());
        Ok(Self { of, about, mission, folder, threads, progress, stop })
    }

    /// Runs a study to where the shards that are there lead: to its results, or to how it ended.
    #[cfg(feature = "shards")]
    pub fn run_in_shards(
        &self,
        study: &dyn Study,
        shards: Shards<'_>,
    ) -> Result<Result<Results, Option<Ended>>, Failure> {
        let is_stopped = || self.stop.load(Ordering::Relaxed);
        let mut host = Host::in_shards(&self.threads, &is_stopped, &self.progress, shards);
        let found = study.run(&mut host);
        let failure = host.failure();
        self.progress.finish();
        match (found, failure) {
            (Ok(found), _) => Ok(Ok(found)),
            (Err(Unfinished::Figure(e)), _) => Err(e).context("a figure of the study")?,
            (Err(Unfinished::Stopped), Some(error)) => Err(error)
                .with_context(|| self.folder.path().join("shards").display().to_string())
                .bad_input(),
            (Err(Unfinished::Stopped), None) => Ok(Err(host.ended())),
        }
    }

    /// Runs a study to its end; `None` when Ctrl-C stopped it, and then its rows are kept.
    pub fn run(&self, study: &dyn Study) -> Result<Option<Results>, Failure> {
        let is_stopped = || self.stop.load(Ordering::Relaxed);
        let mut host = Host::new(&self.threads, &is_stopped, &self.progress, self.kept()?);
        let found = study.run(&mut host);
        let failure = host.failure();
        drop(host);
        self.progress.finish();
        match (found, failure) {
            (Ok(found), _) => Ok(Some(found)),
            (Err(Unfinished::Figure(e)), _) => Err(e).context("a figure of the study")?,
            (Err(Unfinished::Stopped), Some(error)) => Err(error)
                .with_context(|| self.folder.path().join(rows_of(self.about.name)).display().to_string())
                .bad_input(),
            (Err(Unfinished::Stopped), None) => Ok(None),
        }
    }

    /// Writes the manifest.
    pub fn write_manifest(&self) -> Result<(), Failure> {
        let settings = self.of.values.in_order(self.about.settings);
        self.folder.write_manifest(self.about.manifest, self.mission, &settings)
    }

    /// Ends a study whose results are written: with its manifest, and without its rows, which are needed
    /// until then, unless they are kept.
    pub fn finish(&self) -> Result<(), Failure> {
        self.write_manifest()?;
        if self.of.keep {
            return Ok(());
        }
        self.folder.clear(&rows_of(self.about.name)).map(|_| ())
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
        let (name, head) = (rows_of(self.about.name), self.about.head(self.mission, &self.of.values));
        let path = self.folder.path().join(&name);
        let (mut rows, mut whole) = (Vec::new(), 0);
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
            (rows, whole) = going_on(&text, &head).map_err(|why| {
                Failure::input(format!(
                    "{}:1: {why}: begin anew without --resume, or in another folder with --out",
                    path.display()
                ))
            })?;
        }
        let mut file = self.folder.continued(&name, whole as u64)?;
        self.folder.unlist(&name);
        if whole == 0 {
            std::io::Write::write_all(&mut file, head.as_bytes())
                .with_context(|| format!("cannot write {}", path.display()))
                .bad_input()?;
        }
        Ok(KeptRows::going_on(rows, Box::new(file)))
    }
}
