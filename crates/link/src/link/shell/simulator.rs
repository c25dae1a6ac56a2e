//! The simulator on sockets: TCP 4560 + N for the autopilot, UDP 14600 + N for the parachute. Or on a serial
//! line to a board, which it gives the ports of an autopilot: UDP 18570 + N and 14580 + N.

use std::future::Future;
use std::net::SocketAddr;
use std::time::Duration;

use mavlink::MessageData as _;
use mavlink::dialects::common::{HEARTBEAT_DATA, HIL_ACTUATOR_CONTROLS_DATA};
use tokio::net::{TcpListener, TcpStream};

use super::super::autopilot::AUTOPILOT_COMPONENT;
use super::super::frame::Frame;
use super::super::hil::{HilSession, Missing, Pace};
use super::super::parachute::PARACHUTE_COMPONENT;
use super::super::session::{Link, Session as _, Transmit};
use super::super::streamer::{StreamerSession, StreamerState};
use super::busy_wait::BusyWait;
use super::clock::{Pacer, Since, Speed, WATCH_PERIOD};
use super::companion::Companion;
use super::connection::Connection;
use super::endpoint::listen;
use super::links::{Links, PEER_MEMORY};
use super::notice::{LineNotice, Notice, Observer, ShellError, What};
use super::ports::{Ports, loopback};
use super::serial::SerialUrl;
use super::stamp_store::SignWith;
use super::viewer::Viewer;
use crate::time::TimeUs;

/// Half a frame and then nothing for this long: the rest is not coming.
const HALF_FRAME_PATIENCE: Duration = Duration::from_secs(1);

/// An autopilot that has not come to rest in a step for so long never does, since some of it runs by the
/// clock: it is not waited for any more.
const REST_PATIENCE: Duration = Duration::from_secs(10);
/// How soon an autopilot that is still at work is looked at again.
const REST_PERIOD: Duration = Duration::from_micros(100);

/// A client that has not sent one frame for so long since it connected is no autopilot, and holds the place
/// of one.
const SILENT_PATIENCE: Duration = Duration::from_secs(10);
/// An autopilot that has been connected for so long without passing the parachute's frames on does not.
const ROUTER_PATIENCE: Duration = Duration::from_secs(3);
/// So often the end is reported once more, and after such a pause each time: while the autopilot, which may
/// be the way to those who listen, is still connected.
const REPEATS_OF_END: usize = 2;
const REPEAT_PERIOD: Duration = Duration::from_millis(10);
/// Purpose of the TCP port.
const PURPOSE: What = What::Borrowed("simulator, for the autopilot");

struct Shell<'a, O> {
    session: HilSession,
    /// Whether the autopilot is a board on a serial line, which is one of the parachute's links.
    has_board: bool,
    /// Whether the line was there at the last look.
    line_is_up: bool,
    /// Whether it has been said that the autopilot there is another system.
    stranger_told: bool,
    connection: Option<Connection>,
    connected: Since,
    parachute: Links,
    /// Whether the autopilot that is connected passes the parachute's frames on.
    routed: bool,
    viewer: Viewer,
    companion: Option<&'a mut Companion>,
    pacer: Pacer,
    /// While the autopilot's software is starting.
    starting: Pacer,
    waiting: Since,
    attendance: Attendance,
    /// Since simulated time went on last.
    stands: Since,
    /// Whether an autopilot that had been heard has left.
    left: bool,
    /// Whether the autopilot was at rest at the last look in this step.
    rested: bool,
    /// Whether it has been at work for longer than [`REST_PATIENCE`] on one step.
    never_rests: bool,
    /// Frames of one turn; kept for their room.
    sent: Vec<Transmit>,
    busy_wait: BusyWait,
    observer: &'a mut O,
}

/// How long a simulator stays without an autopilot: for ever, unless it is told otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attendance {
    /// End when the first autopilot that has been heard leaves, instead of starting over for the next.
    pub once: bool,
    /// End when simulated time has stood still for so long, in wall time, since somebody is missing.
    pub patience: Option<Duration>,
}

/// An autopilot's process, as known to the program that has started it.
pub trait Guest {
    /// The reason why the process is gone, if it is or is taken to be. `now` is simulated time [us], and
    /// `pace` says what the simulator waits for.
    fn gone(&mut self, now: TimeUs, pace: Pace) -> Option<String>;

    /// Whether it has done all that there was to do at the simulated time that it has been given.
    fn is_idle(&mut self) -> bool;
}

/// An autopilot of which nothing is known but its connection.
struct Stranger;

impl Guest for Stranger {
    fn gone(&mut self, _: TimeUs, _: Pace) -> Option<String> {
        None
    }

    fn is_idle(&mut self) -> bool {
        true
    }
}

/// A drop whose autopilot is a process of its own.
#[derive(Debug)]
pub struct HostedDrop {
    /// The simulator.
    pub simulator: HilSession,
    /// The streamer.
    pub streamer: StreamerSession,
    /// The reason why the autopilot is gone, if it left before the end.
    pub gone: Option<String>,
    /// Number of times that simulated time went on although the autopilot had not yet taken what it was sent.
    pub unfenced: u64,
}

/// Runs the simulator until the mission is over or `stop` completes. Before the first answer, and at
/// [`Speed::Factor`], it keeps the pace of the clock; an autopilot that leaves is waited for, and the drop
/// then starts over, unless `attendance` says otherwise. The parachute reports the end to everybody: through
/// an autopilot that passes its frames on, as a MAVLink router does, otherwise to the default remotes itself.
///
/// # Errors
/// [`ShellError`] when a port cannot be had.
pub async fn run_simulator<O: Observer>(
    session: HilSession,
    ports: &Ports,
    (speed, attendance): (Speed, Attendance),
    sign: Option<&SignWith>,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<HilSession, ShellError> {
    let server = listen(loopback(ports.simulator), &PURPOSE, observer).await?;
    let remotes = [ports.ground_station, ports.api];
    let mut shell = Shell::open(session, ports, speed, sign, &remotes, observer).await?;
    shell.attendance = attendance;
    shell.parachute.expect_router(shell.session.config().system_id);
    shell.run(Some(server), speed, &mut Stranger, stop).await;
    Ok(shell.session)
}

/// Runs the simulator with a streamer beside it for an autopilot that `start` starts and its guest watches,
/// until the mission is over, the streamer has given up, the autopilot is gone for good or `stop` completes.
/// It is started once the ports are ours, so that it cannot meet another simulator. Until the autopilot's
/// first HEARTBEAT, simulated time runs no faster than the clock: its software starts in wall time. The
/// streamer's clock must be the caller's.
///
/// # Errors
/// [`ShellError`] when a port cannot be had; what `start` fails with.
pub async fn run_hosted_drop<O: Observer, G: Guest, E: From<ShellError>>(
    (session, streamer): (HilSession, StreamerSession),
    ports: &Ports,
    speed: Speed,
    start: impl FnOnce() -> Result<G, E>,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<(HostedDrop, G), E> {
    let server = listen(loopback(ports.simulator), &PURPOSE, observer).await?;
    let mut companion = Companion::open(streamer, ports, true, observer).await?;
    let mut shell = Shell::open(session, ports, speed, None, &[ports.ground_station], observer).await?;
    shell.companion = Some(&mut companion);
    let mut guest = start()?;
    let gone = shell.run(Some(server), speed, &mut guest, stop).await;
    let simulator = shell.session;
    Ok((HostedDrop { simulator, unfenced: companion.unfenced, streamer: companion.session, gone }, guest))
}

/// Runs the simulator for a board on a serial line, in real time, with a streamer beside it if there is one,
/// until the mission is over, the streamer has given up or `stop` completes; `factor` is the pace of
/// simulated time where the board's clock is on another scale. A line that is lost is waited for, and the
/// drop then starts over, unless `attendance` says otherwise. The session must be [in real
/// time](HilSession::is_in_real_time), and the streamer's clock the caller's.
///
/// # Errors
/// [`ShellError`] when the line or a port cannot be had.
pub async fn run_board<O: Observer>(
    (session, streamer): (HilSession, Option<StreamerSession>),
    ports: &Ports,
    line: &SerialUrl,
    (factor, attendance): (f64, Attendance),
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<(HilSession, Option<StreamerSession>), ShellError> {
    let speed = Speed::Factor(factor);
    let links = Links::of_board(session.config().system_id, ports, line, observer).await?;
    let mut companion = match streamer {
        Some(streamer) => Some(Companion::open(streamer, ports, false, observer).await?),
        None => None,
    };
    let mut shell = Shell::new(session, links, ports, speed, observer);
    shell.has_board = true;
    shell.starting = Pacer::new(speed);
    shell.attendance = attendance;
    shell.companion = companion.as_mut();
    shell.run(None, speed, &mut Stranger, stop).await;
    let slips = shell.pacer.slips + shell.starting.slips;
    if slips > 0 {
        shell.observer.notice(Notice::NotInTime(slips));
    }
    let session = shell.session;
    Ok((session, companion.map(|companion| companion.session)))
}

/// The next connection; for ever without a server. Safe to cancel.
async fn accept(server: Option<&TcpListener>) -> (TcpStream, SocketAddr) {
    let Some(server) = server else { return std::future::pending().await };
    loop {
        // A connection that is gone before it is accepted is nobody's loss.
        if let Ok(accepted) = server.accept().await {
            return accepted;
        }
        tokio::task::yield_now().await;
    }
}

impl<'a, O: Observer> Shell<'a, O> {
    /// Without autopilot and companion. The parachute speaks to the loopback ports `remotes` unasked.
    async fn open(
        session: HilSession,
        ports: &Ports,
        speed: Speed,
        sign: Option<&SignWith>,
        remotes: &[u16],
        observer: &'a mut O,
    ) -> Result<Self, ShellError> {
        let system_id = session.config().system_id;
        let mut parachute = Links::new((system_id, PARACHUTE_COMPONENT), PEER_MEMORY, false, sign)?;
        parachute.bind_udp(Link::Parachute, ports.parachute, "parachute", remotes, observer).await?;
        Ok(Self::new(session, parachute, ports, speed, observer))
    }

    fn new(session: HilSession, parachute: Links, ports: &Ports, speed: Speed, observer: &'a mut O) -> Self {
        let starting = match speed {
            Speed::Factor(factor) => Speed::Factor(factor.min(1.0)),
            Speed::Max => Speed::Factor(1.0),
        };
        let viewer = Viewer::open(session.config().system_id, ports, speed);
        Self {
            session,
            has_board: false,
            line_is_up: false,
            stranger_told: false,
            connection: None,
            connected: Since::now(),
            parachute,
            routed: false,
            viewer,
            companion: None,
            pacer: Pacer::new(speed),
            starting: Pacer::new(starting),
            waiting: Since::now(),
            attendance: Attendance::default(),
            stands: Since::now(),
            left: false,
            rested: false,
            never_rests: false,
            sent: Vec::new(),
            busy_wait: BusyWait::new(speed),
            observer,
        }
    }

    /// Runs to the end; returns the reason why the guest is gone, if that ended it: what the guest says.
    async fn run(
        &mut self,
        server: Option<TcpListener>,
        speed: Speed,
        guest: &mut impl Guest,
        stop: impl Future<Output = ()>,
    ) -> Option<String> {
        let mut gone = None;
        let mut stop = std::pin::pin!(stop);
        let mut looked = Since::now();
        while self.session.pace() != Pace::Done {
            let pace = self.session.pace();
            let hurries = speed == Speed::Max && pace == Pace::Ready && !self.starts();
            let pause = match self.session.next_wake() {
                Some(_) if self.companion.as_ref().is_some_and(|c| c.fence.is_some()) => WATCH_PERIOD,
                Some(_) if self.settles() && !self.rests(guest) => REST_PERIOD,
                Some(_) if hurries => Duration::ZERO,
                Some(at) => self.until(at).min(WATCH_PERIOD),
                None => WATCH_PERIOD,
            };
            let mut accepted = None;
            let answered = pace == Pace::AwaitingControls && self.busy_wait.look(self.connection.as_mut());
            if pause.is_zero() {
                self.step().await;
            } else if !answered || self.busy_wait.others_are_due() {
                // Whoever always has something to be read keeps the runtime from nothing else.
                tokio::task::yield_now().await;
                tokio::select! {
                    biased;
                    () = &mut stop => {
                        self.session.stop();
                        break;
                    }
                    new = accept(server.as_ref()) => accepted = Some(new),
                    () = Connection::ready(self.connection.as_ref()) => {}
                    () = self.parachute.readable() => {}
                    () = Self::heard(&mut self.companion) => {}
                    () = tokio::task::yield_now(), if answered => {}
                    () = tokio::time::sleep(pause) => {}
                }
            }
            if looked.elapsed() >= WATCH_PERIOD {
                looked = Since::now();
                gone = guest.gone(self.session.now(), self.session.pace());
            }
            self.receive();
            if let Some((stream, peer)) = accepted {
                self.admit(stream, peer);
            }
            self.look_at_silence();
            if let Some(reason) = self.unattended() {
                self.observer.notice(Notice::Unattended(reason));
                self.session.stop();
                break;
            }
            self.act();
            self.send();
            if gone.is_some() || self.streamer_failed() {
                self.session.stop();
            }
        }
        self.act();
        self.send();
        self.repeat_end().await;
        self.parachute.finish(self.observer);
        if let Some(companion) = &mut self.companion {
            companion.links.finish(self.observer);
        }
        // First, so that an autopilot whose connection ends does not find it open.
        drop(server);
        if let Some(connection) = self.connection.take() {
            connection.close().await;
        }
        gone
    }

    /// The last word is the one that nobody misses who has missed it: it is said more than once.
    async fn repeat_end(&mut self) {
        for _ in 0..REPEATS_OF_END {
            if self.connection.is_some() || self.line_is_up {
                tokio::time::sleep(REPEAT_PERIOD).await;
                self.session.repeat_end();
                self.send();
            }
        }
    }

    /// Waits for something from the companion's socket; for ever without one.
    async fn heard(companion: &mut Option<&mut Companion>) {
        match companion {
            Some(companion) => companion.links.readable().await,
            None => std::future::pending().await,
        }
    }

    fn starts(&self) -> bool {
        self.session.companion_starts() || self.companion.as_ref().is_some_and(|c| c.vehicle_starts())
    }

    /// Whether the autopilot is given the time to come to rest before each step: as long as what it is
    /// sent next depends on what it says.
    fn settles(&self) -> bool {
        let listens = self.companion.as_ref().is_some_and(|c| c.session.listens());
        listens && !self.never_rests && !self.has_board
    }

    /// Whether the autopilot is at rest and was at the last look: what it had sent is received by now.
    fn rests(&mut self, guest: &mut impl Guest) -> bool {
        self.never_rests = self.waiting.elapsed() >= REST_PATIENCE;
        let idle = guest.is_idle();
        std::mem::replace(&mut self.rested, idle) && idle
    }

    fn streamer_failed(&self) -> bool {
        self.companion.as_ref().is_some_and(|c| c.session.state() == StreamerState::Failed)
    }

    /// The companion's turn, once the autopilot has answered; until then it only reports what it waits for.
    fn act(&mut self) {
        let Some(companion) = &mut self.companion else { return };
        match self.session.pace() {
            Pace::Free | Pace::Ready | Pace::Done => companion.act(&mut self.session, self.observer),
            Pace::NoPeer | Pace::AwaitingControls => companion.report(self.observer),
        }
    }

    fn until(&mut self, at: TimeUs) -> Duration {
        if self.starts() { self.starting.until(at) } else { self.pacer.until(at) }
    }

    async fn step(&mut self) {
        let before = self.session.now();
        if let Some(at) = self.session.next_wake() {
            self.session.handle_time(at);
            self.observer.flown(self.session.run().log());
        }
        self.waiting = Since::now();
        // A board's first answer is waited for without standing still.
        if self.session.now() > before {
            self.stands = Since::now();
        }
        self.rested = false;
        self.send();
        // Where nothing is waited for, the sockets must be looked at all the same.
        if self.session.pace() != Pace::AwaitingControls {
            tokio::task::yield_now().await;
        }
    }

    fn receive(&mut self) {
        let Self { session, connection, parachute, routed, companion, observer, .. } = self;
        let (has_board, mut stranger) = (self.has_board, None);
        let router = (session.config().system_id, AUTOPILOT_COMPONENT);
        let mut ended = None;
        if let Some(connection) = connection {
            let result = connection.receive(*observer, |observer, frame| {
                observer.frame(session.now(), Link::Simulator, frame.bytes());
                session.handle_input(Link::Simulator, frame);
            });
            ended = result.err();
        }
        parachute.receive(*observer, |observer, link, frame: &Frame| {
            if has_board {
                stranger = stranger.or(take_of_board(session, observer, (link, frame)));
                return;
            }
            *routed |= (frame.system_id, frame.component_id) == router;
            observer.frame(session.now(), link, frame.bytes());
            session.handle_input(link, frame);
        });
        if let Some(companion) = companion {
            companion.receive(session, *observer);
        }
        if let Some(reason) = ended {
            self.disconnect(reason);
        }
        if let Some(found) = stranger.filter(|_| !std::mem::replace(&mut self.stranger_told, true)) {
            let expected = self.session.config().system_id;
            self.tell_of_line(LineNotice::OtherSystem { found, expected });
        }
        let is_up = self.parachute.line_is_up();
        match (std::mem::replace(&mut self.line_is_up, is_up), is_up) {
            (false, true) => self.meet(),
            (true, false) => self.part(),
            _ => {}
        }
    }

    fn tell_of_line(&mut self, notice: LineNotice) {
        self.observer.notice(Notice::Line(self.parachute.line_name().to_owned(), notice));
    }

    fn admit(&mut self, stream: TcpStream, peer: SocketAddr) {
        if self.connection.is_some() {
            self.observer.notice(Notice::TurnedAway(peer));
            return;
        }
        self.observer.notice(Notice::Connected(peer, "autopilot".into()));
        self.connection = Some(Connection::new(stream, peer, "simulator link"));
        self.meet();
    }

    /// An autopilot is there, on its connection or its line.
    fn meet(&mut self) {
        self.session.peer_connected();
        self.connected = Since::now();
        if let Some(companion) = &mut self.companion {
            companion.restart();
        }
        self.pacer.reset();
        self.starting.reset();
        self.waiting = Since::now();
    }

    fn disconnect(&mut self, reason: String) {
        if let Some(connection) = self.connection.take() {
            self.observer.notice(Notice::Disconnected(connection.peer, reason));
            self.part();
        }
    }

    /// The autopilot is gone, with its connection or its line.
    fn part(&mut self) {
        self.left |= self.session.peer_is_heard();
        self.session.peer_left();
        self.routed = false;
        self.waiting = Since::now();
    }

    fn look_at_silence(&mut self) {
        let waited = self.waiting.elapsed();
        if self.session.missing().is_none() || waited < WATCH_PERIOD {
            return;
        }
        let Self { session, connection, observer, .. } = self;
        if let Some(connection) = connection
            && waited >= HALF_FRAME_PATIENCE
        {
            connection.give_up_half_frames(*observer, |observer, frame| {
                observer.frame(session.now(), Link::Simulator, frame.bytes());
                session.handle_input(Link::Simulator, frame);
            });
        }
        session.handle_silence(waited);
        // An autopilot that was started for this simulator is watched by who has started it.
        let silent = self.session.missing() == Some(Missing::AnyFrame) && waited >= SILENT_PATIENCE;
        if self.companion.is_none() && silent {
            self.disconnect(format!("not one frame in {} s", SILENT_PATIENCE.as_secs()));
        }
    }

    /// The reason why nobody is waited for any longer, if so.
    fn unattended(&self) -> Option<String> {
        let Attendance { once, patience } = self.attendance;
        if once && self.left {
            return Some("the autopilot has left".to_owned());
        }
        let patience = patience
            .filter(|patience| self.session.missing().is_some() && self.stands.elapsed() >= *patience)?;
        Some(format!("simulated time has stood still for {} s", patience.as_secs_f64()))
    }

    /// Whether the parachute speaks to default remotes itself: nobody else brings them its frames, and a
    /// vehicle was to be met there before it.
    fn speaks_unasked(&self) -> bool {
        if self.has_board {
            return self.session.peer_is_heard();
        }
        let settled = match self.companion {
            Some(_) => self.session.peer_is_heard(),
            None => self.connected.elapsed() >= ROUTER_PATIENCE,
        };
        self.connection.is_some() && !self.routed && settled
    }

    fn send(&mut self) {
        while let Some(event) = self.session.poll_event() {
            self.observer.notice(Notice::Simulator(event));
        }
        let now = self.session.now();
        while let Some(sent) = self.session.poll_output() {
            if let (Link::Simulator, Some(connection)) = (sent.link, &mut self.connection) {
                connection.queue(&sent.bytes);
            }
            self.sent.push(sent);
        }
        let flushed = match &mut self.connection {
            Some(connection) => connection.flush(),
            None => Ok(()),
        };
        if self.sent.iter().any(|sent| sent.link != Link::Simulator) {
            let speaks_unasked = self.speaks_unasked();
            self.parachute.speak_unasked(speaks_unasked);
        }
        // The autopilot is at work; the rest is done meanwhile.
        let mut frames = std::mem::take(&mut self.sent);
        for sent in frames.drain(..) {
            self.observer.frame(now, sent.link, &sent.bytes);
            self.viewer.show(&sent);
            if self.has_board {
                self.send_with_board(&sent);
            } else if sent.link != Link::Simulator {
                self.parachute.send(&sent);
            }
            if let Some(companion) = &mut self.companion
                && companion.is_inside
                && sent.link != Link::Simulator
            {
                companion.take_from_parachute(&sent);
            }
        }
        self.sent = frames;
        if self.has_board {
            self.parachute.flush();
        }
        if let Err(reason) = flushed {
            self.disconnect(reason);
        }
    }

    /// Sends a frame to the board, and what is the parachute's to all others too.
    fn send_with_board(&mut self, sent: &Transmit) {
        if sent.link == Link::Simulator {
            // The board may not speak before it has heard somebody.
            self.parachute.speak_unasked(true);
            return self.parachute.queue(sent);
        }
        let speaks_unasked = self.speaks_unasked();
        self.parachute.speak_unasked(speaks_unasked);
        for link in [Link::Simulator, Link::GroundStation, Link::Api] {
            self.parachute.queue(&Transmit { link, ..sent.clone() });
        }
    }
}

/// Takes what has come by the links of a board: what its autopilot says is the simulator's business, what
/// others say the parachute's. Returns the system of an autopilot there that is not ours.
fn take_of_board(
    session: &mut HilSession,
    observer: &mut impl Observer,
    (link, frame): (Link, &Frame),
) -> Option<u8> {
    let ours = (session.config().system_id, AUTOPILOT_COMPONENT);
    let from = (frame.system_id, frame.component_id);
    let is_controls = frame.message_id == HIL_ACTUATOR_CONTROLS_DATA::ID;
    let recorded = if is_controls { Link::Simulator } else { Link::Api };
    observer.frame(session.now(), recorded, frame.bytes());
    let is_line = link == Link::Simulator;
    let taken = if is_line && from == ours { Link::Simulator } else { Link::Parachute };
    session.handle_input(taken, frame);
    let shows_itself = is_line && from.1 == ours.1 && frame.message_id == HEARTBEAT_DATA::ID;
    (shows_itself && from != ours).then_some(from.0)
}
