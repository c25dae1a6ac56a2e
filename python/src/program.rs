//! The program `samara`, of which this library is all: `samara_tpf.__main__` is its door.

use std::ffi::OsString;
use std::panic::catch_unwind;

use pyo3::prelude::*;

/// The exit code of a program that has panicked, as Rust has it.
const PANICKED: u8 = 101;

/// Runs a command line, whose first word is the program's name, and gives the exit code. The process is the
/// program's from then on: it takes its signals, and help ends it.
#[pyfunction]
pub fn program(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| catch_unwind(|| samara::cli::run(words)).unwrap_or(PANICKED))
}
