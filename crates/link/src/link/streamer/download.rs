//! A file of the vehicle's, by MAVLink FTP: one request under way at a time.
//!
//! Packets of MAVLink FTP, 251 bytes: sequence (2), session, opcode, size, opcode asked for, burst complete,
//! padding, offset (4), data (239). An answer carries the request's sequence + 1 and ACK or NAK.

use mavlink::dialects::common::{FILE_TRANSFER_PROTOCOL_DATA, MavFtpErr, MavFtpOpcode as Op, MavMessage};

use super::patience::{Sent, Wire};
use crate::params::file::AUTOPILOT_COMPONENT;
use crate::time::TimeUs;

/// Payload of FILE_TRANSFER_PROTOCOL.
type Packet = [u8; 251];
const HEADER_LEN: usize = 12;
/// What is not answered is sent again after this [us].
const RETRY_US: TimeUs = 500_000;
/// How often a request is sent.
const TRIES: u32 = 4;
/// A file that is longer is not taken.
const LONGEST: usize = 1 << 20;

/// A file on its way.
#[derive(Clone, Debug)]
pub(super) struct Download {
    path: &'static str,
    /// The session, once the file is open.
    session: Option<u8>,
    bytes: Vec<u8>,
    sequence: u16,
    sent: Option<Sent>,
    tries: u32,
    outcome: Option<Result<(), &'static str>>,
}

impl Download {
    /// A file of which nothing has been asked.
    pub(super) fn of(path: &'static str) -> Self {
        Self { path, session: None, bytes: Vec::new(), sequence: 0, sent: None, tries: 0, outcome: None }
    }

    /// The file, or why there is none; `None` while it is on its way.
    pub(super) fn outcome(&mut self) -> Option<Result<Vec<u8>, &'static str>> {
        let outcome = self.outcome?;
        Some(outcome.map(|()| std::mem::take(&mut self.bytes)))
    }

    /// What is to be sent now to the autopilot of a system.
    pub(super) fn poll(&mut self, now: TimeUs, wire: &Wire, system_id: u8) -> Option<MavMessage> {
        if self.outcome.is_some() || self.sent.is_some_and(|sent| !wire.has_waited(sent, now, RETRY_US)) {
            return None;
        }
        if self.tries == TRIES {
            self.outcome = Some(Err("no answer"));
            return None;
        }
        self.tries += 1;
        self.sent = Some(wire.send(now));
        let mut payload = [0; 251];
        payload[..2].copy_from_slice(&self.sequence.to_le_bytes());
        match self.session {
            None => {
                let path = self.path.as_bytes();
                (payload[3], payload[4]) = (Op::MAV_FTP_OPCODE_OPENFILERO as u8, path.len() as u8);
                payload[HEADER_LEN..HEADER_LEN + path.len()].copy_from_slice(path);
            }
            Some(session) => {
                payload[2] = session;
                (payload[3], payload[4]) = (Op::MAV_FTP_OPCODE_READFILE as u8, (251 - HEADER_LEN) as u8);
                payload[8..HEADER_LEN].copy_from_slice(&(self.bytes.len() as u32).to_le_bytes());
            }
        }
        Some(packet(payload, system_id))
    }

    /// Takes a packet of the autopilot's; what is to be sent at the end of it.
    pub(super) fn take(&mut self, answer: &Packet, system_id: u8) -> Option<MavMessage> {
        let sequence = u16::from_le_bytes([answer[0], answer[1]]);
        if self.outcome.is_some() || self.sent.is_none() || sequence != self.sequence.wrapping_add(1) {
            return None;
        }
        let data = answer.get(HEADER_LEN..HEADER_LEN + usize::from(answer[4])).unwrap_or_default();
        let is_ack = answer[3] == Op::MAV_FTP_OPCODE_ACK as u8;
        let at_end = !is_ack && data.first() == Some(&(MavFtpErr::MAV_FTP_ERR_EOF as u8));
        (self.sequence, self.sent, self.tries) = (sequence, None, 0);
        match (self.session, is_ack) {
            (None, true) => self.session = Some(answer[2]),
            (Some(_), true) if !data.is_empty() && self.bytes.len() + data.len() <= LONGEST => {
                self.bytes.extend_from_slice(data);
            }
            (Some(_), true) => self.outcome = Some(Err("it does not end")),
            (Some(_), false) if at_end => self.outcome = Some(Ok(())),
            (_, false) => self.outcome = Some(Err("refused")),
        }
        let session = self.session.filter(|_| self.outcome.is_some())?;
        let mut payload = [0; 251];
        payload[..2].copy_from_slice(&self.sequence.to_le_bytes());
        (payload[2], payload[3]) = (session, Op::MAV_FTP_OPCODE_TERMINATESESSION as u8);
        Some(packet(payload, system_id))
    }
}

fn packet(payload: Packet, target_system: u8) -> MavMessage {
    MavMessage::FILE_TRANSFER_PROTOCOL(FILE_TRANSFER_PROTOCOL_DATA {
        target_network: 0,
        target_system,
        target_component: AUTOPILOT_COMPONENT,
        payload,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A server in the words of MAVLink's guide: one file, its end told by NAK EOF.
    struct Server {
        file: Vec<u8>,
        asked: Vec<u8>,
    }

    impl Server {
        fn answer(&mut self, message: &MavMessage) -> Packet {
            let MavMessage::FILE_TRANSFER_PROTOCOL(m) = message else { panic!() };
            let p = m.payload;
            self.asked.push(p[3]);
            let mut answer = [0; 251];
            answer[..2].copy_from_slice(&(u16::from_le_bytes([p[0], p[1]]) + 1).to_le_bytes());
            (answer[2], answer[3]) = (7, Op::MAV_FTP_OPCODE_ACK as u8);
            let offset = u32::from_le_bytes([p[8], p[9], p[10], p[11]]) as usize;
            let part: Vec<u8> = self.file.iter().skip(offset).take(usize::from(p[4])).copied().collect();
            if p[3] == Op::MAV_FTP_OPCODE_READFILE as u8 {
                assert_eq!(p[2], 7);
                if part.is_empty() {
                    answer[3] = Op::MAV_FTP_OPCODE_NAK as u8;
                    (answer[4], answer[HEADER_LEN]) = (1, MavFtpErr::MAV_FTP_ERR_EOF as u8);
                } else {
                    answer[4] = part.len() as u8;
                    answer[HEADER_LEN..HEADER_LEN + part.len()].copy_from_slice(&part);
                }
            }
            answer
        }
    }

    #[test]
    fn a_file_comes_whole_though_every_third_answer_is_lost() {
        let file: Vec<u8> = (0..1000_u32).map(|i| (i * 7) as u8).collect();
        let mut server = Server { file: file.clone(), asked: Vec::new() };
        let (mut download, wire) = (Download::of("/etc/extras/all_events.json.xz"), Wire::default());
        let mut last = None;
        for tick in 0..100 {
            let Some(message) = download.poll(tick * 200_000, &wire, 1) else { continue };
            let answer = server.answer(&message);
            if !server.asked.len().is_multiple_of(3) {
                last = download.take(&answer, 1).or(last);
            }
        }
        assert_eq!(download.outcome(), Some(Ok(file)));
        let Some(MavMessage::FILE_TRANSFER_PROTOCOL(m)) = last else { panic!("the session is not ended") };
        assert_eq!((m.payload[2], m.payload[3]), (7, Op::MAV_FTP_OPCODE_TERMINATESESSION as u8));
    }

    #[test]
    fn silence_and_refusals_end_it() {
        let (mut download, wire) = (Download::of("/x"), Wire::default());
        let sent = (0..100).filter(|tick| download.poll(tick * 200_000, &wire, 1).is_some()).count();
        assert_eq!((sent, download.outcome()), (4, Some(Err("no answer"))));
        let mut download = Download::of("/x");
        assert!(download.poll(0, &wire, 1).is_some());
        let mut nak = [0; 251];
        (nak[0], nak[3]) = (1, Op::MAV_FTP_OPCODE_NAK as u8);
        assert!(download.take(&nak, 1).is_none());
        assert_eq!(download.outcome(), Some(Err("refused")));
    }

    /// A file that goes on and on, as of a vehicle that means harm.
    #[test]
    fn a_file_that_does_not_end_is_given_up() {
        let mut server = Server { file: vec![7; 2 * LONGEST], asked: Vec::new() };
        let (mut download, wire) = (Download::of("/x"), Wire::default());
        for tick in 0..2 * LONGEST as u64 / 239 {
            let Some(message) = download.poll(tick * 200_000, &wire, 1) else { break };
            download.take(&server.answer(&message), 1);
            assert!(download.bytes.len() <= LONGEST);
        }
        assert_eq!(download.outcome(), Some(Err("it does not end")));
        // The answers go on counting up: `u16` is enough for a file of this length.
        assert!(LONGEST / 239 < usize::from(u16::MAX));
    }
}
