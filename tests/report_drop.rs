//! Logs and figures of the nominal drop.
#![cfg(feature = "files")]

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::LazyLock;

use nalgebra::Vector3;
use samara::assess::{Verdict, VerdictBuilder, plan_j_tpf};
use samara::config::{Mission, Stamp, load_mission};
use samara::control::{Airframe, Cascade};
use samara::model::MAX_ROTORS;
use samara::plan::{Guess, InputReference, Plan, PlanProblem, SolverOptions, plan};
use samara::report::{DropRun, FlightCsv};
use samara::report::{drop_figure, drop_json, plan_figure, plan_json, plan_text, verdict_text};
use samara::sim::{DropSimulation, FlightPlan, Reference, Sample, fly};

struct Drop {
    mission: Mission,
    plan: Plan,
    samples: Vec<Sample>,
    verdict: Verdict,
}

static DROP: LazyLock<Drop> = LazyLock::new(|| dropped("mission/titan_drop.json"));

fn planned(mission: &Mission) -> Plan {
    let (body, _) = mission.parachute.hanging(0.0);
    let v = body.v_ned + mission.environment.gravity_ned() * mission.parachute.delay_s;
    let q = body.q_ned_from_body;
    let w = body.omega_body;
    let problem = PlanProblem {
        vehicle: &mission.vehicle,
        environment: &mission.environment,
        initial: [q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z],
        initial_thrust_n: [0.0; MAX_ROTORS],
        target_v_ned: mission.target_v_ned,
        x_ss: mission.x_ss,
        horizon_s: mission.horizon_s,
        nodes: mission.nodes,
        thrust_max_n: mission.thrust_max_n,
        thrust_rate_n_s: mission.thrust_slew_n_s,
        cost_state: mission.cost_state,
        cost_input: mission.cost_input,
        input_reference: InputReference::Zero,
        terminal_velocity_tolerance_m_s: None,
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    plan(&problem, &Guess::StraightLine, &SolverOptions::default(), go_on).unwrap()
}

fn dropped(path: &str) -> Drop {
    let mission = load_mission(Path::new(path)).unwrap();
    let plan = planned(&mission);
    let (vehicle, environment) = (mission.vehicle.clone(), mission.environment.clone());
    let airframe = Airframe::new(&vehicle, &environment).unwrap();
    let mut cascade = Cascade::new(airframe, mission.gains, mission.control_limits);
    let mut sim =
        DropSimulation::new(vehicle, environment, mission.parachute.clone(), mission.hang_s, mission.start);
    sim.schedule_release(mission.hang_s);
    let flight = FlightPlan {
        reference: Reference::Plan {
            trajectory: &plan.trajectory,
            then_v_ned: Some(mission.target_v_ned),
            feed_forward: false,
        },
        yaw_sp_rad: 0.0,
        control_period_s: 0.004,
        setpoint_period_s: Some(0.02),
        duration_s: mission.duration_s,
    };
    let mut samples = Vec::new();
    let mut builder = VerdictBuilder::new(mission.limits, mission.target_v_ned);
    let _ = fly(&mut sim, &mut cascade, &flight, &mut |s| {
        builder.observe(s);
        samples.push(*s);
        ControlFlow::Continue(())
    });
    Drop { mission, plan, samples, verdict: builder.finish().unwrap() }
}

fn stamp(mission: &Mission) -> Stamp {
    Stamp { seed: mission.seed, input_hash: mission.input_hash.clone() }
}

impl Drop {
    fn figure(&self) -> String {
        drop_figure(&self.mission, &self.samples, Some(&self.plan.trajectory), Some(&self.verdict)).unwrap()
    }

    fn plan_figure(&self) -> String {
        plan_figure(&self.mission, &self.plan.trajectory).unwrap()
    }

    fn csv(&self) -> Vec<u8> {
        let n = self.mission.vehicle.rotors.len();
        let mut csv = FlightCsv::new(Vec::new(), n, self.mission.limits, &stamp(&self.mission)).unwrap();
        for sample in &self.samples {
            csv.write(sample).unwrap();
        }
        csv.finish().unwrap()
    }
}

#[test]
fn scratch_write_figures() {
    std::fs::create_dir_all("/tmp/fig").unwrap();
    std::fs::write("/tmp/fig/drop.svg", DROP.figure()).unwrap();
    std::fs::write("/tmp/fig/plan.svg", DROP.plan_figure()).unwrap();
    let t = std::time::Instant::now();
    let csv = DROP.csv();
    println!("csv {} bytes {:?}", csv.len(), t.elapsed());
    let t = std::time::Instant::now();
    let f = DROP.figure();
    println!("figure {} bytes {:?}", f.len(), t.elapsed());
    std::fs::write("/tmp/fig/drop.csv", csv).unwrap();
    println!("{}", verdict_text(&DROP.verdict, &DROP.mission.limits));
    println!("{}", plan_text(&DROP.plan, &DROP.mission.limits, Some(4.0)));
    println!("{}", drop_json(&DROP.mission, &DROP.verdict, &DropRun::default()));
    println!("{}", plan_json(&DROP.mission, &DROP.plan, None));
    println!("{}", plan_j_tpf(&DROP.plan.trajectory, &DROP.mission.limits));
    let x = dropped("mission/x500_drop.json");
    std::fs::write("/tmp/fig/x500.svg", x.figure()).unwrap();
    std::fs::write("/tmp/fig/x500_plan.svg", x.plan_figure()).unwrap();
    let _ = Vector3::<f64>::zeros();
}
