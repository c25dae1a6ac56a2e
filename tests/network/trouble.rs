//! What a seed brings: how the wire is, who stalls and starts anew, who else is there and what they send.

use samara::random::{Purpose, Stream};
use samara::sim::ReleaseTrigger;

use super::frames;
use super::operator::Wish;
use super::wire::{Address, Call, Host, Vehicle, Wire, ports};

/// Later than everything.
const NEVER: u64 = 1 << 60;

/// A family of troubles; a seed's number modulo their number is its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Nothing but the wire's own delays.
    Calm,
    /// Strangers and their misleading frames to the streamer, on a sound wire.
    Misled,
    /// The streamer is stopped at first contact, or what comes to it is held up on the way: what has piled up
    /// passes in one go.
    Stalled,
    /// Loss, doubles, jitter.
    Lossy,
    /// A second simulator with an autopilot of the same system.
    Twin,
    /// Commands of strangers.
    Meddled,
    /// The vehicle is cut loose by time or altitude, armed or not.
    Triggered,
    /// Strangers at every port, who want a place.
    Crowded,
    /// TCP clients that say nothing, or nothing that is let in, with a key and without.
    Doors,
    /// Strangers who hold services.
    Held,
    /// With a key: strangers without it at every door, who also have RADIO_STATUS.
    Keyless,
    /// With a key: parties are started anew, and what was recorded is played to them again.
    PlayedAgain,
    /// With a key: clocks that differ, and a stamp from the end of time.
    Clocks,
    /// Parties stall and start anew, and are cut off.
    Broken,
    /// An autopilot that arms and disarms without time going on.
    Mad,
    /// A simulator whose time jumps to and fro, and to its end; somebody has asked for ATTITUDE every
    /// microsecond.
    Rewound,
    /// With a key: somebody whose clock is minutes to a day ahead, before others come.
    Ahead,
    /// Somebody who sends as much as the sockets hold, over and over, at every port.
    Flooded,
    /// A vehicle whose text does not end, and would act on a terminal.
    Wordy,
    /// Some of everything.
    Storm,
}

/// All families, in the order of the seeds.
pub const KINDS: [Kind; 20] = [
    Kind::Calm,
    Kind::Misled,
    Kind::Stalled,
    Kind::Lossy,
    Kind::Twin,
    Kind::Meddled,
    Kind::Triggered,
    Kind::Crowded,
    Kind::Doors,
    Kind::Held,
    Kind::Keyless,
    Kind::PlayedAgain,
    Kind::Clocks,
    Kind::Broken,
    Kind::Mad,
    Kind::Rewound,
    Kind::Ahead,
    Kind::Flooded,
    Kind::Wordy,
    Kind::Storm,
];

/// How many families a storm is made of, from the second on: those that its seeds in `tests` were found with.
const STORMY: usize = 15;

/// Something that is done at a time.
#[derive(Clone, Debug)]
pub enum Act {
    /// A host does nothing for so long [us].
    Stall(Host, u64),
    /// A host's process ends, or is killed, and is started again.
    Restart { host: Host, killed: bool },
    /// A host is cut off from all datagrams for so long [us].
    CutOff(Host, u64),
    /// What is sent to a host is held up on the way for so long [us], and then passes in one go.
    HoldUp(Host, u64),
    /// A frame from an address that is nobody's.
    Send(Address, Address, Vec<u8>),
    /// A TCP client that is nobody's does something.
    Call(Address, Call),
    /// What was recorded on the way to a host is sent to it again; disguised: in its senders' names.
    PlayAgain { host: Host, disguised: bool },
    /// Somebody with the key sends a stamp from the end of time there.
    FarStamp(Address),
    /// Somebody with the key sends a stamp there that is so far ahead of the operator's clock [us].
    Ahead(Address, u64),
    /// So many datagrams of nobody's bytes at once.
    Flood { to: Address, datagrams: usize },
    /// The operator wants something.
    Wish(Wish),
    /// The operator says nothing for so long [us].
    Pause(u64),
    /// The autopilot's link says so many times in a row that it is armed, and that it is not.
    Toggle(usize),
    /// The simulator's link brings so many steps whose time jumps.
    Rewind(usize),
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
    /// All parties have a key.
    pub signed: bool,
    /// How far each host's clock is ahead [us].
    pub clocks_us: [i64; Host::ALL.len()],
    pub operator_by_tcp: bool,
    /// When the other vehicle starts, if there is one [us].
    pub other_from: Option<u64>,
    pub acts: Vec<(u64, Act)>,
}

impl Trouble {
    /// The trouble of a seed.
    pub fn of(seed: u64) -> Self {
        Self::of_kind(KINDS[(seed % KINDS.len() as u64) as usize], seed)
    }

    /// The trouble that a seed brings in a family.
    pub fn of_kind(kind: Kind, seed: u64) -> Self {
        let mut dice = Stream::new(seed, Purpose::Dice, 1);
        let speed = [1.0, 4.0, 10.0, 50.0][dice.below(4)];
        // The streamer is there first, so that ten seconds are enough.
        let [simulator, autopilot, operator] = [(); 3].map(|()| 50_000 + dice.below(250_000) as u64);
        let starts = [simulator, autopilot, dice.below(50_000) as u64, operator];
        let mut trouble = Self {
            seed,
            kind,
            speed,
            trigger: ReleaseTrigger::Command,
            wire: Wire::default(),
            starts,
            streams: true,
            signed: false,
            clocks_us: Default::default(),
            operator_by_tcp: false,
            other_from: None,
            acts: Vec::new(),
        };
        trouble.bring(kind, &mut dice);
        trouble.acts.sort_by_key(|(at, _)| *at);
        trouble
    }

    /// When a host starts; never, if it is not there [us].
    pub fn start(&self, host: Host) -> u64 {
        let [simulator, autopilot, streamer, operator] = self.starts;
        match host {
            Host::Simulator(Vehicle::Ours) => simulator,
            Host::Autopilot(Vehicle::Ours) => autopilot,
            Host::Streamer if self.streams => streamer,
            Host::Streamer => NEVER,
            Host::Operator => operator,
            Host::Simulator(Vehicle::Other) | Host::Autopilot(Vehicle::Other) => {
                self.other_from.unwrap_or(NEVER)
            }
        }
    }

    /// How far the clocks of two hosts differ at most [s].
    pub fn clocks_differ_s(&self) -> f64 {
        let [first, ..] = self.clocks_us;
        let (least, most) = self.clocks_us.iter().fold((first, first), |(a, b), c| (a.min(*c), b.max(*c)));
        (most - least) as f64 * 1e-6
    }

    /// Wall time [us] at about a simulated time [s].
    pub fn wall(&self, t_s: f64) -> u64 {
        let [simulator, autopilot, ..] = self.starts;
        // It tries to connect every 250 ms.
        let tries = simulator.saturating_sub(autopilot).div_ceil(250_000);
        autopilot + tries * 250_000 + 100 + (t_s / self.speed * 1e6) as u64
    }

    /// Simulated time at about which the last stall, or what is held up, ends [s].
    pub fn stall_ends_s(&self) -> f64 {
        let ends = self.acts.iter().filter_map(|(at, act)| match act {
            Act::Stall(_, long_us) | Act::HoldUp(_, long_us) => Some(at + long_us),
            _ => None,
        });
        let last = ends.max().unwrap_or(0);
        last.saturating_sub(self.wall(0.0)) as f64 * 1e-6 * self.speed
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
            Kind::Stalled => self.stall(dice),
            Kind::Lossy => {
                let wire = Wire {
                    loss: dice.between(0.0, 0.4),
                    doubled: dice.between(0.0, 0.4),
                    jitter_us: dice.between(0.0, 40e3) / self.speed,
                };
                self.wire = wire;
            }
            // Ours has been met; before its modes and arming as a rule.
            Kind::Twin => self.other_from = Some(self.wall(dice.between(0.3, 4.0))),
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
            Kind::Doors => self.knock(dice),
            Kind::Held => self.hold(dice),
            Kind::Keyless => self.keyless(dice),
            Kind::PlayedAgain => self.play_again(dice),
            Kind::Clocks => self.shift_clocks(dice),
            Kind::Broken => {
                for _ in 0..1 + dice.below(3) {
                    let at = self.wall(dice.between(0.0, 9.0));
                    let host = PARTIES[dice.below(3)];
                    let long_us = (dice.between(0.0, 4.0) / self.speed * 1e6) as u64;
                    let act = match dice.below(4) {
                        0 => Act::Restart { host, killed: true },
                        1 => Act::Stall(host, long_us),
                        2 => Act::HoldUp(host, long_us),
                        _ => Act::CutOff(host, long_us),
                    };
                    self.act(at, act);
                }
            }
            Kind::Mad => {
                let at = self.wall(dice.between(0.5, 9.0));
                self.act(at, Act::Toggle(2_000 + dice.below(3_000)));
            }
            Kind::Rewound => {
                let at = self.wall(dice.between(0.5, 9.0));
                self.act(at, Act::Rewind(1 + dice.below(3_000)));
                let asked = self.wall(0.2);
                self.act(asked, Act::Send(50_010, ports::GROUND, frames::every_microsecond()));
            }
            Kind::Ahead => self.run_ahead(dice),
            Kind::Flooded => self.flood(dice),
            Kind::Wordy => {
                for _ in 0..1 + dice.below(20) {
                    let at = self.wall(dice.between(2.0, 9.0));
                    let pieces = frames::endless_text(1 + dice.below(20));
                    self.act(at, Act::Send(ports::AUTOPILOT_API, ports::API, pieces));
                }
            }
            Kind::Storm => {
                let one = |dice: &mut Stream| KINDS[1 + dice.below(STORMY)];
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

    /// The streamer is not scheduled from its start, or from first contact, on; or somebody on the way to it
    /// is not, as a router or a proxy may.
    fn stall(&mut self, dice: &mut Stream) {
        let long_us = (dice.between(0.5, 3.5) / self.speed * 1e6) as u64;
        let [.., streamer, _] = self.starts;
        let met_us = self.wall(0.0);
        let act = [Act::Stall, Act::HoldUp][dice.below(2)];
        let (at, for_us) = match dice.below(2) {
            0 => (streamer, met_us.saturating_sub(streamer) + long_us),
            _ => (met_us + dice.below(60_000) as u64, long_us),
        };
        self.act(at, act(Host::Streamer, for_us));
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

    /// Forty TCP clients that say nothing, or half a frame, and dial again once a second; the operator comes
    /// by TCP too.
    fn knock(&mut self, dice: &mut Stream) {
        self.speed = 1.0;
        self.operator_by_tcp = true;
        self.signed = dice.below(2) == 0;
        let from = self.starts[1] + 1_000;
        self.starts[3] = from + dice.below(2_000_000) as u64;
        for second in 0..9 {
            for i in 0..40 {
                let at = from + second * 1_000_000 + u64::from(i);
                self.dial(dice, at, 53_000 + second as u16 * 40 + i);
            }
        }
    }

    /// A stranger's connection, and what comes by it.
    fn dial(&mut self, dice: &mut Stream, at: u64, from: Address) {
        self.act(at, Act::Call(from, Call::Dial));
        let beat = frames::station_heartbeat(66);
        let said = match dice.below(3) {
            0 => return,
            1 => beat[..9].to_vec(),
            // Whoever speaks without a key is as good as anybody.
            _ if self.signed => beat,
            _ => b"GET / HTTP/1.1".to_vec(),
        };
        self.act(at + 1_000, Act::Call(from, Call::Say(said)));
    }

    /// Strangers without the key: forty at every door, with HEARTBEATs and the RADIO_STATUS that needs no
    /// signature; and whatever misleads or meddles, also before the vehicle has been met.
    fn keyless(&mut self, dice: &mut Stream) {
        (self.signed, self.speed) = (true, 1.0);
        self.operator_by_tcp = dice.below(2) == 0;
        self.starts[3] = 400_000 + dice.below(2_000_000) as u64;
        for second in 0..5 {
            for i in 0..40 {
                let at = 310_000 + second * 2_000_000 + u64::from(i) * 11;
                let stranger = 51_000 + i;
                for to in [ports::GROUND, ports::AUTOPILOT_API, ports::PARACHUTE, ports::API] {
                    let bytes = if dice.below(2) == 0 {
                        frames::radio_status()
                    } else {
                        frames::station_heartbeat(66)
                    };
                    self.act(at, Act::Send(stranger, to, bytes));
                }
                self.dial(dice, at, 53_000 + second as u16 * 40 + i);
            }
        }
        for _ in 0..1 + dice.below(6) {
            let at = self.wall(dice.between(0.0, 9.0));
            self.act(at, Act::Send(50_000, ports::API, frames::misleading(dice)));
            let (to_parachute, bytes) = frames::meddling(dice);
            let to = if to_parachute { ports::PARACHUTE } else { ports::GROUND };
            self.act(at, Act::Send(50_010, to, bytes));
        }
        for k in 0..3 {
            self.act(4_000_000 + k * 1_500_000, Act::Wish(Wish::Parachute));
        }
    }

    /// A party is started anew, and what had come to it is played again, at once and later.
    fn play_again(&mut self, dice: &mut Stream) {
        self.signed = true;
        let host = PARTIES[dice.below(3)];
        let at = self.wall(dice.between(0.5, 9.0));
        self.act(at, Act::Restart { host, killed: dice.below(2) == 0 });
        for after_us in [100, 2_000 + dice.below(3_000_000) as u64] {
            self.act(at + after_us, Act::PlayAgain { host, disguised: dice.below(2) == 0 });
        }
    }

    /// Somebody with the key is 70 s to 23 h ahead, at every port; the operator, whose clock is right, comes
    /// later, and wants something.
    fn run_ahead(&mut self, dice: &mut Stream) {
        (self.signed, self.speed) = (true, 1.0);
        self.starts[3] = 2_000_000 + dice.below(1_000_000) as u64;
        let ahead_us = dice.between(70e6, 23.0 * 3_600e6) as u64;
        for to in [ports::GROUND, ports::AUTOPILOT_API, ports::PARACHUTE, ports::API] {
            for second in 0..3 {
                let at = 400_000 + second * 500_000 + dice.below(400_000) as u64;
                self.act(at, Act::Ahead(to, ahead_us));
            }
        }
        for k in 0..3 {
            self.act(5_000_000 + k * 1_500_000, Act::Wish(Wish::Parachute));
        }
    }

    /// Every 50 to 150 ms most of what a socket holds, at one port or another; the operator wants something.
    fn flood(&mut self, dice: &mut Stream) {
        self.speed = 1.0;
        let mut at = 300_000;
        while at < 9_500_000 {
            let to = [ports::GROUND, ports::AUTOPILOT_API, ports::PARACHUTE, ports::API][dice.below(4)];
            self.act(at, Act::Flood { to, datagrams: 100 + dice.below(100) });
            at += 50_000 + dice.below(100_000) as u64;
        }
        for k in 0..4 {
            self.act(4_000_000 + k * 1_300_000, Act::Wish(Wish::Parachute));
        }
    }

    /// Clocks that differ by less than a minute, or one that is minutes or days off; and a stamp from the end
    /// of time.
    fn shift_clocks(&mut self, dice: &mut Stream) {
        self.signed = true;
        match dice.below(3) {
            0 => {
                let off_us = [200e6, 86_400e6 * 2.0][dice.below(2)];
                let way = [-1.0, 1.0][dice.below(2)];
                self.clocks_us[dice.below(4)] = (way * dice.between(1.0, 2.0) * off_us) as i64;
            }
            _ => self.clocks_us = self.clocks_us.map(|_| dice.between(-25e6, 25e6) as i64),
        }
        for to in [ports::GROUND, ports::AUTOPILOT_API, ports::PARACHUTE, ports::API] {
            let at = self.wall(dice.between(0.0, 9.0));
            self.act(at, Act::FarStamp(to));
        }
    }
}

/// Parties that may be started anew.
const PARTIES: [Host; 3] = [Host::Simulator(Vehicle::Ours), Host::Autopilot(Vehicle::Ours), Host::Streamer];
