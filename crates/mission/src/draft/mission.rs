//! A mission file for a vehicle, on a planet at an altitude.

use super::{rounded, text};
use samara_core::math;
use samara_core::model::Planet;
use samara_core::model::{ModelError, RotorLimits, Vehicle};
use samara_core::units::{RAD_PER_DEG, STANDARD_GRAVITY_M_S2};

/// What the vehicle is released from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleasedFrom {
    /// A parachute in steady descent.
    Parachute,
    /// A balloon that neither climbs nor sinks.
    Balloon,
}

impl ReleasedFrom {
    /// Both of them.
    pub const ALL: [Self; 2] = [Self::Parachute, Self::Balloon];

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parachute => "parachute",
            Self::Balloon => "balloon",
        }
    }
}

/// What is known of a mission.
#[derive(Clone, Debug, PartialEq)]
pub struct MissionDraft {
    /// Name: letters, digits, `_` and `-`.
    pub name: String,
    /// Path of the vehicle file, from the mission's folder.
    pub vehicle: String,
    /// Path of the gains file, from the mission's folder.
    pub gains: String,
    /// Where it is.
    pub planet: Planet,
    /// Altitude of the release above mean sea level [m].
    pub altitude_m: f64,
    /// What the vehicle is released from.
    pub from: ReleasedFrom,
    /// Rate of descent under the parachute [m/s]; estimated when left out.
    pub descent_m_s: Option<f64>,
    /// Time between the release and the start of the rotors [s].
    pub delay_s: f64,
    /// Velocity to reach, NED [m/s].
    pub target_v_ned: [f64; 3],
    /// Safety limit of the speed [m/s]; estimated when left out.
    pub speed_limit_m_s: Option<f64>,
    /// Number of nodes of the plan.
    pub nodes: usize,
    /// Path of the schema from the mission's folder, for editors.
    pub schema: Option<String>,
}

/// Number of nodes that a draft begins with: the paper's.
pub const DRAFT_NODES: usize = 38;

/// Descent of the parachute that is taken where none is given, at sea level on Earth [m/s].
const DESCENT_M_S: f64 = 5.0;
/// Swing of the releases: standard deviation [deg], and length of the pendulum [m].
const SWING_DEG: f64 = 3.0;
const PENDULUM_M: f64 = 1.0;
/// Time under the canopy [s]: a PX4 wants 12.
const HANG_S: f64 = 15.0;
/// Part of it that a hook holds the vehicle still, where PX4 may fly: its estimator starts at rest [s].
const HOOK_S: f64 = 8.0;
/// Noise of the magnetometer where PX4 may fly, which takes readings that do not change for a broken sensor's
/// [gauss].
/// 16 g, by standard gravity.
const ACCELEROMETER_RANGE_M_S2: f64 = 156.9064;
/// 2000 deg/s.
const GYROSCOPE_RANGE_RAD_S: f64 = 34.90659;
const MAGNETOMETER_NOISE_GAUSS: f64 = 0.002;
/// How close to the target's velocity is steady, in the mean over 2 s: as of the missions that are shipped,
/// which fly in wind and turbulence, too [m/s].
const STEADY_M_S: f64 = 0.3;
/// Share of the rotors' thrust that the plan may use: the rest is the controller's.
const PLANNED_SHARE: f64 = 0.9;
/// Rate at which the plan's thrusts may change, in full thrusts a second under Earth's gravity.
const PLANNED_SLEW_PER_S: f64 = 5.0;

/// The text of a mission file, as [`load_mission`](crate::load_mission) reads it.
///
/// # Errors
/// [`ModelError`] when the planet's air is not known at the altitude, or a number is out of its range.
pub fn mission_draft_json(draft: &MissionDraft, vehicle: &Vehicle) -> Result<String, ModelError> {
    let MissionDraft { planet, altitude_m, delay_s, target_v_ned, .. } = *draft;
    let (g, density) = (rounded(planet.gravity_m_s2(altitude_m)), rounded(planet.density_kg_m3(altitude_m)?));
    samara_core::model::check((0.0..=60.0).contains(&delay_s), "delay", "from 0 to 60 s", delay_s)?;
    // Times and speeds of the same manoeuvre under another gravity (Froude).
    let slower = (STANDARD_GRAVITY_M_S2 / g).sqrt();
    let (descent, descent_about) = match (draft.from, draft.descent_m_s) {
        (ReleasedFrom::Balloon, _) => (0.0, "A balloon: no descent".to_owned()),
        (ReleasedFrom::Parachute, Some(descent)) => (descent, "A parachute".to_owned()),
        (ReleasedFrom::Parachute, None) => {
            let estimated = DESCENT_M_S * ((g / STANDARD_GRAVITY_M_S2) * (1.225 / density)).sqrt();
            (
                (10.0 * estimated).round().max(1.0) / 10.0,
                format!("Estimated: the parachute that sinks at {DESCENT_M_S} m/s at sea level on Earth"),
            )
        }
    };
    let mut estimated =
        vec!["monte_carlo", "limits.pitch_deg", "limits.pitch_rate_deg_s", "limits.steady_within_m_s"];
    estimated.extend(draft.speed_limit_m_s.is_none().then_some("limits.speed_m_s"));
    let is_given = draft.from == ReleasedFrom::Balloon || draft.descent_m_s.is_some();
    estimated.extend((!is_given).then_some("parachute.descent_m_s"));
    estimated.sort_unstable();
    let estimated = serde_json::Value::from(estimated).to_string().replace(',', ", ");
    let fastest = descent + g * delay_s;
    let target_speed = target_v_ned.iter().map(|v| v * v).sum::<f64>().sqrt();
    let speed_limit =
        draft.speed_limit_m_s.unwrap_or_else(|| (2.0 * fastest.max(target_speed)).ceil().max(10.0));
    let rotors = RotorLimits::of(vehicle, density);
    let up: f64 = vehicle.rotors.iter().map(|r| -r.axis_body.z).sum();
    let thrust_max_n = rounded(PLANNED_SHARE * rotors.thrust_n);
    let spare = (thrust_max_n * up / (vehicle.mass.mass_kg * g)).clamp(1.1, 2.0) - 1.0;
    let horizon_s = (5.0 * slower).max(4.0 * (fastest + target_speed) / (spare * g)).ceil().min(200.0);
    let slew_n_s = rounded((PLANNED_SLEW_PER_S / slower * thrust_max_n).min(rotors.thrust_slew_n_s));
    let cost_input = rounded(1e-5 * (300.0 / thrust_max_n) * (300.0 / thrust_max_n));
    let duration_s = (HANG_S + delay_s + horizon_s + (2.0 * horizon_s).max(10.0)).ceil().min(900.0);
    let omega = rounded((g / PENDULUM_M).sqrt());
    let (latitude, longitude, place, wind_sigma) = match planet {
        Planet::Earth => (47.397742, 8.545594, "PX4's default home", 1.5),
        Planet::Titan => (7.0, 161.0, "Selk crater on Titan's map", 0.2),
        Planet::Mars => (18.4, 77.5, "Jezero crater", 3.0),
    };
    let (schema, quoted) = (
        draft.schema.as_ref().map_or_else(String::new, |path| format!("  \"$schema\": {},\n", text(path))),
        [&draft.name, &draft.vehicle, &draft.gains].map(|s| text(s)),
    );
    let [name, vehicle_path, gains_path] = quoted;
    let about = text(&format!(
        "A draft by samara new mission: cut loose from a {} on {} at {altitude_m} m, {delay_s} s of fall. What is estimated says so; \
         the limits are guesses that are yours to set.",
        draft.from.name(),
        planet.name(),
    ));
    let site_about =
        text(&format!("Gravity and density at {altitude_m} m: {}. The place is {place}.", planet.source()));
    let parachute_about =
        text(&format!("{descent_about}. No swing by default; a pendulum of 1 m swings at sqrt(g/1 m)."));
    let plan_about = text(&format!(
        "Weights of the paper; the input cost is its 1e-5 scaled by (300/thrust_max_n)^2. {:.0} % of the {:.4} N that a rotor makes \
         here; what is left is the controller's.",
        100.0 * PLANNED_SHARE,
        rotors.thrust_n
    ));
    let limits_about = text(
        "Guesses: speed twice that of the fall without air, Table 1's pitch, PX4's pitch rate. Set them to what your vehicle bears.",
    );
    let [v_n, v_e, v_d] = target_v_ned;
    let magnetometer = match planet {
        Planet::Earth => format!(
            ",\n    \"magnetometer\": {{ \"field\": \"world_magnetic_model\", \"rate_hz\": 50, \
             \"noise_gauss\": {MAGNETOMETER_NOISE_GAUSS} }}"
        ),
        Planet::Titan | Planet::Mars => String::new(),
    };
    let without_errors = |unit: &str| {
        format!(
            "\"noise_{unit}_per_sqrt_hz\": 0, \"walk_{unit}_per_sqrt_s\": 0, \"turn_on_bias_{unit}\": 0, \"resolution_{unit}\": 0"
        )
    };
    let sensors = format!(
        "  \"sensors\": {{\n    \"about\": {},\n    \"accelerometer\": {{ {}, \"range_m_s2\": {ACCELEROMETER_RANGE_M_S2} }},\n    \
         \"gyroscope\": {{ {}, \"range_rad_s\": {GYROSCOPE_RANGE_RAD_S} }}{magnetometer}\n  }},\n",
        text(
            "Perfect but for their ranges, 16 g and 2000 deg/s, beyond which PX4's readings wrap (SimulatorMavlink), and on Earth the \
             magnetometer: PX4 takes readings that do not change for a broken sensor's."
        ),
        without_errors("m_s2"),
        without_errors("rad_s"),
    );
    let hook = match (planet, draft.from) {
        (Planet::Earth, ReleasedFrom::Parachute) => format!("\"hook_s\": {HOOK_S}, "),
        _ => String::new(),
    };
    Ok(format!(
        "{{\n{schema}  \"about\": {about},\n  \"estimated\": {estimated},\n  \"name\": {name},\n  \"vehicle\": {vehicle_path},\n  \"gains\": {gains_path},\n  \"seed\": 1,\n  \
         \"epoch_unix_us\": 1767225600000000,\n  \"duration_s\": {duration_s},\n  \"target_v_ned_m_s\": [{v_n}, {v_e}, {v_d}],\n  \"site\": \
         {{\n    \"about\": {site_about},\n    \"gravity_m_s2\": {g},\n    \"density_kg_m3\": {density},\n    \"wind_ned_m_s\": [0, 0, 0],\n    \
         \"latitude_deg\": {latitude},\n    \"longitude_deg\": {longitude},\n    \"altitude_m\": {altitude_m}\n  }},\n{sensors}  \"parachute\": {{\n    \
         \"about\": {parachute_about},\n    \"descent_m_s\": {descent},\n    \"delay_s\": {delay_s},\n    \"pendulum\": {{ \"amplitude_deg\": 0, \
         \"phase_deg\": 0, \"omega_rad_s\": {omega}, \"length_m\": {PENDULUM_M:?} }}\n  }},\n  \"release\": {{ \"start\": \"release\", \
         \"hang_s\": {HANG_S}, {hook}\"trigger\": \"command\" }},\n  \"plan\": {{\n    \"about\": {plan_about},\n    \"horizon_s\": {horizon_s},\n    \
         \"initial\": \"release\",\n    \"nodes\": {},\n    \"thrust_max_n\": {thrust_max_n},\n    \"thrust_slew_n_s\": {slew_n_s},\n    \
         \"cost_state\": [1, 1, 1, 1, 1, 1, 1, 10, 10, 10],\n    \"cost_input_per_n2\": {cost_input:?},\n    \"cost_input_reference\": \
         \"zero\",\n    \"terminal_tolerance_m_s\": 0.05\n  }},\n  \"limits\": {{\n    \"about\": {limits_about},\n    \"speed_m_s\": \
         {speed_limit},\n    \"steady_within_m_s\": {STEADY_M_S},\n    \"steady_mean_over_s\": 2,\n    \"pitch_deg\": 45,\n    \"pitch_rate_deg_s\": 220,\n    \
         \"vertical_acceleration_m_s2\": {}\n  }},\n  \"control\": {{\n    \"tilt_limit_deg\": 27,\n    \"rate_command_limit_deg_s\": 132,\n    \
         \"yaw_rate_command_limit_deg_s\": 45,\n    \"rate_integral_limit_rad_s2\": 10,\n    \"latency_s\": 0.005,\n    \"tilt_from\": \"gravity\",\n    \
         \"battery_scaling\": true\n  }},\n  \"tuning\": {{\n    \"about\": \"As Table 3, for \
         this release, by (40)-(44): no swing, and six phases of a swing of three standard deviations.\",\n    \"cases\": [\n{}\n    ]\n  }},\n  \
         \"monte_carlo\": {{\n    \"about\": \"(40)-(44): amplitude normal about 0, phase uniform over the turn. Wind, for whole drops, from \
         anywhere.\",\n    \"trials\": 100,\n    \"amplitude_sigma_deg\": {SWING_DEG},\n    \"omega_rad_s\": {omega},\n    \"length_m\": \
         {PENDULUM_M:?},\n    \"wind_sigma_m_s\": {wind_sigma}\n  }}\n}}\n",
        draft.nodes,
        rounded(2.0 * g),
        cases(fastest, omega).join(",\n"),
    ))
}

/// The release cases: states (44) at t = 0.
fn cases(fastest_m_s: f64, omega_rad_s: f64) -> Vec<String> {
    let amplitude = 3.0 * SWING_DEG * RAD_PER_DEG;
    let case = |i: usize, theta: f64, rate: f64| {
        let (sin, cos) = math::sin_cos(theta);
        let sideways = PENDULUM_M * rate;
        let to_1e_3 = |x: f64| (1e3 * x).round() / 1e3 + 0.0;
        format!(
            "      {{ \"name\": \"case_{i}\", \"v_ned_m_s\": [{}, 0, {}], \"pitch_deg\": {}, \"pitch_rate_deg_s\": {} }}",
            to_1e_3(sideways * cos),
            to_1e_3(fastest_m_s - sideways * sin),
            to_1e_3(theta / RAD_PER_DEG),
            to_1e_3(rate / RAD_PER_DEG),
        )
    };
    let swinging = (0..6).map(|i| {
        let (sin, cos) = math::sin_cos(36.0 * i as f64 * RAD_PER_DEG);
        case(i + 1, amplitude * sin, omega_rad_s * amplitude * cos)
    });
    std::iter::once(case(0, 0.0, 0.0)).chain(swinging).collect()
}
