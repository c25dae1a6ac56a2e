//! The simulator on sockets: TCP 4560 + N for the autopilot, UDP 14600 + N for the parachute.

use std::future::Future;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::TcpStream;

use super::super::parachute::PARACHUTE_COMPONENT;
use super::super::signing::Key;
use super::super::{Frame, Link, Pace, Session as _, SimulatorSession};
use super::clock::{Pacer, Since, Speed};
use super::connection::Connection;
use super::links::Links;
use super::notice::{Notice, Observer, ShellError};
use super::ports::Ports;
use super::tcp_server::TcpServer;

/// How often a wait is looked at.
const TICK: Duration = Duration::from_millis(100);
/// Half a frame and then nothing for this long: the rest is not coming.
const HALF_FRAME_PATIENCE: Duration = Duration::from_secs(1);
/// How long a peer of the parachute is remembered.
pub(super) const PEER_MEMORY: Duration = Duration::from_secs(10);

struct Shell<'a, O> {
    session: SimulatorSession,
    connection: Option<Connection>,
    parachute: Links,
    pacer: Pacer,
    waiting: Since,
    observer: &'a mut O,
}

/// Runs the simulator until the mission is over or `stop` completes. Before the first answer, and at [`Speed::Factor`], it
/// keeps the pace of the clock; an autopilot that leaves is waited for, and the drop then starts over. The
/// parachute tells everybody when it is over.
///
/// # Errors
/// [`ShellError`] when a port cannot be had.
pub async fn run_simulator<O: Observer>(
    session: SimulatorSession,
    ports: &Ports,
    speed: Speed,
    key: Option<Key>,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<SimulatorSession, ShellError> {
    let server = TcpServer::bind(ports.simulator, "simulator, for the autopilot", observer).await?;
    let remotes = [ports.ground_station, ports.api];
    let own = (session.config().system_id, PARACHUTE_COMPONENT);
    let mut parachute = Links::new(own, PEER_MEMORY, false, key);
    parachute.expect_doubles();
    parachute.bind_udp(Link::Parachute, ports.parachute, "parachute", &remotes, observer).await?;
    let mut shell = Shell {
        session,
        connection: None,
        parachute,
        pacer: Pacer::new(speed),
        waiting: Since::now(),
        observer,
    };
    let mut stop = std::pin::pin!(stop);
    while shell.session.pace() != Pace::Done {
        let pause = match shell.session.pace() {
            Pace::Free => shell.until_next_step(),
            Pace::Ready if speed != Speed::Max => shell.until_next_step(),
            Pace::Ready | Pace::Done => Duration::ZERO,
            Pace::NoPeer | Pace::AwaitingControls => TICK,
        };
        let mut accepted = None;
        if pause.is_zero() {
            shell.step().await;
        } else {
            tokio::select! {
                () = &mut stop => {
                    shell.session.stop();
                    break;
                }
                new = server.accept() => accepted = Some(new),
                () = Connection::readable(shell.connection.as_ref()) => {}
                () = shell.parachute.readable() => {}
                () = tokio::time::sleep(pause.min(TICK)) => {}
            }
        }
        shell.receive();
        if let Some((stream, peer)) = accepted {
            shell.admit(stream, peer);
        }
        shell.look_at_silence();
        shell.send().await;
    }
    shell.send().await;
    shell.parachute.tell_counts(shell.observer);
    // First, so that an autopilot whose connection ends does not find it open.
    drop(server);
    if let Some(connection) = shell.connection.take() {
        connection.close().await;
    }
    Ok(shell.session)
}

impl<O: Observer> Shell<'_, O> {
    fn until_next_step(&mut self) -> Duration {
        self.pacer.until(self.session.now() + self.session.config().step_us)
    }

    async fn step(&mut self) {
        self.session.advance();
        self.waiting = Since::now();
        self.send().await;
        // Where nothing is waited for, the sockets must be looked at all the same.
        if self.session.pace() != Pace::AwaitingControls {
            tokio::task::yield_now().await;
        }
    }

    fn receive(&mut self) {
        let Self { session, connection, parachute, observer, .. } = self;
        let mut ended = None;
        if let Some(connection) = connection {
            let result = connection.receive(*observer, |observer, frame| {
                observer.frame(session.now(), Link::Simulator, frame.bytes());
                session.handle_input(session.now(), Link::Simulator, frame);
            });
            ended = result.err();
        }
        parachute.receive(*observer, |observer, link, frame: &Frame| {
            observer.frame(session.now(), link, frame.bytes());
            session.handle_input(session.now(), link, frame);
        });
        if let Some(reason) = ended {
            self.disconnect(reason);
        }
    }

    fn admit(&mut self, stream: TcpStream, peer: SocketAddr) {
        if self.connection.is_some() {
            self.observer.notice(Notice::TurnedAway { peer });
            return;
        }
        self.observer.notice(Notice::Connected { peer, what: "autopilot".into() });
        self.connection = Some(Connection::new(stream, peer, "simulator link"));
        self.session.peer_connected();
        self.pacer.reset();
        self.waiting = Since::now();
    }

    fn disconnect(&mut self, reason: String) {
        if let Some(connection) = self.connection.take() {
            self.observer.notice(Notice::Disconnected { peer: connection.peer, reason });
            self.session.peer_left();
        }
    }

    fn look_at_silence(&mut self) {
        if self.session.pace() != Pace::AwaitingControls {
            return;
        }
        let waited = self.waiting.elapsed();
        if waited < HALF_FRAME_PATIENCE.min(TICK) {
            return;
        }
        let Self { session, connection, observer, .. } = self;
        if let Some(connection) = connection
            && waited >= HALF_FRAME_PATIENCE
        {
            connection.give_up_half_frames(*observer, |observer, frame| {
                observer.frame(session.now(), Link::Simulator, frame.bytes());
                session.handle_input(session.now(), Link::Simulator, frame);
            });
        }
        session.handle_silence(waited);
    }

    async fn send(&mut self) {
        while let Some(event) = self.session.poll_event() {
            self.observer.notice(Notice::Simulator(event));
        }
        let now = self.session.now();
        while let Some(sent) = self.session.poll_output() {
            self.observer.frame(now, sent.link, &sent.bytes);
            match (sent.link, &mut self.connection) {
                (Link::Simulator, Some(connection)) => connection.queue(&sent.bytes),
                (Link::Simulator, None) => {}
                _ => self.parachute.send(&sent),
            }
        }
        let flushed = match &mut self.connection {
            Some(connection) => connection.flush().await,
            None => Ok(()),
        };
        if let Err(reason) = flushed {
            self.disconnect(reason);
        }
    }
}
