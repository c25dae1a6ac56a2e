//! Whether a mission can be flown, as PX4 v1.14 checks it (FeasibilityChecker.cpp,
//! mission_feasibility_checker.cpp): when it comes, and in PX4's words. Missions that go through gates, turn
//! to a region of interest or are for a winged vehicle are refused here too.

use nalgebra::Vector3;

use super::super::fence::Fence;
use super::super::settings::{Action, Requirement, Settings};
use super::task::{Step, Task};

/// What a check looks at.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// Position of home, NED [m].
    pub home_ned: Vector3<f64>,
    /// Position of the vehicle, NED [m].
    pub p_ned: Vector3<f64>,
    /// Whether it stands on something.
    pub landed: bool,
    /// The areas to stay in and to keep out of.
    pub fence: &'a Fence,
    /// What else there is to go by.
    pub settings: &'a Settings,
}

/// Why a mission is not flown. Items are counted from 1, as PX4 does.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Infeasible {
    /// A command that is not flown.
    #[error("Mission rejected: item {item}: unsupported cmd: {command}")]
    Unsupported {
        /// The item, from 1.
        item: usize,
        /// `MAV_CMD`.
        command: u16,
    },
    /// A place without a height.
    #[error("Mission rejected: item {0}: no altitude")]
    NoHeight(usize),
    /// A landing of what stands.
    #[error("Mission rejected: starts with landing")]
    StartsWithLanding,
    /// A takeoff that goes down.
    #[error("Mission rejected: Takeoff altitude below home altitude!")]
    LowTakeoff,
    /// A takeoff behind another place.
    #[error("Mission rejected: takeoff not first waypoint item")]
    LateTakeoff,
    /// The first place is farther than MIS_DIST_1WP.
    #[error("First waypoint too far away: {}m, {} max", *.distance_m as i64, *.most_m as i64)]
    FarAway {
        /// Horizontal distance from the vehicle [m].
        distance_m: f64,
        /// MIS_DIST_1WP [m].
        most_m: f64,
    },
    /// MIS_TKO_LAND_REQ wants a takeoff.
    #[error("Mission rejected: Takeoff waypoint required.")]
    NoTakeoff,
    /// MIS_TKO_LAND_REQ wants a landing.
    #[error("Mission rejected: Landing waypoint/pattern required.")]
    NoLanding,
    /// MIS_TKO_LAND_REQ wants both.
    #[error("Mission rejected: Takeoff or Landing item missing.")]
    NotBoth,
    /// MIS_TKO_LAND_REQ wants both or none.
    #[error("Mission rejected: Add Landing item or remove Takeoff.")]
    TakeoffOnly,
    /// MIS_TKO_LAND_REQ wants both or none.
    #[error("Mission rejected: Add Takeoff item or remove Landing.")]
    LandingOnly,
    /// A place outside the fence.
    #[error("Geofence violation for waypoint {0}")]
    OutsideFence(usize),
}

/// Checks a mission; the numbers, from 1, of the items that lie below home, about which there is a warning.
///
/// # Errors
/// [`Infeasible`]: the first reason why it is not flown.
pub fn check(steps: &[Step], around: &Surroundings<'_>) -> Result<Vec<usize>, Infeasible> {
    let numbered = || (1..).zip(steps);
    for (number, step) in numbered() {
        if step.task == Task::Unsupported {
            return Err(Infeasible::Unsupported { item: number, command: step.item.command });
        }
        if step.task.place().is_some() && !step.item.z.is_finite() {
            return Err(Infeasible::NoHeight(number));
        }
    }
    if around.landed && matches!(steps.first(), Some(Step { task: Task::Land { .. }, .. })) {
        return Err(Infeasible::StartsWithLanding);
    }
    check_takeoff(steps, around)?;
    check_distance(steps, around)?;
    check_required(steps, around.settings.mission.requirement)?;
    for (number, step) in numbered() {
        if is_outside(step, around) {
            return Err(Infeasible::OutsideFence(number));
        }
    }
    let home_down_m = around.home_ned.z;
    let is_below = |step: &Step| step.task.place().is_some_and(|at| at.down_m(home_down_m) > home_down_m);
    Ok(numbered().filter(|(_, step)| is_below(step)).map(|(number, _)| number).collect())
}

fn check_takeoff(steps: &[Step], around: &Surroundings<'_>) -> Result<(), Infeasible> {
    let mut placed = false;
    for step in steps {
        if let Task::TakeOff { to } = step.task {
            let height_m = around.home_ned.z - to.down_m(around.home_ned.z);
            if height_m < f64::from(f32::EPSILON) {
                return Err(Infeasible::LowTakeoff);
            }
            if placed {
                return Err(Infeasible::LateTakeoff);
            }
        }
        placed |= step.task.ne().is_some();
    }
    Ok(())
}

fn check_distance(steps: &[Step], around: &Surroundings<'_>) -> Result<(), Infeasible> {
    let most_m = around.settings.mission.first_place_within_m;
    let first = steps.iter().find_map(|step| step.task.ne());
    match first.map(|ne| (ne - around.p_ned.xy()).norm()) {
        Some(distance_m) if most_m > 0.0 && distance_m >= most_m => {
            Err(Infeasible::FarAway { distance_m, most_m })
        }
        _ => Ok(()),
    }
}

fn check_required(steps: &[Step], requirement: Requirement) -> Result<(), Infeasible> {
    let takeoff = steps.iter().any(|step| matches!(step.task, Task::TakeOff { .. }));
    let landing = steps.iter().any(|step| matches!(step.task, Task::Land { .. }));
    match requirement {
        Requirement::Takeoff if !takeoff => Err(Infeasible::NoTakeoff),
        Requirement::Landing if !landing => Err(Infeasible::NoLanding),
        Requirement::Both if !(takeoff && landing) => Err(Infeasible::NotBoth),
        Requirement::BothOrNeither if takeoff && !landing => Err(Infeasible::TakeoffOnly),
        Requirement::BothOrNeither if landing && !takeoff => Err(Infeasible::LandingOnly),
        _ => Ok(()),
    }
}

fn is_outside(step: &Step, around: &Surroundings<'_>) -> bool {
    let Surroundings { home_ned, fence, settings, .. } = around;
    let Some(ne) = step.task.ne().filter(|_| settings.fence != Action::Nothing) else { return false };
    let beyond = |distance_m: f64, most_m: f64| most_m > 0.0 && distance_m > most_m;
    let height_m = step.task.place().map_or(0.0, |at| home_ned.z - at.down_m(home_ned.z));
    fence.is_left_at(ne)
        || fence.is_entered_at(ne)
        || beyond((ne - home_ned.xy()).norm(), settings.fence_radius_m)
        || beyond(height_m, settings.fence_height_m)
}
