//! What can be typed of any study.

use clap::Args;

use crate::cli::args::{
    AutopilotArg, ChoiceArgs, MissionArgs, ParentArgs, PatienceArgs, StateArgs, autopilot, instance, whole,
};
use crate::cli::pilot::px4::{Cpu, Patience};
use crate::cli::pilot::{PilotOption, PilotRequest, Px4Settings};
use crate::cli::terminal::print_err;
#[cfg(feature = "shards")]
use samara::study::cut::Cut;

/// What every study has.
#[derive(Args, Clone, Debug)]
pub struct StudyArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Go on with the study that was stopped, or killed, in the folder.
    ///
    /// Of the same inputs, seed and options: it ends in the bytes in which it would have ended.
    #[arg(long)]
    pub resume: bool,
    /// A part of the study.
    #[cfg(feature = "shards")]
    #[command(flatten)]
    pub part: PartArgs,
    /// Threads to fly on; the results do not depend on it [default: one for each core].
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256))]
    pub threads: Option<u16>,
    /// Whose end is this process's end.
    #[command(flatten)]
    pub parent: ParentArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
}

/// A part of a study.
#[cfg(feature = "shards")]
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Parts of a study")]
pub struct PartArgs {
    /// Fly part I of N of the jobs at hand, I from 0 to N-1, to a file in --out.
    ///
    /// To DIR/shards, by any number of processes on any machines; a part that is there is not flown again.
    /// `samara merge DIR` puts them together, or says which are missing: a study of several rounds goes on
    /// when all parts of one are there.
    #[arg(long, value_name = "I/N", value_parser = str::parse::<Cut>, requires = "out", conflicts_with = "resume")]
    pub shard: Option<Cut>,
    /// Fly the part only if it is one of the study of this ID, as --describe prints it.
    #[arg(long, value_name = "ID", hide_short_help = true, requires = "shard")]
    pub campaign: Option<String>,
    /// Print as JSON which study this is, and fly nothing.
    ///
    /// With --out it is noted there, as the first shard does.
    #[arg(long, hide_short_help = true, conflicts_with_all = ["resume", "shard"])]
    pub describe: bool,
}

#[cfg(feature = "shards")]
impl PartArgs {
    /// Whether a part is asked for, or which study it would be of.
    pub fn asks(&self) -> bool {
        self.shard.is_some() || self.describe
    }
}

/// What flies the drops of a study over a wire.
#[derive(Args, Clone, Debug)]
pub struct WireArgs {
    /// Fly over the wire: by reference or px4=DIR.
    #[arg(long, help_heading = "Autopilot", value_name = "AUTOPILOT", value_parser = autopilot)]
    pub autopilot: Option<AutopilotArg>,
    /// What the autopilot flies by, with --autopilot.
    #[command(flatten)]
    pub state: StateArgs,
    /// Number of the first vehicle, with --autopilot; those side by side have the next.
    #[arg(long, help_heading = "Autopilot", value_name = "0..9", default_value_t = 0, value_parser = instance, hide_short_help = true)]
    pub instance: u16,
    /// How long PX4 may keep a flight waiting.
    #[command(flatten)]
    pub patience: PatienceArgs,
    /// Whether the plan's acceleration is sent with its velocity.
    #[arg(skip)]
    pub feed_forward: bool,
}

impl WireArgs {
    /// What is asked of the autopilot, which renews its plans where `replan` says so. `answers`: PX4 is
    /// waited for no longer than its patience for an answer, too.
    pub fn pilot<'a>(
        &'a self,
        autopilot: &'a AutopilotArg,
        args: &'a StudyArgs,
        (replan, answers): (bool, bool),
    ) -> PilotRequest<'a> {
        let patience = Patience { limit: self.patience.limit(), answers };
        PilotRequest {
            board: None,
            autopilot,
            mission: &args.mission.mission,
            choice: &args.choice,
            state: &self.state,
            feed_forward: self.feed_forward,
            settings: Px4Settings { cpu: Cpu::Together, patience },
            options: PilotOption::asked([
                (PilotOption::Replan, replan),
                (PilotOption::Estimator, self.state.asked()),
                (PilotOption::Patience, self.patience.asked()),
                (PilotOption::Px4sOwnGains, args.choice.px4s_own_gains()),
            ]),
        }
    }
}

/// The choices, but for gains in place of the mission's own.
pub fn without_gains(choice: &ChoiceArgs) -> ChoiceArgs {
    ChoiceArgs { gains: None, params: None, ..choice.clone() }
}

/// Says which spelling is the new one of what was typed.
pub fn now_spelt(old: &str, new: &str) {
    print_err(&format!("samara: {old} is now: {new}\n"));
}
