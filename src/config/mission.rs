//! A mission, checked, with the model objects that it describes.

use std::path::PathBuf;
use std::sync::Arc;

use nalgebra::Vector3;

use super::mission_choices::Inputs;
use super::mission_releases::MonteCarlo;
use crate::assess::SafetyLimits;
use crate::control::{ControlLimits, Gains};
use crate::model::{Environment, MAX_ROTORS, Parachute, Vehicle};
use crate::plan::{InputReference, PlanProblem, PlanState};
use crate::sim::{Battery, DropSimulation, Ground, ReleaseTrigger, SensorSettings, Start};
use crate::tune::ReleaseCase;

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

/// Gravity, air and place of a mission, and what is below.
#[derive(Clone, Debug)]
pub struct Site {
    /// Gravity, air, wind and the local origin's place on the globe.
    pub environment: Environment,
    /// Level ground below the release; `None`: the air has no end.
    pub ground: Option<Ground>,
}

/// How the vehicle is brought to the air and cut loose.
#[derive(Clone, Debug)]
pub struct Release {
    /// Descent, swing and the delay between the release and the start of the rotors.
    pub parachute: Parachute,
    /// Time under the canopy until the nominal release [s].
    pub hang_s: f64,
    /// How the vehicle comes from the release to t = 0.
    pub start: Start,
    /// Whether the vehicle stands on the ground at the start, instead of hanging under its canopy.
    pub standing: bool,
    /// What cuts the vehicle loose.
    pub trigger: ReleaseTrigger,
}

/// The optimal control problem, (25)-(32), but for the vehicle, its initial state and its target.
#[derive(Clone, Debug)]
pub struct PlanSettings {
    /// Horizon of the plan, t_f [s].
    pub horizon_s: f64,
    /// What the plan starts from.
    pub initial: PlanInitial,
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
}

/// What a flight is judged by.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Safety limits, Table 1.
    pub safety: SafetyLimits,
    /// How close to the target velocity is steady [m/s].
    pub steady_within_m_s: f64,
    /// Fastest touch of the ground that is within the limits [m/s].
    pub impact_m_s: f64,
}

/// The cascade that flies the mission.
#[derive(Clone, Debug)]
pub struct Control {
    /// Limits of the cascade.
    pub limits: ControlLimits,
    /// Gains of the cascade.
    pub gains: Gains,
    /// Name of the set of gains.
    pub gains_name: String,
}

/// The releases that gains are tuned on and that a safety study draws.
#[derive(Clone, Debug)]
pub struct Study {
    /// Releases that the gains are tuned on, Table 3.
    pub cases: Vec<ReleaseCase>,
    /// Random releases.
    pub monte_carlo: MonteCarlo,
}

/// How a PX4 flies the mission.
#[derive(Clone, Debug)]
pub struct Px4 {
    /// How it is connected.
    pub clock: Px4Clock,
    /// The parameter file that PX4 flies the mission with, unless another or gains are chosen. Not read yet.
    pub params: Option<PathBuf>,
}

/// A drop, ready to be planned and flown.
#[derive(Clone, Debug)]
pub struct Mission {
    /// Name; results go to `out/<name>/`.
    pub name: String,
    /// Name of the vehicle.
    pub vehicle_name: String,
    /// File of the vehicle.
    pub vehicle_file: PathBuf,
    /// The vehicle.
    pub vehicle: Arc<Vehicle>,
    /// Steady velocity to reach, v_cmd, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Length of the simulation, from the start of the hang [s].
    pub duration_s: f64,
    /// Time of the simulation's start [us since 1970-01-01 UTC].
    pub epoch_unix_us: u64,
    /// Seed of everything random.
    pub seed: u64,
    /// Gravity, air, place and ground.
    pub site: Site,
    /// Parachute, hang and release.
    pub release: Release,
    /// The optimal control problem.
    pub plan: PlanSettings,
    /// What a flight is judged by.
    pub limits: Limits,
    /// Gains and limits of the cascade.
    pub control: Control,
    /// Cases that gains are tuned on, and random releases.
    pub study: Study,
    /// Errors of the sensors.
    pub sensors: SensorSettings,
    /// The battery, if it matters.
    pub battery: Option<Battery>,
    /// How a PX4 flies the mission.
    pub px4: Px4,
    /// What the results depend on: the files' hash and what was chosen beside them.
    pub inputs: Inputs,
}

impl Mission {
    /// The state that a plan starts from, [`PlanInitial`]; adrift with the wind.
    pub fn plan_initial_state(&self) -> PlanState {
        match self.plan.initial {
            PlanInitial::Paper => {
                let drift = self.site.environment.drift_ned_m_s();
                let v0 = self.release.parachute.v0_m_s(self.site.environment.gravity_m_s2);
                [1.0, 0.0, 0.0, 0.0, drift.x, drift.y, v0, 0.0, 0.0, 0.0]
            }
            PlanInitial::Release => {
                let body = DropSimulation::nominal_state_at_t0(
                    self.vehicle.clone(),
                    self.site.environment.clone(),
                    self.release.parachute,
                    self.release.start,
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
            environment: &self.site.environment,
            initial: self.plan_initial_state(),
            initial_thrust_n: [0.0; MAX_ROTORS],
            target_v_ned: self.target_v_ned,
            x_ss: self.plan.x_ss,
            horizon_s: self.plan.horizon_s,
            nodes: self.plan.nodes,
            thrust_max_n: self.plan.thrust_max_n,
            thrust_rate_n_s: self.plan.thrust_slew_n_s,
            cost_state: self.plan.cost_state,
            cost_input: self.plan.cost_input,
            input_reference: self.plan.cost_input_reference,
            terminal_velocity_tolerance_m_s: None,
        }
    }
}
