//! Files read with a bound: a device, a pipe or a file that never ends costs no more memory than the bound,
//! and is refused.

use std::fs;
use std::io::{self, Read};
use std::path::Path;

/// Reads a file to its end, or a pipe until it is closed.
///
/// # Errors
/// The system's, and [`io::ErrorKind::FileTooLarge`] beyond `most` bytes.
pub fn bytes_at_most(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    let there = fs::metadata(path)?;
    if there.is_file() && there.len() > most {
        return Err(too_large(most));
    }
    let mut bytes = Vec::new();
    #[expect(clippy::disallowed_methods, reason = "this is where config/ reads files")]
    fs::File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most { Err(too_large(most)) } else { Ok(bytes) }
}

/// Reads a text that a run has written: from a file, never from a device or a pipe, which may never end or
/// never begin.
///
/// # Errors
/// As [`bytes_at_most`]; [`io::ErrorKind::InvalidInput`] for what is no file and
/// [`io::ErrorKind::InvalidData`] for what is no text.
pub fn text_at_most(path: &Path, most: u64) -> io::Result<String> {
    if !fs::metadata(path)?.is_file() {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "it is no file"));
    }
    let text = String::from_utf8(bytes_at_most(path, most)?);
    text.map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not text"))
}

fn too_large(most: u64) -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, format!("it is larger than {} MiB", most >> 20))
}

/// A reader of lines of which none is longer than a bound: of a table of any length no more than a line is in
/// memory.
#[derive(Debug)]
pub struct BoundedLines<R> {
    inner: R,
    most: usize,
    /// Bytes of the line so far.
    line: usize,
}

impl<R> BoundedLines<R> {
    /// Lines of at most `most` bytes.
    pub fn new(inner: R, most: usize) -> Self {
        Self { inner, most, line: 0 }
    }
}

impl<R: Read> Read for BoundedLines<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n = self.inner.read(into)?;
        for piece in into[..n].split_inclusive(|byte| *byte == b'\n') {
            self.line += piece.len();
            if self.line > self.most {
                let message = format!("a line is longer than {} bytes", self.most);
                return Err(io::Error::new(io::ErrorKind::InvalidData, message));
            }
            if piece.ends_with(b"\n") {
                self.line = 0;
            }
        }
        Ok(n)
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that makes files")]
mod tests {
    use super::*;

    /// One byte more than the bound is refused, from a file by its length, from a device that never ends
    /// after the bound.
    #[test]
    fn what_is_larger_than_the_bound_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, [b'1'; 8]).unwrap();
        assert_eq!(bytes_at_most(&file, 8).unwrap(), [b'1'; 8]);
        assert_eq!(bytes_at_most(&file, 7).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        let zeros = Path::new("/dev/zero");
        if zeros.exists() {
            assert_eq!(bytes_at_most(zeros, 1 << 20).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
            assert_eq!(text_at_most(zeros, 1 << 20).unwrap_err().kind(), io::ErrorKind::InvalidInput);
        }
        fs::write(&file, [0xFF]).unwrap();
        assert_eq!(text_at_most(&file, 8).unwrap_err().kind(), io::ErrorKind::InvalidData);
    }

    /// Lines up to the bound pass as they are, however they are cut into reads; a longer one ends it.
    #[test]
    fn closed_form_lines_up_to_the_bound_pass() {
        for size in [1, 3, 64] {
            let read = |text: &str| {
                let mut lines = BoundedLines::new(text.as_bytes(), 4);
                let (mut all, mut piece) = (Vec::new(), vec![0; size]);
                loop {
                    match lines.read(&mut piece)? {
                        0 => return Ok::<_, io::Error>(all),
                        n => all.extend_from_slice(&piece[..n]),
                    }
                }
            };
            assert_eq!(read("123\n\n12\n1234").unwrap(), b"123\n\n12\n1234");
            assert!(read("123\n1234\n").is_err() && read("12345").is_err());
        }
    }
}
