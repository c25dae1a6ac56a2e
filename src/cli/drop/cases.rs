//! `samara drop --cases`: the mission's release cases (Table 3), a drop each, in one table. PX4 has the
//! reference autopilot beside it.

use std::path::Path;
use std::sync::atomic::Ordering;

use super::args::DropArgs;
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::AutopilotArg;
use crate::cli::conclusion::Conclusion;
use crate::cli::narrator::Narrator;
use crate::cli::pilot::{Pilot, PilotedDrop, Reference};
use crate::cli::planning::Planned;
use crate::cli::system::interrupt_flag;
use crate::cli::terminal::print;
use samara::assess::outcome::{ALTITUDE_LOST, J_TPF, PEAK_PITCH, PEAK_PITCH_RATE, PEAK_SPEED, STEADY_AFTER};
use samara::assess::{Quantity, Verdict};
use samara::report::rows::Columns;
use samara::units::DEG_PER_RAD;

const HEAD: &str = "\
case        flown by     J_TPF  peak pitch  peak pitch rate  peak speed  altitude lost  steady after
                                       deg            deg/s         m/s              m             s
";

/// Quantities of `cases.csv`.
const COLUMNS: [Quantity; 6] = [J_TPF, PEAK_PITCH, PEAK_PITCH_RATE, PEAK_SPEED, ALTITUDE_LOST, STEADY_AFTER];

/// Flies the mission of `nominal` from each release case, into a folder each below that of `nominal`.
pub fn run(
    args: &DropArgs,
    pilot: &dyn Pilot,
    planned: &Planned,
    nominal: &PilotedDrop<'_>,
) -> Result<Answer, Failure> {
    let PilotedDrop { mission, folder, narrator, .. } = *nominal;
    let beside = Reference::default();
    let pilots = match args.autopilot {
        AutopilotArg::Reference => vec![("reference", pilot)],
        _ => vec![(pilot.name(), pilot), ("reference", &beside as &dyn Pilot)],
    };
    let quiet = Narrator::together(true);
    let (mut all_well, mut objects, mut kept) = (true, Vec::new(), Vec::new());
    let mut csv = format!("{}{}\n", mission.stamp().csv_comment(), columns().names());
    narrator.say(HEAD);
    // Each flight listens for Ctrl-C itself, and ends by it; here it ends the series.
    let stop = interrupt_flag()?;
    'cases: for case in mission.study.cases.iter().map(|case| case.name.as_str()) {
        let mut swinging = mission.clone();
        swinging.use_release_case(case).bad_input()?;
        for (name, pilot) in &pilots {
            if stop.load(Ordering::Relaxed) {
                all_well = false;
                narrator.warn("stopped: the cases that follow were not flown\n");
                break 'cases;
            }
            let place = folder.part("drop", Path::new(case).join(name))?;
            planned.write_to(&place, &swinging)?;
            let flown = pilot.fly(&PilotedDrop {
                mission: &swinging,
                folder: &place,
                narrator: &quiet,
                ..*nominal
            })?;
            let mut conclusion = Conclusion::new(&swinging, Some(planned), &flown).with_page(&args.page);
            conclusion.write("drop", &args.circumstances(), &place)?;
            conclusion.report(&quiet, &place)?;
            let verdict = conclusion.verdict.as_ref();
            narrator.say(&row(case, name, verdict));
            if conclusion.answer() == Answer::No {
                all_well = false;
                let place = place.path().display();
                narrator.say(&format!("  NOT OK: see {place}; `--case {case}` tells what happens in it\n"));
            }
            narrator.check()?;
            columns().push_line(&mut csv, &(case, *name, verdict));
            objects.push(object(case, name, &conclusion.json()));
            kept.push(object(case, name, &conclusion.file_json()));
        }
    }
    folder.write_text("cases.csv", &csv)?;
    folder.write_text("cases.json", &all(&kept))?;
    folder.write_manifest("cases", mission, &args.circumstances())?;
    if args.mission.json {
        print(&all(&objects))?;
    } else {
        print(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(Answer::from(all_well))
}

fn object(case: &str, pilot: &str, drop: &str) -> String {
    format!("{{\"case\": \"{case}\", \"autopilot\": \"{pilot}\", \"drop\": {}}}", drop.trim_end())
}

fn all(objects: &[String]) -> String {
    format!("{{\"cases\": [\n{}\n]}}\n", objects.join(",\n"))
}

/// The columns of `cases.csv`; empty fields where nothing was released or nothing became steady.
fn columns<'a>() -> Columns<(&'a str, &'a str, Option<&'a Verdict>)> {
    Columns::<(&str, &str, Option<&Verdict>)>::none()
        .word("case", "name of the release case", |(case, ..)| Some((*case).to_owned()))
        .word("autopilot", "who flew it", |(_, pilot, _)| Some((*pilot).to_owned()))
        .quantities(&COLUMNS, |(.., verdict)| verdict.map(|v| &v.outcome))
        .word("decided_by", "what J_TPF is the share of", |(.., verdict)| {
            verdict.map(|v| v.decided_by.to_owned())
        })
}

fn row(case: &str, pilot: &str, verdict: Option<&Verdict>) -> String {
    let Some(v) = verdict else { return format!("{case:11} {pilot:9}  never released\n") };
    let steady = v.outcome.steady_after_s.map_or("never".to_owned(), |t| format!("{t:.2}"));
    format!(
        "{case:11} {pilot:9} {:8.4} {:11.2} {:16.2} {:11.2} {:14.1} {steady:>13}\n",
        v.outcome.j_tpf,
        v.peaks.pitch_rad * DEG_PER_RAD,
        v.peaks.pitch_rate_rad_s * DEG_PER_RAD,
        v.outcome.peak_speed_m_s,
        v.outcome.altitude_lost_m,
    )
}
