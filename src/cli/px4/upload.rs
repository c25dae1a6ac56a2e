//! The parameters that PX4 is given before a drop.
//!
//! What the drop needs ([`crate::params::procedure`]), the vehicle's own (hover thrust, thrust curve) and the gains: the mission's in
//! PX4's terms, or those of a file, whose word counts where both have one.

use std::collections::BTreeMap;

use crate::cli::outcome::{BadInput, Failure};
use crate::config::Mission;
use crate::link::streamer::Procedure;
use crate::params::procedure::{Circumstances, wanted};
use crate::params::{Mixing, ParameterFile, Value, export_for_mixing, file::AUTOPILOT_COMPONENT};
use crate::trajectory::Trajectory;

/// The vehicle's own; the rest of an export are gains, limits, and the rotors for a PX4 that allocates by them.
const OF_THE_VEHICLE: [&str; 2] = ["MPC_THR_HOVER", "THR_MDL_FAC"];
/// Parameters of the rotors.
const OF_THE_ROTORS: &str = "CA_";

/// What PX4 is given and judged by. `mixer`: whether it mixes by a file, and not by CA_*.
///
/// # Errors
/// [`Failure::BadInput`] when the gains cannot be put in PX4's terms.
pub fn procedure(
    mission: &Mission,
    trajectory: &Trajectory,
    given: Option<&ParameterFile>,
    mixer: bool,
) -> Result<Procedure, Failure> {
    let mixing = if mixer { Mixing::QuadX } else { Mixing::Allocated };
    let subject = mission.parameter_subject();
    let exported = export_for_mixing(&subject, mission.px4_purpose(), mixing).bad_input()?.parameters;
    let circumstances = Circumstances {
        hover_thrust: exported.get("MPC_THR_HOVER").map(|v| v.as_f64()),
        ..circumstances(mission, trajectory)
    };
    let of_the_drop = wanted(&circumstances).map(|(name, value)| (name.to_owned(), value));
    let mut upload: BTreeMap<String, Value> = of_the_drop.collect();
    let counts =
        |name: &str| given.is_none() || OF_THE_VEHICLE.contains(&name) || name.starts_with(OF_THE_ROTORS);
    upload.extend(exported.into_iter().filter(|(name, _)| counts(name)));
    if let Some(given) = given {
        let own = given.entries().filter(|(component, ..)| *component == AUTOPILOT_COMPONENT);
        upload.extend(own.map(|(_, name, entry)| (name.to_owned(), entry.value)));
    }
    if mixer {
        upload.retain(|name, _| !name.starts_with(OF_THE_ROTORS));
    }
    Ok(Procedure { circumstances, upload })
}

/// What the setpoints will demand, in PX4's units.
pub fn circumstances(mission: &Mission, trajectory: &Trajectory) -> Circumstances {
    let setpoints = || trajectory.nodes().iter().map(|n| n.v_ned).chain([mission.target_v_ned]);
    let scale = mission.px4_purpose().factors(mission.environment.gravity_m_s2).velocity;
    Circumstances {
        fastest_descent_m_s: scale * setpoints().map(|v| v.z).fold(0.0, f64::max),
        fastest_horizontal_m_s: scale * setpoints().map(|v| v.xy().norm()).fold(0.0, f64::max),
        hover_thrust: None,
    }
}
