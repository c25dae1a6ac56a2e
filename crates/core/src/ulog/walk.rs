//! Message by message through a log, past what is wrong in it.
//!
//! A message is its length (u16, without these three bytes), its type (a letter) and its body. Where one
//! cannot be - an unknown type, a row of a subscription that is not there, or not of its length - the next
//! place is looked for from which three follow that can be.

use std::ops::Range;

/// So many messages must follow a place behind what is wrong.
const IN_A_ROW: usize = 3;
const HEAD: usize = 3;

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Message {
    pub(super) kind: u8,
    pub(super) body: Range<usize>,
}

/// Whether a row of a subscription may have so many bytes.
pub(super) type Fits<'f> = dyn Fn(u16, usize) -> bool + 'f;

/// The messages of a part of a file.
pub(super) struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
    /// What was passed over.
    pub(super) lost: Vec<Range<usize>>,
}

impl<'a> Walk<'a> {
    pub(super) fn new(bytes: &'a [u8], part: Range<usize>) -> Self {
        Self { bytes, at: part.start, end: part.end.min(bytes.len()), lost: Vec::new() }
    }

    /// The next message.
    pub(super) fn next(&mut self, fits: &Fits<'_>) -> Option<Message> {
        if self.at >= self.end {
            return None;
        }
        let message = self.message_at(self.at, fits).or_else(|| {
            let next = (self.at + 1..self.end).find(|at| self.follow(*at, fits));
            self.lost.push(self.at..next.unwrap_or(self.end));
            self.message_at(next?, fits)
        });
        self.at = message.as_ref().map_or(self.end, |message| message.body.end);
        message
    }

    /// Whether messages follow one another from here, or to the end.
    fn follow(&self, at: usize, fits: &Fits<'_>) -> bool {
        let mut at = at;
        let mut subscribed = None;
        for count in 0..IN_A_ROW {
            if at == self.end {
                return count > 0;
            }
            // A subscription may be what comes first.
            let message = self.message_at(at, &|id, size| fits(id, size) || Some(id) == subscribed);
            let Some(message) = message else { return false };
            if let (b'A', Some([_, low, high])) =
                (message.kind, self.bytes.get(message.body.start..).and_then(<[u8]>::first_chunk))
            {
                subscribed = Some(u16::from_le_bytes([*low, *high]));
            }
            at = message.body.end;
        }
        true
    }

    fn message_at(&self, at: usize, fits: &Fits<'_>) -> Option<Message> {
        let head = self.bytes.get(at..at + HEAD)?;
        let (size, kind) = (usize::from(u16::from_le_bytes([head[0], head[1]])), head[2]);
        let body = at + HEAD..at + HEAD + size;
        let bytes = self.bytes.get(body.clone()).filter(|_| body.end <= self.end)?;
        can_be(kind, bytes, fits).then_some(Message { kind, body })
    }
}

/// Whether a message of this type can have this body.
fn can_be(kind: u8, body: &[u8], fits: &Fits<'_>) -> bool {
    let size = body.len();
    // A length, a type with a name, and a value behind that.
    let is_keyed = |body: &[u8], value: Range<usize>| match body.split_first() {
        None => false,
        Some((length, rest)) => rest.split_at_checked(usize::from(*length)).is_some_and(|(key, behind)| {
            value.contains(&behind.len())
                && key.contains(&b' ')
                && key.iter().all(|b| (b' '..=b'~').contains(b))
        }),
    };
    match kind {
        b'B' => size >= 40,
        b'F' => body.contains(&b':') && body.iter().all(|b| (b' '..=b'~').contains(b)),
        b'A' => size > 3 && body.iter().skip(3).all(u8::is_ascii_graphic),
        b'D' => body.first_chunk().is_some_and(|id| fits(u16::from_le_bytes(*id), size)),
        b'I' => is_keyed(body, 1..usize::MAX),
        b'P' => is_keyed(body, 4..5),
        // Behind what goes on, or which default it is.
        b'M' => is_keyed(body.get(1..).unwrap_or_default(), 0..usize::MAX),
        b'Q' => is_keyed(body.get(1..).unwrap_or_default(), 4..5),
        b'L' => size >= 9,
        b'C' => size >= 11,
        b'R' | b'O' => size == 2,
        b'S' => size == 8,
        _ => false,
    }
}
