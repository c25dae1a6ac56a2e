//! `samara rotor`: a vehicle's blades, and the table of their coefficients.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::results::OutputFolder;
use super::terminal::print;
use samara::config::shipped::is_built_in;
use samara::config::{blade_file, vehicle_path};

/// `samara rotor`.
#[derive(Args, Debug)]
pub struct RotorArgs {
    /// The vehicle, whose rotor is a `blade_element`: a file, or a name - of a file in ./params/vehicles, or
    /// of a vehicle that samara brings along.
    #[arg(value_name = "NAME|FILE")]
    pub vehicle: PathBuf,
    /// File to write the table to [default: the one that the vehicle names].
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}

/// Vertical descent, in units of the induced velocity of hover.
const DESCENTS: [f64; 4] = [0.5, 1.0, 1.5, 2.0];

/// Solves the blades and writes the table.
pub fn run(args: &RotorArgs) -> Result<Answer, Failure> {
    let file = blade_file(&vehicle_path(&args.vehicle).bad_input()?).bad_input()?;
    let out: &Path = match &args.out {
        Some(out) => out,
        None if is_built_in(&file.path) => {
            let built_in = "the vehicle comes with samara; --out FILE is expected";
            return Err(Failure::input(built_in.to_owned()));
        }
        None => &file.path,
    };
    let hover = file.blades.hover();
    let mut text = format!(
        "solidity                    {:.4}\n\
         hover: C_T                  {:.5}\n\
         hover: C_Q                  {:.6}\n\
         hover: induced/tip speed    {:.4}\n\
         hover: figure of merit      {:.3}\n",
        file.blades.solidity(),
        hover.thrust,
        hover.torque,
        hover.induced,
        hover.merit,
    );
    for descent in DESCENTS {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "descent at {descent:.1} v_h: T/T_h   {:.3}",
            file.blades.thrust_in_descent(descent)
        );
    }
    let Some(name) = out.file_name().and_then(|name| name.to_str()) else {
        return Err(Failure::input(format!("expected a file to write to, found {}", out.display())));
    };
    let beside = out.parent().unwrap_or(Path::new(""));
    let folder = OutputFolder::plain(beside)?;
    let path = folder.write_text(name, &file.table_text())?;
    print(&format!("{text}{}\n", path.display()))?;
    Ok(Answer::Yes)
}
