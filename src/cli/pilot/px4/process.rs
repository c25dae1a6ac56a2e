//! PX4's process.
//!
//! It runs in a working directory of its own, where it keeps its parameters, its console and its log, and in
//! a process group of its own, since its start-up script has children. All of the group ends with the value
//! that stands for it, and with this process, however these end.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use anyhow::{Context as _, Result};

use super::beginning::Beginning;
use super::build_folder::BuildFolder;
use super::idle::is_idle;
use super::process_group::ProcessGroup;
use super::{lock, work_dir};
use crate::cli::system::{Stopwatch, pause};

/// The file that PX4's console is kept in, in its working directory.
const CONSOLE: &str = "console.log";
/// How much of its end is read [bytes].
const CONSOLE_END: u64 = 1 << 16;
/// Beginnings of the names of variables that PX4's start script and modules read, parameters (PX4_PARAM_*)
/// among them: what is wanted of them is set.
const FOREIGN: [&str; 2] = ["PX4_", "ROS_"];
/// How long PX4 is given to close its log.
const FAREWELL: Duration = Duration::from_secs(3);
/// How often PX4's end is looked for.
const LOOK: Duration = Duration::from_millis(10);
/// Lines of the console that are shown when PX4 has ended by itself or does not answer.
const LAST_WORDS: usize = 5;

/// The last bytes of a file, this many at most.
fn end_of(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    #[expect(clippy::disallowed_methods, reason = "the child's console")]
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(most)))?;
    let mut end = Vec::new();
    file.take(most).read_to_end(&mut end)?;
    Ok(end)
}

/// Whether a variable of the environment would change a run.
fn is_foreign(name: &OsStr) -> bool {
    FOREIGN.iter().any(|beginning| name.as_encoded_bytes().starts_with(beginning.as_bytes()))
}

/// A running PX4.
#[derive(Debug)]
pub struct Px4Process {
    child: Child,
    group: ProcessGroup,
    work: PathBuf,
    ended: Option<ExitStatus>,
}

impl Px4Process {
    /// Starts instance `instance` in the folder `work`, which is made anew.
    pub fn start(build: &BuildFolder, instance: u16, beginning: &Beginning, work: &Path) -> Result<Self> {
        let model = build.model()?;
        lock::look(instance)?;
        let work = work_dir::make(work, build.path(), beginning)?;
        #[expect(clippy::disallowed_methods, reason = "the child's console")]
        let console = File::create(work.join(CONSOLE)).and_then(|file| Ok((file.try_clone()?, file)));
        let (out, err) = console.with_context(|| format!("cannot write {CONSOLE}"))?;
        let mut command = Command::new(build.program());
        for (name, _) in std::env::vars_os() {
            if is_foreign(&name) {
                command.env_remove(name);
            }
        }
        let group = ProcessGroup::start()?;
        group.adopt(&mut command);
        command
            .args(["-i", &instance.to_string(), "-d"])
            .arg(build.etc())
            .args(["-s", "etc/init.d-posix/rcS", "-w"])
            .arg(&work)
            .current_dir(&work)
            .env("PX4_SIM_MODEL", model)
            .envs(beginning.environment())
            .stdin(Stdio::null())
            .stdout(out)
            .stderr(err);
        if let Some(path) = work_dir::path_with_hooks(&work) {
            command.env("PATH", path);
        }
        let child = command.spawn().with_context(|| format!("cannot start {}", build.program().display()))?;
        Ok(Self { child, group, work, ended: None })
    }

    /// PX4's working directory.
    pub fn work(&self) -> &Path {
        &self.work
    }

    /// Whether PX4 has done all that there was to do.
    pub fn is_idle(&self) -> bool {
        is_idle(self.child.id())
    }

    /// Ends PX4: asked first, so that it closes its log, then without asking. Returns once nothing of its
    /// group is left.
    pub fn stop(&mut self) {
        if self.ended.is_none() {
            self.group.ask();
            self.wait(FAREWELL);
        }
        self.group.kill();
        if self.ended.is_none() {
            self.ended = self.child.wait().ok();
        }
        self.group.wait();
    }

    fn wait(&mut self, patience: Duration) {
        let since = Stopwatch::start();
        while self.has_not_ended() && since.ms() < 1e3 * patience.as_secs_f64() {
            pause(LOOK);
        }
    }

    fn has_not_ended(&mut self) -> bool {
        self.ended = self.ended.or_else(|| self.child.try_wait().ok().flatten());
        self.ended.is_none()
    }

    /// The end of PX4's console, and where that is kept.
    pub fn last_words(&self) -> String {
        let text = end_of(&self.work.join(CONSOLE), CONSOLE_END).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let console = self.work.join(CONSOLE);
        match lines[lines.len().saturating_sub(LAST_WORDS)..].join("\n  ") {
            words if words.is_empty() => format!("{} is empty", console.display()),
            words => format!("the end of {}:\n  {words}", console.display()),
        }
    }

    /// How PX4 has ended, if it has.
    pub fn ended(&mut self) -> Option<String> {
        if self.has_not_ended() {
            return None;
        }
        let how = match self.ended {
            Some(status) => match (status.code(), status.signal()) {
                (Some(code), _) => format!("exit code {code}"),
                (_, Some(signal)) => format!("signal {signal}"),
                _ => "unknown how".to_owned(),
            },
            None => "unknown how".to_owned(),
        };
        Some(format!("PX4 has ended ({how}); {}", self.last_words()))
    }
}

impl Drop for Px4Process {
    fn drop(&mut self) {
        self.stop();
    }
}
