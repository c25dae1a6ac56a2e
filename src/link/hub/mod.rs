//! Between a party and its sockets: many peers on several endpoints, without socket and clock.
//!
//! An endpoint is a socket of one of the party's links. Bytes go in with the address they came from
//! ([`Hub::datagram`], [`Hub::stream`]); sound frames come out with the number of their peer. What the party
//! sends goes through [`Hub::send`], which says what goes to which address:
//!
//! - a peer counts once it has sent a sound frame, and is served until it has been silent for the hub's
//!   memory; what is kept ([`Hub::keep`]: default remotes, connections) is served anyhow;
//! - there are [`MAX_PEERS`] places. Who speaks keeps its place; who has been silent and comes back has it
//!   again before those who came later, one of whom gives way; a component may have a place of its own
//!   ([`Hub::reserve_for`]);
//! - an answer goes to the peer that asked, everything else to all peers of the link;
//! - **every peer gets sequence numbers of its own**, without gaps. PX4 and mavlink-router number frames per
//!   link; with several peers on a link and answers to one of them, all others would count losses;
//! - with a key, everything is signed and only what is signed is let in. Without one, signed frames are taken
//!   like any other, as the protocol's C library does; the link id is the endpoint's number;
//! - what one peer says and others should hear is passed on (`forward`); where a router stands in between,
//!   what comes by two ways is taken once ([`Hub::expect_doubles`]).
//!
//! Everything is bounded: peers, components of a peer, frames to be passed on. Time is in Unix microseconds
//! and must not run backwards.

mod doubles;
mod forward;
mod peers;

#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use self::doubles::Doubles;
use self::forward::{includes, may_leave, reaches};
pub use self::peers::EndpointId;
use self::peers::Peer;
use super::decoder::Decoder;
use super::faults::Faults;
use super::frame::Frame;
use super::peer::PeerId;
use super::session::{Link, Transmit};
use super::signing::{Key, Refusal, Signing};

/// Most peers of a hub; more is a mistake somewhere, or malice.
pub const MAX_PEERS: usize = 32;
/// How long who has been silent has its place back before those who came later [us].
const AWAY_US: u64 = 600_000_000;
/// Most frames that wait to be passed on.
const MAX_FORWARDS: usize = 1024;

/// Settings of a hub.
#[derive(Clone, Debug)]
pub struct HubConfig {
    /// System and component of the party.
    pub own: (u8, u8),
    /// A silent peer is served for this long [us].
    pub memory_us: u64,
    /// Whether frames are passed on between peers.
    pub forwards: bool,
    /// The key, if frames are to be signed.
    pub key: Option<Key>,
}

/// Something that happened to a peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HubEvent<A> {
    /// It has spoken for the first time, or after a silence.
    Heard(EndpointId, A),
    /// There is no room for a peer; reported once until there is.
    Crowded(EndpointId, A),
}

/// A peer that is silent.
#[derive(Clone, Copy, Debug)]
struct Away<A> {
    endpoint: EndpointId,
    address: A,
    since: u64,
    heard_at: u64,
}

/// See the head of this file. `A` is an address.
#[derive(Clone, Debug)]
pub struct Hub<A> {
    config: HubConfig,
    signing: Option<Signing>,
    endpoints: Vec<(Link, Faults)>,
    peers: Vec<Peer<A>>,
    /// Peers that have been silent for too long, the earliest first.
    away: Vec<Away<A>>,
    /// A component that has a place of its own, by whichever peer it is heard first.
    reserved: Option<(u8, u8)>,
    last_id: PeerId,
    crowded_reported: bool,
    doubles: Option<Doubles<(EndpointId, A)>>,
    /// Whom the peers of an endpoint speak to themselves.
    reached: Vec<(EndpointId, Vec<A>)>,
    events: VecDeque<HubEvent<A>>,
    /// Frames to be passed on: by which endpoint, to whom.
    to_forward: VecDeque<(EndpointId, A, Vec<u8>)>,
}

impl<A: Copy + PartialEq> Hub<A> {
    /// A hub without endpoints.
    pub fn new(config: HubConfig) -> Self {
        Self {
            signing: config.key.map(Signing::new),
            config,
            endpoints: Vec::new(),
            peers: Vec::new(),
            away: Vec::new(),
            reserved: None,
            last_id: PeerId::ONLY,
            crowded_reported: false,
            doubles: None,
            reached: Vec::new(),
            events: VecDeque::new(),
            to_forward: VecDeque::new(),
        }
    }

    /// Adds an endpoint of a link; at most 256 have numbers of their own.
    pub fn add_endpoint(&mut self, link: Link) -> EndpointId {
        self.endpoints.push((link, Faults::default()));
        EndpointId(u8::try_from(self.endpoints.len() - 1).unwrap_or(u8::MAX))
    }

    /// Serves an address until it is forgotten, also while it is silent. False if there is no room.
    pub fn keep(&mut self, now: u64, endpoint: EndpointId, address: A) -> bool {
        let admitted = self.admit(now, endpoint, address, None);
        if let Some(i) = admitted {
            self.peers[i].kept = true;
        }
        admitted.is_some()
    }

    /// From now on a frame that has come by one peer is dropped when it comes by another within a second: a
    /// router passes on what its sender says here as well.
    pub fn expect_doubles(&mut self) {
        self.doubles = Some(Doubles::new());
    }

    /// A component (system and component) has a place of its own beside the others: the first peer that
    /// speaks in that name and finds no other.
    pub fn reserve_for(&mut self, component: (u8, u8)) {
        self.reserved = Some(component);
    }

    /// What the peers of an endpoint say to everybody is not passed on to these addresses: they speak to them
    /// themselves.
    pub fn reaches_itself(&mut self, endpoint: EndpointId, addresses: Vec<A>) {
        self.reached.push((endpoint, addresses));
    }

    /// A connection has ended.
    pub fn forget(&mut self, endpoint: EndpointId, address: A) {
        self.peers.retain(|p| (p.endpoint, p.address) != (endpoint, address));
    }

    /// The next thing that happened to a peer.
    pub fn poll_event(&mut self) -> Option<HubEvent<A>> {
        self.events.pop_front()
    }

    /// What has come by an endpoint, by kind.
    pub fn faults(&self, endpoint: EndpointId) -> Faults {
        self.endpoints.get(usize::from(endpoint.0)).map(|e| e.1).unwrap_or_default()
    }

    /// Number of peers that are served.
    pub fn served(&self, now: u64) -> usize {
        self.peers.iter().filter(|p| p.is_served(now, self.config.memory_us)).count()
    }

    /// Takes a datagram and gives out its frames.
    pub fn datagram(
        &mut self,
        now: u64,
        endpoint: EndpointId,
        from: A,
        bytes: &[u8],
        mut each: impl FnMut(&Frame),
    ) {
        let mut decoder = Decoder::new();
        decoder.datagram(bytes, |mut frame| {
            if self.take(now, endpoint, from, &mut frame) {
                each(&frame);
            }
        });
        self.count(endpoint, |faults| faults.add(decoder.faults()));
    }

    /// Takes bytes of a connection that is kept and gives out the frames that are complete.
    pub fn stream(
        &mut self,
        now: u64,
        endpoint: EndpointId,
        from: A,
        bytes: &[u8],
        mut each: impl FnMut(&Frame),
    ) {
        let Some(i) = self.find(endpoint, from) else { return };
        let mut decoder = std::mem::take(&mut self.peers[i].decoder);
        decoder.push(bytes);
        while let Some(mut frame) = decoder.next_frame() {
            if self.take(now, endpoint, from, &mut frame) {
                each(&frame);
            }
        }
        let news = decoder.take_faults();
        self.count(endpoint, |faults| faults.add(&news));
        if let Some(i) = self.find(endpoint, from) {
            self.peers[i].decoder = decoder;
        }
    }

    /// Says what goes where for one of the party's frames.
    pub fn send(&mut self, now: u64, transmit: &Transmit, mut out: impl FnMut(EndpointId, A, &[u8])) {
        self.expire(now);
        let Self { peers, endpoints, signing, .. } = self;
        let reached = |p: &&mut Peer<A>| {
            let link = endpoints.get(usize::from(p.endpoint.0)).map(|e| e.0);
            link == Some(transmit.link) && transmit.to.includes(p.id)
        };
        for peer in peers.iter_mut().filter(reached) {
            let bytes = peer.seal(&transmit.bytes, signing.as_mut(), now);
            out(peer.endpoint, peer.address, &bytes);
        }
    }

    /// The next frame to be passed on, as it came.
    pub fn poll_forward(&mut self) -> Option<(EndpointId, A, Vec<u8>)> {
        self.to_forward.pop_front()
    }

    /// Checks a frame, notes its peer, passes it on; whether the party may see it.
    fn take(&mut self, now: u64, endpoint: EndpointId, from: A, frame: &mut Frame) -> bool {
        if self.doubles.as_mut().is_some_and(|d| d.holds(now, (endpoint, from), frame.bytes())) {
            self.count(endpoint, |faults| faults.doubled += 1);
            return false;
        }
        if let Some(Err(refusal)) = self.signing.as_mut().map(|s| s.check(frame, now)) {
            self.count(endpoint, |faults| match refusal {
                Refusal::Unsigned => faults.unsigned += 1,
                Refusal::BadSignature => faults.bad_signature += 1,
                Refusal::Replayed => faults.replayed += 1,
            });
            return false;
        }
        let sender = (frame.system_id, frame.component_id);
        if sender == self.config.own {
            self.count(endpoint, |faults| faults.own_name += 1);
            return false;
        }
        let Some(i) = self.admit(now, endpoint, from, Some(sender)) else {
            self.count(endpoint, |faults| faults.crowded += 1);
            if !std::mem::replace(&mut self.crowded_reported, true) {
                self.events.push_back(HubEvent::Crowded(endpoint, from));
            }
            return false;
        };
        let (peer, memory_us) = (&mut self.peers[i], self.config.memory_us);
        frame.peer = peer.id;
        if !peer.is_heard(now, memory_us) {
            self.events.push_back(HubEvent::Heard(endpoint, from));
        }
        peer.heard_at = Some(now);
        if let Some(doubles) = &mut self.doubles {
            doubles.note(now, (endpoint, from), frame.bytes());
        }
        if let Some((_, faults)) = self.endpoints.get_mut(usize::from(endpoint.0)) {
            peer.note_sequence(sender, frame.sequence, faults);
            faults.oversize += u64::from(frame.has_excess());
        }
        self.route(now, endpoint, frame);
        true
    }

    fn route(&mut self, now: u64, endpoint: EndpointId, frame: &Frame) {
        let (target, own) = (frame.target(), self.config.own);
        let (mut known, mut full) = (false, false);
        let reached = |address: A| {
            target.0 == 0 && self.reached.iter().any(|(by, to)| *by == endpoint && to.contains(&address))
        };
        for peer in &self.peers {
            let heard = peer.is_served(now, self.config.memory_us) && reaches(target, own, peer.components());
            known |= heard;
            let sender = (frame.system_id, frame.component_id);
            let is_way_back = peer.id == frame.peer || peer.components().any(|c| c == sender);
            let is_needless = is_way_back || reached(peer.address);
            if !heard || is_needless || !self.config.forwards || !may_leave(frame.message_id) {
                continue;
            }
            if self.to_forward.len() < MAX_FORWARDS {
                self.to_forward.push_back((peer.endpoint, peer.address, frame.bytes().to_vec()));
            } else {
                full = true;
            }
        }
        let nobodys = !known && !includes(target, own);
        self.count(endpoint, |faults| {
            faults.wrong_target += u64::from(nobodys);
            faults.not_forwarded += u64::from(full);
        });
    }

    fn find(&self, endpoint: EndpointId, address: A) -> Option<usize> {
        self.peers.iter().position(|p| (p.endpoint, p.address) == (endpoint, address))
    }

    /// The peer of an address, a new one if need be and if there is room; `sender`: who speaks.
    fn admit(
        &mut self,
        now: u64,
        endpoint: EndpointId,
        address: A,
        sender: Option<(u8, u8)>,
    ) -> Option<usize> {
        self.expire(now);
        if let Some(i) = self.find(endpoint, address) {
            return Some(i);
        }
        let was = self.away.iter().position(|a| (a.endpoint, a.address) == (endpoint, address));
        let since = was.map_or(now, |i| self.away[i].since);
        let by_name = sender.is_some() && sender == self.reserved;
        if self.peers.len() >= MAX_PEERS && !self.makes_room(since) {
            let has_own = |p: &Peer<A>| p.components().any(|c| Some(c) == self.reserved);
            if !by_name || self.peers.len() > MAX_PEERS || self.peers.iter().any(has_own) {
                return None;
            }
        }
        if let Some(i) = was {
            self.away.remove(i);
        }
        self.crowded_reported = false;
        self.last_id = PeerId(self.last_id.0.wrapping_add(1).max(1));
        self.peers.push(Peer::new(self.last_id, endpoint, address, since));
        Some(self.peers.len() - 1)
    }

    /// Whether the peer that came last gives way to who was there since before.
    fn makes_room(&mut self, since: u64) -> bool {
        let own = self.reserved;
        let last = (0..self.peers.len())
            .filter(|i| !self.peers[*i].kept && !self.peers[*i].components().any(|c| Some(c) == own))
            .max_by_key(|i| self.peers[*i].since);
        match last.filter(|i| self.peers[*i].since > since) {
            Some(i) => {
                self.peers.remove(i);
                true
            }
            None => false,
        }
    }

    /// Lets those go who have been silent for too long, and remembers the earliest of them.
    fn expire(&mut self, now: u64) {
        let memory_us = self.config.memory_us;
        // A new one is not served before its first frame is noted, within the same call.
        let Self { peers, away, .. } = self;
        peers.retain(|p| {
            let served = p.is_served(now, memory_us);
            if let (false, Some(heard_at)) = (served, p.heard_at) {
                let (endpoint, address, since) = (p.endpoint, p.address, p.since);
                let at = away.partition_point(|a| a.since <= since);
                away.insert(at, Away { endpoint, address, since, heard_at });
            }
            served
        });
        away.retain(|a| now.saturating_sub(a.heard_at) <= AWAY_US);
        away.truncate(MAX_PEERS);
    }

    fn count(&mut self, endpoint: EndpointId, add: impl FnOnce(&mut Faults)) {
        if let Some((_, faults)) = self.endpoints.get_mut(usize::from(endpoint.0)) {
            add(faults);
        }
    }
}
