//! What is made of a mission: the simulation, the planner's problem and its solution, the study, the drops of
//! a campaign, and what its results are stamped with.

use std::ops::ControlFlow;
use std::path::PathBuf;

use nalgebra::Vector3;

use super::{Mission, PlanInitial, Px4Clock, Release, UnfitReplan, contradictions, load_mission};
use crate::error::ConfigError;
use crate::odd::Odd;
use crate::shipped::{MISSIONS, built_in};
use crate::trajectory_csv::Stamp;
use samara_core::assess::Scenario;
use samara_core::assess::{IntegratedPlan, RandomDrop, ReleaseDistribution, SafetyStudy, nodes_enough};
use samara_core::model::{MAX_ROTORS, Parachute};
use samara_core::params::{Purpose, Subject};
use samara_core::plan::{Guess, Plan, PlanError, PlanProblem, PlanState, SolveProgress, SolverOptions, plan};
use samara_core::replan::{Cadence, PlanSource};
use samara_core::sim::{DropSimulation, ElectricBattery, Start, nominal_state_at_t0};
use samara_core::trajectory::Trajectory;

/// A mission whose plan cannot be attempted: the vehicle, the target, and the reason.
#[derive(Debug, thiserror::Error)]
#[error("{} to target_v_ned_m_s [{} {} {}]", vehicle_file.display(), target_v_ned.x, target_v_ned.y, target_v_ned.z)]
pub struct UnplannedError {
    /// File of the vehicle.
    pub vehicle_file: PathBuf,
    /// Target velocity, NED [m/s].
    pub target_v_ned: Vector3<f64>,
    /// Reason.
    pub source: PlanError,
}

impl PlanSource for Mission {
    fn problem_from(&self, initial: PlanState) -> PlanProblem<'_> {
        PlanProblem {
            vehicle: &self.vehicle,
            environment: &self.site.environment,
            initial,
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
            terminal_velocity_tolerance_m_s: self.plan.terminal_tolerance_m_s,
            demands: self.plan.demands,
        }
    }

    fn start(&self) -> Start {
        self.release.start
    }
}

impl Mission {
    /// The mission of this name that the program brings along: `titan_drop`, `x500_drop`, .., with its
    /// vehicle and its gains. No file is read.
    ///
    /// # Errors
    /// [`ConfigError::Read`] when no built-in mission has the name.
    pub fn shipped(name: &str) -> Result<Self, ConfigError> {
        load_mission(&built_in(MISSIONS, name))
    }

    /// Names of the gains that lie beside the mission's own, in order.
    pub fn gains_beside(&self) -> Vec<String> {
        self.inputs.gains_beside()
    }

    /// The texts of the mission's files - mission and vehicle as they were read and, if they are named
    /// `gains_name`, gains as they are now - each with its name among results.
    ///
    /// # Errors
    /// [`ConfigError`] of a file of gains that is no longer there.
    pub fn input_texts(&self, gains_name: &str) -> Result<Vec<(String, String)>, ConfigError> {
        self.inputs.texts(gains_name)
    }

    /// Numbers that the vehicle, or the world, contradicts: each with its key and what they make of it.
    pub fn contradictions(&self) -> Vec<Odd> {
        let (environment, descent_m_s) = (&self.site.environment, self.release.parachute.descent_m_s);
        let start = self.plan_initial_state();
        let mut odd =
            contradictions::of(&self.vehicle, environment, &self.plan, &self.limits, descent_m_s, &start);
        let meet = |radius_m| contradictions::of_rotors_that_meet(&self.vehicle, radius_m);
        odd.extend(self.rotor_radius_m.and_then(meet));
        odd.extend(contradictions::of_a_wake_without_a_factor(&self.vehicle, self.rotor_radius_m));
        odd.extend(contradictions::of_inertia(&self.vehicle, self.rotor_radius_m));
        odd.extend(contradictions::of_air_of_another_altitude(environment));
        let sigma_rad = self.study.monte_carlo.amplitude_sigma_rad;
        odd.extend(contradictions::of_two_bodies(&self.vehicle, environment, &self.release, sigma_rad));
        odd
    }

    /// The prescribed motion under the canopy closest to that of a drop: the parachute's own, or where its
    /// canopy is a body of its own, the steady descent and the linearised swing of both bodies.
    pub fn linearised_parachute(&self) -> Parachute {
        self.release.parachute.linearised(&self.vehicle, &self.site.environment)
    }

    /// What flights from t = 0 have otherwise than drops, a sentence each.
    pub fn t0_remarks(&self) -> Vec<String> {
        let canopy = self.release.parachute.suspension.map(|_| {
            let two = self.linearised_parachute();
            format!(
                "flights from t = 0 begin as (40)-(44) prescribe, without the canopy, which drops have (descent {:.2} m/s, swing \
                 {:.2} rad/s): assess --autopilot flies those",
                two.descent_m_s, two.pendulum.omega_rad_s
            )
        });
        let rotor_start = self.vehicle.start.map(|_| {
            "rotor_start: flights from t = 0 begin with rotors at rest that are driven at once; drops have the start: assess \
             --autopilot flies those"
                .to_owned()
        });
        canopy.into_iter().chain(rotor_start).collect()
    }

    /// How a battery with a voltage acts on flights from t = 0, in a sentence; `None` where there is none.
    pub fn battery_remark(&self) -> Option<&'static str> {
        let remark = "battery.electric: flights from t = 0 have the battery as it is when a drop begins; the plan \
                      has motors on a stiff supply";
        self.electric.as_ref().map(|_| remark)
    }

    /// Speed of the vehicle's level fall with its rotors at rest, in still air at the site [m/s]; `None` when
    /// it is above 1000 m/s.
    pub fn terminal_speed_m_s(&self) -> Option<f64> {
        contradictions::terminal_speed_m_s(&self.vehicle, &self.site.environment)
    }

    /// The simulation at its beginning: under the canopy, or standing.
    pub fn simulation(&self) -> DropSimulation {
        let (vehicle, environment) = (self.vehicle.clone(), self.site.environment.clone());
        let Release { parachute, hang_s, start, standing, .. } = self.release;
        let course = self.site.wind.course(&environment, self.site.wind_number);
        let simulation = match self.site.ground {
            Some(ground) if standing => DropSimulation::standing(vehicle, environment, ground),
            Some(ground) => DropSimulation::new(vehicle, environment, parachute, hang_s, start).above(ground),
            None => DropSimulation::new(vehicle, environment, parachute, hang_s, start),
        };
        let simulation = simulation.in_wind(course).on_battery(self.electric.clone());
        let off = self.off.variation();
        simulation.varied(off.factors(), off.latency_s).with_faults(&self.faults.list)
    }

    /// The simulation whose release comes without a command: at the end of the hang, or when its faults let
    /// it.
    pub fn released_simulation(&self) -> DropSimulation {
        let mut simulation = self.simulation();
        let asked_s = self.release.hang_s;
        let release_s = simulation.faults().map_or(Some(asked_s), |faults| faults.lets_go_at(asked_s));
        simulation.schedule_release(release_s.unwrap_or(f64::INFINITY));
        simulation
    }

    /// The state that a plan starts from, [`PlanInitial`]; adrift with the wind.
    pub fn plan_initial_state(&self) -> PlanState {
        let (environment, release) = (&self.site.environment, &self.release);
        match self.plan.initial {
            PlanInitial::Paper => {
                let drift = environment.drift_ned_m_s();
                let v0 = release.parachute.v0_m_s(environment.gravity_m_s2);
                [1.0, 0.0, 0.0, 0.0, drift.x, drift.y, v0, 0.0, 0.0, 0.0]
            }
            PlanInitial::Release => {
                let body = nominal_state_at_t0(
                    self.vehicle.clone(),
                    environment.clone(),
                    release.parachute,
                    release.start,
                );
                let (q, v, w) = (body.q_ned_from_body, body.v_ned, body.omega_body);
                [q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z]
            }
        }
    }

    /// The planner's problem: from the nominal state at t = 0, rotors at rest, to the target.
    pub fn plan_problem(&self) -> PlanProblem<'_> {
        self.problem_from(self.plan_initial_state())
    }

    /// Whether the mission's plan can be renewed during a drop at this cadence.
    ///
    /// # Errors
    /// [`UnfitReplan`] says why it cannot.
    pub fn check_replan(&self, cadence: Cadence) -> Result<(), UnfitReplan> {
        if self.release.standing {
            return Err(UnfitReplan::Standing);
        }
        self.replan.check(cadence, &self.plan.demands)
    }

    /// Plans the mission, from a straight line as the first guess. `observer` is called after each iteration,
    /// and may stop the solve.
    ///
    /// # Errors
    /// [`UnplannedError`] for a problem that cannot be posed; a solve that does not converge is a [`Plan`].
    pub fn solve(
        &self,
        options: &SolverOptions,
        observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
    ) -> Result<Plan, UnplannedError> {
        plan(&self.plan_problem(), &Guess::StraightLine, options, observer)
            .map_err(|source| self.unplanned(source))
    }

    /// A plan as the mission's vehicle flies it from node to node at the mission's site.
    pub fn integrated(&self, plan: &Trajectory) -> IntegratedPlan {
        IntegratedPlan::new(plan, &self.vehicle, &self.site.environment, &self.limits.safety)
    }

    /// Whether a plan's nodes tell what the mission's vehicle flies along it: J_TPF, and the velocity by what
    /// the mission takes for steady.
    pub fn is_told_by_nodes(&self, plan: &IntegratedPlan) -> bool {
        plan.is_told_by_nodes(self.limits.steady_within_m_s)
    }

    /// A number of nodes, more than the mission's, whose plan [is told by its
    /// nodes](Self::is_told_by_nodes), found by solving with more and more of them; `None` where none was
    /// found or `observer` stopped the solves.
    ///
    /// # Errors
    /// [`UnplannedError`] for a problem that cannot be posed.
    pub fn nodes_enough(
        &self,
        options: &SolverOptions,
        observer: &mut dyn FnMut(&SolveProgress) -> ControlFlow<()>,
    ) -> Result<Option<usize>, UnplannedError> {
        let judge = (&self.limits.safety, self.limits.steady_within_m_s);
        nodes_enough(&self.plan_problem(), judge, options, observer).map_err(|source| self.unplanned(source))
    }

    /// Why a plan of the mission cannot be attempted, with vehicle and target.
    pub fn unplanned(&self, source: PlanError) -> UnplannedError {
        let (vehicle_file, target_v_ned) = (self.vehicle_file.clone(), self.target_v_ned);
        UnplannedError { vehicle_file, target_v_ned, source }
    }

    /// The random releases, (40)-(44).
    pub fn releases(&self) -> ReleaseDistribution {
        let releases = self.study.monte_carlo.releases(self.release.parachute, &self.site.environment);
        releases.with_uncertain(self.uncertain.clone())
    }

    /// How long the mission goes on after the end of a plan [s].
    pub fn settle_s(&self, plan: &Trajectory) -> f64 {
        let plan_begins_s = self.release.hang_s + self.release.parachute.delay_s;
        (self.duration_s - plan_begins_s - plan.end_s()).max(0.0)
    }

    /// Vehicle, site, air, target and limits.
    pub fn scenario(&self) -> Scenario {
        Scenario {
            vehicle: self.vehicle.clone(),
            environment: self.site.environment.clone(),
            wind: self.site.wind.clone(),
            battery: self.electric.clone(),
            target_v_ned: self.target_v_ned,
            limits: self.limits,
        }
    }

    /// The study of controllers along a plan: flights from t = 0 to the mission's end.
    pub fn safety_study(&self, plan: &Trajectory) -> SafetyStudy {
        SafetyStudy {
            scenario: self.scenario(),
            plan: plan.clone(),
            feed_forward: self.control.feed_forward,
            settle_s: self.settle_s(plan),
            delay_s: self.release.parachute.delay_s,
            faults: self.faults.list.clone(),
        }
    }

    /// The drop of a trial of a campaign.
    pub fn draw_drop(&self, trial: u64) -> RandomDrop {
        self.releases().draw_drop(self.seed, trial, self.study.monte_carlo.wind_sigma_m_s)
    }

    /// The mission with what was drawn for a drop: swing, wind, noise, and how far off what is flown is. Name
    /// and hash of the inputs stay; plan and controller know nothing of what was drawn.
    pub fn with_drop(&self, drop: &RandomDrop) -> Self {
        let mut mission = self.clone();
        mission.release.parachute.pendulum =
            self.study.monte_carlo.pendulum(drop.amplitude_rad, drop.phase_rad);
        let tip_off = &mut mission.release.parachute.tip_off;
        *tip_off = tip_off.with(&drop.tip_off);
        let parachute = &mut mission.release.parachute;
        parachute.delay_s = (parachute.delay_s + drop.off.release_delay_s()).max(0.0);
        mission.site.environment.wind_ned_m_s += drop.wind_ned_m_s;
        mission.site.environment = drop.off.variation().blown(&mission.site.environment);
        mission.off = drop.off;
        mission.site.wind_number = drop.trial + 1;
        mission.seed = drop.seed;
        mission
    }

    /// The parachutes whose swings come to t = 0 with the pitch and pitch rate of a release case, where there
    /// is such a swing; in the order of the cases.
    pub fn case_parachutes(&self) -> Vec<Parachute> {
        let cases = self.study.cases.iter();
        cases
            .filter_map(|case| self.release.swinging_to(case, &self.vehicle, &self.site.environment))
            .collect()
    }

    /// Vehicle, site, gains and limits that a parameter file of this mission is about.
    pub fn parameter_subject(&self) -> Subject<'_> {
        Subject {
            vehicle: &self.vehicle,
            environment: &self.site.environment,
            gains: &self.control.gains,
            limits: &self.control.limits,
            speed_m_s: self.limits.safety.speed_m_s,
            tilt_from: self.control.says_tilt_from.then_some(self.control.limits.tilt_from),
            pack: self.electric.as_ref().map(ElectricBattery::pack),
        }
    }

    /// The purpose that a parameter file must have for a PX4 to fly this mission with it.
    pub fn px4_purpose(&self) -> Purpose {
        match self.px4.clock {
            Px4Clock::Real => Purpose::Px4,
            Px4Clock::Froude => Purpose::Px4Froude,
        }
    }

    /// Notes what was chosen beside the files and decides what results hold (an option of the command line,
    /// the hash of a trajectory). The input hash follows.
    pub fn note_choice(&mut self, name: &str, value: &str) {
        self.inputs.note(name, value);
    }

    /// The origin that the mission's result files name.
    pub fn stamp(&self) -> Stamp {
        Stamp { seed: self.seed, input_hash: self.inputs.hash.clone() }
    }
}
