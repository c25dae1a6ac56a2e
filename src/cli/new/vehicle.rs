//! `samara new vehicle`: a vehicle file from what a data sheet or files of other programs say.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::ask::Questions;
use super::files::{new_file, place, schema};
use crate::cli::answer::{Answer, BadInput as _, Failure};
use crate::cli::args::{measured, plain_name, positive, positive_in, three};
use crate::cli::results::OutputFolder;
use crate::cli::terminal::{print, print_err};
use samara::config::draft::{
    DraftRotors, DraftThrust, Frame, VehicleDraft, mass_by_hover, needs_propeller, vehicle_draft_json,
};
use samara::config::foreign::{Key, Known, KnownVehicle, known_vehicle};
use samara::config::{Origin, load_vehicle};

/// `samara new vehicle`.
#[derive(Args, Debug)]
pub struct VehicleArgs {
    /// Name of the vehicle: letters, digits, _ and -.
    #[arg(value_parser = plain_name)]
    name: Option<String>,
    /// Files that say something of it: PX4's airframes, parameter files and logs, Gazebo's .sdf; the later
    /// one stands before the earlier, options before all.
    #[arg(long, value_name = "FILE", num_args = 1..)]
    from: Vec<PathBuf>,
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
    #[arg(long, value_name = "K", value_parser = positive, conflicts_with = "thrust")]
    thrust_coefficient: Option<f64>,
    /// With a thrust coefficient: rotor speed at full throttle [rad/s].
    #[arg(long, value_name = "RAD/S", value_parser = positive_in("rad/s"), conflicts_with = "thrust")]
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

/// What files say of the vehicle, but for what options say instead, and what is to be told of them.
fn known_of(args: &VehicleArgs) -> Result<KnownVehicle, Failure> {
    let mut known = known_vehicle(&args.from).bad_input()?;
    // A hover tells the mass of a thrust, or the thrust of a mass.
    let weighed = args.mass.is_some() || known.numbers.contains_key(&Key::Mass);
    let thrust_keys = if weighed { &[Key::Thrust, Key::Hover][..] } else { &[Key::Thrust] };
    for (option, told, keys) in [
        ("--mass", args.mass, &[Key::Mass][..]),
        ("--thrust", args.thrust, thrust_keys),
        ("--thrust-coefficient", args.thrust_coefficient, &[Key::Thrust]),
        ("--omega-max", args.omega_max, &[Key::OmegaMax]),
        ("--motor-tau", args.motor_tau, &[Key::TauUp]),
        ("--propeller", args.propeller, &[Key::Radius]),
    ] {
        for number in keys.iter().filter(|_| told.is_some()).filter_map(|key| known.numbers.remove(key)) {
            known.remarks.push(format!("{option} stands, not {} of {}", number.value, number.file));
        }
    }
    let inertia = known.inertia_kg_m2.take_if(|_| args.inertia.is_some());
    let rotors = known.rotors.take_if(|_| args.frame.is_some());
    let instead =
        [("--inertia", inertia.map(|known| known.file)), ("--frame", rotors.map(|known| known.file))];
    for (option, file) in instead.into_iter().filter_map(|(option, file)| Some((option, file?))) {
        known.remarks.push(format!("{option} stands, not what {file} says"));
    }
    if let Some(Known { value, file, words, .. }) = &mut known.rotors {
        let remark = match (value.in_metres, args.arm) {
            (true, Some(_)) => {
                words.push_str(", in proportion to the arm that was told");
                format!("--arm stands, not {:.4} m of {file}: all hubs in proportion", value.arm())
            }
            (false, None) => format!("the rotors of {file} are directions: their length is the arm's"),
            _ => return Ok(known),
        };
        known.remarks.push(remark);
    }
    Ok(known)
}

/// What the rotors are: where files have them, or a frame.
fn rotors_of(
    args: &VehicleArgs,
    known: &KnownVehicle,
    ask: &mut Questions,
) -> Result<Option<DraftRotors>, Failure> {
    let question = "from the centre to a rotor's hub [m]";
    if let Some(rotors) = &known.rotors {
        if args.cant != 0.0 {
            return Err(Failure::input(format!(
                "--cant: expected with --frame; {} has the rotors",
                rotors.file
            )));
        }
        let rotors = rotors.value.clone();
        if rotors.in_metres && args.arm.is_none() {
            return Ok(Some(DraftRotors::Known(rotors)));
        }
        let arm = ask.ask(args.arm.as_ref(), "--arm", question, positive_in("m"))?;
        return Ok(arm.map(|arm_m| DraftRotors::Known(rotors.with_arm(arm_m))));
    }
    let names = Frame::ALL.map(Frame::name).join(", ");
    let frame = ask.ask(args.frame.as_ref(), "--frame", &format!("frame ({names})"), frame)?;
    let arm = ask.ask(args.arm.as_ref(), "--arm", question, positive_in("m"))?;
    let cant_deg = args.cant;
    Ok(frame.zip(arm).map(|(frame, arm_m)| DraftRotors::Frame { frame, cant_deg, arm_m }))
}

/// Writes the file, and reads it back as any other.
pub fn run(args: &VehicleArgs) -> Result<Answer, Failure> {
    let mut known = known_of(args)?;
    let mut remarks = std::mem::take(&mut known.remarks);
    let tell = |remark: &String| print_err(&format!("samara: {remark}\n"));
    remarks.iter().for_each(tell);
    let mut ask = Questions::new();
    let name = ask.ask(args.name.as_ref(), "NAME", "name of the vehicle", plain_name)?;
    let coefficient = args.thrust_coefficient.or(known.number(Key::Thrust));
    let omega_max = args.omega_max.or(known.number(Key::OmegaMax));
    let mass = args.mass.or(known.number(Key::Mass));
    let full_n =
        args.thrust.or(coefficient.zip(omega_max).map(|(coefficient, omega)| coefficient * omega * omega));
    let by_hover = full_n.filter(|_| mass.is_none()).and_then(|full_n| mass_by_hover(&known, full_n));
    let mass = mass.or(by_hover.as_ref().map(|(mass_kg, _)| *mass_kg));
    let mass = ask.ask(mass.as_ref(), "--mass", "mass [kg]", positive_in("kg"))?;
    let rotors = rotors_of(args, &known, &mut ask)?;
    if coefficient.is_none() && args.omega_max.is_some() {
        return Err(Failure::input("--omega-max: a --thrust-coefficient is expected with it".to_owned()));
    }
    let omega_max = match coefficient {
        Some(_) => {
            let question = "rotor speed at full throttle [rad/s]";
            ask.ask(omega_max.as_ref(), "--omega-max", question, positive_in("rad/s"))?
        }
        None => omega_max,
    };
    let pairs = args.frame.is_some_and(Frame::is_coaxial);
    let propeller = if needs_propeller(&known, coefficient.is_some(), pairs, args.motor_tau.is_some()) {
        ask.ask(args.propeller.as_ref(), "--propeller", "propeller (0.33 or 13in)", diameter)?
    } else {
        args.propeller
    };
    let thrust = match (coefficient, known.number(Key::Hover).filter(|_| args.thrust.is_none())) {
        (Some(thrust_n_per_rad2_s2), _) => omega_max
            .map(|omega_max_rad_s| DraftThrust::Coefficient { thrust_n_per_rad2_s2, omega_max_rad_s }),
        (None, Some(share)) => Some(DraftThrust::Hover { share }),
        (None, None) => ask
            .ask(
                args.thrust.as_ref(),
                "--thrust",
                "thrust of a rotor at full throttle [N]",
                positive_in("N"),
            )?
            .map(|thrust_n| DraftThrust::AtFullThrottle { thrust_n }),
    };
    ask.finish()?;
    let (Some(name), Some(mass_kg), Some(rotors), Some(thrust)) = (name, mass, rotors, thrust) else {
        return Err(Failure::input("a name and the options without a default are expected".to_owned()));
    };
    let file = new_file(args.out.as_deref(), "params/vehicles", &name)?;
    let (folder, file_name) = place(&file)?;
    let output = OutputFolder::plain(&folder)?;
    let draft = VehicleDraft {
        name,
        mass_kg,
        mass_by: by_hover.map(|(_, formula)| formula),
        rotors,
        propeller_m: propeller,
        thrust,
        density_kg_m3: args.density,
        inertia_kg_m2: args.inertia,
        motor_tau_s: args.motor_tau,
        known,
        schema: schema(&folder, "vehicle.schema.json"),
    };
    if let (Err(e), Some(of_file)) = (draft.check_mass(), draft.known.numbers.get(&Key::Mass)) {
        return Err(of_file.refuse(e.to_string())).bad_input();
    }
    output.write_text(&file_name, &vehicle_draft_json(&draft).bad_input()?)?;
    // What was typed may still contradict itself (an inertia that no body has).
    let written = match load_vehicle(&file) {
        Ok(written) => written,
        Err(e) => {
            let _ = std::fs::remove_file(&file);
            return Err(e).bad_input();
        }
    };
    for remark in draft.hovers_otherwise().into_iter().chain(draft.drags_oddly()) {
        tell(&remark);
        remarks.push(remark);
    }
    let shown = file.display().to_string();
    print(&if args.json {
        format!("{:#}\n", json!({ "vehicle": draft.name, "file": shown, "remarks": remarks }))
    } else {
        let path = if shown.contains('/') { shown.clone() } else { format!("./{shown}") };
        let origins = if args.from.is_empty() { String::new() } else { by_file(&written.origins) };
        format!(
            "{shown}: its `origins` say what is estimated, and how\n{origins}next:\n  samara new mission {}_drop --vehicle {path} --planet earth --altitude 500 \
             --from parachute\n",
            draft.name
        )
    })?;
    Ok(Answer::Yes)
}

/// The keys of a file by what they are from, a line for each.
fn by_file(origins: &[Origin]) -> String {
    let mut lines: Vec<(String, Vec<&str>)> = Vec::new();
    for origin in origins {
        let from = match &origin.file {
            Some(file) => file.clone(),
            None if origin.kind.is_estimate() => "estimated".to_owned(),
            None => "told".to_owned(),
        };
        let keys = origin.keys.iter().map(|key| key.rsplit('.').next().unwrap_or(key));
        match lines.iter_mut().find(|(before, _)| *before == from) {
            Some((_, all)) => all.extend(keys),
            None => lines.push((from, keys.collect())),
        }
    }
    lines.iter().map(|(from, keys)| format!("  {from}: {}\n", keys.join(", "))).collect()
}
