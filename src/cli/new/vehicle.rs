//! `samara new vehicle`: a vehicle file from what a data sheet says.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::ask::Questions;
use super::files::{new_file, place, schema};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::{measured, plain_name, positive, positive_in, three};
use crate::cli::results::OutputFolder;
use crate::cli::terminal::print;
use samara::config::draft::{DraftThrust, Frame, VehicleDraft, vehicle_draft_json};
use samara::config::load_vehicle;

/// `samara new vehicle`.
#[derive(Args, Debug)]
pub struct VehicleArgs {
    /// Name of the vehicle: letters, digits, _ and -.
    #[arg(value_parser = plain_name)]
    name: Option<String>,
    /// Mass, all included [kg].
    #[arg(long, value_name = "KG", value_parser = positive_in("kg"))]
    mass: Option<f64>,
    /// Arrangement of the rotors: quad-x, quad-plus, hexa-x, hexa-plus, octo-x, octo-plus, or
    /// with coaxial pairs y6 or x8.
    #[arg(long, value_name = "FRAME", value_parser = frame)]
    frame: Option<Frame>,
    /// Angle by which each rotor is turned about its arm, so that its thrust turns the vehicle the way that
    /// its torque does: 0 to 45; not with coaxial pairs [deg].
    #[arg(long, value_name = "DEG", value_parser = cant, default_value_t = 0.0)]
    cant: f64,
    /// From the centre of mass to a rotor's hub [m].
    #[arg(long, value_name = "M", value_parser = positive_in("m"))]
    arm: Option<f64>,
    /// Diameter of a propeller: in metres, or with its unit, `13in`.
    #[arg(long, value_name = "M", value_parser = diameter)]
    propeller: Option<f64>,
    /// Thrust of a rotor at full throttle [N]; the rotor speed is estimated.
    #[arg(long, value_name = "N", value_parser = positive_in("N"))]
    thrust: Option<f64>,
    /// Instead of --thrust: thrust over the square of the rotor speed [N/(rad/s)^2].
    #[arg(long, value_name = "K", value_parser = positive, conflicts_with = "thrust", requires = "omega_max")]
    thrust_coefficient: Option<f64>,
    /// With --thrust-coefficient: rotor speed at full throttle [rad/s].
    #[arg(long, value_name = "RAD/S", value_parser = positive_in("rad/s"), requires = "thrust_coefficient")]
    omega_max: Option<f64>,
    /// Density of the air that the thrust holds for [kg/m^3].
    #[arg(long, value_name = "KG/M3", value_parser = positive_in("kg/m3"), default_value_t = 1.225)]
    density: f64,
    /// Moments of inertia about x, y and z [kg m^2]; estimated when left out.
    #[arg(long, value_name = "XX,YY,ZZ", value_parser = inertia)]
    inertia: Option<[f64; 3]>,
    /// Time constant of a motor speeding up [s]; estimated when left out.
    #[arg(long, value_name = "S", value_parser = positive_in("s"))]
    motor_tau: Option<f64>,
    /// File to write [default: params/vehicles/NAME.json where there is that folder, else NAME.json].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print one JSON object on stdout instead of text.
    #[arg(long)]
    json: bool,
}

/// The value of `--frame`.
fn frame(text: &str) -> Result<Frame, String> {
    let known = Frame::ALL.map(Frame::name).join(", ");
    Frame::ALL.into_iter().find(|f| f.name() == text).ok_or_else(|| format!("one of {known} is expected"))
}

/// The value of `--cant`.
fn cant(text: &str) -> Result<f64, String> {
    measured(text, "deg", |x| (0.0..=45.0).contains(&x), "an angle from 0 to 45 degrees is expected")
}

/// The value of `--inertia`.
fn inertia(text: &str) -> Result<[f64; 3], String> {
    three(text, "kgm2", |x| x > 0.0, "three positive numbers, XX,YY,ZZ, are expected")
}

/// A greater number alone is taken for inches that were meant [m].
const BARE_DIAMETER_MOST_M: f64 = 2.0;

/// The value of `--propeller`.
fn diameter(text: &str) -> Result<f64, String> {
    let expected = "a diameter in metres (0.33) or inches (13in) is expected";
    let diameter_m = measured(text, "m", |x| x > 0.0, expected)?;
    let bare = text.trim().parse::<f64>().is_ok();
    if bare && diameter_m > BARE_DIAMETER_MOST_M {
        return Err(format!(
            "{diameter_m} alone is {diameter_m} m; its unit is expected: {diameter_m}in or {diameter_m}m"
        ));
    }
    Ok(diameter_m)
}

/// Writes the file, and reads it back as any other.
pub fn run(args: &VehicleArgs) -> Result<Answer, Failure> {
    let mut ask = Questions::new();
    let name = ask.ask(args.name.as_ref(), "NAME", "name of the vehicle", plain_name)?;
    let mass = ask.ask(args.mass.as_ref(), "--mass", "mass [kg]", positive_in("kg"))?;
    let names = Frame::ALL.map(Frame::name).join(", ");
    let frame = ask.ask(args.frame.as_ref(), "--frame", &format!("frame ({names})"), frame)?;
    let arm =
        ask.ask(args.arm.as_ref(), "--arm", "from the centre to a rotor's hub [m]", positive_in("m"))?;
    let propeller = ask.ask(args.propeller.as_ref(), "--propeller", "propeller (0.33 or 13in)", diameter)?;
    let thrust = match (args.thrust_coefficient, args.omega_max) {
        (Some(thrust_n_per_rad2_s2), Some(omega_max_rad_s)) => {
            Some(DraftThrust::Coefficient { thrust_n_per_rad2_s2, omega_max_rad_s })
        }
        _ => ask
            .ask(
                args.thrust.as_ref(),
                "--thrust",
                "thrust of a rotor at full throttle [N]",
                positive_in("N"),
            )?
            .map(|thrust_n| DraftThrust::AtFullThrottle { thrust_n }),
    };
    ask.finish()?;
    let (Some(name), Some(mass_kg), Some(frame), Some(arm_m), Some(propeller_m), Some(thrust)) =
        (name, mass, frame, arm, propeller, thrust)
    else {
        return Err(Failure::input("a name and the options without a default are expected".to_owned()));
    };
    let file = new_file(args.out.as_deref(), "params/vehicles", &name)?;
    let (folder, file_name) = place(&file)?;
    let output = OutputFolder::plain(&folder)?;
    let draft = VehicleDraft {
        name,
        mass_kg,
        frame,
        cant_deg: args.cant,
        arm_m,
        propeller_m,
        thrust,
        density_kg_m3: args.density,
        inertia_kg_m2: args.inertia,
        motor_tau_s: args.motor_tau,
        schema: schema(&folder, "vehicle.schema.json"),
    };
    output.write_text(&file_name, &vehicle_draft_json(&draft).bad_input()?)?;
    // What was typed may still contradict itself (an inertia that no body has).
    if let Err(e) = load_vehicle(&file) {
        let _ = std::fs::remove_file(&file);
        return Err(e).bad_input();
    }
    let shown = file.display().to_string();
    print(&if args.json {
        format!("{:#}\n", json!({ "vehicle": draft.name, "file": shown }))
    } else {
        let path = if shown.contains('/') { shown.clone() } else { format!("./{shown}") };
        format!(
            "{shown}: its `origins` say what is estimated, and how\nnext:\n  samara new mission {}_drop --vehicle {path} --planet earth --altitude 500 \
             --from parachute\n",
            draft.name
        )
    })?;
    Ok(Answer::Yes)
}
