//! A changed mission in files of its own: beside the one that is open, never over another file.

use std::fs::{self, File};
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use super::viewed::{Refused, Viewed};
use samara_mission::shipped::is_built_in;
use samara_mission::{Override, changed_mission_files};

/// Longest name of a mission that is written [letters]: its vehicle's is longer.
const NAME_MOST: usize = 56;

/// Why a mission is not written.
#[derive(Debug, thiserror::Error)]
pub enum Unwritten {
    /// There is such a file.
    #[error("{} exists", .0.display())]
    Exists(PathBuf),
    /// The name is no name of a mission's file.
    #[error(
        "a name such as my_drop.json is expected: at most {NAME_MOST} letters, digits, `_` and `-` before .json"
    )]
    Name,
    /// It is no mission.
    #[error(transparent)]
    Refused(#[from] Refused),
    /// The system does not let it be written.
    #[error("{}", file.display())]
    System {
        /// The file.
        file: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// Writes the mission with other values as a file of this name beside it, or in the current folder where it
/// is built in, with a vehicle's and a gains' file where they have other values; all or none. The paths of
/// what was written.
///
/// # Errors
/// [`Unwritten`] says why not.
pub fn write(viewed: &Viewed, changes: &[Override], file: &str) -> Result<Vec<PathBuf>, Unwritten> {
    let name = file.strip_suffix(".json").ok_or(Unwritten::Name)?;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !(1..=NAME_MOST).contains(&name.len()) || !name.chars().all(plain) {
        return Err(Unwritten::Name);
    }
    let mission = viewed.with(changes)?;
    let parent = mission.file.parent().filter(|_| !is_built_in(&mission.file));
    let folder = parent.unwrap_or(Path::new(""));
    let files = changed_mission_files(&mission, &viewed.all(changes), name, folder).map_err(Refused::from)?;
    let here = |source| Unwritten::System { file: folder.to_owned(), source };
    let whole = std::path::absolute(folder.join("")).map_err(here)?;
    let mut written: Vec<PathBuf> = Vec::new();
    for (name, text) in files {
        let path = whole.join(name);
        let put = File::create_new(&path).and_then(|mut file| {
            written.push(path.clone());
            file.write_all(text.as_bytes())
        });
        if let Err(source) = put {
            written.iter().for_each(|path| _ = fs::remove_file(path));
            let exists = source.kind() == ErrorKind::AlreadyExists;
            return Err(if exists {
                Unwritten::Exists(path)
            } else {
                Unwritten::System { file: path, source }
            });
        }
    }
    Ok(written)
}
