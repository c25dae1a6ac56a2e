//! The reference autopilot on sockets: TCP client of the simulator, UDP 18570 + N for ground stations, 14580
//! + N for companions; and the way from these to the parachute.

use std::collections::VecDeque;
use std::future::Future;
use std::net::SocketAddr;
use std::time::Duration;

use mavlink::MessageData as _;
use mavlink::dialects::common::{MavMessage, STATUSTEXT_DATA};
use tokio::net::TcpStream;

use super::super::autopilot::AutopilotSession;
use super::super::decoder::Decoder;
use super::super::frame::{Frame, message_id};
use super::super::session::{Link, Session as _, Transmit};
use super::super::statustext::TextReader;
use super::clock::{Since, WATCH_PERIOD};
use super::connection::Connection;
use super::links::{Links, Wiring};
use super::notice::{Notice, Observer, ShellError};
use super::ports::{Ports, loopback};
use crate::time::TimeUs;

/// From one try to connect to the next.
const RETRY: Duration = Duration::from_millis(250);

/// What connects to a loopback port takes no longer.
const DECIDED: Duration = Duration::from_millis(50);

/// For so long after the simulator has left, what the parachute has said last is passed on: the end of one
/// socket may be seen before what came earlier by another.
const LAST_WORDS: Duration = Duration::from_millis(100);

/// What the autopilot does when the simulator has left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterSimulator {
    /// It waits for the next one.
    Wait,
    /// It returns.
    Return,
}

struct Shell<'a, O> {
    session: AutopilotSession,
    connection: Option<Connection>,
    links: Links,
    started: Since,
    own_words: Decoder,
    texts: TextReader,
    /// Recorded, with the time it was made at, and to be sent.
    outbox: VecDeque<(TimeUs, Transmit)>,
    observer: &'a mut O,
}

/// Runs the autopilot until `stop` completes, or the simulator leaves if `after` says so.
///
/// # Errors
/// [`ShellError`] when a port cannot be had.
pub async fn run_autopilot<O: Observer>(
    session: AutopilotSession,
    ports: &Ports,
    wiring: &Wiring,
    after: AfterSimulator,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<AutopilotSession, ShellError> {
    let links = Links::of_autopilot(session.system_id(), ports, wiring, "autopilot, ", observer).await?;
    let mut dialler = Dialler { at: loopback(ports.simulator), tried: None, reported: false };
    let mut shell = Shell {
        session,
        connection: None,
        links,
        started: Since::now(),
        own_words: Decoder::new(),
        texts: TextReader::default(),
        outbox: VecDeque::new(),
        observer,
    };
    let mut stop = std::pin::pin!(stop);
    loop {
        if shell.connection.is_none()
            && let Some(connection) = dialler.try_connect(shell.observer).await
        {
            shell.connection = Some(connection);
            shell.session.simulator_connected();
            shell.send();
        }
        let retry = shell.connection.is_none().then(|| dialler.until_next_try());
        let mut pause = shell.until_wake().min(retry.unwrap_or(Duration::MAX));
        if shell.connection.as_ref().is_some_and(Connection::is_held_up) {
            pause = pause.min(WATCH_PERIOD);
        }
        // A peer that always has something to be read must not keep the runtime from its signals, timers and
        // other sockets: what is ready at once takes nothing of anybody's turn. (`select!` gives
        // them theirs too, when its budget is spent: later.)
        tokio::task::yield_now().await;
        tokio::select! {
            biased;
            () = &mut stop => break,
            () = Connection::ready(shell.connection.as_ref()) => {}
            () = shell.links.readable() => {}
            () = tokio::time::sleep(pause) => {}
        }
        let had = shell.connection.is_some();
        shell.take_turn();
        if let Some(text) = shell.session.take_saved_parameters() {
            shell.observer.keep_parameters(&text);
        }
        let has_left = had && shell.connection.is_none();
        // Who is turned away, because another autopilot flies already, has met no simulator yet.
        if has_left && after == AfterSimulator::Return && shell.session.time().is_some() {
            shell.pass_on_last_words().await;
            break;
        }
    }
    shell.links.finish(shell.observer);
    Ok(shell.session)
}

/// Tries to connect until the simulator is there, as PX4 does.
struct Dialler {
    at: SocketAddr,
    tried: Option<Since>,
    reported: bool,
}

impl Dialler {
    fn until_next_try(&self) -> Duration {
        self.tried.map_or(Duration::ZERO, |tried| RETRY.saturating_sub(tried.elapsed()))
    }

    /// Tries once, if it is time to. That nobody is there is reported once.
    async fn try_connect(&mut self, observer: &mut impl Observer) -> Option<Connection> {
        if !self.until_next_try().is_zero() {
            return None;
        }
        self.tried = Some(Since::now());
        // On the loopback interface this is decided at once, unless whoever listens there accepts nobody.
        if let Ok(Ok(stream)) = tokio::time::timeout(DECIDED, TcpStream::connect(self.at)).await {
            self.reported = false;
            observer.notice(Notice::Connected(self.at, "simulator".into()));
            return Some(Connection::new(stream, self.at, "simulator link"));
        }
        if !std::mem::replace(&mut self.reported, true) {
            observer.notice(Notice::NobodyThere(self.at, "simulator".into()));
        }
        None
    }
}

/// Takes what the session wants sent; `now` stands in for simulated time before there is one.
fn collect(
    session: &mut AutopilotSession,
    now: TimeUs,
    outbox: &mut VecDeque<(TimeUs, Transmit)>,
    observer: &mut impl Observer,
) {
    while let Some(sent) = session.poll_output() {
        let time = session.time();
        // The record begins with simulated time; what comes before, comes at its start.
        observer.frame(time.unwrap_or(0), sent.link, &sent.bytes);
        outbox.push_back((time.unwrap_or(now), sent));
    }
}

impl<O: Observer> Shell<'_, O> {
    /// Simulated time; before there is one, the time since the start.
    fn now(&self) -> TimeUs {
        self.session.time().unwrap_or_else(|| self.started.elapsed_us())
    }

    /// How long until the session wants to be woken.
    fn until_wake(&self) -> Duration {
        let at = self.session.next_wake();
        at.map_or(Duration::MAX, |at| Duration::from_micros(at.saturating_sub(self.started.elapsed_us())))
    }

    /// Takes what has come and sends what is to be sent.
    fn take_turn(&mut self) {
        self.receive();
        self.session.handle_time(self.started.elapsed_us());
        self.send();
    }

    /// The simulator has left, and so shall we: who listens by way of us hears first that it has.
    async fn pass_on_last_words(&mut self) {
        let since = Since::now();
        while let Some(left) = LAST_WORDS.checked_sub(since.elapsed()) {
            _ = tokio::time::timeout(left, self.links.readable()).await;
            tokio::task::yield_now().await;
            self.take_turn();
        }
    }

    fn receive(&mut self) {
        let now = self.now();
        let Self { session, connection, links, outbox, observer, .. } = self;
        let mut take = |observer: &mut O, link: Link, frame: &Frame| {
            observer.frame(session.time().unwrap_or(0), link, frame.bytes());
            session.handle_input(link, frame);
            // Several steps may come at once; each answer is recorded at its own.
            collect(session, now, outbox, observer);
            while let Some(entry) = session.poll_log() {
                observer.log(entry);
            }
        };
        let mut ended = None;
        if let Some(connection) = connection {
            ended = connection.receive(*observer, |o, frame| take(o, Link::Simulator, frame)).err();
        }
        links.receive(*observer, take);
        if let Some(reason) = ended {
            self.disconnect(reason);
        }
    }

    fn disconnect(&mut self, reason: String) {
        if let Some(connection) = self.connection.take() {
            self.observer.notice(Notice::Disconnected(connection.peer, reason));
        }
    }

    fn send(&mut self) {
        let now = self.now();
        let Self { session, outbox, observer, .. } = self;
        collect(session, now, outbox, *observer);
        while let Some((at, sent)) = self.outbox.pop_front() {
            match (sent.link, &mut self.connection) {
                (Link::Simulator, Some(connection)) => connection.queue(&sent.bytes),
                (Link::Simulator, None) => {}
                (Link::GroundStation, _) => {
                    self.links.queue(&sent);
                    self.report_texts(at, &sent.bytes);
                }
                (Link::Api | Link::Parachute, _) => self.links.queue(&sent),
            }
        }
        self.links.flush();
        let flushed = match &mut self.connection {
            Some(connection) => connection.flush(),
            None => Ok(()),
        };
        if let Err(reason) = flushed {
            self.disconnect(reason);
        }
    }

    /// The autopilot speaks to its operators by STATUSTEXT; ours reads it here.
    fn report_texts(&mut self, at: TimeUs, bytes: &[u8]) {
        let Self { own_words, texts, observer, .. } = self;
        if message_id(bytes) != Some(STATUSTEXT_DATA::ID) {
            return;
        }
        own_words.datagram(bytes, |frame| {
            if let Some(MavMessage::STATUSTEXT(m)) = frame.known() {
                for text in texts.take((frame.system_id, frame.component_id), m) {
                    observer.notice(Notice::Autopilot { at, severity: m.severity as u8, text });
                }
            }
        });
    }
}
