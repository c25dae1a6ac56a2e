//! Moments and collective to rotor thrusts, each within `[0, T_lim]`.
//!
//! Roll and pitch moment first, then the collective, which gives way both ways, then yaw in what room is left. For a
//! quadrotor in the vertical plane this is the planar rule, with `b` the collective per rotor and `d` the pitch share:
//!
//! ```text
//! |d| <= T_lim/2 ;  b + |d| > T_lim: b = T_lim - |d| ;  b - |d| < 0: b = |d| ;  T = b +- d
//! ```
//!
//! For N rotors the shares come from the minimum-norm allocation; the moment is scaled down only as far as no collective
//! at all could make room for it, and its direction is kept.

use nalgebra::{SMatrix, Vector3};

use super::ControlError;
use crate::model::{MAX_ROTORS, PerRotor};

/// Allocation of collective and moments to rotors.
#[derive(Clone, Debug, PartialEq)]
pub struct Mixer {
    n_rotors: usize,
    thrust_limit_n: f64,
    /// Thrust of each rotor per newton of lift.
    lift: PerRotor,
    /// Thrust of each rotor per newton metre of roll, pitch, yaw moment.
    moment: [PerRotor; 3],
}

/// A demand larger than this [N or N m] says nothing more than its sign; keeps every product finite.
const DEMAND_LIMIT: f64 = 1e12;

impl Mixer {
    /// From columns lift, roll, pitch, yaw of thrust per unit of demand.
    ///
    /// # Errors
    /// [`ControlError::RotorWithoutLift`] when a rotor has no positive share of the lift.
    pub fn new(
        n_rotors: usize,
        thrust_limit_n: f64,
        allocation: &SMatrix<f64, MAX_ROTORS, 4>,
    ) -> Result<Self, ControlError> {
        let n_rotors = n_rotors.min(MAX_ROTORS);
        let column = |j: usize| std::array::from_fn(|i| if i < n_rotors { allocation[(i, j)] } else { 0.0 });
        let lift: PerRotor = column(0);
        if let Some(i) = (0..n_rotors).find(|&i| !(lift[i] > 0.0)) {
            return Err(ControlError::RotorWithoutLift { rotor: i + 1 });
        }
        Ok(Self { n_rotors, thrust_limit_n, lift, moment: [column(1), column(2), column(3)] })
    }

    /// Number of rotors.
    pub fn n_rotors(&self) -> usize {
        self.n_rotors
    }

    /// Largest thrust of one rotor [N]: `T_static`.
    pub fn thrust_limit_n(&self) -> f64 {
        self.thrust_limit_n
    }

    /// Whether the rotors can make a yaw moment.
    pub fn yaws(&self) -> bool {
        self.moment[2].iter().any(|&y| y != 0.0)
    }

    /// Thrust of each rotor [N] for a lift [N] and a moment [N m], body axes. A demand that is not a number counts as zero.
    pub fn thrusts(&self, lift_n: f64, moment_body: &Vector3<f64>) -> PerRotor {
        let n = self.n_rotors;
        let limit = self.thrust_limit_n;
        let bounded = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(-DEMAND_LIMIT, DEMAND_LIMIT) };
        let [m_roll, m_pitch, m_yaw] =
            [bounded(moment_body.x), bounded(moment_body.y), bounded(moment_body.z)];
        let mut tilt: PerRotor =
            std::array::from_fn(|i| self.moment[0][i] * m_roll + self.moment[1][i] * m_pitch);
        // A lift L fits when 0 <= L c_i + d_i <= T_lim for all i; there is one when s (d_i/c_i - d_j/c_j) <= T_lim/c_i.
        let mut scale = 1.0f64;
        for i in 0..n {
            for j in 0..n {
                let spread = tilt[i] * self.lift[j] - tilt[j] * self.lift[i];
                let room = limit * self.lift[j];
                if scale * spread > room {
                    scale = room / spread;
                }
            }
        }
        let (mut lowest, mut highest) = (f64::NEG_INFINITY, f64::INFINITY);
        for (share, lift) in tilt.iter_mut().zip(&self.lift).take(n) {
            *share *= scale;
            lowest = lowest.max(-*share / lift);
            highest = highest.min((limit - *share) / lift);
        }
        let lift = bounded(lift_n).min(highest).max(lowest);
        let mut thrust = [0.0; MAX_ROTORS];
        for i in 0..n {
            thrust[i] = lift * self.lift[i] + tilt[i];
        }
        self.add_yaw(&mut thrust, m_yaw);
        for t in &mut thrust[..n] {
            *t = t.min(limit).max(0.0);
        }
        thrust
    }

    /// Adds as much of the yaw moment as keeps every thrust within its limits.
    fn add_yaw(&self, thrust: &mut PerRotor, m_yaw: f64) {
        if m_yaw == 0.0 {
            return;
        }
        let mut scale = 1.0f64;
        for (t, y) in thrust.iter().zip(&self.moment[2]).take(self.n_rotors) {
            let share = y * m_yaw;
            let room = if share > 0.0 { self.thrust_limit_n - t } else { *t };
            if share.abs() * scale > room {
                scale = room.max(0.0) / share.abs();
            }
        }
        for (t, y) in thrust.iter_mut().zip(&self.moment[2]).take(self.n_rotors) {
            *t += y * m_yaw * scale;
        }
    }
}
