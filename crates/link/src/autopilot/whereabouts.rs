//! Where the vehicle is and how it moves, as of its last step, and where home is.

use nalgebra::Vector3;

use crate::control::Measurement;
use crate::time::seconds;

/// Control period of the first step, before two stamps show it [s]: 250 Hz.
const NOMINAL_PERIOD_S: f64 = 0.004;
/// Longest period that is integrated over [s]: a gap in the sensor stream does not wind the integrals up.
const LONGEST_PERIOD_S: f64 = 0.05;

/// What is known of place and motion.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Whereabouts {
    p_ned: Vector3<f64>,
    state: Option<(u64, Measurement)>,
    home_ned: Option<Vector3<f64>>,
    last_step_us: Option<u64>,
}

impl Whereabouts {
    /// Takes the position and state of a step; the control period [s].
    pub fn take(&mut self, now_us: u64, p_ned: &Vector3<f64>, measurement: &Measurement) -> f64 {
        (self.p_ned, self.state) = (*p_ned, Some((now_us, *measurement)));
        match self.last_step_us.replace(now_us) {
            None => NOMINAL_PERIOD_S,
            Some(last_us) => seconds(now_us.saturating_sub(last_us)).min(LONGEST_PERIOD_S),
        }
    }

    /// A step without a state.
    pub fn coast(&mut self, now_us: u64) {
        self.last_step_us = Some(now_us);
    }

    /// Position, NED [m].
    pub fn p_ned(&self) -> Vector3<f64> {
        self.p_ned
    }

    /// The latest state, with its time [us].
    pub fn state(&self) -> Option<(u64, Measurement)> {
        self.state
    }

    /// Sets home, NED [m].
    pub fn set_home(&mut self, home_ned: Vector3<f64>) {
        self.home_ned = Some(home_ned);
    }

    /// Home, NED [m]; where the vehicle is becomes home if there is none.
    pub fn settle_home(&mut self) -> Vector3<f64> {
        *self.home_ned.get_or_insert(self.p_ned)
    }

    /// Position from home, NED [m].
    pub fn off_home_ned(&self) -> Vector3<f64> {
        self.p_ned - self.home_ned.unwrap_or(self.p_ned)
    }

    /// Home and the vehicle's velocity, NED [m, m/s], once both are known.
    pub fn home_and_velocity(&self) -> Option<(Vector3<f64>, Vector3<f64>)> {
        self.home_ned.zip(self.state.map(|(_, measurement)| measurement.v_ned))
    }
}
