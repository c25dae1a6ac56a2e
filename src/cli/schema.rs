//! `samara schema`.

use super::args::SchemaArgs;
use super::outcome::{Answer, Failure};
use super::output::{OutputFolder, print};
use crate::config::schema::schemas;

/// Writes the schemas.
pub fn run(args: &SchemaArgs) -> Result<Answer, Failure> {
    let folder = OutputFolder::create(Some(&args.out), "schema")?;
    for (name, text) in schemas() {
        let path = folder.write(name, |out| std::io::Write::write_all(out, text.as_bytes()))?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(Answer::Yes)
}
