//! The drop in memory, at a speed to watch, with ground stations and scripts listening on UDP.
//!
//! Simulator, autopilot and streamer stay in lockstep on their wire in memory, so the flight is the same as
//! without watchers; these get what the autopilot and the parachute send, and may send, outside the lockstep.

use std::future::Future;
use std::time::Duration;

use super::super::autopilot::{AUTOPILOT_COMPONENT, AutopilotSession};
use super::super::lockstep::{Lockstep, LockstepError, Party};
use super::super::parachute::PARACHUTE_COMPONENT;
use super::super::peer::PeerId;
use super::super::session::{Link, Session as _, Transmit};
use super::clock::{Pacer, Speed};
use super::links::{Links, PEER_MEMORY, Wiring};
use super::notice::{Notice, Observer, ShellError};
use super::ports::Ports;
use super::viewer::Viewer;
use crate::time::TimeUs;

/// A reason why a watched drop cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum WatchedError {
    /// A port cannot be had.
    #[error(transparent)]
    Shell(#[from] ShellError),
    /// A party did not answer.
    #[error(transparent)]
    Lockstep(#[from] LockstepError),
}

/// The autopilot's links and the parachute's.
struct Sockets {
    vehicle: Links,
    parachute: Links,
    /// System and component of the autopilot.
    autopilot: (u8, u8),
    /// As which of the parachute's peers it passes on what comes to it.
    router: Option<PeerId>,
    viewer: Viewer,
}

/// Flies the drop until its mission is over or `stop` completes.
///
/// # Errors
/// [`WatchedError`] when a port cannot be had, or the lockstep stands still.
pub async fn run_watched_drop<O: Observer>(
    mut wire: Lockstep<AutopilotSession>,
    ports: &Ports,
    wiring: &Wiring,
    speed: Speed,
    observer: &mut O,
    stop: impl Future<Output = ()>,
) -> Result<Lockstep<AutopilotSession>, WatchedError> {
    let mut sockets = Sockets::open(&wire, ports, (wiring, speed), observer).await?;
    let mut pacer = Pacer::new(speed);
    let mut stop = std::pin::pin!(stop);
    loop {
        let pause = match (speed, wire.simulator.next_wake()) {
            (Speed::Factor(_), Some(at)) => pacer.until(at),
            (Speed::Max, _) | (_, None) => Duration::ZERO,
        };
        tokio::task::yield_now().await;
        tokio::select! {
            biased;
            () = &mut stop => {
                wire.stop(&mut |now, sent| {
                    sockets.queue(sent, Party::Simulator);
                    observer.frame(now, sent.link, &sent.bytes);
                });
                sockets.flush();
                break;
            }
            () = sockets.vehicle.readable(), if !pause.is_zero() => {}
            () = sockets.parachute.readable(), if !pause.is_zero() => {}
            () = tokio::time::sleep(pause), if !pause.is_zero() => {}
            () = std::future::ready(()), if pause.is_zero() => {}
        }
        sockets.receive(&mut wire, observer);
        if !pause.is_zero() {
            continue;
        }
        let goes_on = wire.step_sending(&mut |now, sent: &Transmit, by| {
            sockets.queue(sent, by);
            observer.frame(now, sent.link, &sent.bytes);
        })?;
        sockets.flush();
        observer.flown(wire.simulator.run().log());
        while let Some(event) = wire.simulator.poll_event() {
            observer.notice(Notice::Simulator(event));
        }
        while let Some(event) = wire.streamer.poll_event() {
            observer.notice(Notice::Streamer(event));
        }
        if let Some(text) = wire.autopilot.take_saved_parameters() {
            observer.keep_parameters(&text);
        }
        while let Some(entry) = wire.autopilot.poll_log() {
            observer.log(entry);
        }
        if !goes_on {
            break;
        }
    }
    sockets.vehicle.finish(observer);
    sockets.parachute.finish(observer);
    Ok(wire)
}

impl Sockets {
    async fn open<O: Observer>(
        wire: &Lockstep<AutopilotSession>,
        ports: &Ports,
        (wiring, speed): (&Wiring, Speed),
        observer: &mut O,
    ) -> Result<Self, ShellError> {
        let system = wire.autopilot.system_id();
        let vehicle = Links::of_autopilot(system, ports, wiring, "", observer).await?;
        let mut parachute =
            Links::new((system, PARACHUTE_COMPONENT), PEER_MEMORY, false, wiring.sign.as_ref())?;
        parachute.expect_router(system);
        parachute.bind_udp(Link::Parachute, ports.parachute, "parachute", &[], observer).await?;
        let viewer = Viewer::open(system, ports, speed);
        Ok(Self { vehicle, parachute, autopilot: (system, AUTOPILOT_COMPONENT), router: None, viewer })
    }

    fn receive<O: Observer>(&mut self, wire: &mut Lockstep<AutopilotSession>, observer: &mut O) {
        let now: TimeUs = wire.simulator.now();
        self.vehicle.receive(observer, |observer, link, frame| {
            // The parachute's own frames are known.
            if link != Link::Parachute {
                observer.frame(now, link, frame.bytes());
                wire.deliver(link, frame);
            }
        });
        let Self { parachute, router, autopilot, .. } = self;
        parachute.receive(observer, |observer, link, frame| {
            if (frame.system_id, frame.component_id) == *autopilot {
                *router = Some(frame.peer);
            } else {
                // By way of the autopilot it has been recorded as it came there.
                if *router != Some(frame.peer) {
                    observer.frame(now, link, frame.bytes());
                }
                wire.deliver(link, frame);
            }
        });
    }

    /// Takes a frame for those it is for, to be sent by [`Self::flush`].
    fn queue(&mut self, sent: &Transmit, by: Party) {
        self.viewer.show(sent);
        match (sent.link, by) {
            // The streamer's own frames are for the autopilot alone.
            (Link::Simulator, _) | (_, Party::Streamer) => {}
            (Link::GroundStation | Link::Api, _) => self.vehicle.queue(sent),
            (Link::Parachute, _) => self.parachute.queue(sent),
        }
    }

    fn flush(&mut self) {
        self.vehicle.flush();
        self.parachute.flush();
    }
}
