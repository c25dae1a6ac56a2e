//! What can be typed after `samara assess`.

use std::path::PathBuf;

use clap::builder::ArgPredicate;
use clap::{ArgGroup, Args};

use crate::cli::answer::Failure;
use crate::cli::args::{
    AutopilotArg, ChoiceArgs, MissionArgs, PageArgs, ParentArgs, PatienceArgs, StateArgs, autopilot,
    instance, whole,
};
use crate::cli::pilot::px4::{Cpu, Patience};
use crate::cli::pilot::{PilotOption, PilotRequest, Px4Settings};
#[cfg(feature = "shards")]
use crate::cli::study::args::PartArgs;
use crate::cli::study::args::StudyArgs;
use samara::config::Mission;
use samara::study::campaign::Keep;
#[cfg(feature = "shards")]
use samara::study::cut::Cut;
use samara::study::rare::bound;

/// What `--only` flies again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Only {
    /// The trial of this number.
    Trial(u64),
    /// The failure that `--rare` wrote to this file.
    Failure(PathBuf),
}

fn only(text: &str) -> Result<Only, String> {
    if text.ends_with(".json") {
        return Ok(Only::Failure(text.into()));
    }
    let trial = whole::<u64>(0..=u64::MAX)(text);
    trial.map(Only::Trial).map_err(|expected| format!("{expected}, or the rare_failure.json of --rare"))
}

#[cfg(feature = "shards")]
/// A part of a campaign.
#[derive(Args, Debug)]
#[command(next_help_heading = "Parts of a campaign")]
pub struct ShardArgs {
    /// Fly part I of N alone, I from 0 to N-1, to a file in --out.
    ///
    /// The same trials as in the whole campaign, to DIR/shards/<I>-of-<N>.parquet, by any number of processes
    /// on any machines; a part that is there is not flown again. `samara merge DIR` puts them together.
    #[arg(
        long,
        value_name = "I/N",
        value_parser = str::parse::<Cut>,
        requires = "out",
        group = MODE,
        conflicts_with_all = ["only", "resume"]
    )]
    pub shard: Option<Cut>,
    /// Fly the part only if it is one of the campaign of this ID, as --describe prints it.
    ///
    /// Another version, mission, seed or option is refused before anything is flown.
    #[arg(long, value_name = "ID", value_parser = campaign_id, hide_short_help = true)]
    pub campaign: Option<String>,
    /// Print as JSON which campaign this is, and fly nothing.
    ///
    /// With its ID, which --campaign takes, and the arguments that fly it anywhere.
    #[arg(long, hide_short_help = true, group = MODE, conflicts_with_all = ["only", "resume"])]
    pub describe: bool,
}

#[cfg(feature = "shards")]
fn campaign_id(text: &str) -> Result<String, String> {
    let fits = text.len() == 64 && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
    fits.then(|| text.to_owned()).ok_or_else(|| {
        "64 hexadecimal digits are expected, `campaign` of `samara assess .. --describe`".to_owned()
    })
}

fn keep(text: &str) -> Result<Keep, String> {
    match text {
        "all" => Ok(Keep::All),
        "failures" => Ok(Keep::Failures),
        "summary" => Ok(Keep::Summary),
        _ => Err("`all`, `failures` or `summary` is expected".to_owned()),
    }
}

/// The mission of `--paper` where none is named.
pub const PAPER: &str = "titan_paper";

/// J_TPF that a safe trial stays below, unless it is said otherwise.
pub const BOUND: f64 = 1.0;

/// What is done instead of a mission's own campaigns: one of these at most.
const MODE: &str = "mode";

/// `samara assess`.
#[derive(Args, Debug)]
#[group(skip)]
#[command(
    group = ArgGroup::new(MODE).multiple(false),
    mut_arg("mission", |arg| arg.default_value_if("paper", ArgPredicate::IsPresent, PAPER))
)]
pub struct AssessArgs {
    /// Mission, folder, output form.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// Fly the paper's own study, with its results beside ours.
    ///
    /// The mission is titan_paper unless one is named, such as titan_paper_second, which reads the paper's
    /// control law in another way.
    #[arg(long, group = MODE, conflicts_with_all = ["autopilot"])]
    pub paper: bool,
    /// Now `samara study effects`.
    #[arg(long, hide = true, group = MODE, conflicts_with_all = ["autopilot", "only", "bound"])]
    pub effects: bool,
    /// Now `samara study envelope --pairs PAIRS`.
    #[arg(
        long,
        hide = true,
        value_name = "PAIRS",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "all",
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "bound", "trials"]
    )]
    pub envelope: Option<String>,
    /// Now `samara study envelope --rays N`.
    #[arg(long, hide = true, value_name = "N")]
    pub rays: Option<String>,
    /// Now `samara study replan --when WHEN`.
    #[arg(
        long,
        hide = true,
        value_name = "WHEN",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "release,1",
        group = MODE,
        conflicts_with_all = ["only", "bound", "feed_forward"]
    )]
    pub replan: Option<String>,
    /// Now `samara study free-fall --hours HOURS`.
    #[arg(
        long,
        hide = true,
        value_name = "HOURS",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "20",
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "bound", "params", "case"]
    )]
    pub free_fall: Option<String>,
    /// Now `samara study rare --least P`.
    #[arg(
        long,
        hide = true,
        value_name = "P",
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "keep", "trials"]
    )]
    pub rare: Option<String>,
    /// Now `samara study sobol --points N`.
    #[arg(
        long,
        hide = true,
        value_name = "N",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "2048",
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "keep", "trials", "bound"]
    )]
    pub sobol: Option<String>,
    /// Now `samara study rare --unknowns`.
    #[arg(long, hide = true)]
    pub unknowns: bool,
    /// Now `samara study rare --per-level N`.
    #[arg(long, hide = true, value_name = "N")]
    pub per_level: Option<String>,
    /// Trials of each campaign.
    ///
    /// Instead of the mission's `monte_carlo.trials`.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(2..=1_000_000_000))]
    pub trials: Option<u64>,
    /// J_TPF that a safe trial stays below.
    #[arg(long, value_name = "B", default_value_t = BOUND, value_parser = bound)]
    pub bound: f64,
    /// Go on with what was stopped, or killed, in the folder.
    ///
    /// Campaigns of the same inputs, seed and options, also to more --trials.
    #[arg(long)]
    pub resume: bool,
    /// Lines to keep of the trials: `all`, those of `failures`, or none.
    ///
    /// `summary` keeps the statistics alone: quantiles to half a bin (docs/clusters.md), and nothing to go on
    /// from. [default: all, of more than 1000000 trials summary]
    #[arg(long, value_name = "LINES", value_parser = keep, conflicts_with_all = ["paper", "only", "effects", "envelope", "replan", "free_fall"])]
    pub keep: Option<Keep>,
    /// Fly trial K alone, with flight log and figures.
    ///
    /// Of each campaign: prints what was drawn and what came of it.
    #[arg(long, value_name = "K|FILE", value_parser = only, conflicts_with_all = ["trials", "resume"])]
    pub only: Option<Only>,
    /// Fly the trial of --only so many times: how alike are they?
    ///
    /// With --autopilot: how far the flights lie apart, by standard deviation and range of J_TPF, of the time
    /// to steady flight and of the position 10 s after t = 0.
    #[arg(
        long,
        value_name = "N",
        value_parser = whole::<u64>(2..=10_000)
    )]
    pub repeat: Option<u64>,
    /// Threads to fly on; the results do not depend on it.
    ///
    /// [default: one for each core; 2 for drops by PX4, and there no more than instances are left]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256), hide_short_help = true)]
    pub threads: Option<u16>,
    /// Pages of flights whose files are kept.
    #[command(flatten)]
    pub page: PageArgs,
    /// A part of the campaign.
    #[cfg(feature = "shards")]
    #[command(flatten)]
    pub part: ShardArgs,
    /// Whose end is this process's end.
    #[command(flatten)]
    pub parent: ParentArgs,
    /// Fly whole drops: by reference, px4=DIR or px4-model[=VERSION].
    ///
    /// From the canopy to the end: by samara's own autopilot, by PX4 from its build folder, or by the model
    /// of PX4's control law.
    #[arg(
        long,
        help_heading = "Autopilot",
        value_name = "AUTOPILOT",
        value_parser = autopilot,
        conflicts_with_all = ["bound"]
    )]
    pub autopilot: Option<AutopilotArg>,
    /// What the autopilot flies by, with --autopilot.
    #[command(flatten)]
    pub state: StateArgs,
    /// Send the plan's acceleration with its velocity.
    #[arg(long, help_heading = "Autopilot")]
    pub feed_forward: bool,
    /// Number of the first vehicle; those side by side have the next.
    ///
    /// With --autopilot.
    #[arg(long, help_heading = "Autopilot", value_name = "0..9", default_value_t = 0, value_parser = instance, hide_short_help = true)]
    pub instance: u16,
    /// How long PX4 may keep a flight waiting.
    #[command(flatten)]
    pub patience: PatienceArgs,
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
}

impl AssessArgs {
    /// What is asked of the autopilot of a campaign of whole drops.
    pub fn pilot<'a>(&'a self, autopilot: &'a AutopilotArg) -> PilotRequest<'a> {
        PilotRequest {
            autopilot,
            mission: &self.mission.mission,
            choice: &self.choice,
            state: &self.state,
            feed_forward: self.feed_forward,
            settings: Px4Settings {
                cpu: Cpu::Together,
                patience: Patience { limit: self.patience.limit(), answers: self.only.is_none() },
            },
            options: self.asked(),
        }
    }

    /// Trials of each campaign.
    pub fn trials_of(&self, mission: &Mission) -> u64 {
        self.trials.unwrap_or(mission.study.monte_carlo.trials as u64)
    }

    /// What is asked of any study, where an old spelling asks for one.
    pub fn study(&self) -> StudyArgs {
        StudyArgs {
            mission: self.mission.clone(),
            choice: self.choice.clone(),
            resume: self.resume,
            threads: self.threads,
            parent: self.parent.clone(),
            #[cfg(feature = "shards")]
            part: PartArgs::default(),
        }
    }

    /// Refuses options that would change nothing here. (The parser's own `requires` is silent where what is
    /// required conflicts with something else that was typed.)
    pub fn refuse_idle(&self) -> Result<(), Failure> {
        let (autopilot, alone) = ("--autopilot", "--only K");
        let needs = [
            ("--unknowns", self.unknowns, "--rare", self.rare.is_some()),
            ("--per-level", self.per_level.is_some(), "--rare", self.rare.is_some()),
            ("--rays", self.rays.is_some(), "--envelope", self.envelope.is_some()),
            ("--repeat", self.repeat.is_some(), alone, matches!(self.only, Some(Only::Trial(_)))),
            ("--repeat", self.repeat.is_some(), autopilot, self.autopilot.is_some()),
            ("--feed-forward", self.feed_forward, autopilot, self.autopilot.is_some()),
            ("--instance", self.instance != 0, autopilot, self.autopilot.is_some()),
            #[cfg(feature = "shards")]
            ("--campaign", self.part.campaign.is_some(), "--shard", self.part.shard.is_some()),
        ];
        match needs.into_iter().find(|(_, asked, _, there)| *asked && !there) {
            Some((option, _, needed, _)) => {
                Err(Failure::input(format!("{option}: {needed} is expected with it")))
            }
            None => Ok(()),
        }
    }

    /// Lines that are kept of so many trials.
    pub fn rows_kept(&self, trials: u64) -> Keep {
        self.keep.unwrap_or_else(|| Keep::usual(trials))
    }

    /// The options asked for that not every autopilot has.
    pub fn asked(&self) -> Vec<PilotOption> {
        PilotOption::asked([
            (PilotOption::Replan, self.replan.is_some() && self.autopilot.is_some()),
            (PilotOption::Estimator, self.state.asked()),
            (PilotOption::Patience, self.patience.asked()),
            (PilotOption::Px4sOwnGains, self.choice.px4s_own_gains()),
        ])
    }
}
