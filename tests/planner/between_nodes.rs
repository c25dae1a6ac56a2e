//! What flies between a plan's nodes: the plan integrated from node to node.

use std::ops::ControlFlow;

use nalgebra::Vector3;
use samara::assess::{BETWEEN_NODES_MOST, IntegratedPlan, SafetyLimits};
use samara::config::Mission;
use samara::model::Environment;
use samara::model::environment::GeoPoint;
use samara::plan::{SolverOptions, Status};
use samara::trajectory::{Node, Trajectory};

use super::problems::titan;

fn planned(name: &str, nodes: usize) -> (Mission, Trajectory) {
    let mut mission = Mission::shipped(name).unwrap();
    mission.plan.nodes = nodes;
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let plan = mission.solve(&SolverOptions::default(), go_on).unwrap();
    assert_eq!(plan.status, Status::Converged, "{:?}", plan.diagnosis);
    (mission, plan.trajectory)
}

/// In (next to) no air, level, with thrusts that rise from nothing to three times the weight over `h`: the
/// speed down `v_0 + g (t - 3 t^2/(2 h))` is greatest at a third of the interval, `v_0 + g h/6`, and ends at
/// `v_0 - g h/2`.
#[test]
fn closed_form_the_peak_of_a_fall_between_two_nodes() {
    let (vehicle, _) = titan();
    let (g, h, v_0) = (1.35, 4.0, 3.0);
    let anchor = GeoPoint { latitude_deg: 0.0, longitude_deg: 0.0, altitude_m: 0.0 };
    let environment = Environment::new(g, 1e-12, Vector3::zeros(), anchor).unwrap();
    let full_n = 3.0 * g * vehicle.mass.mass_kg / 4.0;
    let off = Vector3::new(0.06, 0.0, 0.08);
    let node = |t_s: f64, v_down: f64, thrust_n: f64| Node {
        t_s,
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned: Vector3::new(0.0, 0.0, v_down),
        omega_body: Vector3::zeros(),
        thrust_n: [thrust_n; 8],
        a_ned: Vector3::zeros(),
    };
    let mut last = node(h, v_0 - g * h / 2.0, full_n);
    last.v_ned += off;
    let plan = Trajectory::new(vec![node(0.0, v_0, 0.0), last], 4).unwrap();
    let limits = SafetyLimits {
        speed_m_s: 12.0,
        pitch_rad: 1.0,
        pitch_rate_rad_s: 1.0,
        vertical_acceleration_m_s2: 3.0,
    };
    let found = IntegratedPlan::new(&plan, &vehicle, &environment, &limits);
    assert!((found.j_tpf_at_nodes - v_0 / 12.0).abs() < 1e-12, "{found:?}");
    assert!((found.j_tpf - (v_0 + g * h / 6.0) / 12.0).abs() < 2e-6, "{found:?}");
    assert!((found.velocity_defect_m_s - off.norm()).abs() < 1e-9, "{found:?}");
    assert!(found.attitude_defect_rad < 1e-9 && found.body_rate_defect_rad_s < 1e-9, "{found:?}");
    assert!(!found.is_told_by_nodes(1.0), "J_TPF differs by .075");
}

/// Ten nodes, integrated by another program: between the nodes the plan is above what it is at them.
#[test]
fn reference_a_coarse_plan_passes_its_peak_between_nodes() {
    let (mission, plan) = planned("titan_paper", 10);
    let found = mission.integrated(&plan);
    assert!((found.j_tpf_at_nodes - 0.5617).abs() < 6e-5, "{found:?}");
    assert!((found.j_tpf - 0.5656).abs() < 6e-5, "{found:?}");
    assert!(!mission.is_told_by_nodes(&found));
}

/// The number of nodes that would do is one whose plan does, and fewer do not.
#[test]
fn nodes_that_would_do_are_told() {
    let (mission, _) = planned("titan_drop", 10);
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let enough = mission.nodes_enough(&SolverOptions::default(), go_on).unwrap().unwrap();
    assert!((11..40).contains(&enough), "{enough}");
    let (finer, plan) = planned("titan_drop", enough);
    assert!(finer.is_told_by_nodes(&finer.integrated(&plan)));
    let stopped = mission.nodes_enough(&SolverOptions::default(), &mut |_| ControlFlow::Break(()));
    assert_eq!(stopped.unwrap(), None);
}

/// Defects of Hermite-Simpson collocation fall with the fifth power of the interval's length, a halving at a
/// time here; what J_TPF at the nodes is short of goes to nothing.
#[test]
fn prop_what_nodes_do_not_tell_vanishes_with_more_of_them() {
    let found: Vec<IntegratedPlan> = [19, 37, 73, 145]
        .map(|nodes| {
            let (mission, plan) = planned("titan_paper", nodes);
            mission.integrated(&plan)
        })
        .to_vec();
    for pair in found.windows(2) {
        let falls = |of: fn(&IntegratedPlan) -> f64| of(&pair[0]) / of(&pair[1]);
        assert!(falls(|p| p.velocity_defect_m_s) > 12.0, "{pair:?}");
        assert!(falls(|p| p.attitude_defect_rad) > 12.0, "{pair:?}");
        assert!(falls(|p| p.body_rate_defect_rad_s) > 12.0, "{pair:?}");
    }
    assert!(found[3].j_tpf_between_nodes() < 5e-5, "{found:?}");
}

/// Every shipped mission's plan is told by its nodes.
#[test]
fn shipped_missions_have_the_nodes_that_they_need() {
    for name in [
        "balloon_drop",
        "dragonfly_drop",
        "hexa_drop",
        "octo_drop",
        "titan_drop",
        "titan_no_wire",
        "titan_paper",
        "titan_paper_linear",
        "titan_paper_second",
        "titan_px4",
        "x500_drop",
        "x500_ground",
        "x500_no_wire",
    ] {
        let nodes = Mission::shipped(name).unwrap().plan.nodes;
        let (mission, plan) = planned(name, nodes);
        let found = mission.integrated(&plan);
        assert!(found.j_tpf_between_nodes() <= BETWEEN_NODES_MOST, "{name}: {found:?}");
        assert!(mission.is_told_by_nodes(&found), "{name}: {found:?}");
    }
}
