//! What a run has written, by its hash: taken while it is written, so that what lies there later can be held
//! against it.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use std::rc::Rc;

use sha2::{Digest as _, Sha256};

/// The hash of a file that is being written, shared with whoever asks for it at the end.
#[derive(Clone, Debug, Default)]
pub struct WrittenHash(Rc<RefCell<Sha256>>);

impl WrittenHash {
    /// The hash so far, hexadecimal.
    pub fn hex(&self) -> String {
        hexadecimal(self.0.borrow().clone())
    }

    /// Takes bytes in that were written, or that were there and are kept.
    pub fn take(&self, bytes: &[u8]) {
        self.0.borrow_mut().update(bytes);
    }
}

/// A file that is hashed as it is written.
#[derive(Debug)]
pub struct Hashed<W> {
    inner: W,
    hash: WrittenHash,
}

impl<W> Hashed<W> {
    /// A file whose hash goes on from what was taken in.
    pub fn new(inner: W, hash: WrittenHash) -> Self {
        Self { inner, hash }
    }

    /// What is written to; the hash does not follow what is done to it.
    pub fn inner_mut(&mut self) -> &mut W {
        &mut self.inner
    }
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.inner.write(bytes)?;
        self.hash.take(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

fn hexadecimal(hash: Sha256) -> String {
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// SHA-256 of a text, hexadecimal.
pub fn sha256_of(text: &str) -> String {
    hexadecimal(Sha256::new_with_prefix(text))
}

/// Hashes what a reader holds to its end.
pub fn hash_of(mut from: impl Read) -> io::Result<WrittenHash> {
    let hash = WrittenHash::default();
    let mut piece = vec![0; 1 << 16];
    loop {
        match from.read(&mut piece)? {
            0 => return Ok(hash),
            n => hash.take(&piece[..n]),
        }
    }
}

/// SHA-256 of a file, hexadecimal.
pub fn sha256_of_file(path: &Path) -> io::Result<String> {
    #[expect(clippy::disallowed_methods, reason = "a result that was written, now or before")]
    let file = File::open(path)?;
    Ok(hash_of(file)?.hex())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The digest of "abc" is that of FIPS 180-4's example (NIST), whole or in pieces.
    #[test]
    fn reference_the_hash_is_that_of_what_was_written() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        let hash = WrittenHash::default();
        let mut out = Hashed::new(Vec::new(), hash.clone());
        out.write_all(b"a").unwrap();
        out.write_all(b"bc").unwrap();
        assert_eq!((hash.hex().as_str(), sha256_of("abc").as_str()), (expected, expected));
        assert_eq!(hash_of(&b"abc"[..]).unwrap().hex(), expected);
    }
}
