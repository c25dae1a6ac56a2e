//! A drop flown by the model of PX4's control law ([`crate::control::px4`]), without a wire: as a streamer that holds to the
//! procedure of a drop under PX4 flies it. Level attitude without thrust is streamed until the rotors are free, the velocity from
//! then on; PX4 takes up velocity control [`SWITCH_S`] after the first velocity setpoint.

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::drop::{DropSimulation, Phase};
use super::flight::FlightPlan;
use super::record::Sample;
use crate::control::Measurement;
use crate::control::px4::{Law, Setpoint};
use crate::frames::LEVEL;
use crate::model::MAX_ROTORS;

/// From the first velocity setpoint to velocity control, in PX4's time [s]: its commander looks every 10 ms; 8 to 12 ms were measured.
pub const SWITCH_S: f64 = 0.01;

/// Flies from the simulation's present time: `plan.control_period_s` is the period of the IMU samples in the vehicle's time, the
/// law's similarity Froude's k = sqrt(g0/g) by which PX4's clock runs slower. PX4 takes its velocity for what it is plus
/// `v_error_ned` [m/s]. `observe` as in [`super::flight::fly`].
pub fn fly_px4(
    sim: &mut DropSimulation,
    law: &mut Law,
    plan: &FlightPlan<'_>,
    v_error_ned: Vector3<f64>,
    observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
) -> ControlFlow<()> {
    let dt = plan.control_period_s;
    let switch_s = SWITCH_S * law.similarity();
    let mut throttle = [0.0; MAX_ROTORS];
    let mut v_sp_ned = None;
    for _ in 0..plan.steps() {
        let setpoint = match (sim.phase(), sim.time_powered_s()) {
            (Phase::Powered, Some(t)) if t >= switch_s => {
                let (v_ned, a_ff_ned) = plan.setpoint_at(t);
                v_sp_ned = Some(v_ned);
                Setpoint::Velocity { v_ned, a_ff_ned, yaw_rad: None }
            }
            _ => Setpoint::Attitude(LEVEL, 0.0),
        };
        let body = &sim.state().body;
        let m = Measurement {
            q_ned_from_body: body.q_ned_from_body,
            v_ned: body.v_ned + v_error_ned,
            omega_body: body.omega_body,
        };
        throttle = law.step(&m, &setpoint, dt);
        let before = sim.moment();
        let instant = sim.advance(&throttle, dt);
        observe(&before.sample(instant, &throttle, v_sp_ned))?;
    }
    observe(&sim.sample(&throttle, v_sp_ned))
}
