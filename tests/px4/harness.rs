//! Programs that are started, listened to and ended, one test at a time.

use std::io::{BufRead as _, BufReader, Read, Write as _};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::{JoinHandle, sleep};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

/// Far more than anything here takes, on a busy machine too.
pub const PATIENCE: Duration = Duration::from_secs(120);
/// Numbers of the vehicles.
pub const INSTANCES: [u16; 2] = [7, 9];
pub const MISSION: &str = "tests/calm_x500.json";

static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// A build folder of PX4, and the only test that uses it.
pub struct Px4 {
    pub build: PathBuf,
    _turn: MutexGuard<'static, ()>,
}

/// The build folder, if there is one; otherwise says that the test is skipped, past the capture of the test's
/// output.
pub fn px4(test: &str) -> Option<Px4> {
    let Some(build) = std::env::var_os("SAMARA_PX4").filter(|folder| !folder.is_empty()) else {
        let text = format!("SKIPPED {test}: it needs PX4, and SAMARA_PX4 does not name a build folder\n");
        std::io::stderr().write_all(text.as_bytes()).unwrap();
        return None;
    };
    // A test that has failed says nothing about the next one.
    let turn = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    Some(Px4 { build: std::fs::canonicalize(build).unwrap(), _turn: turn })
}

/// A program whose words are kept. Killed when it goes out of scope.
pub struct Running {
    child: Child,
    group: bool,
    said: Arc<Mutex<String>>,
    listeners: Vec<JoinHandle<()>>,
}

impl Running {
    fn start(mut command: Command, group: bool) -> Self {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let said = Arc::new(Mutex::new(String::new()));
        let listen = |from: Box<dyn Read + Send>| {
            let said = said.clone();
            std::thread::spawn(move || {
                for line in BufReader::new(from).split(b'\n').map_while(Result::ok) {
                    let line = String::from_utf8_lossy(&line).into_owned();
                    said.lock().unwrap().push_str(&format!("{line}\n"));
                }
            })
        };
        let listeners = vec![
            listen(Box::new(child.stdout.take().unwrap())),
            listen(Box::new(child.stderr.take().unwrap())),
        ];
        Self { child, group, said, listeners }
    }

    /// The program with these arguments.
    pub fn samara(args: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
        command.args(args);
        Self::start(command, false)
    }

    /// PX4 as one starts it by hand, with parameters, by its start-up script up to v1.15, by its environment
    /// later; all that it starts ends with it.
    pub fn px4(build: &Path, instance: u16, work: &Path, parameters: &[(&str, f64)]) -> Self {
        let hooks = work.join("hooks");
        std::fs::create_dir_all(&hooks).unwrap();
        // Versions before v1.14 have a mixer; later ones their rotors by CA_*, which the model itself sets.
        let newer = build.join("etc/init.d-posix/airframes/10016_none_iris").exists();
        let (model, mixer) = if newer { ("none_iris", "") } else { ("iris", "set MIXER quad_x\n") };
        let lines: String =
            parameters.iter().map(|(name, value)| format!("param set {name} {value}\n")).collect();
        std::fs::write(hooks.join("px4-rc.params"), format!("#!/bin/sh\n{mixer}{lines}")).unwrap();
        let path = format!("{}:{}", hooks.display(), std::env::var("PATH").unwrap());
        let mut command = Command::new(build.join("bin/px4"));
        command.args(["-i", &instance.to_string(), "-d"]).arg(build.join("etc")).arg("-w").arg(work);
        command.args(["-s", "etc/init.d-posix/rcS"]).current_dir(work).process_group(0);
        command.env("PX4_SIM_MODEL", model).env("PATH", path);
        command.envs(parameters.iter().map(|(name, value)| (format!("PX4_PARAM_{name}"), value.to_string())));
        Self::start(command, true)
    }

    pub fn id(&self) -> Pid {
        Pid::from_child(&self.child)
    }

    pub fn said(&self) -> String {
        self.said.lock().unwrap().clone()
    }

    /// How often it has said it so far.
    pub fn times(&self, words: &str) -> usize {
        self.said.lock().unwrap().matches(words).count()
    }

    /// Waits until it has said it so often.
    pub fn until(&self, words: &str, times: usize) {
        wait_for(|| self.times(words) >= times, || format!("`{words}` {times} times in:\n{}", self.said()));
    }

    pub fn signal(&self, signal: Signal) {
        kill_process(self.id(), signal).unwrap();
    }

    /// Waits for its end.
    pub fn end(mut self) -> (ExitStatus, String) {
        let mut status = None;
        let said = self.said.clone();
        wait_for(
            || {
                status = self.child.try_wait().unwrap();
                status.is_some()
            },
            || format!("the end of:\n{}", said.lock().unwrap()),
        );
        // A killed one's pipes may be held by what it has left; they are not waited for.
        if status.is_some_and(|s| s.code().is_some()) {
            self.listeners.drain(..).for_each(|listener| listener.join().unwrap());
        }
        (status.unwrap(), self.said())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if self.group {
            _ = kill_process_group(self.id(), Signal::KILL);
        }
        _ = self.child.kill();
        _ = self.child.wait();
    }
}

/// Waits until something is so; a panic that says what was expected when it does not come.
pub fn wait_for(mut is_so: impl FnMut() -> bool, expected: impl Fn() -> String) {
    let since = Instant::now();
    while !is_so() {
        assert!(since.elapsed() < PATIENCE, "not within {PATIENCE:?}: {}", expected());
        sleep(Duration::from_millis(5));
    }
}

/// Arguments of a drop flown by PX4.
pub fn drop_args(px4: &Px4, instance: u16, out: &Path, more: &[&str]) -> Vec<String> {
    let autopilot = format!("px4={}", px4.build.display());
    let (instance, out) = (instance.to_string(), out.to_str().unwrap());
    let args = ["drop", MISSION, "--autopilot", &autopilot, "--instance", &instance, "--out", out];
    args.iter().chain(more).map(|arg| (*arg).to_owned()).collect()
}

/// A drop flown by PX4, started.
pub fn start_drop(px4: &Px4, instance: u16, out: &Path, more: &[&str]) -> Running {
    let args = drop_args(px4, instance, out, more);
    Running::samara(&args.iter().map(String::as_str).collect::<Vec<_>>())
}

/// The mission as data.
pub fn mission() -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(MISSION).unwrap()).unwrap()
}

/// drop.json of a folder.
pub fn verdict(out: &Path) -> serde_json::Value {
    serde_json::from_str(&std::fs::read_to_string(out.join("drop.json")).unwrap()).unwrap()
}

pub fn number(verdict: &serde_json::Value, key: &str) -> f64 {
    verdict[key].as_f64().unwrap_or_else(|| panic!("no {key} in {verdict}"))
}
