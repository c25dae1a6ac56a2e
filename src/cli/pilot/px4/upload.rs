//! Whether PX4 can fly a mission, and the parameters that it is given before a drop: what the drop needs, the
//! vehicle's own (hover thrust, thrust curve) and the gains, the mission's in PX4's terms or those of a file.

use crate::cli::answer::{BadInput as _, Failure};
use samara::config::{Mission, check_for_px4};
use samara::control::px4::is_quad_x;
use samara::link::parties;
use samara::link::streamer::{Procedure, Uploads};
use samara::params::px4_required::DropEnvelope;
use samara::params::{Export, Mixing, ParameterFile, Upload, export_for_mixing};
use samara::time::seconds;
use samara::trajectory::Trajectory;

/// The vehicle's own parameters; the rest of an export are gains, limits, and the rotors for a PX4 that
/// allocates by them.
const OF_THE_VEHICLE: [&str; 2] = ["MPC_THR_HOVER", "THR_MDL_FAC"];
/// The beginning of the names of the rotors' parameters.
const OF_THE_ROTORS: &str = "CA_";

/// What PX4 is given and judged by, and the mission's export that it was made of.
#[derive(Clone, Debug)]
pub struct Preparation {
    /// What the parameters depend on.
    pub envelope: DropEnvelope,
    /// What PX4 is given.
    pub upload: Upload,
    /// Gains, limits and vehicle of the mission.
    pub export: Export,
}

/// The mission's gains, limits and vehicle in the terms of a PX4; `mixer`: whether it mixes by a file, and
/// not by CA_*. Refuses gains that cannot be put in PX4's terms.
pub fn exported(mission: &Mission, given: Option<&ParameterFile>, mixer: bool) -> anyhow::Result<Export> {
    let mixing = if mixer { Mixing::QuadX } else { Mixing::Allocated };
    let mut subject = mission.parameter_subject();
    if given.is_some() {
        // The file says what the tilt comes from.
        subject.tilt_from = None;
    }
    Ok(export_for_mixing(&subject, mission.px4_purpose(), mixing)?)
}

/// Prepares a PX4 for the flight, as [`exported`] has it.
pub fn preparation(
    mission: &Mission,
    trajectory: &Trajectory,
    given: Option<&ParameterFile>,
    mixer: bool,
) -> Result<Preparation, Failure> {
    let export = exported(mission, given, mixer).bad_input()?;
    let envelope = DropEnvelope {
        hover_thrust: export.parameters.get("MPC_THR_HOVER").map(|v| v.as_f64()),
        ..envelope(mission, trajectory)
    };
    let is_rotors = |name: &str| name.starts_with(OF_THE_ROTORS);
    let counts = |name: &str| given.is_none() || OF_THE_VEHICLE.contains(&name) || is_rotors(name);
    let of_the_mission = export.parameters.iter().filter(|(name, _)| counts(name));
    let of_the_mission = of_the_mission.map(|(name, value)| (name.clone(), *value));
    let mut upload = Upload::new(&envelope, of_the_mission, given);
    if mixer {
        upload.parameters.retain(|name, _| !is_rotors(name));
    }
    Ok(Preparation { envelope, upload, export })
}

impl Preparation {
    /// All that PX4 is given, as a file's content; `by_a_file`: whether a file stands in the gains' place.
    pub fn into_export(self, by_a_file: bool) -> Export {
        let Self { upload, mut export, .. } = self;
        if by_a_file {
            // Those are remarks on the mission's gains.
            export.remarks.clear();
        }
        export.remarks.extend(upload.remarks);
        export.with(upload.parameters)
    }
}

/// All that PX4 is given, as a file's content.
pub fn whole(
    mission: &Mission,
    trajectory: &Trajectory,
    given: Option<&ParameterFile>,
    mixer: bool,
) -> Result<Export, Failure> {
    Ok(preparation(mission, trajectory, given, mixer)?.into_export(given.is_some()))
}

/// What a PX4 is given and judged by, whichever it is: that comes out on the wire; and what there is to
/// remark on it.
pub fn of_any(
    mission: &Mission,
    trajectory: &Trajectory,
    given: Option<&ParameterFile>,
) -> Result<(Procedure, Vec<String>), Failure> {
    check_for_px4(mission).bad_input()?;
    let Preparation { envelope, upload, .. } = preparation(mission, trajectory, given, false)?;
    let by_mixer = match is_quad_x(&mission.vehicle) {
        Ok(()) => Some(preparation(mission, trajectory, given, true)?.upload.parameters),
        Err(_) => None,
    };
    let uploads = Uploads { by_mixer, allocated: upload.parameters };
    let canopy_moves = mission.release.parachute.suspension.is_some();
    Ok((Procedure { envelope, canopy_moves, uploads, event_texts: None }, upload.remarks))
}

/// What the setpoints will demand, in PX4's units.
pub fn envelope(mission: &Mission, trajectory: &Trajectory) -> DropEnvelope {
    let setpoints = || trajectory.nodes().iter().map(|n| n.v_ned).chain([mission.target_v_ned]);
    let on_px4s_clock = |site_us| parties::froude(mission).map_or(site_us, |froude| froude.wire_us(site_us));
    let scale = mission.px4_purpose().factors(mission.site.environment.gravity_m_s2).k;
    DropEnvelope {
        fastest_descent_m_s: scale * setpoints().map(|v| v.z).fold(0.0, f64::max),
        fastest_horizontal_m_s: scale * setpoints().map(|v| v.xy().norm()).fold(0.0, f64::max),
        hover_thrust: None,
        satellite_delay_s: Some(seconds(on_px4s_clock(mission.sensors.satellite.delay_us))),
    }
}
