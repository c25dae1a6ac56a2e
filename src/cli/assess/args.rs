//! What can be typed after `samara assess`.

use std::path::PathBuf;

use clap::builder::ArgPredicate;
use clap::{ArgGroup, Args};

use crate::cli::answer::Failure;
use crate::cli::args::{
    AutopilotArg, ChoiceArgs, MissionArgs, PageArgs, ParentArgs, PatienceArgs, StateArgs, autopilot,
    instance, number, whole,
};
use crate::cli::pilot::px4::{Cpu, Patience};
use crate::cli::pilot::{PilotOption, PilotRequest, Px4Settings};
use samara::assess::envelope::EnvelopeAxis;
use samara::assess::rare::{PER_LEVEL, PER_LEVEL_LEAST, PROBABILITY_LEAST};
use samara::config::Mission;
use samara::replan::Cadence;
use samara::report::campaign::Keep;
#[cfg(feature = "shards")]
use samara::report::cut::Cut;

/// The pairs of `--envelope`, in order, none twice.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pairs(pub Vec<[EnvelopeAxis; 2]>);

fn pairs(text: &str) -> Result<Pairs, String> {
    if text == "all" {
        return Ok(Pairs(EnvelopeAxis::pairs()));
    }
    let names = EnvelopeAxis::ALL.map(EnvelopeAxis::name).join(", ");
    let mut pairs: Vec<[EnvelopeAxis; 2]> = Vec::new();
    for pair in text.split(',') {
        let axes = pair.split_once(':').map(|(x, y)| [x, y].map(|name| EnvelopeAxis::named(name.trim())));
        let Some([Some(x), Some(y)]) = axes.filter(|[x, y]| x != y) else {
            return Err(format!(
                "`all`, or pairs of different quantities such as pitch:wind are expected, found `{pair}`; \
                 quantities: {names}"
            ));
        };
        if !pairs.iter().any(|known| known.contains(&x) && known.contains(&y)) {
            pairs.push([x, y]);
        }
    }
    Ok(Pairs(pairs))
}

/// The cadences of `--replan`, in order, none twice.
#[derive(Clone, Debug, PartialEq)]
pub struct Cadences(pub Vec<Cadence>);

fn cadences(text: &str) -> Result<Cadences, String> {
    let mut cadences = Vec::new();
    for cadence in text.split(',') {
        let cadence = cadence.trim().parse()?;
        if !cadences.contains(&cadence) {
            cadences.push(cadence);
        }
    }
    Ok(Cadences(cadences))
}

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

fn rare(text: &str) -> Result<f64, String> {
    let fits = |p: f64| (PROBABILITY_LEAST..=0.1).contains(&p);
    number(text, fits, &format!("a probability from {PROBABILITY_LEAST:e} to 0.1 is expected, such as 1e-6"))
}

fn bound(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x <= 1e6, "a number above 0, up to 1e6, is expected")
}

fn rays(text: &str) -> Result<usize, String> {
    let expected = "a multiple of 4 from 4 to 64 is expected";
    text.parse()
        .ok()
        .filter(|n: &usize| (4..=64).contains(n) && n.is_multiple_of(4))
        .ok_or_else(|| expected.to_owned())
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

/// Directions of each pair of `--envelope`, unless it is said otherwise.
const RAYS: usize = 16;

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
    /// What the mission leaves to choose.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// Fly the paper's own study, with its results beside ours.
    ///
    /// The mission is titan_paper unless one is named, such as titan_paper_second, which reads the paper's
    /// control law in another way.
    #[arg(long, group = MODE, conflicts_with_all = ["autopilot"])]
    pub paper: bool,
    /// Show what each effect that the mission names does.
    ///
    /// Whole drops by its own gains, without a wire: with none of its effects, with each alone, with all,
    /// and with each left out of all.
    #[arg(long, group = MODE, conflicts_with_all = ["autopilot", "only", "bound"])]
    pub effects: bool,
    /// Search how far from the nominal release a drop may begin and be safe.
    ///
    /// Two quantities at a time: `all` pairs, or some with commas between, such as `pitch:wind`. The
    /// quantities are pitch, pitch_rate, descent, delay, wind and turbulence.
    #[arg(
        long,
        value_name = "PAIRS",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "all",
        value_parser = pairs,
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "bound", "trials"]
    )]
    pub envelope: Option<Pairs>,
    /// Directions of each pair of --envelope, a multiple of 4 [default: 16].
    #[arg(long, value_name = "N", value_parser = rays, hide_short_help = true)]
    pub rays: Option<usize>,
    /// Show what it does to renew the plan during the drop.
    ///
    /// When: `release`, once; or a rate [Hz], from the release on; several with commas between. Whole drops
    /// without a wire, or by --autopilot reference, beside those along one plan.
    #[arg(
        long,
        value_name = "WHEN",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "release,1",
        value_parser = cadences,
        group = MODE,
        conflicts_with_all = ["only", "bound", "feed_forward"]
    )]
    pub replan: Option<Cadences>,
    /// Show how well the release is found without a wire.
    ///
    /// By the fall that the accelerometer shows: releases that must be found, and HOURS of descent in
    /// turbulence in which nothing may be, 20 unless they are given.
    #[arg(
        long,
        value_name = "HOURS",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "20",
        value_parser = whole::<u64>(1..=100_000),
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "bound", "params", "case"]
    )]
    pub free_fall: Option<u64>,
    /// Find how rare failures are, down to probability P.
    ///
    /// Subset simulation over everything that is drawn, turbulence's white noise included: the probability
    /// that J_TPF reaches --bound with its interval, or that it is below P, and the most likely failure.
    #[arg(
        long,
        value_name = "P",
        value_parser = rare,
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "keep", "trials"]
    )]
    pub rare: Option<f64>,
    /// Show what decides a drop, of all that is uncertain.
    ///
    /// Sobol's indices of J_TPF, the time to steady flight and the altitude lost, over swing, air and the
    /// controller's unknowns, from two samples of N trials and N more for each quantity, 2048 unless given.
    #[arg(
        long,
        value_name = "N",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "2048",
        value_parser = whole::<usize>(64..=1_000_000),
        hide_short_help = true,
        group = MODE,
        conflicts_with_all = ["autopilot", "only", "keep", "trials", "bound"]
    )]
    pub sobol: Option<usize>,
    /// Draw what is uncertain too, with --rare, where no file has the key `uncertain`.
    ///
    /// Mass, inertia, drag, density, thrust, latency, steady wind, delays: as `samara tune --robust` draws
    /// them. What the mission or its vehicle calls uncertain is always drawn.
    #[arg(long, hide_short_help = true)]
    pub unknowns: bool,
    /// Flights of each level of --rare [default: 6800].
    #[arg(
        long,
        value_name = "N",
        value_parser = whole::<usize>(PER_LEVEL_LEAST as u64..=100_000),
        hide_short_help = true
    )]
    pub per_level: Option<usize>,
    /// Trials of each campaign.
    ///
    /// Instead of the mission's `monte_carlo.trials`; with --effects 1000, with --replan 300, with
    /// --free-fall 10000 unless it is given.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(2..=1_000_000_000))]
    pub trials: Option<u64>,
    /// J_TPF that a safe trial stays below.
    #[arg(long, value_name = "B", default_value_t = BOUND, value_parser = bound)]
    pub bound: f64,
    /// Go on with what was stopped, or killed, in the folder.
    ///
    /// Campaigns or a study of the same inputs, seed and options; a campaign also to more --trials.
    #[arg(long)]
    pub resume: bool,
    /// Lines to keep of the trials: `all`, those of `failures`, or none.
    ///
    /// `summary` keeps the statistics alone: quantiles to half a bin (docs/shards.md), and nothing to go on
    /// from. [default: all, of more than 1000000 trials summary]
    #[arg(long, value_name = "LINES", value_parser = keep, conflicts_with_all = ["paper", "only", "effects", "envelope", "replan", "free_fall"])]
    pub keep: Option<Keep>,
    /// A part of the campaign.
    #[cfg(feature = "shards")]
    #[command(flatten)]
    pub part: ShardArgs,
    /// Whose end is this process's end.
    #[command(flatten)]
    pub parent: ParentArgs,
    /// Fly trial K alone, with flight log and figures.
    ///
    /// Of each campaign: prints what was drawn and what came of it. Or the most likely failure of --rare,
    /// from its rare_failure.json.
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
    /// Pages of flights whose files are kept.
    #[command(flatten)]
    pub page: PageArgs,
    /// Threads to fly on; the results do not depend on it.
    ///
    /// [default: one for each core; 2 for drops by PX4, and there no more than instances are left]
    #[arg(long, value_name = "N", value_parser = whole::<u16>(1..=256), hide_short_help = true)]
    pub threads: Option<u16>,
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

    /// Flights of each level of `--rare`.
    pub fn per_level(&self) -> usize {
        self.per_level.unwrap_or(PER_LEVEL)
    }

    /// Directions of each pair of `--envelope`.
    pub fn rays(&self) -> usize {
        self.rays.unwrap_or(RAYS)
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
