//! A streamer beside the simulator, for an autopilot that is a process of its own.
//!
//! The autopilot's link for companions lives in wall time: a frame that has been handed to the socket is with
//! the autopilot some time later, and a simulator that does not wait would be steps ahead by then. So each
//! batch of frames is followed by a TIMESYNC, which the autopilot answers in the order of arrival: once the
//! answer is there all before it has been taken, and the next HIL_SENSOR may go. Setpoints are thus in force
//! at the same simulated time at any speed.

use std::time::Duration;

use mavlink::dialects::common::{MavMessage, TIMESYNC_DATA};

use super::super::decoder::Decoder;
use super::super::encoder::Encoder;
use super::super::frame::Frame;
use super::super::hil::HilSession;
use super::super::session::{Link, Session as _, Transmit};
use super::super::streamer::{STREAMER_COMPONENT, STREAMER_SYSTEM, StreamerSession, StreamerState};
use super::clock::Since;
use super::event_texts::read_fetched;
use super::links::Links;
use super::notice::{Notice, Observer, ShellError};
use super::ports::Ports;
use crate::time::TimeUs;

/// An autopilot that has not answered a TIMESYNC for so long will not; time goes on without.
const FENCE_PATIENCE: Duration = Duration::from_secs(1);
/// An autopilot that has not answered its first TIMESYNC for so long never will.
const START_PATIENCE: Duration = Duration::from_secs(10);
/// The autopilot may be silent while simulated time stands still.
const PEER_MEMORY: Duration = Duration::from_secs(600);

/// A streamer with its socket and the fence that keeps simulated time behind the autopilot.
#[derive(Debug)]
pub(super) struct Companion {
    initial: StreamerSession,
    pub(super) session: StreamerSession,
    pub(super) links: Links,
    /// Frames of its own go out under the streamer's address.
    encoder: Encoder,
    decoder: Decoder,
    /// Since when the last TIMESYNC has not been answered, if simulated time waits for it.
    pub(super) fence: Option<Since>,
    /// Stamp of the last TIMESYNC.
    stamp: i64,
    /// Whether simulator and parachute are spoken to in memory, and simulated time waits for the autopilot;
    /// otherwise it is behind the ports of a board, as any other is.
    pub(super) is_inside: bool,
    /// The autopilot has answered a TIMESYNC. Before, nothing waits for one: its receiver may be asleep in
    /// simulated time.
    answers: bool,
    /// When it was sent the first one.
    asked: Option<Since>,
    /// Fences that were given up.
    pub(super) unfenced: u64,
    ticked: Option<TimeUs>,
    since: Since,
}

impl Companion {
    pub(super) async fn open<O: Observer>(
        session: StreamerSession,
        ports: &Ports,
        is_inside: bool,
        observer: &mut O,
    ) -> Result<Self, ShellError> {
        let own = (STREAMER_SYSTEM, STREAMER_COMPONENT);
        let mut links = Links::new(own, PEER_MEMORY, false, None)?;
        let to = [ports.autopilot_api];
        links.bind_udp(Link::Api, ports.api, "streamer, for the autopilot", &to, observer).await?;
        Ok(Self {
            initial: session.clone(),
            session,
            links,
            encoder: Encoder::new(STREAMER_SYSTEM, STREAMER_COMPONENT),
            decoder: Decoder::new(),
            fence: None,
            is_inside,
            stamp: 0,
            answers: false,
            asked: None,
            unfenced: 0,
            ticked: None,
            since: Since::now(),
        })
    }

    /// Another autopilot, another flight.
    pub(super) fn restart(&mut self) {
        self.session = self.initial.clone();
        (self.fence, self.answers, self.asked, self.ticked) = (None, false, None, None);
        self.since = Since::now();
    }

    /// Whether the vehicle's software is still starting, in wall time: it has not been heard, or has not
    /// listened yet.
    pub(super) fn vehicle_starts(&self) -> bool {
        let deaf = !self.answers && self.asked.as_ref().is_some_and(|since| since.elapsed() < START_PATIENCE);
        deaf || self.is_unheard()
    }

    fn is_unheard(&self) -> bool {
        self.session.state() == StreamerState::WaitingForVehicle
    }

    /// Takes what has come. The simulator gets the autopilot's HEARTBEAT this way, which does not come on its
    /// own link.
    pub(super) fn receive<O: Observer>(&mut self, simulator: &mut HilSession, observer: &mut O) {
        let now = simulator.now();
        let Self { session, links, fence, stamp, answers, is_inside, .. } = self;
        let is_empty = links.receive(observer, |observer, link, frame: &Frame| {
            if let Some(MavMessage::TIMESYNC(m)) = frame.known() {
                *answers |= m.tc1 != 0 && (1..=*stamp).contains(&m.ts1);
                if m.ts1 == *stamp && m.tc1 != 0 {
                    *fence = None;
                }
                return;
            }
            session.handle_input(link, frame);
            if !*is_inside {
                return;
            }
            observer.frame(now, link, frame.bytes());
            if matches!(frame.known(), Some(MavMessage::HEARTBEAT(_))) {
                simulator.handle_input(Link::Parachute, frame);
            }
        });
        if self.fence.is_some_and(|since| since.elapsed() >= FENCE_PATIENCE) {
            self.fence = None;
            self.unfenced += 1;
        }
        let taken = self.answers && self.fence.is_none();
        if is_empty {
            self.session.handle_empty(self.since.elapsed(), taken);
        }
        if self.is_unheard() {
            self.session.handle_silence(self.since.elapsed());
        }
    }

    /// Takes a frame of the parachute, without a socket. Its HEARTBEAT goes on to the autopilot, as by the
    /// router of a vehicle: PX4 may ask for one before it arms (COM_PARACHUTE).
    pub(super) fn take_from_parachute(&mut self, sent: &Transmit) {
        let Self { session, decoder, .. } = self;
        let mut is_heartbeat = false;
        decoder.datagram(&sent.bytes, |frame| {
            is_heartbeat |= matches!(frame.known(), Some(MavMessage::HEARTBEAT(_)));
            session.handle_input(Link::Parachute, &frame);
        });
        if is_heartbeat && !self.is_unheard() {
            self.links.send(&Transmit::to_all(Link::Api, sent.bytes.clone()));
            self.put_fence();
        }
    }

    /// Lets the session act at the simulator's time, once for each, and sends what it wants sent: to the
    /// autopilot and, without a socket, to the parachute.
    pub(super) fn act<O: Observer>(&mut self, simulator: &mut HilSession, observer: &mut O) {
        let now = simulator.now();
        if self.ticked != Some(now) {
            self.ticked = Some(now);
            self.session.handle_time(now);
        }
        read_fetched(&mut self.session);
        self.report(observer);
        let mut any = false;
        while let Some(sent) = self.session.poll_output() {
            any = true;
            self.links.send(&sent);
            if !self.is_inside {
                continue;
            }
            observer.frame(now, sent.link, &sent.bytes);
            self.decoder.datagram(&sent.bytes, |frame| simulator.handle_input(Link::Parachute, &frame));
        }
        if any {
            self.put_fence();
        }
        simulator.note_setpoint(self.session.velocity_setpoint_ned());
    }

    /// Passes on what the session reports.
    pub(super) fn report<O: Observer>(&mut self, observer: &mut O) {
        while let Some(event) = self.session.poll_event() {
            observer.notice(Notice::Streamer(event));
        }
    }

    fn put_fence(&mut self) {
        if !self.is_inside {
            return;
        }
        self.stamp += 1;
        self.asked.get_or_insert_with(Since::now);
        let ping = TIMESYNC_DATA { tc1: 0, ts1: self.stamp, ..TIMESYNC_DATA::default() };
        let bytes = self.encoder.encode(&MavMessage::TIMESYNC(ping));
        self.links.send(&Transmit::to_all(Link::Api, bytes));
        self.fence = self.answers.then(Since::now);
    }
}
