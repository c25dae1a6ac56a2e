//! What Python has, asked of it. Each question has two seconds.

use std::io::Read;
use std::process::{Command, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

use super::finding::{Finding, State};
use samara::report::json::VERSION;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(2);

const WHICH: &str = "import sys; print('%d.%d.%d %s' % (*sys.version_info[:3], sys.executable))";
const PYMAVLINK: &str =
    "import pymavlink; print(getattr(pymavlink, '__version__', 'its version is not known'))";
const SAMARA_TPF: &str = "import samara_tpf; print(samara_tpf.__version__)";

/// Python and its modules.
pub fn python() -> Vec<Finding> {
    let which = match answer("python3", WHICH) {
        Ok(answer) => answer,
        Err(why) => {
            let finding = Finding::new("python3", State::Absent, why);
            return vec![finding.advising("only scripts and samara_tpf need it: Python 3.11 or newer")];
        }
    };
    let module = |name: &str, script: &str, use_of: &str| {
        answer("python3", script).map_err(|why| Finding::new(name, State::Absent, why).advising(use_of))
    };
    let pymavlink =
        module("pymavlink", PYMAVLINK, "only scripts over MAVLink need it: pip install pymavlink");
    let samara_tpf = module("samara_tpf", SAMARA_TPF, "only samara in Python needs it: docs/python.md");
    vec![
        Finding::new("python3", State::Ok, which),
        pymavlink.map_or_else(|absent| absent, |version| Finding::new("pymavlink", State::Ok, version)),
        samara_tpf.map_or_else(|absent| absent, |version| of_version(&version)),
    ]
}

/// The module, whose version must be the program's.
fn of_version(version: &str) -> Finding {
    let finding = Finding::new("samara_tpf", State::ok_or_no(version == VERSION), version);
    match finding.state {
        State::No => finding.advising(format!("this program is {VERSION}: install the wheel of its version")),
        _ => finding,
    }
}

/// The first line that a script prints, or why there is none.
fn answer(python: &str, script: &str) -> Result<String, String> {
    let mut command = Command::new(python);
    command.args(["-c", script]).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(|error| format!("{python} cannot be started: {error}"))?;
    let pipes = (child.stdout.take(), child.stderr.take());
    let (sender, said) = channel();
    // A child of the child may hold the pipes open for longer than anybody waits.
    let read = std::thread::Builder::new().spawn(move || {
        let _ = sender.send((text(pipes.0), text(pipes.1)));
    });
    read.map_err(|error| error.to_string())?;
    let said = said.recv_timeout(PATIENCE);
    // One that has just ended is gone, too.
    let _ = if said.is_err() { child.kill() } else { Ok(()) };
    let ended = child.wait().map_err(|error| error.to_string())?;
    let (out, err) = said.map_err(|_| format!("no answer within {} s", PATIENCE.as_secs()))?;
    match ended.success() {
        true => Ok(out.lines().next().unwrap_or_default().to_owned()),
        false => Err(err.lines().last().unwrap_or("it failed without a word").to_owned()),
    }
}

/// What comes by a pipe, to its end.
fn text(pipe: Option<impl Read>) -> String {
    let mut bytes = Vec::new();
    let read = pipe.map_or(Ok(0), |mut pipe| pipe.read_to_end(&mut bytes));
    read.map_or_else(|error| error.to_string(), |_| String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    /// By programs that stand in for Python: one answers, one fails, one never ends, one is not there.
    #[test]
    fn an_answer_comes_or_is_given_up() {
        assert_eq!(answer("/bin/sh", "echo 1.2; echo 3"), Ok("1.2".to_owned()));
        assert_eq!(answer("/bin/sh", "echo no >&2; echo none >&2; exit 1"), Err("none".to_owned()));
        assert_eq!(answer("/bin/sh", "exec sleep 60"), Err("no answer within 2 s".to_owned()));
        assert!(answer("/nowhere/python3", "").unwrap_err().contains("cannot be started"));
    }

    #[test]
    fn the_module_is_of_the_program_s_version() {
        assert!(of_version(VERSION).is_no_trouble());
        let other = of_version("0.0.1");
        assert!(!other.is_no_trouble() && other.advice.unwrap().contains(VERSION));
    }
}
