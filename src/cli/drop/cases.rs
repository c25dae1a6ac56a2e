//! `samara drop --cases`: the mission's release cases (Table 3), a drop each, in one table. PX4 has the reference autopilot beside it.

use super::{Concluded, DropArgs, Pilot, begin, conclude, plan_or_keep};
use crate::assess::Verdict;
use crate::cli::args::ChoiceArgs;
use crate::cli::narrative::Narrator;
use crate::cli::outcome::{Answer, BadInput, Failure};
use crate::cli::output::{OutputFolder, print};
use crate::units::DEG_PER_RAD;

const HEAD: &str = "\
case        flown by     J_TPF  peak pitch  peak pitch rate  peak speed  altitude lost  steady after
                                       deg            deg/s         m/s              m             s
";

/// `samara drop --cases`.
pub fn run(args: &DropArgs) -> Result<Answer, Failure> {
    let (pilot, mut mission, narrator, folder) = begin(args)?;
    let Some(planned) = plan_or_keep(args, &mut mission, &folder, &narrator)? else { return Ok(Answer::No) };
    let pilots = match pilot {
        Pilot::Reference(_) => vec![("reference", pilot)],
        Pilot::Px4(..) | Pilot::Px4Model(_) => {
            let name = if matches!(pilot, Pilot::Px4(..)) { "px4" } else { "px4-model" };
            let own = ChoiceArgs { params: None, ..args.choice.clone() };
            vec![(name, pilot), ("reference", Pilot::Reference(own))]
        }
    };
    let quiet = Narrator::together(true);
    let (mut all_well, mut objects) = (true, Vec::new());
    narrator.say(HEAD)?;
    let cases: Vec<String> = mission.tuning_cases.iter().map(|case| case.name.clone()).collect();
    for case in &cases {
        let mut swinging = mission.clone();
        swinging.use_release_case(case).bad_input()?;
        for (name, pilot) in &pilots {
            let place = OutputFolder::create(Some(&folder.path().join(case).join(name)), &mission.name)?;
            planned.write_to(&place, &swinging)?;
            let flown = pilot.fly(args, &swinging, &planned.trajectory, &place, &quiet)?;
            let Concluded { verdict, answer, json } =
                conclude(args, &swinging, &planned, &flown, &place, &quiet)?;
            all_well &= answer == Answer::Yes;
            narrator.say(&row(case, name, verdict.as_ref()))?;
            if answer == Answer::No {
                let place = place.path().display();
                narrator
                    .say(&format!("  NOT OK: see {place}; `--case {case}` tells what happens in it\n"))?;
            }
            objects.push(format!(
                "{{\"case\": \"{case}\", \"autopilot\": \"{name}\", \"drop\": {}}}",
                json.trim_end()
            ));
        }
    }
    if args.mission.json {
        print(&format!("{{\"cases\": [\n{}\n]}}\n", objects.join(",\n")))?;
    } else {
        narrator.say(&format!("results in {}\n", folder.path().display()))?;
    }
    Ok(if all_well { Answer::Yes } else { Answer::No })
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
