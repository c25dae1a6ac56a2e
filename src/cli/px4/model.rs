//! `samara drop --autopilot px4-model`: the drop that PX4 is expected to fly, by the model of its control law, without a wire.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use crate::cli::clock::Stopwatch;
use crate::cli::drop::Flown;
use crate::cli::outcome::{BadInput, Failure};
use crate::config::Mission;
use crate::control::px4::facts::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use crate::control::px4::{Law, Parameters, is_quad_x};
use crate::link::FlightRecord;
use crate::model::environment::same_gravity;
use crate::params::{ParameterFile, Purpose, law_parameters};
use crate::sim::px4_flight::fly_px4;
use crate::sim::{FlightPlan, Reference};
use crate::trajectory::Trajectory;
use crate::units::STANDARD_GRAVITY_M_S2;

/// How PX4 flies at the mission's site: as it is, or by Froude scaling; and Froude's k.
pub fn purpose_at(mission: &Mission) -> (Purpose, f64) {
    let g = mission.environment.gravity_m_s2;
    if same_gravity(STANDARD_GRAVITY_M_S2, g) {
        (Purpose::Px4, 1.0)
    } else {
        (Purpose::Px4Froude, (STANDARD_GRAVITY_M_S2 / g).sqrt())
    }
}

/// What PX4 is set to for the mission: by a file that is for it, or by the mission's gains in its terms.
///
/// # Errors
/// [`Failure::BadInput`] when the vehicle is no quadrotor in X, the file is for something else or the gains have no place in PX4.
pub fn parameters_for(mission: &Mission, given: Option<&ParameterFile>) -> Result<Parameters, Failure> {
    is_quad_x(&mission.vehicle).bad_input()?;
    let (purpose, _) = purpose_at(mission);
    if let Some(other) = given.and_then(ParameterFile::purpose).filter(|p| *p != purpose)
        && purpose == Purpose::Px4Froude
    {
        let g = mission.environment.gravity_m_s2;
        return Err(anyhow::anyhow!(
            "--params: the file is for {}; under {g} m/s^2 one for {} is expected",
            other.name(),
            purpose.name()
        ))
        .bad_input();
    }
    law_parameters(&mission.parameter_subject(), purpose, given).bad_input()
}

/// Flies the mission by the model, the release at the end of the hang.
///
/// # Errors
/// As [`parameters_for`].
pub fn fly(
    mission: &Mission,
    trajectory: &Trajectory,
    given: Option<&ParameterFile>,
    feed_forward: bool,
) -> Result<Flown, Failure> {
    let parameters = parameters_for(mission, given)?;
    let (_, similarity) = purpose_at(mission);
    let mut sim = mission.simulation();
    sim.schedule_release(mission.hang_s);
    let then_v_ned = Some(mission.target_v_ned);
    let plan = FlightPlan {
        reference: Reference::Plan { trajectory, then_v_ned, feed_forward },
        yaw_sp_rad: 0.0,
        control_period_s: IMU_PERIOD_S * similarity,
        setpoint_period_s: Some(SETPOINT_PERIOD_S * similarity),
        duration_s: mission.duration_s,
    };
    let watch = Stopwatch::start();
    let mut law = Law::new(parameters, similarity);
    let mut log = Vec::new();
    let _ = fly_px4(&mut sim, &mut law, &plan, Vector3::zeros(), &mut |sample| {
        log.push(*sample);
        ControlFlow::Continue(())
    });
    let real_time_factor = 1e3 * mission.duration_s / watch.ms();
    Ok(Flown { log, record: FlightRecord::default(), real_time_factor, trouble: None })
}
