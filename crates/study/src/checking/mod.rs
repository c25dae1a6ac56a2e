//! What a mission amounts to: its derived numbers, and what its plan and its loops say of it. Nothing is
//! flown.

mod odd;
mod words;

pub use odd::odd;
pub use words::{checked_json, checked_text};

use std::ops::ControlFlow;

use samara_core::design::{LeastMargins, WorstLoop};
use samara_core::model::RotorLimits;
use samara_core::plan::{Plan, SolverOptions, Status};
use samara_core::trajectory::Trajectory;
use samara_mission::{Derived, Mission, UnplannedError, derived};

use crate::designing::own_loops;
use crate::tuning::{BesideTheRule, beside_the_rule};

/// A mission as it is checked.
#[derive(Debug)]
pub struct Checked {
    /// Derived numbers, and what they contradict.
    pub derived: Derived,
    /// The mission's plan.
    pub plan: CheckedPlan,
    /// The loops of the mission's gains, each where it keeps least to instability; none of commands that come
    /// later than [`LATENCY_MOST_S`].
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
    /// Greatest frequency at which the loop's gain is 1 [rad/s]; 0 where it is so nowhere.
    pub crossover_rad_s: f64,
    /// Time in which a difference falls to a twentieth [s]; infinite where it does not.
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
/// Most latency [s] of loops that are looked at: each period of it is two states more, and their margins take
/// a second or so.
pub const LATENCY_MOST_S: f64 = 0.1;
/// Height that there must be, as a multiple of what is needed.
const TO_SPARE: f64 = 1.1;
/// Time constants in which a difference falls to a twentieth.
const SETTLED: f64 = 3.0;
/// Places of the velocity loops north and down.
const VELOCITIES: [usize; 2] = [2, 3];

/// What a mission amounts to.
pub fn checked(mission: &Mission) -> Checked {
    let plan = solved(mission);
    let (loops, least) = if mission.vehicle.latency_s > LATENCY_MOST_S {
        Default::default()
    } else {
        own_loops(mission, plan.trajectory())
    };
    checked_by(mission, plan, loops, least)
}

/// What a mission amounts to, by its plan, its loops and what they must keep.
pub fn checked_by(
    mission: &Mission,
    plan: CheckedPlan,
    loops: Vec<WorstLoop>,
    least: LeastMargins,
) -> Checked {
    Checked {
        derived: derived(mission),
        slow: slow(mission, &loops),
        loops,
        least,
        gains: beside_the_rule(mission, &mission.control.gains),
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
        let crossover_rad_s = loops.get(index)?.crossover_rad_s.unwrap_or(0.0);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::designing::{first_judge, own_design};
    use samara_core::control::Gains;
    use samara_mission::Effect;
    use samara_mission::shipped::{MISSIONS, names_in};

    fn shipped(name: &str, change: impl FnOnce(&mut Mission)) -> Checked {
        let mut mission = Mission::shipped(name).unwrap();
        change(&mut mission);
        checked(&mission)
    }

    fn scaled(gains: &Gains, factors: [f64; 7]) -> Gains {
        let k = gains.as_longitudinal();
        let Gains { k_ppsi, k_pr, .. } = *gains;
        Gains { k_ppsi, k_pr, ..Gains::longitudinal(std::array::from_fn(|i| factors[i] * k[i])) }
    }

    /// Of every shipped mission the worst of its loops are what `design` judges it by.
    #[test]
    fn reference_the_worst_loops_are_the_designs_margins() {
        for name in names_in(MISSIONS) {
            let mission = Mission::shipped(name).unwrap();
            let found = checked(&mission);
            let Some(plan) = found.plan.trajectory() else {
                assert_eq!(name, "x500_ground");
                assert!(found.loops.iter().all(|of| of.modulus.1.state == "target"));
                continue;
            };
            let (modulus, delay_s) = first_judge(&mission, 0).least_margins(plan, &own_design(&mission));
            let stable = found.loops.iter().all(|of| of.unstable.is_none());
            let least = found.loops.iter().map(|of| of.modulus.0).fold(1.0, f64::min);
            assert_eq!(if stable { least } else { -least }, modulus, "{name}");
            let least_s = found.loops.iter().filter_map(|of| of.delay_s).map(|of| of.0).fold(10.0, f64::min);
            assert_eq!(if stable { least_s } else { 0.0 }, delay_s, "{name}");
            assert_eq!(found.loops.iter().map(|of| of.index).collect::<Vec<_>>(), {
                (0..found.loops.len()).collect::<Vec<_>>()
            });
        }
    }

    /// By hand: a rate loop whose command is late by theta bears `K_pq theta` of pi/2 where all of it is
    /// delay and more where it is lag. The x500's rule has 0.5 at 26.8 1/s, so that theta is 19 ms; twenty
    /// times 4.81 1/s are 1.8, and with the attitude's gain twenty times as great too nothing is left.
    #[test]
    fn closed_form_gains_times_twenty_are_unstable() {
        let own = shipped("x500_drop", |_| {});
        assert!(own.loops.len() == 9 && own.loops.iter().all(|of| of.unstable.is_none()));
        let found = shipped("x500_drop", |m| m.control.gains = scaled(&m.control.gains, [20.0; 7]));
        let unstable = found.loops.iter().filter(|of| of.unstable.is_some());
        assert!(unstable.clone().any(|of| of.index == 0) && unstable.clone().any(|of| of.index == 4));
        assert!(unstable.filter_map(|of| of.unstable).all(|at| at.off.factors().is_none()), "the known one");
        assert!(found.gains.outside.iter().any(|n| n.name == "k_pq_per_s" && n.value > n.most));
    }

    /// `L = (K s + K_i)/s^2` crosses 1 at `w^2 = (K^2 + sqrt(K^4 + 4 K_i^2))/2`, and drag only takes away of
    /// it: with a twentieth of 1.313 1/s and a four-hundredth of 0.295 1/s^2 at 0.0665 rad/s, so that a
    /// difference takes 45 s to fall to a twentieth; from t = 0 on the x500 has 14.5 s. With its own gains it
    /// takes 3 s. Without any gain it does not fall.
    #[test]
    fn closed_form_a_slow_loop_does_not_settle() {
        let slow = |factor: f64| {
            let factors = [1.0, 1.0, 1.0, 1.0, 1.0, factor, factor * factor];
            shipped("x500_drop", |m| m.control.gains = scaled(&m.control.gains, factors)).slow
        };
        assert_eq!(slow(1.0), []);
        let found = slow(0.05);
        assert!(found.len() == 1 && found[0].index == 2, "{found:?}");
        assert!(found[0].settles_s > 45.0 && (found[0].left_s - 14.5).abs() < 1e-9, "{found:?}");
        assert_eq!(slow(0.0)[0].settles_s, f64::INFINITY);
    }

    /// The x500 loses 14.2 m in its drop, of which 3.5 before t = 0; without a plan it takes
    /// `v^2/2/(T/W - 1)/g` with 8.93 m/s, a target of 1 m/s down and a thrust to weight of 1.689, and the
    /// thrust 41 ms to come.
    #[test]
    fn closed_form_room_above_the_ground() {
        let room = |down_m: f64, nodes: usize| {
            let found = shipped("x500_drop", |m| {
                *m = m.with_effects(&[Effect::RotorInflow]);
                m.site.ground = Some(samara_core::sim::Ground { down_m });
                m.plan.nodes = nodes;
            });
            found.room.unwrap()
        };
        let [low, high] = [10.0, 16.0].map(|down_m| room(down_m, 38));
        assert!((low.needed_m.unwrap() - 14.2).abs() < 0.1, "{low:?}");
        assert!(!low.is_enough() && high.is_enough() && high.needed_m == low.needed_m);
        let braking = (8.933f64.powi(2) - 1.0) / (2.0 * 0.689 * 9.80665);
        let by_hand = 0.25 * (5.0 + 8.933) + 8.933 * 0.0412 + braking;
        let long = room(10.0, NODES_MOST + 1);
        assert!((long.needed_m.unwrap() / by_hand - 1.0).abs() < 0.01, "{long:?}, by hand {by_hand}");
        assert_eq!(shipped("titan_paper", |_| {}).room, None);
    }

    /// Gains that were found in the paper's range and lean on its end, an x500's of version 0.1; a mission
    /// that names the range has it for its own.
    #[test]
    fn gains_that_lean_on_the_papers_range_are_named() {
        let names = |found: &Checked| {
            found.gains.at_papers_end.iter().map(|n| n.name.clone().into_owned()).collect::<Vec<_>>()
        };
        let lean = Gains::longitudinal([4.81, 1.8, 4.73, 4.97, 3.07, 1.31, 0.29]);
        let x500 = shipped("x500_drop", |m| m.control.gains = lean);
        assert_eq!(names(&x500), ["k_pq_per_s", "k_pvz_per_s"]);
        let own = shipped("x500_drop", |m| {
            (m.control.gains, m.study.gain_range) = (lean, Some((1e-4, 5.0)));
        });
        assert_eq!(own.gains, BesideTheRule::default());
        assert_eq!(shipped("octo_drop", |_| {}).gains, BesideTheRule::default());
    }
}
