//! How plan and gains of a mission are designed together.
//!
//! | file | holds |
//! |---|---|
//! | this one | judge and search of a mission's settings |
//! | [`search`] | the study: a search, its finalists, fresh flights |
//! | [`report`] | tables, JSON, rows, figure |

pub mod report;
pub mod search;

use std::sync::Arc;

use samara_core::assess::Scenario;
use samara_core::control::px4::timing::IMU_PERIOD_S;
use samara_core::design::{
    Design, DesignBounds, DesignFlights, DesignJudge, DesignSearchSettings, FreshResults, LeastMargins,
    LoopsAt, OperatingPoint, PlanDesign, RELEASE, RandomDrops, Unknown, WorstLoop,
};
use samara_core::model::wind::Wind;
use samara_core::sim::DropSimulation;
use samara_core::trajectory::Trajectory;
use samara_core::uncertain::UncertainQuantity;
use samara_mission::Mission;

use crate::tuning::gain_space;
use crate::uncertain::uncertain_or_usual;

/// Designs of a generation.
const SAMPLES: usize = 16;
/// Spread of the first generation, as a share of the ranges.
const SPREAD: f64 = 0.08;

/// Least distance of a loop's response from -1: a phase of 29 deg, a factor of 2 on the gain.
pub const LEAST_MODULUS: f64 = 0.5;
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
        horizon_s: mission.plan.horizon_s,
        delay_s: mission.release.parachute.delay_s,
        cases: mission.study.cases.clone(),
        releases: mission.releases().with_uncertain(Some(uncertain_or_usual(mission))),
        seed: mission.seed,
        own_air: mission.site.wind.turbulence.is_some(),
        drops: MissionDrops::of(mission).map(|drops| Arc::new(drops) as _),
    }
}

/// Whether drops of a mission have what flights from t = 0 leave out: a canopy that moves, a wind from
/// anywhere or by altitude, rotors that are started.
pub fn is_more_than_from_t0(mission: &Mission) -> bool {
    mission.release.parachute.suspension.is_some()
        || mission.study.monte_carlo.wind_sigma_m_s > 0.0
        || mission.site.wind.profile.is_some()
        || mission.vehicle.start.is_some()
}

/// Whole drops of a mission, by its own random numbers.
#[derive(Debug)]
struct MissionDrops {
    /// The mission, in the turbulence that designs are judged in.
    mission: Mission,
}

impl MissionDrops {
    /// Those of a mission of which flights from t = 0 leave something out; `None`: they leave out nothing.
    fn of(mission: &Mission) -> Option<Self> {
        is_more_than_from_t0(mission).then(|| Self::in_light_turbulence(mission))
    }

    fn in_light_turbulence(mission: &Mission) -> Self {
        let mut mission = mission.clone();
        mission.site.wind = mission.design.wind(&mission.site.wind, mission.seed);
        Self { mission }
    }
}

impl RandomDrops for MissionDrops {
    fn numbered(&self, number: u64, unknown: Unknown) -> DropSimulation {
        let uncertain = unknown.vehicle.then(|| uncertain_or_usual(&self.mission));
        let wind_sigma_m_s = self.mission.study.monte_carlo.wind_sigma_m_s;
        let releases = self.mission.releases().with_uncertain(uncertain);
        let mut drop = releases.draw_drop(self.mission.seed, number, wind_sigma_m_s);
        // A mission that draws a wind of its own needs no usual one beside it.
        if unknown.air && wind_sigma_m_s > 0.0 && self.mission.uncertain.is_none() {
            drop.off.set(UncertainQuantity::Wind, 0.0);
        }
        let mut mission = self.mission.with_drop(&drop);
        if !unknown.air {
            mission.site.wind = Wind::default();
            mission.site.environment = mission.off.variation().blown(&self.mission.site.environment);
        }
        mission.released_simulation()
    }

    fn held_until_s(&self) -> f64 {
        let release = &self.mission.release;
        let sooner = uncertain_or_usual(&self.mission).of(UncertainQuantity::ReleaseDelay);
        let sooner_s = sooner.map_or(0.0, |distribution| distribution.support()[0].min(0.0));
        (release.hang_s + release.parachute.delay_s + sooner_s).max(0.0)
    }

    fn ends_s(&self, plan: &Trajectory) -> f64 {
        let begins_s = self.mission.release.hang_s + self.mission.release.parachute.delay_s;
        let settle_s = self.mission.design.settle_s.unwrap_or_else(|| self.mission.settle_s(plan));
        begins_s + plan.end_s() + settle_s
    }
}

/// The loops of the mission's own design, each where it keeps least to instability - at the release unless it
/// stands on the ground, at the peak of a plan of the mission where there is one, and at the target - and
/// what it must keep.
pub fn own_loops(mission: &Mission, plan: Option<&Trajectory>) -> (Vec<WorstLoop>, LeastMargins) {
    let each = (0..LOOP_STATES_MOST).map(|state| own_loops_in(mission, plan, state));
    let all = each.filter(|loops| !loops.is_empty()).reduce(joined);
    (all.unwrap_or_default(), least_margins(mission))
}

/// Most states in which a mission's loops are looked at.
pub const LOOP_STATES_MOST: usize = 3;

/// The loops of [`own_loops`] in one of its states; none where there is no such state.
pub fn own_loops_in(mission: &Mission, plan: Option<&Trajectory>, state: usize) -> Vec<WorstLoop> {
    let judge = judge_of_loops(mission);
    let points = own_points(mission, &judge, plan);
    points.get(state).map_or(Vec::new(), |point| judge.worst_loops(&[*point], &own_design(mission)))
}

fn own_points(mission: &Mission, judge: &DesignJudge<'_>, plan: Option<&Trajectory>) -> Vec<OperatingPoint> {
    let mut points = judge.operating_points(plan);
    if mission.release.standing {
        points.retain(|point| point.name != RELEASE);
    }
    points
}

/// The loops of the mission's own design in the states of [`own_loops`], of the vehicle as it is known.
pub fn own_loops_at(mission: &Mission, plan: Option<&Trajectory>) -> Vec<LoopsAt> {
    let judge = judge_of_loops(mission);
    judge.loops_in(&own_points(mission, &judge, plan), &own_design(mission))
}

/// What each of a mission's loops must keep.
pub fn least_margins(mission: &Mission) -> LeastMargins {
    design_bounds(mission).margins
}

/// The loops in the states of both.
pub fn joined(loops: Vec<WorstLoop>, others: Vec<WorstLoop>) -> Vec<WorstLoop> {
    loops.into_iter().zip(&others).map(|(of, other)| of.join(other)).collect()
}

/// A judge that flies nothing.
fn judge_of_loops(mission: &Mission) -> DesignJudge<'_> {
    let flights = DesignFlights { drops: None, ..design_flights(mission) };
    judge_by(mission, flights, 0, Unknown { vehicle: false, air: false })
}

/// The judge of designs of a mission.
pub fn design_judge(mission: &Mission) -> DesignJudge<'_> {
    let unknown = Unknown { vehicle: mission.design.unknowns, air: true };
    judge_by(mission, design_flights(mission), mission.design.draws, unknown)
}

/// The judge of the first gains of a mission: by so many whole drops with everything unknown, also where
/// flights from t = 0 would leave out nothing.
pub fn first_judge(mission: &Mission, drops: usize) -> DesignJudge<'_> {
    let whole = Arc::new(MissionDrops::in_light_turbulence(mission));
    let flights = DesignFlights { drops: Some(whole), ..design_flights(mission) };
    judge_by(mission, flights, drops, Unknown { vehicle: true, air: true })
}

fn judge_by(mission: &Mission, flights: DesignFlights, draws: usize, unknown: Unknown) -> DesignJudge<'_> {
    let made_small = (mission.design.objective, design_bounds(mission));
    DesignJudge::new(mission.plan_problem(), flights, made_small, draws, unknown)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{EffectFlights, EffectsOn};
    use samara_core::assess::VerdictBuilder;
    use samara_core::control::{Airframe, ControlSettings};
    use samara_core::design::{DrawnDrop, fly_drops};
    use samara_core::plan::SolverOptions;
    use std::ops::ControlFlow;

    /// Drops that are flown once to where a design takes over, and by the mission's own from there, come out
    /// as the campaign's drops of their numbers, to the bit: canopy, battery, ring and gusts too.
    #[test]
    fn prop_drops_of_a_search_are_those_of_a_campaign() {
        let mission = Mission::shipped("x500_drop").unwrap();
        let plan = mission.solve(&SolverOptions::default(), &mut |_| ControlFlow::Continue(())).unwrap();
        let drops = MissionDrops::of(&mission).unwrap();
        let own = own_design(&mission);
        let settings = ControlSettings {
            airframe: Airframe::new(&mission.vehicle, &mission.site.environment).unwrap(),
            gains: mission.control.gains,
            limits: own.limits,
        };
        let drawn = (0..5).map(|number| {
            let simulation = drops.numbered(number, Unknown { vehicle: false, air: true });
            let seen = VerdictBuilder::judging(mission.limits, mission.target_v_ned);
            DrawnDrop::new(simulation, seen).advanced_to(drops.held_until_s())
        });
        let ends_s = drops.ends_s(&plan.trajectory);
        let along = (&plan.trajectory, mission.target_v_ned);
        let flown = fly_drops(drawn.collect(), &own, along, settings, ends_s);
        let kept = EffectsOn::All.kept(&mission.effects());
        let campaign = EffectFlights::new(&mission, &kept, &plan.trajectory).unwrap().fly_all(0..5);
        for (flown, drop) in flown.iter().zip(&campaign) {
            assert_eq!((flown.outcome, flown.objections.is_empty()), (drop.outcome, drop.safe));
        }
    }
}
