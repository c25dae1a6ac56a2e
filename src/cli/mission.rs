//! Missions as a verb uses them: read, with the choices of the command line put in.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};

use super::answer::{BadInput as _, Failure};
use super::args::{
    ChoiceArgs, EstimatorChoice, MissionArgs, PX4_DEFAULT, SetArgs, StateArgs, is_parameter_file,
};
use super::narrator::Narrator;
use super::terminal::{print, print_err, print_remarks};
use samara::config::shipped::is_built_in;
use samara::config::{Mission, load_mission_with, mission_path, plain_name};
use samara::params::metadata::Kind;
use samara::params::{Against, Check, Class, Finding, Metadata, ParameterFile, check};
use samara::replan::Cadence;
use samara::report::params::check_text;

/// The mission of a file or of a name, with what was set in it.
pub fn open_mission(name_or_path: &Path, set: &SetArgs) -> Result<Mission, Failure> {
    load_mission_with(&mission_path(name_or_path).bad_input()?, &set.set).bad_input()
}

/// A line for each name that was typed: the file that it means, or that it is built in. Nothing for a path.
pub fn origin(typed: &Path, mission: &Mission) -> String {
    let mut lines = String::new();
    if let Some(name) = plain_name(typed) {
        lines += &match is_built_in(&mission.file) {
            true => format!("mission {name}: built in\n"),
            false => format!("mission ./{}\n", mission.file.display()),
        };
    }
    // Beside a mission of one's own they may be taken for one's own, too.
    if is_built_in(&mission.inputs.gains_file) && !is_built_in(&mission.file) {
        lines += &format!("gains {}: built in\n", mission.control.gains_name);
    }
    lines
}

/// Prints [`origin`], but not beside a JSON object.
pub fn print_origin(args: &MissionArgs, mission: &Mission) -> Result<(), Failure> {
    if args.json { Ok(()) } else { print(&origin(&args.mission, mission)) }
}

/// The mission with the chosen gains and seed.
pub fn chosen_mission(name_or_path: &Path, choice: &ChoiceArgs) -> Result<Mission, Failure> {
    let mut mission = open_mission(name_or_path, &choice.set)?;
    if let Some(gains) = &choice.gains {
        if is_parameter_file(gains) {
            return Err(Failure::input(format!(
                "--gains {gains}: a parameter file is chosen with --params; a gains file (JSON) is expected, or a name"
            )));
        }
        mission.use_gains(gains).bad_input()?;
    }
    if let Some(path) = &choice.params {
        print_remarks(path.display(), &mission.use_parameters(path).bad_input()?);
    }
    if let Some(seed) = choice.seed {
        mission.use_seed(seed);
    }
    if let Some(case) = &choice.case {
        mission.use_release_case(case).bad_input()?;
    }
    Ok(mission)
}

/// The mission with its choices for flights from t = 0, and what there is to remark about it.
pub fn mission_from_t0(
    args: &MissionArgs,
    choice: &ChoiceArgs,
    narrator: &Narrator,
) -> Result<Mission, Failure> {
    let mission = chosen_mission(&args.mission, choice)?;
    mission.faults.check_from_t0().bad_input()?;
    narrator.say(&origin(&args.mission, &mission));
    let remarks = mission.t0_remarks().into_iter().chain(mission.battery_remark().map(str::to_owned));
    remarks.for_each(|remark| print_err(&format!("samara: {remark}\n")));
    Ok(mission)
}

/// Refuses a mission whose plan cannot be renewed at this cadence.
pub fn check_replan(mission: &Mission, cadence: Cadence) -> Result<(), Failure> {
    let refused = |why| Failure::input(format!("{}: {why}", mission.file.display()));
    mission.check_replan(cadence).map_err(refused)
}

/// Has a mission's plan renewed at this cadence: notes it, and puts in the gains that the mission has for it
/// where no others were chosen and the autopilot flies by the mission's gains. Refuses a plan that cannot be
/// renewed.
pub fn use_replan(
    mission: &mut Mission,
    cadence: Cadence,
    choice: &ChoiceArgs,
    by_gains: bool,
) -> Result<(), Failure> {
    check_replan(mission, cadence)?;
    mission.note_choice("replan", &cadence.to_string());
    if by_gains && choice.gains.is_none() && choice.params.is_none() {
        mission.use_replan_gains();
    }
    Ok(())
}

/// The mission with the chosen gains and seed, for a drop: refuses one that starts on the ground.
pub fn mission_with_a_drop(path: &Path, choice: &ChoiceArgs) -> Result<Mission, Failure> {
    let mission = chosen_mission(path, choice)?;
    has_a_drop(&mission)?;
    Ok(mission)
}

/// Refuses a mission that starts on the ground.
pub fn has_a_drop(mission: &Mission) -> Result<(), Failure> {
    if mission.release.standing {
        return Err(Failure::input(format!(
            "{}: the vehicle starts on the ground, there is no drop; fly it with `samara sim`, `samara autopilot` and a ground \
             station",
            mission.file.display()
        )));
    }
    Ok(())
}

/// The mission for a flight by PX4, and the parameter file that PX4 is given: the chosen one; where nothing
/// is chosen, the one that the mission names; with the gains [`PX4_DEFAULT`] an empty one. Without a file PX4
/// flies the mission's gains in its terms. `flown`: the version of PX4 that flies, where it is known.
pub fn mission_for_px4(
    path: &Path,
    choice: &ChoiceArgs,
    flown: Option<Against>,
) -> Result<(Mission, Option<ParameterFile>), Failure> {
    let choice = &choice.of_px4();
    let own = choice.px4s_own_gains();
    let others = ChoiceArgs { gains: choice.gains.clone().filter(|_| !own), params: None, ..choice.clone() };
    let mut mission = mission_with_a_drop(path, &others)?;
    if own {
        mission.control.gains_name = PX4_DEFAULT.to_owned();
        mission.note_choice("gains", PX4_DEFAULT);
        return Ok((mission, Some(ParameterFile::default())));
    }
    let chosen = (choice.gains.as_deref(), choice.params.as_deref());
    let Some(given) = px4_parameters(&mission, chosen) else { return Ok((mission, None)) };
    let file = mission.note_parameters(&given);
    let file = match choice.params {
        Some(_) => file.bad_input()?,
        None => file.with_context(|| format!("{}: px4_params", mission.file.display())).bad_input()?,
    };
    let check = check_of(&file, flown.unwrap_or_else(|| Against::of(&file)));
    let remarkable = match choice.params {
        Some(_) => !check.findings.is_empty() || check.unknown > 0 || !file.remarks().is_empty(),
        // What a drop needs is no news in a file that was chosen for it, nor that it is for other versions.
        None => check.findings.iter().any(|f| !matches!(f.class, Class::Needed | Class::OtherVersion)),
    };
    if remarkable {
        // What `samara params check` prints of a file.
        print_err(&check_text(&given.display().to_string(), &file, &check, &[], None));
    }
    is_useful(&check).with_context(|| given.display().to_string()).bad_input()?;
    Ok((mission, Some(file)))
}

/// The parameter file that PX4 flies by where gains and parameters of these names are chosen, or none: that
/// which is chosen, else the mission's own, unless gains are.
pub fn px4_parameters(mission: &Mission, (gains, params): (Option<&str>, Option<&Path>)) -> Option<PathBuf> {
    let named = mission.px4.params.clone().filter(|_| gains.is_none());
    params.map(Path::to_owned).or(named)
}

/// A file's own parameters against a version of PX4.
pub fn check_of(file: &ParameterFile, against: Against) -> Check {
    check(against, file.purpose(), file.own().map(|(name, entry)| (name, entry.value)))
}

/// Refuses a value that no PX4 would load, and a file that holds nothing of PX4's. What is of another version
/// goes over the wire in the type that the vehicle has.
pub fn is_useful(check: &Check) -> anyhow::Result<()> {
    let is_wrong =
        |f: &&Finding| f.class == Class::WrongType && !Metadata::is_ever(&f.name, Kind::of(f.value));
    match check.findings.iter().find(is_wrong) {
        Some(finding) => bail!("{}", finding.text()),
        None if check.known == 0 => bail!("none of PX4's parameters stands in it"),
        None => Ok(()),
    }
}

/// Notes the estimator among the mission's choices, where it is not the truth: the flight depends on it.
pub fn note_estimator(mission: &mut Mission, state: &StateArgs) {
    if state.estimator == EstimatorChoice::Ekf {
        mission.note_choice("estimator", "ekf");
    }
}
