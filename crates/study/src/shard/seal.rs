//! The seal of a part's file: its SHA-256 in its own metadata, so that no byte of it changes unnoticed.
//!
//! The digest is that of the whole file with 64 zeros in the digest's place, in the footer, where any reader
//! of Parquet finds it under [`SEAL`].

use std::io::{self, Read, Seek, SeekFrom, Write};

use sha2::{Digest as _, Sha256};

/// Key of the digest in the metadata.
pub const SEAL: &str = "samara.sha256";
/// What stands in the digest's place until the file is sealed.
pub const UNSEALED: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Bytes between key and value of a pair, in Thrift's compact protocol: type, and length of the value.
const BETWEEN: usize = 2;
/// Most bytes of a footer.
const FOOTER_MOST: u64 = 1 << 28;

/// Seals a file that was written with [`UNSEALED`] under [`SEAL`].
///
/// # Errors
/// [`io::Error`] where it cannot be read or written, or is no such file.
pub fn seal(file: &mut (impl Read + Write + Seek)) -> io::Result<()> {
    let unsealed = || io::Error::new(io::ErrorKind::InvalidData, "a file to be sealed is expected");
    let (place, found) = digest_place(file)?.ok_or_else(unsealed)?;
    if found != UNSEALED.as_bytes() {
        return Err(unsealed());
    }
    let digest = digest(file, place)?;
    file.seek(SeekFrom::Start(place))?;
    file.write_all(digest.as_bytes())?;
    file.seek(SeekFrom::End(0))?;
    file.flush()
}

/// Whether a file is sealed, and as it was then.
///
/// # Errors
/// [`io::Error`] where it cannot be read.
pub fn is_sealed(file: &mut (impl Read + Seek)) -> io::Result<bool> {
    let Some((place, found)) = digest_place(file)? else { return Ok(false) };
    Ok(digest(file, place)?.as_bytes() == found)
}

/// Where the digest stands, and what stands there; `None` in a file that has none.
fn digest_place(file: &mut (impl Read + Seek)) -> io::Result<Option<(u64, Vec<u8>)>> {
    let length = file.seek(SeekFrom::End(0))?;
    // A Parquet file ends with its footer, the footer's length and four letters.
    let Some(end) = length.checked_sub(8) else { return Ok(None) };
    let mut tail = [0; 4];
    file.seek(SeekFrom::Start(end))?;
    file.read_exact(&mut tail)?;
    let footer_length = u64::from(u32::from_le_bytes(tail));
    let Some(begin) = end.checked_sub(footer_length).filter(|_| footer_length <= FOOTER_MOST) else {
        return Ok(None);
    };
    let mut footer = Vec::new();
    file.seek(SeekFrom::Start(begin))?;
    file.by_ref().take(footer_length).read_to_end(&mut footer)?;
    let Some(key) = footer.windows(SEAL.len()).rposition(|bytes| bytes == SEAL.as_bytes()) else {
        return Ok(None);
    };
    let at = key + SEAL.len() + BETWEEN;
    let found = footer.get(at..at + UNSEALED.len());
    Ok(found.map(|found| (begin + at as u64, found.to_vec())))
}

/// SHA-256 of a file with zeros for the digest, hexadecimal.
fn digest(file: &mut (impl Read + Seek), place: u64) -> io::Result<String> {
    let mut hash = Sha256::new();
    file.seek(SeekFrom::Start(0))?;
    hash_all(&mut file.by_ref().take(place), &mut hash)?;
    hash.update(UNSEALED);
    file.seek(SeekFrom::Start(place + UNSEALED.len() as u64))?;
    hash_all(file, &mut hash)?;
    Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}

fn hash_all(from: &mut impl Read, hash: &mut Sha256) -> io::Result<()> {
    let mut piece = vec![0; 1 << 16];
    loop {
        match from.read(&mut piece)? {
            0 => return Ok(()),
            n => hash.update(&piece[..n]),
        }
    }
}
