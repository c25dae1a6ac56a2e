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

use mavlink::MessageData as _;
use mavlink::dialects::common::{HEARTBEAT_DATA, RADIO_STATUS_DATA};

use self::doubles::Doubles;
use self::forward::{includes, is_setpoint, may_leave, reaches};
pub use self::peers::EndpointId;
use self::peers::Peer;
use super::decoder::Decoder;
use super::faults::Faults;
use super::frame::Frame;
use super::peer::{PeerId, Recipient};
use super::session::{Link, Transmit};
use super::signing::{ClockError, Key, Refusal, Signing};
use super::stamps::Stamps;

/// Most peers of a hub; more is a mistake somewhere, or malice.
pub const MAX_PEERS: usize = 32;
/// How long who has been silent has its place back before those who came later [us].
const AWAY_US: u64 = 600_000_000;
/// Most frames that wait to be passed on.
const MAX_FORWARDS: usize = 1024;
/// Most connections by others that have not spoken yet; of more, the one that has waited longest is closed.
const MAX_WAITING: usize = 16;
/// How long a connection may take to speak [us].
const SPEAK_WITHIN_US: u64 = 5_000_000;

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
    /// A system and component there signs by our key, but is so many seconds ahead of our clock (negative:
    /// behind) and not believed; each is reported once.
    OtherClock(EndpointId, A, (u8, u8), i64),
}

/// A connection whose peer has not spoken yet.
#[derive(Clone, Debug)]
struct Waiting<A> {
    endpoint: EndpointId,
    address: A,
    since: u64,
    decoder: Decoder,
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
    /// Systems and components whose clocks have been reported.
    clocks_reported: Vec<(u8, u8)>,
    /// Connections whose peers have not spoken, the earliest first.
    waiting: Vec<Waiting<A>>,
    /// Connections that are to be closed.
    to_close: VecDeque<(EndpointId, A)>,
    doubles: Option<Doubles<(EndpointId, A)>>,
    /// Whether what is for everybody goes to kept peers that have not spoken.
    speaks_unasked: bool,
    /// The endpoint behind which a simulator keeps step with companions.
    watcher: Option<EndpointId>,
    /// The endpoint of the autopilot in whose place the party stands.
    stands_for: Option<EndpointId>,
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
            clocks_reported: Vec::new(),
            waiting: Vec::new(),
            to_close: VecDeque::new(),
            doubles: None,
            speaks_unasked: true,
            watcher: None,
            stands_for: None,
            events: VecDeque::new(),
            to_forward: VecDeque::new(),
        }
    }

    /// With a key: goes on from the time stamps of an earlier run.
    ///
    /// # Errors
    /// As [`Signing::resume`].
    pub fn resume(&mut self, now: u64, stamps: Stamps) -> Result<(), ClockError> {
        self.signing.as_mut().map_or(Ok(()), |s| s.resume(stamps, now))
    }

    /// With a key: the time stamps to be kept now for the next start, when they have changed.
    pub fn poll_stamps(&mut self) -> Option<Stamps> {
        self.signing.as_mut()?.poll_stamps()
    }

    /// With a key: the time stamps as they are, to be kept at the end.
    pub fn stamps(&self) -> Option<&Stamps> {
        self.signing.as_ref().map(Signing::stamps)
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

    /// A connection that somebody else has made. Without a key it is served at once, and closed
    /// ([`Self::poll_close`]) if it has said nothing when others want its place. With a key it is a peer from
    /// its first frame that is let in; until then it waits in a small table, for at most five seconds.
    pub fn accept(&mut self, now: u64, endpoint: EndpointId, address: A) {
        if self.signing.is_none() {
            if self.peers.iter().filter(|p| p.is_listener).count() >= MAX_WAITING {
                self.close_listener();
            }
            match self.admit(now, endpoint, address, None) {
                Some(i) => (self.peers[i].kept, self.peers[i].is_listener) = (true, true),
                None => self.to_close.push_back((endpoint, address)),
            }
            return;
        }
        if self.waiting.len() == MAX_WAITING {
            let first = self.waiting.remove(0);
            self.to_close.push_back((first.endpoint, first.address));
        }
        self.waiting.push(Waiting { endpoint, address, since: now, decoder: Decoder::new() });
    }

    /// The next connection to be closed, because its peer has not spoken or others came.
    pub fn poll_close(&mut self, now: u64) -> Option<(EndpointId, A)> {
        if self.waiting.first().is_some_and(|w| now.saturating_sub(w.since) > SPEAK_WITHIN_US) {
            let first = self.waiting.remove(0);
            self.to_close.push_back((first.endpoint, first.address));
        }
        self.to_close.pop_front()
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

    /// Whether what is for everybody goes to peers that are kept and have not spoken, as it does at first:
    /// not where a router brings it to them.
    pub fn speak_unasked(&mut self, speaks: bool) {
        self.speaks_unasked = speaks;
    }

    /// Behind this endpoint a simulator waits for a companion and keeps step with its setpoints: its peers
    /// get setpoints that are for us alone, and, when they are first heard, the last HEARTBEAT of who was
    /// there before them.
    pub fn show_companions_to(&mut self, endpoint: EndpointId) {
        self.watcher = Some(endpoint);
    }

    /// Behind this endpoint is an autopilot that has no others: what it says to everybody goes to all that
    /// are kept, who need not speak first, as an autopilot's own does.
    pub fn stand_for(&mut self, endpoint: EndpointId) {
        self.stands_for = Some(endpoint);
    }

    /// A connection has ended.
    pub fn forget(&mut self, endpoint: EndpointId, address: A) {
        self.peers.retain(|p| (p.endpoint, p.address) != (endpoint, address));
        self.waiting.retain(|w| (w.endpoint, w.address) != (endpoint, address));
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
        let waits = |w: &Waiting<A>| (w.endpoint, w.address) == (endpoint, from);
        let mut decoder = match self.find(endpoint, from) {
            Some(i) => std::mem::take(&mut self.peers[i].decoder),
            None => match self.waiting.iter_mut().find(|w| waits(w)) {
                Some(waiting) => std::mem::take(&mut waiting.decoder),
                None => return,
            },
        };
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
            self.peers[i].kept = true;
            self.waiting.retain(|w| !waits(w));
        } else if let Some(waiting) = self.waiting.iter_mut().find(|w| waits(w)) {
            waiting.decoder = decoder;
        }
    }

    /// Says what goes where for one of the party's frames.
    pub fn send(&mut self, now: u64, transmit: &Transmit, mut out: impl FnMut(EndpointId, A, &[u8])) {
        self.expire(now);
        let Self { peers, endpoints, signing, .. } = self;
        let (unasked, memory_us) = (self.speaks_unasked, self.config.memory_us);
        let reached = |p: &&mut Peer<A>| {
            let link = endpoints.get(usize::from(p.endpoint.0)).map(|e| e.0);
            let is_asked = unasked || transmit.to != Recipient::All || p.is_heard(now, memory_us);
            let by_arrangement = p.kept && matches!(transmit.to, Recipient::KeptAnd(_));
            link == Some(transmit.link) && (transmit.to.includes(p.id) || by_arrangement) && is_asked
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
        let verified = self.signing.as_ref().map_or(Ok(()), |s| s.verify(frame));
        // Made by radios on the way, which have no key: taken from who is a peer already.
        if verified == Err(Refusal::Unsigned) && frame.message_id == RADIO_STATUS_DATA::ID {
            self.expire(now);
            if let Some(i) = self.find(endpoint, from) {
                frame.peer = self.peers[i].id;
                return true;
            }
        }
        if let Err(refusal) = verified {
            return self.refuse(endpoint, from, frame, refusal);
        }
        // What came by two ways has one stamp.
        if self.doubles.as_mut().is_some_and(|d| d.holds(now, (endpoint, from), frame.bytes())) {
            self.count(endpoint, |faults| faults.doubled += 1);
            return false;
        }
        if let Some(Err(refusal)) = self.signing.as_mut().map(|s| s.check_stamp(frame, now)) {
            return self.refuse(endpoint, from, frame, refusal);
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
        let is_new = !peer.is_heard(now, memory_us);
        peer.heard_at = Some(now);
        peer.is_listener = false;
        if frame.message_id == HEARTBEAT_DATA::ID {
            peer.heartbeat = Some(frame.bytes().to_vec());
        }
        if let Some(doubles) = &mut self.doubles {
            doubles.note(now, (endpoint, from), frame.bytes());
        }
        if let Some((_, faults)) = self.endpoints.get_mut(usize::from(endpoint.0)) {
            peer.note_sequence(sender, frame.sequence, faults);
            faults.oversize += u64::from(frame.has_excess());
        }
        if is_new {
            self.events.push_back(HubEvent::Heard(endpoint, from));
            if self.watcher == Some(endpoint) {
                self.introduce_others(now, i);
            }
        }
        self.route(now, endpoint, frame);
        true
    }

    /// Passes the last HEARTBEAT of each other peer that is heard on to peer `i`.
    fn introduce_others(&mut self, now: u64, i: usize) {
        let (new, memory_us) = (&self.peers[i], self.config.memory_us);
        let others = self.peers.iter().filter(|p| p.id != new.id && p.is_heard(now, memory_us));
        let heartbeats = others.filter_map(|p| p.heartbeat.clone());
        self.to_forward.extend(heartbeats.map(|bytes| (new.endpoint, new.address, bytes)));
    }

    /// Counts a frame that is not let in; false.
    fn refuse(&mut self, endpoint: EndpointId, from: A, frame: &Frame, refusal: Refusal) -> bool {
        let sender = (frame.system_id, frame.component_id);
        if let Refusal::Clock(ahead_s) = refusal
            && !self.clocks_reported.contains(&sender)
            && self.clocks_reported.len() < MAX_PEERS
        {
            self.clocks_reported.push(sender);
            self.events.push_back(HubEvent::OtherClock(endpoint, from, sender, ahead_s));
        }
        self.count(endpoint, |faults| match refusal {
            Refusal::Unsigned => faults.unsigned += 1,
            Refusal::BadSignature => faults.bad_signature += 1,
            Refusal::Replayed => faults.replayed += 1,
            Refusal::Clock(_) => faults.clock += 1,
        });
        false
    }

    fn route(&mut self, now: u64, endpoint: EndpointId, frame: &Frame) {
        let (target, own) = (frame.target(), self.config.own);
        let watcher = self.watcher.filter(|_| is_setpoint(frame.message_id) && includes(target, own));
        let for_all = self.stands_for == Some(endpoint) && target.0 == 0;
        let (mut known, mut full) = (false, false);
        for peer in &self.peers {
            let reached = watcher == Some(peer.endpoint)
                || for_all && peer.kept
                || reaches(target, own, peer.components());
            let heard = reached && peer.is_served(now, self.config.memory_us);
            known |= heard;
            let sender = (frame.system_id, frame.component_id);
            let is_way_back = peer.id == frame.peer || peer.components().any(|c| c == sender);
            // Of an autopilot in whose place we stand all is passed on: what is left out would count as lost.
            let leaves = for_all || may_leave(frame.message_id);
            if !heard || is_way_back || !self.config.forwards || !leaves {
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
        let makes_room = |hub: &mut Self| (sender.is_some() && hub.close_listener()) || hub.makes_room(since);
        if self.peers.len() >= MAX_PEERS && !makes_room(self) {
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

    /// Closes the connection that has been there for longest without a word; whether there was one.
    fn close_listener(&mut self) -> bool {
        let Some(i) = self.peers.iter().position(|p| p.is_listener) else { return false };
        let listener = self.peers.remove(i);
        self.to_close.push_back((listener.endpoint, listener.address));
        true
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
