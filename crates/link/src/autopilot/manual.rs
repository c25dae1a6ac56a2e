//! The modes that are flown with sticks: POSCTL, ALTCTL, STABILIZED, and MANUAL, which to a multirotor is
//! STABILIZED.
//!
//! | mode | sticks mean |
//! |---|---|
//! | POSCTL | a velocity; in the middle, the place where they were let go |
//! | ALTCTL | the acceleration of a tilt, and a climb rate; in the middle, level at that height |
//! | STABILIZED, MANUAL | a tilt and a collective thrust |
//!
//! As PX4 v1.14.0 has them: FlightTaskManualPosition, FlightTaskManualAltitude, StickYaw and StickTiltXY
//! (MPC_POS_MODE 0, "simple position control"), and `generate_attitude_setpoint` of mc_att_control. The yaw
//! stick turns at a rate, which is fed forward; the heading at which the turn ends is kept.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{Vector2, Vector3};

use super::FlightMode;
use super::sticks::Sticks;
use crate::control::VelocityLimits;
use crate::frames::{Quaternion, product, quaternion_from_euler, quaternion_from_rotation_vector, wrap_pi};
use crate::math;
use crate::units::RAD_PER_DEG;

/// A rate below this is no turn [rad/s].
const TURNING_RAD_S: f64 = 0.001;
/// A throttle stick above this, 65 % of its way, takes off (FlightTaskManualAltitude::_checkTakeoff).
const TAKEOFF_THROTTLE: f64 = 0.3;
/// A throttle stick below this does not turn the heading setpoint (generate_attitude_setpoint).
const IDLE_THROTTLE: f64 = -0.9;
/// Largest dead zone; PX4's `math::deadzone`.
const LARGEST_DEAD_ZONE: f64 = 0.99;

/// What sticks mean, under PX4's parameter names and with PX4's defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManualSettings {
    /// MPC_VEL_MANUAL: horizontal speed at full stick [m/s].
    pub speed_m_s: f64,
    /// MPC_VEL_MAN_SIDE: sideways [m/s]; negative as forward.
    pub side_speed_m_s: f64,
    /// MPC_VEL_MAN_BACK: backward [m/s]; negative as forward.
    pub back_speed_m_s: f64,
    /// MPC_MAN_TILT_MAX: tilt at full stick [deg].
    pub tilt_deg: f64,
    /// MC_MAN_TILT_TAU: time constant of the filter on the tilt sticks [s].
    pub tilt_tau_s: f64,
    /// MPC_MAN_Y_MAX: yaw rate at full stick [deg/s].
    pub yaw_rate_deg_s: f64,
    /// MPC_MAN_Y_TAU: time constant of the filter on the yaw stick [s].
    pub yaw_tau_s: f64,
    /// MPC_HOLD_DZ: dead zone of the sticks, 0..1.
    pub dead_zone: f64,
    /// MPC_HOLD_MAX_XY: horizontal speed below which the place is kept [m/s]; 0 is any.
    pub hold_speed_m_s: f64,
    /// MPC_HOLD_MAX_Z: vertical speed below which the height is kept [m/s]; 0 is any.
    pub hold_climb_m_s: f64,
    /// MPC_XY_MAN_EXPO: share of the cubic in the horizontal sticks, 0..1.
    pub level_expo: f64,
    /// MPC_Z_MAN_EXPO: share of the cubic in the throttle stick, 0..1.
    pub climb_expo: f64,
    /// MPC_YAW_EXPO: share of the cubic in the yaw stick, 0..1.
    pub yaw_expo: f64,
    /// MPC_LAND_ALT1: height above home below which the climb rate is limited [m].
    pub slow_below_m: f64,
    /// MPC_LAND_ALT2: height above home below which it is that of landing and takeoff [m].
    pub slowest_below_m: f64,
    /// MPC_MANTHR_MIN: collective thrust at the lowest stick, 0..1.
    pub least_thrust: f64,
    /// MPC_THR_MAX: collective thrust at the highest stick, 0..1.
    pub most_thrust: f64,
    /// MPC_THR_CURVE: 1, thrust is linear in the stick; 0, the middle hovers.
    pub linear_thrust: bool,
}

impl ManualSettings {
    /// PX4 v1.14's defaults.
    pub const DEFAULT: Self = Self {
        speed_m_s: 10.0,
        side_speed_m_s: -1.0,
        back_speed_m_s: -1.0,
        tilt_deg: 35.0,
        tilt_tau_s: 0.0,
        yaw_rate_deg_s: 150.0,
        yaw_tau_s: 0.08,
        dead_zone: 0.1,
        hold_speed_m_s: 0.8,
        hold_climb_m_s: 0.6,
        level_expo: 0.6,
        climb_expo: 0.6,
        yaw_expo: 0.6,
        slow_below_m: 10.0,
        slowest_below_m: 5.0,
        least_thrust: 0.08,
        most_thrust: 1.0,
        linear_thrust: false,
    };

    /// Collective thrust of a throttle stick, 0..1, where `hover` carries the weight: PX4's
    /// `throttle_curve`.
    fn thrust(&self, throttle: f64, hover: f64) -> f64 {
        let stick = (0.5 * (throttle + 1.0)).clamp(0.0, 1.0);
        let (least, most) = (self.least_thrust, self.most_thrust);
        let thrust = match stick {
            _ if self.linear_thrust => least + stick * (most - least),
            lower if lower <= 0.5 => least + 2.0 * lower * (hover - least),
            upper => hover + (2.0 * upper - 1.0) * (most - hover),
        };
        thrust.clamp(0.0, 1.0)
    }
}

/// What a step of a manual mode knows.
#[derive(Clone, Copy, Debug)]
pub struct Circumstances<'a> {
    /// Position, NED [m].
    pub p_ned: Vector3<f64>,
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Heading [rad].
    pub yaw_rad: f64,
    /// Control period [s].
    pub dt_s: f64,
    /// Home's position down [m].
    pub home_down_m: f64,
    /// MPC_LAND_SPEED and MPC_TKO_SPEED: greatest descent and climb near the ground [m/s].
    pub near_ground_m_s: [f64; 2],
    /// Greatest velocities.
    pub limits: VelocityLimits,
    /// Greatest yaw rate, MC_YAWRATE_MAX [rad/s].
    pub yaw_rate_rad_s: f64,
    /// Gravity [m/s^2].
    pub gravity_m_s2: f64,
    /// Collective thrust that carries the weight, 0..1.
    pub hover_thrust: f64,
    /// What the sticks mean.
    pub settings: &'a ManualSettings,
}

impl Circumstances<'_> {
    /// Yaw rate of a yaw stick [rad/s].
    fn yaw_rate(&self, stick: f64) -> f64 {
        let rate = stick * self.settings.yaw_rate_deg_s * RAD_PER_DEG;
        rate.min(self.yaw_rate_rad_s).max(-self.yaw_rate_rad_s)
    }
}

/// A heading that may be turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    /// Heading [rad].
    pub yaw_rad: f64,
    /// Rate, fed forward [rad/s].
    pub rate_rad_s: f64,
}

impl Heading {
    /// By how much the heading that a loop of gain `k_per_s` is asked for has to be ahead so that it turns at
    /// the rate [rad]: rate over gain, and never so much that the loop would turn back.
    pub fn lead_rad(&self, k_per_s: f64) -> f64 {
        let lead = if k_per_s > 0.0 { self.rate_rad_s / k_per_s } else { 0.0 };
        lead.clamp(-FRAC_PI_2, FRAC_PI_2)
    }

    /// The attitude that a loop of yaw gain `k_per_s` is asked for, with a tilt about nose and right wing
    /// [rad] as seen from the heading; the lead turns about the thrust, which stays where it is.
    pub fn attitude(&self, tilt_rad: &Vector2<f64>, k_per_s: f64) -> Quaternion {
        let about_down = |angle| quaternion_from_euler(0.0, 0.0, angle);
        let tilt = quaternion_from_rotation_vector(Vector3::new(tilt_rad.x, tilt_rad.y, 0.0));
        product(product(about_down(self.yaw_rad), tilt), about_down(self.lead_rad(k_per_s)))
    }
}

/// What the sticks ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ManualSetpoint {
    /// Position, velocity and acceleration by axes, NED [m, m/s, m/s^2]; velocity beside a position is fed
    /// forward, and an axis has one of the three at the least.
    Place {
        /// Position, velocity, acceleration.
        pva: [[Option<f64>; 3]; 3],
        /// Heading.
        heading: Heading,
    },
    /// A tilt about body axes seen from above, and a thrust.
    Tilt {
        /// Rotation vector of the tilt: about the nose and about the right wing [rad].
        tilt_rad: Vector2<f64>,
        /// Heading.
        heading: Heading,
        /// Collective thrust, 0..1.
        thrust: f64,
    },
}

/// A manual mode under way.
#[derive(Clone, Copy, Debug, Default)]
pub struct ManualFlight {
    begun: bool,
    /// The place that is kept, by axes, NED [m].
    level_m: Option<[f64; 2]>,
    down_m: Option<f64>,
    /// The heading that is kept, and the filtered yaw rate.
    yaw_rad: Option<f64>,
    yaw_rate_rad_s: f64,
    /// Filtered tilt sticks.
    tilt: Vector2<f64>,
}

/// Whether the throttle stick asks for a takeoff.
pub fn wants_takeoff(sticks: &Sticks) -> bool {
    sticks.throttle > TAKEOFF_THROTTLE
}

impl ManualFlight {
    /// The next step of a mode.
    pub fn step(&mut self, mode: FlightMode, sticks: &Sticks, c: &Circumstances<'_>) -> ManualSetpoint {
        if !std::mem::replace(&mut self.begun, true) {
            (self.level_m, self.down_m) = (Some([c.p_ned.x, c.p_ned.y]), Some(c.p_ned.z));
        }
        if !mode.holds_height() {
            return self.tilt(sticks, c);
        }
        let heading = self.turn(sticks, c);
        let (down_m, climb) = self.climb(sticks, c);
        let ahead = Vector2::new(sticks.pitch, sticks.roll);
        let [p, v, a] = match mode {
            FlightMode::Posctl => {
                let v = self.speed(ahead, c);
                [self.place(v, c), [Some(v.x), Some(v.y)], [None; 2]]
            }
            _ => {
                let a = self.acceleration(ahead, c);
                [[None; 2], [None; 2], [Some(a.x), Some(a.y)]]
            }
        };
        let pva = [[p[0], p[1], down_m], [v[0], v[1], Some(climb)], [a[0], a[1], None]];
        ManualSetpoint::Place { pva, heading }
    }

    /// StickYaw: the filtered rate, and the heading that is kept once it has died away.
    fn turn(&mut self, sticks: &Sticks, c: &Circumstances<'_>) -> Heading {
        let s = c.settings;
        let wanted = c.yaw_rate(curved(sticks.yaw, s.yaw_expo, s.dead_zone));
        self.yaw_rate_rad_s += smoothing(c.dt_s, s.yaw_tau_s) * (wanted - self.yaw_rate_rad_s);
        if self.yaw_rate_rad_s.abs() > TURNING_RAD_S {
            self.yaw_rad = None;
            return Heading { yaw_rad: c.yaw_rad, rate_rad_s: self.yaw_rate_rad_s };
        }
        Heading { yaw_rad: *self.yaw_rad.get_or_insert(c.yaw_rad), rate_rad_s: 0.0 }
    }

    /// FlightTaskManualAltitude: the height that is kept, and the velocity down.
    fn climb(&mut self, sticks: &Sticks, c: &Circumstances<'_>) -> (Option<f64>, f64) {
        let s = c.settings;
        let stick = -curved(sticks.throttle, s.climb_expo, s.dead_zone);
        let greatest = if sticks.throttle < 0.0 { c.limits.down_m_s } else { c.limits.up_m_s };
        let stopped = s.hold_climb_m_s <= 0.0 || c.v_ned.z.abs() < s.hold_climb_m_s;
        self.down_m = match self.down_m {
            _ if stick != 0.0 => None,
            None if stopped => Some(c.p_ned.z),
            kept => kept,
        };
        let height_m = c.home_down_m - c.p_ned.z;
        let within =
            |least: f64, most: f64| between(height_m, s.slowest_below_m, s.slow_below_m, least, most);
        let [land, take_off] = c.near_ground_m_s;
        let (up, down) = (within(take_off, c.limits.up_m_s), within(land, c.limits.down_m_s));
        (self.down_m, (greatest * stick).min(down).max(-up))
    }

    /// FlightTaskManualPosition: the velocity that the sticks point to, NED.
    fn speed(&self, ahead: Vector2<f64>, c: &Circumstances<'_>) -> Vector2<f64> {
        let s = c.settings;
        let mut stick = within_unit(ahead.map(|x| curved(x, s.level_expo, s.dead_zone)));
        if s.side_speed_m_s >= 0.0 {
            stick.y *= s.side_speed_m_s / s.speed_m_s;
        }
        if s.back_speed_m_s >= 0.0 && stick.x < 0.0 {
            stick.x *= s.back_speed_m_s / s.speed_m_s;
        }
        self.turned_to_ned(stick * s.speed_m_s, c)
    }

    /// The place that is kept: where the vehicle had slowed down after the sticks were let go.
    fn place(&mut self, v_sp: Vector2<f64>, c: &Circumstances<'_>) -> [Option<f64>; 2] {
        let hold = c.settings.hold_speed_m_s;
        let stopped = hold <= 0.0 || c.v_ned.xy().norm() < hold;
        self.level_m = match self.level_m {
            _ if v_sp.norm() > 0.0 => None,
            None if stopped => Some([c.p_ned.x, c.p_ned.y]),
            kept => kept,
        };
        self.level_m.map_or([None; 2], |p| p.map(Some))
    }

    /// StickTiltXY: the acceleration of a tilt at hover, NED.
    fn acceleration(&mut self, ahead: Vector2<f64>, c: &Circumstances<'_>) -> Vector2<f64> {
        let s = c.settings;
        self.tilt += (within_unit(ahead) - self.tilt) * smoothing(c.dt_s, s.tilt_tau_s);
        self.turned_to_ned(self.tilt, c) * (math::tan(s.tilt_deg * RAD_PER_DEG) * c.gravity_m_s2)
    }

    /// From forward and right to north and east, by the heading that is kept, else the present one.
    fn turned_to_ned(&self, v: Vector2<f64>, c: &Circumstances<'_>) -> Vector2<f64> {
        let (sin, cos) = math::sin_cos(self.yaw_rad.unwrap_or(c.yaw_rad));
        Vector2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y)
    }

    /// `generate_attitude_setpoint`: sticks without dead zone and curve straight to a tilt.
    fn tilt(&mut self, sticks: &Sticks, c: &Circumstances<'_>) -> ManualSetpoint {
        let s = c.settings;
        let most = s.tilt_deg * RAD_PER_DEG;
        let wanted = Vector2::new(sticks.roll, -sticks.pitch) * most;
        self.tilt += (wanted - self.tilt) * smoothing(c.dt_s, s.tilt_tau_s);
        let rate_rad_s = c.yaw_rate(sticks.yaw);
        let yaw_rad = match self.yaw_rad {
            Some(yaw) if sticks.throttle >= IDLE_THROTTLE => wrap_pi(yaw + rate_rad_s * c.dt_s),
            _ => c.yaw_rad,
        };
        self.yaw_rad = Some(yaw_rad);
        let norm = self.tilt.norm();
        let tilt_rad = if norm > most { self.tilt * (most / norm) } else { self.tilt };
        let heading = Heading { yaw_rad, rate_rad_s };
        ManualSetpoint::Tilt { tilt_rad, heading, thrust: s.thrust(sticks.throttle, c.hover_thrust) }
    }
}

/// PX4's `expo_deadzone`: zero within the dead zone, linear and cubic in shares beyond it, 1 at full stick.
fn curved(stick: f64, expo: f64, dead_zone: f64) -> f64 {
    let (stick, dead) = (stick.clamp(-1.0, 1.0), dead_zone.clamp(0.0, LARGEST_DEAD_ZONE));
    if stick.abs() <= dead {
        return 0.0;
    }
    let x = (stick - dead.copysign(stick)) / (1.0 - dead);
    (1.0 - expo) * x + expo * x * x * x
}

/// PX4's AlphaFilter: the share of the way to a new value in a step.
fn smoothing(dt_s: f64, tau_s: f64) -> f64 {
    let sum = tau_s + dt_s;
    if sum > 0.0 { dt_s / sum } else { 0.0 }
}

/// A vector of at most unit length.
fn within_unit(v: Vector2<f64>) -> Vector2<f64> {
    let length = v.norm();
    if length > 1.0 { v / length } else { v }
}

/// PX4's `math::interpolate`: constant, linear between the two corners, constant.
fn between(x: f64, low: f64, high: f64, at_low: f64, at_high: f64) -> f64 {
    if x <= low {
        at_low
    } else if x > high {
        at_high
    } else {
        at_low + (x - low) * (at_high - at_low) / (high - low)
    }
}

#[cfg(test)]
mod tests;
