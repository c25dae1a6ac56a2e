//! Texts as STATUSTEXT messages and back, as MAVLink's description of that message has it.
//!
//! One message holds 50 bytes. A longer text goes in pieces that share an `id` other than 0 and count up in
//! `chunk_seq`; a receiver takes a piece with a zero byte in it for the last one. Hence every piece but the
//! last is full, and a text whose last piece would be full as well is followed by an empty one. A character
//! is never torn apart, since ground stations decode piece by piece: where one does not fit any more, spaces
//! fill the piece.

use std::collections::BTreeMap;

use mavlink::dialects::common::{MavSeverity, STATUSTEXT_DATA};

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

/// Puts the pieces of several senders together.
#[derive(Clone, Debug, Default)]
pub(super) struct TextReader {
    unfinished: BTreeMap<(u8, u8), (u16, Vec<u8>)>,
}

impl TextReader {
    /// The texts that are known with this message of `sender` (system, component): mostly one, none while
    /// pieces are missing. One whose end has not come (lost, or a full last piece without the empty one after
    /// it) is returned with the next.
    pub(super) fn take(&mut self, sender: (u8, u8), message: &STATUSTEXT_DATA) -> Vec<String> {
        let readable = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let length = message.text.iter().position(|&c| c == 0);
        let piece = &message.text[..length.unwrap_or(PIECE)];
        let mut texts = Vec::new();
        if let Some((id, text)) = self.unfinished.remove(&sender) {
            if id == message.id {
                self.unfinished.insert(sender, (id, text));
            } else {
                texts.push(readable(&text));
            }
        }
        if message.id == 0 {
            texts.push(readable(piece));
            return texts;
        }
        let (_, text) = self.unfinished.entry(sender).or_insert((message.id, Vec::new()));
        text.extend_from_slice(piece);
        if length.is_some() || message.chunk_seq == u8::MAX {
            texts.push(readable(text));
            self.unfinished.remove(&sender);
        }
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
