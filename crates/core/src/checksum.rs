//! CRC-32, reflected polynomial 0xEDB88320: over parameters and files as PX4 counts it, from 0 with nothing
//! inverted, and as zlib, PNG and Ethernet do, inverted before and after.

/// Continues PX4's checksum over some bytes; a new one starts from 0.
pub fn crc32(start: u32, bytes: &[u8]) -> u32 {
    bytes.iter().fold(start, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |c, _| if c & 1 == 1 { c >> 1 ^ 0xEDB8_8320 } else { c >> 1 })
    })
}

/// CRC-32/ISO-HDLC of some bytes, as zlib's `crc32` and Python's `zlib.crc32` count it.
pub fn crc32_iso(bytes: &[u8]) -> u32 {
    !crc32(u32::MAX, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of CRC-32 (ISO-HDLC), which starts from and ends with all ones inverted, and of
    /// CRC-32/JAMCRC, which does not invert at the end.
    #[test]
    fn reference_check_values_of_the_catalogue() {
        assert_eq!(crc32_iso(b"123456789"), 0xCBF4_3926);
        assert_eq!(crc32(u32::MAX, b"123456789"), 0x340B_C6D9);
        assert_eq!(crc32(crc32(0, b"1234"), b"56789"), crc32(0, b"123456789"));
        assert_eq!(crc32(0, b""), 0);
    }
}
