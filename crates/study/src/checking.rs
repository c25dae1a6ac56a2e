//! What a mission amounts to: its derived numbers, and what its plan and its loops say of it. Nothing is
//! flown.

use std::ops::ControlFlow;

use samara_core::design::{LeastMargins, WorstLoop};
use samara_core::model::RotorLimits;
use samara_core::plan::{Plan, SolverOptions, Status};
use samara_core::trajectory::Trajectory;
use samara_mission::{Derived, Mission, UnplannedError, derived};

use super::designing::own_loops;
use super::tuning::{BesideTheRule, beside_the_rule};

/// A mission as it is checked.
#[derive(Debug)]
pub struct Checked {
    /// Derived numbers, and what they contradict.
    pub derived: Derived,
    /// The mission's plan.
    pub plan: CheckedPlan,
    /// The loops of the mission's gains, each where it keeps least to instability.
    pub loops: Vec<WorstLoop>,
    /// What each loop must keep.
    pub least: LeastMargins,
    /// Velocity loops that are too slow for the mission.
    pub slow: Vec<SlowLoop>,
    /// The gains beside the rule for the vehicle.
    pub gains: BesideTheRule,
    /// Room above the ground, where there is one below the release.
    pub room: Option<Room>,
}

/// The plan of a mission that is checked.
#[derive(Debug)]
pub enum CheckedPlan {
    /// The mission has none: it begins on the ground.
    None,
    /// It has more than [`NODES_MOST`] nodes, and was not solved.
    Long,
    /// It cannot be posed.
    Unposed(UnplannedError),
    /// It was solved, or the solve did not converge.
    Solved(Box<Plan>),
}

impl CheckedPlan {
    /// The plan, where it was found.
    pub fn trajectory(&self) -> Option<&Trajectory> {
        match self {
            Self::Solved(plan) if plan.status == Status::Converged => Some(&plan.trajectory),
            _ => None,
        }
    }
}

/// A loop whose velocity is not reached within the mission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlowLoop {
    /// Place of the loop in [`LOOPS`](samara_core::design::LOOPS).
    pub index: usize,
    /// Greatest frequency at which the loop's gain is 1 [rad/s].
    pub crossover_rad_s: f64,
    /// Time in which a difference falls to a twentieth [s].
    pub settles_s: f64,
    /// Time from t = 0 to the mission's end [s].
    pub left_s: f64,
}

/// Room above the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Room {
    /// Height of the release above the ground [m].
    pub height_m: f64,
    /// Height that fall and plan lose, or without a plan the fall and what the greatest lift takes to end it
    /// [m]; `None` where the rotors do not lift the vehicle.
    pub needed_m: Option<f64>,
}

impl Room {
    /// Whether the room is enough, with a tenth to spare.
    pub fn is_enough(&self) -> bool {
        self.needed_m.is_some_and(|needed_m| self.height_m >= TO_SPARE * needed_m)
    }
}

/// Most nodes of a plan that is solved: it takes a second or so.
pub const NODES_MOST: usize = 500;
/// Height that there must be, as a multiple of what is needed.
const TO_SPARE: f64 = 1.1;
/// Time constants in which a difference falls to a twentieth.
const SETTLED: f64 = 3.0;
/// Places of the velocity loops north and down.
const VELOCITIES: [usize; 2] = [2, 3];

/// What a mission amounts to.
pub fn checked(mission: &Mission) -> Checked {
    let plan = solved(mission);
    let (loops, least) = own_loops(mission, plan.trajectory());
    Checked {
        derived: derived(mission),
        slow: slow(mission, &loops),
        loops,
        least,
        gains: beside_the_rule(mission),
        room: room(mission, plan.trajectory()),
        plan,
    }
}

fn solved(mission: &Mission) -> CheckedPlan {
    if mission.release.standing {
        return CheckedPlan::None;
    }
    if mission.plan.nodes > NODES_MOST {
        return CheckedPlan::Long;
    }
    match mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())) {
        Ok(plan) => CheckedPlan::Solved(Box::new(plan)),
        Err(unposed) => CheckedPlan::Unposed(unposed),
    }
}

/// Time from t = 0, when the rotors are freed, to the mission's end [s].
fn left_s(mission: &Mission) -> f64 {
    mission.duration_s - mission.release.hang_s - mission.release.parachute.delay_s
}

/// A loop that crosses 1 at a frequency has about its inverse for a time constant.
fn slow(mission: &Mission, loops: &[WorstLoop]) -> Vec<SlowLoop> {
    let left_s = if mission.release.standing { mission.duration_s } else { left_s(mission) };
    let slow = |index: usize| {
        let crossover_rad_s = loops.get(index)?.crossover_rad_s?;
        let settles_s = SETTLED / crossover_rad_s;
        (settles_s > left_s).then_some(SlowLoop { index, crossover_rad_s, settles_s, left_s })
    };
    VELOCITIES.into_iter().filter_map(slow).collect()
}

fn room(mission: &Mission, plan: Option<&Trajectory>) -> Option<Room> {
    let ground = mission.site.ground.filter(|_| !mission.release.standing)?;
    let parachute = &mission.release.parachute;
    let start_m_s = mission.plan_initial_state()[6];
    let fall_m = 0.5 * (parachute.descent_m_s + start_m_s) * parachute.delay_s;
    let needed_m = plan.map_or_else(|| braking_m(mission, start_m_s), |plan| Some(depth_m(plan)));
    Some(Room { height_m: ground.down_m, needed_m: needed_m.map(|needed_m| fall_m + needed_m) })
}

/// How far a plan goes below its start [m].
fn depth_m(plan: &Trajectory) -> f64 {
    let mut down_m = 0.0f64;
    let below = plan.nodes().windows(2).map(|pair| {
        down_m += 0.5 * (pair[0].v_ned.z + pair[1].v_ned.z) * (pair[1].t_s - pair[0].t_s);
        down_m
    });
    below.fold(0.0, f64::max)
}

/// Height in which the greatest lift takes a fall to the target's rate of descent, once the thrust is there
/// [m].
fn braking_m(mission: &Mission, start_m_s: f64) -> Option<f64> {
    let (vehicle, site) = (&mission.vehicle, &mission.site.environment);
    let rotors = RotorLimits::of(vehicle, site.density_kg_m3);
    let lift_n = RotorLimits::lift_n(vehicle, site.density_kg_m3);
    let up_m_s2 = lift_n / vehicle.mass.mass_kg - site.gravity_m_s2;
    let thrust_s = rotors.thrust_n / rotors.thrust_slew_n_s;
    let end_m_s = mission.target_v_ned.z.max(0.0).min(start_m_s);
    let braking_m = (start_m_s * start_m_s - end_m_s * end_m_s) / (2.0 * up_m_s2);
    (up_m_s2 > 0.0).then_some(start_m_s * thrust_s + braking_m)
}
