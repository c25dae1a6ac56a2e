//! The setpoints of OFFBOARD: a velocity, a place, an acceleration, an attitude, or body rates; and the rule
//! that OFFBOARD may begin, and go on, only with a setpoint younger than PX4's COM_OF_LOSS_T of simulated
//! time.
//!
//! `link` reads the wire's type masks; here a setpoint is already one of the kinds
//! that are flown, and its numbers are checked: finite, quaternion near unit length, thrust within 0..1.

use nalgebra::Vector3;

use crate::frames::{Quaternion, normalized, quaternion_from_euler, rotate_ned_from_body, wrap_pi, yaw};
use crate::time::seconds;

/// The frame that a velocity setpoint is given in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityFrame {
    /// North, east, down.
    Ned,
    /// Forward, right, down, level whatever the tilt: NED turned by the vehicle's heading at the setpoint's
    /// arrival.
    Heading,
}

/// Heading under a velocity setpoint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum YawSetpoint {
    /// Keep the heading that was last commanded, or the one at which velocity control began.
    Keep,
    /// Turn to this heading [rad].
    Angle(f64),
    /// Turn at this rate [rad/s].
    Rate(f64),
    /// Turn to a heading that goes on turning from the setpoint's arrival.
    Turning {
        /// Heading at the arrival [rad].
        angle: f64,
        /// Rate [rad/s].
        rate: f64,
    },
}

/// A setpoint as a companion sends it; [`crate::control::Setpoint`] is what the controller is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OffboardSetpoint {
    /// Velocity with acceleration feed-forward.
    Velocity {
        /// Frame of both vectors.
        frame: VelocityFrame,
        /// Velocity [m/s].
        v: Vector3<f64>,
        /// Acceleration feed-forward [m/s^2]; zero when none is given.
        a_ff: Vector3<f64>,
        /// Heading.
        yaw: YawSetpoint,
    },
    /// Position, velocity and acceleration, mixed by axes; each axis has one of them at the least.
    Place {
        /// Frame of velocity and acceleration. A position is in NED, from the local origin, whatever that is.
        frame: VelocityFrame,
        /// Position [m].
        p: [Option<f64>; 3],
        /// Velocity [m/s]: fed forward beside a position, else to be flown.
        v: [Option<f64>; 3],
        /// Acceleration [m/s^2]: fed forward beside a velocity or position, else to be flown.
        a: [Option<f64>; 3],
        /// Heading.
        yaw: YawSetpoint,
    },
    /// Attitude and collective thrust.
    Attitude {
        /// Attitude, body to NED.
        q_ned_from_body: Quaternion,
        /// 0..1 of all rotors' static thrust.
        collective: f64,
    },
    /// Body rates and collective thrust.
    Rates {
        /// Body rates [rad/s].
        omega_body: Vector3<f64>,
        /// 0..1 of all rotors' static thrust.
        collective: f64,
    },
}

/// Why a setpoint cannot be flown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SetpointRefusal {
    /// A number that counts is NaN or infinite.
    #[error("setpoint refused: NaN or infinite")]
    NotFinite,
    /// The quaternion is not of unit length.
    #[error("setpoint refused: quaternion not of unit length")]
    QuaternionLength,
    /// The thrust is outside 0..1.
    #[error("setpoint refused: thrust must be within 0..1")]
    ThrustRange,
    /// The heading frame needs a heading.
    #[error("setpoint refused: no heading known yet")]
    NoHeading,
}

impl OffboardSetpoint {
    /// Checks the numbers, scales the quaternion to unit length, turns the heading frame into NED with the
    /// vehicle's present attitude.
    ///
    /// # Errors
    /// [`SetpointRefusal`] names what is wrong.
    pub(super) fn checked(self, q_now: Option<Quaternion>) -> Result<Self, SetpointRefusal> {
        match self {
            Self::Velocity { frame, v, a_ff, yaw: heading } => {
                check_finite(v.iter().chain(a_ff.iter()).chain(&heading.numbers()))?;
                let ned = turn_into_ned(frame, q_now)?;
                Ok(Self::Velocity { frame: VelocityFrame::Ned, v: ned(v), a_ff: ned(a_ff), yaw: heading })
            }
            Self::Place { frame, p, v, a, yaw: heading } => {
                check_finite(p.iter().chain(&v).chain(&a).flatten().chain(&heading.numbers()))?;
                let turn = turn_into_ned(frame, q_now)?;
                let ned = |x: [Option<f64>; 3]| {
                    let turned = turn(x.map(|x| x.unwrap_or(0.0)).into());
                    std::array::from_fn(|i| x[i].map(|_| turned[i]))
                };
                Ok(Self::Place { frame: VelocityFrame::Ned, p, v: ned(v), a: ned(a), yaw: heading })
            }
            Self::Attitude { q_ned_from_body: q, collective } => {
                check_finite(&q)?;
                check_thrust(collective)?;
                let length = q.iter().map(|c| c * c).sum::<f64>().sqrt();
                if (length - 1.0).abs() > 0.1 {
                    return Err(SetpointRefusal::QuaternionLength);
                }
                Ok(Self::Attitude { q_ned_from_body: normalized(q), collective })
            }
            Self::Rates { omega_body, collective } => {
                check_finite(omega_body.iter())?;
                check_thrust(collective)?;
                Ok(self)
            }
        }
    }
}

impl YawSetpoint {
    fn numbers(self) -> [f64; 2] {
        match self {
            Self::Keep => [0.0; 2],
            Self::Angle(x) | Self::Rate(x) => [x, 0.0],
            Self::Turning { angle, rate } => [angle, rate],
        }
    }

    /// The heading that is to be flown so long [s] after the setpoint's arrival.
    fn aged(self, age_s: f64) -> Self {
        match self {
            Self::Turning { angle, rate } => Self::Angle(wrap_pi(angle + rate * age_s)),
            other => other,
        }
    }
}

/// Rotation of a frame's vectors into NED, with the vehicle's present attitude.
fn turn_into_ned(
    frame: VelocityFrame,
    q_now: Option<Quaternion>,
) -> Result<impl Fn(Vector3<f64>) -> Vector3<f64>, SetpointRefusal> {
    let turn = match frame {
        VelocityFrame::Ned => None,
        VelocityFrame::Heading => {
            Some(quaternion_from_euler(0.0, 0.0, yaw(q_now.ok_or(SetpointRefusal::NoHeading)?)))
        }
    };
    Ok(move |x: Vector3<f64>| turn.map_or(x, |q| rotate_ned_from_body(q, x)))
}

fn check_finite<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Result<(), SetpointRefusal> {
    if numbers.into_iter().all(|x| x.is_finite()) { Ok(()) } else { Err(SetpointRefusal::NotFinite) }
}

fn check_thrust(collective: f64) -> Result<(), SetpointRefusal> {
    check_finite([&collective])?;
    if (0.0..=1.0).contains(&collective) { Ok(()) } else { Err(SetpointRefusal::ThrustRange) }
}

/// The latest setpoint and when it came.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetpointStore(Option<(u64, OffboardSetpoint)>);

impl SetpointStore {
    /// Keeps a setpoint that came at `now_us`.
    pub fn put(&mut self, now_us: u64, setpoint: OffboardSetpoint) {
        self.0 = Some((now_us, setpoint));
    }

    /// The latest setpoint, as it is to be flown at `now_us`, if it is no older than `timeout_us`.
    pub fn fresh(&self, now_us: u64, timeout_us: u64) -> Option<OffboardSetpoint> {
        // One from the future is from before simulated time began.
        let (at, mut setpoint) = self.0?;
        let age_us = now_us.checked_sub(at).filter(|us| *us <= timeout_us)?;
        if let OffboardSetpoint::Velocity { yaw, .. } | OffboardSetpoint::Place { yaw, .. } = &mut setpoint {
            *yaw = yaw.aged(seconds(age_us));
        }
        Some(setpoint)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn velocity(frame: VelocityFrame, v: Vector3<f64>) -> OffboardSetpoint {
        OffboardSetpoint::Velocity { frame, v, a_ff: Vector3::zeros(), yaw: YawSetpoint::Keep }
    }

    #[test]
    fn closed_form_a_setpoint_lives_for_so_long() {
        let setpoint = OffboardSetpoint::Attitude { q_ned_from_body: [1.0, 0.0, 0.0, 0.0], collective: 0.0 };
        let mut store = SetpointStore::default();
        assert_eq!(store.fresh(0, 1_000_000), None);
        store.put(500, setpoint);
        assert_eq!(store.fresh(1_000_500, 1_000_000), Some(setpoint));
        assert_eq!(store.fresh(1_000_501, 1_000_000), None);
        assert_eq!(store.fresh(499, 1_000_000), None, "a clock that has started over");
        assert_eq!((store.fresh(520, 20), store.fresh(521, 20)), (Some(setpoint), None));
    }

    /// 0.5 rad at the arrival, 0.25 rad/s: 0.6 rad after 0.4 s; over the turn to the other side.
    #[test]
    fn closed_form_a_heading_goes_on_turning() {
        let mut store = SetpointStore::default();
        let heading = |store: &SetpointStore, now_us| match store.fresh(now_us, 1_000_000) {
            Some(OffboardSetpoint::Velocity { yaw: YawSetpoint::Angle(angle), .. }) => angle,
            other => panic!("{other:?}"),
        };
        let turning = |angle, rate| OffboardSetpoint::Velocity {
            frame: VelocityFrame::Ned,
            v: Vector3::zeros(),
            a_ff: Vector3::zeros(),
            yaw: YawSetpoint::Turning { angle, rate },
        };
        store.put(1_000_000, turning(0.5, 0.25));
        assert_relative_eq!(heading(&store, 1_400_000), 0.6, epsilon = 1e-15);
        store.put(2_000_000, turning(3.0, 1.0));
        assert_relative_eq!(heading(&store, 2_500_000), 3.5 - std::f64::consts::TAU, epsilon = 1e-15);
        assert_eq!(turning(0.0, f64::NAN).checked(None), Err(SetpointRefusal::NotFinite));
    }

    #[test]
    fn closed_form_heading_frame_turns_with_the_nose_and_not_with_the_tilt() {
        let q = quaternion_from_euler(0.2, -0.4, std::f64::consts::FRAC_PI_2);
        let forward_down = velocity(VelocityFrame::Heading, Vector3::new(3.0, 0.0, 1.0));
        let Ok(OffboardSetpoint::Velocity { frame, v, .. }) = forward_down.checked(Some(q)) else {
            panic!("refused")
        };
        assert_eq!(frame, VelocityFrame::Ned);
        assert_relative_eq!(v, Vector3::new(0.0, 3.0, 1.0), epsilon = 1e-12);
        assert_eq!(forward_down.checked(None), Err(SetpointRefusal::NoHeading));
    }

    #[test]
    fn closed_form_nonsense_is_refused_with_its_reason() {
        let nan = velocity(VelocityFrame::Ned, Vector3::new(0.0, f64::NAN, 0.0));
        assert_eq!(nan.checked(None), Err(SetpointRefusal::NotFinite));
        let attitude =
            |q, collective| OffboardSetpoint::Attitude { q_ned_from_body: q, collective }.checked(None);
        assert_eq!(attitude([0.0; 4], 0.0), Err(SetpointRefusal::QuaternionLength));
        assert_eq!(attitude([1.0, 0.0, 0.0, 0.0], 1.01), Err(SetpointRefusal::ThrustRange));
        assert_eq!(attitude([1.0, 0.0, 0.0, 0.0], f64::NAN), Err(SetpointRefusal::NotFinite));
        assert!(
            attitude([1.001, 0.0, 0.0, 0.0], 0.5).is_ok_and(|s| s
                == OffboardSetpoint::Attitude { q_ned_from_body: [1.0, 0.0, 0.0, 0.0], collective: 0.5 })
        );
    }
}
