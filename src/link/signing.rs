//! MAVLink 2 signing: only holders of the key may send, and nobody may play back what was sent.
//!
//! A signature is 13 bytes behind the checksum: link id, 48 bits of time in units of 10 us since 2015-01-01
//! UTC, and the first 6 bytes of SHA-256 over key, frame (from the start marker to the checksum), link id and
//! time (<https://mavlink.io/en/guide/message_signing.html>).
//!
//! Time comes as an argument. The protocol wants the real time there: a receiver that does not know a sender
//! yet takes nothing from it that is more than a minute behind its own clock.

use mavlink::MessageData as _;
use mavlink::dialects::common::RADIO_STATUS_DATA;
use sha2::{Digest, Sha256};

use super::frame::{Frame, SIGNATURE_LEN};

/// 2015-01-01 00:00 UTC in Unix microseconds.
const EPOCH_UNIX_US: u64 = 1_420_070_400_000_000;
/// One minute, the age up to which a new sender is believed.
const NEW_STREAM_WINDOW: u64 = 6_000_000;
/// Most senders whose last time stamps are remembered; a further one is not believed.
const MAX_STREAMS: usize = 256;
/// Bytes of the digest that are sent.
const DIGEST_LEN: usize = 6;

/// A reason why a text is no key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// Nothing there.
    #[error("the key is empty: 64 hexadecimal digits or a passphrase are expected")]
    Empty,
}

/// The secret of 32 bytes that both sides have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Key([u8; 32]);

impl Key {
    /// The key itself.
    pub fn from_bytes(bytes: [u8; 32]) -> Self {
        Self(bytes)
    }

    /// The key that QGroundControl and MAVProxy make of a passphrase: its SHA-256.
    pub fn from_passphrase(passphrase: &str) -> Self {
        Self(Sha256::digest(passphrase.as_bytes()).into())
    }

    /// Reads a key file: 64 hexadecimal digits are the key, any other text is a passphrase. A line break at
    /// the end is not part of it.
    ///
    /// # Errors
    /// [`KeyError`] for an empty text.
    pub fn parse(text: &str) -> Result<Self, KeyError> {
        let text = text.trim_end_matches(['\n', '\r']);
        if text.is_empty() {
            return Err(KeyError::Empty);
        }
        Ok(hexadecimal(text).map_or_else(|| Self::from_passphrase(text), Self))
    }

    fn sign(&self, signed_part: &[u8]) -> [u8; DIGEST_LEN] {
        let digest = Sha256::new().chain_update(self.0).chain_update(signed_part).finalize();
        std::array::from_fn(|i| digest[i])
    }
}

/// A key is not shown.
impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Key(..)")
    }
}

fn hexadecimal(text: &str) -> Option<[u8; 32]> {
    let digits = text.as_bytes();
    if digits.len() != 64 || !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    let mut key = [0; 32];
    for (byte, pair) in key.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?;
    }
    Some(key)
}

/// A reason why a frame is not let in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// It is not signed.
    Unsigned,
    /// It is signed with another key, or was changed on the way.
    BadSignature,
    /// It is not newer than what came before, or too old for a sender that is new.
    Replayed,
}

/// One sender on one of its links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stream {
    link_id: u8,
    system_id: u8,
    component_id: u8,
    newest: u64,
}

/// Signs what is sent and checks what comes.
#[derive(Clone, Debug)]
pub struct Signing {
    key: Key,
    /// The latest time stamp used or believed.
    latest: u64,
    streams: Vec<Stream>,
}

impl Signing {
    /// With a key; nothing sent or heard yet.
    pub fn new(key: Key) -> Self {
        Self { key, latest: 0, streams: Vec::new() }
    }

    /// Appends the signature to a frame that ends in its checksum and carries the "signed" flag.
    pub fn append(&mut self, frame: &mut Vec<u8>, link_id: u8, now_unix_us: u64) {
        // Each stamp is later than the last, however fast frames follow each other.
        self.latest = protocol_time(now_unix_us).max(self.latest + 1);
        frame.push(link_id);
        frame.extend_from_slice(&self.latest.to_le_bytes()[..6]);
        let digest = self.key.sign(frame);
        frame.extend_from_slice(&digest);
    }

    /// Whether a frame may be let in.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub fn check(&mut self, frame: &Frame, now_unix_us: u64) -> Result<(), Refusal> {
        if !frame.is_signed() {
            // Made by radios on the way, which have no key.
            return if frame.message_id == RADIO_STATUS_DATA::ID { Ok(()) } else { Err(Refusal::Unsigned) };
        }
        let bytes = frame.bytes();
        let (signed_part, digest) = bytes.split_at(bytes.len() - DIGEST_LEN);
        if self.key.sign(signed_part) != digest {
            return Err(Refusal::BadSignature);
        }
        let at = bytes.len() - SIGNATURE_LEN;
        let (link_id, mut stamp) = (bytes[at], [0; 8]);
        stamp[..6].copy_from_slice(&bytes[at + 1..at + 7]);
        let stamp = u64::from_le_bytes(stamp);
        let sender = |s: &Stream| {
            (s.link_id, s.system_id, s.component_id) == (link_id, frame.system_id, frame.component_id)
        };
        self.latest = self.latest.max(protocol_time(now_unix_us));
        let full = self.streams.len() == MAX_STREAMS;
        match self.streams.iter_mut().find(|s| sender(s)) {
            Some(stream) if stamp <= stream.newest => return Err(Refusal::Replayed),
            Some(stream) => stream.newest = stamp,
            None if stamp + NEW_STREAM_WINDOW < self.latest || full => {
                return Err(Refusal::Replayed);
            }
            None => {
                let (system_id, component_id) = (frame.system_id, frame.component_id);
                self.streams.push(Stream { link_id, system_id, component_id, newest: stamp });
            }
        }
        // Who is ahead of us by his clock shall not take us for a replay.
        self.latest = self.latest.max(stamp);
        Ok(())
    }
}

/// The protocol's time of a Unix time; 0 before 2015.
fn protocol_time(unix_us: u64) -> u64 {
    unix_us.saturating_sub(EPOCH_UNIX_US) / 10
}

#[cfg(test)]
mod tests;
