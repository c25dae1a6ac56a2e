//! The texts of PX4's events, from metadata as PX4 keeps and serves them: JSON compressed by xz.

use std::io::Read;
use std::sync::Arc;

use lzma_rust2::XzReader;

use super::super::px4_events::EventTexts;
use super::super::streamer::StreamerSession;

/// Metadata that become longer than this [bytes] are none: PX4's are 150 kB.
const LONGEST: usize = 2 << 20;
/// Most memory that the decoder may use [KiB]: what `xz -9` asks for is 64 MiB and a little. What is used is
/// no more than what has come out.
const MOST_KIB: u32 = 65 << 10;

/// The texts in a file's bytes.
///
/// # Errors
/// What is wrong with them, in words: not xz, too long, or no metadata of events.
pub fn event_texts(xz: &[u8]) -> Result<EventTexts, String> {
    let json = unpacked(xz).map_err(|why| format!("metadata of PX4's events: {why}"))?;
    EventTexts::parse(&json).map_err(|e| e.to_string())
}

/// What is packed, as long as it is no longer than [`LONGEST`]: nothing is unpacked beyond.
fn unpacked(xz: impl Read) -> Result<Vec<u8>, String> {
    let mut json = Vec::new();
    let reader = XzReader::new_mem_limit(xz, false, MOST_KIB);
    reader.take(LONGEST as u64 + 1).read_to_end(&mut json).map_err(|e| e.to_string())?;
    if json.len() > LONGEST {
        return Err(format!("more than {} MiB unpacked", LONGEST >> 20));
    }
    Ok(json)
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

    /// One event, packed by `xz -9 --check=crc32` (liblzma).
    const PACKED: &[u8] = include_bytes!("../../../../../tests/data/events.json.xz");
    /// 2 096 914 zeros as one chunk of LZMA2 that depends on nothing before it (liblzma).
    const ZEROS: &[u8] = include_bytes!("../../../../../tests/data/zeros.lzma2");
    /// Heads of stream and block of [`PACKED`].
    const HEADS: usize = 24;

    #[test]
    fn reference_what_liblzma_has_packed_is_read() {
        assert_eq!(event_texts(PACKED).unwrap().len(), 1);
    }

    #[test]
    fn what_is_not_xz_or_no_metadata_is_said_to_be_so() {
        let flipped: Vec<u8> = PACKED.iter().enumerate().map(|(i, b)| b ^ u8::from(i == 0)).collect();
        for bytes in [&b""[..], b"{}", &PACKED[..PACKED.len() / 2], &flipped] {
            let why = event_texts(bytes).unwrap_err();
            assert!(why.starts_with("metadata of PX4's events: "), "{why}");
        }
    }

    /// One bit anywhere: mostly refused, never a panic, and never much.
    #[test]
    fn prop_a_flipped_bit_is_refused_or_harmless() {
        for bit in 0..8 * PACKED.len() {
            let mut bytes = PACKED.to_vec();
            bytes[bit / 8] ^= 1 << (bit % 8);
            if let Ok(texts) = event_texts(&bytes) {
                assert!(texts.len() <= 1, "{bit}");
            }
        }
    }

    /// A MiB of xz is 5.9 GB of zeros, which an earlier decoder unpacked before it looked at their number:
    /// now it reads no further than the bound.
    #[test]
    fn regress_a_bomb_is_not_unpacked() {
        let mut bomb = PACKED[..HEADS].to_vec();
        while bomb.len() < 1 << 20 {
            bomb.extend_from_slice(ZEROS);
        }
        let mut left = &bomb[..];
        assert_eq!(unpacked(&mut left).unwrap_err(), "more than 2 MiB unpacked");
        let read = bomb.len() - left.len();
        assert!(read <= HEADS + 3 * ZEROS.len(), "{read} bytes were unpacked");
    }

    /// The window that a head asks for is not given: 4 GiB, as `xz` refuses without `--memlimit`.
    #[test]
    fn a_window_that_is_larger_than_any_of_xz_is_refused() {
        let mut bytes = PACKED.to_vec();
        // Block head: size, flags, filter 0x21, its size, the window's size, padding, CRC-32.
        assert_eq!(bytes[12..16], [2, 0, 0x21, 1]);
        bytes[16] = 40;
        let checksum = crate::checksum::crc32_iso(&bytes[12..20]);
        bytes[20..24].copy_from_slice(&checksum.to_le_bytes());
        let why = unpacked(&bytes[..]).unwrap_err();
        assert!(why.contains("memory"), "{why}");
    }
}
