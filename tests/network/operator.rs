//! An operator at a ground station of their own: speaks once a second, and wants something now and then.

use std::collections::VecDeque;

use mavlink::dialects::common::MavCmd;
use samara::link::parachute::PARACHUTE_COMPONENT;
use samara::link::{EndpointId, Frame, Hub, HubConfig, Link, Transmit};

use super::frames;
use super::process::key;
use super::trouble::Trouble;
use super::wire::{Address, ports};

/// From one HEARTBEAT to the next, and from one try to connect to the next [us].
const BEAT_US: u64 = 1_000_000;
/// Since an operator began to speak, this long passes before silence counts [us].
const SETTLES_US: u64 = 2_500_000;
const OWN: (u8, u8) = (255, 190);

/// Something that the operator asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// A HEARTBEAT of the parachute, through the autopilot.
    Parachute,
    /// The mission cleared.
    Clear,
    /// A file of the autopilot's.
    File,
}

pub struct Operator {
    hub: Hub<Address>,
    endpoint: EndpointId,
    /// Where the vehicle is.
    vehicle: Address,
    pub inbox: VecDeque<Vec<u8>>,
    pub is_connected: bool,
    quiet_until: u64,
    speaks_since: Option<u64>,
    heard: u64,
    next_beat: u64,
    asked: Option<Wish>,
    sequence: u16,
}

impl Operator {
    pub fn new(of: &Trouble, unix: u64) -> Self {
        let config = HubConfig { own: OWN, memory_us: u64::MAX, forwards: false, key: of.signed.then(key) };
        let mut hub = Hub::new(config);
        let endpoint = hub.add_endpoint(Link::GroundStation);
        let vehicle = if of.operator_by_tcp { ports::DOOR } else { ports::GROUND };
        hub.keep(unix, endpoint, vehicle);
        Self {
            hub,
            endpoint,
            vehicle,
            inbox: VecDeque::new(),
            is_connected: false,
            quiet_until: 0,
            speaks_since: None,
            heard: 0,
            next_beat: 0,
            asked: None,
            sequence: 0,
        }
    }

    /// Takes what has come: for how long nothing had, where the operator was speaking [us], and whether a
    /// wish was granted.
    pub fn receive(&mut self, now: u64, unix: u64) -> (u64, bool) {
        let (mut silent_us, mut granted) = (0, false);
        for bytes in std::mem::take(&mut self.inbox) {
            let asked = self.asked;
            let mut heard = false;
            self.hub.datagram(unix, self.endpoint, self.vehicle, &bytes, |frame| {
                heard = true;
                granted |= asked.is_some_and(|wish| grants(wish, frame));
            });
            if granted {
                self.asked = None;
            }
            if heard {
                silent_us = silent_us.max(self.silence(now));
                self.heard = now;
            }
        }
        (silent_us, granted)
    }

    /// For how long an operator who speaks has heard nothing [us].
    pub fn silence(&self, now: u64) -> u64 {
        let speaks = self.speaks_since.is_some_and(|since| now > since + SETTLES_US);
        if speaks { now - self.heard.max(self.speaks_since.unwrap_or(0)) } else { 0 }
    }

    /// Says nothing until then.
    pub fn pause(&mut self, until: u64) {
        self.quiet_until = until;
        self.speaks_since = None;
    }

    /// What the operator's HEARTBEAT is on the wire, if it is due.
    pub fn beat(&mut self, now: u64, unix: u64) -> Option<Vec<u8>> {
        if now < self.next_wake() {
            return None;
        }
        self.next_beat = now + BEAT_US;
        self.speaks_since.get_or_insert(now);
        Some(self.seal(unix, frames::station_heartbeat(OWN.0)))
    }

    pub fn next_wake(&self) -> u64 {
        self.next_beat.max(self.quiet_until)
    }

    /// What asks for a wish on the wire.
    pub fn ask(&mut self, wish: Wish, unix: u64) -> Vec<u8> {
        self.asked = Some(wish);
        self.sequence += 1;
        let bytes = match wish {
            Wish::Parachute => {
                let request = MavCmd::MAV_CMD_REQUEST_MESSAGE;
                frames::command(OWN.0, request, (1, PARACHUTE_COMPONENT), [0.0; 3])
            }
            Wish::Clear => frames::mission_clear(OWN.0),
            Wish::File => frames::file_open(OWN.0, 100 + self.sequence),
        };
        self.seal(unix, bytes)
    }

    fn seal(&mut self, unix: u64, bytes: Vec<u8>) -> Vec<u8> {
        let mut sealed = Vec::new();
        let transmit = Transmit::to_all(Link::GroundStation, bytes);
        self.hub.send(unix, &transmit, |_, _, bytes| sealed = bytes.to_vec());
        sealed
    }
}

fn grants(wish: Wish, frame: &Frame) -> bool {
    match wish {
        Wish::Parachute => frame.component_id == PARACHUTE_COMPONENT && frame.command_ack().is_some(),
        // MISSION_ACK, accepted.
        Wish::Clear => frame.message_id == 47 && frame.payload().u8(2) == 0,
        // ACK of the file server.
        Wish::File => frame.message_id == 110 && frame.payload().u8(3 + 3) == 128,
    }
}
