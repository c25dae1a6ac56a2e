//! `samara compare`: two runs, two missions, or a flight log and a mission, held against each other.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;
use serde::de::DeserializeOwned;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::SetArgs;
use super::log::flight;
use super::mission::open_mission;
use super::planning::plan_mission;
use super::results::OutputFolder;
use super::terminal::print;
use samara::config::bounded::text_at_most;
use samara::config::{Mission, plain_name};
use samara::logged_flight::LoggedFlight;
use samara::plan::Status;
use samara::study::campaign::json::AssessObject;
use samara::study::compare::campaigns::CampaignPair;
use samara::study::compare::drops::DropPair;
use samara::study::compare::logged::LoggedPair;
use samara::study::compare::missions::MissionPair;
use samara::study::compare::paths::{FlownPath, paths_figure};
use samara::study::compare::{Compared, PATHS, REPLAY};
use samara::study::fidelity::lines::CampaignLines;

/// The verdict on a drop, and the flight.
const DROP: &str = "drop.json";
const FLIGHT: &str = "flight.csv";
/// How names of files with the lines of a campaign begin.
const CAMPAIGNS: [&str; 2] = ["campaign_", "drops_"];
/// Larger objects of results are none [bytes].
const LARGEST: u64 = 64 << 20;

/// `samara compare`.
#[derive(Args, Debug)]
pub struct CompareArgs {
    /// A run's folder, the lines of a campaign (.csv), a mission (a name or a file), or a flight log (.ulg).
    #[arg(value_name = "A")]
    pub a: PathBuf,
    /// Another one, of the same kind; to a flight log the mission that was flown.
    #[arg(value_name = "B")]
    pub b: PathBuf,
    /// With a flight log: lines of a campaign of that mission (.csv), to say whether the drop is within them.
    #[arg(long, value_name = "FILE")]
    pub campaign: Option<PathBuf>,
    /// Folder that compare.html, .json and .svg, of a log drop.html too, are written to [default: nothing
    /// is].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// One of two things that are compared.
enum Side {
    Run(Run),
    Mission(Box<Mission>),
    Log(Box<LoggedFlight>),
}

/// What there is of a run: files, not read yet.
struct Run {
    /// How it was named.
    name: PathBuf,
    /// Files with the lines of campaigns, by their names.
    campaigns: BTreeMap<String, PathBuf>,
    /// The folder with a drop, where it has one.
    drop: Option<PathBuf>,
}

/// Compares, prints, and writes where that is asked for. It judges nothing.
pub fn run(args: &CompareArgs) -> Result<Answer, Failure> {
    if args.campaign.is_some() && !is_log(&args.a) {
        return Err(Failure::input(format!(
            "--campaign goes with a flight log (.ulg) as A; {} is none",
            args.a.display()
        )));
    }
    let names = [&args.a, &args.b].map(|path| path.display().to_string());
    let compared = match (side(&args.a)?, side(&args.b)?) {
        (Side::Run(a), Side::Run(b)) => of_runs(names, &[a, b])?,
        (Side::Mission(a), Side::Mission(b)) => {
            let texts = [&a, &b].map(|mission| mission.input_texts(&mission.control.gains_name));
            let [of_a, of_b] = texts;
            let texts = [&of_a.bad_input()?[..], &of_b.bad_input()?[..]];
            let missions = Some(MissionPair::new([&a, &b], texts));
            Compared { names, missions, ..Compared::default() }
        }
        (Side::Log(log), Side::Mission(mission)) => of_log(names, &log, &mission, args)?,
        (a, b) => {
            let kind = |side: &Side| match side {
                Side::Run(_) => "a run",
                Side::Mission(_) => "a mission",
                Side::Log(_) => "a flight log",
            };
            return Err(Failure::input(format!(
                "{} is {}, {} is {}: two runs are expected, two missions, or a flight log and then the mission that was flown",
                args.a.display(),
                kind(&a),
                args.b.display(),
                kind(&b)
            )));
        }
    };
    let document = compared.document();
    if let Some(out) = &args.out {
        let folder = OutputFolder::plain(out)?;
        folder.write_text("compare.json", &compared.json())?;
        if let Some(svg) = &compared.paths {
            folder.write_text(PATHS, svg)?;
        }
        if let Some(page) = &compared.replay {
            folder.write_text(REPLAY, page)?;
        }
        folder.write_text("compare.html", &document.page())?;
    }
    print(&if args.json {
        compared.json()
    } else {
        let page = args.out.as_ref().map(|out| {
            let replay =
                compared.replay.as_ref().map_or(String::new(), |_| format!(", the drop in {REPLAY}"));
            format!("\npage in {}{replay}\n", out.join("compare.html").display())
        });
        document.text() + &page.unwrap_or_default()
    })?;
    Ok(Answer::Yes)
}

fn side(path: &Path) -> Result<Side, Failure> {
    if path.is_dir() {
        return Ok(Side::Run(Run::of_folder(path)?));
    }
    if is_log(path) {
        return Ok(Side::Log(Box::new(flight(path)?)));
    }
    if path.extension().is_some_and(|ending| ending == "csv") {
        let campaigns = BTreeMap::from([(file_name(path), path.to_owned())]);
        return Ok(Side::Run(Run { name: path.to_owned(), campaigns, drop: None }));
    }
    if plain_name(path).is_none() && !path.exists() {
        return Err(Failure::input(format!(
            "{}: nothing is there; a run's folder, the lines of a campaign, a flight log or a mission is expected",
            path.display()
        )));
    }
    let nothing_set = SetArgs { set: Vec::new() };
    Ok(Side::Mission(Box::new(open_mission(path, &nothing_set)?)))
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn is_log(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "ulg")
}

/// The drop of a log, and what the mission predicts of it.
fn of_log(
    names: [String; 2],
    log: &LoggedFlight,
    mission: &Mission,
    args: &CompareArgs,
) -> Result<Compared, Failure> {
    let campaign = args.campaign.as_deref().map(lines).transpose()?;
    let plan = plan_mission(mission, false)?.plan;
    if plan.status != Status::Converged {
        return Err(Failure::input(format!(
            "{}: no plan of it is found, so that nothing is predicted",
            names[1]
        )));
    }
    let pair = LoggedPair::new(log, mission, &plan.trajectory, campaign.as_ref());
    let pair = pair.with_context(|| names[0].clone()).bad_input()?;
    let words = [names[0].clone(), format!("{} from the same state", names[1])];
    let paths = paths_figure(&words, &pair.paths()).context("drawing the flight paths")?;
    let replay = args.out.as_ref().map(|_| pair.page(&file_name(&args.a), mission, &plan.trajectory));
    Ok(Compared { names, logged: Some(pair), paths: Some(paths), replay, ..Compared::default() })
}

impl Run {
    fn of_folder(folder: &Path) -> Result<Self, Failure> {
        let entries = fs::read_dir(folder)
            .and_then(|entries| entries.map(|entry| Ok(entry?.file_name())).collect::<Result<Vec<_>, _>>())
            .with_context(|| format!("{}: a folder of results is expected", folder.display()))
            .bad_input()?;
        let names = entries.into_iter().filter_map(|name| name.into_string().ok());
        let is_lines =
            |name: &String| name.ends_with(".csv") && CAMPAIGNS.iter().any(|begin| name.starts_with(begin));
        let campaigns = names.filter(is_lines).map(|name| (name.clone(), folder.join(name))).collect();
        let drop = Some(folder.to_owned()).filter(|folder| folder.join(DROP).is_file());
        Ok(Self { name: folder.to_owned(), campaigns, drop })
    }

    /// The files that it has, in words.
    fn words(&self) -> String {
        let drop = self.drop.iter().map(|_| DROP);
        let all: Vec<&str> = self.campaigns.keys().map(String::as_str).chain(drop).collect();
        let has = if all.is_empty() { "nothing that is compared".to_owned() } else { all.join(", ") };
        format!("{} has {has}", self.name.display())
    }
}

fn of_runs(names: [String; 2], runs: &[Run; 2]) -> Result<Compared, Failure> {
    let pairs = pairs(runs);
    let campaigns = pairs.iter().map(campaign_pair).collect::<Result<Vec<_>, Failure>>()?;
    let [a, b] = runs;
    let (mut drops, mut paths) = (None, None);
    if let (Some(a), Some(b)) = (&a.drop, &b.drop) {
        drops = Some(DropPair { drops: [object(&a.join(DROP))?, object(&b.join(DROP))?] });
        if let (Some(a), Some(b)) = (path_of(a)?, path_of(b)?) {
            paths = Some(paths_figure(&names, &[a, b]).context("drawing the flight paths")?);
        }
    }
    if campaigns.is_empty() && drops.is_none() {
        return Err(Failure::input(format!(
            "{}; {}: lines of campaigns (campaign_*.csv, drops_*.csv) of the same name are expected in both, or one file in each, \
             or a {DROP} in both; two of several files are compared by their paths",
            a.words(),
            b.words()
        )));
    }
    Ok(Compared { names, campaigns, drops, paths, ..Compared::default() })
}

/// The files of two runs that are held against each other, by the name of the pair: those of the same name,
/// or the only ones.
fn pairs<'a>([a, b]: &'a [Run; 2]) -> Vec<(String, [&'a Path; 2])> {
    let same = a.campaigns.iter().filter_map(|(name, of_a)| {
        let of_b = b.campaigns.get(name)?;
        Some((name.trim_end_matches(".csv").to_owned(), [of_a.as_path(), of_b.as_path()]))
    });
    let same: Vec<_> = same.collect();
    let only = |run: &'a Run| match run.campaigns.len() {
        1 => run.campaigns.iter().next(),
        _ => None,
    };
    match (only(a), only(b)) {
        (Some((name_a, of_a)), Some((name_b, of_b))) if same.is_empty() => {
            let [name_a, name_b] = [name_a, name_b].map(|name| name.trim_end_matches(".csv"));
            vec![(format!("{name_a} and {name_b}"), [of_a.as_path(), of_b.as_path()])]
        }
        _ => same,
    }
}

fn campaign_pair((name, files): &(String, [&Path; 2])) -> Result<CampaignPair, Failure> {
    let [a, b] = files;
    CampaignPair::new(name.clone(), [lines(a)?, lines(b)?], [told_failed(a), told_failed(b)]).bad_input()
}

fn lines(path: &Path) -> Result<CampaignLines, Failure> {
    let lines = CampaignLines::read_any(opened(path)?);
    lines.with_context(|| path.display().to_string()).bad_input()
}

/// How many trials failed by the results beside the lines, where those are there.
fn told_failed(lines: &Path) -> Option<u64> {
    let name = lines.file_name()?.to_str()?;
    let assessed: AssessObject = object(&lines.with_file_name("assess.json")).ok()?;
    let campaign = assessed.campaigns.iter().find(|campaign| campaign.file.as_deref() == Some(name))?;
    Some(campaign.unsafe_trials)
}

/// The flight path of a drop; `None` where its flight is not there, or never began.
fn path_of(folder: &Path) -> Result<Option<FlownPath>, Failure> {
    let path = folder.join(FLIGHT);
    if !path.is_file() {
        return Ok(None);
    }
    FlownPath::read(opened(&path)?).with_context(|| path.display().to_string()).bad_input()
}

fn object<T: DeserializeOwned>(path: &Path) -> Result<T, Failure> {
    let text =
        text_at_most(path, LARGEST).with_context(|| format!("cannot read {}", path.display())).bad_input()?;
    let read = serde_json::from_str(&text);
    read.with_context(|| format!("{}: a result as samara writes it is expected", path.display())).bad_input()
}

fn opened(path: &Path) -> Result<File, Failure> {
    #[expect(clippy::disallowed_methods, reason = "what earlier runs have written, read line by line")]
    let file = File::open(path).with_context(|| format!("cannot read {}", path.display()));
    file.bad_input()
}
