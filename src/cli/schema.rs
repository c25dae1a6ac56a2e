//! `samara schema`.

use std::path::PathBuf;

use clap::Args;

use super::answer::{Answer, Failure};
use super::results::OutputFolder;
use super::terminal::print;
use samara::config::schema::schemas;

/// `samara schema`.
#[derive(Args, Debug)]
pub struct SchemaArgs {
    /// Folder to write to.
    #[arg(long, value_name = "DIR", default_value = "params/schema")]
    pub out: PathBuf,
}

/// Writes the schemas.
pub fn run(args: &SchemaArgs) -> Result<Answer, Failure> {
    let folder = OutputFolder::create(Some(&args.out), "schema")?;
    for (name, text) in schemas() {
        let path = folder.write_text(name, &text)?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(Answer::Yes)
}
