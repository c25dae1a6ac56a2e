//! The `.tlog`: what went over the wire, for mavlogdump, MAVExplorer and QGroundControl's replay.
//!
//! One record per frame: the time as a big-endian u64 of Unix microseconds, then the raw frame. The time is
//! the mission's epoch plus simulated time, so that a drop writes the same bytes whenever it is run.

use std::io::{self, Write};

use crate::time::TimeUs;

/// Writes a `.tlog` to anything that takes bytes; give it a buffered writer.
#[derive(Debug)]
pub struct Tlog<W> {
    epoch_unix_us: u64,
    last: u64,
    out: W,
}

impl<W: Write> Tlog<W> {
    /// A log whose simulated time 0 is `epoch_unix_us` [us since 1970-01-01 UTC].
    pub fn new(out: W, epoch_unix_us: u64) -> Self {
        Self { epoch_unix_us, last: 0, out }
    }

    /// Writes one frame seen at simulated time `now`. Readers want stamps that do not decrease; an earlier
    /// time is written as the last one.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&mut self, now: TimeUs, frame: &[u8]) -> io::Result<()> {
        self.last = self.last.max(self.epoch_unix_us.saturating_add(now));
        self.out.write_all(&self.last.to_be_bytes())?;
        self.out.write_all(frame)
    }

    /// The writer, flushed.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// pymavlink's reader: 8 bytes `>Q`, then the frame.
    #[test]
    fn reference_layout_is_big_endian_microseconds_then_the_frame() {
        let mut log = Tlog::new(Vec::new(), 0x0005_F5E1_0000_0000);
        log.write(0x10, &[0xFD, 1, 2]).unwrap();
        log.write(0x08, &[0xFD, 3]).unwrap();
        let bytes = log.finish().unwrap();
        let expected =
            [0, 5, 0xF5, 0xE1, 0, 0, 0, 0x10, 0xFD, 1, 2, 0, 5, 0xF5, 0xE1, 0, 0, 0, 0x10, 0xFD, 3];
        assert_eq!(bytes, expected);
    }
}
