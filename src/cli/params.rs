//! `samara params`: PX4 parameter files written, checked and compared.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use serde_json::{Value, json};

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{ChoiceArgs, DEFAULT_MISSION, SetArgs, px4_version};
use super::mission::{
    check_of, chosen_mission, has_a_drop, is_useful, mission_for_px4, open_mission, origin,
};
use super::pilot::px4::upload::{exported, whole};
use super::pilot::px4_model;
use super::planning::plan_mission;
use super::results::{OutputFolder, place_of};
use super::terminal::print;
use samara::autopilot::parameters::document::{Listed, listed, markdown};
use samara::config::{Mission, check_for_px4, load_parameters};
use samara::control::px4::versions::Number;
use samara::control::px4::{Law, is_quad_x};
use samara::params::compatibility::written_for;
use samara::params::{
    Against, Export, Metadata, Mixing, ParameterFile, Purpose, diff, export, export_for_version, import,
};
use samara::plan::Status;
use samara::report::params::Way;
use samara::report::{params as report, plan_text};

/// `samara params`.
#[derive(Args, Debug)]
pub struct ParamsArgs {
    /// What to do.
    #[command(subcommand)]
    verb: ParamsVerb,
}

#[derive(Debug, Subcommand)]
enum ParamsVerb {
    /// Write a mission's gains and vehicle as PX4 parameters.
    #[command(after_long_help = include_str!("help/params_export.txt"))]
    Export(ExportArgs),
    /// Hold a file against PX4's types and ranges.
    #[command(after_long_help = include_str!("help/params_check.txt"))]
    Check(CheckArgs),
    /// Compare two files.
    #[command(after_long_help = include_str!("help/params_diff.txt"))]
    Diff(DiffArgs),
    /// Print what samara's own autopilot has for parameters, and what each does, as Markdown.
    List(ListArgs),
}

#[derive(Args, Debug)]
struct ListArgs {
    /// Print one JSON object instead: `parameters`, a list of name, type, unit, default, range, about, here.
    #[arg(long)]
    json: bool,
}

#[derive(Args, Debug)]
struct ExportArgs {
    /// The mission: a file, or a name - of a file in ./mission, or of a mission that samara brings along.
    #[arg(value_name = "NAME|FILE", default_value = DEFAULT_MISSION)]
    mission: PathBuf,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    set: SetArgs,
    /// Gains: a file, or a name - beside the mission's own gains, or of gains that samara brings along (ours,
    /// safety, near_hover, paper_pso); with --drop `px4_default`: PX4's own.
    #[arg(long, value_name = "NAME|FILE")]
    gains: Option<String>,
    /// What the file shall be for.
    #[arg(long = "for", value_enum, default_value_t = PurposeArg::Samara)]
    purpose: PurposeArg,
    /// All that `samara drop --autopilot px4=DIR` gives to PX4: the mission's `px4_params` where no --gains
    /// are chosen, and what a drop needs besides, with the mission's plan.
    #[arg(long)]
    drop: bool,
    /// With --drop: for a PX4 that allocates by CA_* (v1.14 and later) instead of mixing by `quad_x`; any
    /// other vehicle than a quadrotor in X needs it.
    #[arg(long, requires = "drop")]
    allocated: bool,
    /// The version of PX4 that the file is for: what that has no counterpart of is refused, what it has not
    /// is left out, types are its own, and it settles --allocated [default: v1.14 and later, with --drop
    /// v1.12].
    #[arg(long, visible_alias = "px4", value_name = "VERSION", value_parser = px4_version)]
    #[arg(conflicts_with = "allocated")]
    px4_version: Option<Number>,
    /// The file; `-` for stdout [default: out/<mission name>/<vehicle>_<for>.params, with --drop
    /// <vehicle>_<for>_drop.params].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Args, Debug)]
struct CheckArgs {
    /// The parameter file.
    file: PathBuf,
    /// The version of PX4 to hold it against [default: the file's, by its line `# Version:`, else the
    /// newest known].
    #[arg(long, value_name = "VERSION", value_parser = px4_version)]
    px4: Option<Number>,
    /// What the file is to be for.
    #[arg(long = "for", value_enum)]
    purpose: Option<PurposeArg>,
    /// A mission whose vehicle samara is to fly with it, by file or by name.
    #[arg(long, value_name = "NAME|FILE")]
    mission: Option<PathBuf>,
    /// Other values of the mission's and the vehicle's keys.
    #[command(flatten)]
    set: SetArgs,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Args, Debug)]
struct DiffArgs {
    /// A parameter file.
    a: PathBuf,
    /// Another one.
    b: PathBuf,
    /// The version of PX4 that describes them [default: each file's, by its line `# Version:`, else the
    /// newest known].
    #[arg(long, value_name = "VERSION", value_parser = px4_version)]
    px4: Option<Number>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum PurposeArg {
    /// samara's own autopilot: SI gains under the site's gravity.
    Samara,
    /// Unmodified PX4, which takes 9.80665 m/s^2 for gravity.
    Px4,
    /// PX4 with clock, velocities and rates scaled to 9.80665 m/s^2.
    Px4Froude,
}

impl PurposeArg {
    fn purpose(self) -> Purpose {
        match self {
            Self::Samara => Purpose::Samara,
            Self::Px4 => Purpose::Px4,
            Self::Px4Froude => Purpose::Px4Froude,
        }
    }
}

/// Writes, checks, compares or lists parameters.
pub fn run(args: &ParamsArgs) -> Result<Answer, Failure> {
    match &args.verb {
        ParamsVerb::Export(args) => run_export(args),
        ParamsVerb::Check(args) => run_check(args),
        ParamsVerb::Diff(args) => run_diff(args),
        ParamsVerb::List(args) => {
            print(&if args.json { list_json() } else { markdown() })?;
            Ok(Answer::Yes)
        }
    }
}

/// The parameters of samara's own autopilot as an object.
fn list_json() -> String {
    let each = |Listed { name, kind, unit, default, range, about, here }: Listed| {
        json!({
            "name": name, "type": kind, "unit": unit, "default": default, "range": range, "about": about, "here": here
        })
    };
    let parameters: Vec<Value> = listed().into_iter().map(each).collect();
    format!("{:#}\n", json!({ "version": env!("CARGO_PKG_VERSION"), "parameters": parameters }))
}

fn run_export(args: &ExportArgs) -> Result<Answer, Failure> {
    let choice = ChoiceArgs { gains: args.gains.clone(), set: args.set.clone(), ..ChoiceArgs::default() };
    let (mission, export) = if args.drop {
        let (mission, given) = mission_for_px4(&args.mission, &choice, args.px4_version.map(Against::asked))?;
        let export = of_a_drop(args, &mission, given.as_ref())?;
        (mission, export)
    } else {
        let mission = chosen_mission(&args.mission, &choice)?;
        let (subject, purpose) = (mission.parameter_subject(), args.purpose.purpose());
        let export = match &args.px4_version {
            Some(version) => export_for_version(&subject, purpose, *version),
            None => export(&subject, purpose),
        };
        let export = export.bad_input()?;
        (mission, export)
    };
    let text = report::params_file(&mission, &export);
    let to_stdout = args.out.as_deref() == Some(Path::new("-"));
    if to_stdout && !args.json {
        print(&text)?;
        return Ok(Answer::Yes);
    }
    let path = match args.out.as_deref() {
        Some(path) if to_stdout => path.to_owned(),
        Some(path) => {
            let Some(name) = path.file_name() else {
                return Err(Failure::input(format!("--out {}: a file is expected", path.display())));
            };
            let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            let folder = OutputFolder::plain(parent)?;
            folder.write_text(&name.to_string_lossy(), &text)?;
            path.to_owned()
        }
        None => {
            let drop = if args.drop { "_drop" } else { "" };
            let purpose = export.purpose.name().replace('-', "_");
            let name = format!("{}_{purpose}{drop}.params", mission.vehicle_name);
            OutputFolder::plain(&place_of(None, &mission.name))?.write_text(&name, &text)?
        }
    };
    let path = path.display().to_string();
    print(&if args.json {
        report::export_json(&mission, &path, &export)
    } else {
        format!("{}{path}: {}", origin(&args.mission, &mission), report::export_text(&export))
    })?;
    Ok(Answer::Yes)
}

/// What a drop gives to PX4.
fn of_a_drop(args: &ExportArgs, mission: &Mission, given: Option<&ParameterFile>) -> Result<Export, Failure> {
    let (wanted, of_mission) = (args.purpose.purpose(), mission.px4_purpose());
    if wanted != of_mission {
        return Err(Failure::input(format!(
            "--drop: PX4 flies this mission, by its px4_clock, with parameters for {0}; --for {0} is expected, not {1}",
            of_mission.name(),
            wanted.name()
        )));
    }
    let mixing = args.px4_version.map(Mixing::of_version);
    let allocated = mixing.map_or(args.allocated, |mixing| mixing == Mixing::Allocated);
    if !allocated && let Err(reason) = is_quad_x(&mission.vehicle) {
        return Err(Failure::input(format!(
            "--drop is for a PX4 that mixes by the file `quad_x` (v1.12), and {reason}; with --drop --allocated it is for PX4 v1.14 and \
             later, which takes the rotors from CA_*"
        )));
    }
    check_for_px4(mission).bad_input()?;
    let timed = plan_mission(mission, false)?;
    if timed.plan.status != Status::Converged {
        let text = plan_text(mission, &timed.plan, None);
        return Err(Failure::input(format!("no plan to fly: {text}")));
    }
    let whole = || whole(mission, &timed.plan.trajectory, given, !allocated);
    let Some(version) = args.px4_version else { return whole() };
    if given.is_none() {
        export_for_version(&mission.parameter_subject(), wanted, version).bad_input()?;
    }
    Ok(whole()?.for_version(Against::asked(version)))
}

fn run_check(args: &CheckArgs) -> Result<Answer, Failure> {
    let file = load_parameters(&args.file).bad_input()?;
    if file.entries().next().is_none() {
        return Err(Failure::input(format!("{}: there is no parameter in it", args.file.display())));
    }
    let against = args.px4.map_or_else(|| Against::of(&file), Against::asked);
    let check = check_of(&file, against);
    let ways = match &args.mission {
        Some(mission) => ways(&open_mission(mission, &args.set)?, &file),
        None => Vec::new(),
    };
    let refusal = for_another(args, &file).or_else(|| {
        let nobody = !ways.is_empty() && ways.iter().all(|way| way.refusal.is_some());
        nobody.then(|| "nobody flies the mission with it".to_owned())
    });
    let name = args.file.display().to_string();
    let words = if args.json { report::check_json } else { report::check_text };
    print(&words(&name, &file, &check, &ways, refusal.as_deref()))?;
    Ok(Answer::from(check.passes() && refusal.is_none()))
}

/// Why the file is not for what it is to be for. What PX4's ground stations and its shell write is PX4's.
fn for_another(args: &CheckArgs, file: &ParameterFile) -> Option<String> {
    let wanted = args.purpose.map(PurposeArg::purpose).filter(|p| file.purpose() != Some(*p))?;
    if wanted == Purpose::Px4 && file.purpose().is_none() && file.is_of_px4() {
        return None;
    }
    let is = file.purpose().map_or("does not say what it is for", Purpose::words);
    Some(format!("for {} is wanted, the file: {is}", wanted.name()))
}

/// Every way to fly a mission with the file, asked as a drop asks it.
fn ways(mission: &Mission, file: &ParameterFile) -> Vec<Way> {
    let way =
        |by: String, asked: anyhow::Result<()>| Way { by, refusal: asked.err().map(|e| format!("{e:#}")) };
    let drop = || has_a_drop(mission).map_err(|failure| anyhow::Error::msg(failure.text()));
    let own = || drop().and_then(|()| Ok(import(file, &mission.parameter_subject()).map(drop_value)?));
    let px4s = |against: Against| {
        drop()?;
        written_for(file, mission.site.environment.gravity_m_s2, mission.px4_purpose())?;
        is_useful(&check_of(file, against))
    };
    let model = |law: &Law| {
        px4s(Against::of_law(law)).and_then(|()| px4_model::suits(mission, law, Some(file)).map(drop_value))
    };
    let real = |version: Number| {
        px4s(Against::flown(version))?;
        let mixes = Mixing::of_version(version) == Mixing::QuadX;
        if mixes {
            is_quad_x(&mission.vehicle)?;
        }
        check_for_px4(mission)?;
        exported(mission, Some(file), mixes).map(drop_value)
    };
    let laws = Law::ALL.iter().map(|law| way(law.since.to_owned(), model(law)));
    let versions = Metadata::versions().map(|version| way(version.to_string(), real(version)));
    let mut all = vec![way("samara's own autopilot".to_owned(), own())];
    all.extend(together("px4-model", laws));
    all.extend(together("PX4", versions));
    all
}

fn drop_value<T>(_: T) {}

/// Ways by consecutive versions with one answer, as one way each.
fn together(name: &str, ways: impl IntoIterator<Item = Way>) -> Vec<Way> {
    let mut groups: Vec<(String, Way)> = Vec::new();
    for way in ways {
        match groups.last_mut() {
            Some((_, last)) if last.refusal == way.refusal => last.by = way.by,
            _ => groups.push((way.by.clone(), way)),
        }
    }
    let label = |(first, way): (String, Way)| {
        let to = if first == way.by { String::new() } else { format!(" to {}", way.by) };
        Way { by: format!("{name} {first}{to}"), refusal: way.refusal }
    };
    groups.into_iter().map(label).collect()
}

fn run_diff(args: &DiffArgs) -> Result<Answer, Failure> {
    let (a, b) = (load_parameters(&args.a).bad_input()?, load_parameters(&args.b).bad_input()?);
    let differences = diff(&a, &b);
    let names = [args.a.display().to_string(), args.b.display().to_string()];
    let names = [names[0].as_str(), names[1].as_str()];
    let words = if args.json { report::diff_json } else { report::diff_text };
    let against = [&a, &b].map(|file| args.px4.map_or_else(|| Against::of(file), Against::asked));
    print(&words(names, [&a, &b], against, &differences))?;
    Ok(Answer::from(differences.iter().all(|d| d.rounding)))
}
