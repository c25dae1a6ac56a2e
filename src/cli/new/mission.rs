//! `samara new mission`: a mission for a vehicle, and gains that fly it.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::ask::Questions;
use super::files::{new_file, place, schema};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::{measured, plain_name, positive_in, three};
use crate::cli::planning::{plan_mission, solve};
use crate::cli::results::OutputFolder;
use crate::cli::terminal::{print, print_err};
use samara::config::draft::{DRAFT_NODES, MissionDraft, ReleasedFrom, mission_draft_json};
use samara::config::shipped::is_built_in;
use samara::config::{Mission, derived, gains_json, load_mission, load_vehicle, relative, vehicle_path};
use samara::hints::No;
use samara::model::Planet;
use samara::plan::{Plan, SolverOptions, Status};
use samara::report::hint::Hint;
use samara::report::plan_text;
use samara::study::first_gains::{LEAST_MODULUS, RANDOM_DROPS, StoppedBy, gains_that_fly, guessed_gains};

/// `samara new mission`.
#[derive(Args, Debug)]
pub struct MissionArgs {
    /// Name of the mission: letters, digits, _ and -.
    #[arg(value_parser = plain_name)]
    name: Option<String>,
    /// The vehicle: a file, or a name - of a file in ./params/vehicles, or of a vehicle that samara brings
    /// along.
    #[arg(long, value_name = "NAME|FILE")]
    vehicle: Option<PathBuf>,
    /// Where it is: earth, titan or mars.
    #[arg(long, value_name = "PLANET", value_parser = planet)]
    planet: Option<Planet>,
    /// Altitude of the release above mean sea level [m].
    #[arg(long, value_name = "M", value_parser = altitude)]
    altitude: Option<f64>,
    /// What the vehicle is released from: parachute or balloon.
    #[arg(long, value_name = "parachute|balloon", value_parser = released_from, default_value = "parachute")]
    from: ReleasedFrom,
    /// Rate of descent under the parachute [m/s]; estimated when left out.
    #[arg(long, value_name = "M/S", value_parser = positive_in("m/s"))]
    descent: Option<f64>,
    /// Time between the release and the start of the rotors [s].
    #[arg(long, value_name = "S", value_parser = delay, default_value_t = 0.5)]
    delay: f64,
    /// Velocity to reach: north, east, down [m/s].
    #[arg(long, value_name = "N,E,D", value_parser = velocity, allow_hyphen_values = true, default_value = "2,0,1")]
    target: [f64; 3],
    /// Speed that the vehicle bears [m/s]; guessed when left out.
    #[arg(long, value_name = "M/S", value_parser = positive_in("m/s"))]
    speed_limit: Option<f64>,
    /// File to write [default: mission/NAME.json where there is that folder, else NAME.json].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    json: bool,
}

fn planet(text: &str) -> Result<Planet, String> {
    let known = Planet::ALL.map(Planet::name).join(", ");
    Planet::ALL.into_iter().find(|p| p.name() == text).ok_or_else(|| format!("one of {known} is expected"))
}

fn released_from(text: &str) -> Result<ReleasedFrom, String> {
    let known = ReleasedFrom::ALL.map(ReleasedFrom::name).join(" or ");
    ReleasedFrom::ALL.into_iter().find(|f| f.name() == text).ok_or_else(|| format!("{known} is expected"))
}

fn altitude(text: &str) -> Result<f64, String> {
    measured(text, "m", f64::is_finite, "an altitude in metres is expected")
}

fn delay(text: &str) -> Result<f64, String> {
    measured(text, "s", |x| (0.0..=60.0).contains(&x), "a time from 0 to 60 s is expected")
}

fn velocity(text: &str) -> Result<[f64; 3], String> {
    three(
        text,
        "m/s",
        |x| x.abs() <= 100.0,
        "three components of a velocity, N,E,D, each up to 100 m/s, are expected",
    )
}

/// Writes the mission and its gains; No when no gains were found that fly it.
pub fn run(args: &MissionArgs) -> Result<Answer, Failure> {
    let mut ask = Questions::new();
    let name = ask.ask(args.name.as_ref(), "NAME", "name of the mission", plain_name)?;
    let path = |text: &str| Ok(PathBuf::from(text));
    let vehicle = ask.ask(args.vehicle.as_ref(), "--vehicle", "vehicle (a file or a name)", path)?;
    let planet = ask.ask(args.planet.as_ref(), "--planet", "planet (earth, titan, mars)", planet)?;
    let altitude = ask.ask(args.altitude.as_ref(), "--altitude", "altitude of the release [m]", altitude)?;
    ask.finish()?;
    let (Some(name), Some(vehicle), Some(planet), Some(altitude_m)) = (name, vehicle, planet, altitude)
    else {
        return Err(Failure::input("a name and the options without a default are expected".to_owned()));
    };
    let vehicle_file = vehicle_path(&vehicle).bad_input()?;
    let vehicle = load_vehicle(&vehicle_file).bad_input()?.vehicle;

    let file = new_file(args.out.as_deref(), "mission", &name)?;
    let (folder, file_name) = place(&file)?;
    let gains_folder =
        Some(Path::new("params/gains")).filter(|f| args.out.is_none() && f.is_dir()).unwrap_or(&folder);
    let gains_name = format!("{name}_gains");
    let gains_file = gains_folder.join(format!("{gains_name}.json"));
    if gains_file.exists() {
        let shown = gains_file.display();
        return Err(Failure::input(format!(
            "{shown} is there already, and nothing was written; another name is expected"
        )));
    }
    let output = OutputFolder::plain(&folder)?;
    let gains_output = OutputFolder::plain(gains_folder)?;
    let mut draft = MissionDraft {
        name,
        vehicle: match is_built_in(&vehicle_file) {
            true => vehicle_file.display().to_string(),
            false => relative(&folder, &vehicle_file),
        },
        gains: String::new(),
        planet,
        altitude_m,
        from: args.from,
        descent_m_s: args.descent,
        delay_s: args.delay,
        target_v_ned: args.target,
        speed_limit_m_s: args.speed_limit,
        nodes: DRAFT_NODES,
        schema: schema(&folder, "mission.schema.json"),
    };
    // Refused before anything is written.
    mission_draft_json(&draft, &vehicle).bad_input()?;
    let density = planet.density_kg_m3(altitude_m).bad_input()?;
    let first = guessed_gains(&vehicle, density);
    gains_output.write_text(&format!("{gains_name}.json"), &gains_json(&gains_name, "A guess.", &first))?;
    draft.gains = relative(&folder, &gains_file);
    output.write_text(&file_name, &mission_draft_json(&draft, &vehicle).bad_input()?)?;
    let (mission, plan) = enough_nodes(load_mission(&file).bad_input()?, |nodes| {
        draft.nodes = nodes;
        output.write_text(&file_name, &mission_draft_json(&draft, &vehicle).bad_input()?)?;
        load_mission(&file).bad_input()
    })?;

    let (shown, gains_shown) = (file.display().to_string(), gains_file.display().to_string());
    let no = |why: String, hint: Hint| {
        print_err(&format!("samara: {shown} is written, but {why}\n"));
        for odd in derived(&mission).odd {
            print_err(&format!("samara: {odd}\n{}", Hint::of(odd.no, &mission).lines()));
        }
        print_err(&hint.lines());
        Ok(Answer::No)
    };
    if plan.status != Status::Converged {
        let why = format!("has no plan: {}", plan_text(&mission, &plan, None).trim_end());
        return no(why, Hint::of(plan.no.unwrap_or(No::PlanFails), &mission));
    }
    let Some(found) = gains_that_fly(&mission, &plan.trajectory) else {
        let why = format!("no gains were found that fly it; {gains_shown} holds a guess");
        return no(why, Hint::of(No::NoGainsFly, &mission));
    };
    let after_s = found.verdict.outcome.steady_after_s.unwrap_or(f64::NAN);
    let (worst, steady_s) = found.worst_and_steady();
    let (modulus, delay_s) = found.margins;
    let random = format!(
        "of {RANDOM_DROPS} random drops with everything unknown {} unsafe, worst J_TPF {worst:.3}, steady after {steady_s:.1} s in the \
         mean; loops {modulus:.2} from instability, by a delay {:.0} ms",
        if found.unsafe_drops == 0 { "none".to_owned() } else { found.unsafe_drops.to_string() },
        1e3 * delay_s,
    );
    let stopped = found.stopped_by.map_or_else(String::new, |by| {
        let (of, state) = found.nearest;
        let why = match by {
            StoppedBy::UnsafeDrops(drops) => format!("gains that keep more leave {drops} drops unsafe"),
            StoppedBy::NoSet => "no gains that fly the drop keep more".to_owned(),
        };
        format!(", less than {LEAST_MODULUS} by the loop of {of} at the {state}: {why}")
    });
    let random = format!("{random}{stopped}");
    let about = format!(
        "By samara new mission for {}: {}. Flown: J_TPF {:.3}, steady after {after_s:.1} s; {random}. samara design finds better ones.",
        mission.name, found.about, found.verdict.outcome.j_tpf
    );
    gains_output.write_text(&format!("{gains_name}.json"), &gains_json(&gains_name, &about, &found.gains))?;
    print(&if args.json {
        let outcome = &found.verdict.outcome;
        let flown = json!({
            "j_tpf": outcome.j_tpf,
            "steady_after_s": outcome.steady_after_s,
            "random_drops": RANDOM_DROPS,
            "unsafe_drops": found.unsafe_drops,
            "worst_j_tpf": worst,
            "modulus": modulus,
            "delay_margin_s": delay_s,
        });
        format!(
            "{:#}\n",
            json!({ "mission": mission.name, "file": shown, "gains_file": gains_shown, "flown": flown })
        )
    } else {
        let path = if shown.contains('/') { shown.clone() } else { format!("./{shown}") };
        format!(
            "{shown}: its `about`s say what is estimated and guessed\n{gains_shown}: {}; flown: J_TPF {:.3}, steady after {after_s:.1} s;\n  {random}\n\
             next:\n  samara check {path}\n  samara drop {path}\n",
            found.about, found.verdict.outcome.j_tpf
        )
    })?;
    Ok(Answer::Yes)
}

/// The draft and its plan, with as many nodes as tell what flies along it: `with_nodes` drafts it with so
/// many.
fn enough_nodes(
    draft: Mission,
    with_nodes: impl FnOnce(usize) -> Result<Mission, Failure>,
) -> Result<(Mission, Plan), Failure> {
    let options = SolverOptions::default();
    let plan = solve(&draft, &options, false, None)?.plan;
    if plan.status != Status::Converged || draft.is_told_by_nodes(&draft.integrated(&plan.trajectory)) {
        return Ok((draft, plan));
    }
    match draft.nodes_enough(&options, &mut |_| ControlFlow::Continue(())).bad_input()? {
        Some(nodes) => {
            let finer = with_nodes(nodes)?;
            let plan = plan_mission(&finer, false)?.plan;
            Ok((finer, plan))
        }
        None => Ok((draft, plan)),
    }
}
