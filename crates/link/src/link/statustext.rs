//! Texts as STATUSTEXT messages and back, as MAVLink's description of that message has it.
//!
//! One message holds 50 bytes. A longer text goes in pieces that share an `id` other than 0 and count up in
//! `chunk_seq`; a receiver takes a piece with a zero byte in it for the last one. Hence every piece but the
//! last is full, and a text whose last piece would be full as well is followed by an empty one. A character
//! is never torn apart, since ground stations decode piece by piece: where one does not fit any more, spaces
//! fill the piece.

use std::collections::BTreeMap;

use mavlink::dialects::common::{MavSeverity, STATUSTEXT_DATA};

use crate::printable::printable;

/// Bytes of text in one message.
const PIECE: usize = 50;

/// Makes the messages of one sender.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TextWriter {
    long_texts: u16,
}

impl TextWriter {
    /// The messages that carry `text`.
    pub(super) fn messages(&mut self, severity: MavSeverity, text: &str) -> Vec<STATUSTEXT_DATA> {
        let mut pieces = pieces(text);
        let mut id = 0;
        if pieces.len() > 1 {
            self.long_texts = self.long_texts.wrapping_add(1).max(1);
            id = self.long_texts;
            // The end would go unnoticed.
            if pieces.last().is_some_and(|last| !last.contains(&0)) {
                pieces.push([0; PIECE]);
            }
        }
        let message = |(chunk_seq, piece): (u8, [u8; PIECE])| {
            let text = piece.into();
            STATUSTEXT_DATA { severity, text, id, chunk_seq }
        };
        // A 257th piece could not be numbered.
        (0..=u8::MAX).zip(pieces).map(message).collect()
    }
}

/// The text in pieces, full but for the last.
fn pieces(text: &str) -> Vec<[u8; PIECE]> {
    let mut pieces = Vec::new();
    let mut rest = text;
    loop {
        let last = rest.len() <= PIECE;
        let fits = (0..=rest.len().min(PIECE)).rev().find(|&i| rest.is_char_boundary(i));
        let (head, tail) = rest.split_at(fits.unwrap_or(0));
        let mut piece = [if last { 0 } else { b' ' }; PIECE];
        piece[..head.len()].copy_from_slice(head.as_bytes());
        pieces.push(piece);
        if last {
            return pieces;
        }
        rest = tail;
    }
}

/// Most senders whose texts are put together at a time.
const MOST_SENDERS: usize = 16;
/// Stands where pieces of a text have not come.
const GAP: &[u8] = b"...";

/// A text whose end has not come.
#[derive(Clone, Debug)]
struct Unfinished {
    id: u16,
    /// The number of the latest piece.
    piece: u8,
    bytes: Vec<u8>,
}

/// Puts the pieces of several senders together. What it holds is bounded: a text has 256 pieces at most, and
/// 16 senders have one under way.
#[derive(Clone, Debug, Default)]
pub(super) struct TextReader {
    unfinished: BTreeMap<(u8, u8), Unfinished>,
}

impl TextReader {
    /// The texts that are known with this message of `sender` (system, component), made [`printable`]: mostly
    /// one, none while pieces are missing. One whose end has not come (lost, or a full last piece without the
    /// empty one after it) is returned with the next, and so is one whose pieces begin anew. A piece that has
    /// come twice counts once.
    pub(super) fn take(&mut self, sender: (u8, u8), message: &STATUSTEXT_DATA) -> Vec<String> {
        let readable = |bytes: &[u8]| printable(&String::from_utf8_lossy(bytes)).into_owned();
        let length = message.text.iter().position(|&c| c == 0);
        let piece = &message.text[..length.unwrap_or(PIECE)];
        let mut texts = Vec::new();
        let mut text = Vec::new();
        if let Some(earlier) = self.unfinished.remove(&sender) {
            let goes_on = earlier.id == message.id && message.chunk_seq >= earlier.piece;
            if goes_on && message.chunk_seq == earlier.piece {
                self.unfinished.insert(sender, earlier);
                return texts;
            }
            if goes_on {
                text = earlier.bytes;
                text.extend_from_slice(if message.chunk_seq - earlier.piece > 1 { GAP } else { &[] });
            } else {
                texts.push(readable(&earlier.bytes));
            }
        }
        text.extend_from_slice(piece);
        if message.id == 0 || length.is_some() || message.chunk_seq == u8::MAX {
            texts.push(readable(&text));
            return texts;
        }
        if self.unfinished.len() == MOST_SENDERS {
            // Another sender's: nobody's text by this one's name.
            self.unfinished.pop_first();
        }
        self.unfinished.insert(sender, Unfinished { id: message.id, piece: message.chunk_seq, bytes: text });
        texts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sent(text: &str) -> Vec<STATUSTEXT_DATA> {
        TextWriter::default().messages(MavSeverity::MAV_SEVERITY_INFO, text)
    }

    /// As MAVSDK puts pieces together: up to one with a zero byte; and each piece must be readable by itself,
    /// as for QGroundControl. `None`: the end never comes.
    fn received(messages: &[STATUSTEXT_DATA]) -> Option<String> {
        let mut whole = String::new();
        for (i, m) in messages.iter().enumerate() {
            assert_eq!(usize::from(m.chunk_seq), i);
            whole += m.text.to_str().unwrap();
            if m.id == 0 || m.text.contains(&0) {
                assert_eq!(i + 1, messages.len(), "nothing after the end");
                return Some(whole);
            }
        }
        None
    }

    #[test]
    fn reference_a_text_arrives_whole_whatever_its_length() {
        for length in [0, 1, 49, 50, 51, 99, 100, 101, 150, 5_000] {
            let text: String = ('a'..='z').cycle().take(length).collect();
            let messages = sent(&text);
            assert_eq!(received(&messages).as_deref(), Some(text.as_str()), "{length}");
            assert_eq!(messages.len() == 1, length <= 50, "{length}");
            assert!(messages.iter().all(|m| (m.id == 0) == (length <= 50)), "{length}");
        }
        assert_eq!(sent(&"x".repeat(100)).len(), 3, "an empty piece ends it");
    }

    #[test]
    fn prop_what_is_written_is_read() {
        let (mut writer, mut reader) = (TextWriter::default(), TextReader::default());
        for length in (0..130).chain([149, 150, 151, 2_000]) {
            let text: String = ('a'..='z').cycle().take(length).collect();
            let messages = writer.messages(MavSeverity::MAV_SEVERITY_INFO, &text);
            // Somebody else speaks in between.
            let read = messages.iter().flat_map(|m| {
                assert_eq!(reader.take((1, 161), &sent("me too")[0]), ["me too"]);
                reader.take((1, 1), m)
            });
            assert_eq!(read.collect::<Vec<_>>(), [text], "{length}");
        }
    }

    /// PX4 numbers every text, and ends none that fills its last piece.
    #[test]
    fn reference_a_text_of_px4_that_never_ends_is_reported_with_the_next() {
        let mut reader = TextReader::default();
        let numbered = |id, text: &str| STATUSTEXT_DATA { id, ..sent(text)[0].clone() };
        assert!(reader.take((1, 1), &numbered(7, &"x".repeat(50))).is_empty());
        assert_eq!(reader.take((1, 1), &numbered(8, "short")), ["x".repeat(50), "short".to_owned()]);
        assert!(reader.unfinished.is_empty());
    }

    /// Full pieces of one text over and over, by many: 92 MB a second were kept of them.
    #[test]
    fn regress_a_text_without_an_end_is_bounded() {
        let full = |id, chunk_seq| STATUSTEXT_DATA { id, chunk_seq, ..sent(&"x".repeat(50))[0].clone() };
        let mut reader = TextReader::default();
        let held = |reader: &TextReader| -> usize { reader.unfinished.values().map(|u| u.bytes.len()).sum() };
        for i in 0..20_000_u32 {
            let sender = ((i % 7) as u8, (i % 5) as u8);
            // The same piece, pieces that count up, and every second one.
            let chunk_seq = [3, i as u8, (2 * i) as u8][i as usize / 7_000];
            for text in reader.take(sender, &full(7, chunk_seq)) {
                assert!(text.len() <= 256 * 53, "{}", text.len());
            }
            assert!(reader.unfinished.len() <= MOST_SENDERS && held(&reader) <= MOST_SENDERS * 256 * 53);
        }
        let mut reader = TextReader::default();
        let whole: Vec<String> = (0..=255).flat_map(|piece| reader.take((1, 1), &full(7, piece))).collect();
        assert_eq!(whole, ["x".repeat(256 * 50)], "the last piece that can be numbered ends it");
        assert!(reader.unfinished.is_empty());
    }

    /// MAVLink's description of STATUSTEXT: pieces are numbered, and some may be lost.
    #[test]
    fn a_lost_piece_leaves_a_gap_and_a_doubled_one_counts_once() {
        let pieces = sent(&["a", "b", "c", "d"].map(|c| c.repeat(50)).concat());
        let read = |order: &[usize]| {
            let mut reader = TextReader::default();
            order.iter().flat_map(|i| reader.take((1, 1), &pieces[*i])).collect::<Vec<_>>()
        };
        let [a, b, c, d] = ["a", "b", "c", "d"].map(|c| c.repeat(50));
        assert_eq!(read(&[0, 0, 1, 2, 2, 3, 4]), [format!("{a}{b}{c}{d}")]);
        assert_eq!(read(&[0, 1, 3, 4]), [format!("{a}{b}...{d}")]);
        assert_eq!(read(&[0, 1, 0, 1, 2, 3, 4]), [format!("{a}{b}"), format!("{a}{b}{c}{d}")]);
    }

    /// What would act on a terminal is written as a word: an earlier version cleared the screen and wrote
    /// lines of its own.
    #[test]
    fn regress_a_text_acts_on_no_terminal() {
        let mut reader = TextReader::default();
        let raw = "\u{1b}[2J\u{1b}[1;1Hgood\r evil\u{202e}\n";
        assert_eq!(reader.take((1, 1), &sent(raw)[0]), [r"\x1b[2J\x1b[1;1Hgood\x0d evil\u{202e}\x0a"]);
    }

    #[test]
    fn prop_a_character_is_never_torn_apart() {
        for before in 45..=50 {
            for character in ["é", "²", "→", "𝜏"] {
                let text = format!("{}{character} and on", "x".repeat(before));
                let whole = received(&sent(&text)).unwrap();
                let fill = if before < 50 && before + character.len() > 50 { 50 - before } else { 0 };
                assert_eq!(whole, text.replacen(character, &(" ".repeat(fill) + character), 1), "{before}");
            }
        }
    }

    #[test]
    fn long_texts_have_numbers_of_their_own() {
        let (mut writer, long) = (TextWriter { long_texts: u16::MAX - 1 }, "x".repeat(51));
        let ids = [(); 3].map(|()| writer.messages(MavSeverity::MAV_SEVERITY_INFO, &long)[0].id);
        assert_eq!(ids, [u16::MAX, 1, 2], "0 is for texts in one piece");
    }
}
