//! `samara replay`: a drop flown again from its recorded actuators, without an autopilot, and held against
//! what was recorded of it; of a flight log as far as that goes.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{ChoiceArgs, PageArgs, whole};
use super::conclusion::Conclusion;
use super::log::flight;
use super::mission::mission_with_a_drop;
use super::narrator::Narrator;
use super::pilot::Flown;
use super::results::OutputFolder;
use super::terminal::print;
use samara::config::Mission;
use samara::config::bounded::bytes_at_most;
use samara::link::hil::SIMULATOR_COMPONENT;
use samara::link::{Replayed, TlogReader, TlogRecord, parties, replay};
use samara::report::FlightCsv;
use samara::report::truth::{Truth, replay_json, replay_text};
use samara::study::compare::replayed::ReplayedLog;

/// The recording in a folder of results.
const RECORDING: &str = "hil.tlog";
/// The recording of the other link, beside it.
const COMPANION: &str = "companion.tlog";
/// The truth, beside it.
const TRUTH: &str = "flight.csv";

/// Larger recordings are refused [bytes]: 900 s, the longest flight, have 131 MB.
const RECORDING_MOST: u64 = 512 << 20;

/// `samara replay`.
#[derive(Args, Debug)]
pub struct ReplayArgs {
    /// The recording: hil.tlog, or the folder that holds it; or a flight log (.ulg).
    ///
    /// Of `samara drop`, `samara sim` or a trial that a campaign kept; companion.tlog and flight.csv are
    /// taken from beside it.
    #[arg(value_name = "FILE|DIR")]
    pub recording: PathBuf,
    /// The mission that was flown: a file, or a name.
    #[arg(value_name = "MISSION")]
    pub mission: PathBuf,
    /// Trial of the campaign that the recording is of.
    #[arg(long, value_name = "K", value_parser = whole::<u64>(0..=u64::MAX))]
    pub trial: Option<u64>,
    /// Folder for the results [default: `replay` beside the recording].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
    /// What the mission leaves to choose; gains decide nothing here.
    #[command(flatten)]
    pub choice: ChoiceArgs,
    /// The page.
    #[command(flatten)]
    pub page: PageArgs,
}

/// Flies the recording again, writes the flight and says whether it is the one that was recorded.
pub fn run(args: &ReplayArgs) -> Result<Answer, Failure> {
    let mut mission = mission_with_a_drop(&args.mission, &args.choice)?;
    if let Some(trial) = args.trial {
        mission = mission.with_drop(&mission.draw_drop(trial));
        mission.note_choice("trial", &trial.to_string());
    }
    if args.recording.extension().is_some_and(|ending| ending == "ulg") {
        return of_log(args, &mission);
    }
    let path = if args.recording.is_dir() { args.recording.join(RECORDING) } else { args.recording.clone() };
    let beside = |name: &str| path.with_file_name(name);
    let hil =
        records(&path, &mission)?.ok_or_else(|| anyhow!("{}: no such file", path.display())).bad_input()?;
    let companion = records(&beside(COMPANION), &mission)?.unwrap_or_default();
    let replayed = fly(&mission, &hil, &companion).with_context(|| path.display().to_string()).bad_input()?;
    let truth = read(&beside(TRUTH))?.map(|bytes| {
        let mut text = Vec::new();
        // Writing to memory cannot fail.
        let _ = write_truth(&mut text, &mission, &replayed);
        Truth::of(&String::from_utf8_lossy(&bytes), &String::from_utf8_lossy(&text))
    });
    let out = args.out.clone().unwrap_or_else(|| path.with_file_name("replay"));
    let folder = OutputFolder::create("replay", Some(&out), &mission.name)?;
    let equal = replayed.difference.is_none() && truth.as_ref().is_none_or(Truth::is_equal);
    let (messages, difference) =
        (replayed.equal_messages, replayed.difference.as_ref().map(ToString::to_string));
    let record = replayed.run.record().clone();
    let flown = Flown::of_simulator(replayed.run.into_log(), record);
    let mut conclusion = Conclusion::new(&mission, None, &flown).with_page(&args.page);
    conclusion.write("replay", &[], &folder)?;
    let narrator = Narrator::together(args.json);
    narrator.say(&format!("flown again in {}\n", folder.path().display()));
    narrator.check()?;
    let (difference, truth) = (difference.as_deref(), truth.as_ref());
    print(&if args.json {
        replay_json(&mission, messages, difference, truth)
    } else {
        replay_text(messages, difference, truth)
    })?;
    Ok(Answer::from(equal))
}

/// Flies the drop of a flight log again by its commands, and says how far that goes.
fn of_log(args: &ReplayArgs, mission: &Mission) -> Result<Answer, Failure> {
    if args.trial.is_some() || args.page.mcap {
        let words = "a flight log (.ulg) is replayed without --trial and --mcap";
        return Err(Failure::input(words.to_owned()));
    }
    let log = flight(&args.recording)?;
    let name = args.recording.file_name().unwrap_or_default().to_string_lossy();
    let replayed = ReplayedLog::new(&log, mission).with_context(|| name.to_string()).bad_input()?;
    let out = args.out.clone().unwrap_or_else(|| args.recording.with_file_name("replay"));
    let folder = OutputFolder::create("replay", Some(&out), &mission.name)?;
    folder.write(TRUTH, |out| {
        let mut csv = FlightCsv::new(out, mission, false)?;
        replayed.flown.iter().try_for_each(|sample| csv.write(sample))?;
        csv.finish().map(|_| ())
    })?;
    if !args.page.no_html {
        folder.write_text("drop.html", &replayed.page(&name, mission))?;
    }
    folder.write_manifest("replay", mission, &[])?;
    print(&if args.json {
        replayed.json(mission)
    } else {
        format!("{}results in {}\n", replayed.text(), folder.path().display())
    })?;
    Ok(Answer::Yes)
}

/// The flight of the records, on the wire that fits: a mission that has PX4's clock scaled was flown by PX4,
/// in its units, or by another, in the site's.
fn fly(mission: &Mission, hil: &[TlogRecord], companion: &[TlogRecord]) -> Result<Replayed, anyhow::Error> {
    let of_simulator = hil.iter().find(|record| record.frame.component_id == SIMULATOR_COMPONENT);
    let system =
        of_simulator.ok_or_else(|| anyhow!("no message of a simulator in the recording"))?.frame.system_id;
    let on = |froude| replay(parties::simulator(mission, system, froude, None), hil, companion);
    let replayed = on(None);
    match parties::froude(mission) {
        Some(froude) if !matches!(&replayed, Ok(Replayed { difference: None, .. })) => {
            let scaled = on(Some(froude));
            let equal = |replayed: &Result<Replayed, _>| replayed.as_ref().map_or(0, |r| r.equal_messages);
            Ok(if equal(&scaled) > equal(&replayed) { scaled? } else { replayed? })
        }
        _ => Ok(replayed?),
    }
}

/// The records of a file; `None` when there is none.
fn records(path: &Path, mission: &Mission) -> Result<Option<Vec<TlogRecord>>, Failure> {
    let Some(bytes) = read(path)? else { return Ok(None) };
    let records: Result<Vec<_>, _> = TlogReader::new(&bytes, mission.epoch_unix_us).collect();
    records.map(Some).with_context(|| path.display().to_string()).bad_input()
}

fn read(path: &Path) -> Result<Option<Vec<u8>>, Failure> {
    match bytes_at_most(path, RECORDING_MOST) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e).with_context(|| format!("cannot read {}", path.display())).bad_input(),
    }
}

fn write_truth(out: &mut Vec<u8>, mission: &Mission, replayed: &Replayed) -> std::io::Result<()> {
    let mut csv = FlightCsv::new(out, mission, mission.site.ground.is_some())?;
    replayed.run.log().iter().try_for_each(|sample| csv.write(sample))?;
    csv.finish().map(|_| ())
}
