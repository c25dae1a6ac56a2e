//! What is asked step by step as a Python script that streams it in OFFBOARD, with what ends it early.

use samara_core::manoeuvre::{Ask, Kind, Step};
use samara_core::printable::printable;
use samara_core::units::DEG_PER_RAD;

use super::{LOGGING, ManoeuvreReport};

const SCRIPT: &str = include_str!("fly.py");
/// Room around what was flown before a flight is ended early: a share, and lengths [m].
const ROOM: f64 = 1.5;
const ROOM_M: f64 = 10.0;

impl ManoeuvreReport<'_> {
    /// The script; without passes, which a plan flies.
    pub fn script(&self) -> String {
        let mut steps = String::new();
        for (rounds, trial) in self.rounds().filter(|(_, trial)| trial.kind != Kind::Passes) {
            let round: String = trial.kind.round(&trial.sizes).iter().map(line).collect();
            if rounds > 0 {
                steps += &format!("    # {rounds} rounds of: {}.\n    *{rounds} * [\n", trial.kind.words());
                steps += &(round + "    ],\n");
            }
        }
        let most = |of: fn(&samara_core::manoeuvre::Seen) -> f64| {
            self.trials
                .iter()
                .filter(|trial| trial.kind != Kind::Passes)
                .map(|t| of(&t.seen))
                .fold(0.0, f64::max)
        };
        let logging: String = LOGGING.map(|(name, value, _)| format!("    \"{name}\": {value},\n")).concat();
        SCRIPT
            .replace("@VEHICLE@", &printable(self.vehicle).replace(['"', '\\'], "'"))
            .replace("    # @LOGGING@\n", &logging)
            .replace("    # @STEPS@\n", &steps)
            .replace(
                "@TILT_DEG@",
                // Not less: on its way back to its place PX4 tilts as far as MPC_TILTMAX_AIR allows.
                &format!("{:.0}", self.bounds.tilt_rad * DEG_PER_RAD),
            )
            .replace("@AWAY_M@", &format!("{:.0}", ROOM * most(|s| s.away_m) + ROOM_M))
            .replace(
                "@BELOW_M@",
                &format!("{:.0}", (ROOM * most(|s| s.below_m) + 0.3 * ROOM_M).min(self.bounds.below_m)),
            )
            .replace("@ABOVE_M@", &format!("{:.0}", ROOM * most(|s| s.above_m) + ROOM_M))
    }
}

fn line(step: &Step) -> String {
    let asked = match step.ask {
        Ask::Hold => "hold".to_owned(),
        Ask::Velocity([north, east, down], _) => format!("velocity({north:.2}, {east:.2}, {down:.2})"),
        Ask::Attitude(turn, thrust) => {
            let [roll, pitch, yaw] = turn.map(|x| x * DEG_PER_RAD);
            format!("attitude({roll:.2}, {pitch:.2}, {yaw:.2}, {thrust:.3})")
        }
    };
    format!("        ({:.3}, {asked}),\n", step.length_s)
}
