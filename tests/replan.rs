//! Plans renewed during a drop: against the plan itself where nothing is otherwise than planned, and on the
//! wire in memory.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use samara::config::{Mission, UnfitReplan, load_mission};
use samara::link::parties::{self, StreamerChoice};
use samara::link::streamer::SolvedBy;
use samara::link::{Lockstep, StreamerEvent};
use samara::model::rigid_body::BodyState;
use samara::plan::{Guess, Plan, SolverOptions, Status, plan};
use samara::replan::{Cadence, Kept, ReplanRequest, ReplanSettings, ReplanSetup};
use samara::report::{FlownDrop, judge_drop};
use samara::study::effects::EffectFlights;
use samara::study::replan::{ReplanFlights, ReplanRow};

/// The lander before its design: its plan ends in a terminal set, and feeds nothing forward.
const LANDER: &str = "tests/data/reference_drop.json";

fn planned(name: &str) -> (Arc<Mission>, Plan) {
    let mission =
        if name == LANDER { load_mission(Path::new(name)).unwrap() } else { Mission::shipped(name).unwrap() };
    let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(plan.status, Status::Converged);
    (Arc::new(mission), plan)
}

fn setup(name: &str, cadence: Cadence) -> ReplanSetup {
    let (source, plan) = planned(name);
    let settings = source.replan.settings;
    ReplanSetup { source, plan, cadence, settings }
}

/// Bellman's principle: the plan that begins at a state of a plan is the rest of that plan. Its nodes lie
/// closer, so it is the same to the discretisation: to 0.04 m/s of speeds up to 6.6 m/s where the thrusts
/// rise, less later; and where nothing has passed, to the tolerance of the solves.
#[test]
fn prop_a_plan_renewed_where_it_was_is_the_rest_of_it() {
    let setup = setup(LANDER, Cadence::Hz(1.0));
    let plan = &setup.plan.trajectory;
    for (passed_s, within_m_s) in [(0.0, 1e-5), (0.6, 0.05), (3.0, 0.03), (9.0, 6e-3), (18.0, 3e-3)] {
        let seen = BodyState {
            p_ned: nalgebra::Vector3::zeros(),
            q_ned_from_body: samara::frames::normalized(plan.attitude(passed_s)),
            v_ned: plan.velocity_ned(passed_s),
            omega_body: plan.body_rates(passed_s),
        };
        let request = ReplanRequest {
            number: 0,
            seen_s: passed_s,
            seen,
            takes_effect_s: passed_s,
            in_force: plan.clone(),
        };
        let answer = setup.renewal().answer(&request);
        let renewed = answer.found.unwrap();
        assert_eq!(renewed.nodes()[0].t_s, passed_s);
        assert!((renewed.end_s() - plan.end_s()).abs() < 1e-12);
        let off = (0..=300).map(|i| passed_s + (30.0 - passed_s) * f64::from(i) / 300.0);
        let off = off.map(|t| (renewed.velocity_ned(t) - plan.velocity_ned(t)).norm()).fold(0.0, f64::max);
        assert!(off <= within_m_s, "{passed_s}: off {off}");
        assert!(answer.iterations <= 8, "{passed_s}: {} iterations", answer.iterations);
    }
}

/// A release far from the plan's is another problem's beginning, with other bounds active: the renewal is
/// solved within its iterations all the same, and is the plan of a solve that knew none.
#[test]
fn reference_a_plan_from_far_off_is_that_of_a_cold_solve() {
    let setup = setup("titan_paper", Cadence::Release);
    for (pitch_rad, rate_rad_s) in [(0.15, 0.33), (0.1, -0.25), (-0.1, 0.1), (0.0, -0.15)] {
        let seen = BodyState {
            p_ned: nalgebra::Vector3::zeros(),
            q_ned_from_body: samara::frames::quaternion_from_euler(0.0, pitch_rad, 0.0),
            v_ned: nalgebra::Vector3::new(0.06, 0.0, 3.66),
            omega_body: nalgebra::Vector3::new(0.0, rate_rad_s, 0.0),
        };
        let in_force = setup.plan.trajectory.clone();
        let request = ReplanRequest { number: 0, seen_s: 0.0, seen, takes_effect_s: 0.0, in_force };
        let answer = setup.renewal().answer(&request);
        let renewed = answer.found.unwrap();
        let (q, v) = (seen.q_ned_from_body, seen.v_ned);
        let problem =
            setup.source.problem_from([q[0], q[1], q[2], q[3], v.x, v.y, v.z, 0.0, rate_rad_s, 0.0]);
        let cold = plan(&problem, &Guess::StraightLine, &SolverOptions::default(), &mut |_| {
            ControlFlow::Continue(())
        });
        let cold = cold.unwrap();
        assert_eq!(cold.status, Status::Converged);
        let off = (0..=300).map(|i| 0.1 * f64::from(i));
        let off = off.map(|t| (renewed.velocity_ned(t) - cold.trajectory.velocity_ned(t)).norm());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-4, "{pitch_rad}: off {off}");
    }
}

/// Too few iterations are no plan.
#[test]
fn a_plan_that_is_not_solved_is_kept() {
    let mut setup = setup("titan_drop", Cadence::Release);
    setup.settings = ReplanSettings { iterations: 1, ..setup.settings };
    let seen = BodyState {
        p_ned: nalgebra::Vector3::zeros(),
        q_ned_from_body: samara::frames::quaternion_from_euler(0.0, 0.2, 0.0),
        v_ned: nalgebra::Vector3::new(0.5, 0.2, 3.5),
        omega_body: nalgebra::Vector3::new(0.0, 0.1, 0.0),
    };
    let in_force = setup.plan.trajectory.clone();
    let request = ReplanRequest { number: 3, seen_s: -0.4, seen, takes_effect_s: 0.0, in_force };
    let answer = setup.renewal().answer(&request);
    let limit = Kept::Unsolved { status: Status::IterationLimit, iterations: 1 };
    assert_eq!((answer.number, answer.found), (3, Err(limit)));
}

/// A drop by the reference autopilot on the wire in memory, its plan renewed from telemetry.
fn dropped(name: &str, cadence: Cadence) -> (f64, bool, Vec<samara::replan::ReplanRecord>, Vec<String>) {
    let setup = setup(name, cadence);
    let mission = Mission::shipped(name).unwrap();
    let (autopilot, _) = parties::autopilot(&mission, None, false, 1).unwrap();
    let choice =
        StreamerChoice { replan: Some((setup.clone(), SolvedBy::Session)), ..StreamerChoice::default() };
    let plan = setup.plan.trajectory.clone();
    let streamer = parties::streamer(&mission, plan.clone(), 1, choice);
    let mut wire = Lockstep::new(parties::simulator(&mission, 1, None, None), autopilot, streamer);
    let mut said = Vec::new();
    while wire.step(&mut |_, _, _| ()).unwrap() {
        while let Some(event) = wire.streamer.poll_event() {
            if let StreamerEvent::Replanned(_) = event.event {
                said.push(event.to_string());
            }
        }
    }
    let replans = wire.streamer.replans().to_vec();
    let record = wire.simulator.run().record().clone();
    let log = wire.simulator.into_run().into_log();
    let over = FlownDrop { log: &log, record: &record, plan: Some(&plan), by: None, trouble: None };
    let (verdict, run) = judge_drop(&mission, &over);
    (verdict.as_ref().unwrap().outcome.j_tpf, run.is_safe(verdict.as_ref()), replans, said)
}

/// On Earth, at the release and twice a second until 2 s of the plan's 5 s: what the streamer reads off the
/// wire is enough to renew the plan each time, within 20 ms of simulated time.
#[test]
fn plans_are_renewed_from_telemetry() {
    let (_, safe, replans, said) = dropped("x500_drop", Cadence::Release);
    assert!(safe);
    assert_eq!((replans.len(), said.len()), (1, 1), "{said:?}");
    assert_eq!((replans[0].takes_effect_s, replans[0].kept.clone()), (0.0, None));
    assert!((-0.5..-0.47).contains(&replans[0].seen_s), "{replans:?}");
    let (_, safe, replans, _) = dropped("x500_drop", Cadence::Hz(2.0));
    assert!(safe);
    assert_eq!(replans.len(), 5, "{replans:?}");
    assert!(replans.iter().all(|replan| replan.kept.is_none()), "{replans:?}");
    assert!(
        replans.iter().all(|r| (r.takes_effect_s - (r.seen_s + 0.02).max(0.0)).abs() < 1e-9),
        "{replans:?}"
    );
}

/// A plan that is not renewed is flown as `study effects` flies it, which knows nothing of renewals.
#[test]
fn reference_one_plan_is_flown_as_it_ever_was() {
    let (mission, plan) = planned(LANDER);
    let own = (mission.control.gains_name.as_str(), &mission.control.gains);
    let rows = ReplanRow::campaigns(&mission, &[Cadence::Release], own);
    let names: Vec<String> = rows.iter().map(ReplanRow::name).collect();
    assert_eq!(names, ["once", "once_fed_forward", "release"]);
    let beside = EffectFlights::new(&mission, &mission.effects(), &plan.trajectory).unwrap();
    let once = ReplanFlights::new(&mission, &plan, &rows[0]).unwrap();
    let released = ReplanFlights::new(&mission, &plan, &rows[2]).unwrap();
    for trial in [0, 5] {
        let flown = once.fly(trial);
        assert_eq!(flown.drop, beside.fly(trial));
        assert_eq!((flown.renewed, flown.kept), (0, 0));
        assert_eq!(released.fly(trial).renewed, 1);
    }
}

/// By hand: what cannot be renewed, and how often a plan can be.
#[test]
fn plans_that_cannot_be_renewed_are_refused() {
    let mut mission = Mission::shipped("titan_drop").unwrap();
    assert_eq!(mission.check_replan(Cadence::Hz(50.0)), Ok(()));
    mission.replan.settings.latency_s = 0.1;
    assert!(matches!(mission.check_replan(Cadence::Hz(11.0)), Err(UnfitReplan::Rate { most_hz: 10.0, .. })));
    mission.plan.demands.motion.altitude_lost_m = Some(100.0);
    assert_eq!(mission.check_replan(Cadence::Release), Ok(()));
    let refused = mission.check_replan(Cadence::Hz(1.0)).unwrap_err().to_string();
    assert!(refused.starts_with("plan.motion.altitude_lost_m: "), "{refused}");
    mission.release.standing = true;
    assert_eq!(mission.check_replan(Cadence::Release), Err(UnfitReplan::Standing));
}
