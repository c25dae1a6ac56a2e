//! The network with everything in it: what happens is taken in the order of its time, acts of the trouble
//! are done, and hosts have their turns (`turns`).

use std::collections::VecDeque;

use mavlink::dialects::common::MavModeFlag;
use samara::link::{AutopilotSession, HilSession, Pace, StreamerSession};
use samara::random::{Purpose, Stream};

use super::frames;
use super::operator::Operator;
use super::process::{self, EPOCH_US, Process, Wired};
use super::seen::Outcome;
use super::trouble::{Act, Trouble};
use super::turns::{self, WAKE_US};
use super::wire::{Address, Call, Datagram, Event, Host, Queue, Vehicle, ports};

/// From a socket to the next [us].
pub(super) const DELAY_US: u64 = 15;
/// From one datagram to the next of a backlog that passes on [us].
const PASS_US: u64 = 8;
/// A run that has not ended so long after its last trouble does not end [us]: the streamer's patience is
/// 15 s.
const PATIENCE_US: u64 = 60_000_000;

/// A simulator and its autopilot.
pub(super) struct Pair {
    pub(super) simulator: Process<HilSession>,
    pub(super) autopilot: Process<AutopilotSession>,
    pub(super) wired: Wired,
    /// When simulated time had which value: the pace is kept from there.
    pub(super) anchor: Option<(u64, u64)>,
    /// The autopilot passes the parachute's frames on.
    pub(super) routed: bool,
}

/// See the head of this file.
pub struct World<'a> {
    pub(super) trouble: &'a Trouble,
    pub(super) now: u64,
    pub(super) queue: Queue,
    dice: Stream,
    pub(super) ours: Pair,
    pub(super) other: Option<Pair>,
    pub(super) streamer: Process<StreamerSession>,
    pub(super) operator: Operator,
    /// When each host's next turn is, until when it stalls and is cut off, and from when on what comes to it
    /// is not behind a backlog on the way.
    turns: [Option<u64>; Host::ALL.len()],
    stalled: [u64; Host::ALL.len()],
    cut_off: [u64; Host::ALL.len()],
    backlog: [u64; Host::ALL.len()],
    /// The stamps of signed frames that each host keeps.
    pub(super) stamps: [Option<String>; Host::ALL.len()],
    /// What somebody has recorded of that which was let in. (What never arrived is no replay: it counts when
    /// it comes.)
    pub(super) recorded: VecDeque<Datagram>,
    pub(super) connections: u32,
    pub(super) heard_armed: bool,
    /// Whose autopilot the streamer has met, and whether the other one is armed.
    pub(super) met: Option<Vehicle>,
    pub(super) other_is_armed: bool,
    pub(super) seen: Outcome,
}

impl<'a> World<'a> {
    pub fn new(trouble: &'a Trouble) -> Self {
        let start = |host: Host| trouble.start(host);
        let unix = |host: Host| unix(trouble, host, start(host));
        let pair = |vehicle: Vehicle| {
            let (simulator, autopilot) = (Host::Simulator(vehicle), Host::Autopilot(vehicle));
            Pair {
                simulator: process::simulator(trouble, vehicle, start(simulator), unix(simulator)),
                autopilot: process::autopilot(trouble, vehicle, start(autopilot), unix(autopilot)),
                wired: Wired::default(),
                anchor: None,
                routed: false,
            }
        };
        let mut world = Self {
            trouble,
            now: 0,
            queue: Queue::default(),
            dice: Stream::new(trouble.seed, Purpose::Dice, 2),
            ours: pair(Vehicle::Ours),
            other: trouble.other_from.map(|_| pair(Vehicle::Other)),
            streamer: process::streamer(trouble, start(Host::Streamer), unix(Host::Streamer)),
            operator: Operator::new(trouble, unix(Host::Operator)),
            turns: [None; Host::ALL.len()],
            stalled: Host::ALL.map(start),
            cut_off: [0; Host::ALL.len()],
            backlog: [0; Host::ALL.len()],
            stamps: Default::default(),
            recorded: VecDeque::new(),
            connections: 0,
            heard_armed: false,
            met: None,
            other_is_armed: false,
            seen: Outcome::default(),
        };
        for host in Host::ALL {
            world.wake(host, world.stalled[host.index()]);
        }
        for (i, (at, _)) in trouble.acts.iter().enumerate() {
            world.queue.push(*at, Event::Act(i));
        }
        world
    }

    /// Runs to the end of both, or to the end of all patience.
    pub fn run(mut self) -> Outcome {
        let troubles_end = self.trouble.acts.iter().map(|(at, _)| *at).max().unwrap_or(0);
        let starts_end = self.trouble.starts.into_iter().max().unwrap_or(0);
        let flight_us = (2.0 * 10.0 / self.trouble.speed * 1e6) as u64;
        let limit = troubles_end.max(starts_end) + 2 * flight_us + PATIENCE_US;
        while let Some((at, event)) = self.queue.pop() {
            if at > limit {
                break;
            }
            self.now = at;
            self.happen(event);
            let streamer = &self.streamer.session;
            let streamed = streamer.is_over() || turns::waits(streamer) || !self.trouble.streams;
            if self.ours.simulator.session.pace() == Pace::Done && streamed && at > troubles_end {
                self.seen.ended = true;
                break;
            }
        }
        self.seen.note_unserved(self.operator.silence(self.now));
        self.seen.conclude(&self.ours.simulator.session, &self.streamer.session);
        // What it says of the other vehicle says nothing of ours.
        self.seen.streamer_yes &= self.met != Some(Vehicle::Other);
        self.seen
    }

    /// Unix time by a host's clock.
    pub(super) fn unix(&self, host: Host) -> u64 {
        unix(self.trouble, host, self.now)
    }

    pub(super) fn pair(&mut self, vehicle: Vehicle) -> Option<&mut Pair> {
        match vehicle {
            Vehicle::Ours => Some(&mut self.ours),
            Vehicle::Other => self.other.as_mut(),
        }
    }

    /// Gives a host a turn at a time, unless it has one before.
    pub(super) fn wake(&mut self, host: Host, at: u64) {
        let turn = &mut self.turns[host.index()];
        if turn.is_none_or(|t| t > at) {
            *turn = Some(at);
            self.queue.push(at, Event::Turn(host));
        }
    }

    /// A host is at work, or is stopped, until then.
    pub(super) fn occupy(&mut self, host: Host, until: u64) {
        let stalled = &mut self.stalled[host.index()];
        *stalled = (*stalled).max(until);
    }

    pub(super) fn tell(&mut self, what: &str) {
        self.seen.tell(self.now, what);
    }

    fn happen(&mut self, event: Event) {
        let soon = self.now + WAKE_US;
        match event {
            Event::Datagram(datagram) => self.deliver(datagram),
            Event::Connect { vehicle, connection } => self.connect(vehicle, connection),
            Event::Bytes { connection, to, bytes } => {
                let (Host::Simulator(vehicle) | Host::Autopilot(vehicle)) = to else { return };
                let Some(pair) = self.pair(vehicle) else { return };
                if pair.wired.connection == Some(connection) {
                    pair.wired.inboxes[usize::from(to == Host::Autopilot(vehicle))].push_back(bytes);
                }
                self.wake(to, soon);
            }
            Event::Closed { connection, to } => self.closed(connection, to),
            Event::Call { from, call } => {
                let host = Host::Autopilot(Vehicle::Ours);
                if self.now >= self.trouble.start(host) {
                    self.ours.autopilot.call(from, call);
                    self.wake(host, soon);
                }
            }
            Event::Reply { to, bytes } => {
                if to == ports::OPERATOR_TCP {
                    self.operator.is_connected &= bytes.is_some();
                    self.operator.inbox.extend(bytes);
                    self.wake(Host::Operator, soon);
                } else if bytes.is_some() && self.trouble.signed {
                    self.seen.strangers_told += 1;
                }
            }
            Event::Turn(host) => {
                if self.turns[host.index()] != Some(self.now) {
                    return;
                }
                self.turns[host.index()] = None;
                let stalled = self.stalled[host.index()];
                if stalled > self.now {
                    return self.wake(host, stalled);
                }
                self.turn(host);
            }
            Event::Act(i) => self.act(self.trouble.acts[i].1.clone()),
        }
    }

    fn deliver(&mut self, datagram: Datagram) {
        let Some(host) = Host::of(datagram.to) else { return };
        // Nobody listens before the process runs.
        if self.now < self.trouble.start(host) {
            return;
        }
        let delivered = match host {
            Host::Simulator(vehicle) => {
                self.pair(vehicle).is_some_and(|pair| pair.simulator.deliver(datagram))
            }
            Host::Autopilot(vehicle) => {
                self.pair(vehicle).is_some_and(|pair| pair.autopilot.deliver(datagram))
            }
            Host::Streamer => self.streamer.deliver(datagram),
            Host::Operator => {
                self.operator.inbox.push_back(datagram.bytes);
                true
            }
        };
        if delivered {
            self.wake(host, self.now + WAKE_US);
        }
    }

    fn act(&mut self, act: Act) {
        match act {
            Act::Stall(host, long_us) => self.occupy(host, self.now + long_us),
            Act::CutOff(host, long_us) => self.cut_off[host.index()] = self.now + long_us,
            Act::HoldUp(host, long_us) => self.backlog[host.index()] = self.now + long_us,
            Act::Restart { host, killed } => self.restart(host, killed),
            Act::Send(from, to, bytes) => self.datagram(Datagram { to, from, bytes, forged: true }),
            Act::Call(from, call) => self.queue.push(self.now + DELAY_US, Event::Call { from, call }),
            Act::PlayAgain { host, disguised } => self.play_again(host, disguised),
            Act::FarStamp(to) => {
                let mad = frames::far_stamp(self.unix(Host::Operator));
                self.datagram(Datagram { to, from: 50_020, bytes: mad, forged: false });
            }
            Act::Ahead(to, ahead_us) => {
                let unix = self.unix(Host::Operator);
                let bytes = frames::stamped(unix, unix + ahead_us);
                self.datagram(Datagram { to, from: 50_020, bytes, forged: false });
            }
            Act::Flood { to, datagrams } => {
                for _ in 0..datagrams {
                    let bytes = frames::junk(&mut self.dice);
                    self.datagram(Datagram { to, from: 50_040, bytes, forged: true });
                }
            }
            Act::Pause(long_us) => self.operator.pause(self.now + long_us),
            Act::Wish(wish) => {
                self.seen.wishes[0] += 1;
                let bytes = self.operator.ask(wish, self.unix(Host::Operator));
                self.by_operator(bytes);
            }
            Act::Toggle(times) => {
                let now = self.ours.simulator.session.now();
                let mad = |i: usize| {
                    let mut mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
                    mode.set(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED, i & 1 == 0);
                    frames::actuators(now, mode)
                };
                let bytes = (0..2 * times).flat_map(mad).collect();
                self.on_simulators_link(Host::Simulator(Vehicle::Ours), bytes);
            }
            Act::Rewind(times) => {
                let bytes = frames::rewinding(&mut self.dice, times);
                self.on_simulators_link(Host::Autopilot(Vehicle::Ours), bytes);
            }
        }
    }

    /// What the operator says, by the way that they have chosen.
    pub(super) fn by_operator(&mut self, bytes: Vec<u8>) {
        if !self.trouble.operator_by_tcp {
            let (to, from) = (ports::GROUND, ports::OPERATOR);
            return self.datagram(Datagram { to, from, bytes, forged: false });
        }
        let from = ports::OPERATOR_TCP;
        if !std::mem::replace(&mut self.operator.is_connected, true) {
            self.queue.push(self.now + DELAY_US, Event::Call { from, call: Call::Dial });
        }
        self.queue.push(self.now + DELAY_US, Event::Call { from, call: Call::Say(bytes) });
    }

    /// Somebody who has recorded what went to a host sends it there again.
    fn play_again(&mut self, host: Host, disguised: bool) {
        let to_host = |datagram: &&Datagram| Host::of(datagram.to) == Some(host);
        let recorded: Vec<Datagram> = self.recorded.iter().filter(to_host).cloned().collect();
        self.tell(&format!("{} datagrams are played to {host:?} again", recorded.len()));
        // No more than its socket holds.
        for (i, datagram) in recorded.iter().rev().take(250).rev().enumerate() {
            let from = if disguised { datagram.from } else { 50_030 };
            let again = Datagram { from, forged: true, ..datagram.clone() };
            self.queue.push(self.now + DELAY_US + i as u64, Event::Datagram(again));
        }
    }

    fn restart(&mut self, host: Host, killed: bool) {
        self.tell(&format!("{host:?} is started anew"));
        let (now, unix) = (self.now, self.unix(host));
        let trouble = self.trouble;
        let last = match host {
            Host::Simulator(_) => self.ours.simulator.hub.stamps(),
            Host::Autopilot(_) => self.ours.autopilot.hub.stamps(),
            Host::Streamer => self.streamer.hub.stamps(),
            Host::Operator => None,
        };
        if let Some(stamps) = last.filter(|_| !killed) {
            self.stamps[host.index()] = Some(stamps.to_text());
        }
        let stamps = self.stamps[host.index()].clone().filter(|_| trouble.signed);
        let stamps = stamps.as_deref().unwrap_or_default();
        let connection = self.ours.wired.connection;
        let closed = |to: Host| connection.map(|connection| Event::Closed { connection, to });
        let event = match host {
            Host::Simulator(vehicle) => {
                self.seen.note_flight(&self.ours.simulator.session);
                self.ours.simulator = process::simulator(trouble, vehicle, now, unix);
                self.ours.simulator.resume(unix, stamps);
                (self.ours.anchor, self.ours.routed) = (None, false);
                closed(Host::Autopilot(vehicle))
            }
            Host::Autopilot(vehicle) => {
                self.ours.autopilot = process::autopilot(trouble, vehicle, now, unix);
                self.ours.autopilot.resume(unix, stamps);
                self.ours.wired.dialled = None;
                closed(Host::Simulator(vehicle))
            }
            Host::Streamer => {
                self.streamer = process::streamer(trouble, now, unix);
                self.streamer.resume(unix, stamps);
                self.met = None;
                None
            }
            Host::Operator => None,
        };
        if let Some(event) = event {
            // Its own end is closed at once, the other hears of it.
            self.ours.wired.connection = None;
            self.ours.wired.inboxes.iter_mut().for_each(VecDeque::clear);
            self.queue.push(now + DELAY_US, event);
        }
        self.wake(host, now + WAKE_US);
    }

    /// Puts bytes of ours on the connection between simulator and autopilot, which keeps their order.
    fn on_simulators_link(&mut self, to: Host, bytes: Vec<u8>) {
        if let Some(connection) = self.ours.wired.connection {
            self.bytes(Vehicle::Ours, connection, to, bytes);
        }
    }

    pub(super) fn bytes(&mut self, vehicle: Vehicle, connection: u32, to: Host, bytes: Vec<u8>) {
        let arrives = self.now + DELAY_US;
        let Some(pair) = self.pair(vehicle) else { return };
        let latest = &mut pair.wired.latest[usize::from(to == Host::Autopilot(vehicle))];
        *latest = (*latest).max(arrives);
        let at = *latest;
        self.queue.push(at, Event::Bytes { connection, to, bytes });
    }

    /// Puts a datagram on the wire.
    pub(super) fn datagram(&mut self, datagram: Datagram) {
        self.datagram_later(datagram, 0);
    }

    /// Puts a datagram on the wire after so long [us].
    pub(super) fn datagram_later(&mut self, datagram: Datagram, after_us: u64) {
        let host = Host::of(datagram.to);
        if host.is_none() && datagram.to != ports::STATION && self.trouble.signed {
            self.seen.strangers_told += 1;
        }
        let is_cut = |port| Host::of(port).is_some_and(|host| self.cut_off[host.index()] > self.now);
        let Some(host) = host.filter(|_| !is_cut(datagram.to) && !is_cut(datagram.from)) else { return };
        let wire = self.trouble.wire;
        let copies = 1 + usize::from(wire.doubled > 0.0 && self.dice.uniform() < wire.doubled);
        for _ in 0..copies {
            if wire.loss > 0.0 && self.dice.uniform() < wire.loss {
                continue;
            }
            let jitter = if wire.jitter_us > 0.0 { self.dice.between(0.0, wire.jitter_us) } else { 0.0 };
            let mut at = self.now + after_us + DELAY_US + jitter as u64;
            let backlog = &mut self.backlog[host.index()];
            if *backlog > at {
                at = *backlog;
                *backlog += PASS_US;
            }
            self.queue.push(at, Event::Datagram(datagram.clone()));
        }
    }

    /// An autopilot's call reaches its simulator.
    fn connect(&mut self, vehicle: Vehicle, connection: u32) {
        let (host, now) = (Host::Simulator(vehicle), self.now);
        let up = now >= self.trouble.start(host);
        let Some(pair) = self.pair(vehicle) else { return };
        if !up || pair.wired.connection.is_some() || pair.simulator.session.pace() == Pace::Done {
            return;
        }
        if vehicle == Vehicle::Ours {
            self.seen.note_flight(&self.ours.simulator.session);
        }
        let Some(pair) = self.pair(vehicle) else { return };
        pair.wired.connect(connection, now);
        (pair.anchor, pair.routed) = (None, false);
        pair.simulator.session.peer_connected();
        pair.simulator.waiting = now;
        pair.autopilot.session.simulator_connected();
        for host in [host, Host::Autopilot(vehicle)] {
            self.wake(host, now + WAKE_US);
        }
    }

    /// The other end of the connection between simulator and autopilot is gone.
    fn closed(&mut self, connection: u32, to: Host) {
        let now = self.now;
        let (Host::Simulator(vehicle) | Host::Autopilot(vehicle)) = to else { return };
        let Some(pair) = self.pair(vehicle) else { return };
        if pair.wired.connection.is_none_or(|c| c == connection) {
            pair.wired.connection = None;
            if to == Host::Simulator(vehicle) {
                pair.simulator.session.peer_left();
                pair.simulator.waiting = now;
                pair.routed = false;
            }
        }
        self.wake(to, now + WAKE_US);
    }

    /// The port of a process that a frame goes out by, and what becomes of it.
    pub(super) fn send_out(&mut self, out: Vec<(Option<Address>, Address, Vec<u8>)>, after_us: u64) {
        for (from, to, bytes) in out {
            match from {
                Some(from) => self.datagram_later(Datagram { to, from, bytes, forged: false }, after_us),
                None => {
                    let at = self.now + after_us + DELAY_US;
                    self.queue.push(at, Event::Reply { to, bytes: Some(bytes) });
                }
            }
        }
    }

    pub(super) fn shut(&mut self, closed: Vec<Address>) {
        for to in closed {
            self.queue.push(self.now + DELAY_US, Event::Reply { to, bytes: None });
        }
    }
}

/// Unix time by a host's clock.
fn unix(trouble: &Trouble, host: Host, now: u64) -> u64 {
    (EPOCH_US + now).saturating_add_signed(trouble.clocks_us[host.index()])
}
