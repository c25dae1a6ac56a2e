//! A host's turn: what the shell's loops do with sockets, once. Turns come when something has arrived or is
//! due.

use std::time::Duration;

use mavlink::dialects::common::{MavCmd, MavMessage, MavModeFlag};
use samara::link::streamer::StreamerState;
use samara::link::{Link, LogEntry, Pace, Session as _, StreamerSession, Transmit};

use super::process::Received;
use super::wire::{Event, Host, Vehicle};
use super::world::{DELAY_US, Pair, World};

/// The shell's.
const WATCH_US: u64 = 100_000;
const RETRY_US: u64 = 250_000;
const ROUTER_PATIENCE_US: u64 = 3_000_000;
/// Most datagrams that somebody who listens has recorded.
const MOST_RECORDED: usize = 3_000;
/// From the arrival of something to the turn of the host [us].
pub(super) const WAKE_US: u64 = 5;
/// Two ends of the connection between simulator and autopilot.
const SIMULATORS: usize = 0;
const AUTOPILOTS: usize = 1;

/// Whether the streamer has met no vehicle so far.
pub(super) fn waits(streamer: &StreamerSession) -> bool {
    streamer.state() == StreamerState::WaitingForVehicle
}

impl World<'_> {
    pub(super) fn turn(&mut self, host: Host) {
        match host {
            Host::Simulator(vehicle) => self.turn_of_simulator(vehicle),
            Host::Autopilot(vehicle) => self.turn_of_autopilot(vehicle),
            Host::Streamer => self.turn_of_streamer(),
            Host::Operator => self.turn_of_operator(),
        }
    }

    /// Notes what came of a turn at the sockets, and keeps the stamps that are to be kept.
    fn note(&mut self, host: Host, received: Received, stamps: Option<String>) -> u64 {
        if self.trouble.signed {
            self.seen.strangers_heard += received.forged;
            let more = self.recorded.len() + received.let_in.len();
            self.recorded.drain(..more.saturating_sub(MOST_RECORDED).min(self.recorded.len()));
            self.recorded.extend(received.let_in);
        }
        self.seen.other_clock |= received.other_clock;
        if stamps.is_some() {
            self.stamps[host.index()] = stamps;
        }
        self.shut(received.closed);
        self.occupy(host, self.now + received.took_us);
        received.took_us
    }

    fn turn_of_simulator(&mut self, vehicle: Vehicle) {
        let host = Host::Simulator(vehicle);
        let (now, unix, speed) = (self.now, self.unix(host), self.trouble.speed);
        let Some(Pair { simulator, wired, anchor, routed, .. }) = self.pair(vehicle) else { return };
        let paced = simulator.session.pace();
        wired.receive(SIMULATORS, |frame| simulator.session.handle_input(Link::Simulator, frame));
        let received = simulator.receive(unix, |session, link, _, frame| {
            *routed |= (frame.system_id, frame.component_id) == (1, 1);
            session.handle_input(link, frame);
        });
        let session = &mut simulator.session;
        if paced == Pace::NoPeer && session.pace() != Pace::NoPeer {
            simulator.waiting = now;
        }
        let waited = now - simulator.waiting;
        if session.missing().is_some() && waited >= WATCH_US {
            session.handle_silence(Duration::from_micros(waited));
        }
        let mut next = now + WATCH_US;
        if let Some(at) = session.next_wake() {
            let (from, start) = *anchor.get_or_insert((now, at));
            let due = from + ((at.saturating_sub(start)) as f64 / speed) as u64;
            let late = (100_000.0 / speed).max(5_000.0) as u64;
            if now > due + late {
                *anchor = Some((now, at));
            }
            if now >= due {
                session.handle_time(at);
                simulator.waiting = now;
                next = now + WAKE_US;
            } else {
                next = next.min(due);
            }
        }
        if !received.is_empty {
            next = now + WAKE_US;
        }
        let connection = wired.connection;
        let settled = connection.is_some() && now >= wired.since + ROUTER_PATIENCE_US;
        simulator.hub.speak_unasked(settled && !*routed);
        let events: Vec<_> = std::iter::from_fn(|| session.poll_event()).collect();
        let sent: Vec<Transmit> = std::iter::from_fn(|| session.poll_output()).collect();
        let (by_wire, by_socket): (Vec<_>, Vec<_>) =
            sent.into_iter().partition(|sent| sent.link == Link::Simulator);
        let out: Vec<_> = by_socket.iter().flat_map(|sent| simulator.send(unix, sent)).collect();
        let is_done = simulator.session.pace() == Pace::Done;
        let stamps = simulator.hub.poll_stamps().map(|stamps| stamps.to_text());
        let closes = if is_done { wired.connection.take() } else { None };
        let took_us = self.note(host, received, stamps);
        if vehicle == Vehicle::Ours {
            for event in events {
                self.seen.reports[0] += 1;
                self.tell(&format!("simulator {event}"));
            }
        }
        for sent in by_wire {
            if let Some(connection) = connection {
                self.bytes(vehicle, connection, Host::Autopilot(vehicle), sent.bytes);
            }
        }
        self.send_out(out, took_us);
        self.look();
        if let Some(connection) = closes {
            let to = Host::Autopilot(vehicle);
            self.queue.push(now + DELAY_US, Event::Closed { connection, to });
        }
        if !is_done {
            self.wake(host, next);
        }
    }

    fn turn_of_autopilot(&mut self, vehicle: Vehicle) {
        let host = Host::Autopilot(vehicle);
        let (now, unix, number) = (self.now, self.unix(host), self.connections + 1);
        let Some(Pair { autopilot, wired, .. }) = self.pair(vehicle) else { return };
        let dials = wired.connection.is_none() && wired.dialled.is_none_or(|at| now >= at + RETRY_US);
        if dials {
            wired.dialled = Some(now);
        }
        wired.receive(AUTOPILOTS, |frame| autopilot.session.handle_input(Link::Simulator, frame));
        let received = autopilot.receive(unix, |session, link, _, frame| session.handle_input(link, frame));
        autopilot.session.handle_time(now - autopilot.started);
        let log = std::iter::from_fn(|| autopilot.session.poll_log());
        let begun = log.filter(|entry| matches!(entry, LogEntry::Begin(..))).count();
        let mut out = autopilot.forwards();
        let mut by_wire = Vec::new();
        while let Some(sent) = autopilot.session.poll_output() {
            if sent.link == Link::Simulator {
                by_wire.push(sent.bytes);
                continue;
            }
            out.extend(autopilot.send(unix, &sent));
            // By this the parachute knows its router.
            if sent.link == Link::Api && sent.bytes[7..10] == [0; 3] {
                out.extend(autopilot.send(unix, &Transmit::to_all(Link::Parachute, sent.bytes)));
            }
        }
        let (connection, is_connected) = (wired.connection, wired.connection.is_some());
        let stamps = autopilot.hub.poll_stamps().map(|stamps| stamps.to_text());
        let next = autopilot.session.next_wake().map(|at| at + autopilot.started);
        let next = next.unwrap_or(now + WATCH_US).max(now + WAKE_US);
        let next = if is_connected { next } else { next.min(wired.dialled.unwrap_or(now) + RETRY_US) };
        let (is_empty, connections) = (received.is_empty, autopilot.connections.len());
        if dials {
            self.connections = number;
            let connect = Event::Connect { vehicle, connection: number };
            self.queue.push(now + DELAY_US, connect);
        }
        let took_us = self.note(host, received, stamps);
        if vehicle == Vehicle::Ours {
            self.seen.flights_logged += begun;
            self.seen.most_sent = self.seen.most_sent.max(out.len());
            self.seen.most_connections = self.seen.most_connections.max(connections);
        }
        for bytes in by_wire {
            if let Some(connection) = connection {
                self.bytes(vehicle, connection, Host::Simulator(vehicle), bytes);
            }
        }
        self.send_out(out, took_us);
        self.look();
        self.wake(host, if is_empty { next } else { now + WAKE_US });
    }

    fn turn_of_streamer(&mut self) {
        let host = Host::Streamer;
        let (now, unix) = (self.now, self.unix(host));
        let Self { streamer, heard_armed, met, .. } = self;
        if streamer.session.is_over() {
            return;
        }
        let (before, waited) = (streamer.session.now(), waits(&streamer.session));
        let received = streamer.receive(unix, |session, link, from, frame| {
            if let Some(Host::Autopilot(vehicle)) = Host::of(from)
                && frame.component_id == 1
                && let Some(MavMessage::HEARTBEAT(m)) = frame.known()
            {
                if waits(session) {
                    *met = Some(vehicle);
                }
                if vehicle == Vehicle::Ours {
                    *heard_armed = m.base_mode.contains(MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED);
                }
            }
            session.handle_input(link, frame);
        });
        let is_empty = received.is_empty;
        if is_empty {
            streamer.session.handle_empty(Duration::from_micros(now - streamer.started), false);
        }
        let since = streamer.session.now();
        if since == before {
            streamer.session.handle_silence(Duration::from_micros(now - streamer.waiting));
        } else {
            streamer.waiting = now;
        }
        if since < before || waited && !waits(&streamer.session) {
            self.seen.note_streamers_beginning();
        }
        let events: Vec<_> = std::iter::from_fn(|| streamer.session.poll_event()).collect();
        let mut out = Vec::new();
        while let Some(sent) = streamer.session.poll_output() {
            let gripper = (MavCmd::MAV_CMD_DO_GRIPPER as u16).to_le_bytes();
            let is_command = sent.bytes[7..10] == [76, 0, 0] && sent.bytes.len() > 40;
            if is_command && sent.bytes[38..40] == gripper && !*heard_armed {
                self.seen.blind_releases += 1;
            }
            out.extend(streamer.send(unix, &sent));
        }
        let stamps = streamer.hub.poll_stamps().map(|stamps| stamps.to_text());
        let took_us = self.note(host, received, stamps);
        for event in events {
            self.seen.reports[1] += 1;
            self.tell(&format!("streamer {event}"));
        }
        self.send_out(out, took_us);
        self.wake(host, now + if is_empty { WATCH_US } else { WAKE_US });
    }

    fn turn_of_operator(&mut self) {
        let (now, unix) = (self.now, self.unix(Host::Operator));
        let (silent_us, granted) = self.operator.receive(now, unix);
        self.seen.note_unserved(silent_us);
        self.seen.wishes[1] += usize::from(granted);
        if let Some(bytes) = self.operator.beat(now, unix) {
            self.by_operator(bytes);
        }
        let next = self.operator.next_wake();
        self.wake(Host::Operator, next.max(now + WAKE_US));
    }

    /// The truth, and what grows.
    fn look(&mut self) {
        let pair = &self.ours;
        let served = [
            pair.simulator.hub.served(self.unix(Host::Simulator(Vehicle::Ours))),
            pair.autopilot.hub.served(self.unix(Host::Autopilot(Vehicle::Ours))),
        ];
        self.seen.most_served = served.into_iter().fold(self.seen.most_served, usize::max);
        self.seen.look(&pair.simulator.session, &pair.autopilot.session);
        let other = self.other.as_ref();
        let is_armed = other.is_some_and(|pair| pair.autopilot.session.autopilot().is_armed());
        self.seen.other_armed |= is_armed && !self.other_is_armed && self.met == Some(Vehicle::Ours);
        self.other_is_armed = is_armed;
    }
}
