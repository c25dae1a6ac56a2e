//! The folder of a study's parts: their files, and what was asked, which whoever puts them together reads.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::aside::Aside;
use samara::host::shards::ShardFiles;
use samara::report::json::VERSION;
use samara::study::asked::Asked;
use samara::study::kind::differences;

/// Name of the folder, within a study's.
pub const FOLDER: &str = "shards";
/// What a study in shards was asked, beside its parts.
pub const ASKED: &str = "study.json";

/// The folder of the parts.
pub struct PartsFolder {
    /// Where it is.
    pub path: PathBuf,
    /// Where parts are looked for that are not here.
    pub besides: Option<PathBuf>,
}

impl PartsFolder {
    /// The folder of the parts in that of a study.
    pub fn of(out: &Path) -> Self {
        Self { path: out.join(FOLDER), besides: None }
    }

    /// The folder of the parts, made where there is none. One with shards of a campaign is refused.
    pub fn made(out: &Path) -> Result<Self, Failure> {
        let made = Self::of(out);
        let folder = fs::create_dir_all(&made.path);
        folder.with_context(|| format!("cannot make the folder {}", made.path.display())).bad_input()?;
        let names = made.names().with_context(|| made.path.display().to_string()).bad_input()?;
        match names.iter().find(|name| name.ends_with(".parquet")) {
            None => Ok(made),
            Some(name) => Err(Failure::input(format!(
                "{}: a shard of a campaign lies there; another folder (--out) is expected",
                made.path.join(name).display()
            ))),
        }
    }

    /// Notes what is asked, or refuses what is not what was: rows of `head`. A search may be asked to go on
    /// for longer, or to end otherwise.
    pub fn note(&self, asked: &Asked, head: &str) -> Result<(), Failure> {
        let path = self.path.join(ASKED);
        let text = serde_json::to_string_pretty(asked).context("what is asked")? + "\n";
        let found = self.read(ASKED).with_context(|| path.display().to_string()).bad_input()?;
        if found.as_ref() == Some(&text) {
            return Ok(());
        }
        if let Some(found) = found {
            let named = |why: &str| Failure::input(format!("{}: {why}", path.display()));
            let found: Asked = serde_json::from_str(&found).map_err(|error| named(&error.to_string()))?;
            if found.head != head {
                let words = differences(&found.head, head).unwrap_or_default();
                return Err(named(&format!(
                    "another study is flown in this folder; another one (--out) is expected: {words}"
                )));
            }
        }
        self.write(ASKED, &text).with_context(|| path.display().to_string()).bad_input()
    }

    /// What was asked.
    pub fn asked(path: &Path) -> Result<Asked, Failure> {
        let place = || path.display().to_string();
        let text = read(path).with_context(place).bad_input()?.unwrap_or_default();
        let asked: Asked = serde_json::from_str(&text).with_context(place).bad_input()?;
        if asked.version != VERSION {
            let found = &asked.version;
            return Err(Failure::input(format!(
                "{}: shards by samara {VERSION} are expected, found some by {found}",
                place()
            )));
        }
        Ok(asked)
    }
}

impl ShardFiles for PartsFolder {
    fn names(&self) -> io::Result<Vec<String>> {
        let mut names = BTreeSet::new();
        for folder in std::iter::once(&self.path).chain(&self.besides) {
            for entry in fs::read_dir(folder)? {
                names.extend(entry?.file_name().into_string());
            }
        }
        Ok(names.into_iter().collect())
    }

    fn read(&self, name: &str) -> io::Result<Option<String>> {
        match (read(&self.path.join(name))?, &self.besides) {
            (None, Some(besides)) => read(&besides.join(name)),
            (found, _) => Ok(found),
        }
    }

    fn write(&self, name: &str, text: &str) -> io::Result<()> {
        let mut aside = Aside::new(&self.path.join(name))?;
        let mut file = aside.taken()?;
        io::Write::write_all(&mut file, text.as_bytes())?;
        file.sync_all()?;
        aside.rename()
    }
}

/// The text of a file; `None` where there is none.
fn read(path: &Path) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    match fs::File::options().read(true).open(path) {
        Ok(mut file) => file.read_to_end(&mut bytes)?,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(e),
    };
    // What is no text is damaged.
    Ok(Some(String::from_utf8_lossy(&bytes).into_owned()))
}

/// Whether a folder holds shards of a study.
pub fn is_study(dir: &Path) -> bool {
    dir.join(FOLDER).join(ASKED).exists()
}
