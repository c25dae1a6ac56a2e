//! Virtual wall time, sockets and connections between them, and the hosts of the sessions: each does in a
//! turn what the shell's loops do with sockets, and turns come when something has arrived or is due.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::time::Duration;

use mavlink::dialects::common::{MavCmd, MavMessage, MavModeFlag};
use samara::autopilot::FlightMode;
use samara::link::parachute::PARACHUTE_COMPONENT;
use samara::link::parties::{self, StreamerChoice};
use samara::link::streamer::{Procedure, STREAMER_COMPONENT, STREAMER_SYSTEM, StreamerState};
use samara::link::{
    AutopilotSession, Decoder, Encoder, EndpointId, HilSession, Hub, HubConfig, Link, Pace, Session as _,
    StreamerSession, Transmit,
};
use samara::random::Stream;
use samara::report::{FlownDrop, judge_drop};
use samara::sim::{DropEvent, Phase};

use super::FLIGHT;
use super::frames;
use super::trouble::{Act, Trouble};

/// A UDP port.
pub type Address = u16;

/// Well-known ports, as an instance has them.
pub mod ports {
    use super::Address;

    pub const STATION: Address = 14_550;
    pub const API: Address = 14_540;
    pub const GROUND: Address = 18_570;
    pub const AUTOPILOT_API: Address = 14_580;
    pub const PARACHUTE: Address = 14_600;
    /// The autopilot's own towards the parachute.
    pub const ROUTER: Address = 40_000;
    /// An operator's ground station, which is no default remote.
    pub const OPERATOR: Address = 5_001;
}

/// A process of the drop, or the operator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Host {
    Simulator,
    Autopilot,
    Streamer,
    Operator,
}

/// Something that the operator asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// A HEARTBEAT of the parachute, through the autopilot.
    Parachute,
    /// The mission cleared.
    Clear,
    /// A file of the autopilot's.
    File,
}

const HOSTS: [Host; 4] = [Host::Simulator, Host::Autopilot, Host::Streamer, Host::Operator];
/// Unix time at which the network begins [us].
const EPOCH_US: u64 = 1_800_000_000_000_000;
/// The shell's.
const WATCH_US: u64 = 100_000;
const RETRY_US: u64 = 250_000;
const AT_A_TIME: usize = 64;
/// Datagrams that a socket holds before the next are lost.
const SOCKET_ROOM: usize = 256;
/// From the arrival of something to the turn of the host [us].
const WAKE_US: u64 = 5;
/// From a socket to the next [us].
const DELAY_US: u64 = 15;
/// A run that has not ended so long after its last trouble does not end [us]: the streamer's patience is
/// 15 s.
const PATIENCE_US: u64 = 60_000_000;

struct Process<S> {
    session: S,
    hub: Hub<Address>,
    /// Ports of the hub's endpoints.
    ports: Vec<Address>,
    inbox: VecDeque<(Address, Address, Vec<u8>)>,
    stream: VecDeque<Vec<u8>>,
    decoder: Decoder,
    connection: Option<u32>,
    started: u64,
    /// Since when what it waits for is missing.
    waiting: u64,
}

impl<S> Process<S> {
    fn new(session: S, own: (u8, u8), memory_us: u64, forwards: bool, started: u64) -> Self {
        let hub = Hub::new(HubConfig { own, memory_us, forwards, key: None });
        Self {
            session,
            hub,
            ports: Vec::new(),
            inbox: VecDeque::new(),
            stream: VecDeque::new(),
            decoder: Decoder::new(),
            connection: None,
            started,
            waiting: started,
        }
    }

    fn bind(&mut self, link: Link, port: Address, kept: &[Address], now: u64) -> EndpointId {
        let id = self.hub.add_endpoint(link);
        self.ports.push(port);
        for remote in kept {
            self.hub.keep(EPOCH_US + now, id, *remote);
        }
        id
    }
}

/// What a run came to, and what was seen on the way.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Both came to an end by themselves.
    pub ended: bool,
    /// Exit 0 of the simulator and of the streamer, if there was one that met a vehicle.
    pub simulator_yes: bool,
    pub streamer_yes: bool,
    /// The last flight was released; while the autopilot was not armed.
    pub released: bool,
    pub unarmed: bool,
    /// Any flight was released.
    pub ever_released: bool,
    pub ever_unarmed: bool,
    /// The parachute was commanded by the streamer while the autopilot's last HEARTBEAT was not armed.
    pub blind_releases: usize,
    /// Longest time that the autopilot was out of OFFBOARD or disarmed between t = 0 and the plan's end,
    /// simulated [s].
    pub left_s: f64,
    /// Difference of the last velocity from the target [m/s]; how far the log goes [s].
    pub last_error_m_s: f64,
    pub logged_s: f64,
    /// A failsafe after the release.
    pub failsafe: bool,
    /// Events in the flight's record, reports of the simulator and of the streamer, most peers of a hub.
    pub recorded: usize,
    pub reports: [usize; 2],
    pub most_served: usize,
    /// Wishes of the operator: asked, granted.
    pub wishes: [usize; 2],
    /// Why the streamer gave up.
    pub gave_up: Option<String>,
    /// Longest silence of the vehicle to an operator who speaks, wall time [s].
    pub unserved_s: f64,
    pub story: Vec<String>,
}

#[derive(Clone, Debug)]
enum Event {
    Datagram { to: Address, from: Address, bytes: Vec<u8> },
    Connect(u32),
    Bytes { connection: u32, to: Host, bytes: Vec<u8> },
    Closed { connection: u32, to: Host },
    Turn(Host),
    Act(usize),
}

/// The network with everything in it.
pub struct World<'a> {
    trouble: &'a Trouble,
    now: u64,
    queue: BinaryHeap<Reverse<(u64, u64)>>,
    events: Vec<Option<Event>>,
    dice: Stream,
    simulator: Process<HilSession>,
    autopilot: Process<AutopilotSession>,
    streamer: Process<StreamerSession>,
    operator: Operator,
    /// When each host's next turn is, and until when it stalls and is cut off.
    turns: [Option<u64>; 4],
    stalled: [u64; 4],
    cut_off: [u64; 4],
    anchor: Option<(u64, u64)>,
    connections: u32,
    dialled: Option<u64>,
    latest_bytes: [u64; 2],
    heard_armed: bool,
    left_since: Option<u64>,
    seen: Outcome,
}

struct Operator {
    inbox: VecDeque<Vec<u8>>,
    quiet_until: u64,
    speaks_since: Option<u64>,
    heard: u64,
    next_beat: u64,
    asked: Option<Wish>,
    sequence: u16,
}

fn index(host: Host) -> usize {
    HOSTS.iter().position(|h| *h == host).unwrap()
}

fn owner(port: Address) -> Option<Host> {
    match port {
        ports::PARACHUTE => Some(Host::Simulator),
        ports::GROUND | ports::AUTOPILOT_API | ports::ROUTER => Some(Host::Autopilot),
        ports::API => Some(Host::Streamer),
        ports::OPERATOR => Some(Host::Operator),
        _ => None,
    }
}

fn simulator(trouble: &Trouble, now: u64) -> Process<HilSession> {
    let mut mission = FLIGHT.mission.clone();
    mission.release.trigger = trouble.trigger;
    let session = parties::simulator(&mission, 1, None, None);
    let mut process = Process::new(session, (1, PARACHUTE_COMPONENT), 10_000_000, false, now);
    process.hub.expect_doubles();
    process.hub.reserve_for((1, 1));
    // As behind an autopilot that passes its frames on.
    process.hub.speak_unasked(false);
    process.bind(Link::Parachute, ports::PARACHUTE, &[ports::STATION, ports::API], now);
    process
}

fn autopilot(now: u64) -> Process<AutopilotSession> {
    let (session, _) = parties::autopilot(&FLIGHT.mission, None, false, 1).unwrap();
    let mut process = Process::new(session, (1, 1), 10_000_000, true, now);
    process.bind(Link::GroundStation, ports::GROUND, &[ports::STATION], now);
    process.bind(Link::Api, ports::AUTOPILOT_API, &[ports::API], now);
    process.bind(Link::Parachute, ports::ROUTER, &[ports::PARACHUTE], now);
    process
}

fn streamer(trouble: &Trouble, now: u64) -> Process<StreamerSession> {
    let mut mission = FLIGHT.mission.clone();
    mission.release.trigger = trouble.trigger;
    let choice = StreamerChoice { procedure: Some(Procedure::default()), ..StreamerChoice::default() };
    let session = parties::streamer(&mission, FLIGHT.plan.clone(), 1, choice);
    let own = (STREAMER_SYSTEM, STREAMER_COMPONENT);
    let mut process = Process::new(session, own, 600_000_000, false, now);
    process.bind(Link::Api, ports::API, &[ports::AUTOPILOT_API, ports::PARACHUTE], now);
    process
}

impl<'a> World<'a> {
    pub fn new(trouble: &'a Trouble) -> Self {
        let [of_simulator, of_autopilot, of_streamer, _] = trouble.starts;
        let mut world = Self {
            trouble,
            now: 0,
            queue: BinaryHeap::new(),
            events: Vec::new(),
            dice: Stream::new(trouble.seed, 2),
            simulator: simulator(trouble, of_simulator),
            autopilot: autopilot(of_autopilot),
            streamer: streamer(trouble, of_streamer),
            operator: Operator {
                inbox: VecDeque::new(),
                quiet_until: 0,
                speaks_since: None,
                heard: 0,
                next_beat: 0,
                asked: None,
                sequence: 0,
            },
            turns: [None; 4],
            stalled: trouble.starts,
            cut_off: [0; 4],
            anchor: None,
            connections: 0,
            dialled: None,
            latest_bytes: [0; 2],
            heard_armed: false,
            left_since: None,
            seen: Outcome::default(),
        };
        if !trouble.streams {
            world.stalled[index(Host::Streamer)] = u64::MAX;
        }
        for host in HOSTS {
            world.wake(host, world.stalled[index(host)]);
        }
        for (i, (at, _)) in trouble.acts.iter().enumerate() {
            world.push(*at, Event::Act(i));
        }
        world
    }

    /// Runs to the end of both, or to the end of all patience.
    pub fn run(mut self) -> Outcome {
        let troubles_end = self.trouble.acts.iter().map(|(at, _)| *at).max().unwrap_or(0);
        let starts_end = self.trouble.starts.into_iter().max().unwrap_or(0);
        let flight_us = (2.0 * 10.0 / self.trouble.speed * 1e6) as u64;
        let limit = troubles_end.max(starts_end) + 2 * flight_us + PATIENCE_US;
        while let Some(Reverse((at, number))) = self.queue.pop() {
            if at > limit {
                break;
            }
            self.now = at;
            if let Some(event) = self.events[number as usize].take() {
                self.happen(event);
            }
            let waits = self.streamer.session.state() == StreamerState::WaitingForVehicle;
            let streamed = self.streamer.session.is_over() || waits || !self.trouble.streams;
            if self.simulator.session.pace() == Pace::Done && streamed && at > troubles_end {
                self.seen.ended = true;
                break;
            }
        }
        self.conclude()
    }

    fn push(&mut self, at: u64, event: Event) {
        self.queue.push(Reverse((at, self.events.len() as u64)));
        self.events.push(Some(event));
    }

    fn wake(&mut self, host: Host, at: u64) {
        if at == u64::MAX {
            return;
        }
        let turn = &mut self.turns[index(host)];
        if turn.is_none_or(|t| t > at) {
            *turn = Some(at);
            self.push(at, Event::Turn(host));
        }
    }

    fn happen(&mut self, event: Event) {
        let soon = self.now + WAKE_US;
        match event {
            Event::Datagram { to, from, bytes } => {
                let Some(host) = owner(to) else { return };
                let room = |len: usize| len < SOCKET_ROOM;
                match host {
                    // Nobody listens before the process runs.
                    _ if self.now < self.trouble.starts[index(host)] => return,
                    Host::Simulator if room(self.simulator.inbox.len()) => {
                        self.simulator.inbox.push_back((to, from, bytes));
                    }
                    Host::Autopilot if room(self.autopilot.inbox.len()) => {
                        self.autopilot.inbox.push_back((to, from, bytes));
                    }
                    Host::Streamer if room(self.streamer.inbox.len()) => {
                        self.streamer.inbox.push_back((to, from, bytes));
                    }
                    Host::Operator => self.operator.inbox.push_back(bytes),
                    _ => return,
                }
                self.wake(host, soon);
            }
            Event::Connect(connection) => self.connect(connection),
            Event::Bytes { connection, to, bytes } => {
                if to == Host::Simulator && self.simulator.connection == Some(connection) {
                    self.simulator.stream.push_back(bytes);
                } else if to == Host::Autopilot && self.autopilot.connection == Some(connection) {
                    self.autopilot.stream.push_back(bytes);
                }
                self.wake(to, soon);
            }
            Event::Closed { connection, to } => {
                if to == Host::Simulator && self.simulator.connection == Some(connection) {
                    self.simulator.connection = None;
                    self.simulator.session.peer_left();
                    self.simulator.waiting = self.now;
                } else if to == Host::Autopilot && self.autopilot.connection == Some(connection) {
                    self.autopilot.connection = None;
                }
                self.wake(to, soon);
            }
            Event::Turn(host) => {
                if self.turns[index(host)] != Some(self.now) {
                    return;
                }
                self.turns[index(host)] = None;
                let stalled = self.stalled[index(host)];
                if stalled > self.now {
                    return self.wake(host, stalled);
                }
                match host {
                    Host::Simulator => self.turn_of_simulator(),
                    Host::Autopilot => self.turn_of_autopilot(),
                    Host::Streamer => self.turn_of_streamer(),
                    Host::Operator => self.turn_of_operator(),
                }
            }
            Event::Act(i) => self.act(self.trouble.acts[i].1.clone()),
        }
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Stall(host, long_us) => {
                let stalled = &mut self.stalled[index(host)];
                *stalled = (*stalled).max(self.now + long_us);
            }
            Act::CutOff(host, long_us) => self.cut_off[index(host)] = self.now + long_us,
            Act::Restart(host) => self.restart(host),
            Act::Send(from, to, bytes) => {
                if to == ports::API {
                    Decoder::new()
                        .datagram(&bytes, |frame| self.tell(&format!("{from} sends {:?}", frame.known())));
                }
                self.datagram(to, from, bytes);
            }
            Act::Pause(long_us) => {
                self.operator.quiet_until = self.now + long_us;
                self.operator.speaks_since = None;
            }
            Act::Wish(wish) => self.wish(wish),
            Act::Toggle(times) => self.toggle(times),
        }
    }

    fn restart(&mut self, host: Host) {
        self.tell(&format!("{host:?} is started anew"));
        let now = self.now;
        let closed = |world: &mut Self, connection: Option<u32>, to: Host| {
            if let Some(connection) = connection {
                world.push(now + DELAY_US, Event::Closed { connection, to });
            }
        };
        match host {
            Host::Simulator => {
                let connection = self.simulator.connection;
                self.note_flight();
                self.simulator = simulator(self.trouble, now);
                self.anchor = None;
                closed(self, connection, Host::Autopilot);
            }
            Host::Autopilot => {
                let connection = self.autopilot.connection;
                self.autopilot = autopilot(now);
                self.dialled = None;
                closed(self, connection, Host::Simulator);
            }
            Host::Streamer => self.streamer = streamer(self.trouble, now),
            Host::Operator => {}
        }
        self.wake(host, now + WAKE_US);
    }

    /// Frames of the simulator's link, as a mad autopilot would send them.
    fn toggle(&mut self, times: usize) {
        let Some(connection) = self.autopilot.connection else { return };
        let mut mad = Encoder::new(1, 1);
        let time_usec = self.simulator.session.now();
        let mut bytes = Vec::new();
        for i in 0..2 * times {
            let mut mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
            mode.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, i % 2 == 0);
            let controls = mavlink::dialects::common::HIL_ACTUATOR_CONTROLS_DATA {
                time_usec,
                mode,
                ..Default::default()
            };
            bytes.extend(mad.encode(&MavMessage::HIL_ACTUATOR_CONTROLS(controls)));
        }
        self.push(self.now + DELAY_US, Event::Bytes { connection, to: Host::Simulator, bytes });
    }

    /// Puts a datagram on the wire.
    fn datagram(&mut self, to: Address, from: Address, bytes: Vec<u8>) {
        let is_cut = |port| owner(port).is_some_and(|host| self.cut_off[index(host)] > self.now);
        if owner(to).is_none() || is_cut(to) || is_cut(from) {
            return;
        }
        let wire = self.trouble.wire;
        let copies = 1 + usize::from(wire.doubled > 0.0 && self.dice.uniform() < wire.doubled);
        for _ in 0..copies {
            if wire.loss > 0.0 && self.dice.uniform() < wire.loss {
                continue;
            }
            let jitter = if wire.jitter_us > 0.0 { self.dice.between(0.0, wire.jitter_us) } else { 0.0 };
            let at = self.now + DELAY_US + jitter as u64;
            self.push(at, Event::Datagram { to, from, bytes: bytes.clone() });
        }
    }

    /// Puts bytes on the connection between simulator and autopilot, which keeps their order.
    fn bytes(&mut self, connection: Option<u32>, to: Host, bytes: Vec<u8>) {
        let Some(connection) = connection else { return };
        let latest = &mut self.latest_bytes[usize::from(to == Host::Autopilot)];
        *latest = (*latest).max(self.now + DELAY_US);
        let at = *latest;
        self.push(at, Event::Bytes { connection, to, bytes });
    }

    /// The autopilot's call reaches the simulator.
    fn connect(&mut self, connection: u32) {
        let up = self.now >= self.trouble.starts[index(Host::Simulator)];
        let free = self.simulator.connection.is_none();
        if !up || !free || self.simulator.session.pace() == Pace::Done {
            return;
        }
        self.note_flight();
        self.simulator.connection = Some(connection);
        self.simulator.stream.clear();
        self.simulator.decoder = Decoder::new();
        self.simulator.session.peer_connected();
        self.simulator.waiting = self.now;
        self.anchor = None;
        self.autopilot.connection = Some(connection);
        self.autopilot.stream.clear();
        self.autopilot.decoder = Decoder::new();
        self.autopilot.session.simulator_connected();
        for host in [Host::Simulator, Host::Autopilot] {
            self.wake(host, self.now + WAKE_US);
        }
    }

    fn turn_of_simulator(&mut self) {
        let (now, unix) = (self.now, EPOCH_US + self.now);
        let Process { session, hub, ports, inbox, stream, decoder, waiting, .. } = &mut self.simulator;
        let paced = session.pace();
        for bytes in stream.drain(..) {
            decoder.push(&bytes);
            while let Some(frame) = decoder.next_frame() {
                session.handle_input(Link::Simulator, &frame);
            }
        }
        for _ in 0..AT_A_TIME {
            let Some((to, from, bytes)) = inbox.pop_front() else { break };
            let id = EndpointId(ports.iter().position(|p| *p == to).unwrap() as u8);
            hub.datagram(unix, id, from, &bytes, |frame| session.handle_input(Link::Parachute, frame));
        }
        let more = !inbox.is_empty();
        if paced == Pace::NoPeer && session.pace() != Pace::NoPeer {
            *waiting = now;
        }
        let waited = now - *waiting;
        if session.missing().is_some() && waited >= WATCH_US {
            session.handle_silence(Duration::from_micros(waited));
        }
        let mut next = now + WATCH_US;
        if let Some(at) = session.next_wake() {
            let (from, start) = *self.anchor.get_or_insert((now, at));
            let due = from + ((at.saturating_sub(start)) as f64 / self.trouble.speed) as u64;
            let late = (100_000.0 / self.trouble.speed).max(5_000.0) as u64;
            if now > due + late {
                self.anchor = Some((now, at));
            }
            if now >= due {
                session.handle_time(at);
                *waiting = now;
                next = now + WAKE_US;
            } else {
                next = next.min(due);
            }
        }
        if more {
            next = now + WAKE_US;
        }
        while let Some(event) = self.simulator.session.poll_event() {
            self.seen.reports[0] += 1;
            self.tell(&format!("simulator {event}"));
        }
        while let Some(sent) = self.simulator.session.poll_output() {
            if sent.link == Link::Simulator {
                self.bytes(self.simulator.connection, Host::Autopilot, sent.bytes);
            } else {
                self.send_by(Host::Simulator, &sent);
            }
        }
        self.look();
        if self.simulator.session.pace() != Pace::Done {
            self.wake(Host::Simulator, next);
        } else if let Some(connection) = self.simulator.connection.take() {
            self.push(now + DELAY_US, Event::Closed { connection, to: Host::Autopilot });
        }
    }

    fn turn_of_autopilot(&mut self) {
        let (now, unix) = (self.now, EPOCH_US + self.now);
        if self.autopilot.connection.is_none() && self.dialled.is_none_or(|at| now >= at + RETRY_US) {
            self.dialled = Some(now);
            self.connections += 1;
            self.push(now + DELAY_US, Event::Connect(self.connections));
        }
        let Process { session, hub, ports, inbox, stream, decoder, started, .. } = &mut self.autopilot;
        for bytes in stream.drain(..) {
            decoder.push(&bytes);
            while let Some(frame) = decoder.next_frame() {
                session.handle_input(Link::Simulator, &frame);
            }
        }
        for _ in 0..AT_A_TIME {
            let Some((to, from, bytes)) = inbox.pop_front() else { break };
            let at = ports.iter().position(|p| *p == to).unwrap();
            let link = [Link::GroundStation, Link::Api, Link::Parachute][at];
            hub.datagram(unix, EndpointId(at as u8), from, &bytes, |frame| session.handle_input(link, frame));
        }
        let more = !inbox.is_empty();
        session.handle_time(now - *started);
        while session.poll_log().is_some() {}
        let forwards: Vec<_> = std::iter::from_fn(|| hub.poll_forward()).collect();
        for (id, to, bytes) in forwards {
            let from = self.autopilot.ports[usize::from(id.0)];
            self.datagram(to, from, bytes);
        }
        while let Some(sent) = self.autopilot.session.poll_output() {
            match sent.link {
                Link::Simulator => self.bytes(self.autopilot.connection, Host::Simulator, sent.bytes),
                _ => {
                    self.send_by(Host::Autopilot, &sent);
                    // By this the parachute knows its router.
                    if sent.link == Link::Api && sent.bytes[7..10] == [0; 3] {
                        let beat = Transmit::to_all(Link::Parachute, sent.bytes);
                        self.send_by(Host::Autopilot, &beat);
                    }
                }
            }
        }
        self.look();
        let until = self.autopilot.session.next_wake().map(|at| at + self.autopilot.started);
        let next = until.unwrap_or(now + WATCH_US).max(now + WAKE_US);
        let next = if self.autopilot.connection.is_none() { next.min(now + RETRY_US) } else { next };
        self.wake(Host::Autopilot, if more { now + WAKE_US } else { next });
    }

    fn turn_of_streamer(&mut self) {
        let (now, unix) = (self.now, EPOCH_US + self.now);
        let Process { session, hub, inbox, started, waiting, .. } = &mut self.streamer;
        if session.is_over() {
            return;
        }
        let before = session.now();
        for _ in 0..AT_A_TIME {
            let Some((_, from, bytes)) = inbox.pop_front() else { break };
            hub.datagram(unix, EndpointId(0), from, &bytes, |frame| {
                if from == ports::AUTOPILOT_API
                    && frame.component_id == 1
                    && let Some(MavMessage::HEARTBEAT(m)) = frame.known()
                {
                    self.heard_armed = m.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
                }
                session.handle_input(Link::Api, frame);
            });
        }
        let is_empty = inbox.is_empty();
        if is_empty {
            session.handle_empty(Duration::from_micros(now - *started), false);
        }
        if session.now() == before {
            session.handle_silence(Duration::from_micros(now - *waiting));
        } else {
            *waiting = now;
        }
        while let Some(event) = self.streamer.session.poll_event() {
            self.seen.reports[1] += 1;
            self.tell(&format!("streamer {event}"));
        }
        while let Some(sent) = self.streamer.session.poll_output() {
            let gripper = (MavCmd::MAV_CMD_DO_GRIPPER as u16).to_le_bytes();
            let is_command = sent.bytes[7..10] == [76, 0, 0] && sent.bytes.len() > 40;
            if is_command && sent.bytes[38..40] == gripper && !self.heard_armed {
                self.seen.blind_releases += 1;
            }
            self.send_by(Host::Streamer, &sent);
        }
        let next = if is_empty { now + WATCH_US } else { now + WAKE_US };
        self.wake(Host::Streamer, next);
    }

    fn turn_of_operator(&mut self) {
        let now = self.now;
        let messages: Vec<Vec<u8>> = self.operator.inbox.drain(..).collect();
        for bytes in messages {
            let quiet = std::mem::replace(&mut self.operator.heard, now);
            if self.operator.speaks_since.is_some_and(|since| now > since + 2_500_000) {
                self.note_unserved(now - quiet);
            }
            Decoder::new().datagram(&bytes, |frame| {
                let is_granted = match self.operator.asked {
                    Some(Wish::Parachute) => frame.component_id == 161 && frame.command_ack().is_some(),
                    // MISSION_ACK, accepted.
                    Some(Wish::Clear) => frame.message_id == 47 && frame.payload().u8(2) == 0,
                    // ACK of the file server.
                    Some(Wish::File) => frame.message_id == 110 && frame.payload().u8(3 + 3) == 128,
                    None => false,
                };
                if is_granted {
                    self.operator.asked = None;
                    self.seen.wishes[1] += 1;
                }
            });
        }
        if now >= self.operator.quiet_until && now >= self.operator.next_beat {
            self.operator.next_beat = now + 1_000_000;
            self.operator.speaks_since.get_or_insert(now);
            self.datagram(ports::GROUND, ports::OPERATOR, frames::station_heartbeat(255));
        }
        let next = self.operator.next_beat.max(self.operator.quiet_until);
        self.wake(Host::Operator, next.max(now + WAKE_US));
    }

    /// The vehicle has said nothing to the operator for so long [us].
    fn note_unserved(&mut self, silent_us: u64) {
        self.seen.unserved_s = self.seen.unserved_s.max(silent_us as f64 * 1e-6);
    }

    fn wish(&mut self, wish: Wish) {
        self.seen.wishes[0] += 1;
        self.operator.asked = Some(wish);
        self.operator.sequence += 1;
        let bytes = match wish {
            Wish::Parachute => {
                frames::command(255, MavCmd::MAV_CMD_REQUEST_MESSAGE, (1, PARACHUTE_COMPONENT), [0.0; 3])
            }
            Wish::Clear => frames::mission_clear(255),
            Wish::File => frames::file_open(255, 100 + self.operator.sequence),
        };
        self.datagram(ports::GROUND, ports::OPERATOR, bytes);
    }

    /// Sends what a session wants sent, through its hub.
    fn send_by(&mut self, host: Host, sent: &Transmit) {
        let unix = EPOCH_US + self.now;
        let mut out = Vec::new();
        let mut to = |id: EndpointId, address, bytes: &[u8]| out.push((id, address, bytes.to_vec()));
        let ports = match host {
            Host::Simulator => {
                self.simulator.hub.send(unix, sent, &mut to);
                &self.simulator.ports
            }
            Host::Autopilot => {
                self.autopilot.hub.send(unix, sent, &mut to);
                &self.autopilot.ports
            }
            _ => {
                self.streamer.hub.send(unix, sent, &mut to);
                &self.streamer.ports
            }
        };
        let sent: Vec<_> = out.iter().map(|(id, ..)| ports[usize::from(id.0)]).collect();
        for (from, (_, to, bytes)) in sent.into_iter().zip(out) {
            self.datagram(to, from, bytes);
        }
    }

    /// The truth, and what grows.
    fn look(&mut self) {
        let unix = EPOCH_US + self.now;
        let served = [&self.simulator.hub, &self.autopilot.hub].map(|hub| hub.served(unix));
        self.seen.most_served = served.into_iter().fold(self.seen.most_served, usize::max);
        let run = self.simulator.session.run();
        let (t_us, simulation) = (run.now(), run.simulation());
        let powered_s = simulation.powered_from_s().map(|from| t_us as f64 * 1e-6 - from);
        let plan_s = FLIGHT.plan.end_s();
        let in_plan = simulation.phase() == Phase::Powered && powered_s.is_some_and(|t| t < plan_s);
        let autopilot = self.autopilot.session.autopilot();
        let flies = autopilot.is_armed() && autopilot.mode() == FlightMode::Offboard;
        if in_plan && !flies {
            let since = *self.left_since.get_or_insert(t_us);
            let left_s = t_us.saturating_sub(since) as f64 * 1e-6;
            self.seen.left_s = self.seen.left_s.max(left_s);
        } else {
            self.left_since = None;
        }
    }

    /// The flight that is over, or is about to start over.
    fn note_flight(&mut self) {
        let events = &self.simulator.session.run().record().events;
        self.seen.ever_released |= events.iter().any(|e| matches!(e.event, DropEvent::Released { .. }));
        self.seen.ever_unarmed |= events.iter().any(|e| e.event == DropEvent::ReleasedUnarmed);
    }

    fn tell(&mut self, what: &str) {
        // A run's story is for the one who looks at it; a flood is not retold.
        if self.seen.story.len() < 400 {
            self.seen.story.push(format!("{:10.6} {what}", self.now as f64 * 1e-6));
        }
    }

    fn conclude(mut self) -> Outcome {
        self.note_flight();
        let served = self.operator.speaks_since.is_some_and(|since| self.now > since + 2_500_000);
        if served && self.operator.heard > 0 {
            self.note_unserved(self.now - self.operator.heard);
        }
        let mission = &FLIGHT.mission;
        let record = self.simulator.session.run().record().clone();
        let log = self.simulator.session.run().log();
        let flown = FlownDrop { log, record: &record, plan: None, by: None, trouble: None };
        let (verdict, run) = judge_drop(mission, &flown);
        let seen = &mut self.seen;
        seen.simulator_yes = run.is_safe(verdict.as_ref());
        seen.gave_up = self.streamer.session.failure().map(str::to_owned);
        seen.streamer_yes = self.streamer.session.has_succeeded();
        seen.released = record.events.iter().any(|e| matches!(e.event, DropEvent::Released { .. }));
        seen.unarmed = record.events.iter().any(|e| e.event == DropEvent::ReleasedUnarmed);
        seen.failsafe = record.failsafe;
        seen.recorded = record.events.len();
        if let Some(last) = log.last() {
            seen.logged_s = last.t_s;
            seen.last_error_m_s = (last.state.body.v_ned - mission.target_v_ned).norm();
        }
        self.seen
    }
}
