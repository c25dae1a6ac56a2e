//! The reference autopilot on sockets: TCP client of the simulator, UDP 18570 + N for ground stations, 14580 + N for
//! companions.

use std::future::Future;
use std::time::Duration;

use mavlink::dialects::common::MavMessage;

use super::super::statustext::TextReader;
use super::super::{AutopilotSession, Decoder, Frame, Link, Session as _, TimeUs};
use super::clock::Since;
use super::connection::Connection;
use super::notice::{Notice, Observer, ShellError};
use super::ports::Ports;
use super::simulator::PEER_MEMORY;
use super::tcp_client::TcpClient;
use super::udp::UdpEndpoint;

const TICK: Duration = Duration::from_millis(100);
/// STATUSTEXT.
const STATUSTEXT_ID: u32 = 253;

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
    ground: UdpEndpoint,
    api: UdpEndpoint,
    started: Since,
    own_words: Decoder,
    texts: TextReader,
    observer: &'a mut O,
}

/// Runs the autopilot until `stop` completes, or the simulator leaves if `after` says so.
///
/// # Errors
/// [`ShellError`] when a port cannot be had.
pub async fn run_autopilot<O: Observer>(
    session: AutopilotSession,
    ports: &Ports,
    after: AfterSimulator,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<AutopilotSession, ShellError> {
    let (at, remotes) = (ports.autopilot_ground, [ports.ground_station]);
    let ground =
        UdpEndpoint::bind(at, "autopilot, for ground stations", &remotes, PEER_MEMORY, observer).await?;
    let (at, remotes) = (ports.autopilot_api, [ports.api]);
    let api = UdpEndpoint::bind(at, "autopilot, for companions", &remotes, PEER_MEMORY, observer).await?;
    let mut client = TcpClient::new(ports.simulator, "simulator");
    let mut shell = Shell {
        session,
        connection: None,
        ground,
        api,
        started: Since::now(),
        own_words: Decoder::new(),
        texts: TextReader::default(),
        observer,
    };
    let mut stop = std::pin::pin!(stop);
    loop {
        if shell.connection.is_none()
            && let Some((stream, peer)) = client.try_connect(shell.observer).await
        {
            shell.connection = Some(Connection::new(stream, peer, "simulator link"));
            shell.session.simulator_connected();
            shell.send().await;
        }
        tokio::select! {
            () = &mut stop => break,
            () = Connection::readable(shell.connection.as_ref()) => {}
            () = shell.ground.readable() => {}
            () = shell.api.readable() => {}
            () = tokio::time::sleep(TICK) => {}
        }
        let had = shell.connection.is_some();
        shell.receive();
        shell.session.handle_time(shell.started.elapsed_us());
        shell.send().await;
        if let Some(text) = shell.session.take_saved_parameters() {
            shell.observer.keep_parameters(&text);
        }
        if had && shell.connection.is_none() && after == AfterSimulator::Return {
            break;
        }
    }
    Ok(shell.session)
}

impl<O: Observer> Shell<'_, O> {
    /// Simulated time; before there is one, the time since the start.
    fn now(&self) -> TimeUs {
        self.session.time().unwrap_or_else(|| self.started.elapsed_us())
    }

    fn receive(&mut self) {
        let now = self.now();
        let Self { session, connection, ground, api, observer, .. } = self;
        let take = |link: Link| {
            move |session: &mut AutopilotSession, observer: &mut O, frame: &Frame| {
                observer.frame(session.time().unwrap_or(0), link, frame.bytes());
                session.handle_input(now, link, frame);
            }
        };
        let (from_simulator, from_ground, from_api) =
            (take(Link::Simulator), take(Link::GroundStation), take(Link::Api));
        let mut ended = None;
        if let Some(connection) = connection {
            ended = connection.receive(*observer, |o, frame| from_simulator(session, o, frame)).err();
        }
        ground.receive(*observer, |o, frame| from_ground(session, o, frame));
        api.receive(*observer, |o, frame| from_api(session, o, frame));
        if let Some(reason) = ended {
            self.disconnect(reason);
        }
    }

    fn disconnect(&mut self, reason: String) {
        if let Some(connection) = self.connection.take() {
            self.observer.notice(Notice::Disconnected { peer: connection.peer, reason });
        }
    }

    async fn send(&mut self) {
        let now = self.now();
        while let Some(sent) = self.session.poll_output() {
            match (sent.link, &mut self.connection) {
                (Link::Simulator, Some(connection)) => connection.queue(&sent.bytes),
                (Link::Simulator, None) => continue,
                (Link::GroundStation, _) => {
                    self.ground.send(&sent.bytes);
                    self.tell_words(now, &sent.bytes);
                }
                (Link::Api | Link::Parachute, _) => self.api.send(&sent.bytes),
            }
            // The record begins with simulated time; what comes before, comes at its start.
            self.observer.frame(self.session.time().unwrap_or(0), sent.link, &sent.bytes);
        }
        let flushed = match &mut self.connection {
            Some(connection) => connection.flush().await,
            None => Ok(()),
        };
        if let Err(reason) = flushed {
            self.disconnect(reason);
        }
    }

    /// The autopilot speaks to its operators by STATUSTEXT; ours reads it here.
    fn tell_words(&mut self, at: TimeUs, bytes: &[u8]) {
        let Self { own_words, texts, observer, .. } = self;
        if bytes.get(7..10) != Some(&STATUSTEXT_ID.to_le_bytes()[..3]) {
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
