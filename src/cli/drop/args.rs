//! What can be typed after `samara drop`.

use std::path::PathBuf;

use clap::Args;

use crate::cli::args::{
    AutopilotArg, ChoiceArgs, LinkArgs, MissionArgs, NetArgs, PatienceArgs, PlanningArgs, StateArgs,
    autopilot, speed,
};
use crate::cli::pilot::px4::{Cpu, Patience};
use crate::cli::pilot::{PilotOption, PilotRequest, Px4Settings};
use samara::link::shell::Speed;

/// The help of `samara drop`.
pub const DROP_HELP: &str = "\
Writes to the folder of --out: flight.csv (every term of the force balance at 250 Hz), trajectory.csv (what was flown), plan.json and
plan.svg (unless --trajectory was given), drop.json (the verdict), drop.svg, flight.ulg (the autopilot's log, as PX4 writes it),
vehicle.tlog (the link of ground stations), companion.tlog (that of the streamer and the parachute), hil.tlog (simulator and
autopilot) and drop_manifest.json (inputs, options, SHA-256 of each file).

JSON (--json): mission, version, seed, input_hash, gains, autopilot (reference, reference_ekf, px4 or px4-model), autopilot_version
(PX4's, as it tells it, or null), trajectory (source: planned or file; sha256 of trajectory.csv), completed (to the end of mission and
plan, by an autopilot that did not leave or refuse), ended_at_s, reason (why it was not completed or never released, or \"not steady\",
or null), j_tpf, decided_by (the quantity that J_TPF is the share of), peak_speed_m_s, peak_pitch_deg,
peak_pitch_rate_deg_s, peak_roll_deg, peak_roll_rate_deg_s, peak_vertical_acceleration_m_s2, altitude_lost_m (from the
release to the plan's end), steady_after_s (null if never), final_v_ned_m_s, limits_passed (list), failsafe (whether one flew part of the manoeuvre), events (list of t_s, text),
plan_j_tpf, plan_solve_ms, real_time_factor, and impact_speed_m_s if it came to the ground. Peaks are magnitudes here; the table on the terminal gives them their signs. When the
vehicle was never released the verdict's keys are null; when no plan was found the object is that of `samara plan --json`. Roll and
roll rate are judged against the limits of pitch and pitch rate.

With --cases each drop's files are in <case>/px4 or <case>/reference, the table in cases.csv, all objects in cases.json; the JSON object
has `cases`, a list of case, autopilot, drop.

Exit code 1 when a limit was passed, a failsafe flew, steady flight was not reached, the plan did not converge, the vehicle was never
released, PX4 left, refused or never came, or the mission was stopped (Ctrl-C) before its end or ended before the plan.

Examples:
  samara drop
  samara drop --gains paper_pso
  samara drop --params params/px4/titan_samara.params
  samara drop --estimator ekf mission/x500_drop.json
  samara drop --speed 1          (watch it in QGroundControl)
  samara drop mission/x500_drop.json --out /tmp/x500
  samara drop mission/x500_drop.json --autopilot px4=../PX4-Autopilot/build/px4_sitl_default
  samara drop mission/titan_px4.json --cases --autopilot px4=../PX4-Autopilot/build/px4_sitl_default
  samara drop mission/x500_drop.json --autopilot px4-model --gains x500
  samara drop --trajectory out/titan_drop/trajectory.csv --json";

/// `samara drop`.
#[derive(Args, Debug)]
pub struct DropArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// The autopilot that flies: samara's own; PX4 from the build folder of its simulation; or the model of
    /// PX4's control law, which predicts what PX4 will do.
    #[arg(long, value_name = "reference|px4=DIR|px4-model", default_value = "reference", value_parser = autopilot)]
    pub autopilot: AutopilotArg,
    /// What the autopilot flies by.
    #[command(flatten)]
    pub state: StateArgs,
    /// Fly this trajectory instead of planning one.
    #[arg(long, value_name = "FILE")]
    pub trajectory: Option<PathBuf>,
    /// Fly each release case of the mission (Table 3), into a folder of its own; beside PX4 the reference
    /// autopilot flies them too.
    #[arg(long, conflicts_with = "case")]
    pub cases: bool,
    /// Send the plan's acceleration with its velocity, to PX4.
    #[arg(long)]
    pub feed_forward: bool,
    /// Where PX4 runs: all of it is fastest on one processor. `auto`: on one, another for each instance, and
    /// the simulator beside it on the others; a number: both on that one; `any`: wherever the system puts
    /// them.
    #[arg(long, value_name = "auto|any|N", default_value = "auto", value_parser = cpu)]
    pub cpu: Cpu,
    /// How long PX4 may keep the flight waiting.
    #[command(flatten)]
    pub patience: PatienceArgs,
    /// How much to show of the planning.
    #[command(flatten)]
    pub planning: PlanningArgs,
    /// Simulated seconds per second, or `max`. With a factor the drop can be watched: the links for ground
    /// stations (UDP 14550), companions (14540 + instance) and the parachute are open.
    #[arg(long, value_name = "FACTOR|max", default_value = "max", value_parser = speed)]
    pub speed: Speed,
    /// Ports.
    #[command(flatten)]
    pub net: NetArgs,
    /// Further endpoints, where --speed is a factor.
    #[command(flatten)]
    pub link: LinkArgs,
}

impl DropArgs {
    /// The pilot that is asked for.
    pub fn pilot(&self) -> PilotRequest<'_> {
        PilotRequest {
            autopilot: &self.autopilot,
            mission: &self.mission.mission,
            choice: &self.choice,
            state: &self.state,
            settings: Px4Settings {
                feed_forward: self.feed_forward,
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
                (PilotOption::FeedForward, self.feed_forward),
                (PilotOption::Px4sOwnGains, self.choice.px4s_own_gains()),
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
