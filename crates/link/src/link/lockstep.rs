//! The wire in memory: simulator with parachute, autopilot and streamer in one thread, in lockstep.
//!
//! Everything they say to each other is encoded to MAVLink 2 frames and decoded on the other side, as on
//! sockets, but simulated time stands still until all has been delivered. Within a step at time t the order
//! is: the simulator's messages of t, the autopilot's answer and telemetry of t, what the streamer and the
//! parachute make of them, and their answers; so a setpoint sent at t is with the autopilot before its step
//! at t + 4 ms, and a release commanded at t is a release at t. Same sessions, same bytes, every time.
//!
//! Frames of the ground station's link leave by the tap; what a ground station sends is put in by
//! [`Lockstep::deliver`].

use super::decoder::Decoder;
use super::faults::Faults;
use super::frame::Frame;
use super::hil::{HilSession, Missing, Pace};
use super::peer::PeerId;
use super::session::{Link, Session, Transmit};
use super::streamer::StreamerSession;
use crate::time::{TimeUs, seconds};

/// Rounds of answers to answers within one step; what is still in flight then is delivered in the next step.
const MAX_ROUNDS: usize = 32;

/// The lockstep stands still, because the autopilot has not answered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("at {:.3} s the simulator misses {missing}", seconds(*at))]
pub struct LockstepError {
    /// Simulated time.
    pub at: TimeUs,
    /// What is missing.
    pub missing: Missing,
}

/// One of the three parties, as the sender of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Party {
    /// The simulator, or its parachute.
    Simulator,
    /// The autopilot.
    Autopilot,
    /// The streamer.
    Streamer,
}

/// Simulator, autopilot and streamer with the wires between them, in one thread.
#[derive(Clone, Debug)]
pub struct Lockstep<A> {
    /// The simulator, which hosts the parachute.
    pub simulator: HilSession,
    /// The autopilot.
    pub autopilot: A,
    /// The streamer.
    pub streamer: StreamerSession,
    decoder: Decoder,
}

impl<A: Session> Lockstep<A> {
    /// Connects the three; the simulator has its peer.
    pub fn new(mut simulator: HilSession, autopilot: A, streamer: StreamerSession) -> Self {
        simulator.peer_connected();
        Self { simulator, autopilot, streamer, decoder: Decoder::new() }
    }

    /// Makes one step of the simulation and delivers all that follows from it. Every frame goes by `tap`,
    /// once, with its simulated time and its link. Returns whether the mission goes on.
    ///
    /// # Errors
    /// [`LockstepError`] when the autopilot has not answered the step before.
    pub fn step(&mut self, tap: &mut impl FnMut(TimeUs, Link, &[u8])) -> Result<bool, LockstepError> {
        self.step_sending(&mut |now, sent, _| tap(now, sent.link, &sent.bytes))
    }

    /// As [`Self::step`]; the tap learns whom each frame is for, and by which party it was sent.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_sending(
        &mut self,
        tap: &mut impl FnMut(TimeUs, &Transmit, Party),
    ) -> Result<bool, LockstepError> {
        let Some(now) = self.simulator.next_wake() else {
            let missing = self.simulator.missing().unwrap_or(Missing::AnyFrame);
            return match self.simulator.pace() {
                Pace::Done => Ok(false),
                _ => Err(LockstepError { at: self.simulator.now(), missing }),
            };
        };
        self.simulator.handle_time(now);
        // The setpoint that the autopilot's step at this time flies by is the one sent before it.
        self.simulator.note_setpoint(self.streamer.velocity_setpoint_ned());
        self.autopilot.handle_time(now);
        self.streamer.handle_time(now);
        for _ in 0..MAX_ROUNDS {
            if !self.round(now, tap) {
                break;
            }
        }
        Ok(self.simulator.pace() != Pace::Done)
    }

    /// Steps until the mission is over.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn run(&mut self, tap: &mut impl FnMut(TimeUs, Link, &[u8])) -> Result<(), LockstepError> {
        while self.step(tap)? {}
        Ok(())
    }

    /// Makes no further step: the simulator notifies everybody, as at the end of the mission.
    pub fn stop(&mut self, tap: &mut impl FnMut(TimeUs, &Transmit)) {
        self.simulator.stop();
        while let Some(sent) = self.simulator.poll_output() {
            tap(self.simulator.now(), &sent);
        }
    }

    /// Puts in what came from outside by `link`: for the autopilot what comes from ground stations and
    /// companions, for the parachute what comes to its own socket, for the simulator what comes from an
    /// autopilot.
    pub fn deliver(&mut self, link: Link, frame: &Frame) {
        match link {
            Link::GroundStation | Link::Api => self.autopilot.handle_input(link, frame),
            Link::Parachute | Link::Simulator => self.simulator.handle_input(link, frame),
        }
    }

    /// What the receivers on the wire have seen of damage: none.
    pub fn faults(&self) -> &Faults {
        self.decoder.faults()
    }

    /// Everyone's output once; whether there was any.
    fn round(&mut self, now: TimeUs, tap: &mut impl FnMut(TimeUs, &Transmit, Party)) -> bool {
        let Self { simulator, autopilot, streamer, decoder } = self;
        let mut any = false;
        while let Some(sent) = simulator.poll_output() {
            any = true;
            tap(now, &sent, Party::Simulator);
            match sent.link {
                _ if !sent.to.includes(PeerId::ONLY) => {}
                Link::Simulator => pass(decoder, &sent.bytes, autopilot, Link::Simulator),
                _ => pass(decoder, &sent.bytes, streamer, Link::Parachute),
            }
        }
        while let Some(sent) = autopilot.poll_output() {
            any = true;
            tap(now, &sent, Party::Autopilot);
            match sent.link {
                _ if !sent.to.includes(PeerId::ONLY) => {}
                Link::Simulator => pass(decoder, &sent.bytes, simulator, Link::Simulator),
                Link::Api => pass(decoder, &sent.bytes, streamer, Link::Api),
                Link::GroundStation | Link::Parachute => {}
            }
        }
        while let Some(sent) = streamer.poll_output() {
            any = true;
            tap(now, &sent, Party::Streamer);
            // One socket, two peers, as on UDP: both get it, and each knows what is meant for it.
            decoder.datagram(&sent.bytes, |frame: Frame| {
                autopilot.handle_input(Link::Api, &frame);
                simulator.handle_input(Link::Parachute, &frame);
            });
        }
        any
    }
}

fn pass(decoder: &mut Decoder, bytes: &[u8], to: &mut impl Session, link: Link) {
    decoder.datagram(bytes, |frame| to.handle_input(link, &frame));
}
