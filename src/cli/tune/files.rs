//! The files of a tuning: gains, parameters, the course of the search, the manifest.

use std::io::Write as _;
use std::path::PathBuf;

use anyhow::Context;

use super::args::{MethodArg, TuneArgs, name_of};
use super::settings::particles;
use crate::cli::outcome::{BadInput, Failure};
use crate::cli::output::OutputFolder;
use samara::config::{Mission, gains_json};
use samara::control::Gains;
use samara::params::{Purpose, export};
use samara::report::params::params_file;
use samara::report::tune::{TuneRun, tables};
use samara::tune::{Longitudinal, Search};

/// `gains.json` and `gains.params`.
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
    let path: PathBuf = folder.write("gains.json", |out| out.write_all(text.as_bytes()))?;
    let mut with_gains = mission.clone();
    with_gains.use_gains(&path.to_string_lossy()).context("the gains that were written")?;
    let parameters = export(&with_gains.parameter_subject(), Purpose::Samara).bad_input()?;
    folder.write("gains.params", |out| out.write_all(params_file(&with_gains, &parameters).as_bytes()))?;
    Ok(())
}

/// The manifest of a tuning, with the options that made it.
pub fn write_tune_manifest(args: &TuneArgs, folder: &OutputFolder, mission: &Mission) -> Result<(), Failure> {
    let options = [
        ("method", name_of(args.method)),
        ("objective", name_of(args.objective)),
        ("model", name_of(args.model)),
        ("robust", args.robust.to_string()),
        ("rms_bound", args.rms_bound.map_or_else(|| "default".to_owned(), |x| x.to_string())),
        ("penalty", args.penalty.to_string()),
        ("swing", format!("{:?}", args.swing)),
        ("start", start_name(args, mission)),
        ("particles", particles(args)),
        ("iterations", args.iterations.to_string()),
        ("stall", args.stall.to_string()),
        ("unseen", args.unseen.to_string()),
    ];
    folder.write_manifest("tune", mission, &options)
}

/// Name of the gains that a search begins at.
pub fn start_name(args: &TuneArgs, mission: &Mission) -> String {
    match (&args.start, args.method) {
        (Some(name), _) => name.clone(),
        (None, MethodArg::CmaEs) => mission.control.gains_name.clone(),
        (None, MethodArg::PsoCma | MethodArg::Pso | MethodArg::NearHover) => "none".to_owned(),
    }
}

/// The course of a search: `convergence.csv` and `.svg`, `front.csv`.
pub fn write_course(
    folder: &OutputFolder,
    mission: &Mission,
    search: &Search,
    run: &TuneRun,
) -> Result<(), Failure> {
    let figure =
        samara::report::convergence_figure(mission, search, run).context("the figure of the search")?;
    let files = [
        ("convergence.csv", tables::convergence_csv(mission, search)),
        ("front.csv", tables::front_csv(mission, search)),
        ("convergence.svg", figure),
    ];
    for (name, text) in files {
        folder.write(name, |out| out.write_all(text.as_bytes()))?;
    }
    Ok(())
}
