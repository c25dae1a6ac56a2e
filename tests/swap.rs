//! The four swap axes from outside the crate: the recipes of ARCHITECTURE.md, kept true.
#![cfg(all(feature = "files", feature = "link"))]

use std::collections::VecDeque;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use nalgebra::{Matrix3, SVector, Vector3};
use samara::assess::{SafetyStudy, StudyEntry, StudyReference};
use samara::autopilot::parameters::Parameters;
use samara::config::{Mission, load_mission};
use samara::control::{Airframe, Cascade, ControlSettings};
use samara::link::{
    AutopilotSession, AutopilotSetup, Decoder, Frame, HilConfig, HilSession, Link, Lockstep, Session,
    StreamerConfig, StreamerSession, Transmit,
};
use samara::model::rigid_body::{BodyState, MassProperties};
use samara::model::{Interference, MAX_ROTORS, RotationSense, RotorMount, Vehicle, trim};
use samara::plan::dynamics::{Curvature, Dynamics, Linearisation};
use samara::plan::problem::{Bounds, Nodes, Problem, QuadraticCost};
use samara::plan::solver::{SolverOptions, StartFrom, Status, solve};
use samara::plan::{Guess, plan};
use samara::sim::{DropSimulation, FlightPlan, Phase, PlantKind, Reference, fly};
use samara::trajectory::{Node, Trajectory};
use samara::tune::GainJudge;
use samara::tune::gain_judge::Setting;

#[path = "../examples/own_controller.rs"]
#[expect(dead_code, reason = "the example's main")]
mod own_controller;

/// Controller: the regulator of `examples/own_controller.rs` through the study, a campaign and the lockstep
/// wire. Steady at the target means within 1 % of it.
#[test]
fn another_controller_flies_study_campaign_and_wire() {
    let mission = titan();
    let plan = own_controller::planned(&mission).unwrap();
    let lqr = own_controller::Lqr::new(&mission).unwrap();
    let (cases, campaign) = own_controller::study(&mission, &plan, &lqr, 20);
    assert!(cases.len() == 7 && cases.iter().all(|j_tpf| *j_tpf < 0.9), "{cases:?}");
    assert!(campaign.count() == 20 && campaign.max() < 0.9, "{campaign:?}");
    let verdict = own_controller::drop_over_the_wire(&mission, &plan, &lqr).unwrap();
    assert!(verdict.outcome.j_tpf < 0.9 && verdict.limits_passed.is_empty(), "{verdict:?}");
    assert!(verdict.outcome.steady_after_s.is_some_and(|t_s| t_s < 34.0), "{verdict:?}");
}

/// Controller: the same regulator under the judge that gains are tuned on, whose flights are the study's.
/// Both take the RMS at the period that divides the plan's intervals, the study the rest at 10 ms: close by.
#[test]
fn another_controller_is_judged_by_the_flights_of_the_study() {
    let mission = titan();
    let plan = own_controller::planned(&mission).unwrap();
    let lqr = own_controller::Lqr::new(&mission).unwrap();
    let setting = Setting {
        scenario: mission.scenario(),
        control_limits: mission.control.limits,
        plant: PlantKind::Actuator,
        yaw: mission.control.gains,
        plan: &plan,
        feed_forward: false,
        settle_s: 0.0,
    };
    let cases = &mission.study.cases;
    let judged = GainJudge::new(setting).unwrap().with_cases(cases).evaluate_controller(&lqr);

    let study = SafetyStudy { settle_s: 0.0, ..mission.safety_study(&plan) };
    let entry = StudyEntry {
        name: "lqr",
        gains_name: "lqr".to_owned(),
        controller: Box::new(lqr),
        reference: StudyReference::Optimal,
    };
    let worst = |cost: &dyn Fn(&BodyState) -> f64| cases.iter().map(|c| cost(&c.state())).fold(0.0, f64::max);
    let outcome = |start: &BodyState| study.outcome(&entry, start);
    let target = mission.target_v_ned;
    let rms = worst(&|start| study.tracking_rms(&entry, start));
    let j_tpf = worst(&|start| outcome(start).j_tpf);
    let unrest = worst(&|start| (outcome(start).final_v_ned() - target).norm() / target.norm());
    assert!(rms > 0.1 && j_tpf > 0.1 && unrest > 0.02, "{rms} {j_tpf} {unrest}");
    assert_eq!(judged.rms, rms);
    assert!((judged.j_tpf - j_tpf).abs() < 1e-4, "{judged:?}, the study's J_TPF {j_tpf}");
    assert!((judged.unrest - unrest).abs() < 1e-4, "{judged:?}, at the study's end {unrest}");
}

fn titan() -> Mission {
    load_mission(Path::new("mission/titan_paper.json")).unwrap()
}

fn drop_of(mission: &Mission) -> DropSimulation {
    DropSimulation::new(
        mission.vehicle.clone(),
        mission.site.environment.clone(),
        mission.release.parachute,
        mission.release.hang_s,
        mission.release.start,
    )
}

/// Vehicle: a hexacopter built in code, planned and flown like any other.
#[test]
fn another_vehicle_is_planned_and_flown() {
    let mut mission = titan();
    let spins = [
        RotationSense::Ccw,
        RotationSense::Cw,
        RotationSense::Ccw,
        RotationSense::Cw,
        RotationSense::Ccw,
        RotationSense::Cw,
    ];
    let rotors = (0..6)
        .map(|i| {
            let angle = std::f64::consts::FRAC_PI_3 * (f64::from(i) + 0.5);
            RotorMount {
                position_body_m: Vector3::new(1.4 * angle.cos(), 1.4 * angle.sin(), 0.0),
                axis_body: -Vector3::z(),
                spin: spins[i as usize],
                interference: Interference::NONE,
            }
        })
        .collect();
    let old = &mission.vehicle;
    let mass =
        MassProperties::new(1100.0, Matrix3::from_diagonal(&Vector3::new(900.0, 900.0, 1500.0))).unwrap();
    let vehicle =
        Vehicle::new(mass, rotors, old.aero.clone(), old.rotor.clone(), old.motor.clone(), old.options)
            .unwrap();
    mission.vehicle = Arc::new(vehicle);
    mission.plan.x_ss = None;
    let plan = plan(&mission.plan_problem(), &Guess::StraightLine, &SolverOptions::default(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap();
    assert_eq!(plan.status, Status::Converged, "{:?}", plan.diagnosis);
    let airframe = Airframe::new(&mission.vehicle, &mission.site.environment).unwrap();
    let mut cascade = Cascade::new(airframe, mission.control.gains, mission.control.limits);
    let mut sim = drop_of(&mission);
    sim.schedule_release(mission.release.hang_s);
    let flight = FlightPlan::new(
        Reference::Plan {
            trajectory: &plan.trajectory,
            then_v_ned: Some(mission.target_v_ned),
            feed_forward: false,
        },
        0.01,
        mission.duration_s,
    );
    let mut end = Vector3::zeros();
    let _ = fly(&mut sim, &mut cascade, &flight, &mut |sample| {
        end = sample.state.body.v_ned;
        ControlFlow::Continue(())
    });
    assert!((end - mission.target_v_ned).norm() < 0.1, "{end}");
}

/// Controller: any function from state to throttles. Here a proportional law on the descent, rotors all
/// alike.
#[test]
fn another_controller_flies_the_simulation() {
    let mission = titan();
    let mut sim = drop_of(&mission);
    sim.schedule_release(0.0);
    for _ in 0..6000 {
        let mut throttle = [0.0; MAX_ROTORS];
        if sim.phase() == Phase::Powered {
            let too_fast = sim.state().body.v_ned.z - 4.0;
            throttle[..4].fill((0.78 + 0.3 * too_fast).clamp(0.0, 1.0));
        }
        sim.step(&throttle, 0.005);
    }
    let v_down = sim.state().body.v_ned.z;
    assert!((v_down - 4.0).abs() < 0.3, "{v_down}");
}

/// Planner: anything that makes a trajectory. Here a straight ramp to the target.
fn ramp(mission: &Mission) -> Trajectory {
    let at_trim = trim(&mission.vehicle, &mission.site.environment, mission.target_v_ned, 0.0).unwrap();
    let start =
        Vector3::new(0.0, 0.0, mission.release.parachute.v0_m_s(mission.site.environment.gravity_m_s2));
    let node = |t_s: f64, v_ned: Vector3<f64>| Node {
        t_s,
        q_ned_from_body: at_trim.q_ned_from_body,
        v_ned,
        omega_body: Vector3::zeros(),
        thrust_n: at_trim.thrust_n,
        a_ned: (mission.target_v_ned - start) / 20.0,
    };
    Trajectory::new(vec![node(0.0, start), node(20.0, mission.target_v_ned)], 4).unwrap()
}

/// A solver of another system: the double integrator, to a closed form. Minimising `x(1)' S x(1)` with heavy
/// S from rest at 1 with an input that costs little brings it to the origin.
#[test]
fn other_dynamics_are_solved() {
    struct DoubleIntegrator;
    impl Dynamics<2, 1> for DoubleIntegrator {
        fn value(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> SVector<f64, 2> {
            SVector::from([x[1], u[0]])
        }
        fn linearise(&self, x: &SVector<f64, 2>, u: &SVector<f64, 1>) -> Linearisation<2, 1> {
            let a = nalgebra::Matrix2::new(0.0, 1.0, 0.0, 0.0);
            Linearisation { f: self.value(x, u), a, b: SVector::from([0.0, 1.0]) }
        }
        fn curvature(
            &self,
            _: &SVector<f64, 2>,
            _: &SVector<f64, 1>,
            _: &SVector<f64, 2>,
        ) -> Curvature<2, 1> {
            Curvature::zero()
        }
    }
    let intervals = 100;
    let cost = QuadraticCost::new(
        (SVector::zeros(), SVector::zeros()),
        SVector::zeros(),
        SVector::from([1.0]),
        SVector::from([1e7, 1e7]),
    );
    let bounds = Bounds::on_input(SVector::from([-50.0]), SVector::from([50.0]), SVector::from([1e4]));
    let start = (SVector::from([1.0, 0.0]), SVector::from([-6.0]));
    let problem = Problem::new(DoubleIntegrator, start, (intervals, 1.0 / intervals as f64), cost, bounds);
    let guess =
        Nodes { x: vec![problem.x_initial; intervals + 1], u: vec![problem.u_initial; intervals + 1] };
    let options = SolverOptions { tolerance: 1e-7, ..SolverOptions::default() };
    let solution =
        solve(&problem, StartFrom::Guess(guess), &options, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(solution.status, Status::Converged);
    // Minimum energy from rest at 1 to rest at 0 in unit time: u = -6 + 12 t, cost 12.
    assert!((solution.objective - 12.0).abs() < 0.01, "{}", solution.objective);
}

/// A party behind another transport: everything it hears and says passes a byte pipe that cuts at odd places.
struct Piped {
    inner: AutopilotSession,
    decoder: Decoder,
    out: VecDeque<Transmit>,
}

impl Session for Piped {
    fn handle_input(&mut self, link: Link, frame: &Frame) {
        let bytes = frame.bytes().to_vec();
        let Self { inner, decoder, .. } = self;
        for chunk in bytes.chunks(7) {
            decoder.push(chunk);
            while let Some(frame) = decoder.next_frame() {
                inner.handle_input(link, &frame);
            }
        }
        while let Some(sent) = self.inner.poll_output() {
            self.out.push_back(sent);
        }
    }
    fn handle_time(&mut self, now: u64) {
        self.inner.handle_time(now);
        while let Some(sent) = self.inner.poll_output() {
            self.out.push_back(sent);
        }
    }
    fn next_wake(&self) -> Option<u64> {
        self.inner.next_wake()
    }
    fn poll_output(&mut self) -> Option<Transmit> {
        self.out.pop_front()
    }
}

/// Transport and planner at once: a ramp as the plan, the autopilot behind a byte pipe; the flight is the
/// same to the bit as on the direct wire.
#[test]
fn another_transport_and_another_planner_fly_the_same_drop() {
    let mission = titan();
    let autopilot = || {
        let airframe = Airframe::new(&mission.vehicle, &mission.site.environment).unwrap();
        AutopilotSession::new(AutopilotSetup {
            system_id: 1,
            control: ControlSettings {
                airframe,
                gains: mission.control.gains,
                limits: mission.control.limits,
            },
            controller: None,
            environment: mission.site.environment.clone(),
            estimator: None,
            rotors: 4,
            epoch_unix_us: mission.epoch_unix_us,
            parameters: Parameters::of(&mission.parameter_subject(), 1).unwrap(),
            keeps_parameters: false,
        })
    };
    let simulator = || HilSession::new(drop_of(&mission), HilConfig::default());
    let streamer = || {
        let config = StreamerConfig {
            hang_s: mission.release.hang_s,
            delay_s: mission.release.parachute.delay_s,
            target_v_ned: mission.target_v_ned,
            ..StreamerConfig::default()
        };
        StreamerSession::new(config, ramp(&mission))
    };
    let mut direct = Lockstep::new(simulator(), autopilot(), streamer());
    direct.run(&mut |_, _, _| {}).unwrap();
    let piped = Piped { inner: autopilot(), decoder: Decoder::new(), out: VecDeque::new() };
    let mut through_pipe = Lockstep::new(simulator(), piped, streamer());
    through_pipe.run(&mut |_, _, _| {}).unwrap();
    let (a, b) = (direct.simulator.run().log(), through_pipe.simulator.run().log());
    assert_eq!(a.len(), b.len());
    let end = a.last().unwrap().state.body.v_ned;
    assert!((end - mission.target_v_ned).norm() < 0.1, "{end}");
    assert_eq!(a.last().unwrap().state, b.last().unwrap().state);
}
