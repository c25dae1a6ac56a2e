//! A study with its host: threads, progress, and rows that are kept in the folder while it flies, so that the
//! same command with `--resume` goes on after it was stopped or killed, and ends in the same bytes.

use std::io::Read as _;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;

use super::args::StudyArgs;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::narrator::Narrator;
use crate::cli::progress::ProgressLine;
use crate::cli::results::OutputFolder;
use crate::cli::system::thread_pool;
use crate::cli::terminal::print;
use samara::config::Mission;
use samara::host::kept::{self, KeptRows};
use samara::host::{Host, Progress};
use samara::printable::printable;
use samara::report::json::VERSION;
use samara::study::jobs::Stopped;

/// The folder of a study's results; where it goes on, with the rows that an earlier run has left.
pub fn folder(args: &StudyArgs, verb: &str, name: &str, mission: &Mission) -> Result<OutputFolder, Failure> {
    let folder = OutputFolder::create(verb, args.mission.out.as_deref(), &mission.name)?;
    if args.resume {
        folder.resume([rows_of(name)]);
    }
    Ok(folder)
}

/// Name of a study's file of rows.
fn rows_of(name: &str) -> String {
    format!("{name}_rows.csv")
}

/// What a study is, for its host.
pub struct Asked<'a> {
    /// Name of the study: what its file of rows begins with.
    pub name: &'static str,
    /// Name of the study in its manifest.
    pub verb: &'static str,
    /// What its jobs are called.
    pub unit: &'static str,
    /// Jobs, or the most that there are.
    pub whole: u64,
    /// Threads that fly; `None`: one for each core.
    pub threads: Option<u16>,
    /// What decides its rows beside the mission's inputs: name and value.
    pub settings: &'a [(&'static str, String)],
}

/// A study of a mission on its host.
pub struct Hosted<'a> {
    args: &'a StudyArgs,
    mission: &'a Mission,
    folder: &'a OutputFolder,
    asked: Asked<'a>,
    pool: rayon::ThreadPool,
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
    /// A host for a study whose results go to `folder`.
    pub fn new(
        args: &'a StudyArgs,
        (mission, folder): (&'a Mission, &'a OutputFolder),
        asked: Asked<'a>,
        stop: &'a AtomicBool,
    ) -> Result<Self, Failure> {
        let pool = thread_pool(asked.threads)?;
        let progress = ProgressLine::new("study", asked.unit, asked.whole);
        Ok(Self { args, mission, folder, asked, pool, progress, stop })
    }

    /// Threads that fly.
    pub fn threads(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Runs a study to its end; `None` when Ctrl-C stopped it, and then its rows are kept.
    pub fn run<T>(
        &self,
        study: impl FnOnce(&mut Host<'_>) -> Result<T, Stopped>,
    ) -> Result<Option<T>, Failure> {
        let is_stopped = || self.stop.load(Ordering::Relaxed);
        let mut host = Host::new(&self.pool, &is_stopped, &self.progress, self.kept()?);
        let found = study(&mut host);
        let failure = host.failure();
        drop(host);
        self.progress.finish();
        match (found, failure) {
            (Ok(found), _) => Ok(Some(found)),
            (Err(Stopped), Some(error)) => Err(error)
                .with_context(|| self.folder.path().join(self.rows()).display().to_string())
                .bad_input(),
            (Err(Stopped), None) => Ok(None),
        }
    }

    /// Ends a study whose results are written: with its manifest, without its rows, which are needed until
    /// then, and with its JSON object or its text.
    pub fn finish(
        &self,
        object: impl FnOnce() -> String,
        text: impl FnOnce() -> String,
    ) -> Result<(), Failure> {
        self.folder.write_manifest(self.asked.verb, self.mission, self.asked.settings)?;
        self.folder.clear(&self.rows())?;
        print(&if self.args.mission.json { object() } else { text() })
    }

    /// The answer of a study that was stopped, with an object whose `key` has no value.
    pub fn stopped(&self, key: &str, narrator: &Narrator) -> Result<Answer, Failure> {
        narrator.say("stopped; the same command with --resume goes on\n");
        narrator.check()?;
        if self.args.mission.json {
            let object = serde_json::json!({ "mission": self.mission.name, key: null, "reason": "stopped" });
            print(&format!("{object:#}\n"))?;
        }
        Ok(Answer::No)
    }

    fn rows(&self) -> String {
        rows_of(self.asked.name)
    }

    /// The first line of the file of rows: everything that they hang on.
    fn head(&self) -> String {
        let settings: serde_json::Map<String, serde_json::Value> = self
            .asked
            .settings
            .iter()
            .map(|(name, value)| ((*name).to_owned(), value.clone().into()))
            .collect();
        let object = serde_json::json!({
            "study": self.asked.name, "version": VERSION, "mission": self.mission.name,
            "seed": self.mission.seed, "input_hash": self.mission.inputs.hash, "settings": settings,
        });
        format!("# {object}\n")
    }

    /// The rows of an earlier run where it is to be gone on with, and the file that takes those to come.
    fn kept(&self) -> Result<KeptRows, Failure> {
        let (name, head) = (self.rows(), self.head());
        let path = self.folder.path().join(&name);
        let (mut rows, mut whole) = (Vec::new(), 0);
        if self.args.resume {
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
            match text.strip_prefix(&head) {
                Some(text) => {
                    (rows, whole) = kept::read(text);
                    whole += head.len();
                }
                // Killed before its first line was whole.
                None if head.starts_with(&text) => {}
                None => {
                    return Err(Failure::input(format!(
                        "{}:1: these rows are of other inputs; expected `{}`, found `{}`: begin anew without --resume, or in \
                         another folder with --out",
                        path.display(),
                        head.trim_end(),
                        printable(text.lines().next().unwrap_or_default())
                    )));
                }
            }
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
