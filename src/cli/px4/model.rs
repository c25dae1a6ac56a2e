//! `samara drop --autopilot px4-model`: the drop that PX4 is expected to fly, by the model of its control law, without a wire.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::flight::suits;
use super::upload::preparation;
use crate::cli::clock::Stopwatch;
use crate::cli::drop::Flown;
use crate::cli::outcome::{BadInput, Failure};
use samara::config::Mission;
use samara::control::px4::timing::{IMU_PERIOD_S, SETPOINT_PERIOD_S};
use samara::control::px4::{Law, Parameters, is_quad_x};
use samara::link::FlightRecord;
use samara::params::{ParameterFile, px4_model_parameters};
use samara::report::FlownBy;
use samara::sim::px4_flight::fly_px4;
use samara::sim::{FlightPlan, Reference};
use samara::trajectory::Trajectory;

/// What PX4 is set to for the mission, by a file or by the mission's gains in its terms, and what is to say of that.
///
/// # Errors
/// [`Failure::BadInput`] when PX4 cannot fly the mission, its vehicle is no quadrotor in X, or the gains have no place in PX4.
pub fn parameters_for(
    mission: &Mission,
    trajectory: &Trajectory,
    given: Option<&ParameterFile>,
) -> Result<(Parameters, Vec<String>), Failure> {
    suits(mission).bad_input()?;
    is_quad_x(&mission.vehicle).bad_input()?;
    let mut law =
        px4_model_parameters(&mission.parameter_subject(), mission.px4_purpose(), given).bad_input()?;
    let upload = preparation(mission, trajectory, given, true)?.upload;
    // Where PX4 would not get the file's value the model has not got it either.
    let own = given.into_iter().flat_map(ParameterFile::entries);
    for (name, value) in own.filter_map(|(_, name, _)| Some((name, upload.parameters.get(name)?))) {
        // What the law does not read it is not told.
        let _ = law.set(name, value.as_f64());
    }
    Ok((law, upload.remarks))
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
    let (parameters, _) = parameters_for(mission, trajectory, given)?;
    // k of Froude's scaling: PX4's clock is slower than the site's by it.
    let similarity = mission.px4_purpose().factors(mission.site.environment.gravity_m_s2).velocity;
    let mut sim = mission.simulation();
    sim.schedule_release(mission.release.hang_s);
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
    let by = FlownBy { name: "px4-model", version: None };
    Ok(Flown { log, record: FlightRecord::default(), real_time_factor, by, trouble: None })
}
