//! Why a file was refused: where it is wrong and what was expected there.

use std::path::{Path, PathBuf};

use super::shipped::is_built_in;
use samara_core::params::ParamsError;
use samara_core::printable::printable;

/// A file that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {role} {}: {reason}{}", shown(path), whence(path, named_in.as_ref()))]
    Read {
        /// Role of the file ("mission file").
        role: &'static str,
        /// The path that was tried.
        path: PathBuf,
        /// The file that names it; `None` when it was given on the command line.
        named_in: Option<PathBuf>,
        /// Reason that the operating system gives.
        reason: String,
    },
    /// No file has the name that was given.
    #[error(
        "no {role} of the name `{}` (looked for {}){} expected one of {}, or a path{}",
        printable(name),
        shown(tried),
        did_you_mean(near.as_deref()),
        known.join(", "),
        as_a_path(name, *is_here, *is_here_as_json)
    )]
    Unknown {
        /// Role of the file ("mission file").
        role: &'static str,
        /// The name.
        name: String,
        /// The path on disk that the name would have meant.
        tried: PathBuf,
        /// The name that was probably meant.
        near: Option<String>,
        /// All names, on disk and built in, in order.
        known: Vec<String>,
        /// Whether something of that very path is in the current directory.
        is_here: bool,
        /// Whether a file of that name, and `.json`, is.
        is_here_as_json: bool,
    },
    /// The text is not the JSON or the table that was expected.
    #[error("{}:{line}:{column}: {}{message}", shown(file), at(json_path))]
    Content {
        /// The file.
        file: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Where in the document: `rotors[2].axis_body`; empty for the document itself and in a table.
        json_path: String,
        /// Fault, and what was expected.
        message: String,
    },
    /// A key cannot be set, or not to this value.
    #[error("--set {set}: {message}")]
    Override {
        /// Key and value as they were given.
        set: String,
        /// Fault, and what was expected.
        message: String,
    },
    /// A parameter file is not what was expected, or is not for the mission's vehicle and site.
    #[error("{}:{}{error}", shown(file), if starts_with_line(error) { "" } else { " " })]
    Parameters {
        /// The file.
        file: PathBuf,
        /// Fault; begins with the line, if it is one line's.
        error: ParamsError,
    },
}

/// A path on one line, in which nothing acts on a terminal.
fn shown(path: &Path) -> String {
    printable(&path.display().to_string()).into_owned()
}

fn starts_with_line(error: &ParamsError) -> bool {
    use ParamsError::{
        Columns, Control, DoesNotBelong, Field, Format, NoCounterpart, NoGains, NoUnit, Pair, TooMany, Twice,
    };
    match error {
        Columns { .. } | Field { .. } | Pair { .. } | TooMany { .. } | Twice { .. } => true,
        DoesNotBelong(_) | Format(_) | NoGains | Control(_) | NoUnit { .. } | NoCounterpart { .. } => false,
    }
}

/// A hint at what was probably meant, to stand between what was found and what was expected.
pub(super) fn did_you_mean(near: Option<&str>) -> String {
    near.map_or_else(|| ";".to_owned(), |near| format!(", did you mean `{near}`?"))
}

/// Where a name would have been a path.
fn as_a_path(name: &str, is_here: bool, is_here_as_json: bool) -> String {
    match (is_here, is_here_as_json) {
        (true, _) => format!(": there is a ./{} here", printable(name)),
        (false, true) => format!(": there is a ./{}.json here", printable(name)),
        (false, false) => String::new(),
    }
}

fn at(json_path: &str) -> String {
    if json_path.is_empty() { String::new() } else { format!("{json_path}: ") }
}

fn whence(path: &Path, named_in: Option<&PathBuf>) -> String {
    match (named_in, path.is_relative() && !is_built_in(path)) {
        (Some(file), _) => {
            format!(" (named in {}; paths in a file are relative to that file)", shown(file))
        }
        (None, true) => match std::env::current_dir() {
            Ok(here) => format!(" (relative to the current directory, {})", shown(&here)),
            Err(_) => " (relative to the current directory)".to_owned(),
        },
        (None, false) => String::new(),
    }
}
