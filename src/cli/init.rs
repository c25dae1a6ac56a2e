//! `samara init`: a copy of what is inside the program, to edit.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::answer::{Answer, Failure};
use super::results::OutputFolder;
use super::terminal::print;
use samara::config::schema::schemas;
use samara::config::shipped::SHIPPED;

/// What the folder holds and what can be done there, for whoever comes upon it.
const README: &str = include_str!("help/init_readme.md");

/// The verbs of a drop on pymavlink, for scripts.
const DROP_PY: &str = include_str!("../../tests/e2e/drop.py");

/// `samara init`.
#[derive(Args, Debug)]
pub struct InitArgs {
    /// Folder to write to; it is made.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Writes the shipped files, the schemas, a README and a script's library, unless one of them is there
/// already.
pub fn run(args: &InitArgs) -> Result<Answer, Failure> {
    let schemas = schemas().map(|(name, text)| (format!("params/schema/{name}"), text));
    let shipped = SHIPPED.iter().map(|file| (file.path.to_owned(), file.text.to_owned()));
    let beside = [("README.md", README), ("drop.py", DROP_PY)];
    let beside = beside.map(|(name, text)| (name.to_owned(), text.to_owned()));
    let files: Vec<(String, String)> = beside.into_iter().chain(shipped).chain(schemas).collect();
    if let Some((name, _)) = files.iter().find(|(name, _)| args.folder.join(name).exists()) {
        return Err(Failure::input(format!(
            "{} is there already; a folder without the files of an earlier `samara init` is expected, and nothing was written",
            args.folder.join(name).display()
        )));
    }
    for (path, text) in &files {
        let (folder, name) = path.rsplit_once('/').unwrap_or(("", path));
        OutputFolder::plain(&args.folder.join(folder))?.write_text(name, text)?;
    }
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    print(&if args.json {
        format!("{:#}\n", json!({ "folder": args.folder.display().to_string(), "files": names }))
    } else {
        text(&args.folder, &names)
    })?;
    Ok(Answer::Yes)
}

fn text(folder: &Path, names: &[&str]) -> String {
    let mut lines = String::new();
    for name in names {
        lines += &format!("{}\n", folder.join(name).display());
    }
    format!(
        "{lines}next:\n  cd {}\n  samara drop x500_drop    # flies mission/x500_drop.json, which is yours to edit\n",
        folder.display()
    )
}
