//! Where results go: the output folder and stdout.

use std::fs::{self, File};
use std::io::{self, BufReader, BufWriter, Seek as _, Write};
use std::path::{Path, PathBuf};

use anyhow::Context;

use super::outcome::{BadInput, Failure};

/// The folder that a run writes to.
#[derive(Clone, Debug)]
pub struct OutputFolder {
    path: PathBuf,
}

impl OutputFolder {
    /// Makes the folder: `out`, or `out/<mission name>` by default.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it cannot be made.
    pub fn create(out: Option<&Path>, mission_name: &str) -> Result<Self, Failure> {
        let path = out.map_or_else(|| Path::new("out").join(mission_name), Path::to_owned);
        fs::create_dir_all(&path)
            .with_context(|| format!("cannot make the output folder {}", path.display()))
            .bad_input()?;
        Ok(Self { path })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A file that is written while a run goes on; it is made with the first byte, so that a run that does not get that far
    /// (a busy port) leaves the file of another one alone.
    pub fn late(&self, name: &str) -> LateFile {
        LateFile { path: self.path.join(name), file: None }
    }

    /// A file that grows while a run goes on, cut to its first `kept` bytes and continued there; 0 begins it anew. Writes go
    /// straight to the system, so that nothing is lost when the program is killed.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it cannot be written.
    pub fn continued(&self, name: &str, kept: u64) -> Result<File, Failure> {
        let path = self.path.join(name);
        let open = || {
            let mut file = File::options().create(true).truncate(false).write(true).open(&path)?;
            file.set_len(kept)?;
            file.seek(io::SeekFrom::End(0))?;
            Ok::<_, io::Error>(file)
        };
        open().with_context(|| format!("cannot write {}", path.display())).bad_input()
    }

    /// A file of an earlier run, to be read; `None` when there is none.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it cannot be read.
    pub fn open(&self, name: &str) -> Result<Option<BufReader<File>>, Failure> {
        let path = self.path.join(name);
        match File::options().read(true).open(&path) {
            Ok(file) => Ok(Some(BufReader::new(file))),
            Err(e) if e.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(e).with_context(|| format!("cannot read {}", path.display())).bad_input(),
        }
    }

    /// Writes a file whole: under a temporary name first, so that a reader never sees half of it.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it cannot be written (full disk, no permission).
    pub fn write(
        &self,
        name: &str,
        content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> Result<PathBuf, Failure> {
        let path = self.path.join(name);
        let partial = self.path.join(format!("{name}.partial"));
        #[expect(clippy::disallowed_methods, reason = "one of two places that make result files")]
        let made = File::create(&partial).and_then(|file| {
            let mut writer = BufWriter::new(file);
            content(&mut writer)?;
            writer.flush()
        });
        made.and_then(|()| fs::rename(&partial, &path))
            .with_context(|| format!("cannot write {}", path.display()))
            .bad_input()?;
        Ok(path)
    }
}

/// Tells on stderr, for when stdout belongs to a JSON object; as [`print`] otherwise.
pub fn tell(text: &str) -> Result<(), Failure> {
    let mut out = io::stderr().lock();
    match out.write_all(text.as_bytes()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(anyhow::Error::from(e).context("stderr").into())
        }
        _ => Ok(()),
    }
}

/// See [`OutputFolder::late`].
#[derive(Debug)]
pub struct LateFile {
    path: PathBuf,
    file: Option<BufWriter<File>>,
}

impl Write for LateFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.file.is_none() {
            #[expect(clippy::disallowed_methods, reason = "one of two places that make result files")]
            let file = File::create(&self.path)?;
            self.file = Some(BufWriter::new(file));
        }
        self.file.as_mut().map_or(Ok(0), |file| file.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.as_mut().map_or(Ok(()), Write::flush)
    }
}

/// Prints to stdout; a reader that has gone away (`samara plan | head`) is no error.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(anyhow::Error::from(e).context("stdout").into())
        }
        _ => Ok(()),
    }
}
