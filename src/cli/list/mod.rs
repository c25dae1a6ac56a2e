//! `samara list`: what can be named, and what was flown.
//!
//! | file | holds |
//! |---|---|
//! | `runs` | results below a folder |
//! | this one | missions, vehicles and gains; text and JSON of all |

pub mod runs;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde_json::{Map, Value, json};

use super::answer::{Answer, Failure};
use super::terminal::print;
use samara::config::shipped::is_built_in;
use samara::config::{
    ConfigError, GainsFile, Listed, Mission, VehicleFile, listed_gains, listed_missions, listed_vehicles,
};
use samara::printable::printable;
use samara::report::json::VERSION;

/// Columns of a line of the terminal.
const WIDTH: usize = 100;
/// Runs that are shown where everything is listed.
const NEWEST: usize = 8;

/// What is listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Missions: the argument of most verbs.
    Missions,
    /// Vehicles: for `samara new mission` and `samara rotor`.
    Vehicles,
    /// Gains: for --gains.
    Gains,
    /// Folders of results.
    Runs,
}

impl Kind {
    const fn name(self) -> &'static str {
        match self {
            Self::Missions => "missions",
            Self::Vehicles => "vehicles",
            Self::Gains => "gains",
            Self::Runs => "runs",
        }
    }
}

/// `samara list`.
#[derive(Args, Debug)]
pub struct ListArgs {
    /// List these alone [default: all four].
    #[arg(value_name = "KIND", value_enum)]
    pub kind: Option<Kind>,
    /// Folder below which runs are looked for.
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    pub json: bool,
}

/// A part of the list: the head of its columns, its rows, the last cell of each of any length, and its
/// objects.
struct Part {
    head: &'static [&'static str],
    rows: Vec<Vec<String>>,
    objects: Vec<Value>,
}

/// Lists what was asked for.
pub fn run(args: &ListArgs) -> Result<Answer, Failure> {
    let all = [Kind::Missions, Kind::Vehicles, Kind::Gains, Kind::Runs];
    let asked = all.into_iter().filter(|kind| args.kind.is_none_or(|only| only == *kind));
    let parts = asked.map(|kind| Ok((kind, part(kind, args)?))).collect::<Result<Vec<_>, Failure>>()?;
    print(&if args.json {
        let head = [("version".to_owned(), json!(VERSION))];
        let objects = parts.into_iter().map(|(kind, part)| (kind.name().to_owned(), part.objects.into()));
        format!("{:#}\n", Value::Object(head.into_iter().chain(objects).collect::<Map<_, _>>()))
    } else {
        let texts = parts.iter().map(|(kind, part)| text(*kind, part, args));
        texts.collect::<Vec<_>>().join("\n")
    })?;
    Ok(Answer::Yes)
}

fn part(kind: Kind, args: &ListArgs) -> Result<Part, Failure> {
    Ok(match kind {
        Kind::Missions => missions(&listed_missions()),
        Kind::Vehicles => vehicles(&listed_vehicles()),
        Kind::Gains => gains(&listed_gains(), &listed_missions()),
        Kind::Runs => of_runs(&runs::below(&args.out)?),
    })
}

fn missions(listed: &[Listed<Mission>]) -> Part {
    let rows = listed.iter().map(|mission| {
        let vehicle = read(mission).map(|m| m.vehicle_name.clone());
        let world = read(mission).and_then(|m| m.site.world()).map(|world| world.name().to_owned());
        row(mission, [vehicle, world])
    });
    let objects = listed.iter().map(|mission| {
        let of = read(mission);
        object(
            mission,
            [
                ("vehicle", json!(of.map(|m| &m.vehicle_name))),
                ("planet", json!(of.and_then(|m| m.site.world()).map(|world| world.name()))),
                ("gains", json!(of.map(|m| &m.control.gains_name))),
            ],
        )
    });
    Part {
        head: &["mission", "vehicle", "planet", "from", "what"],
        rows: rows.collect(),
        objects: objects.collect(),
    }
}

fn vehicles(listed: &[Listed<VehicleFile>]) -> Part {
    let rows = listed.iter().map(|vehicle| {
        let of = read(vehicle).map(|file| &file.vehicle);
        row(vehicle, [of.map(|v| v.mass.mass_kg.to_string()), of.map(|v| v.rotors.len().to_string())])
    });
    let objects = listed.iter().map(|vehicle| {
        let of = read(vehicle).map(|file| &file.vehicle);
        let mass_kg = json!(of.map(|v| v.mass.mass_kg));
        object(vehicle, [("mass_kg", mass_kg), ("rotors", json!(of.map(|v| v.rotors.len())))])
    });
    Part {
        head: &["vehicle", "mass [kg]", "rotors", "from", "what"],
        rows: rows.collect(),
        objects: objects.collect(),
    }
}

/// Gains, and the vehicles of the missions that name them: a file of gains itself names none.
fn gains(listed: &[Listed<GainsFile>], missions: &[Listed<Mission>]) -> Part {
    let vehicles = |file: &GainsFile| {
        let missions = missions.iter().filter_map(read);
        let own = missions.filter(|m| m.control.gains_name == file.name && m.control.gains == file.gains);
        let mut vehicles: Vec<&str> = own.map(|m| m.vehicle_name.as_str()).collect();
        vehicles.sort_unstable();
        vehicles.dedup();
        vehicles
    };
    let words = |file: &GainsFile| Some(vehicles(file).join(", ")).filter(|words| !words.is_empty());
    let rows = listed.iter().map(|gains| row(gains, [read(gains).and_then(words)]));
    let objects = listed
        .iter()
        .map(|gains| object(gains, [("vehicles", json!(read(gains).map(vehicles).unwrap_or_default()))]));
    Part {
        head: &["gains", "of missions with", "from", "what"],
        rows: rows.collect(),
        objects: objects.collect(),
    }
}

fn of_runs(found: &[runs::Run]) -> Part {
    let row = |run: &runs::Run| {
        let verdict = run.verdict.map_or("-", runs::Verdict::words);
        let [folder, verb, mission, version, written] =
            [&run.folder, &run.verb, &run.mission, &run.version, &run.written].map(Clone::clone);
        vec![folder, verb, mission, version, verdict.to_owned(), written]
    };
    Part {
        head: &["run", "verb", "mission", "version", "verdict", "written"],
        rows: found.iter().map(row).collect(),
        objects: found.iter().map(runs::Run::object).collect(),
    }
}

fn read<T>(listed: &Listed<T>) -> Option<&T> {
    listed.read.as_ref().ok()
}

/// The place of a file in words: its folder.
fn from(path: &Path) -> String {
    let folder = path.parent().unwrap_or(path);
    if is_built_in(path) { "built in".to_owned() } else { format!("./{}", folder.display()) }
}

/// What a file says of itself, or why it is refused.
fn what<T>(listed: &Listed<T>) -> String {
    match &listed.read {
        Err(refused) => format!("NOT read: {refused}"),
        Ok(_) => listed.about.clone().unwrap_or_default(),
    }
}

fn row<T, const N: usize>(listed: &Listed<T>, between: [Option<String>; N]) -> Vec<String> {
    let between = between.into_iter().map(|cell| cell.unwrap_or_else(|| "-".to_owned()));
    let ends = [from(&listed.path), what(listed)];
    std::iter::once(listed.name.clone()).chain(between).chain(ends).collect()
}

fn object<T, const N: usize>(listed: &Listed<T>, between: [(&str, Value); N]) -> Value {
    let refused = listed.read.as_ref().err().map(ConfigError::to_string);
    let ends = [
        ("path", json!(listed.path.display().to_string())),
        ("built_in", json!(is_built_in(&listed.path))),
        ("about", json!(listed.about)),
        ("refused", json!(refused)),
    ];
    let keys = std::iter::once(("name", json!(listed.name))).chain(between).chain(ends);
    Value::Object(keys.map(|(key, value)| (key.to_owned(), value)).collect())
}

/// A part as a table whose columns stand to the left; the last one is cut at the terminal's width.
fn text(kind: Kind, part: &Part, args: &ListArgs) -> String {
    if part.rows.is_empty() {
        let place = if kind == Kind::Runs { format!(" below {}", args.out.display()) } else { String::new() };
        return format!("no {}{place}\n", kind.name());
    }
    let shown = if args.kind.is_none() && kind == Kind::Runs { NEWEST } else { usize::MAX };
    let head = part.head.iter().map(|cell| (*cell).to_owned()).collect();
    // Cells are one line each, whatever files are named and say.
    let fit = |row: &Vec<String>| row.iter().map(|cell| printable(cell).into_owned()).collect();
    let lines: Vec<Vec<String>> =
        std::iter::once(head).chain(part.rows.iter().take(shown).map(fit)).collect();
    let width = |column: usize| {
        lines.iter().filter_map(|line| line.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..part.head.len()).map(width).collect();
    let mut table = String::new();
    for line in &lines {
        let cells = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:width$}"));
        let whole = cells.collect::<Vec<_>>().join("  ");
        table += &(cut(whole.trim_end()) + "\n");
    }
    match part.rows.len().saturating_sub(shown) {
        0 => table,
        more => format!("{table}and {more} more: samara list runs\n"),
    }
}

/// A line that fits the terminal.
fn cut(line: &str) -> String {
    if line.chars().count() <= WIDTH {
        return line.to_owned();
    }
    let begin: String = line.chars().take(WIDTH - 3).collect();
    format!("{} ..", begin.trim_end())
}
