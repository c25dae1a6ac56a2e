//! What can be typed after `samara drop`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{
    AutopilotArg, CHOICES, ChoiceArgs, LinkArgs, MissionArgs, NetArgs, PageArgs, PatienceArgs, PlanningArgs,
    StateArgs, autopilot, speed,
};
use crate::cli::live::LiveArgs;
use crate::cli::pilot::px4::{Cpu, Patience};
use crate::cli::pilot::{PilotOption, PilotRequest, Px4Settings};
use samara::link::shell::{SerialUrl, Speed};
use samara::replan::Cadence;

/// `samara drop`.
#[derive(Args, Debug)]
pub struct DropArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// How much to show of the planning.
    #[command(flatten)]
    pub planning: PlanningArgs,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
    /// The page while it flies.
    #[command(flatten)]
    pub live: LiveArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// The pilot: reference, px4=DIR or px4-model[=VERSION].
    ///
    /// samara's own autopilot; PX4 from the build folder of its simulation; or the model of PX4's control
    /// law, which predicts what PX4 will do.
    #[arg(
        long,
        value_name = "AUTOPILOT",
        default_value = "reference",
        value_parser = autopilot,
        help_heading = "Autopilot"
    )]
    pub autopilot: AutopilotArg,
    /// What the autopilot flies by.
    #[command(flatten)]
    pub state: StateArgs,
    /// Fly this trajectory instead of planning one.
    #[arg(long, value_name = "FILE", help_heading = CHOICES)]
    pub trajectory: Option<PathBuf>,
    /// Renew the plan during the drop: at the `release`, or from it on at a rate [Hz].
    ///
    /// From the vehicle's telemetry, with the plan's acceleration fed forward; by the gains that the mission
    /// has for it (`replan.gains`), unless others are chosen.
    #[arg(long, value_name = "release|HZ", conflicts_with = "trajectory", help_heading = CHOICES)]
    pub replan: Option<Cadence>,
    /// Fly each release case of the mission, into a folder of its own.
    ///
    /// Table 3 of the paper. Beside PX4 the reference autopilot flies them too.
    #[arg(long, conflicts_with = "case", help_heading = CHOICES)]
    pub cases: bool,
    /// Send the plan's acceleration with its velocity.
    ///
    /// As `control.feed_forward` of the mission does.
    #[arg(long, help_heading = "Autopilot")]
    pub feed_forward: bool,
    /// The processor that PX4 runs on.
    ///
    /// All of PX4 is fastest on one. `auto`: on one, another for each instance, and the simulator beside it
    /// on the others; a number: both on that one; `any`: wherever the system puts them.
    #[arg(
        long,
        value_name = "auto|any|N",
        default_value = "auto",
        value_parser = cpu,
        help_heading = "Autopilot",
        hide_short_help = true
    )]
    pub cpu: Cpu,
    /// How long PX4 may keep the flight waiting.
    #[command(flatten)]
    pub patience: PatienceArgs,
    /// Simulated seconds per second: a factor opens the links.
    ///
    /// With a factor the drop can be watched: the links for ground stations (UDP 14550), companions (14540 +
    /// instance) and the parachute are open.
    #[arg(long, value_name = "FACTOR|max", default_value = "max", value_parser = speed, help_heading = "Links")]
    pub speed: Speed,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Further endpoints, where --speed is a factor.
    #[command(flatten)]
    pub link: LinkArgs,
    /// Fly a board with PX4 on this line, in real time: docs/serial.md.
    ///
    /// Hardware in the loop, PROPELLERS OFF: PX4 with SYS_HITL 1 on a USB port or UART, such as
    /// /dev/ttyACM0 or /dev/ttyUSB0:921600 (the default rate; USB has its own). Ground stations (UDP
    /// 14550) and companions (14540 + instance) reach it through here.
    #[arg(long, value_name = "DEV[:BAUD]", conflicts_with_all = ["autopilot", "cases"], help_heading = "Links")]
    pub serial: Option<SerialUrl>,
}

impl DropArgs {
    /// The pilot that is asked for.
    pub fn pilot(&self) -> PilotRequest<'_> {
        PilotRequest {
            autopilot: &self.autopilot,
            board: self.serial.as_ref(),
            mission: &self.mission.mission,
            choice: &self.choice,
            state: &self.state,
            feed_forward: self.feed_forward,
            settings: Px4Settings {
                cpu: self.cpu,
                patience: Patience { limit: self.patience.limit(), answers: self.cases },
            },
            options: PilotOption::asked([
                (PilotOption::Estimator, self.state.asked()),
                (PilotOption::Link, !self.link.links.is_empty()),
                (PilotOption::SignKey, self.net.sign_key.is_some()),
                (PilotOption::Speed, self.speed != Speed::Max),
                (PilotOption::Cpu, self.cpu != Cpu::Apart),
                (PilotOption::Patience, self.patience.asked()),
                (PilotOption::Px4sOwnGains, self.choice.px4s_own_gains()),
                (PilotOption::Replan, self.replan.is_some()),
            ]),
        }
    }

    /// What does not touch the flight but shows in the .tlog files: the vehicle's number, and that others may
    /// have taken part.
    pub fn circumstances(&self) -> Vec<(&'static str, String)> {
        let mut circumstances = vec![("instance", self.net.instance.to_string())];
        if let Speed::Factor(factor) = self.speed {
            circumstances.push(("speed", format!("{factor:?}")));
        }
        circumstances
    }
}

/// The value of `--cpu`.
fn cpu(text: &str) -> Result<Cpu, String> {
    match text {
        "auto" => Ok(Cpu::Apart),
        "any" => Ok(Cpu::Any),
        number => number
            .parse()
            .map(Cpu::Number)
            .map_err(|_| "`auto`, `any` or the number of a processor is expected".to_owned()),
    }
}
