//! What is not typed: asked for on a terminal, or refused by the names of the options.

use std::io::{self, BufRead as _, IsTerminal as _};

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::terminal::print_err;

/// Asks for what is missing, one question after another.
pub struct Questions {
    missing: Vec<&'static str>,
    interactive: bool,
}

impl Questions {
    /// Asks where both ends are a terminal; elsewhere it collects what is missing.
    pub fn new() -> Self {
        Self { missing: Vec::new(), interactive: io::stdin().is_terminal() && io::stderr().is_terminal() }
    }

    /// The value that was typed, else the answer to the question; `None` where nobody can be asked.
    pub fn ask<T: Clone>(
        &mut self,
        typed: Option<&T>,
        option: &'static str,
        question: &str,
        parse: impl Fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, Failure> {
        if let Some(value) = typed {
            return Ok(Some(value.clone()));
        }
        if !self.interactive {
            self.missing.push(option);
            return Ok(None);
        }
        loop {
            print_err(&format!("{question}: "));
            let mut line = String::new();
            if io::stdin().lock().read_line(&mut line).bad_input()? == 0 {
                return Err(Failure::input(format!("{option}: the answers have ended; nothing was written")));
            }
            match parse(line.trim()) {
                Ok(value) => return Ok(Some(value)),
                Err(expected) => print_err(&format!("  {expected}\n")),
            }
        }
    }

    /// Refuses what is missing.
    pub fn finish(&self) -> Result<(), Failure> {
        if self.missing.is_empty() {
            return Ok(());
        }
        Err(Failure::input(format!(
            "expected besides: {} (on a terminal they are asked for)",
            self.missing.join(", ")
        )))
    }
}
