//! The key that frames are signed with, and the time stamps of signed frames, in files beside it.
#![expect(clippy::disallowed_methods, reason = "the command line reads the key, and keeps the time stamps")]

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Error, ErrorKind, Read as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use samara::link::shell::{SignWith, StampStore};
use samara::link::signing::Key;

use super::answer::{BadInput as _, Failure};

/// How frames are signed by the key of this file.
pub fn sign_with(path: &Path) -> Result<SignWith, Failure> {
    let context = || format!("{}: no key to sign with", path.display());
    let text = read_key(path).with_context(context).bad_input()?;
    let key = Key::parse(&text).with_context(context).bad_input()?;
    let stamps = Arc::new(StampFiles { key: path.to_owned(), is_file: path.is_file() });
    Ok(SignWith { key, stamps })
}

/// Most bytes of a key file.
const MAX_KEY_LEN: u64 = 4_096;

/// The text of a key file: short, and readable by its owner alone.
fn read_key(path: &Path) -> io::Result<String> {
    let file = File::open(path)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let mode = file.metadata()?.permissions().mode() & 0o777;
        if file.metadata()?.is_file() && mode & 0o077 != 0 {
            let what =
                format!("others than its owner may open it (mode {mode:04o}): `chmod 600` is expected");
            return Err(Error::new(ErrorKind::InvalidData, what));
        }
    }
    read_short(file, MAX_KEY_LEN)
}

/// The text of a file that has at most so many bytes.
fn read_short(file: File, most: u64) -> io::Result<String> {
    let mut text = String::new();
    file.take(most + 1).read_to_string(&mut text)?;
    if text.len() as u64 > most {
        return Err(Error::new(ErrorKind::InvalidData, format!("longer than {most} bytes")));
    }
    Ok(text)
}

/// Most bytes of a file of time stamps: 256 senders, of 40 bytes each, and more.
const MAX_LEN: u64 = 65_536;

/// `KEY.SYSTEM-COMPONENT.stamps`, one for each party.
#[derive(Debug)]
struct StampFiles {
    /// The file of the key.
    key: PathBuf,
    /// Nothing stands beside a key that comes by a pipe: its stamps are kept nowhere.
    is_file: bool,
}

impl StampFiles {
    fn path(&self, (system, component): (u8, u8), ending: &str) -> PathBuf {
        let mut name = OsString::from(&self.key);
        name.push(format!(".{system}-{component}.stamps{ending}"));
        name.into()
    }
}

impl StampStore for StampFiles {
    fn load(&self, party: (u8, u8)) -> io::Result<Option<String>> {
        if !self.is_file {
            return Ok(None);
        }
        match File::open(self.path(party, "")) {
            Ok(file) => read_short(file, MAX_LEN).map(Some),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e),
        }
    }

    fn store(&self, party: (u8, u8), text: &str) -> io::Result<()> {
        if !self.is_file {
            return Ok(());
        }
        let partial = self.path(party, ".partial");
        fs::write(&partial, text)?;
        fs::rename(&partial, self.path(party, ""))
    }

    fn place(&self, party: (u8, u8)) -> String {
        self.path(party, "").display().to_string()
    }
}
