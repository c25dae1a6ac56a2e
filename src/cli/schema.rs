//! `samara schema`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::answer::{Answer, Failure};
use super::results::OutputFolder;
use super::terminal::print;
use samara::config::schema::schemas;
use samara::study;

/// Folder of the schemas in the project and in what `samara init` writes.
const USUAL: &str = "params/schema";

/// `samara schema`.
#[derive(Args, Debug)]
pub struct SchemaArgs {
    /// Folder to write to [default: params/schema, where there is one].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Writes the schemas.
pub fn run(args: &SchemaArgs) -> Result<Answer, Failure> {
    let usual = Path::new(USUAL);
    let Some(out) = args.out.as_deref().or(usual.is_dir().then_some(usual)) else {
        return Err(Failure::input(format!(
            "there is no folder {USUAL} here; --out DIR is expected, or `samara init DIR`, which writes the schemas too"
        )));
    };
    let folder = OutputFolder::plain(out)?;
    OutputFolder::plain(&out.join("results"))?;
    let inputs = schemas().map(|(name, text)| (name.to_owned(), text));
    for (name, text) in inputs.into_iter().chain(study::schema::schemas()) {
        print(&format!("{}\n", folder.write_text(&name, &text)?.display()))?;
    }
    Ok(Answer::Yes)
}
