//! The results of a tuning: gains, parameters, the search step by step, the manifest; or why there are no
//! gains.

use anyhow::Context as _;

use super::args::{TuneArgs, name_of};
use super::settings::{particles, tuning};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::results::OutputFolder;
use crate::cli::terminal::{print, print_err};
use samara::config::{Mission, gains_json};
use samara::control::Gains;
use samara::params::{Purpose, export};
use samara::report::params::params_file;
use samara::study::range_ends::range_ends_words;
use samara::study::tuning::convergence_figure;
use samara::study::tuning::report::{TuneRun, records};
use samara::tune::{Longitudinal, RangeEnds, Search};

/// Name of a search's checkpoint.
pub const CHECKPOINT: &str = "checkpoint.json";

/// Writes `gains.json` and `gains.params`.
pub fn write_gains(
    args: &TuneArgs,
    folder: &OutputFolder,
    mission: &Mission,
    k: &Longitudinal,
    about: &str,
) -> Result<(), Failure> {
    let yaw = &mission.control.gains;
    let gains = Gains { k_ppsi: yaw.k_ppsi, k_pr: yaw.k_pr, ..Gains::longitudinal(*k) };
    let text = gains_json(&args.name, about, &gains);
    let path = folder.write_text("gains.json", &text)?;
    let mut with_gains = mission.clone();
    with_gains.use_gains(&path.to_string_lossy()).context("the gains that were written")?;
    let parameters = export(&with_gains.parameter_subject(), Purpose::Samara).bad_input()?;
    folder.write_text("gains.params", &params_file(&with_gains, &parameters)).map(|_| ())
}

/// Writes the manifest of a tuning, with the options that made it and, of a search, the numbers that stand at
/// an end of their range.
pub fn write_tune_manifest(
    args: &TuneArgs,
    folder: &OutputFolder,
    mission: &Mission,
    ends: &RangeEnds,
) -> Result<(), Failure> {
    let mut options = vec![
        ("method", name_of(args.method)),
        ("objective", name_of(args.objective)),
        ("model", name_of(args.model)),
        ("robust", args.robust.to_string()),
        ("draws", tuning(args).robust.unwrap_or(0).to_string()),
        ("rms_bound", args.rms_bound.map_or_else(|| "default".to_owned(), |x| x.to_string())),
        ("penalty", args.penalty.to_string()),
        ("swing", format!("{:?}", args.swing)),
        ("start", tuning(args).start_name(mission)),
        ("particles", particles(args)),
        ("iterations", args.iterations.to_string()),
        ("stall", args.stall.to_string()),
        ("unseen", args.unseen.to_string()),
    ];
    options.extend(range_ends_words(ends).map(|words| ("at_range_ends", words)));
    folder.write_manifest("tune", mission, &options)
}

/// Writes the search step by step: `convergence.csv` and `.svg`, `front.csv`.
pub fn write_search(
    folder: &OutputFolder,
    mission: &Mission,
    search: &Search,
    run: &TuneRun,
) -> Result<(), Failure> {
    let figure = convergence_figure(mission, search, run).context("the figure of the search")?;
    let files = [
        ("convergence.csv", records::convergence_csv(mission, search)),
        ("front.csv", records::front_csv(mission, search)),
        ("convergence.svg", figure),
    ];
    for (name, text) in files {
        folder.write_text(name, &text)?;
    }
    Ok(())
}

/// Why a search has no gains.
pub fn no_gains(stopped: bool) -> &'static str {
    if stopped {
        "stopped before any gains were judged"
    } else {
        "no gains were found that fly every release"
    }
}

/// Reports why there are no gains.
pub fn report_nothing(args: &TuneArgs, mission: &str, reason: &str) -> Result<Answer, Failure> {
    print_err(&format!("samara: {reason}\n"));
    if args.mission.json {
        let object = serde_json::json!({ "mission": mission, "gains": null, "reason": reason });
        print(&format!("{object:#}\n"))?;
    }
    Ok(Answer::No)
}
