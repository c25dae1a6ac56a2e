//! The offboard streamer on a socket: UDP 14540 + N, where autopilot and parachute speak first.

use std::future::Future;
use std::time::Duration;

use super::super::session::{Link, Session as _};
use super::super::streamer::{STREAMER_COMPONENT, STREAMER_SYSTEM, StreamerEvent, StreamerSession};
use super::clock::{Since, WATCH_PERIOD};
use super::event_texts::read_fetched;
use super::links::Links;
use super::notice::{Notice, Observer, ShellError};
use super::ports::Ports;
use super::solver::Solver;
use super::stamp_store::SignWith;

/// The parachute speaks once per simulated second only, and time may run slowly.
const PEER_MEMORY: Duration = Duration::from_secs(600);

/// Runs the streamer until its stream has ended, it has given up, or `stop` completes.
///
/// # Errors
/// [`ShellError`] when the port cannot be had.
pub async fn run_streamer<O: Observer>(
    mut session: StreamerSession,
    ports: &Ports,
    sign: Option<&SignWith>,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<StreamerSession, ShellError> {
    let what = "streamer, for autopilot and parachute";
    let own = (STREAMER_SYSTEM, STREAMER_COMPONENT);
    let mut socket = Links::new(own, PEER_MEMORY, false, sign)?;
    // Their places are theirs, however many others speak first.
    let vehicle = [ports.autopilot_api, ports.parachute];
    socket.bind_udp(Link::Api, ports.api, what, &vehicle, observer).await?;
    let began = Since::now();
    let mut heard = began;
    let mut solver = session.host_renewal().map(Solver::start);
    let mut stop = std::pin::pin!(stop);
    while !session.is_over() {
        tokio::task::yield_now().await;
        tokio::select! {
            biased;
            () = &mut stop => break,
            (answer, took) = Solver::answer(&mut solver) => session.handle_replanned(answer, took),
            () = socket.readable() => {}
            () = tokio::time::sleep(WATCH_PERIOD) => {}
        }
        let before = session.now();
        let is_empty = socket.receive(observer, |observer, link, frame| {
            observer.frame(session.now(), link, frame.bytes());
            session.handle_input(link, frame);
        });
        if is_empty {
            session.handle_empty(began.elapsed(), false);
        }
        read_fetched(&mut session);
        if session.now() == before {
            session.handle_silence(heard.elapsed());
        } else {
            heard = Since::now();
        }
        if let (Some(request), Some(solver)) = (session.poll_replan(), &solver) {
            solver.ask(request);
        }
        while let Some(event) = session.poll_event() {
            let waits = matches!(event.event, StreamerEvent::Waiting { .. });
            observer.notice(Notice::Streamer(event));
            let faults = socket.faults();
            if waits && faults.refused() > 0 {
                observer.notice(Notice::RefusedMeanwhile(faults));
            }
        }
        while let Some(sent) = session.poll_output() {
            observer.frame(session.now(), sent.link, &sent.bytes);
            socket.send(&sent);
        }
    }
    socket.finish(observer);
    Ok(session)
}
