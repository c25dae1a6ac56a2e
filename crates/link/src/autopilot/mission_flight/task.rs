//! What the items of a mission ask for, read as PX4 v1.14 reads them (mavlink_mission.cpp,
//! `parse_mavlink_mission_item`): places in the local frame, angles in radians.

use nalgebra::{Vector2, Vector3};

use super::super::missions::{Item, REGIONS_OF_INTEREST};
use crate::frames::wrap_pi;
use crate::model::Environment;
use crate::model::environment::GeoPoint;
use crate::units::RAD_PER_DEG;

/// `MAV_FRAME`s whose altitudes count from home (GLOBAL_RELATIVE_ALT and its old twin `_INT`).
const RELATIVE_FRAMES: [u8; 2] = [3, 6];

/// Commands for actuators, cameras and gimbals, the mark of a landing, and the end of a region of interest.
const PASSED_OVER: [u16; 20] = [
    187, 189, 197, 200, 203, 204, 205, 206, 214, 260, 530, 531, 532, 1000, 1001, 2000, 2001, 2003, 2500, 2501,
];

/// How high a place is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Height {
    /// Height above home [m].
    AboveHome(f64),
    /// Position down from the local origin [m].
    Down(f64),
}

/// A place of an item.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// North and east of the local origin [m].
    pub ne: Vector2<f64>,
    /// How high it is.
    pub height: Height,
}

impl Place {
    /// Position down [m] of the place, with home at a position down [m].
    pub fn down_m(&self, home_down_m: f64) -> f64 {
        match self.height {
            Height::AboveHome(height_m) => home_down_m - height_m,
            Height::Down(down_m) => down_m,
        }
    }

    /// Position of the place, NED [m], with home at a position down [m].
    pub fn ned(&self, home_down_m: f64) -> Vector3<f64> {
        Vector3::new(self.ne.x, self.ne.y, self.down_m(home_down_m))
    }

    fn of(item: &Item, environment: &Environment) -> Self {
        let (latitude_deg, longitude_deg) = (item.x / 1e7, item.y / 1e7);
        let local = environment.local_ned(&GeoPoint { latitude_deg, longitude_deg, altitude_m: 0.0 });
        let altitude_m = f64::from(item.z);
        let height = if RELATIVE_FRAMES.contains(&item.frame.0) {
            Height::AboveHome(altitude_m)
        } else {
            Height::Down(environment.anchor.altitude_m - altitude_m)
        };
        Self { ne: local.xy(), height }
    }
}

/// What an item asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Task {
    /// NAV_TAKEOFF: straight up, then to the place.
    TakeOff {
        /// Where to.
        to: Place,
    },
    /// NAV_WAYPOINT.
    Waypoint {
        /// Where.
        at: Place,
        /// Time to stay [s].
        hold_s: f64,
        /// The place is reached within this [m]; `None` within NAV_ACC_RAD.
        radius_m: Option<f64>,
        /// Heading to turn to [rad].
        yaw_rad: Option<f64>,
    },
    /// NAV_LOITER_UNLIM and NAV_LOITER_TIME: a multirotor stays at the place.
    Loiter {
        /// Where.
        at: Place,
        /// Time to stay [s]; `None` for ever.
        hold_s: Option<f64>,
        /// Heading to turn to [rad].
        yaw_rad: Option<f64>,
    },
    /// NAV_LOITER_TO_ALT: over the place first, then to its height.
    LoiterToHeight {
        /// Where.
        at: Place,
        /// Over the place means within this beyond NAV_ACC_RAD [m]; `None` is NAV_LOITER_RAD.
        radius_m: Option<f64>,
    },
    /// NAV_LAND: over the place, north and east of the local origin [m], and down.
    Land {
        /// Where.
        ne: Vector2<f64>,
    },
    /// NAV_RETURN_TO_LAUNCH.
    Return,
    /// NAV_DELAY.
    Delay {
        /// How long [s].
        hold_s: f64,
    },
    /// DO_JUMP.
    Jump {
        /// Number of the item to go on with.
        to: usize,
        /// How often, then it goes on behind the jump.
        times: u16,
    },
    /// DO_CHANGE_SPEED: horizontal speed [m/s], or MPC_XY_CRUISE again.
    Speed(Option<f64>),
    /// DO_GRIPPER: the parachute's to obey.
    Gripper,
    /// DO_SET_HOME.
    SetHome,
    /// A command for a payload that is not there, or a mark: passed over, as PX4 goes on at once without
    /// waiting for whoever should obey.
    Nothing,
    /// Not flown here.
    Unsupported,
}

impl Task {
    fn of(item: &Item, environment: &Environment) -> Self {
        // Parameter 3 is the radius of a circle, which a multirotor does not fly.
        let [first, second, _, fourth] = item.params.map(f64::from);
        let place = || Place::of(item, environment);
        let positive = |x: f64| (x > f64::from(f32::EPSILON) && x.is_finite()).then_some(x);
        // No time is negative; no number is no time.
        let time_s = |x: f64| x.max(0.0);
        let yaw_rad = fourth.is_finite().then(|| wrap_pi(fourth * RAD_PER_DEG));
        match item.command {
            16 => {
                let radius_m = positive(second);
                Self::Waypoint { at: place(), hold_s: time_s(first), radius_m, yaw_rad }
            }
            17 => Self::Loiter { at: place(), hold_s: None, yaw_rad },
            19 => Self::Loiter { at: place(), hold_s: Some(time_s(first)), yaw_rad },
            20 => Self::Return,
            21 => Self::Land { ne: place().ne },
            22 => Self::TakeOff { to: place() },
            31 => Self::LoiterToHeight { at: place(), radius_m: positive(second.abs()) },
            93 => Self::Delay { hold_s: time_s(first) },
            // A number that is too large ends the mission when it is come to.
            177 => Self::Jump { to: first.max(0.0) as usize, times: second as u16 },
            178 => Self::Speed(positive(second)),
            179 => Self::SetHome,
            211 => Self::Gripper,
            command if PASSED_OVER.contains(&command) || REGIONS_OF_INTEREST.contains(&command) => {
                Self::Nothing
            }
            _ => Self::Unsupported,
        }
    }

    /// Where it goes, north and east of the local origin [m], if it goes to a place.
    pub fn ne(&self) -> Option<Vector2<f64>> {
        match self {
            Self::Land { ne } => Some(*ne),
            _ => self.place().map(|place| place.ne),
        }
    }

    /// The place that it goes to in the air, if it goes to one.
    pub fn place(&self) -> Option<Place> {
        match self {
            Self::TakeOff { to: at }
            | Self::Waypoint { at, .. }
            | Self::Loiter { at, .. }
            | Self::LoiterToHeight { at, .. } => Some(*at),
            _ => None,
        }
    }
}

/// An item and what it asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The item as it came.
    pub item: Item,
    /// The task that it sets.
    pub task: Task,
}

/// The items of a mission as what they ask for, with places on the local frame of a site.
pub fn steps(items: &[Item], environment: &Environment) -> Vec<Step> {
    items.iter().map(|item| Step { item: *item, task: Task::of(item, environment) }).collect()
}
