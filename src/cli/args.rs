//! The options that several verbs share; those of one verb stand beside it.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::Args;

use super::answer::{BadInput as _, Failure};
pub use super::set::{CHOICES, SetArgs};
use super::sign_key::sign_with;
#[cfg(unix)]
use super::system::raise_without_parent;
use samara::config::Mission;
use samara::config::shipped::is_built_in;
use samara::control::px4::versions::Number;
use samara::control::px4::{Law, Version};
use samara::link::shell::ports::MAX_INSTANCE;
use samara::link::shell::{LinkUrl, Ports, SignWith, Speed, Wiring, system_of_instance};
use samara::params::Metadata;
pub use samara::study::settings::{measured, number, plain_name, positive, positive_in, whole};

/// The mission where none is named.
pub const DEFAULT_MISSION: &str = "titan_drop";

/// Options that every verb with a mission has.
#[derive(Args, Clone, Debug)]
pub struct MissionArgs {
    /// The mission: a file, or a name.
    ///
    /// A name is of a file in ./mission, or of a mission that samara brings along.
    #[arg(value_name = "NAME|FILE", default_value = DEFAULT_MISSION)]
    pub mission: PathBuf,
    /// Folder for the results [default: out/<mission name>].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

impl MissionArgs {
    /// How the mission is named in a command: a built-in one by its name, which means it anywhere else, too.
    pub fn named(&self, mission: &Mission) -> PathBuf {
        if is_built_in(&mission.file) { self.mission.clone() } else { mission.file.clone() }
    }
}

/// Whose end is this process's end.
#[derive(Args, Clone, Debug, Default)]
pub struct ParentArgs {
    /// End when the process that started this one ends.
    ///
    /// A worker that is killed leaves nothing running. With PID, that process: one that has ended before this
    /// looked is noticed, too.
    #[cfg(unix)]
    #[arg(
        long,
        value_name = "PID",
        num_args = 0..=1,
        require_equals = true,
        value_parser = whole::<u32>(1..=u64::from(u32::MAX)),
        hide_short_help = true
    )]
    pub with_parent: Option<Option<u32>>,
}

impl ParentArgs {
    /// From now on the flag is raised when that process ends, if one is named.
    pub fn watch(&self, flag: &Arc<AtomicBool>) -> Result<(), Failure> {
        #[cfg(unix)]
        if let Some(parent) = self.with_parent {
            raise_without_parent(flag, parent)?;
        }
        #[cfg(not(unix))]
        let _ = flag;
        Ok(())
    }
}

/// Whether the page of a flight is written, and its log for other tools.
#[derive(Args, Clone, Debug)]
pub struct PageArgs {
    /// Leave out drop.html, the page that replays the flight (a megabyte).
    #[arg(long)]
    pub no_html: bool,
    /// Write drop.mcap, too: the flight for Foxglove, Rerun and PlotJuggler.
    #[arg(long)]
    pub mcap: bool,
}

impl PageArgs {
    /// What a verb without flights has.
    pub const NONE: Self = Self { no_html: false, mcap: false };
}

/// What every verb that plans has.
#[derive(Args, Debug)]
pub struct PlanningArgs {
    /// Show each iteration of the planner on stderr.
    #[arg(short, long)]
    pub verbose: bool,
}

/// Which of several vehicles side by side.
#[derive(Args, Debug)]
#[command(next_help_heading = "Links")]
pub struct NetArgs {
    /// Number of the vehicle.
    ///
    /// Shifts its ports as PX4 does, and its MAVLink system id.
    #[arg(long, value_name = "0..9", default_value_t = 0, value_parser = instance)]
    pub instance: u16,
    /// Sign what is sent, and let in only what is signed by this key.
    ///
    /// That is to ground stations, companions and parachute. The file holds 64 hexadecimal digits or a
    /// passphrase, as QGroundControl and MAVProxy take it; nobody but its owner may read it. The last time
    /// stamps are kept beside it.
    #[arg(long, value_name = "FILE")]
    pub sign_key: Option<PathBuf>,
}

impl NetArgs {
    /// The ports of the instance.
    pub fn ports(&self) -> Result<Ports, Failure> {
        Ports::of_instance(self.instance).bad_input()
    }

    /// The MAVLink system of the instance's vehicle.
    pub fn system(&self) -> Result<u8, Failure> {
        system_of_instance(self.instance).bad_input()
    }

    /// How frames are signed, by the key read from its file, if there is one.
    pub fn sign(&self) -> Result<Option<SignWith>, Failure> {
        self.sign_key.as_deref().map(sign_with).transpose()
    }

    /// Endpoints and key besides the instance's ports.
    pub fn wiring(&self, link: &LinkArgs) -> Result<Wiring, Failure> {
        Ok(Wiring { urls: link.links.clone(), sign: self.sign()? })
    }
}

/// Endpoints besides an instance's own.
#[derive(Args, Debug)]
#[command(next_help_heading = "Links")]
pub struct LinkArgs {
    /// A further endpoint for ground stations, such as udpout:HOST:PORT.
    ///
    /// udpin, udpout, tcpin or tcpout, then :HOST:PORT (`in` binds and serves whoever comes, `out` goes
    /// there). May be repeated.
    #[arg(long = "link", value_name = "URL")]
    pub links: Vec<LinkUrl>,
}

/// How long PX4 is waited for.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Autopilot")]
pub struct PatienceArgs {
    /// Wall time that PX4 may take to connect [s].
    ///
    /// Where many drops are flown, also for an answer. A single drop waits for an answer for ever: PX4 may
    /// stand still in a debugger.
    #[arg(long = "patience", value_name = "S", default_value_t = PATIENCE_S, value_parser = positive_in("s"), hide_short_help = true)]
    seconds: f64,
}

/// Patience unless it is said otherwise [s].
const PATIENCE_S: f64 = 60.0;

impl Default for PatienceArgs {
    fn default() -> Self {
        Self { seconds: PATIENCE_S }
    }
}

impl PatienceArgs {
    /// Whether another than the usual patience is asked for.
    pub fn asked(&self) -> bool {
        self.seconds != PATIENCE_S
    }

    /// As a duration.
    pub fn limit(&self) -> Duration {
        Duration::try_from_secs_f64(self.seconds).unwrap_or(Duration::MAX)
    }
}

/// The autopilot that flies a drop.
#[derive(Clone, Debug, PartialEq)]
pub enum AutopilotArg {
    /// samara's own.
    Reference,
    /// PX4, from a build folder.
    Px4(PathBuf),
    /// The model of the control law of a version of PX4.
    Px4Model(Law),
}

impl fmt::Display for AutopilotArg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Reference => f.write_str("reference"),
            Self::Px4(folder) => write!(f, "px4={}", folder.display()),
            Self::Px4Model(law) if *law == Law::V1_12 => f.write_str("px4-model"),
            Self::Px4Model(law) => write!(f, "px4-model={}", law.since),
        }
    }
}

/// What can be chosen in place of the mission's own.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = CHOICES)]
pub struct ChoiceArgs {
    /// Gains: a name (ours, safety, near_hover, ..) or a file.
    ///
    /// A name is of a file beside the mission's own gains, or of gains that samara brings along. Where PX4
    /// flies, a parameter file in place of the one that the mission names for it (`px4_params`), or
    /// `px4_default`: PX4's own.
    #[arg(long, value_name = "NAME|FILE")]
    pub gains: Option<String>,
    /// Gains and limits from a PX4 parameter file.
    ///
    /// One that is for samara's autopilot, or for any autopilot under standard gravity. Where PX4 flies: a
    /// file for it, instead of the mission's `px4_params`.
    #[arg(long, value_name = "FILE", conflicts_with = "gains")]
    pub params: Option<PathBuf>,
    /// Seed of everything random.
    #[arg(long, value_name = "N", value_parser = whole::<u64>(0..=u64::MAX))]
    pub seed: Option<u64>,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    pub set: SetArgs,
    /// Swing so that the release is this case of the mission (case_0 ..).
    ///
    /// The vehicle swings under its canopy so that it comes to t = 0 with the pitch and pitch rate of the
    /// release case (Table 3: case_0 to case_6).
    #[arg(long, value_name = "NAME")]
    pub case: Option<String>,
}

/// Whether gains are a parameter file, by its name.
pub fn is_parameter_file(gains: &str) -> bool {
    let endings = ["params", "param", "parm"];
    Path::new(gains).extension().is_some_and(|ending| endings.iter().any(|known| ending == *known))
}

/// `--gains` of this name: PX4's own.
pub const PX4_DEFAULT: &str = "px4_default";

impl ChoiceArgs {
    /// Whether PX4 is to keep the gains that it has.
    pub fn px4s_own_gains(&self) -> bool {
        self.gains.as_deref() == Some(PX4_DEFAULT)
    }

    /// The choice where PX4 flies: gains that are a parameter file are its parameters.
    pub fn of_px4(&self) -> Self {
        match &self.gains {
            Some(gains) if is_parameter_file(gains) => {
                Self { gains: None, params: Some(PathBuf::from(gains)), ..self.clone() }
            }
            _ => self.clone(),
        }
    }
}

/// What the reference autopilot flies by.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Autopilot")]
pub struct StateArgs {
    /// State that the autopilot flies by: truth or ekf.
    #[arg(long, value_enum, default_value_t = EstimatorChoice::Truth, hide_possible_values = true)]
    pub estimator: EstimatorChoice,
}

impl StateArgs {
    /// Whether it is to have an estimator.
    pub fn asked(&self) -> bool {
        self.estimator != EstimatorChoice::Truth
    }
}

/// Where the autopilot's state comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum EstimatorChoice {
    /// The simulator's truth (ODOMETRY, HIL_STATE_QUATERNION), as in the paper's study.
    #[default]
    Truth,
    /// The autopilot's own Kalman filter on the sensors (HIL_SENSOR, HIL_GPS).
    Ekf,
}

/// The value of `--instance`: the number of a vehicle that has ports.
pub fn instance(text: &str) -> Result<u16, String> {
    let instance =
        text.parse::<u16>().map_err(|_| format!("a number from 0 to {MAX_INSTANCE} is expected"))?;
    Ports::of_instance(instance).map(|_| instance).map_err(|e| e.to_string())
}

/// The value of `--speed`: simulated seconds per second, or `max`.
pub fn speed(text: &str) -> Result<Speed, String> {
    if text == "max" {
        return Ok(Speed::Max);
    }
    let expected = "a factor from 0.001 to 10000, or `max`, is expected";
    number(text, |x| (0.001..=10_000.0).contains(&x), expected).map(Speed::Factor)
}

/// The value of `--wait-for`: how long a companion that falls silent is waited for.
pub fn companion(text: &str) -> Result<Duration, String> {
    let expected = "`companion`, or `companion=` and seconds from 0.1 to 86400, is expected";
    match text.split_once('=') {
        None if text == "companion" => Ok(Duration::from_secs(5)),
        Some(("companion", seconds)) => {
            measured(seconds, "s", |x| (0.1..=86_400.0).contains(&x), expected).map(Duration::from_secs_f64)
        }
        _ => Err(expected.to_owned()),
    }
}

/// A version of PX4 whose law the model has.
pub fn px4_law(text: &str) -> Result<Law, String> {
    Version::law_of(text).map_err(|e| e.to_string())
}

/// The number of a version of PX4 whose parameters are known.
pub fn px4_version(text: &str) -> Result<Number, String> {
    let (oldest, newest) = (Metadata::OLDEST, Metadata::NEWEST);
    let known = text.parse().ok().filter(|version| (oldest..=newest).contains(version));
    known.ok_or_else(|| format!("a version of PX4 from {oldest} to {newest} is expected"))
}

/// The value of `--autopilot`.
pub fn autopilot(text: &str) -> Result<AutopilotArg, String> {
    match text.split_once('=') {
        None if text == "reference" => Ok(AutopilotArg::Reference),
        None if text == "px4-model" => Ok(AutopilotArg::Px4Model(Law::V1_12)),
        Some(("px4-model", version)) => px4_law(version).map(AutopilotArg::Px4Model),
        Some(("px4", folder)) if !folder.is_empty() => Ok(AutopilotArg::Px4(folder.into())),
        _ => Err("`reference`, `px4-model`, or `px4=` and a build folder of PX4's simulation is expected"
            .to_owned()),
    }
}

/// Three numbers in a unit that fit, separated by commas; otherwise what is expected.
pub fn three(text: &str, unit: &str, fits: impl Fn(f64) -> bool, expected: &str) -> Result<[f64; 3], String> {
    let numbers: Result<Vec<f64>, String> =
        text.split(',').map(|part| measured(part, unit, &fits, expected)).collect();
    numbers?.try_into().map_err(|_| expected.to_owned())
}

/// The arguments of a verb, of words that begin with it.
pub fn parsed<A: Args>(words: &[String]) -> Result<A, Failure> {
    let verb = words.first().cloned().unwrap_or_default();
    let command = super::help::with_negative_values(A::augment_args(clap::Command::new(verb)));
    let typed = command.try_get_matches_from(words);
    let args = typed.and_then(|typed| A::from_arg_matches(&typed));
    args.map_err(|error| Failure::input(error.render().to_string()))
}
