//! `samara identify`: a vehicle out of flight logs.

use std::path::{Path, PathBuf};

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::log::flight;
use super::mission::open_mission;
use super::results::OutputFolder;
use super::set::SetArgs;
use super::system::threads;
use super::terminal::print;
use samara::config::{VehicleFile, identified_file, load_vehicle, vehicle_path};
use samara::identify::{IdentifyError, Parameter, Settings, identify};
use samara::manoeuvre::{Kind, Recipe, Step, Trial, USUAL, Wanted};
use samara::model::rigid_body::MassProperties;
use samara::report::document::Document;
use samara::report::identified::IdentifyReport;
use samara::report::manoeuvre::ManoeuvreReport;
use samara::study::manoeuvre::rehearsal;

/// Heaviest vehicle [kg], and strongest gravity [m/s^2].
const HEAVIEST_KG: f64 = 100_000.0;
const STRONGEST_M_S2: f64 = 100.0;
/// Densest air [kg/m^3].
const DENSEST_KG_M3: f64 = 100.0;

/// `samara identify`.
#[derive(Args, Debug)]
pub struct IdentifyArgs {
    /// Flight logs of one vehicle: PX4's or samara's own (.ulg), or tables (CSV, Parquet).
    #[arg(value_name = "LOG", required_unless_present = "manoeuvre", conflicts_with = "manoeuvre")]
    pub logs: Vec<PathBuf>,
    /// The vehicle as it is known: a file, or a name of one.
    #[arg(
        long,
        value_name = "NAME|FILE",
        required_unless_present = "manoeuvre",
        conflicts_with = "manoeuvre"
    )]
    pub vehicle: Option<PathBuf>,
    /// Mass in the flight [kg] [default: the vehicle's].
    #[arg(long, value_name = "KG", conflicts_with = "manoeuvre")]
    pub mass: Option<f64>,
    /// Gravity where it was flown [m/s^2].
    #[arg(long, value_name = "M_S2", default_value_t = 9.80665, conflicts_with = "manoeuvre")]
    pub gravity: f64,
    /// Density of the air where it was flown [kg/m^3]; PX4's log has it by the pressure and a temperature of
    /// 15 deg C, before v1.16 of 20 [default: the log's, otherwise 1.225].
    #[arg(long, value_name = "KG_M3", conflicts_with = "manoeuvre")]
    pub density: Option<f64>,
    /// Instead, what to fly so that a log tells this mission's vehicle, and how well.
    #[arg(long, value_name = "MISSION")]
    pub manoeuvre: Option<PathBuf>,
    /// Largest standard error that is wanted, as inertia=2 or drag_along=10: percent, [ms] or [mm].
    #[arg(long, value_name = "QUANTITY=PERCENT", conflicts_with_all = ["logs", "vehicle"])]
    pub wanted: Vec<String>,
    /// Write NAME.json, NAME.html, .. [default: the vehicle's name and `_identified`, `_manoeuvre`].
    #[arg(long, value_name = "NAME")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Finds out what logs tell of a vehicle, and writes it.
pub fn run(args: &IdentifyArgs) -> Result<Answer, Failure> {
    let Some(vehicle) = &args.vehicle else { return manoeuvre(args) };
    for (name, value, most) in [
        ("--mass", args.mass.unwrap_or(1.0), HEAVIEST_KG),
        ("--gravity", args.gravity, STRONGEST_M_S2),
        ("--density", args.density.unwrap_or(1.0), DENSEST_KG_M3),
    ] {
        if !(value > 0.0 && value <= most) {
            return Err(Failure::input(format!(
                "{name}: expected a number above 0, up to {most}, found {value}"
            )));
        }
    }
    let path = vehicle_path(vehicle).bad_input()?;
    let VehicleFile { name: base, mut vehicle, .. } = load_vehicle(&path).bad_input()?;
    let mass_kg = args.mass.unwrap_or(vehicle.mass.mass_kg);
    vehicle.mass = MassProperties::new(mass_kg, vehicle.mass.inertia_kg_m2).bad_input()?;
    let mut flights = args.logs.iter().map(|log| flight(log)).collect::<Result<Vec<_>, _>>()?;
    let mut settings = Settings { gravity_m_s2: args.gravity, ..Settings::default() };
    if let Some(density_kg_m3) = args.density {
        settings.density_kg_m3 = density_kg_m3;
        flights.iter_mut().for_each(|flight| flight.density_kg_m3 = None);
    }
    let found = identify(&flights, &vehicle, &settings).map_err(|(log, error)| {
        Failure::input(format!(
            "{}: {error}",
            args.logs.get(log).map_or_else(String::new, |l| l.display().to_string())
        ))
    })?;
    let logs: Vec<String> = args
        .logs
        .iter()
        .map(|log| log.file_name().unwrap_or_default().to_string_lossy().into_owned())
        .collect();
    let (folder, name) = place(args, format!("{base}_identified"))?;
    let report = IdentifyReport {
        base: &base,
        vehicle: &vehicle,
        density_kg_m3: settings.density_kg_m3,
        logs: &logs,
        found: &found,
    };
    let document = report.document();
    let mut written = Vec::new();
    // Where nothing was found the vehicle is the one that was known, and it has its file.
    if !found.found.is_empty() {
        let logs = logs.join(", ");
        let file = identified_file(&path, (&name, &logs, mass_kg), &vehicle, &found).bad_input()?;
        written.push(folder.write_text(&format!("{name}.json"), &file.text)?);
        if let Some((table, text)) = &file.table {
            written.push(folder.write_text(table, text)?);
        }
    }
    written.push(folder.write_text(&format!("{name}.html"), &document.page())?);
    tell(args, &report.json(), &document, &written)?;
    Ok(if found.found.is_empty() { Answer::No } else { Answer::Yes })
}

/// Says what to fly, and writes what it is flown by. No: it does not come to all errors that are wanted.
fn manoeuvre(args: &IdentifyArgs) -> Result<Answer, Failure> {
    let Some(mission) = &args.manoeuvre else {
        return Err(Failure::input("--vehicle: expected, or --manoeuvre MISSION".to_owned()));
    };
    let wanted = wanted(&args.wanted)?;
    let mission = open_mission(mission, &SetArgs::default())?;
    let (rehearsal, bounds) = rehearsal(&mission).bad_input()?;
    let threads = threads(None)?;
    let told = |failed: IdentifyError| Failure::input(format!("what was flown says nothing: {failed}"));
    let trials = threads.each(&Kind::ALL, |kind| rehearsal.trial(*kind, &bounds, mission.seed));
    let trials: Vec<Trial> = trials.into_iter().collect::<Result<_, _>>().map_err(told)?;
    let seeds = [1, 2, 3, 4].map(|more| mission.seed.wrapping_add(more));
    let fly = |steps: &[Step]| -> Result<Vec<_>, IdentifyError> {
        threads.each(&seeds, |seed| rehearsal.expected(steps, *seed)).into_iter().collect()
    };
    let (recipe, expected) = Recipe::flown(&trials, &wanted, &bounds, fly).map_err(told)?;
    let report = ManoeuvreReport {
        mission: &mission.name,
        vehicle: &mission.vehicle_name,
        site: &mission.site.environment,
        bounds: &bounds,
        trials: &trials,
        recipe: &recipe,
        expected: &expected,
        wanted: &wanted,
    };
    let document = report.document();
    let (folder, name) = place(args, format!("{}_manoeuvre", mission.vehicle_name))?;
    let mut written = vec![
        folder.write_text(&format!("{name}.py"), &report.script())?,
        folder.write_text(&format!("{name}.html"), &document.page())?,
    ];
    if let Some(plan) = report.plan() {
        written.push(folder.write_text(&format!("{name}.plan"), &plan)?);
    }
    tell(args, &report.json(), &document, &written)?;
    Ok(Answer::from(report.missed().is_empty()))
}

/// The errors that are wanted: those that are given, otherwise the usual ones.
fn wanted(given: &[String]) -> Result<Wanted, Failure> {
    let mut wanted = USUAL;
    for one in given {
        let refuse = |found: &str| {
            let keys = Parameter::ALL.map(Parameter::key).join(", ");
            Failure::input(format!(
                "--wanted {one}: expected QUANTITY=PERCENT, above 0 and up to 100, QUANTITY one of {keys}, \
                 or the first word of some; found {found}"
            ))
        };
        let (key, number) = one.split_once('=').ok_or_else(|| refuse("no `=`"))?;
        let number: f64 = number.parse().map_err(|_| refuse(number))?;
        if !(number > 0.0 && number <= 100.0) {
            return Err(refuse(&number.to_string()));
        }
        let is_meant = |parameter: &Parameter| {
            parameter.key().strip_prefix(key).is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
        };
        let meant: Vec<Parameter> = Parameter::ALL.into_iter().filter(is_meant).collect();
        if meant.is_empty() {
            return Err(refuse(key));
        }
        for parameter in meant {
            wanted[parameter as usize] = if parameter.is_factor() { 1e-2 * number } else { 1e-3 * number };
        }
    }
    Ok(wanted)
}

/// Where results go, and their name.
fn place(args: &IdentifyArgs, usual: String) -> Result<(OutputFolder, String), Failure> {
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from(usual));
    let Some(name) = out.file_name().and_then(|name| name.to_str()) else {
        return Err(Failure::input(format!("expected a name to write to, found {}", out.display())));
    };
    let name = name.strip_suffix(".json").unwrap_or(name).to_owned();
    Ok((OutputFolder::plain(out.parent().unwrap_or(Path::new("")))?, name))
}

/// Prints a result, as text with the files that were written.
fn tell(args: &IdentifyArgs, json: &str, document: &Document, written: &[PathBuf]) -> Result<(), Failure> {
    if args.json {
        return print(json);
    }
    let lines: String = written.iter().map(|path| format!("{}\n", path.display())).collect();
    print(&(document.text() + "\n" + &lines))
}
