//! The `.tlog`: what went over the wire, for mavlogdump, MAVExplorer and QGroundControl's replay.
//!
//! One record per frame: the time as a big-endian u64 of Unix microseconds, then the raw frame. The time is
//! the mission's epoch plus simulated time, so that a drop writes the same bytes whenever it is run.

use std::io::{self, Write};

use super::decoder::Decoder;
use super::frame::{Frame, Header};
use crate::time::TimeUs;

/// Bytes of a record's time.
const STAMP_LEN: usize = 8;

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

/// A frame of a `.tlog`.
#[derive(Clone, Debug)]
pub struct TlogRecord {
    /// Simulated time.
    pub at: TimeUs,
    /// Number of the record, from 1.
    pub number: usize,
    /// Where the record begins in the file [bytes].
    pub offset: usize,
    /// The frame.
    pub frame: Frame,
}

/// A record that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("record {number}, at byte {offset}: {fault}")]
pub struct TlogError {
    /// Number of the record, from 1.
    pub number: usize,
    /// Where the record begins in the file [bytes].
    pub offset: usize,
    /// What is wrong with it.
    pub fault: TlogFault,
}

/// What is wrong with a record of a `.tlog`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TlogFault {
    /// The file ends inside the record.
    #[error("the file ends inside it")]
    Truncated,
    /// Behind the time there is no MAVLink frame.
    #[error("expected a MAVLink frame behind the 8 bytes of its time")]
    NoFrame,
    /// The frame is of no known message, or its checksum is another.
    #[error("the frame is damaged, or of a message that is not known: its checksum does not fit")]
    Damaged,
    /// The time is before the epoch that the mission gives.
    #[error("its time is before the mission's epoch: a recording of another mission")]
    BeforeEpoch,
    /// The time is before that of the record before.
    #[error("its time is before that of the record before it")]
    Backwards,
}

/// Reads the records of a `.tlog` in order; after an error there are no more.
#[derive(Clone, Debug)]
pub struct TlogReader<'a> {
    bytes: &'a [u8],
    epoch_unix_us: u64,
    offset: usize,
    number: usize,
    last: TimeUs,
}

impl<'a> TlogReader<'a> {
    /// The records of a file with these bytes, whose simulated time 0 is `epoch_unix_us` [us since 1970-01-01
    /// UTC].
    pub fn new(bytes: &'a [u8], epoch_unix_us: u64) -> Self {
        Self { bytes, epoch_unix_us, offset: 0, number: 0, last: 0 }
    }

    /// The record at the start of `rest`, and how long it is.
    fn read(&self, rest: &[u8]) -> Result<(TimeUs, Frame, usize), TlogFault> {
        let (stamp, rest) = rest.split_first_chunk::<STAMP_LEN>().ok_or(TlogFault::Truncated)?;
        if rest.first().is_some_and(|b| ![mavlink::MAV_STX, mavlink::MAV_STX_V2].contains(b)) {
            return Err(TlogFault::NoFrame);
        }
        let header = Header::read(rest).ok_or(TlogFault::Truncated)?;
        let bytes = rest.get(..header.frame_len()).ok_or(TlogFault::Truncated)?;
        let unix_us = u64::from_be_bytes(*stamp);
        let at = unix_us.checked_sub(self.epoch_unix_us).ok_or(TlogFault::BeforeEpoch)?;
        if at < self.last {
            return Err(TlogFault::Backwards);
        }
        let mut found = None;
        Decoder::new().datagram(bytes, |frame| found = Some(frame));
        let frame = found.filter(|frame| frame.bytes().len() == bytes.len()).ok_or(TlogFault::Damaged)?;
        Ok((at, frame, STAMP_LEN + bytes.len()))
    }
}

impl Iterator for TlogReader<'_> {
    type Item = Result<TlogRecord, TlogError>;

    fn next(&mut self) -> Option<Self::Item> {
        let rest = self.bytes.get(self.offset..).filter(|rest| !rest.is_empty())?;
        self.number += 1;
        let (number, offset) = (self.number, self.offset);
        match self.read(rest) {
            Ok((at, frame, len)) => {
                self.offset += len;
                self.last = at;
                Some(Ok(TlogRecord { at, number, offset, frame }))
            }
            Err(fault) => {
                self.offset = self.bytes.len();
                Some(Err(TlogError { number, offset, fault }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use mavlink::dialects::common::{HEARTBEAT_DATA, MavMessage};

    use super::super::encoder::Encoder;
    use super::*;

    /// What was written is read again; then every cut and every flipped bit of a record, by what was done.
    #[test]
    fn a_recording_is_read_again_and_damage_is_named() {
        let mut encoder = Encoder::new(1, 1);
        let mut frame = || encoder.encode(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default()));
        let mut log = Tlog::new(Vec::new(), 1_000);
        let frames = [frame(), frame()];
        log.write(4, &frames[0]).unwrap();
        log.write(8, &frames[1]).unwrap();
        let bytes = log.finish().unwrap();
        let first = STAMP_LEN + frames[0].len();
        let read: Vec<_> = TlogReader::new(&bytes, 1_000).map(Result::unwrap).collect();
        let read: Vec<_> = read.iter().map(|r| (r.at, r.number, r.offset, r.frame.bytes())).collect();
        assert_eq!(read, [(4, 1, 0, &frames[0][..]), (8, 2, first, &frames[1][..])]);

        let fault = |bytes: &[u8], epoch| TlogReader::new(bytes, epoch).find_map(Result::err).unwrap();
        for cut in first + 1..bytes.len() {
            let expected = TlogError { number: 2, offset: first, fault: TlogFault::Truncated };
            assert_eq!(fault(&bytes[..cut], 1_000), expected);
        }
        for bit in 0..8 * (frames[1].len() - 1) {
            let mut flipped = bytes.clone();
            flipped[first + STAMP_LEN + 1 + bit / 8] ^= 1 << (bit % 8);
            let found = fault(&flipped, 1_000);
            assert_eq!((found.number, found.offset), (2, first), "{bit}");
        }
        assert_eq!(fault(&bytes, 1_005).fault, TlogFault::BeforeEpoch);
        assert_eq!(fault(b"time,phase,north_m,east_m\n", 0).fault, TlogFault::NoFrame);
        let mut backwards = bytes[first..].to_vec();
        backwards.extend_from_slice(&bytes[..first]);
        assert_eq!(fault(&backwards, 1_000).fault, TlogFault::Backwards);
    }

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
