//! The texts of PX4's events, from metadata as PX4 keeps and serves them: JSON compressed by xz.

use std::io;
use std::sync::Arc;

use super::super::px4_events::EventTexts;
use super::super::streamer::StreamerSession;

/// Metadata that become longer than this are none: PX4's are 150 kB.
const LONGEST: usize = 8 << 20;

/// A writer that takes no more than so much.
struct Bounded(Vec<u8>);

impl io::Write for Bounded {
    fn write(&mut self, part: &[u8]) -> io::Result<usize> {
        if self.0.len() + part.len() > LONGEST {
            return Err(io::Error::other("more than 8 MiB"));
        }
        self.0.extend_from_slice(part);
        Ok(part.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The texts in a file's bytes.
///
/// # Errors
/// What is wrong with them, in words: not xz, too long, or no metadata of events.
pub fn event_texts(xz: &[u8]) -> Result<EventTexts, String> {
    let mut json = Bounded(Vec::new());
    lzma_rs::xz_decompress(&mut &xz[..], &mut json)
        .map_err(|e| format!("metadata of PX4's events: {e:?}"))?;
    EventTexts::parse(&json.0).map_err(|e| e.to_string())
}

/// Reads the metadata that a streamer has fetched, if it has, and gives them back as texts.
pub(super) fn read_fetched(session: &mut StreamerSession) {
    if let Some(metadata) = session.poll_event_metadata() {
        match event_texts(&metadata) {
            Ok(texts) => session.know_events(Arc::new(texts)),
            Err(why) => session.miss_events(why),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_xz_or_no_metadata_is_said_to_be_so() {
        let mut packed = Vec::new();
        let json = br#"{"version":2,"components":{"1":{"namespace":"px4"}}}"#;
        lzma_rs::xz_compress(&mut &json[..], &mut packed).unwrap();
        assert!(event_texts(&packed).unwrap().is_empty());
        let flipped: Vec<u8> = packed.iter().enumerate().map(|(i, b)| b ^ u8::from(i == 0)).collect();
        for bytes in [&b""[..], b"{}", &packed[..packed.len() / 2], &flipped] {
            let why = event_texts(bytes).unwrap_err();
            assert!(why.starts_with("metadata of PX4's events: "), "{why}");
        }
        let zeros = vec![0; LONGEST + 1];
        let mut bomb = Vec::new();
        lzma_rs::xz_compress(&mut &zeros[..], &mut bomb).unwrap();
        assert!(event_texts(&bomb).unwrap_err().contains("more than 8 MiB"));
    }
}
