//! The drop in memory, at a speed to watch, with ground stations and scripts listening on UDP.
//!
//! Simulator, autopilot and streamer stay in lockstep on their wire in memory, so the flight is the same as without
//! watchers; these get what the autopilot and the parachute send, and may send, outside the lockstep.

use std::future::Future;
use std::time::Duration;

use super::super::streamer::STREAMER_SYSTEM;
use super::super::{AutopilotSession, Link, Lockstep, LockstepError, Session as _, TimeUs};
use super::clock::{Pacer, Speed};
use super::notice::{Notice, Observer, ShellError};
use super::ports::Ports;
use super::simulator::PEER_MEMORY;
use super::udp::UdpEndpoint;

/// Why a watched drop cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum WatchedError {
    /// A port cannot be had.
    #[error(transparent)]
    Shell(#[from] ShellError),
    /// A party did not answer.
    #[error(transparent)]
    Lockstep(#[from] LockstepError),
}

struct Sockets {
    ground: UdpEndpoint,
    api: UdpEndpoint,
    parachute: UdpEndpoint,
}

/// Flies the drop until its mission is over or `stop` completes.
///
/// # Errors
/// [`WatchedError`] when a port cannot be had, or the lockstep stands still.
pub async fn run_watched_drop<O: Observer>(
    mut wire: Lockstep<AutopilotSession>,
    ports: &Ports,
    speed: Speed,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<Lockstep<AutopilotSession>, WatchedError> {
    let (ground, api) = ([ports.ground_station], [ports.api]);
    let both = [ports.ground_station, ports.api];
    let bind = UdpEndpoint::bind;
    let mut sockets = Sockets {
        ground: bind(ports.autopilot_ground, "for ground stations", &ground, PEER_MEMORY, observer).await?,
        api: bind(ports.autopilot_api, "for companions", &api, PEER_MEMORY, observer).await?,
        parachute: bind(ports.parachute, "parachute", &both, PEER_MEMORY, observer).await?,
    };
    let mut pacer = Pacer::new(speed);
    let mut stop = std::pin::pin!(stop);
    let step_us = wire.simulator.config().step_us;
    loop {
        let pause = match speed {
            Speed::Max => Duration::ZERO,
            Speed::Factor(_) => pacer.until(wire.simulator.now() + step_us),
        };
        tokio::select! {
            biased;
            () = &mut stop => {
                wire.simulator.stop();
                while let Some(sent) = wire.simulator.poll_output() {
                    sockets.send(sent.link, &sent.bytes);
                    observer.frame(wire.simulator.now(), sent.link, &sent.bytes);
                }
                break;
            }
            () = sockets.ground.readable(), if !pause.is_zero() => {}
            () = sockets.api.readable(), if !pause.is_zero() => {}
            () = sockets.parachute.readable(), if !pause.is_zero() => {}
            () = tokio::time::sleep(pause), if !pause.is_zero() => {}
            () = tokio::task::yield_now(), if pause.is_zero() => {}
        }
        sockets.receive(&mut wire, observer);
        if !pause.is_zero() {
            continue;
        }
        let goes_on = wire.step(&mut |now, link, bytes: &[u8]| {
            sockets.send(link, bytes);
            observer.frame(now, link, bytes);
        })?;
        while let Some(event) = wire.simulator.poll_event() {
            observer.notice(Notice::Simulator(event));
        }
        while let Some(event) = wire.streamer.poll_event() {
            observer.notice(Notice::Streamer(event));
        }
        if let Some(text) = wire.autopilot.take_saved_parameters() {
            observer.keep_parameters(&text);
        }
        if !goes_on {
            break;
        }
    }
    Ok(wire)
}

impl Sockets {
    fn receive<O: Observer>(&mut self, wire: &mut Lockstep<AutopilotSession>, observer: &mut O) {
        let now: TimeUs = wire.simulator.now();
        for (socket, link) in [
            (&mut self.ground, Link::GroundStation),
            (&mut self.api, Link::Api),
            (&mut self.parachute, Link::Parachute),
        ] {
            socket.receive(observer, |observer, frame| {
                observer.frame(now, link, frame.bytes());
                wire.deliver(link, frame.bytes());
            });
        }
    }

    fn send(&mut self, link: Link, bytes: &[u8]) {
        // The streamer's own frames are for the autopilot alone.
        let from_streamer = bytes.get(5) == Some(&STREAMER_SYSTEM);
        match link {
            Link::GroundStation => self.ground.send(bytes),
            Link::Api if !from_streamer => self.api.send(bytes),
            Link::Parachute => self.parachute.send(bytes),
            Link::Api | Link::Simulator => {}
        }
    }
}
