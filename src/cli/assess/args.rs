//! What can be typed after `samara assess`.

use std::path::PathBuf;

use clap::builder::ArgPredicate;
use clap::parser::ValueSource;
use clap::{ArgGroup, ArgMatches, Args, Command, FromArgMatches};

use crate::cli::answer::Failure;
use crate::cli::args::{PageArgs, whole};
use crate::cli::study::args::{StudyArgs, WireArgs};
use crate::cli::study::options::{options, values};
use samara::study::campaign::settings::OWN;
use samara::study::settings::Values;

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

/// The mission of `--paper` where none is named.
pub const PAPER: &str = "titan_paper";

/// Settings of campaigns, by their table.
#[derive(Clone, Debug)]
pub struct SettingsArgs {
    /// Their values.
    pub values: Values,
    /// Names of those that were typed.
    pub typed: Vec<&'static str>,
}

impl Args for SettingsArgs {
    fn augment_args(command: Command) -> Command {
        command.args(options(OWN))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SettingsArgs {
    fn from_arg_matches(typed: &ArgMatches) -> Result<Self, clap::Error> {
        let is_typed = |name: &&str| typed.value_source(name) == Some(ValueSource::CommandLine);
        let names = OWN.iter().map(|setting| setting.name);
        Ok(Self { values: values(OWN, typed)?, typed: names.filter(is_typed).collect() })
    }

    fn update_from_arg_matches(&mut self, typed: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(typed)?;
        Ok(())
    }
}

/// What is done instead of a mission's own campaigns: one of these at most.
const MODE: &str = "mode";

/// `samara assess`.
#[derive(Args, Debug)]
#[group(skip)]
#[command(
    group = ArgGroup::new(MODE).multiple(false),
    mut_arg("mission", |arg| arg.default_value_if("paper", ArgPredicate::IsPresent, PAPER)),
    mut_arg("autopilot", |arg| {
        let help = "Fly whole drops: by reference, px4=DIR or px4-model[=VERSION]";
        let more = "From the canopy to the end: by samara's own autopilot, by PX4 from its build folder, or by \
                    the model of PX4's control law.";
        arg.help(help).long_help(format!("{help}\n\n{more}"))
    }),
    mut_arg("keep", |arg| arg.conflicts_with_all(["only", "effects", "envelope", "replan", "free_fall"])),
    mut_arg("threads", |arg| arg.hide_short_help(true)),
)]
#[cfg_attr(feature = "shards", command(
    mut_arg("shard", |arg| arg.conflicts_with("only")),
    mut_arg("describe", |arg| arg.conflicts_with("only")),
))]
pub struct AssessArgs {
    /// What every study has.
    #[command(flatten)]
    pub study: StudyArgs,
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
    /// What campaigns are asked.
    #[command(flatten)]
    pub settings: SettingsArgs,
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
    /// Pages of flights whose files are kept.
    #[command(flatten)]
    pub page: PageArgs,
    /// What flies whole drops.
    #[command(flatten)]
    pub wire: WireArgs,
    /// Send the plan's acceleration with its velocity.
    #[arg(long, help_heading = "Autopilot")]
    pub feed_forward: bool,
}

impl AssessArgs {
    /// Refuses options that would change nothing here. (The parser's own `requires` is silent where what is
    /// required conflicts with something else that was typed.)
    pub fn refuse_idle(&self) -> Result<(), Failure> {
        let (autopilot, alone) = ("--autopilot", "--only K");
        let by_autopilot = self.wire.autopilot.is_some();
        let needs = [
            ("--unknowns", self.unknowns, "--rare", self.rare.is_some()),
            ("--per-level", self.per_level.is_some(), "--rare", self.rare.is_some()),
            ("--rays", self.rays.is_some(), "--envelope", self.envelope.is_some()),
            ("--repeat", self.repeat.is_some(), alone, matches!(self.only, Some(Only::Trial(_)))),
            ("--repeat", self.repeat.is_some(), autopilot, by_autopilot),
            ("--feed-forward", self.feed_forward, autopilot, by_autopilot),
            ("--instance", self.wire.instance != 0, autopilot, by_autopilot),
            ("--estimator", self.wire.state.asked(), autopilot, by_autopilot),
            ("--patience", self.wire.patience.asked(), autopilot, by_autopilot),
            ("--gains px4_default", self.study.choice.px4s_own_gains(), autopilot, by_autopilot),
        ];
        match needs.into_iter().find(|(_, asked, _, there)| *asked && !there) {
            Some((option, _, needed, _)) => {
                Err(Failure::input(format!("{option}: {needed} is expected with it")))
            }
            None => Ok(()),
        }
    }
}
