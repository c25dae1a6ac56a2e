//! The judge that gains are tuned on, on the Titan vehicle: the reference's numbers, and its engine in space
//! beside the planar one.

use nalgebra::Vector3;
use samara::assess::ReleaseDistribution;
use samara::assess::tracking::{PITCH_MAX_RAD, SPEED_MAX_M_S};
use samara::control::{ControlLimits, Gains};
use samara::frames::{product, quaternion_from_euler};
use samara::model::Parachute;
use samara::model::parachute::{Pendulum, TipOff};
use samara::model::rigid_body::BodyState;
use samara::sim::PlantKind;
use samara::sim::planar::Variation;
use samara::trajectory::Trajectory;
use samara::tune::cma_es::CmaSettings;
use samara::tune::gain_judge::{Loss, Setting};
use samara::tune::near_hover::near_hover;
use samara::tune::unknowns;
use samara::tune::{
    CandidateSearch as _, Evaluation, GainJudge, GainSpace, Method, Objective, Search, SearchSettings,
};
use samara::uncertain::Uncertainty;
use samara::units::RAD_PER_DEG;

use super::data::{NUMBERS, TABLE_3, gains, number, numbers, plan, scenario};

fn setting(plan: &Trajectory, plant: PlantKind, settle_s: f64) -> Setting<'_> {
    Setting {
        scenario: scenario(),
        control_limits: ControlLimits::default(),
        plant,
        yaw: Gains::near_hover(),
        plan,
        feed_forward: false,
        settle_s,
    }
}

/// (46) of the reference's gains. The judge's plan is 3e-6 from the one that the reference tracks.
#[test]
fn reference_worst_rms() {
    let plan = plan();
    for (key, plant) in [("ideal_plant", PlantKind::Ideal), ("actuator_plant", PlantKind::Actuator)] {
        let judge = GainJudge::new(setting(&plan, plant, 0.0)).unwrap().with_cases(&TABLE_3);
        for (name, file) in [("NH", "near_hover"), ("PSO", "paper_pso")] {
            let wanted = numbers(&NUMBERS["tracking_rms"][key][name]).into_iter().fold(0.0, f64::max);
            let found = judge.evaluate(&gains(file).as_longitudinal()).rms;
            assert!((found - wanted).abs() < 2e-5, "{key} {name}: {:.2e}", found - wanted);
        }
    }
    let judge = GainJudge::new(setting(&plan, PlantKind::Actuator, 4.5)).unwrap().with_cases(&TABLE_3);
    let safety = judge.evaluate(&gains("safety").as_longitudinal());
    let wanted = number(&NUMBERS["safety_gains_rms_worst_actuator_plant"]);
    assert!((safety.rms - wanted).abs() < 2e-5 && safety.unrest == 0.0, "{safety:?}");
    // The paper's gains make a limit cycle.
    assert!(judge.evaluate(&gains("paper_pso").as_longitudinal()).unrest >= 0.01);
}

/// An independent study's map of J_TPF over the release found steps of 0.09 between neighbouring releases
/// under these gains, as at a swing of 2.5 deg with a phase of -172.5 deg: 0.642 between 0.555 and 0.555. The
/// release whose pitch is a degree from there shows nothing; tipped, it does.
#[test]
fn reference_a_step_a_degree_beside_a_release_is_seen() {
    let plan = plan();
    let k = gains("ours").as_longitudinal();
    let worst = |judge: GainJudge<'_>| judge.evaluate(&k).j_tpf;
    let judge = || GainJudge::new(setting(&plan, PlantKind::Actuator, 0.0)).unwrap();
    let release = |phase_deg: f64| {
        let (amplitude_rad, phase_rad) = (2.5 * RAD_PER_DEG, phase_deg * RAD_PER_DEG);
        let pendulum = Pendulum { amplitude_rad, phase_rad, omega_rad_s: 2.0, length_m: 0.34 };
        Parachute::new(3.0, 0.5, pendulum).unwrap().state_at_t0(1.35)
    };
    assert!(worst(judge().with_states(&[release(-172.0)])) > 0.63);
    for by_rad in [-RAD_PER_DEG, RAD_PER_DEG] {
        let mut beside = release(-172.0);
        beside.q_ned_from_body = product(quaternion_from_euler(0.0, by_rad, 0.0), beside.q_ned_from_body);
        let plain = worst(judge().with_states(&[beside]));
        let tipped = worst(judge().with_states(&[beside]).with_tipped(&[beside]));
        assert!(plain < 0.58 && tipped > 0.63, "{by_rad}: {plain} {tipped}");
    }
}

/// What nobody says is uncertain, at the paper's target.
fn usual() -> Uncertainty {
    unknowns::usual(Vector3::new(4.0, 0.0, 4.0).norm())
}

/// A breath of wind from the side, which the planar engine refuses, puts the flights in space.
#[test]
fn prop_the_bench_in_space_is_the_planar_one() {
    let plan = plan();
    let planar = setting(&plan, PlantKind::Actuator, 4.5);
    let mut in_space = planar.clone();
    in_space.scenario.environment.wind_ned_m_s = Vector3::new(0.0, 1e-12, 0.0);
    let case = [TABLE_3[2].clone()];
    let [planar, in_space] = [planar, in_space]
        .map(|s| GainJudge::new(s).unwrap().with_cases(&case).with_variations(&case, &usual()));
    let k = gains("safety").as_longitudinal();
    assert_eq!(planar.flights(), 20);
    for (i, (p, s)) in planar.fly(&k).iter().zip(in_space.fly(&k)).enumerate() {
        let apart = (p.rms - s.rms).abs().max((p.j_tpf - s.j_tpf).abs()).max((p.unrest - s.unrest).abs());
        assert!(apart < 1e-6, "flight {i}: {p:?} {s:?}");
    }
    // The way is to the plan's end in both, by the trapezoid rule in the plane; the flights go on from there.
    let others = [(case[0].state(), Variation::NONE)];
    let [p, s] = [&planar, &in_space].map(|judge| judge.measure_others(&k, &others)[0].outcome);
    assert!((p.way_ned_m() - s.way_ned_m()).norm() < 2e-3, "{p:?} {s:?}");
    // A pitch loop as fast as its rate loop tumbles.
    let lost = planar.evaluate(&[3.52, 2.11, 1.665, 3.79, 3.37, 0.431, 0.0032]);
    assert_eq!(lost, Evaluation::DIVERGED);
}

/// At a hover 1 % of the target is nothing and a distance as a fraction of it has no meaning: the mission's
/// tolerance takes both places, in the plane and in space. After the plan the vehicle is told to stop; it has
/// come to rest when it is within the tolerance a second before the end.
#[test]
fn prop_a_hover_target_is_judged_like_any_other() {
    let plan = plan();
    let case = [TABLE_3[2].clone()];
    let k = gains("safety").as_longitudinal();
    let evaluated = |settle_s: f64, side_wind_m_s: f64| {
        let mut hover = setting(&plan, PlantKind::Actuator, settle_s);
        (hover.scenario.target_v_ned, hover.scenario.limits.steady_within_m_s) = (Vector3::zeros(), 0.1);
        hover.scenario.environment.wind_ned_m_s = Vector3::new(0.0, side_wind_m_s, 0.0);
        GainJudge::new(hover).unwrap().with_cases(&case).evaluate(&k)
    };
    for (settle_s, rested) in [(25.0, true), (2.0, false)] {
        let [plane, space] = [0.0, 1e-12].map(|wind| evaluated(settle_s, wind));
        assert_eq!(plane.unrest == 0.0, rested, "{plane:?}");
        assert!(plane.is_finite() && (plane.unrest - space.unrest).abs() < 1e-5, "{plane:?} {space:?}");
        assert!(rested || plane.unrest > 1.0, "more than the tolerance away: {plane:?}");
    }
}

/// A search whose first candidates each lose a flight ends there, and the judge says which flight and how: a
/// pitch loop as fast as its rate loop turns over in one of the variations.
#[test]
fn a_search_without_a_start_that_flies_ends_at_once() {
    let plan = plan();
    let case = [TABLE_3[2].clone()];
    let judge = GainJudge::new(setting(&plan, PlantKind::Actuator, 0.0)).unwrap();
    let judge = judge.with_cases(&case).with_variations(&case, &usual());
    let tumbling = [3.52, 2.11, 1.665, 3.79, 3.37, 0.431, 0.0032];
    let lost = judge.first_lost(&tumbling).unwrap();
    let Loss::Diverged { t_s, speed_m_s, pitch_rad } = lost.loss else { panic!("{lost}") };
    assert!(speed_m_s > SPEED_MAX_M_S || pitch_rad.abs() > PITCH_MAX_RAD, "{lost}");
    assert!((0.0..plan.end_s()).contains(&t_s) && lost.start == case[0].state(), "{lost}");
    assert!(judge.first_lost(&gains("safety").as_longitudinal()).is_none());

    let cma = CmaSettings { samples: 4, sigma: 1e-9, tolerance: 0.0, ..CmaSettings::default() };
    let settings = |start| SearchSettings {
        method: Method::CmaEs(cma),
        objectives: vec![Objective::Rms],
        iterations: 3,
        space: GainSpace::of_all(1e-4, 5.0),
        starts: vec![start],
        seed: 1,
    };
    for (start, judged, lost) in [(tumbling, 5, true), (gains("safety").as_longitudinal(), 13, false)] {
        let mut search = Search::new(settings(start));
        while let Some(candidates) = search.candidates() {
            let evaluations: Vec<_> = candidates.iter().map(|k| judge.evaluate(k)).collect();
            search.update(&evaluations);
        }
        assert_eq!((search.tried().len(), search.is_lost()), (judged, lost));
    }
}

/// Flights that are left out would not have made a candidate cheaper: what is given up costs more than its
/// ceiling, and what is not is judged to the bit as by all its flights.
#[test]
fn prop_a_candidate_is_given_up_only_when_it_costs_too_much() {
    let plan = plan();
    let judge = GainJudge::new(setting(&plan, PlantKind::Actuator, 4.5)).unwrap().with_cases(&TABLE_3);
    let judge = judge.with_states(&random_releases(&swing(), 8, 30));
    let objective = Objective::Safety { rms_bound: 0.367, penalty: 2.0 };
    let mut spared = 0;
    for name in ["near_hover", "paper_pso", "safety", "ours", "ideal_rms"] {
        let k = gains(name).as_longitudinal();
        let whole = judge.evaluate(&k);
        let cost = objective.cost(&whole);
        for ceiling in [0.5 * cost, 0.95 * cost, cost, f64::INFINITY] {
            let judged = judge.evaluate_below(&k, &objective, ceiling);
            let worse = whole.worse(judged);
            assert_eq!(worse, whole, "{name}: no flight that is not there");
            if judged != whole {
                spared += 1;
                assert!(ceiling < cost && objective.cost(&judged) > ceiling, "{name} {ceiling}: {judged:?}");
            }
        }
    }
    assert!(spared > 0);
}

/// The relays find the limits of stability: outer loops are slower than inner ones, and the gains made of
/// them fly the drop.
#[test]
fn regress_near_hover_gains_fly() {
    let plan = plan();
    let setting = setting(&plan, PlantKind::Actuator, 4.5);
    let found = near_hover(&setting).unwrap();
    let [rate, pitch, vertical, horizontal] = found.loops.map(|l| l.period_s);
    assert!(rate < pitch && pitch < horizontal && vertical < horizontal, "{found:?}");
    let flown = GainJudge::new(setting).unwrap().with_cases(&TABLE_3).evaluate(&found.adjusted);
    assert!(flown.j_tpf < 1.0 && flown.rms < 1.0, "{flown:?}");
}

/// The bars that `ours` was made for, on flights that its tuning never saw: mean at most 0.56, and no more
/// than one of 4 x 1000 above 0.66, where one of 40 000 is above 0.65 (docs/tuning.md): two would be once in
/// 200 draws.
#[test]
fn regress_our_gains_on_unseen_flights() {
    let plan = plan();
    let setting = setting(&plan, PlantKind::Actuator, 4.5);
    let k = gains("ours").as_longitudinal();
    let cases = GainJudge::new(setting.clone()).unwrap().with_cases(&TABLE_3).evaluate(&k);
    assert!(cases.rms <= 0.3670 && cases.unrest == 0.0, "{cases:?}");
    let mut above = 0;
    for seed in 1..=4 {
        let states = random_releases(&swing(), seed, 1000);
        let flights = GainJudge::new(setting.clone()).unwrap().with_states(&states).fly(&k);
        above += flights.iter().filter(|e| e.j_tpf > 0.66).count();
        let mean = flights.iter().map(|e| e.j_tpf).sum::<f64>() / 1000.0;
        assert!(mean <= 0.56, "seed {seed}: mean {mean}");
    }
    assert!(above <= 1, "{above} of 4000");
}

/// The first `count` random releases of a seed: those of a campaign.
fn random_releases(swing: &ReleaseDistribution, seed: u64, count: usize) -> Vec<BodyState> {
    (0..count).map(|trial| swing.draw(seed, trial as u64).state).collect()
}

/// (40)-(44), the pendulum of the paper's text.
fn swing() -> ReleaseDistribution {
    let pendulum = Pendulum { amplitude_rad: 0.0, phase_rad: 0.0, omega_rad_s: 2.0, length_m: 0.34 };
    ReleaseDistribution {
        parachute: Parachute::new(3.0, 0.5, pendulum).unwrap(),
        gravity_m_s2: 1.35,
        drift_ned_m_s: Vector3::zeros(),
        amplitude_sigma_rad: 3.0 * RAD_PER_DEG,
        tip_off_sigma: TipOff::default(),
        uncertain: None,
    }
}
