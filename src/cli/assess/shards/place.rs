//! Where the file of a part is.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use anyhow::Context as _;

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::aside::Aside;
use crate::cli::terminal::print_err;
use samara::study::cut::Cut;
use samara::study::shard::{ShardHead, ShardReader};

/// Folder of the parts within a campaign's.
pub const FOLDER: &str = "shards";
/// Ending of the name of a part's file.
pub const ENDING: &str = ".parquet";
/// The file of a part.
pub struct PartPlace {
    folder: PathBuf,
    name: String,
}

impl PartPlace {
    /// The part's place in a campaign's folder, which is made. Beside parts of another cut there is none.
    pub fn new(out: &Path, shard: Cut) -> Result<Self, Failure> {
        let folder = out.join(FOLDER);
        let made = fs::create_dir_all(&folder);
        made.with_context(|| format!("cannot make the folder {}", folder.display())).bad_input()?;
        let there = fs::read_dir(&folder).into_iter().flatten().flatten();
        let names = there.filter_map(|entry| entry.file_name().into_string().ok());
        let mut cuts = names.filter_map(|name| Cut::of_name(name.strip_suffix(ENDING)?));
        if let Some(other) = cuts.find(|cut| cut.of != shard.of) {
            return Err(Failure::input(format!(
                "--shard {shard}: {} has shards of {}, one of those is expected, or another folder (--out)",
                folder.display(),
                other.of
            )));
        }
        Ok(Self { folder, name: format!("{}{ENDING}", shard.name()) })
    }

    /// The file.
    pub fn path(&self) -> PathBuf {
        self.folder.join(&self.name)
    }

    /// Whether the part is there and whole. One that is cut short is not; one of another campaign is refused.
    pub fn is_whole(&self, wanted: &ShardHead) -> Result<bool, Failure> {
        let path = self.path();
        let Some(file) = open(&path)? else { return Ok(false) };
        let found = match ShardReader::checked(file) {
            Ok(reader) => reader.head().clone(),
            Err(error) => {
                let why = anyhow::Error::from(error);
                print_err(&format!("samara: {}: not whole, flown again: {why:#}\n", path.display()));
                return Ok(false);
            }
        };
        wanted
            .check_same_campaign(&found)
            .with_context(|| {
                format!("{}: another folder (--out) is expected for another campaign", path.display())
            })
            .bad_input()?;
        if found.range() != wanted.range() {
            return Err(Failure::input(format!(
                "{}: trials {:?} are expected in this shard, found {:?}",
                path.display(),
                wanted.range(),
                found.range()
            )));
        }
        Ok(true)
    }

    /// Begins the file aside.
    pub fn begin(&self) -> Result<Aside, Failure> {
        Aside::begin(&self.path())
    }
}

/// The file of a part, to be read; `None` where there is none.
pub fn open(path: &Path) -> Result<Option<File>, Failure> {
    let opened = fs::metadata(path).and_then(|there| match there.is_file() {
        true => File::options().read(true).open(path),
        false => Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no file")),
    });
    match opened {
        Ok(file) => Ok(Some(file)),
        Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e).with_context(|| format!("cannot read {}", path.display())).bad_input(),
    }
}
