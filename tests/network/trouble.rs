//! What a seed brings: how the wire is, who stalls and starts anew, who else is there and what they send.

use samara::random::Stream;
use samara::sim::ReleaseTrigger;

use super::frames;
use super::world::{Address, Host, Wish, ports};

/// A family of troubles; a seed's number modulo their number is its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing but the wire's own delays.
    Calm,
    /// Strangers and their misleading frames to the streamer, on a sound wire.
    Misled,
    /// Stalls of the streamer before the release, with what piles up meanwhile.
    Stalled,
    /// Loss, doubles, jitter.
    Lossy,
    /// A second vehicle of the same system.
    Twin,
    /// Commands of strangers.
    Meddled,
    /// The vehicle is cut loose by time or altitude, armed or not.
    Triggered,
    /// Strangers at every port, who want a place.
    Crowded,
    /// Strangers who hold services.
    Held,
    /// Parties stall and start anew, and are cut off.
    Broken,
    /// An autopilot that arms and disarms without time going on.
    Mad,
    /// Some of everything.
    Storm,
}

/// All families, in the order of the seeds.
pub const KINDS: [Kind; 12] = [
    Kind::Calm,
    Kind::Misled,
    Kind::Stalled,
    Kind::Lossy,
    Kind::Twin,
    Kind::Meddled,
    Kind::Triggered,
    Kind::Crowded,
    Kind::Held,
    Kind::Broken,
    Kind::Mad,
    Kind::Storm,
];

/// Something that is done at a time.
#[derive(Clone, Debug)]
pub enum Act {
    /// A host does nothing for so long [us].
    Stall(Host, u64),
    /// A host's process ends and is started again.
    Restart(Host),
    /// A host is cut off from all datagrams for so long [us].
    CutOff(Host, u64),
    /// A frame from an address that is nobody's.
    Send(Address, Address, Vec<u8>),
    /// The operator wants something.
    Wish(Wish),
    /// The operator says nothing for so long [us].
    Pause(u64),
    /// The autopilot's link says so many times in a row that it is armed, and that it is not.
    Toggle(usize),
}

/// The wire between sockets.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wire {
    /// Part of the datagrams that are lost.
    pub loss: f64,
    /// Part of them that come twice.
    pub doubled: f64,
    /// Further delay, uniform up to this [us]: what is sent later may come earlier.
    pub jitter_us: f64,
}

/// Everything that a seed brings.
#[derive(Clone, Debug)]
pub struct Trouble {
    pub seed: u64,
    pub kind: Kind,
    /// Simulated seconds per second.
    pub speed: f64,
    pub trigger: ReleaseTrigger,
    pub wire: Wire,
    /// When simulator, autopilot, streamer and operator start [us].
    pub starts: [u64; 4],
    pub streams: bool,
    pub acts: Vec<(u64, Act)>,
}

impl Trouble {
    /// The trouble of a seed.
    pub fn of(seed: u64) -> Self {
        let mut dice = Stream::new(seed, 1);
        let kind = KINDS[(seed % KINDS.len() as u64) as usize];
        let speed = [1.0, 4.0, 10.0, 50.0][dice.below(4)];
        // The streamer is there first, so that ten seconds are enough.
        let [simulator, autopilot, operator] = [(); 3].map(|()| 50_000 + dice.below(250_000) as u64);
        let starts = [simulator, autopilot, dice.below(50_000) as u64, operator];
        let (trigger, wire) = (ReleaseTrigger::Command, Wire::default());
        let mut trouble = Self { seed, kind, speed, trigger, wire, starts, streams: true, acts: Vec::new() };
        trouble.bring(kind, &mut dice);
        trouble.acts.sort_by_key(|(at, _)| *at);
        trouble
    }

    /// Wall time [us] at about a simulated time [s].
    fn wall(&self, t_s: f64) -> u64 {
        let [simulator, autopilot, ..] = self.starts;
        // It tries to connect every 250 ms.
        let tries = simulator.saturating_sub(autopilot).div_ceil(250_000);
        autopilot + tries * 250_000 + 100 + (t_s / self.speed * 1e6) as u64
    }

    fn bring(&mut self, kind: Kind, dice: &mut Stream) {
        match kind {
            Kind::Calm => {}
            Kind::Misled => {
                // The vehicle has been met.
                for _ in 0..1 + dice.below(4) {
                    let at = self.wall(dice.between(2.0, 9.0));
                    let stranger = 50_000 + dice.below(3) as u16;
                    self.act(at, Act::Send(stranger, ports::API, frames::misleading(dice)));
                }
            }
            Kind::Stalled => {
                // Not scheduled from its start, or from the first contact, on.
                let long_us = (dice.between(0.5, 3.5) / self.speed * 1e6) as u64;
                let [.., streamer, _] = self.starts;
                let (met_us, early) = (self.wall(0.0), dice.below(2) == 0);
                let at = if early { streamer } else { met_us + dice.below(60_000) as u64 };
                let for_us = if early { met_us.saturating_sub(streamer) + long_us } else { long_us };
                self.act(at, Act::Stall(Host::Streamer, for_us));
            }
            Kind::Lossy => {
                let wire = Wire {
                    loss: dice.between(0.0, 0.4),
                    doubled: dice.between(0.0, 0.4),
                    jitter_us: dice.between(0.0, 40e3) / self.speed,
                };
                self.wire = wire;
            }
            Kind::Twin => self.twin(dice),
            Kind::Meddled => {
                for _ in 0..1 + dice.below(4) {
                    let at = self.wall(dice.between(0.0, 9.0));
                    let (to_parachute, bytes) = frames::meddling(dice);
                    let to = if to_parachute { ports::PARACHUTE } else { ports::GROUND };
                    self.act(at, Act::Send(50_010, to, bytes));
                }
            }
            Kind::Triggered => {
                // The release is 20 m up, after four seconds at 5 m/s from there.
                self.trigger = [ReleaseTrigger::Time, ReleaseTrigger::Altitude(608.0)][dice.below(2)];
                self.streams = dice.below(4) > 0;
                self.starts[2] = self.wall(dice.between(0.0, 6.0));
                if dice.below(2) == 0 {
                    let at = self.wall(dice.between(2.0, 5.0));
                    let disarm = mavlink::dialects::common::MavCmd::MAV_CMD_COMPONENT_ARM_DISARM;
                    let bytes = frames::command(66, disarm, (1, 1), [0.0, 21_196.0, 0.0]);
                    self.act(at, Act::Send(50_010, ports::GROUND, bytes));
                }
            }
            Kind::Crowded => self.crowd(dice),
            Kind::Held => self.hold(dice),
            Kind::Broken => {
                for _ in 0..1 + dice.below(3) {
                    let at = self.wall(dice.between(0.0, 9.0));
                    let host = [Host::Simulator, Host::Autopilot, Host::Streamer][dice.below(3)];
                    let long_us = (dice.between(0.0, 4.0) / self.speed * 1e6) as u64;
                    self.act(
                        at,
                        match dice.below(3) {
                            0 => Act::Restart(host),
                            1 => Act::Stall(host, long_us),
                            _ => Act::CutOff(host, long_us),
                        },
                    );
                }
            }
            Kind::Mad => {
                let at = self.wall(dice.between(0.5, 9.0));
                self.act(at, Act::Toggle(2_000 + dice.below(3_000)));
            }
            Kind::Storm => {
                let one = |dice: &mut Stream| KINDS[1 + dice.below(KINDS.len() - 2)];
                for _ in 0..3 {
                    let kind = one(dice);
                    self.bring(kind, dice);
                }
            }
        }
    }

    fn act(&mut self, at: u64, act: Act) {
        self.acts.push((at, act));
    }

    /// A second vehicle of system 1 with a parachute: it is heard from some time on, its clock runs, it is
    /// released and its simulation ends.
    fn twin(&mut self, dice: &mut Stream) {
        let (autopilot, parachute) = (24_580, 24_600);
        // It is started after ours has been met.
        let begins_s = dice.between(2.0, 6.0);
        let (released_s, ends_s) = (dice.between(0.5, 2.0), dice.between(2.0, 4.0));
        let mut t_s = 0.0;
        while t_s < ends_s {
            let at = self.wall(begins_s + t_s);
            self.act(at, Act::Send(autopilot, ports::API, frames::attitude((t_s * 1e3) as u32)));
            t_s += 0.05;
        }
        for k in 0..4 {
            let at = self.wall(begins_s + f64::from(k));
            self.act(at, Act::Send(autopilot, ports::API, frames::vehicle_heartbeat(k % 2 == 0)));
            self.act(at, Act::Send(parachute, ports::API, frames::parachute_heartbeat()));
        }
        for (after_s, name) in [(released_s, "t_release"), (ends_s, "t_end")] {
            let value = frames::parachute_value(name, (after_s * 1e3) as i32);
            self.act(self.wall(begins_s + after_s), Act::Send(parachute, ports::API, value));
        }
    }

    /// More strangers than there are places, renewed every second, at the ports of autopilot and parachute;
    /// the operator pauses and comes back, and wants the parachute's answer through the autopilot.
    fn crowd(&mut self, dice: &mut Stream) {
        // 25 s of wall time, more than peers are remembered for.
        self.speed = 0.4;
        // The operator, who speaks every second, came first.
        let begins_us = 1_400_000 + dice.below(600_000) as u64;
        let many = 34 + dice.below(20) as u16;
        let ends_us = self.wall(9.0);
        let mut at = begins_us;
        while at < ends_us {
            for i in 0..many {
                for to in [ports::GROUND, ports::PARACHUTE] {
                    let beat = frames::station_heartbeat(100 + (i % 100) as u8);
                    self.act(at + u64::from(i) * 7, Act::Send(51_000 + i, to, beat));
                }
            }
            at += 2_000_000;
        }
        let paused_us = dice.between(2e6, 11.5e6) as u64;
        let at = dice.between(2.5e6, 6e6) as u64;
        self.act(at, Act::Pause(paused_us));
        for k in 1..4 {
            self.act(at + paused_us + k * 1_500_000, Act::Wish(Wish::Parachute));
        }
    }

    /// Strangers hold a mission upload and all file sessions; the operator wants both.
    fn hold(&mut self, dice: &mut Stream) {
        self.speed = 1.0;
        let mut at = 400_000;
        let files = dice.below(2) == 0;
        while at < 9_000_000 {
            for i in 0..12u16 {
                let system = 120 + i as u8;
                let bytes = match (files, at) {
                    (true, _) => frames::file_open(system, (at / 200_000) as u16),
                    (false, 400_000) => frames::mission_holding(120, true),
                    (false, _) => frames::mission_holding(120, false),
                };
                let from = if files { 52_000 + i } else { 52_000 };
                self.act(at + u64::from(i), Act::Send(from, ports::GROUND, bytes));
            }
            at += 1_000_000;
        }
        let wish = if files { Wish::File } else { Wish::Clear };
        for k in 0..4 {
            self.act(3_200_000 + k * 1_500_000, Act::Wish(wish));
        }
    }
}
