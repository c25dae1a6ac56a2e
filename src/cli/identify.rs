//! `samara identify`: a vehicle out of flight logs.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::results::OutputFolder;
use super::terminal::print;
use samara::config::bounded::bytes_at_most;
use samara::config::{VehicleFile, identified_file, load_vehicle, read_flight_table, vehicle_path};
use samara::identify::{Settings, identify};
use samara::logged_flight::LoggedFlight;
use samara::model::rigid_body::MassProperties;
use samara::report::identified::IdentifyReport;
use samara::ulog::Ulog;

/// Larger logs are refused [bytes].
const LARGEST: u64 = 1 << 30;
/// Heaviest vehicle [kg], and strongest gravity [m/s^2].
const HEAVIEST_KG: f64 = 100_000.0;
const STRONGEST_M_S2: f64 = 100.0;

/// `samara identify`.
#[derive(Args, Debug)]
pub struct IdentifyArgs {
    /// Flight logs of one vehicle: PX4's or samara's own (.ulg), or tables (.csv).
    #[arg(value_name = "LOG", required = true)]
    pub logs: Vec<PathBuf>,
    /// The vehicle as it is known: a file, or a name of one.
    #[arg(long, value_name = "NAME|FILE")]
    pub vehicle: PathBuf,
    /// Mass in the flight [kg] [default: the vehicle's].
    #[arg(long, value_name = "KG")]
    pub mass: Option<f64>,
    /// Gravity where it was flown [m/s^2].
    #[arg(long, value_name = "M_S2", default_value_t = 9.80665)]
    pub gravity: f64,
    /// Write NAME.json and NAME.html [default: the vehicle's name and `_identified`].
    #[arg(long, value_name = "NAME")]
    pub out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Finds out what logs tell of a vehicle, and writes it.
pub fn run(args: &IdentifyArgs) -> Result<Answer, Failure> {
    for (name, value, most) in
        [("--mass", args.mass.unwrap_or(1.0), HEAVIEST_KG), ("--gravity", args.gravity, STRONGEST_M_S2)]
    {
        if !(value > 0.0 && value <= most) {
            return Err(Failure::input(format!(
                "{name}: expected a number above 0, up to {most}, found {value}"
            )));
        }
    }
    let path = vehicle_path(&args.vehicle).bad_input()?;
    let VehicleFile { name: base, mut vehicle, .. } = load_vehicle(&path).bad_input()?;
    let mass_kg = args.mass.unwrap_or(vehicle.mass.mass_kg);
    vehicle.mass = MassProperties::new(mass_kg, vehicle.mass.inertia_kg_m2).bad_input()?;
    let flights = args.logs.iter().map(|log| flight(log)).collect::<Result<Vec<_>, _>>()?;
    let settings = Settings { gravity_m_s2: args.gravity, ..Settings::default() };
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
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from(format!("{base}_identified")));
    let Some(name) = out.file_name().and_then(|name| name.to_str()) else {
        return Err(Failure::input(format!("expected a name to write to, found {}", out.display())));
    };
    let name = name.strip_suffix(".json").unwrap_or(name);
    let told = (name, logs.join(", "), mass_kg);
    let file = identified_file(&path, (told.0, &told.1, told.2), &vehicle, &found).bad_input()?;
    let report = IdentifyReport {
        base: &base,
        vehicle: &vehicle,
        density_kg_m3: settings.density_kg_m3,
        logs: &logs,
        found: &found,
    };
    let document = report.document();
    let folder = OutputFolder::plain(out.parent().unwrap_or(Path::new("")))?;
    let mut written = vec![folder.write_text(&format!("{name}.json"), &file.text)?];
    if let Some((table, text)) = &file.table {
        written.push(folder.write_text(table, text)?);
    }
    written.push(folder.write_text(&format!("{name}.html"), &document.page())?);
    if args.json {
        print(&report.json())?;
    } else {
        let lines: String = written.iter().map(|path| format!("{}\n", path.display())).collect();
        print(&(document.text() + "\n" + &lines))?;
    }
    Ok(if found.found.is_empty() { Answer::No } else { Answer::Yes })
}

/// The flight of a log or of a table.
fn flight(path: &Path) -> Result<LoggedFlight, Failure> {
    let shown = path.display().to_string();
    let bytes = bytes_at_most(path, LARGEST).with_context(|| format!("cannot read {shown}")).bad_input()?;
    if Ulog::is_one(&bytes) || path.extension().is_none_or(|kind| !kind.eq_ignore_ascii_case("csv")) {
        let log = Ulog::read(&bytes).with_context(|| shown).bad_input()?;
        return Ok(LoggedFlight::of_ulog(&log));
    }
    let text = String::from_utf8(bytes).with_context(|| format!("{shown}: expected text")).bad_input()?;
    read_flight_table(&text, path).bad_input()
}
