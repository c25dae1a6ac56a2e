//! Verification of the core: its results against NASA's check cases and closed forms.
//!
//! | file | holds |
//! |---|---|
//! | [`check`] | a check and its verdict; groups of them |
//! | [`motion`] | a rigid body under a given force and moment, by the simulator's own integrator |
//! | [`nasa`] | the 6-DOF check cases 2, 3, 4, 6, 7 and 8 of NASA/TM-2015-218675 |
//! | [`body`] | free fall, precession, what a tumble conserves |
//! | [`fall`] | terminal velocity under drag |
//! | [`batch`] | such falls on the batch engine |
//! | [`wind`] | drift with the wind, turbulence, gusts |
//! | [`swing`] | the pendulum under the canopy |
//! | [`two_bodies`] | vehicle and canopy under one riser |
//! | [`rotor_start`] | rotors that nobody drives, and their start |
//! | [`angular_momentum`] | the rotors' angular momentum |
//! | [`momentum`] | a rotor's thrust and torque by momentum theory |
//! | [`blades`] | a rotor with known blades between the knots of its table |
//! | [`steady`] | trim and the motors' steady states |
//! | [`power`] | battery and bus |
//! | [`cascade`] | small steps under the paper's controller |
//! | [`optimum`] | optimal transfers by the planner's solver |
//! | [`order`] | orders of convergence of integrator and collocation |
//!
//! The code under test is the code that flies: `model::rigid_body`, `frames`, `sim`'s integrator and plant,
//! the vehicle's own tables, `plan`'s transcription. Only what a case has around it (a round, turning Earth,
//! the standard atmosphere) lives here.

pub mod angular_momentum;
pub mod batch;
pub mod blades;
pub mod body;
pub mod cascade;
pub mod check;
pub mod fall;
pub mod momentum;
pub mod motion;
pub mod nasa;
pub mod optimum;
pub mod order;
pub mod power;
pub mod rotor_start;
pub mod steady;
pub mod swing;
pub mod two_bodies;
pub mod wind;

pub use check::{Check, CheckGroup, VerifyError};

use crate::plan::PlanProblem;

/// All checks, group by group. `lander` is the vehicle with speed controllers and a rotor table
/// (`mission/titan_paper.json`), `quadrotor` the one with known blades and first-order motors
/// (`mission/x500_drop.json`).
///
/// # Errors
/// [`VerifyError`] when a vehicle cannot be checked at all.
pub fn verify(lander: &PlanProblem<'_>, quadrotor: &PlanProblem<'_>) -> Result<Vec<CheckGroup>, VerifyError> {
    use nasa::wind::{WINDS_FT_S, cases_6_to_8};
    use nasa::{Brick, Earth, case_2, case_3, case_4};
    Ok(vec![
        case_2(&Earth::WGS_84, &Brick::CASE_2)?,
        case_3(&Earth::WGS_84, &Brick::CASE_3)?,
        case_4(&Earth::SPHERE, &Brick::SPHERE)?,
        cases_6_to_8(&Earth::WGS_84, &Brick::SPHERE, &WINDS_FT_S)?,
        body::free_fall(lander.environment.gravity_m_s2)?,
        body::precession()?,
        body::tumble(&lander.vehicle.mass),
        fall::under_drag(lander.vehicle, lander.environment),
        batch::falls(lander.vehicle, lander.environment),
        wind::drift(lander.vehicle, lander.environment)?,
        wind::turbulence(lander.environment),
        wind::gusts(),
        swing::under_the_canopy(lander.vehicle, lander.environment)?,
        two_bodies::canopy_and_vehicle(lander.vehicle, lander.environment)?,
        momentum::rotor(&lander.vehicle.rotor, lander.environment.density_kg_m3, &momentum::LANDER),
        blades::between_knots(
            &quadrotor.vehicle.rotor,
            quadrotor.environment.density_kg_m3,
            &blades::QUADROTOR,
        )?,
        rotor_start::of_rotors()?,
        angular_momentum::without_air(quadrotor.vehicle, quadrotor.environment),
        steady::trim_at_target(lander, quadrotor)?,
        steady::motors(lander, quadrotor),
        power::supply(lander, quadrotor)?,
        cascade::small_steps(quadrotor.vehicle, quadrotor.environment)?,
        optimum::of_a_double_integrator()?,
        order::of_convergence(lander, quadrotor)?,
    ])
}
