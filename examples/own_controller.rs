//! A controller of your own in the safety study, in a Monte Carlo campaign and behind MAVLink: a
//! linear-quadratic regulator about the steady state that the drop shall reach.
//!
//! ```sh
//! cargo run --release --example own_controller
//! ```

#![expect(clippy::print_stdout, reason = "an example shows what came out")]

use std::ops::ControlFlow;

use nalgebra::{SMatrix, SVector, Vector3};
use samara::assess::{StudyEntry, StudyReference, Summary, Verdict, VerdictBuilder};
use samara::autopilot::parameters::Parameters;
use samara::config::{Mission, load_mission};
use samara::control::{Airframe, ControlOutput, ControlSettings, Controller, Measurement, Setpoint};
use samara::frames::{conjugate, product};
use samara::link::{
    AutopilotSession, AutopilotSetup, HilConfig, HilSession, Lockstep, StreamerConfig, StreamerSession,
};
use samara::model::{MAX_ROTORS, Trim, trim};
use samara::plan::dynamics::{Dynamics as _, VehicleDynamics};
use samara::plan::{Guess, SolverOptions, plan};
use samara::trajectory::Trajectory;

type Failure = Box<dyn std::error::Error>;

/// A regulator of `e = [v - v_sp, tilt, roll and pitch rate, integral of v - v_sp]` for a quadrotor: `T =
/// T_trim - K e`. The heading is left alone.
#[derive(Clone, Debug)]
pub struct Lqr {
    trim: Trim,
    gain: SMatrix<f64, 4, 10>,
    thrust_limit_n: f64,
    integral_ned_m: Vector3<f64>,
}

impl Lqr {
    /// The regulator about the mission's target velocity; `None` where there is no steady flight or not four
    /// rotors.
    pub fn new(mission: &Mission) -> Option<Self> {
        let (vehicle, site) = (&mission.vehicle, &mission.site.environment);
        let trim = trim(vehicle, site, mission.target_v_ned, 0.0).ok()?;
        // The planner's linearisation: states [q, v_ned, omega_body], inputs the four thrusts.
        let (q, v) = (trim.q_ned_from_body, trim.v_ned);
        let x = SVector::from([q[0], q[1], q[2], q[3], v.x, v.y, v.z, 0.0, 0.0, 0.0]);
        let u = SVector::<f64, 4>::from_column_slice(&trim.thrust_n[..4]);
        let at_trim = VehicleDynamics::<4>::new(vehicle, site)?.linearise(&x, &u);
        // Small turns about the body's x and y in place of the quaternion: dx = M e, e = M^-1 dx.
        let mut m = SMatrix::<f64, 10, 7>::zeros();
        m.fixed_view_mut::<3, 3>(4, 0).fill_with_identity();
        m.fixed_view_mut::<4, 1>(0, 3).copy_from_slice(&product(q, [0.0, 0.5, 0.0, 0.0]));
        m.fixed_view_mut::<4, 1>(0, 4).copy_from_slice(&product(q, [0.0, 0.0, 0.5, 0.0]));
        m.fixed_view_mut::<2, 2>(7, 5).fill_with_identity();
        let mut inverse = m.transpose();
        inverse.fixed_rows_mut::<2>(3).scale_mut(4.0);
        // A step of 10 ms, with the integral of the velocity error.
        const DT_S: f64 = 0.01;
        let mut a = SMatrix::<f64, 10, 10>::identity();
        let mut corner = a.fixed_view_mut::<7, 7>(0, 0);
        corner += inverse * at_trim.a * m * DT_S;
        a.fixed_view_mut::<3, 3>(7, 0).fill_diagonal(DT_S);
        let mut b = SMatrix::<f64, 10, 4>::zeros();
        b.fixed_view_mut::<7, 4>(0, 0).copy_from(&(inverse * at_trim.b * DT_S));
        // What is worth as much as a thrust of 50 N: m/s, rad, rad/s, m.
        let worth = SVector::from([1.0, 1.0, 0.2, 0.15, 0.15, 0.3, 0.3, 2.0, 2.0, 1.0]);
        let cost = SMatrix::from_diagonal(&worth.map(|w: f64| w.powi(-2)));
        let thrust_cost = SMatrix::<f64, 4, 4>::identity() / 50.0f64.powi(2);
        let (mut p, mut gain) = (cost, SMatrix::<f64, 4, 10>::zeros());
        for _ in 0..20_000 {
            let bp = b.transpose() * p;
            gain = (thrust_cost + bp * b).try_inverse()? * bp * a;
            p = cost + a.transpose() * p * (a - b * gain);
        }
        let thrust_limit_n = vehicle.static_thrust_n(site.density_kg_m3);
        Some(Self { trim, gain, thrust_limit_n, integral_ned_m: Vector3::zeros() })
    }
}

impl Controller for Lqr {
    fn reset(&mut self) {
        self.integral_ned_m = Vector3::zeros();
    }

    fn step(&mut self, measurement: &Measurement, setpoint: &Setpoint, dt_s: f64) -> ControlOutput {
        // Before the rotors are free: level attitude without thrust.
        let Setpoint::Velocity { v_ned, .. } = *setpoint else { return ControlOutput::ZERO };
        let e_v = measurement.v_ned - v_ned;
        let [_, x, y, _] = product(conjugate(self.trim.q_ned_from_body), measurement.q_ned_from_body);
        let (omega, i) = (measurement.omega_body, self.integral_ned_m);
        let e = [e_v.x, e_v.y, e_v.z, 2.0 * x, 2.0 * y, omega.x, omega.y, i.x, i.y, i.z];
        self.integral_ned_m += e_v * dt_s;
        let change_n = -(self.gain * SVector::from(e));
        let thrust_n = |i: usize| if i < 4 { self.trim.thrust_n[i] + change_n[i] } else { 0.0 };
        ControlOutput::from_thrusts(std::array::from_fn::<_, MAX_ROTORS, _>(thrust_n), self.thrust_limit_n)
    }
}

/// J_TPF of the mission's release cases and over `trials` random releases.
pub fn study(mission: &Mission, plan: &Trajectory, controller: &Lqr, trials: u64) -> (Vec<f64>, Summary) {
    let study = mission.safety_study(plan);
    let entry = StudyEntry {
        name: "lqr",
        gains_name: "lqr".to_owned(),
        controller: Box::new(controller.clone()),
        reference: StudyReference::Optimal,
    };
    let cases = mission.study.cases.iter().map(|case| study.outcome(&entry, &case.state()).j_tpf).collect();
    let releases: Vec<_> = (0..trials).map(|trial| mission.releases().draw(mission.seed, trial)).collect();
    let mut campaign = Summary::default();
    for outcome in study.fly_releases(&entry, &releases) {
        campaign.push(outcome.j_tpf);
    }
    (cases, campaign)
}

/// The whole drop in lockstep over MAVLink: simulator, the reference autopilot with this controller,
/// streamer.
pub fn drop_over_the_wire(
    mission: &Mission,
    plan: &Trajectory,
    controller: &Lqr,
) -> Result<Verdict, Failure> {
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment)?;
    let autopilot = AutopilotSession::new(AutopilotSetup {
        system_id: 1,
        control: ControlSettings { airframe, gains: mission.control.gains, limits: mission.control.limits },
        controller: Some(Box::new(controller.clone())),
        environment: mission.site.environment.clone(),
        estimator: None,
        rotors: mission.vehicle.rotors.len(),
        epoch_unix_us: mission.epoch_unix_us,
        parameters: Parameters::of(&mission.parameter_subject(), 1)?,
        keeps_parameters: false,
    });
    let streamer = StreamerConfig {
        hang_s: mission.release.hang_s,
        delay_s: mission.release.parachute.delay_s,
        target_v_ned: mission.target_v_ned,
        ..StreamerConfig::default()
    };
    let simulator = HilSession::new(mission.simulation(), HilConfig::default());
    let mut wire = Lockstep::new(simulator, autopilot, StreamerSession::new(streamer, plan.clone()));
    wire.run(&mut |_, _, _| {})?;
    let mut verdict = VerdictBuilder::judging(mission.limits, mission.target_v_ned).along(plan);
    wire.simulator.run().log().iter().for_each(|sample| verdict.observe(sample));
    verdict.finish().ok_or_else(|| "the vehicle was never released".into())
}

/// The mission's plan.
pub fn planned(mission: &Mission) -> Result<Trajectory, Failure> {
    let options = SolverOptions::default();
    let plan =
        plan(&mission.plan_problem(), &Guess::StraightLine, &options, &mut |_| ControlFlow::Continue(()))?;
    Ok(plan.trajectory)
}

fn main() -> Result<(), Failure> {
    let mission = load_mission("mission/titan_drop.json".as_ref())?;
    let plan = planned(&mission)?;
    let lqr = Lqr::new(&mission).ok_or("no regulator for this vehicle")?;
    let (cases, campaign) = study(&mission, &plan, &lqr, 100);
    println!("release cases: J_TPF {cases:.3?}");
    println!(
        "{} random releases: J_TPF {:.3}, at most {:.3}",
        campaign.count(),
        campaign.mean(),
        campaign.max()
    );
    let verdict = drop_over_the_wire(&mission, &plan, &lqr)?;
    println!(
        "drop over MAVLink: J_TPF {:.3}, steady after {:?} s",
        verdict.outcome.j_tpf, verdict.outcome.steady_after_s
    );
    Ok(())
}
