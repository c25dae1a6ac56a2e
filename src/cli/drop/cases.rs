//! `samara drop --cases`: the mission's release cases (Table 3), a drop each, in one table. PX4 has the reference autopilot beside it.

use std::fmt::Write as _;
use std::io::Write as _;

use super::{Concluded, DropArgs, Pilot, begin, circumstances, conclude, plan_or_keep, tell_remarks};
use crate::cli::args::ChoiceArgs;
use crate::cli::mission::stamp_of;
use crate::cli::narrative::Narrator;
use crate::cli::outcome::{Answer, BadInput, Failure};
use crate::cli::output::{OutputFolder, print};
use samara::assess::Verdict;
use samara::units::DEG_PER_RAD;

const HEAD: &str = "\
case        flown by     J_TPF  peak pitch  peak pitch rate  peak speed  altitude lost  steady after
                                       deg            deg/s         m/s              m             s
";

/// Columns of `cases.csv`.
const COLUMNS: &str = "case,autopilot,j_tpf,peak_pitch_deg,peak_pitch_rate_deg_s,peak_speed_m_s,altitude_lost_m,steady_after_s,decided_by";

/// `samara drop --cases`.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    let (pilot, mut mission, narrator, folder) = begin(args)?;
    let Some(planned) = plan_or_keep(args, &mut mission, &folder, &narrator)? else { return Ok(Answer::No) };
    tell_remarks(&mission, &pilot.check(&mission, &planned.trajectory)?);
    let pilots = match pilot {
        Pilot::Reference(_) => vec![("reference", pilot)],
        Pilot::Px4(..) | Pilot::Px4Model(_) => {
            let name = pilot.name(&args.state);
            let own = ChoiceArgs { params: None, ..args.choice.clone() };
            vec![(name, pilot), ("reference", Pilot::Reference(own))]
        }
    };
    let quiet = Narrator::together(true);
    let (mut all_well, mut objects, mut kept) = (true, Vec::new(), Vec::new());
    let mut csv = format!("{}{COLUMNS}\n", stamp_of(&mission).csv_comment());
    narrator.say(HEAD)?;
    let cases: Vec<String> = mission.study.cases.iter().map(|case| case.name.clone()).collect();
    for case in &cases {
        let mut swinging = mission.clone();
        swinging.use_release_case(case).bad_input()?;
        for (name, pilot) in &pilots {
            let place = OutputFolder::create(Some(&folder.path().join(case).join(name)), &mission.name)?;
            planned.write_to(&place, &swinging)?;
            let flown = pilot.fly(args, &swinging, &planned.trajectory, &place, &quiet)?;
            let Concluded { verdict, answer, json, file } =
                conclude(&swinging, &planned, &flown, &circumstances(args), &place, &quiet)?;
            all_well &= answer == Answer::Yes;
            narrator.say(&row(case, name, verdict.as_ref()))?;
            if answer == Answer::No {
                let place = place.path().display();
                narrator
                    .say(&format!("  NOT OK: see {place}; `--case {case}` tells what happens in it\n"))?;
            }
            csv += &line(case, name, verdict.as_ref());
            objects.push(object(case, name, &json));
            kept.push(object(case, name, &file));
        }
    }
    folder.write("cases.csv", |out| out.write_all(csv.as_bytes()))?;
    folder.write("cases.json", |out| out.write_all(all(&kept).as_bytes()))?;
    folder.write_manifest("cases", &mission, &circumstances(args))?;
    if args.mission.json {
        print(&all(&objects))?;
    } else {
        narrator.say(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(if all_well { Answer::Yes } else { Answer::No })
}

fn object(case: &str, pilot: &str, drop: &str) -> String {
    format!("{{\"case\": \"{case}\", \"autopilot\": \"{pilot}\", \"drop\": {}}}", drop.trim_end())
}

fn all(objects: &[String]) -> String {
    format!("{{\"cases\": [\n{}\n]}}\n", objects.join(",\n"))
}

/// A line of `cases.csv`; empty fields where nothing was released or nothing became steady.
fn line(case: &str, pilot: &str, verdict: Option<&Verdict>) -> String {
    let mut line = format!("{case},{pilot}");
    let numbers: [fn(&Verdict) -> Option<f64>; 6] = [
        |v| Some(v.j_tpf),
        |v| Some(v.peak_pitch_rad.abs() * DEG_PER_RAD),
        |v| Some(v.peak_pitch_rate_rad_s.abs() * DEG_PER_RAD),
        |v| Some(v.peak_speed_m_s),
        |v| Some(v.altitude_lost_m),
        |v| v.steady_after_s,
    ];
    for number in numbers {
        // Writing to a String cannot fail.
        let _ = write!(line, ",{}", verdict.and_then(number).map_or(String::new(), |x| format!("{x:?}")));
    }
    line + &format!(",{}\n", verdict.map_or("", |v| v.decided_by))
}

fn row(case: &str, pilot: &str, verdict: Option<&Verdict>) -> String {
    let Some(v) = verdict else { return format!("{case:11} {pilot:9}  never released\n") };
    let steady = v.steady_after_s.map_or("never".to_owned(), |t| format!("{t:.2}"));
    format!(
        "{case:11} {pilot:9} {:8.4} {:11.2} {:16.2} {:11.2} {:14.1} {steady:>13}\n",
        v.j_tpf,
        v.peak_pitch_rad * DEG_PER_RAD,
        v.peak_pitch_rate_rad_s * DEG_PER_RAD,
        v.peak_speed_m_s,
        v.altitude_lost_m,
    )
}
