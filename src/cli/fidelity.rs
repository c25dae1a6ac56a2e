//! `samara fidelity`: one campaign by several ways to fly it, held against each other.

use std::fs::File;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{AutopilotArg, ChoiceArgs, MissionArgs, whole};
use super::mission::{chosen_mission, mission_for_px4, origin};
use super::narrator::Narrator;
use super::results::OutputFolder;
use super::terminal::print;
use samara::assess::ChosenAmong;
use samara::config::Mission;
use samara::control::px4::versions::VERSIONS;
use samara::study::fidelity::FidelityReport;
use samara::study::fidelity::fidelity_figure;
use samara::study::fidelity::lines::CampaignLines;

/// Fewest campaigns that can be compared.
const FEWEST: usize = 2;

/// `samara fidelity`.
#[derive(Args, Debug)]
pub struct FidelityArgs {
    /// The mission.
    #[command(flatten)]
    pub mission: MissionArgs,
    /// The lines of a campaign (CSV); twice or more, the most faithful first.
    ///
    /// `drops_<autopilot>_<gains>.csv` or `campaign_<name>.csv`, as `samara assess` writes them, of the same
    /// mission, seed and inputs.
    #[arg(long = "by", value_name = "FILE", required = true)]
    pub by: Vec<PathBuf>,
    /// Trials that calibrate the bound from the second way to the first [default: half].
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=100_000_000))]
    pub calibrate: Option<usize>,
    /// How many designs the flown one was chosen among by the first file's trials.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole::<u64>(1..=1_000_000_000))]
    pub chosen_among: u64,
    /// What the campaigns were flown with.
    #[command(flatten)]
    pub choice: ChoiceArgs,
}

/// Reads the campaigns, writes and prints what they say together.
pub fn run(args: &FidelityArgs) -> Result<Answer, Failure> {
    if args.by.len() < FEWEST {
        let expected = "--by: at least two campaigns are expected, the most faithful first";
        return Err(Failure::input(expected.to_owned()));
    }
    let (path, choice) = (&args.mission.mission, &args.choice);
    let gains = choice.of_px4().gains.filter(|_| !choice.px4s_own_gains());
    let own = chosen_mission(path, &ChoiceArgs { gains, params: None, ..choice.clone() })?;
    // Campaigns by PX4 and by its model have the parameter file among their inputs, and which of them flew.
    let (of_px4, _) = mission_for_px4(path, choice, None)?;
    let by = |autopilot: &str| {
        let mut mission = of_px4.clone();
        mission.note_choice("autopilot", autopilot);
        mission
    };
    let models = VERSIONS
        .iter()
        .filter_map(|version| version.law)
        .map(|law| by(&AutopilotArg::Px4Model(law).to_string()));
    let flown: Vec<Mission> = [own, by("px4")].into_iter().chain(models).collect();
    let hashes: Vec<&str> = flown.iter().map(|mission| mission.inputs.hash.as_str()).collect();
    let read = |path: &PathBuf| {
        let lines = CampaignLines::read(opened(path)?, &of_px4, &hashes);
        lines.with_context(|| path.display().to_string()).bad_input()
    };
    let rungs = args.by.iter().map(read).collect::<Result<Vec<_>, Failure>>()?;
    for (k, path) in args.by.iter().enumerate() {
        if let Some(same) = (0..k).find(|before| rungs[*before] == rungs[k]) {
            let (path, same) = (path.display(), args.by[same].display());
            let message = format!("--by {path}: another campaign than that of {same} is expected");
            return Err(Failure::input(message));
        }
    }
    if let (Some(calibrate), [first, second, ..]) = (args.calibrate, &rungs[..]) {
        let shared = first.trials.intersection(&second.trials).count();
        if calibrate > shared {
            return Err(Failure::input(format!(
                "--calibrate {calibrate}: at most the {shared} trials that both of the first two have flown are expected"
            )));
        }
    }
    let first = rungs.first().map(|first| first.input_hash.as_str());
    let mission = flown.iter().find(|mission| first == Some(&mission.inputs.hash)).unwrap_or(&of_px4);
    let narrator = Narrator::alone(args.mission.json);
    narrator.say(&origin(path, mission));
    let report = FidelityReport::new(mission, rungs, args.calibrate, ChosenAmong::new(args.chosen_among));
    let folder = OutputFolder::create("fidelity", args.mission.out.as_deref(), &mission.name)?;
    let (said, json) = (report.document().text(), report.json());
    folder.write_text("fidelity.txt", &said)?;
    folder.write_text("fidelity.json", &json)?;
    let figure = fidelity_figure(&report).context("no trial was flown both ways").bad_input()?;
    folder.write_text("fidelity.svg", &figure)?;
    let files = args.by.iter().map(|path| path.display().to_string()).collect::<Vec<_>>().join(", ");
    let mut asked = vec![("by", files), ("chosen_among", args.chosen_among.to_string())];
    asked.extend(args.calibrate.map(|n| ("calibrate", n.to_string())));
    folder.write_manifest("fidelity", mission, &asked)?;
    print(&if args.mission.json {
        json
    } else {
        format!("{said}\nfigure in {}\n", folder.path().join("fidelity.svg").display())
    })?;
    Ok(Answer::Yes)
}

fn opened(path: &Path) -> Result<File, Failure> {
    #[expect(clippy::disallowed_methods, reason = "what earlier runs have written, read line by line")]
    let file = File::open(path).with_context(|| format!("cannot read {}", path.display()));
    file.bad_input()
}
