//! The parties of a drop, built from a mission.

use std::path::{Path, PathBuf};
use std::time::Duration;

use super::hil::Stamps;
use super::streamer::{Clock, Procedure, SolvedBy};
use super::{
    AutopilotSession, AutopilotSetup, Froude, HilConfig, HilSession, StreamerConfig, StreamerSession, TimeUs,
    microseconds,
};
use crate::autopilot::estimator::EstimatorSettings;
use crate::autopilot::parameters::Parameters;
use crate::config::{ConfigError, Mission, Px4Clock, load_parameters};
use crate::control::{Airframe, ControlError, ControlSettings, Controller};
use crate::params::ParamsError;
use crate::replan::ReplanSetup;
use crate::sim::{DropRunConfig, ReleaseTrigger};
use crate::trajectory::Trajectory;

/// A mission that the reference autopilot cannot fly.
#[derive(Debug, thiserror::Error)]
pub enum PartyError {
    /// The vehicle cannot be controlled.
    #[error("{}", vehicle_file.display())]
    Airframe {
        /// File of the vehicle.
        vehicle_file: PathBuf,
        /// Reason.
        source: ControlError,
    },
    /// The gains or limits have no place among the parameters.
    #[error(transparent)]
    Parameters(#[from] ParamsError),
    /// The parameter file cannot be used.
    #[error(transparent)]
    File(#[from] ConfigError),
}

/// The scale of the wire to PX4, where the mission has one.
pub fn froude(mission: &Mission) -> Option<Froude> {
    match mission.px4.clock {
        Px4Clock::Real => None,
        Px4Clock::Froude => Some(Froude::under(mission.site.environment.gravity_m_s2)),
    }
}

/// The simulator with its parachute, which waits for a companion if `companion` says how long.
pub fn simulator(
    mission: &Mission,
    system_id: u8,
    froude: Option<Froude>,
    companion: Option<Duration>,
) -> HilSession {
    HilSession::new(mission.simulation(), hil_config(mission, system_id, froude, companion))
}

/// The simulator with its parachute for an autopilot with a clock of its own, on which a HIL_SENSOR comes
/// every `period_us`; the parachute stamps by `stamps`.
pub fn simulator_in_real_time(
    mission: &Mission,
    system_id: u8,
    period_us: TimeUs,
    stamps: Stamps,
) -> HilSession {
    let froude = froude(mission);
    let mut config = hil_config(mission, system_id, froude, None);
    config.real_time = Some(stamps);
    config.run.step_us = froude.map_or(period_us, |froude| froude.site_us(period_us));
    HilSession::new(mission.simulation(), config)
}

fn hil_config(
    mission: &Mission,
    system_id: u8,
    froude: Option<Froude>,
    companion: Option<Duration>,
) -> HilConfig {
    let default = DropRunConfig::default();
    let run = DropRunConfig {
        step_us: froude.map_or(default.step_us, Froude::step_us),
        duration_us: microseconds(mission.duration_s),
        trigger: mission.release.trigger,
        battery: mission.battery,
        limits: Some(mission.limits.safety),
    };
    let allow_faults = mission.faults.allow_command;
    HilConfig {
        system_id,
        froude,
        run,
        sensors: mission.sensors,
        seed: mission.seed,
        companion,
        allow_faults,
        real_time: None,
    }
}

/// The reference autopilot with the mission's gains, and with what else a parameter file holds; and remarks
/// on what of the file is not taken. It flies on the simulator's truth, or on its own Kalman filter.
///
/// # Errors
/// [`PartyError`] for a vehicle that cannot be controlled, gains out of range, or a file that is refused.
pub fn autopilot(
    mission: &Mission,
    parameters: Option<&Path>,
    on_estimator: bool,
    system_id: u8,
) -> Result<(AutopilotSession, Vec<String>), PartyError> {
    autopilot_under(mission, None, parameters, on_estimator, system_id)
}

/// The reference autopilot as [`autopilot`] makes it, with a controller in the place of the cascade.
///
/// # Errors
/// As [`autopilot`].
pub fn autopilot_under(
    mission: &Mission,
    controller: Option<Box<dyn Controller>>,
    parameters: Option<&Path>,
    on_estimator: bool,
    system_id: u8,
) -> Result<(AutopilotSession, Vec<String>), PartyError> {
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment)
        .map_err(|source| PartyError::Airframe { vehicle_file: mission.vehicle_file.clone(), source })?;
    let mut session = AutopilotSession::new(AutopilotSetup {
        system_id,
        control: ControlSettings { airframe, gains: mission.control.gains, limits: mission.control.limits },
        controller,
        environment: mission.site.environment.clone(),
        estimator: on_estimator.then(|| estimator_settings(mission)),
        rotors: mission.vehicle.rotors.len(),
        epoch_unix_us: mission.epoch_unix_us,
        parameters: Parameters::of(&mission.parameter_subject(), system_id)?,
        keeps_parameters: true,
    });
    if let Some(settings) = mission.release.free_fall {
        session = session.looking_for_a_fall(settings);
    }
    let remarks = match parameters {
        Some(path) => session.load_parameters(&load_parameters(path)?),
        None => Vec::new(),
    };
    Ok((session, remarks))
}

/// The estimator at the mission's site: it knows gravity, the magnetic field and how late satellite fixes
/// are, as a crew would set it up, and takes the sensors for typical ones.
fn estimator_settings(mission: &Mission) -> EstimatorSettings {
    let field_ned_gauss = mission.sensors.magnetometer.field_at(&mission.site.environment);
    EstimatorSettings {
        gps_delay_us: mission.sensors.satellite.delay_us,
        ..EstimatorSettings::at_site(mission.site.environment.gravity_m_s2, field_ned_gauss)
    }
}

/// What a streamer depends on beside the mission.
#[derive(Clone, Debug, Default)]
pub struct StreamerChoice {
    /// The streamer's clock.
    pub clock: Clock,
    /// What the vehicle must be given and must show before it is released.
    pub procedure: Option<Procedure>,
    /// The scale of the wire.
    pub froude: Option<Froude>,
    /// Renewals of the plan, and who solves for them; they feed the plan's acceleration forward.
    pub replan: Option<(ReplanSetup, SolvedBy)>,
}

/// The offboard streamer of a plan.
pub fn streamer(
    mission: &Mission,
    trajectory: Trajectory,
    vehicle_system: u8,
    choice: StreamerChoice,
) -> StreamerSession {
    let StreamerChoice { clock, procedure, froude, replan } = choice;
    let mut config = StreamerConfig {
        vehicle_system,
        hang_s: mission.release.hang_s,
        free_fall: mission.release.free_fall,
        commands_release: mission.release.trigger == ReleaseTrigger::Command,
        delay_s: mission.release.parachute.delay_s,
        gravity_m_s2: mission.site.environment.gravity_m_s2,
        target_v_ned: mission.target_v_ned,
        feed_forward: mission.control.feed_forward || replan.is_some(),
        froude,
        clock,
        procedure,
        ..StreamerConfig::default()
    };
    if let Some(froude) = froude {
        // Periods that the autopilot's clock sets the pace of.
        for period in [&mut config.setpoint_period_us, &mut config.lead_us, &mut config.settle_us] {
            *period = froude.site_us(*period);
        }
        config.attempts = (f64::from(config.attempts) * froude.k()).ceil() as u32;
    }
    let session = StreamerSession::new(config, trajectory);
    match replan {
        Some((setup, by)) => session.renewing(setup, by),
        None => session,
    }
}
