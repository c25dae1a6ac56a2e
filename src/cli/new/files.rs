//! Where drafts are written, and the paths between them.

use std::path::{Path, PathBuf};

use crate::cli::answer::Failure;
use samara::config::relative;

/// The file of `--out`, or `NAME.json` in `usual` where there is such a folder, else in the current one. It
/// is not to be there yet.
pub fn new_file(out: Option<&Path>, usual: &str, name: &str) -> Result<PathBuf, Failure> {
    let folder = if Path::new(usual).is_dir() { Path::new(usual) } else { Path::new("") };
    let file = out.map_or_else(|| folder.join(format!("{name}.json")), Path::to_owned);
    if file.exists() {
        return Err(Failure::input(format!(
            "{} is there already, and nothing was written; another name or --out FILE is expected",
            file.display()
        )));
    }
    Ok(file)
}

/// Folder and name of a file that is to be written.
pub fn place(file: &Path) -> Result<(PathBuf, String), Failure> {
    let Some(name) = file.file_name().and_then(|name| name.to_str()) else {
        return Err(Failure::input(format!("--out {}: a file is expected", file.display())));
    };
    let folder = file.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    Ok((folder.to_owned(), name.to_owned()))
}

/// The path from a folder to a schema, where the schemas are in the usual place.
pub fn schema(folder: &Path, name: &str) -> Option<String> {
    let schema = Path::new("params/schema").join(name);
    schema.is_file().then(|| relative(folder, &schema))
}
