//! The setpoints of a flight, one per control step, tabulated once for all flights of a batch.

use super::NotPlanar;
use crate::sim::FlightPlan;

/// Lateral parts below this are rounding [m/s, m/s^2].
const SIDEWAYS: f64 = 1e-9;

/// Most control steps of a table; keeps its size within reason.
const MOST_STEPS: u64 = 10_000_000;

/// Setpoints of velocity [m/s] and fed-forward acceleration [m/s^2], north and down.
#[derive(Clone, Debug, PartialEq)]
pub struct SetpointTable {
    period_s: f64,
    setpoints: Vec<Setpoint>,
}

/// Velocity [m/s] and fed-forward acceleration [m/s^2], north and down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setpoint {
    pub(super) v_n: f64,
    pub(super) v_d: f64,
    pub(super) a_n: f64,
    pub(super) a_d: f64,
}

impl SetpointTable {
    /// Tabulates a plan of flight.
    ///
    /// # Errors
    /// [`NotPlanar`] when the control period is not positive, the flight is longer than ten million steps, or
    /// setpoints or heading leave the plane.
    pub fn new(plan: &FlightPlan<'_>) -> Result<Self, NotPlanar> {
        let period_s = plan.control_period_s;
        if !(period_s.is_finite() && period_s > 0.0) {
            return Err(NotPlanar::OutOfRange {
                what: "control period",
                expected: "a positive time in seconds",
                value: period_s,
            });
        }
        if plan.yaw_sp_rad != Some(0.0) {
            return Err(NotPlanar::Sideways { what: "the heading" });
        }
        let steps = plan.steps();
        if steps > MOST_STEPS {
            return Err(NotPlanar::OutOfRange {
                what: "length of the flight",
                expected: "at most ten million control periods",
                value: plan.duration_s,
            });
        }
        let setpoint = |step: u64| {
            let (v_ned, a_ned) = plan.setpoint_at(step as f64 * period_s);
            // A plan solved in space is in the plane to rounding.
            if !(v_ned.y.abs() < SIDEWAYS && a_ned.y.abs() < SIDEWAYS) {
                return Err(NotPlanar::Sideways { what: "the reference" });
            }
            Ok(Setpoint { v_n: v_ned.x, v_d: v_ned.z, a_n: a_ned.x, a_d: a_ned.z })
        };
        Ok(Self { period_s, setpoints: (0..steps).map(setpoint).collect::<Result<_, _>>()? })
    }

    /// Control period [s].
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Number of control periods of a flight.
    pub fn steps(&self) -> usize {
        self.setpoints.len()
    }

    pub(super) fn setpoints(&self) -> &[Setpoint] {
        &self.setpoints
    }
}
