//! MAVLink FTP, read-only: component metadata, and nothing else.
//!
//! A request with the sequence of the last one is that one again, whose answer was lost: the same answer goes
//! out. Bursts go out a few at a time, so that telemetry is not held up.
//!
//! There are eight sessions, two for a component, four for all that speak from one address. Who has none yet
//! always gets one: that which was unused for longest gives way.
//!
//! Packets of MAVLink FTP, 251 bytes: sequence (2), session, opcode, size, opcode asked for, burst complete,
//! padding, offset (4), data (239). An answer carries the session, the request's sequence + 1 and ACK or NAK.

#[cfg(test)]
mod tests;

use std::collections::VecDeque;
use std::ops::RangeInclusive;

use mavlink::dialects::common::{MavFtpErr as Nak, MavFtpOpcode as Op};
use num_traits::FromPrimitive as _;

use super::outbox::Peer;
use crate::autopilot::parameters::Parameters;
use crate::autopilot::parameters::component_metadata::{Content, contents};
use crate::checksum::crc32;
use crate::time::TimeUs;

/// Payload of FILE_TRANSFER_PROTOCOL.
pub(super) type Packet = [u8; 251];

const HEADER_LEN: usize = 12;
const DATA_LEN: usize = 251 - HEADER_LEN;

/// What an answer holds: its session and its data.
type Answer = Result<(u8, Vec<u8>), Nak>;
/// Most sessions of one component.
const MOST_OF_PEER: usize = 2;
/// Most sessions of all that speak from one address.
const MOST_OF_ADDRESS: usize = 4;
/// Most sessions.
const MOST_SESSIONS: usize = 8;
/// Most peers whose last answer is remembered.
const MOST_PEERS: usize = 8;
/// A session that nobody used for so long may be taken by another [us].
const IDLE_US: TimeUs = 10_000_000;
/// Packets of a burst that go out at a time.
const BURST_AT_A_TIME: usize = 5;

/// Opcodes from CreateFile to RenameFile: all that lie between are requests to write.
const WRITING: RangeInclusive<u8> = Op::MAV_FTP_OPCODE_CREATEFILE as u8..=Op::MAV_FTP_OPCODE_RENAME as u8;

#[derive(Clone, Copy, Debug)]
struct Session {
    id: u8,
    peer: Peer,
    file: usize,
    used_us: TimeUs,
}

/// A burst that is going out.
#[derive(Clone, Copy, Debug)]
struct Burst {
    peer: Peer,
    session: u8,
    file: usize,
    sequence: u16,
    offset: usize,
    size: usize,
}

/// The server.
#[derive(Clone, Debug, Default)]
pub(super) struct FileServer {
    files: Vec<Content>,
    sessions: Vec<Session>,
    bursts: Vec<Burst>,
    last: VecDeque<(Peer, u16, Packet)>,
    answers: VecDeque<(Peer, Packet)>,
}

impl FileServer {
    /// Serves the metadata of these parameters.
    pub(super) fn new(parameters: &Parameters) -> Self {
        Self { files: contents(parameters), ..Self::default() }
    }

    /// Checksum of a file, PX4's CRC-32.
    pub(super) fn crc(&self, path: &str) -> Option<u32> {
        self.files.iter().find(|f| f.path == path).map(|f| crc32(0, &f.bytes))
    }

    /// The next packet to send.
    pub(super) fn poll_answer(&mut self) -> Option<(Peer, Packet)> {
        self.answers.pop_front()
    }

    /// All sessions end: the vehicle's time has started over.
    pub(super) fn restart(&mut self) {
        self.sessions.clear();
        self.bursts.clear();
        self.last.clear();
    }

    /// Takes a request.
    pub(super) fn handle(&mut self, now: TimeUs, peer: Peer, request: &Packet) {
        let [low, high, session, opcode, size, ..] = *request;
        if opcode >= Op::MAV_FTP_OPCODE_ACK as u8 {
            return;
        }
        let sequence = u16::from_le_bytes([low, high]);
        if let Some((_, _, answer)) = self.last.iter().find(|(p, s, _)| *p == peer && *s == sequence) {
            let again = *answer;
            self.answers.push_back((peer, again));
            return;
        }
        let offset = u32::from_le_bytes([request[8], request[9], request[10], request[11]]) as usize;
        let data =
            request.get(HEADER_LEN..HEADER_LEN + usize::from(size)).ok_or(Nak::MAV_FTP_ERR_INVALIDDATASIZE);
        let answer = match Op::from_u8(opcode) {
            Some(Op::MAV_FTP_OPCODE_NONE) => Ok((session, Vec::new())),
            Some(Op::MAV_FTP_OPCODE_TERMINATESESSION) => self.terminate(peer, session),
            Some(Op::MAV_FTP_OPCODE_RESETSESSION) => {
                self.sessions.retain(|s| s.peer != peer);
                self.bursts.retain(|b| b.peer != peer);
                Ok((session, Vec::new()))
            }
            Some(Op::MAV_FTP_OPCODE_LISTDIRECTORY) => data.and_then(|data| self.list(session, data, offset)),
            Some(Op::MAV_FTP_OPCODE_OPENFILERO) => data.and_then(|data| self.open(now, peer, data)),
            Some(Op::MAV_FTP_OPCODE_READFILE) => self.read(now, peer, session, offset, usize::from(size)),
            Some(Op::MAV_FTP_OPCODE_CALCFILECRC) => data.and_then(|data| {
                let file = self.find(data)?;
                Ok((session, crc32(0, &self.files[file].bytes).to_le_bytes().to_vec()))
            }),
            Some(Op::MAV_FTP_OPCODE_BURSTREADFILE) => {
                let size = usize::from(size);
                match self.begin_burst(now, Burst { peer, session, file: 0, sequence, offset, size }) {
                    Ok(()) => return,
                    Err(nak) => Err(nak),
                }
            }
            _ if WRITING.contains(&opcode) => Err(Nak::MAV_FTP_ERR_FILEPROTECTED),
            _ => Err(Nak::MAV_FTP_ERR_UNKNOWNCOMMAND),
        };
        let packet = packet(sequence.wrapping_add(1), session, opcode, offset, answer);
        self.remember(peer, sequence, packet);
        self.answers.push_back((peer, packet));
    }

    /// Sends on what is under way.
    pub(super) fn handle_time(&mut self) {
        for _ in 0..BURST_AT_A_TIME {
            for i in (0..self.bursts.len()).rev() {
                self.burst_on(i);
            }
        }
    }

    fn remember(&mut self, peer: Peer, sequence: u16, packet: Packet) {
        self.last.retain(|(p, ..)| *p != peer);
        if self.last.len() == MOST_PEERS {
            self.last.pop_front();
        }
        self.last.push_back((peer, sequence, packet));
    }

    fn find(&self, path: &[u8]) -> Result<usize, Nak> {
        let path = path_of(path);
        self.files
            .iter()
            .position(|f| f.path.trim_start_matches('/') == path)
            .ok_or(Nak::MAV_FTP_ERR_FILENOTFOUND)
    }

    fn open(&mut self, now: TimeUs, peer: Peer, path: &[u8]) -> Answer {
        let file = self.find(path)?;
        let is_there = |s: &&Session| (s.peer.link, s.peer.id) == (peer.link, peer.id);
        let own = self.sessions.iter().filter(|s| s.peer == peer).count();
        let there = self.sessions.iter().filter(is_there).count();
        if own >= MOST_OF_PEER || there >= MOST_OF_ADDRESS {
            return Err(Nak::MAV_FTP_ERR_NOSESSIONSAVAILABLE);
        }
        if self.sessions.len() >= MOST_SESSIONS {
            let unused = (0..self.sessions.len()).min_by_key(|i| self.sessions[*i].used_us);
            let gives_way = |i: &usize| there == 0 || now.saturating_sub(self.sessions[*i].used_us) > IDLE_US;
            let i = unused.filter(gives_way).ok_or(Nak::MAV_FTP_ERR_NOSESSIONSAVAILABLE)?;
            let id = self.sessions.remove(i).id;
            self.bursts.retain(|b| b.session != id);
        }
        let free = (0..=u8::MAX).find(|id| self.sessions.iter().all(|s| s.id != *id));
        let id = free.ok_or(Nak::MAV_FTP_ERR_NOSESSIONSAVAILABLE)?;
        self.sessions.push(Session { id, peer, file, used_us: now });
        Ok((id, (self.files[file].bytes.len() as u32).to_le_bytes().to_vec()))
    }

    fn session(&mut self, now: TimeUs, peer: Peer, id: u8) -> Result<Session, Nak> {
        let found = self.sessions.iter_mut().find(|s| s.id == id && s.peer == peer);
        let session = found.ok_or(Nak::MAV_FTP_ERR_INVALIDSESSION)?;
        session.used_us = now;
        Ok(*session)
    }

    fn terminate(&mut self, peer: Peer, id: u8) -> Answer {
        let at = self
            .sessions
            .iter()
            .position(|s| s.id == id && s.peer == peer)
            .ok_or(Nak::MAV_FTP_ERR_INVALIDSESSION)?;
        self.sessions.remove(at);
        self.bursts.retain(|b| b.session != id);
        Ok((id, Vec::new()))
    }

    fn read(&mut self, now: TimeUs, peer: Peer, id: u8, offset: usize, size: usize) -> Answer {
        let session = self.session(now, peer, id)?;
        let rest = self.files[session.file].bytes.get(offset..).filter(|rest| !rest.is_empty());
        let rest = rest.ok_or(Nak::MAV_FTP_ERR_EOF)?;
        Ok((id, rest[..rest.len().min(piece(size))].to_vec()))
    }

    /// Begins a burst from the file of its session.
    fn begin_burst(&mut self, now: TimeUs, burst: Burst) -> Result<(), Nak> {
        let file = self.session(now, burst.peer, burst.session)?.file;
        if burst.offset >= self.files[file].bytes.len() {
            return Err(Nak::MAV_FTP_ERR_EOF);
        }
        self.bursts.retain(|b| b.session != burst.session);
        self.bursts.push(Burst { file, size: piece(burst.size), ..burst });
        Ok(())
    }

    fn burst_on(&mut self, i: usize) {
        let Some(burst) = self.bursts.get_mut(i) else { return };
        let bytes = &self.files[burst.file].bytes;
        let end = bytes.len().min(burst.offset + burst.size);
        let data = bytes[burst.offset..end].to_vec();
        burst.sequence = burst.sequence.wrapping_add(1);
        let answer = Ok((burst.session, data));
        let mut sent = packet(
            burst.sequence,
            burst.session,
            Op::MAV_FTP_OPCODE_BURSTREADFILE as u8,
            burst.offset,
            answer,
        );
        // The last packet says that the burst is over.
        sent[6] = u8::from(end == bytes.len());
        burst.offset = end;
        let (peer, over) = (burst.peer, end == bytes.len());
        self.answers.push_back((peer, sent));
        if over {
            self.bursts.remove(i);
        }
    }

    /// Entries from the `offset`th: `F` name, tab, size or `D` name, each with a zero after it.
    fn list(&self, session: u8, path: &[u8], offset: usize) -> Answer {
        let folder = path_of(path);
        let prefix = if folder.is_empty() { String::new() } else { format!("{folder}/") };
        let mut entries: Vec<String> = Vec::new();
        for file in &self.files {
            let Some(rest) = file.path.trim_start_matches('/').strip_prefix(&prefix) else { continue };
            entries.push(match rest.split_once('/') {
                Some((folder, _)) => format!("D{folder}\0"),
                None => format!("F{rest}\t{}\0", file.bytes.len()),
            });
        }
        entries.dedup();
        if entries.is_empty() {
            return Err(Nak::MAV_FTP_ERR_FILENOTFOUND);
        }
        let mut data = Vec::new();
        for entry in entries.get(offset..).filter(|rest| !rest.is_empty()).ok_or(Nak::MAV_FTP_ERR_EOF)? {
            if data.len() + entry.len() > DATA_LEN {
                break;
            }
            data.extend_from_slice(entry.as_bytes());
        }
        Ok((session, data))
    }
}

/// How much a read gives: all that fits, unless less is asked for.
fn piece(size: usize) -> usize {
    if size == 0 { DATA_LEN } else { size.min(DATA_LEN) }
}

/// A path up to its first zero, without slashes at its ends; empty when it is no text.
fn path_of(data: &[u8]) -> &str {
    let end = data.iter().position(|b| *b == 0).unwrap_or(data.len());
    std::str::from_utf8(&data[..end]).unwrap_or("?").trim_matches('/')
}

fn packet(sequence: u16, asked: u8, opcode: u8, offset: usize, answer: Answer) -> Packet {
    let mut packet = [0; 251];
    packet[..2].copy_from_slice(&sequence.to_le_bytes());
    packet[5] = opcode;
    packet[8..HEADER_LEN].copy_from_slice(&(offset as u32).to_le_bytes());
    let nak;
    let (session, kind, data) = match &answer {
        Ok((session, data)) => (*session, Op::MAV_FTP_OPCODE_ACK, data.as_slice()),
        Err(reason) => {
            nak = [*reason as u8];
            (asked, Op::MAV_FTP_OPCODE_NAK, nak.as_slice())
        }
    };
    (packet[2], packet[3], packet[4]) = (session, kind as u8, data.len() as u8);
    packet[HEADER_LEN..HEADER_LEN + data.len()].copy_from_slice(data);
    packet
}
