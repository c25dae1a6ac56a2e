//! How plan and gains of a mission are designed together: judge and search of its settings.

use samara_core::assess::Scenario;
use samara_core::control::px4::timing::IMU_PERIOD_S;
use samara_core::design::{
    Design, DesignBounds, DesignFlights, DesignJudge, DesignSearchSettings, FlyPortions, FreshResults,
    LeastMargins, NotJudged, PlanDesign, Unknown, judge_fresh,
};
use samara_mission::Mission;

use super::tuning::gain_space;

/// Designs of a generation.
const SAMPLES: usize = 16;
/// Spread of the first generation, as a share of the ranges.
const SPREAD: f64 = 0.08;

/// Least distance of a loop's response from -1: a phase of 29 deg, a factor of 2 on the gain.
const LEAST_MODULUS: f64 = 0.5;
/// Least delay that takes a loop to the limit of stability [s].
const LEAST_DELAY_S: f64 = 0.02;

/// The flights of a design of a mission.
pub fn design_flights(mission: &Mission) -> DesignFlights {
    DesignFlights {
        scenario: Scenario {
            wind: mission.design.wind(&mission.site.wind, mission.seed),
            ..mission.scenario()
        },
        yaw: mission.control.gains,
        settle_s: mission.design.settle_s.unwrap_or(mission.plan.horizon_s),
        delay_s: mission.release.parachute.delay_s,
        cases: mission.study.cases.clone(),
        releases: mission.releases(),
        seed: mission.seed,
    }
}

/// The judge of designs of a mission.
pub fn design_judge(mission: &Mission) -> DesignJudge<'_> {
    let unknown = Unknown { vehicle: mission.design.unknowns, air: true };
    let made_small = (mission.design.objective, design_bounds(mission));
    DesignJudge::new(
        mission.plan_problem(),
        design_flights(mission),
        made_small,
        mission.design.draws,
        unknown,
    )
}

/// The bounds of a mission's designs: unless the mission says otherwise, flights are steady by the plan's
/// end, and the loops are some way from instability: a modulus, and a delay of a control period and twice the
/// latency.
fn design_bounds(mission: &Mission) -> DesignBounds {
    let bounds = mission.design.bounds;
    let delay_s = LEAST_DELAY_S.max(IMU_PERIOD_S + 2.0 * mission.vehicle.latency_s);
    let [steady_after_s, altitude_lost_m, tilt_deg] = bounds.most;
    DesignBounds {
        most: [steady_after_s.or(Some(mission.plan.horizon_s)), altitude_lost_m, tilt_deg],
        margins: LeastMargins {
            modulus: bounds.margins.modulus.or(Some(LEAST_MODULUS)),
            delay_s: bounds.margins.delay_s.or(Some(delay_s)),
        },
        ..bounds
    }
}

/// A mission's own plan and gains.
pub fn own_design(mission: &Mission) -> Design {
    Design {
        plan: PlanDesign::of(&mission.plan_problem()),
        gains: mission.control.gains.as_longitudinal(),
        feed_forward: mission.control.feed_forward,
        limits: mission.control.limits,
    }
}

/// The search of a mission's design, of at most `budget` designs.
pub fn design_search(mission: &Mission, budget: usize) -> DesignSearchSettings {
    let own = own_design(mission);
    DesignSearchSettings {
        space: mission.design.space(&own, &mission.limits.safety, gain_space(mission)),
        bounds: design_bounds(mission),
        own,
        samples: SAMPLES,
        spread: SPREAD,
        budget,
        seed: mission.seed,
    }
}

/// A design on fresh flights.
#[derive(Clone, Debug)]
pub struct JudgedDesign {
    /// Name of the design.
    pub name: String,
    /// Results by condition.
    pub fresh: Vec<FreshResults>,
}

/// Name of the mission's own design.
pub const OWN: &str = "own";

/// Judges the mission's own design, where it has a plan, and the chosen one of a name, where it is another,
/// on so many fresh flights in each condition.
///
/// # Errors
/// [`NotJudged::Stopped`]: then nothing is judged.
pub fn judge_own_and(
    (name, chosen): (&str, &Design),
    mission: &Mission,
    judge: &DesignJudge<'_>,
    flights: u64,
    fly: &FlyPortions<'_>,
) -> Result<Vec<JudgedDesign>, NotJudged> {
    let own = own_design(mission);
    let chosen = (*chosen != own).then_some((name, *chosen));
    let mut judged = Vec::new();
    for (name, design) in std::iter::once((OWN, own)).chain(chosen) {
        match judge_fresh(judge, &design, flights, fly) {
            Ok(fresh) => judged.push(JudgedDesign { name: name.to_owned(), fresh }),
            // The mission's own plan may be none.
            Err(NotJudged::NoPlan) => {}
            Err(stopped) => return Err(stopped),
        }
    }
    Ok(judged)
}
