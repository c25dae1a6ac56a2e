//! The terminal: results on stdout, everything else on stderr, and the exit code.

use std::fmt::Display;
use std::io::{self, Write as _};
use std::process::ExitCode;

use super::answer::{Answer, BadInput, Failure};

/// Prints to stdout; a reader that has gone away (`samara plan | head`) is no error. A device that cannot be
/// written to is one: results that nobody gets are no success.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(anyhow::Error::from(e).context("cannot write to stdout")).bad_input()
        }
        _ => Ok(()),
    }
}

/// Prints to stderr. When that is gone or full nobody is left to read, and there is no reason to end.
pub fn print_err(text: &str) {
    let _ = io::stderr().lock().write_all(text.as_bytes());
}

/// Prints remarks to stderr, each behind what it is of: a parameter file, gains or a mission.
pub fn print_remarks(of: impl Display, remarks: &[String]) {
    for remark in remarks {
        print_err(&format!("samara: {of}: {remark}\n"));
    }
}

/// Prints a failure and gives the exit code.
pub fn exit_code(result: Result<Answer, Failure>) -> ExitCode {
    let (code, whose) = match &result {
        Ok(Answer::Yes) => return ExitCode::SUCCESS,
        Ok(Answer::No) => return ExitCode::from(1),
        Err(Failure::BadInput(_)) => (2, ""),
        Err(Failure::Internal(_)) => (3, "internal error: "),
    };
    if let Err(failure) = result {
        print_err(&format!("samara: {whose}{}\n", failure.text()));
    }
    ExitCode::from(code)
}
