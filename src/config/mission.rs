//! A mission, checked, with the model objects that it describes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Vector3;

use super::gains_file::{gains_path, load_named_gains};
use super::mission_ground::{self, MissionGround};
use super::mission_json::{InitialJson, InputReferenceJson, MissionJson, StartJson};
use super::mission_parts as parts;
use super::mission_sensors;
use super::number::NonNegative;
use super::source::{InputHash, Source};
use super::trajectory_csv::{TrajectoryFile, load_trajectory};
use super::vehicle_file::load_named_vehicle;
use super::{ConfigError, GainsFile, VehicleFile};
use crate::assess::{RandomDrop, ReleaseDistribution, SafetyLimits, steady_within_m_s};
use crate::control::{ControlLimits, Gains};
use crate::model::parachute::Pendulum;
use crate::model::{Environment, MAX_ROTORS, Parachute, Vehicle};
use crate::plan::{InputReference, PlanProblem, PlanState};
use crate::sim::{Battery, DropSimulation, ReleaseTrigger, SensorSettings, Start};
use crate::tune::ReleaseCase;
use crate::units::RAD_PER_DEG;

/// State that a plan starts from, rotors at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanInitial {
    /// The paper's (44) without the swing: level and still, descending at `v_0 = descent + g t_d`.
    Paper,
    /// Where the drop comes to after a release at the end of the hang, with its swing and braked by the air.
    Release,
}

/// How a PX4 that flies the mission is connected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Px4Clock {
    /// In the site's units and time.
    Real,
    /// By Froude's similarity, in the units and time of standard gravity.
    Froude,
}

/// Random releases, (40)-(44): the swing's amplitude is normal about 0, its phase uniform over the turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonteCarlo {
    /// Releases in a campaign.
    pub trials: usize,
    /// Standard deviation of the amplitude theta_0 [rad].
    pub amplitude_sigma_rad: f64,
    /// Frequency of the swing [rad/s].
    pub omega_rad_s: f64,
    /// Length r of the pendulum [m].
    pub length_m: f64,
    /// Standard deviation of the wind in north and in east, in campaigns of whole drops [m/s].
    pub wind_sigma_m_s: f64,
}

/// A drop, ready to be planned and flown.
#[derive(Clone, Debug)]
pub struct Mission {
    /// Name; results go to `out/<name>/`.
    pub name: String,
    /// Name of the vehicle.
    pub vehicle_name: String,
    /// The vehicle.
    pub vehicle: Arc<Vehicle>,
    /// Gravity, air and place.
    pub environment: Environment,
    /// Descent, swing and delay.
    pub parachute: Parachute,
    /// Steady velocity to reach, v_cmd, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Horizon of the plan, t_f [s].
    pub horizon_s: f64,
    /// What the plan starts from.
    pub plan_initial: PlanInitial,
    /// Number of nodes of the plan; one more than its intervals.
    pub nodes: usize,
    /// Greatest thrust of a rotor in the plan [N].
    pub thrust_max_n: f64,
    /// Greatest rate of change of a rotor's thrust in the plan [N/s].
    pub thrust_slew_n_s: f64,
    /// Diagonal of Q and S over `[q0 q1 q2 q3 vn ve vd p q r]`.
    pub cost_state: [f64; 10],
    /// Diagonal of R [1/N^2].
    pub cost_input: f64,
    /// Thrust that costs nothing.
    pub cost_input_reference: InputReference,
    /// Reference state of the cost, (31), in the order of `cost_state`; `None`: the solved trim.
    pub x_ss: Option<[f64; 10]>,
    /// Safety limits, Table 1.
    pub limits: SafetyLimits,
    /// How close to the target velocity is steady [m/s].
    pub steady_within_m_s: f64,
    /// Limits of the cascade.
    pub control_limits: ControlLimits,
    /// Gains of the cascade.
    pub gains: Gains,
    /// Their name.
    pub gains_name: String,
    /// How the vehicle comes from the release to t = 0.
    pub start: Start,
    /// Time under the canopy until the nominal release [s].
    pub hang_s: f64,
    /// Length of the simulation, from the start of the hang [s].
    pub duration_s: f64,
    /// Time of the simulation's start [us since 1970-01-01 UTC].
    pub epoch_unix_us: u64,
    /// What is below, if it matters.
    pub ground: Option<MissionGround>,
    /// The battery, if it matters.
    pub battery: Option<Battery>,
    /// Errors of the sensors.
    pub sensors: SensorSettings,
    /// How a PX4 is connected.
    pub px4_clock: Px4Clock,
    /// What cuts the vehicle loose.
    pub release_trigger: ReleaseTrigger,
    /// What the gains are tuned on, Table 3.
    pub tuning_cases: Vec<ReleaseCase>,
    /// Random releases.
    pub monte_carlo: MonteCarlo,
    /// Seed of everything random.
    pub seed: u64,
    /// SHA-256 of mission, vehicle, tables and gains, and of what was chosen beside them, hexadecimal.
    pub input_hash: String,
    /// What was chosen beside the files: name and value, in the order of choosing.
    pub choices: Vec<(String, String)>,
    /// For putting other gains in.
    gains_shelf: GainsShelf,
}

/// Where gains come from, and the hash of every other input.
#[derive(Clone)]
struct GainsShelf {
    directory: PathBuf,
    hash_without_gains: InputHash,
}

impl std::fmt::Debug for GainsShelf {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        self.directory.fmt(f)
    }
}

impl GainsShelf {
    /// Reads a gains file; with it, the hash of all inputs.
    fn take(&self, path: &Path, named_in: Option<&Path>) -> Result<(GainsFile, String), ConfigError> {
        let mut hash = self.hash_without_gains.clone();
        let gains = load_named_gains(path, named_in, &mut hash)?;
        Ok((gains, hash.hex()))
    }
}

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
    let gains_file = source.resolve(&json.gains);
    let directory = gains_file.parent().map(Path::to_owned).unwrap_or_default();
    let gains_shelf = GainsShelf { directory, hash_without_gains: hash };
    let (gains, input_hash) = gains_shelf.take(&gains_file, Some(path))?;
    parts::check_times(&source, &json)?;
    parts::check_x_ss(&source, json.plan.x_ss.as_ref(), json.target_v_ned_m_s.get())?;
    build(&source, &json, vehicle, gains, input_hash, gains_shelf)
}

impl Mission {
    /// Puts other gains in: those of the file `name_or_path`, or of that name beside the mission's own gains file. The input
    /// hash follows.
    ///
    /// # Errors
    /// [`ConfigError`] when the file cannot be read or does not hold gains; the mission is unchanged then.
    pub fn use_gains(&mut self, name_or_path: &str) -> Result<(), ConfigError> {
        let path = gains_path(name_or_path, &self.gains_shelf.directory);
        let (gains, input_hash) = self.gains_shelf.take(&path, None)?;
        self.gains = gains.gains;
        self.gains_name = gains.name;
        self.input_hash = input_hash;
        for (name, value) in self.choices.clone() {
            self.absorb(&name, &value);
        }
        Ok(())
    }

    /// Hash of mission, vehicle and tables without the gains: the inputs of a search for gains.
    pub fn hash_without_gains(&self) -> String {
        self.gains_shelf.hash_without_gains.hex()
    }

    /// The random releases, (40)-(44).
    pub fn releases(&self) -> ReleaseDistribution {
        let mc = &self.monte_carlo;
        let mut parachute = self.parachute;
        parachute.pendulum = Pendulum {
            amplitude_rad: 0.0,
            phase_rad: 0.0,
            omega_rad_s: mc.omega_rad_s,
            length_m: mc.length_m,
        };
        ReleaseDistribution {
            parachute,
            gravity_m_s2: self.environment.gravity_m_s2,
            drift_ned_m_s: self.environment.drift_ned_m_s(),
            amplitude_sigma_rad: mc.amplitude_sigma_rad,
        }
    }

    /// The drop of a trial of a campaign.
    pub fn draw_drop(&self, trial: u64) -> RandomDrop {
        self.releases().draw_drop(self.seed, trial, self.monte_carlo.wind_sigma_m_s)
    }

    /// The mission with what was drawn for a drop: swing, wind and noise. It keeps its name and the hash of its inputs; the plan's
    /// start is not what was drawn, since nobody knows that beforehand.
    pub fn with_drop(&self, drop: &RandomDrop) -> Self {
        let mut mission = self.clone();
        mission.parachute.pendulum = Pendulum {
            amplitude_rad: drop.amplitude_rad,
            phase_rad: drop.phase_rad,
            omega_rad_s: self.monte_carlo.omega_rad_s,
            length_m: self.monte_carlo.length_m,
        };
        mission.environment.wind_ned_m_s += drop.wind_ned_m_s;
        mission.seed = drop.seed;
        mission
    }

    /// Notes what was chosen beside the files and decides what results hold (an option of the command line, the hash of a
    /// trajectory). The input hash follows.
    pub fn note_choice(&mut self, name: &str, value: &str) {
        self.choices.push((name.to_owned(), value.to_owned()));
        self.absorb(name, value);
    }

    /// Puts another seed in. The input hash follows.
    pub fn use_seed(&mut self, seed: u64) {
        if seed != self.seed {
            self.seed = seed;
            self.note_choice("seed", &seed.to_string());
        }
    }

    /// Reads a trajectory for the mission's vehicle, to be flown instead of a plan. The input hash follows.
    ///
    /// # Errors
    /// [`ConfigError`] when the file is wrong or for another number of rotors; the mission is unchanged then.
    pub fn use_trajectory(&mut self, path: &Path) -> Result<TrajectoryFile, ConfigError> {
        let file = load_trajectory(path, self.vehicle.rotors.len())?;
        self.note_choice("trajectory sha256", &file.sha256);
        Ok(file)
    }

    fn absorb(&mut self, name: &str, value: &str) {
        let mut hash = InputHash::default();
        hash.follow(&self.input_hash);
        hash.absorb_text(name, value);
        self.input_hash = hash.hex();
    }

    /// The input hash with one more file in it.
    pub(super) fn hash_with(&self, role: &str, source: &Source) -> String {
        let mut hash = self.gains_shelf.hash_without_gains.clone();
        hash.follow(&self.input_hash);
        hash.absorb(role, source);
        hash.hex()
    }

    /// The state that a plan starts from, [`PlanInitial`]; adrift with the wind.
    pub fn plan_initial_state(&self) -> PlanState {
        match self.plan_initial {
            PlanInitial::Paper => {
                let drift = self.environment.drift_ned_m_s();
                let v0 = self.parachute.v0_m_s(self.environment.gravity_m_s2);
                [1.0, 0.0, 0.0, 0.0, drift.x, drift.y, v0, 0.0, 0.0, 0.0]
            }
            PlanInitial::Release => {
                let body = DropSimulation::nominal_state_at_t0(
                    self.vehicle.clone(),
                    self.environment.clone(),
                    self.parachute,
                    self.start,
                );
                let (q, v, w) = (body.q_ned_from_body, body.v_ned, body.omega_body);
                [q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z]
            }
        }
    }

    /// The planner's problem: from the nominal state at t = 0, rotors at rest, to the target.
    pub fn plan_problem(&self) -> PlanProblem<'_> {
        PlanProblem {
            vehicle: &self.vehicle,
            environment: &self.environment,
            initial: self.plan_initial_state(),
            initial_thrust_n: [0.0; MAX_ROTORS],
            target_v_ned: self.target_v_ned,
            x_ss: self.x_ss,
            horizon_s: self.horizon_s,
            nodes: self.nodes,
            thrust_max_n: self.thrust_max_n,
            thrust_rate_n_s: self.thrust_slew_n_s,
            cost_state: self.cost_state,
            cost_input: self.cost_input,
            input_reference: self.cost_input_reference,
            terminal_velocity_tolerance_m_s: None,
        }
    }
}

fn build(
    source: &Source,
    json: &MissionJson,
    vehicle: VehicleFile,
    gains: GainsFile,
    input_hash: String,
    gains_shelf: GainsShelf,
) -> Result<Mission, ConfigError> {
    let (environment, parachute) = (parts::environment(source, json)?, parts::parachute(source, json)?);
    let (plan, limits, control) = (&json.plan, &json.limits, &json.control);
    Ok(Mission {
        name: json.name.0.clone(),
        vehicle_name: vehicle.name,
        vehicle: Arc::new(vehicle.vehicle),
        sensors: mission_sensors::sensors(source, json, &environment)?,
        px4_clock: parts::px4_clock(source, json)?,
        environment,
        parachute,
        target_v_ned: json.target_v_ned_m_s.get().into(),
        horizon_s: plan.horizon_s.get(),
        plan_initial: match plan.initial {
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
        limits: SafetyLimits {
            speed_m_s: limits.speed_m_s.get(),
            pitch_rad: limits.pitch_deg.get() * RAD_PER_DEG,
            pitch_rate_rad_s: limits.pitch_rate_deg_s.get() * RAD_PER_DEG,
            vertical_acceleration_m_s2: limits.vertical_acceleration_m_s2.get(),
        },
        steady_within_m_s: limits
            .steady_within_m_s
            .map_or_else(|| steady_within_m_s(&json.target_v_ned_m_s.get().into()), |s| s.get()),
        control_limits: ControlLimits {
            tilt_rad: control.tilt_limit_deg.get() * RAD_PER_DEG,
            rate_command_rad_s: control.rate_command_limit_deg_s.get() * RAD_PER_DEG,
            yaw_rate_command_rad_s: control.yaw_rate_command_limit_deg_s.get() * RAD_PER_DEG,
            rate_integral_rad_s2: control.rate_integral_limit_rad_s2.get(),
        },
        gains: gains.gains,
        gains_name: gains.name,
        start: match json.release.start {
            StartJson::Release => Start::Release,
            StartJson::T0 => Start::T0,
            StartJson::Ground => Start::Release,
        },
        hang_s: json.release.hang_s.get(),
        duration_s: json.duration_s.get(),
        epoch_unix_us: json.epoch_unix_us.get() as u64,
        ground: mission_ground::ground(source, json)?,
        battery: mission_ground::battery(json),
        release_trigger: parts::trigger(source, json)?,
        tuning_cases: json.tuning.cases.iter().map(parts::release_case).collect(),
        monte_carlo: MonteCarlo {
            trials: json.monte_carlo.trials.get(),
            amplitude_sigma_rad: json.monte_carlo.amplitude_sigma_deg.get() * RAD_PER_DEG,
            omega_rad_s: json.monte_carlo.omega_rad_s.get(),
            length_m: json.monte_carlo.length_m.get(),
            wind_sigma_m_s: json.monte_carlo.wind_sigma_m_s.map_or(0.0, |s| s.get()),
        },
        seed: json.seed,
        input_hash,
        choices: Vec::new(),
        gains_shelf,
    })
}
