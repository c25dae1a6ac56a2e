//! Torque and thrust to the motors of a quadrotor in X, and what is done where they do not fit:
//! `MultirotorMixer::mix_airmode_disabled` (MC_AIRMODE 0), `minimize_saturation`, `mix_yaw`,
//! `update_saturation_status`.
//!
//! Thrust comes down first, never up; then roll, then pitch give way; yaw is mixed into what is left, for
//! which thrust may come down again.

use nalgebra::Vector3;
use std::f64::consts::FRAC_1_SQRT_2;

/// Motors of the quadrotor.
pub const MOTORS: usize = 4;

type Motors = [f64; MOTORS];

const ROLL: Motors = [-FRAC_1_SQRT_2, FRAC_1_SQRT_2, FRAC_1_SQRT_2, -FRAC_1_SQRT_2];
const PITCH: Motors = [FRAC_1_SQRT_2, -FRAC_1_SQRT_2, FRAC_1_SQRT_2, -FRAC_1_SQRT_2];
const YAW: Motors = [1.0, 1.0, -1.0, -1.0];
const THRUST: Motors = [1.0; MOTORS];

/// Yaw may ask for so much of a motor, at the cost of thrust.
const MOST_WITH_YAW: f64 = 1.15;

/// A motor with a lesser share is not made room for.
const WEAK: f64 = 0.2;

/// Below this command, -1 to 1, a motor counts as stopped.
const STOPPED: f64 = -0.99;

/// Axes whose torque cannot grow to one side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Saturation {
    /// More torque to the positive side would saturate more.
    pub positive: [bool; 3],
    /// More torque to the negative side would saturate more.
    pub negative: [bool; 3],
}

/// Thrust of each motor, 0..1 or a little beyond, for normalised torque (-1..1 each) and thrust (0..1).
pub fn mix(torque: &Vector3<f64>, thrust: f64) -> Motors {
    let torque = torque.map(|t| t.clamp(-1.0, 1.0));
    desaturated(&[ROLL, PITCH, YAW, THRUST], &torque, thrust.clamp(0.0, 1.0))
}

/// Thrust of each of N motors, by their shares in a unit of roll, pitch, yaw and thrust: 0..1 or a little
/// beyond.
pub fn desaturated<const N: usize>(shares: &[[f64; N]; 4], torque: &Vector3<f64>, thrust: f64) -> [f64; N] {
    let [roll, pitch, yaw, up] = shares;
    let mut motors = std::array::from_fn(|i| torque.x * roll[i] + torque.y * pitch[i] + thrust * up[i]);
    unsaturate(&mut motors, up, 1.0, true);
    unsaturate(&mut motors, roll, 1.0, false);
    unsaturate(&mut motors, pitch, 1.0, false);
    for (motor, yaw) in motors.iter_mut().zip(yaw) {
        *motor += torque.z * yaw;
    }
    unsaturate(&mut motors, yaw, MOST_WITH_YAW, false);
    unsaturate(&mut motors, up, 1.0, true);
    motors
}

/// Torques that motor commands (-1..1) leave no room for in the next step: a stopped motor takes no less.
pub fn saturation(commands: &Motors) -> Saturation {
    let mut found = Saturation::default();
    for (i, _) in commands.iter().enumerate().filter(|(_, command)| **command < STOPPED) {
        for (axis, share) in [ROLL[i], PITCH[i], YAW[i]].into_iter().enumerate() {
            found.negative[axis] |= share > 0.0;
            found.positive[axis] |= share < 0.0;
        }
    }
    found
}

/// Moves the motors along a vector until as few as possible are beyond 0 and `most`, twice, the second time
/// half way.
fn unsaturate<const N: usize>(motors: &mut [f64; N], along: &[f64; N], most: f64, only_down: bool) {
    let first = gain(motors, along, most);
    if only_down && first > 0.0 {
        return;
    }
    add(motors, along, first);
    let second = 0.5 * gain(motors, along, most);
    add(motors, along, second);
}

fn add<const N: usize>(motors: &mut [f64; N], along: &[f64; N], gain: f64) {
    for (motor, share) in motors.iter_mut().zip(along) {
        *motor += gain * share;
    }
}

fn gain<const N: usize>(motors: &[f64; N], along: &[f64; N], most: f64) -> f64 {
    let (mut least, mut greatest) = (0.0f64, 0.0f64);
    for (motor, share) in motors.iter().zip(along).filter(|(_, share)| share.abs() >= WEAK) {
        let beyond = if *motor < 0.0 {
            -motor
        } else if *motor > most {
            most - motor
        } else {
            continue;
        };
        least = least.min(beyond / share);
        greatest = greatest.max(beyond / share);
    }
    least + greatest
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn near(found: Motors, expected: Motors) -> bool {
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12)
    }

    /// Closed form: u = 0.7071 (+-roll +-pitch) +- yaw + thrust where everything fits.
    #[test]
    fn closed_form_what_fits_is_mixed_as_it_is() {
        let r = FRAC_1_SQRT_2;
        let expected = [
            0.5 - 0.1 * r + 0.2 * r + 0.05,
            0.5 + 0.1 * r - 0.2 * r + 0.05,
            0.5 + 0.1 * r + 0.2 * r - 0.05,
            0.5 - 0.1 * r - 0.2 * r - 0.05,
        ];
        assert!(near(mix(&Vector3::new(0.1, 0.2, 0.05), 0.5), expected));
    }

    /// Closed forms: without thrust nothing turns; thrust gives way to pitch at the top and not at the
    /// bottom.
    #[test]
    fn closed_form_saturation() {
        assert!(near(mix(&Vector3::new(0.3, -0.2, 0.0), 0.0), [0.0; 4]));
        let pitched = mix(&Vector3::new(0.0, 0.2, 0.0), 1.0);
        let below = 1.0 - 2.0 * 0.2 * FRAC_1_SQRT_2;
        assert!(near(pitched, [1.0, below, 1.0, below]), "{pitched:?}");
        let low = mix(&Vector3::new(0.0, 0.4, 0.0), 0.1);
        assert!(near(low, [0.2, 0.0, 0.2, 0.0]), "pitch is cut to what the thrust carries: {low:?}");
        let none = saturation(&[-1.0; 4]);
        assert_eq!((none.positive, none.negative), ([true; 3], [true; 3]));
        let rear_left = saturation(&[0.0, -1.0, 0.0, 0.0]);
        assert_eq!(rear_left.negative, [true, false, true]);
        assert_eq!(rear_left.positive, [false, true, false]);
    }

    proptest! {
        /// Thrust is never raised, and without yaw every motor keeps its range.
        #[test]
        fn prop_thrust_only_comes_down(x in -1.5f64..1.5, y in -1.5f64..1.5, thrust in -0.2f64..1.2) {
            let motors = mix(&Vector3::new(x, y, 0.0), thrust);
            prop_assert!(motors.iter().sum::<f64>() <= 4.0 * thrust.clamp(0.0, 1.0) + 1e-9, "{motors:?}");
            prop_assert!(motors.iter().all(|m| (-1e-9..=1.0 + 1e-9).contains(m)), "{motors:?}");
        }
    }
}
