//! What has come by a link and was not as it should be, counted by kind.

use std::fmt;

/// Counts by kind. A decoder counts what concerns bytes and frames, a [`super::Hub`] what concerns peers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Faults {
    /// Frames whose checksum was right.
    pub frames: u64,
    /// Bytes that belong to no frame.
    pub skipped_bytes: u64,
    /// Candidates with a wrong checksum.
    pub bad_crc: u64,
    /// Frames that a datagram (or a stream given up) ended inside of.
    pub truncated: u64,
    /// Frames of a message that the dialect does not have; their checksum cannot be checked.
    pub unknown_id: u64,
    /// Bytes of those behind which another frame begins, or the datagram ends: of a newer dialect.
    pub unknown_bytes: u64,
    /// Frames with MAVLink 2 incompatibility flags other than "signed"; a receiver must drop them.
    pub incompatible: u64,
    /// Sound frames with a value that the parser refuses, given out without a [`super::Frame::message`].
    pub unparsed: u64,
    /// Sound frames of MAVLink 1; taken like those of MAVLink 2.
    pub mavlink1: u64,
    /// Sound frames that were signed.
    pub signed: u64,
    /// Sound frames with more payload than their message has fields (a newer dialect's extension); the excess
    /// is not read.
    pub oversize: u64,
    /// Frames refused because their signature is not of our key.
    pub bad_signature: u64,
    /// Frames refused because they are not signed, while we have a key.
    pub unsigned: u64,
    /// Frames refused because their signature is not newer than the last of that sender:
    /// somebody plays back what he has recorded.
    pub replayed: u64,
    /// Frames rightly signed and refused as their stamp is more than a minute ahead of our clock, or that of
    /// a new sender more than a minute behind: the clocks of the two machines differ, or they were recorded.
    pub clock: u64,
    /// Frames with the sequence number of the frame before them; taken.
    pub repeated: u64,
    /// Frames that were overtaken by later ones of their sender; taken.
    pub late: u64,
    /// Frames that had come by another way already, through a router; dropped.
    pub doubled: u64,
    /// Sequence numbers left out: frames that were lost on the way.
    pub missed: u64,
    /// Frames for a system or component that is neither ours nor known on any link.
    pub wrong_target: u64,
    /// Frames that claim to be sent by us; dropped.
    pub own_name: u64,
    /// Frames of peers for whom there is no room; dropped.
    pub crowded: u64,
    /// Frames that could not be forwarded, because too many waited already.
    pub not_forwarded: u64,
}

impl Faults {
    /// Candidates that gave no frame.
    pub fn dropped(&self) -> u64 {
        self.bad_crc + self.truncated + self.unknown_id + self.incompatible
    }

    /// Sound frames that were not let in.
    pub fn refused(&self) -> u64 {
        self.bad_signature + self.unsigned + self.replayed + self.clock + self.own_name + self.crowded
    }

    /// Whether anything was not as it should be. A peer may speak a newer dialect; the messages that are not
    /// known here then seem to be missing in its numbering.
    pub fn any(&self) -> bool {
        let missed = self.missed.saturating_sub(self.unknown_id);
        let known = Self { unknown_id: 0, unknown_bytes: 0, missed, ..*self };
        Self { frames: 0, mavlink1: 0, signed: 0, doubled: 0, ..known } != Self::default()
    }

    /// Adds what another has counted.
    pub fn add(&mut self, other: &Self) {
        for ((_, sum), (_, count)) in self.all().into_iter().zip({ *other }.all()) {
            *sum += *count;
        }
    }

    /// Every count with its name.
    fn all(&mut self) -> [(&'static str, &mut u64); 23] {
        [
            ("frames", &mut self.frames),
            ("skipped bytes", &mut self.skipped_bytes),
            ("bad checksum", &mut self.bad_crc),
            ("cut off", &mut self.truncated),
            ("unknown message", &mut self.unknown_id),
            ("bytes of those", &mut self.unknown_bytes),
            ("unknown flags", &mut self.incompatible),
            ("odd values", &mut self.unparsed),
            ("MAVLink 1", &mut self.mavlink1),
            ("signed", &mut self.signed),
            ("oversize", &mut self.oversize),
            ("bad signature", &mut self.bad_signature),
            ("unsigned", &mut self.unsigned),
            ("replayed", &mut self.replayed),
            ("other clock", &mut self.clock),
            ("repeated", &mut self.repeated),
            ("late", &mut self.late),
            ("doubled", &mut self.doubled),
            ("missed", &mut self.missed),
            ("wrong target", &mut self.wrong_target),
            ("in our name", &mut self.own_name),
            ("too many peers", &mut self.crowded),
            ("not forwarded", &mut self.not_forwarded),
        ]
    }
}

/// The counts that are not zero, by name: `12 frames, bad checksum 3, unsigned 1`.
impl fmt::Display for Faults {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} frames", self.frames)?;
        for (name, count) in { *self }.all().into_iter().skip(1).filter(|(_, count)| **count > 0) {
            write!(f, ", {name} {count}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_counts_add_kind_by_kind_and_are_reported_by_name() {
        let mut sum = Faults::default();
        for (i, (_, count)) in sum.all().into_iter().enumerate() {
            *count = i as u64;
        }
        let once = sum;
        sum.add(&once);
        for (i, (_, count)) in sum.all().into_iter().enumerate() {
            assert_eq!(*count, 2 * i as u64);
        }
        let some = Faults { frames: 12, bad_crc: 3, unsigned: 1, ..Faults::default() };
        assert_eq!(some.to_string(), "12 frames, bad checksum 3, unsigned 1");
    }

    /// PX4 v1.18 sends GNSS_INTEGRITY twice a second, which the dialect here does not have.
    #[test]
    fn a_newer_dialect_is_nothing_odd() {
        let newer = Faults { frames: 12, unknown_id: 3, unknown_bytes: 130, missed: 3, ..Faults::default() };
        assert!(!newer.any());
        assert!(Faults { missed: 4, ..newer }.any() && Faults { skipped_bytes: 1, ..newer }.any());
    }
}
