//! MAVLink 2 signing: only holders of the key may send, and nobody may play back what was sent.
//!
//! A signature is 13 bytes behind the checksum: link id, 48 bits of time in units of 10 us since 2015-01-01
//! UTC, and the first 6 bytes of SHA-256 over key, frame (from the start marker to the checksum), link id and
//! time (<https://mavlink.io/en/guide/message_signing.html>).
//!
//! Time comes as an argument. The protocol wants the real time there: a receiver takes nobody's stamps that
//! are more than a minute ahead of its own clock, and those of a sender that it does not know yet only if
//! they are not more than a minute behind. Its own clock is the measure, and not the latest stamp that it has
//! believed, as in the protocol's C library: there one sender that is ahead locks out all others.

use sha2::{Digest, Sha256};

use super::frame::{Frame, SIGNATURE_LEN};
use super::stamps::{AHEAD, LAST_STAMP, MAX_STREAMS, Stamps, Stream};

/// 2015-01-01 00:00 UTC in Unix microseconds.
const EPOCH_UNIX_US: u64 = 1_420_070_400_000_000;
/// One minute: by so much a stamp may be ahead of our clock, and that of a new sender behind.
const WINDOW: u64 = 6_000_000;
/// Bytes of the digest that are sent.
const DIGEST_LEN: usize = 6;

/// A reason why a text is no key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum KeyError {
    /// Nothing there.
    #[error("the key is empty: 64 hexadecimal digits or a passphrase are expected")]
    Empty,
    /// Almost a key.
    #[error("{0} hexadecimal digits: a key has 64; a passphrase that looks like a cut key is not taken")]
    Digits(usize),
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
    /// [`KeyError`] for an empty text, and for 48 to 80 hexadecimal digits that are not 64.
    pub fn parse(text: &str) -> Result<Self, KeyError> {
        let text = text.trim_end_matches(['\n', '\r']);
        if text.is_empty() {
            return Err(KeyError::Empty);
        }
        let is_hexadecimal = text.bytes().all(|b| b.is_ascii_hexdigit());
        if is_hexadecimal && (48..=80).contains(&text.len()) && text.len() != 64 {
            return Err(KeyError::Digits(text.len()));
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
    /// It is not newer than what came before.
    Replayed,
    /// It is signed by our key, but this many seconds ahead of our clock, or (negative), by a sender that is
    /// new, behind it: the clocks of the machines differ, or it was recorded.
    Clock(i64),
}

/// A clock that no frame can be signed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ClockError {
    /// It says a time before the stamps begin.
    #[error("this machine's clock is before 2015, when the stamps of signed frames begin: set it")]
    BeforeEpoch,
    /// It is this many seconds behind the last stamp of an earlier run, more than a minute: nobody whose
    /// clock is right would believe what follows.
    #[error(
        "this machine's clock is {0} s behind the last stamp there: set it, or remove the file if the clock was \
         wrong then"
    )]
    Behind(u64),
}

/// Signs what is sent and checks what comes.
#[derive(Clone, Debug)]
pub struct Signing {
    key: Key,
    stamps: Stamps,
    /// As they were given out to be kept last.
    kept: Stamps,
}

impl Signing {
    /// With a key; nothing sent or heard yet.
    pub fn new(key: Key) -> Self {
        Self { key, stamps: Stamps::default(), kept: Stamps::default() }
    }

    /// Goes on from the stamps of an earlier run.
    ///
    /// # Errors
    /// [`ClockError`] when nobody could follow by a clock like this.
    pub fn resume(&mut self, stamps: Stamps, now_unix_us: u64) -> Result<(), ClockError> {
        let ahead = stamps.last().saturating_sub(protocol_time(now_unix_us));
        if now_unix_us < EPOCH_UNIX_US {
            return Err(ClockError::BeforeEpoch);
        }
        if ahead > WINDOW + AHEAD {
            return Err(ClockError::Behind(ahead / 100_000));
        }
        self.kept = stamps.clone();
        self.stamps = stamps;
        Ok(())
    }

    /// The last stamps as they are.
    pub fn stamps(&self) -> &Stamps {
        &self.stamps
    }

    /// The stamps to be kept for the next start, when those that were kept last no longer hold: ten seconds
    /// ahead, so that this is seldom.
    pub fn poll_stamps(&mut self) -> Option<Stamps> {
        if self.stamps.is_within(&self.kept) {
            return None;
        }
        self.kept = self.stamps.ahead();
        Some(self.kept.clone())
    }

    /// Appends the signature to a frame that ends in its checksum and carries the "signed" flag.
    pub fn append(&mut self, frame: &mut Vec<u8>, link_id: u8, now_unix_us: u64) {
        // Each stamp is later than the last, however fast frames follow each other.
        self.stamps.latest = protocol_time(now_unix_us).max(self.stamps.latest + 1).min(LAST_STAMP);
        frame.push(link_id);
        frame.extend_from_slice(&self.stamps.latest.to_le_bytes()[..6]);
        let digest = self.key.sign(frame);
        frame.extend_from_slice(&digest);
    }

    /// Whether a frame is signed by our key. Nothing is remembered of it.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub fn verify(&self, frame: &Frame) -> Result<(), Refusal> {
        if !frame.is_signed() {
            return Err(Refusal::Unsigned);
        }
        let bytes = frame.bytes();
        let (signed_part, digest) = bytes.split_at(bytes.len() - DIGEST_LEN);
        if self.key.sign(signed_part) == digest { Ok(()) } else { Err(Refusal::BadSignature) }
    }

    /// Whether a frame may be let in: signed by our key, and later than what came before.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub fn check(&mut self, frame: &Frame, now_unix_us: u64) -> Result<(), Refusal> {
        self.verify(frame)?;
        self.check_stamp(frame, now_unix_us)
    }

    /// Whether the stamp of a frame that is signed by our key ([`Self::verify`]) is later than what came
    /// before.
    ///
    /// # Errors
    /// [`Refusal`] with the reason.
    pub(super) fn check_stamp(&mut self, frame: &Frame, now_unix_us: u64) -> Result<(), Refusal> {
        let bytes = frame.bytes();
        let at = bytes.len() - SIGNATURE_LEN;
        let (link_id, mut stamp) = (bytes[at], [0; 8]);
        stamp[..6].copy_from_slice(&bytes[at + 1..at + 7]);
        let stamp = u64::from_le_bytes(stamp);
        let clock = protocol_time(now_unix_us);
        if stamp > clock + WINDOW {
            return Err(Refusal::Clock(seconds_ahead(stamp, clock)));
        }
        let (system_id, component_id) = (frame.system_id, frame.component_id);
        let sender =
            |s: &Stream| (s.link_id, s.system_id, s.component_id) == (link_id, system_id, component_id);
        self.stamps.latest = self.stamps.latest.max(clock);
        match self.stamps.streams.iter_mut().find(|s| sender(s)) {
            Some(stream) if stamp <= stream.newest => return Err(Refusal::Replayed),
            Some(stream) => stream.newest = stamp,
            None if stamp + WINDOW < clock => return Err(Refusal::Clock(seconds_ahead(stamp, clock))),
            None if stamp <= self.stamps.forgotten => return Err(Refusal::Replayed),
            None => {
                self.make_room();
                self.stamps.streams.push(Stream { link_id, system_id, component_id, newest: stamp });
            }
        }
        Ok(())
    }

    /// Forgets the sender that was heard longest ago, if there is no room for another.
    fn make_room(&mut self) {
        if self.stamps.streams.len() < MAX_STREAMS {
            return;
        }
        if let Some(i) = (0..self.stamps.streams.len()).min_by_key(|i| self.stamps.streams[*i].newest) {
            self.stamps.forgotten = self.stamps.forgotten.max(self.stamps.streams.swap_remove(i).newest);
        }
    }
}

/// How many seconds a stamp is ahead of a time of the protocol (negative: behind).
fn seconds_ahead(stamp: u64, time: u64) -> i64 {
    (stamp.cast_signed() - time.cast_signed()) / 100_000
}

/// The protocol's time of a Unix time; 0 before 2015.
fn protocol_time(unix_us: u64) -> u64 {
    unix_us.saturating_sub(EPOCH_UNIX_US) / 10
}

#[cfg(test)]
mod tests;
