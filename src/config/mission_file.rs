//! The mission file: `mission/*.json`, with the vehicle and the gains that it names.

use std::path::Path;
use std::sync::Arc;

use super::mission::{Control, Limits, Mission, PlanInitial, PlanSettings, Px4, Release, Site, Study};
use super::mission_choices::Inputs;
use super::mission_ground;
use super::mission_json::{InitialJson, InputReferenceJson, MissionJson, StartJson};
use super::mission_parts as parts;
use super::mission_releases::MonteCarlo;
use super::mission_sensors;
use super::number::NonNegative;
use super::source::{InputHash, Source};
use super::vehicle_file::load_named_vehicle;
use super::{ConfigError, GainsFile, VehicleFile};
use crate::assess::{SafetyLimits, steady_within_m_s};
use crate::control::ControlLimits;
use crate::plan::InputReference;
use crate::sim::Start;
use crate::units::RAD_PER_DEG;

/// Reads a mission, its vehicle and its gains.
///
/// # Errors
/// [`ConfigError`] with the place in the file that is refused.
pub fn load_mission(path: &Path) -> Result<Mission, ConfigError> {
    let source = Source::read(path, "mission file", None)?;
    let json: MissionJson = source.parse()?;
    let mut hash = InputHash::default();
    hash.absorb("mission", &source);
    let vehicle = load_named_vehicle(&source.resolve(&json.vehicle), Some(path), &mut hash)?;
    let (inputs, gains) = Inputs::of_files(&source.resolve(&json.gains), path, hash)?;
    parts::check_times(&source, &json)?;
    parts::check_x_ss(&source, json.plan.x_ss.as_ref(), json.target_v_ned_m_s.get())?;
    parts::check_case_names(&source, &json.tuning.cases)?;
    build(&source, &json, vehicle, gains, inputs)
}

fn build(
    source: &Source,
    json: &MissionJson,
    vehicle: VehicleFile,
    gains: GainsFile,
    inputs: Inputs,
) -> Result<Mission, ConfigError> {
    let (environment, parachute) = (parts::environment(source, json)?, parts::parachute(source, json)?);
    let (plan, limits, control) = (&json.plan, &json.limits, &json.control);
    Ok(Mission {
        name: json.name.0.clone(),
        vehicle_name: vehicle.name,
        vehicle_file: source.resolve(&json.vehicle),
        vehicle: Arc::new(vehicle.vehicle),
        target_v_ned: json.target_v_ned_m_s.get().into(),
        duration_s: json.duration_s.get(),
        epoch_unix_us: json.epoch_unix_us.get() as u64,
        seed: json.seed.get() as u64,
        sensors: mission_sensors::sensors(source, json, &environment)?,
        battery: mission_ground::battery(json),
        px4: Px4 {
            clock: parts::px4_clock(source, json)?,
            params: json.px4_params.as_deref().map(|path| source.resolve(path)),
        },
        site: Site { environment, ground: mission_ground::ground(source, json)? },
        release: Release {
            parachute,
            hang_s: json.release.hang_s.get(),
            start: match json.release.start {
                StartJson::Release | StartJson::Ground => Start::Release,
                StartJson::T0 => Start::T0,
            },
            standing: matches!(json.release.start, StartJson::Ground),
            trigger: parts::trigger(source, json)?,
        },
        plan: PlanSettings {
            horizon_s: plan.horizon_s.get(),
            initial: match plan.initial {
                Some(InitialJson::Release) => PlanInitial::Release,
                Some(InitialJson::Paper) | None => PlanInitial::Paper,
            },
            nodes: plan.nodes.get(),
            thrust_max_n: plan.thrust_max_n.get(),
            thrust_slew_n_s: plan.thrust_slew_n_s.get(),
            cost_state: plan.cost_state.0.map(NonNegative::get),
            cost_input: plan.cost_input_per_n2.get(),
            cost_input_reference: match plan.cost_input_reference {
                InputReferenceJson::Zero => InputReference::Zero,
                InputReferenceJson::Trim => InputReference::Trim,
            },
            x_ss: plan.x_ss.as_ref().map(parts::state_vector),
        },
        limits: Limits {
            safety: SafetyLimits {
                speed_m_s: limits.speed_m_s.get(),
                pitch_rad: limits.pitch_deg.get() * RAD_PER_DEG,
                pitch_rate_rad_s: limits.pitch_rate_deg_s.get() * RAD_PER_DEG,
                vertical_acceleration_m_s2: limits.vertical_acceleration_m_s2.get(),
            },
            steady_within_m_s: limits
                .steady_within_m_s
                .map_or_else(|| steady_within_m_s(&json.target_v_ned_m_s.get().into()), |s| s.get()),
            impact_m_s: limits.impact_speed_m_s.map_or(mission_ground::IMPACT_LIMIT_M_S, |limit| limit.get()),
        },
        control: Control {
            limits: ControlLimits {
                tilt_rad: control.tilt_limit_deg.get() * RAD_PER_DEG,
                rate_command_rad_s: control.rate_command_limit_deg_s.get() * RAD_PER_DEG,
                yaw_rate_command_rad_s: control.yaw_rate_command_limit_deg_s.get() * RAD_PER_DEG,
                rate_integral_rad_s2: control.rate_integral_limit_rad_s2.get(),
            },
            gains: gains.gains,
            gains_name: gains.name,
        },
        study: Study {
            cases: json.tuning.cases.iter().map(parts::release_case).collect(),
            monte_carlo: MonteCarlo {
                trials: json.monte_carlo.trials.get(),
                amplitude_sigma_rad: json.monte_carlo.amplitude_sigma_deg.get() * RAD_PER_DEG,
                omega_rad_s: json.monte_carlo.omega_rad_s.get(),
                length_m: json.monte_carlo.length_m.get(),
                wind_sigma_m_s: json.monte_carlo.wind_sigma_m_s.map_or(0.0, |s| s.get()),
            },
        },
        inputs,
    })
}
