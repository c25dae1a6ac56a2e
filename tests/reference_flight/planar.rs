//! The batch engine's costs, on the Titan vehicle: against the code for flight in space, and against the
//! reference's numbers.

use nalgebra::Vector3;
use samara::assess::tracking::control_period_s;
use samara::assess::{
    BatchFlight, BatchMeasure, Limits, TrackingError, Verdict, VerdictBuilder, judge_flights,
    steady_within_m_s,
};
use samara::control::{ControlLimits, Gains};
use samara::sim::planar::{Flight, Model, Release, Variation};
use samara::sim::{DropSimulation, FlightPlan, PlantKind, Reference, fly};
use samara::trajectory::Trajectory;
use samara::tune::ReleaseCase;
use samara::units::RAD_PER_DEG;

use super::data::{
    NUMBERS, TABLE_3, TITAN, cascade, flight_reference, gains, limits, number, numbers, plan, site,
    target_ned,
};

fn flight_of(case: &ReleaseCase, gains: Gains) -> Flight {
    Flight { gains, release: Release::of(&case.state()).unwrap(), variation: Variation::NONE }
}

fn along(reference: Reference<'_>, control_period_s: f64, duration_s: f64) -> FlightPlan<'_> {
    FlightPlan::new(reference, control_period_s, duration_s)
}

fn hermite(trajectory: &Trajectory, then_v_ned: Option<Vector3<f64>>) -> Reference<'_> {
    Reference::Plan { trajectory, then_v_ned, feed_forward: false }
}

/// The seven cases, judged.
fn judged(
    kind: PlantKind,
    gains: Gains,
    plan: &FlightPlan<'_>,
    nodes: Option<&Trajectory>,
) -> Vec<BatchFlight> {
    let model = Model::new(&TITAN, &site(), &ControlLimits::default(), kind).unwrap();
    let target = target_ned();
    let near = steady_within_m_s(&target);
    let measure =
        BatchMeasure::new(plan, nodes, &Limits::of_j_state(limits(), near), [target.x, target.z]).unwrap();
    let flights: Vec<Flight> = TABLE_3.iter().map(|case| flight_of(case, gains)).collect();
    let mut outcomes = vec![BatchFlight::default(); flights.len()];
    judge_flights(&model, &measure, &flights, &mut outcomes);
    outcomes
}

fn in_space(
    kind: PlantKind,
    gains: Gains,
    plan: &FlightPlan<'_>,
    nodes: &Trajectory,
    case: &ReleaseCase,
) -> (f64, Verdict) {
    let mut sim = DropSimulation::at_t0(TITAN.clone(), site(), case.state(), kind);
    let (mut error, mut verdict) = (TrackingError::new(nodes), VerdictBuilder::new(limits(), target_ned()));
    let _ = fly(&mut sim, &mut cascade(gains), plan, &mut |s| {
        verdict.observe(s);
        error.observe(s)
    });
    (error.rms(), verdict.finish().unwrap())
}

/// Seven releases, the study's controllers and references, both plants; on past the plan's end to the steady
/// state.
#[test]
fn prop_batch_costs_are_those_of_flights_in_space() {
    let (velocity, nodes) = (flight_reference(), plan());
    let plan = hermite(&velocity, Some(target_ned()));
    let step = Reference::Step(target_ned());
    let dt_s = control_period_s(&nodes);
    for (name, reference) in [
        ("near_hover", step),
        ("paper_pso", step),
        ("near_hover", plan),
        ("paper_pso", plan),
        ("safety", plan),
    ] {
        for (kind, bar) in [(PlantKind::Ideal, 1e-12), (PlantKind::Actuator, 1e-9)] {
            let flight = along(reference, dt_s, nodes.end_s() + 405.0 * dt_s);
            let outcomes = judged(kind, gains(name), &flight, Some(&nodes));
            for (found, case) in outcomes.iter().zip(TABLE_3.iter()) {
                let (rms, v) = in_space(kind, gains(name), &flight, &nodes, case);
                let (o, v) = (&found.outcome, &v.outcome);
                let pairs = [
                    (found.rms, rms),
                    (o.j_tpf, v.j_tpf),
                    (o.peak_speed_m_s, v.peak_speed_m_s),
                    (o.peak_pitch_deg * RAD_PER_DEG, v.peak_pitch_deg * RAD_PER_DEG),
                    (o.peak_pitch_rate_deg_s * RAD_PER_DEG, v.peak_pitch_rate_deg_s * RAD_PER_DEG),
                    (o.vn_end_m_s, v.vn_end_m_s),
                    (o.vd_end_m_s, v.vd_end_m_s),
                    (o.steady_after_s.unwrap_or(-1.0), v.steady_after_s.unwrap_or(-1.0)),
                ];
                for (i, (found, wanted)) in pairs.into_iter().enumerate() {
                    let error = (found - wanted).abs();
                    assert!(error < bar, "{kind:?} {name} {case:?} column {i}: {error:.2e}");
                }
                assert!(!found.given_up);
            }
        }
    }
}

/// A pitch loop of the wrong sign turns the vehicle over: both engines give it up within a turn, and count
/// half a turn for it.
#[test]
fn prop_a_flight_that_turns_over_costs_the_same_in_space() {
    let (velocity, nodes) = (flight_reference(), plan());
    let flight = along(hermite(&velocity, None), control_period_s(&nodes), nodes.end_s());
    let mut gains = gains("safety");
    gains.k_ptheta = -3.0;
    let most = std::f64::consts::PI / limits().pitch_rad;
    for (found, case) in judged(PlantKind::Ideal, gains, &flight, Some(&nodes)).iter().zip(TABLE_3.iter()) {
        let (rms, verdict) = in_space(PlantKind::Ideal, gains, &flight, &nodes, case);
        assert!(found.given_up && found.rms == 1000.0 && rms == 1000.0, "{case:?}");
        let (o, in_space) = (&found.outcome, verdict.outcome.j_tpf);
        assert!((o.j_tpf - in_space).abs() < 1e-9 * in_space, "{case:?}");
        let rate = o.peak_pitch_rate_deg_s * RAD_PER_DEG / limits().pitch_rate_rad_s;
        let speed = o.peak_speed_m_s / limits().speed_m_s;
        assert!(o.peak_pitch_deg > 180.0, "{case:?}");
        assert!((o.j_tpf - most.max(rate).max(speed)).abs() < 1e-15 * o.j_tpf, "{case:?}");
    }
}

#[test]
fn reference_batch_rms_on_both_plants() {
    let (velocity, nodes) = (flight_reference(), plan());
    let flight = along(hermite(&velocity, None), control_period_s(&nodes), nodes.end_s());
    for (key, kind) in [("ideal_plant", PlantKind::Ideal), ("actuator_plant", PlantKind::Actuator)] {
        let best = if kind == PlantKind::Ideal { "_best_knife_edge" } else { "_best" };
        let tuned = &NUMBERS["tracking_rms"][format!("{key}{best}")];
        let table = &NUMBERS["tracking_rms"][key];
        for (gains, wanted) in [
            (gains("near_hover"), &table["NH"]),
            (gains("paper_pso"), &table["PSO"]),
            (Gains::longitudinal(numbers(&tuned["gains"]).try_into().unwrap()), &tuned["per_case"]),
        ] {
            let outcomes = judged(kind, gains, &flight, Some(&nodes));
            for (found, wanted) in outcomes.iter().zip(numbers(wanted)) {
                assert!((found.rms - wanted).abs() < 3e-7, "{key}: {:.2e}", found.rms - wanted);
            }
        }
    }
    let outcomes = judged(PlantKind::Actuator, gains("safety"), &flight, Some(&nodes));
    let worst = outcomes.iter().map(|o| o.rms).fold(0.0, f64::max);
    assert!((worst - number(&NUMBERS["safety_gains_rms_worst_actuator_plant"])).abs() < 3e-7, "{worst}");
}

#[test]
fn reference_batch_j_tpf_of_all_cases_and_controllers() {
    let velocity = flight_reference();
    let plan = hermite(&velocity, None);
    for (suffix, dt_s) in [("dt0.01", 0.01), ("dt0.004", 0.004)] {
        for (key, name, reference) in [
            ("NHstep", "near_hover", Reference::Step(target_ned())),
            ("NHopt", "near_hover", plan),
            ("PSOopt", "paper_pso", plan),
        ] {
            let table = &NUMBERS["flight_peaks"][format!("{key}_eval_{suffix}")];
            let (j_tpf, speed) = (numbers(&table["J_TPF"]), numbers(&table["Vmax"]));
            let pitch = [numbers(&table["pitch_min_deg"]), numbers(&table["pitch_max_deg"])];
            let outcomes = judged(PlantKind::Actuator, gains(name), &along(reference, dt_s, 30.0), None);
            for (case, found) in outcomes.iter().enumerate() {
                let what = format!("{key} {suffix} case {case}");
                assert!((found.outcome.j_tpf - j_tpf[case]).abs() < 1e-9, "{what}: {}", found.outcome.j_tpf);
                assert!((found.outcome.peak_speed_m_s - speed[case]).abs() < 2e-9, "{what}");
                let steepest = if pitch[0][case].abs() > pitch[1][case].abs() { 0 } else { 1 };
                let wanted = pitch[steepest][case].abs();
                assert!(((found.outcome.peak_pitch_deg - wanted) * RAD_PER_DEG).abs() < 2e-9, "{what}");
                assert_eq!(found.rms, 0.0, "no nodes, no error");
            }
        }
    }
}

/// A flight that diverges, one whose state is no number, and one whose nodes fall between the control steps.
#[test]
fn lost_flights_cost_a_thousand_and_leave_the_others_alone() {
    let (velocity, nodes) = (flight_reference(), plan());
    let dt_s = control_period_s(&nodes);
    let flight = along(hermite(&velocity, None), dt_s, nodes.end_s());
    let model = Model::new(&TITAN, &site(), &ControlLimits::default(), PlantKind::Ideal).unwrap();
    let measure_with_nodes =
        BatchMeasure::new(&flight, Some(&nodes), &Limits::of_j_state(limits(), 0.05), [4.0, 4.0]).unwrap();
    assert_eq!(measure_with_nodes.setpoints().steps(), 37 * 81);
    let good = flight_of(&TABLE_3[2], gains("safety"));
    let mut fast = good;
    fast.release.v_north_m_s = 80.0;
    let mut broken = good;
    broken.variation.mass = f64::NAN;
    // The wrong sign of the pitch loop: it tumbles.
    let mut tumbling = good;
    tumbling.gains.k_ptheta = -3.0;
    let mut outcomes = [BatchFlight::default(); 4];
    judge_flights(&model, &measure_with_nodes, &[fast, good, broken, tumbling], &mut outcomes);
    let mut alone = [BatchFlight::default(); 1];
    judge_flights(&model, &measure_with_nodes, &[good], &mut alone);
    assert_eq!(outcomes[1], alone[0]);
    assert!(outcomes[1].rms < 1.0 && !outcomes[1].given_up);
    for lost in [0, 2, 3] {
        assert_eq!(outcomes[lost].rms, 1000.0);
        assert!(outcomes[lost].given_up && outcomes[lost].outcome.j_tpf > 1.0, "{lost}");
    }
    assert_eq!(outcomes[0].outcome.peak_speed_m_s, 80.0f64.hypot(TABLE_3[2].v_ned.z));
    assert_eq!(outcomes[2].outcome.j_tpf, f64::INFINITY);
    let off_grid =
        judged(PlantKind::Ideal, gains("safety"), &along(hermite(&velocity, None), 0.01, 30.0), Some(&nodes));
    assert!(off_grid.iter().all(|o| o.rms == 1000.0 && !o.given_up));
}
