//! A process with a session and its sockets, as the shell has them: what comes is held by the socket up to
//! its room and taken by the hub, a batch at a time.

use std::collections::VecDeque;

use samara::link::parachute::PARACHUTE_COMPONENT;
use samara::link::parties::{self, StreamerChoice};
use samara::link::signing::Key;
use samara::link::stamps::Stamps;
use samara::link::streamer::{Procedure, STREAMER_COMPONENT, STREAMER_SYSTEM};
use samara::link::{
    AutopilotSession, Decoder, EndpointId, Frame, HilSession, Hub, HubConfig, HubEvent, Link,
    StreamerSession, Transmit,
};
use samara::sim::ReleaseTrigger;

use super::FLIGHT;
use super::trouble::Trouble;
use super::wire::{Address, Call, Datagram, Vehicle, ports};

/// Datagrams that a socket holds before the next are lost: Linux's default of 212 992 bytes
/// (net.core.rmem_default) by the 768 that it counts for a small one.
const SOCKET_ROOM: usize = 277;
/// The shell's: datagrams that are taken at a time.
const AT_A_TIME: usize = 64;
/// Wall time that a party needs for a datagram [us].
const DATAGRAM_US: u64 = 4;

/// What signed frames are signed with.
pub fn key() -> Key {
    Key::from_passphrase("titan")
}

/// One process.
pub struct Process<S> {
    pub session: S,
    pub hub: Hub<Address>,
    /// UDP ports and links of the hub's endpoints.
    sockets: Vec<(Address, Link)>,
    inbox: VecDeque<Datagram>,
    /// The TCP server's endpoint, its connections, and what has come by them.
    door: Option<EndpointId>,
    pub connections: Vec<Address>,
    calls: VecDeque<(Address, Call)>,
    /// When it was started.
    pub started: u64,
    /// Since when what it waits for is missing.
    pub waiting: u64,
}

/// What came of a turn at the sockets.
pub struct Received {
    /// Nothing more was there.
    pub is_empty: bool,
    /// Wall time that it took [us].
    pub took_us: u64,
    /// Frames that were handed to the session and were nobody's of the parties, and the others' datagrams.
    pub forged: usize,
    pub let_in: Vec<Datagram>,
    /// Connections that were closed by us.
    pub closed: Vec<Address>,
    /// Somebody was told to have another clock.
    pub other_clock: bool,
}

impl<S> Process<S> {
    /// A process that starts at `now`; with a key if the trouble has one.
    fn new(session: S, (own, memory_us, forwards): ((u8, u8), u64, bool), now: u64, of: &Trouble) -> Self {
        let hub = Hub::new(HubConfig { own, memory_us, forwards, key: of.signed.then(key) });
        Self {
            session,
            hub,
            sockets: Vec::new(),
            inbox: VecDeque::new(),
            door: None,
            connections: Vec::new(),
            calls: VecDeque::new(),
            started: now,
            waiting: now,
        }
    }

    fn bind(&mut self, unix: u64, link: Link, port: Address, kept: &[Address]) {
        let id = self.hub.add_endpoint(link);
        self.sockets.push((port, link));
        for remote in kept {
            self.hub.keep(unix, id, *remote);
        }
    }

    /// Goes on from the stamps that were kept on disk.
    pub fn resume(&mut self, unix: u64, stamps: &str) {
        self.hub.resume(unix, Stamps::parse(stamps).unwrap()).unwrap();
    }

    /// A datagram has reached one of its sockets; false if there is no room for it.
    pub fn deliver(&mut self, datagram: Datagram) -> bool {
        let has_room = self.inbox.len() < SOCKET_ROOM;
        if has_room {
            self.inbox.push_back(datagram);
        }
        has_room
    }

    /// A client of its TCP server does something.
    pub fn call(&mut self, from: Address, call: Call) {
        self.calls.push_back((from, call));
    }

    /// Takes what has come, as the shell does in a turn of its loop.
    pub fn receive(&mut self, unix: u64, mut each: impl FnMut(&mut S, Link, Address, &Frame)) -> Received {
        let Self { session, hub, sockets, inbox, door, connections, calls, .. } = self;
        let (mut taken, mut forged, mut let_in) = (0, 0, Vec::new());
        for datagram in inbox.drain(..inbox.len().min(AT_A_TIME)) {
            let i = sockets.iter().position(|(port, _)| *port == datagram.to).unwrap();
            let link = sockets[i].1;
            taken += 1;
            let mut is_let_in = false;
            hub.datagram(unix, EndpointId(i as u8), datagram.from, &datagram.bytes, |frame| {
                is_let_in = true;
                each(session, link, datagram.from, frame);
            });
            match is_let_in {
                true if datagram.forged => forged += 1,
                true => let_in.push(datagram),
                false => {}
            }
        }
        for (from, call) in calls.drain(..) {
            let Some(door) = *door else { continue };
            match call {
                // An address has one connection at a time.
                Call::Dial if connections.contains(&from) => {}
                Call::Dial => {
                    hub.accept(unix, door, from);
                    connections.push(from);
                }
                Call::Say(bytes) if connections.contains(&from) => {
                    hub.stream(unix, door, from, &bytes, |frame| {
                        forged += usize::from(from != ports::OPERATOR_TCP);
                        each(session, Link::GroundStation, from, frame);
                    });
                }
                Call::Say(_) => {}
            }
        }
        let mut closed = Vec::new();
        while let Some((id, from)) = hub.poll_close(unix) {
            hub.forget(id, from);
            connections.retain(|open| *open != from);
            closed.push(from);
        }
        let mut other_clock = false;
        while let Some(event) = hub.poll_event() {
            other_clock |= matches!(event, HubEvent::OtherClock(..));
        }
        let took_us = taken * DATAGRAM_US;
        Received { is_empty: inbox.is_empty(), took_us, forged, let_in, closed, other_clock }
    }

    /// What goes where of a frame that the session wants sent: by which socket (none: to a TCP client), to
    /// whom.
    pub fn send(&mut self, unix: u64, sent: &Transmit) -> Vec<(Option<Address>, Address, Vec<u8>)> {
        let mut out = Vec::new();
        let Self { hub, sockets, .. } = self;
        hub.send(unix, sent, |id, to, bytes| {
            out.push((sockets.get(usize::from(id.0)).map(|s| s.0), to, bytes.to_vec()));
        });
        out
    }

    /// What is to be passed on, in the same form.
    pub fn forwards(&mut self) -> Vec<(Option<Address>, Address, Vec<u8>)> {
        let Self { hub, sockets, .. } = self;
        std::iter::from_fn(|| hub.poll_forward())
            .map(|(id, to, bytes)| (sockets.get(usize::from(id.0)).map(|s| s.0), to, bytes))
            .collect()
    }
}

/// Unix time at which the network begins [us].
pub const EPOCH_US: u64 = 1_800_000_000_000_000;

pub fn simulator(of: &Trouble, vehicle: Vehicle, now: u64, unix: u64) -> Process<HilSession> {
    let mut mission = FLIGHT.mission.clone();
    // The other one is nobody's, and comes down by its clock.
    mission.release.trigger = if vehicle == Vehicle::Ours { of.trigger } else { ReleaseTrigger::Time };
    let session = parties::simulator(&mission, 1, None, None);
    let mut process = Process::new(session, ((1, PARACHUTE_COMPONENT), 10_000_000, false), now, of);
    process.hub.expect_doubles();
    process.hub.reserve_for((1, 1));
    process.bind(unix, Link::Parachute, vehicle.port(ports::PARACHUTE), &[ports::STATION, ports::API]);
    process
}

pub fn autopilot(of: &Trouble, vehicle: Vehicle, now: u64, unix: u64) -> Process<AutopilotSession> {
    let (session, _) = parties::autopilot(&FLIGHT.mission, None, false, 1).unwrap();
    let mut process = Process::new(session, ((1, 1), 10_000_000, true), now, of);
    process.bind(unix, Link::GroundStation, vehicle.port(ports::GROUND), &[ports::STATION]);
    process.bind(unix, Link::Api, vehicle.port(ports::AUTOPILOT_API), &[ports::API]);
    let parachute = vehicle.port(ports::PARACHUTE);
    process.bind(unix, Link::Parachute, vehicle.port(ports::ROUTER), &[parachute]);
    process.door = Some(process.hub.add_endpoint(Link::GroundStation));
    process
}

pub fn streamer(of: &Trouble, now: u64, unix: u64) -> Process<StreamerSession> {
    let mut mission = FLIGHT.mission.clone();
    mission.release.trigger = of.trigger;
    let choice = StreamerChoice { procedure: Some(Procedure::default()), ..StreamerChoice::default() };
    let session = parties::streamer(&mission, FLIGHT.plan.clone(), 1, choice);
    let own = (STREAMER_SYSTEM, STREAMER_COMPONENT);
    let mut process = Process::new(session, (own, 600_000_000, false), now, of);
    process.bind(unix, Link::Api, ports::API, &[ports::AUTOPILOT_API, ports::PARACHUTE]);
    process
}

/// The two ends of the connection between a simulator and its autopilot.
#[derive(Default)]
pub struct Wired {
    pub connection: Option<u32>,
    pub since: u64,
    /// What has come to the simulator and to the autopilot, and the time of the latest on the way.
    pub inboxes: [VecDeque<Vec<u8>>; 2],
    pub decoders: [Decoder; 2],
    pub latest: [u64; 2],
    /// When the autopilot has tried to connect last.
    pub dialled: Option<u64>,
}

impl Wired {
    /// A new connection stands.
    pub fn connect(&mut self, connection: u32, now: u64) {
        let dialled = self.dialled;
        *self = Self { connection: Some(connection), since: now, dialled, ..Self::default() };
    }

    /// Frames that have come to one end, 0 the simulator's.
    pub fn receive(&mut self, end: usize, mut each: impl FnMut(&Frame)) {
        for bytes in self.inboxes[end].drain(..) {
            self.decoders[end].push(&bytes);
            while let Some(frame) = self.decoders[end].next_frame() {
                each(&frame);
            }
        }
    }
}
