//! Where the automatic modes go: HOLD, TAKEOFF, LAND and RETURN as position and velocity setpoints, from
//! where the vehicle is. Missions are [`super::mission_flight`]'s.
//!
//! | mode | what it does |
//! |---|---|
//! | HOLD | brakes to a stop, then keeps the place where it stopped; or goes to DO_REPOSITION's place |
//! | TAKEOFF | straight up to a height above home at MPC_TKO_SPEED; then HOLD there |
//! | DESCEND | LAND without a position: sinks level at MPC_LAND_SPEED, and drifts with the wind |
//! | LAND | brakes and keeps its place over the ground, sinks at MPC_LAND_SPEED until something stops it |
//! | RETURN | up to RTL_RETURN_ALT, over to home, down to RTL_DESCEND_ALT, waits RTL_LAND_DELAY, lands |
//!
//! A stop is a speed below 0.3 m/s, or 10 s of braking: in wind the vehicle may need longer for the last of
//! it than that. Places are flown to in a straight line at the speed that the position loop asks for, within
//! MPC_XY_CRUISE, MPC_Z_V_AUTO_UP and MPC_Z_V_AUTO_DN; the heading stays. (PX4 also limits acceleration and
//! jerk on the way, lets RETURN climb less the closer home is (RTL_CONE_ANG), turns the nose to where it
//! flies, and slows LAND down in two steps.)

use nalgebra::{Vector2, Vector3};

use super::settings::Settings;
use super::{FlightMode, YawSetpoint};
use crate::control::VelocityLimits;
use crate::units::US_PER_S;

/// Slower than this it has stopped [m/s].
const STOPPED_M_S: f64 = 0.3;
/// Longest braking [us].
const BRAKING_US: u64 = 10_000_000;
/// A height is reached within this [m]; PX4's NAV_MC_ALT_RAD.
pub(super) const HEIGHT_REACHED_M: f64 = 0.8;
/// Home is reached within this [m].
const HOME_REACHED_M: f64 = 1.0;
/// RETURN from closer to home than this [m] does not climb to its height first; PX4's RTL_MIN_DIST.
const NEAR_HOME_M: f64 = 10.0;

/// What a step of the navigator knows.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// Simulated time [us].
    pub now_us: u64,
    /// Position, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Heading [rad].
    pub heading_rad: f64,
    /// Home, NED [m].
    pub home_ned: Vector3<f64>,
    /// Speeds and heights.
    pub settings: &'a Settings,
}

/// What to fly to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guidance {
    /// Position, NED [m]; `None` for an axis without one.
    pub p_ned: [Option<f64>; 3],
    /// Velocity fed forward, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// What the position loop may ask for.
    pub limits: VelocityLimits,
    /// Heading.
    pub yaw: YawSetpoint,
}

/// A place to stop at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stop {
    since_us: Option<u64>,
    at: Option<Vector3<f64>>,
}

impl Stop {
    /// Where the vehicle comes to a stop.
    pub const BRAKING: Self = Self { since_us: None, at: None };

    fn at(place: Vector3<f64>) -> Self {
        Self { since_us: None, at: Some(place) }
    }

    /// The place, once it has stopped; `level` looks at the horizontal speed only.
    pub fn place(&mut self, s: &Situation<'_>, level: bool) -> Option<Vector3<f64>> {
        let since = *self.since_us.get_or_insert(s.now_us);
        let speed = if level { s.v_ned.xy().norm() } else { s.v_ned.norm() };
        if self.at.is_none() && (speed < STOPPED_M_S || s.now_us.saturating_sub(since) >= BRAKING_US) {
            self.at = Some(s.p_ned);
        }
        self.at
    }
}

/// A stage of the way home.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Leg {
    Climb { stop: Stop },
    Cross,
    Descend,
    Wait { since_us: u64 },
    Land,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Task {
    Hold { stop: Stop, yaw: YawSetpoint },
    Takeoff { height: Option<f64>, from: Option<Vector3<f64>> },
    Land { stop: Stop },
    Descend,
    Return { down_m: Option<f64>, leg: Leg },
}

/// What the automatic mode is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Navigator {
    task: Task,
    /// DO_CHANGE_SPEED's [m/s], until the next mode.
    speed_m_s: Option<f64>,
}

impl Default for Navigator {
    fn default() -> Self {
        Self::begin(FlightMode::AutoLoiter)
    }
}

impl Navigator {
    /// Begins a mode; one that is not automatic counts as HOLD.
    pub fn begin(mode: FlightMode) -> Self {
        let task = match mode {
            FlightMode::AutoTakeoff => Task::Takeoff { height: None, from: None },
            FlightMode::AutoLand => Task::Land { stop: Stop::BRAKING },
            FlightMode::AutoRtl => Task::Return { down_m: None, leg: Leg::Climb { stop: Stop::BRAKING } },
            _ => Task::Hold { stop: Stop::BRAKING, yaw: YawSetpoint::Keep },
        };
        Self { task, speed_m_s: None }
    }

    /// Begins a HOLD at a place, NED [m].
    pub fn hold_at(place_ned: Vector3<f64>, yaw: YawSetpoint) -> Self {
        Self { task: Task::Hold { stop: Stop::at(place_ned), yaw }, speed_m_s: None }
    }

    /// Begins a descent without a position, as PX4's `FlightTaskDescend` (v1.14.3).
    pub fn descend() -> Self {
        Self { task: Task::Descend, speed_m_s: None }
    }

    /// Begins a TAKEOFF to a position down [m] instead of the settings' height.
    pub fn take_off_to(down_m: f64) -> Self {
        Self { task: Task::Takeoff { height: Some(down_m), from: None }, speed_m_s: None }
    }

    /// Changes the horizontal speed, until the next mode [m/s]; `None` is the settings'.
    pub fn set_speed(&mut self, speed_m_s: Option<f64>) {
        self.speed_m_s = speed_m_s;
    }

    /// Whether it is on its way to the ground.
    pub fn is_landing(&self) -> bool {
        matches!(self.task, Task::Land { .. } | Task::Descend | Task::Return { leg: Leg::Land, .. })
    }

    /// The next step; true when a takeoff has arrived.
    pub fn step(&mut self, s: &Situation<'_>) -> (Guidance, bool) {
        let mut limits = s.settings.automatic;
        limits.level_m_s = self.speed_m_s.unwrap_or(limits.level_m_s).min(s.settings.greatest.level_m_s);
        let still = Guidance { p_ned: [None; 3], v_ned: Vector3::zeros(), limits, yaw: YawSetpoint::Keep };
        match &mut self.task {
            Task::Hold { stop, yaw } => {
                let p_ned = stop.place(s, false).map_or([None; 3], |p| [Some(p.x), Some(p.y), Some(p.z)]);
                (Guidance { p_ned, yaw: *yaw, ..still }, false)
            }
            Task::Takeoff { height, from } => {
                let from = *from.get_or_insert(s.p_ned);
                let above_home = s.home_ned.z - s.settings.takeoff_height_m;
                // Whoever is higher already stays there.
                let down = height.unwrap_or(above_home).min(from.z);
                let p_ned = [Some(from.x), Some(from.y), Some(down)];
                let limits = VelocityLimits { up_m_s: s.settings.takeoff_speed_m_s, ..limits };
                let arrived = (down - s.p_ned.z).abs() < HEIGHT_REACHED_M && s.v_ned.z.abs() < STOPPED_M_S;
                if arrived {
                    self.task = Task::Hold {
                        stop: Stop::at(Vector3::new(from.x, from.y, down)),
                        yaw: YawSetpoint::Keep,
                    };
                }
                (Guidance { p_ned, limits, ..still }, arrived)
            }
            Task::Land { stop } => (descent(still, stop.place(s, true).map(|p| p.xy()), s), false),
            Task::Descend => (descending(still, s), false),
            Task::Return { down_m, leg } => {
                let down = *down_m.get_or_insert_with(|| return_down_m(s));
                (returning(leg, down, s, still), false)
            }
        }
    }
}

/// Sinks over a place, north and east [m]; without one it brakes.
pub(super) fn descent(still: Guidance, ne: Option<Vector2<f64>>, s: &Situation<'_>) -> Guidance {
    let speed = s.settings.land_speed_m_s;
    Guidance {
        p_ned: [ne.map(|p| p.x), ne.map(|p| p.y), None],
        v_ned: Vector3::new(0.0, 0.0, speed),
        limits: VelocityLimits { down_m_s: speed, ..still.limits },
        ..still
    }
}

/// Sinks without a place. The velocity over the ground that it seems to have is the one asked for, so that
/// nothing is: it stays level.
fn descending(still: Guidance, s: &Situation<'_>) -> Guidance {
    let speed = s.settings.land_speed_m_s;
    Guidance {
        v_ned: Vector3::new(s.v_ned.x, s.v_ned.y, speed),
        limits: VelocityLimits { level_m_s: f64::MAX, down_m_s: speed, ..still.limits },
        ..still
    }
}

/// Position down at which RETURN flies home: never below the present one.
fn return_down_m(s: &Situation<'_>) -> f64 {
    let near = (s.p_ned - s.home_ned).xy().norm() < NEAR_HOME_M;
    let height_m = if near { s.settings.descend_height_m } else { s.settings.return_height_m };
    (s.home_ned.z - height_m).min(s.p_ned.z)
}

fn returning(leg: &mut Leg, down: f64, s: &Situation<'_>, still: Guidance) -> Guidance {
    let home = s.home_ned;
    let wait_down = (home.z - s.settings.descend_height_m).max(down);
    let over_home = |down: f64| Guidance { p_ned: [Some(home.x), Some(home.y), Some(down)], ..still };
    let reached = |down: f64| (down - s.p_ned.z).abs() < HEIGHT_REACHED_M;
    if let Leg::Climb { stop } = leg {
        let place = stop.place(s, true);
        if !(reached(down) && place.is_some()) {
            return Guidance { p_ned: [place.map(|p| p.x), place.map(|p| p.y), Some(down)], ..still };
        }
        *leg = Leg::Cross;
    }
    if *leg == Leg::Cross {
        if (home - s.p_ned).xy().norm() > HOME_REACHED_M || s.v_ned.xy().norm() > STOPPED_M_S {
            return over_home(down);
        }
        *leg = Leg::Descend;
    }
    if *leg == Leg::Descend {
        if !reached(wait_down) {
            return over_home(wait_down);
        }
        *leg = Leg::Wait { since_us: s.now_us };
    }
    if let Leg::Wait { since_us } = *leg {
        let waited_s = s.now_us.saturating_sub(since_us) as f64 / US_PER_S;
        if s.settings.land_delay_s.is_none_or(|delay_s| waited_s < delay_s) {
            return over_home(wait_down);
        }
        *leg = Leg::Land;
    }
    descent(still, Some(home.xy()), s)
}
