//! Judge of a design: planned, then flown from the release cases in still air and from random releases in
//! everything that the controller does not know of.

use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use nalgebra::Vector3;

use super::drops::{DrawnDrop, FlownDrop, FreshFlight, RandomDrops, Unknown, fly_drops};
use super::margins::{LoopSetting, LoopsAt, OperatingPoint, RELEASE, TARGET, loops_at, steady_near};
use super::objective::{BOUNDED, DesignBounds, DesignObjective, JudgedFlight, Judgement, LOST};
use super::operating_point::{body_of, body_of_state, shaft_energy_j};
use super::worst_loop::{LoopPlace, WorstLoop};
use super::{Design, PlanDesign};
use crate::assess::study::StudyStart;
use crate::assess::{
    Objection, Outcome, ReleaseDistribution, Scenario, StateCost, VerdictBuilder, judge_trial,
};
use crate::control::px4::timing::IMU_PERIOD_S;
use crate::control::{Airframe, ControlError, ControlSettings, Gains};
use crate::model::rigid_body::BodyState;
use crate::model::{MAX_ROTORS, Vehicle, trim};
use crate::plan::{Guess, Plan, PlanProblem, SolverOptions, Status, plan};
use crate::random::Trials;
use crate::sim::PlantKind;
use crate::sim::planar::{NotPlanar, Variation};
use crate::trajectory::{Node, Trajectory};
use crate::tune::gain_judge::{MeasuredFlight, Setting};
use crate::tune::unknowns::tipped;
use crate::tune::{GainJudge, Longitudinal, ReleaseCase};

/// Vehicle, site and limits of a design's flights.
#[derive(Clone, Debug)]
pub struct DesignFlights {
    /// Vehicle, site, air, target and limits.
    pub scenario: Scenario,
    /// Gains whose yaw part is used.
    pub yaw: Gains,
    /// How long a flight goes on after the plan's end [s].
    pub settle_s: f64,
    /// Horizon of the mission's plan [s], which times to steady flight are measured by.
    pub horizon_s: f64,
    /// Time from the release to t = 0 [s], whose fall is part of the altitude lost.
    pub delay_s: f64,
    /// Releases that every design flies in still air.
    pub cases: Vec<ReleaseCase>,
    /// Random releases, with what the controller does not know of.
    pub releases: ReleaseDistribution,
    /// Seed of all that is drawn.
    pub seed: u64,
    /// Whether the air of the random flights is the mission's own: then one that is never steady is not safe.
    /// In turbulence that the mission does not name a vehicle need not come to rest within what is steady.
    pub own_air: bool,
    /// Whole drops in place of random flights from t = 0, where those leave out what the mission names.
    pub drops: Option<Arc<dyn RandomDrops>>,
}

impl DesignFlights {
    /// The random flight of this number.
    pub fn draw(&self, number: u64, unknown: Unknown) -> (BodyState, Variation) {
        let known = self.releases.with_uncertain(None);
        let releases = if unknown.vehicle { &self.releases } else { &known };
        let StudyStart { state, variation, .. } = (&releases.draw(self.seed, number)).into();
        (state, Variation { air: unknown.air.then_some(number + 1), ..variation })
    }

    /// Pilot of the flights along the plan of a design.
    ///
    /// # Errors
    /// [`ControlError`] for a vehicle that cannot be controlled.
    pub fn pilot<'p>(&self, plan: &'p Trajectory, design: &Design) -> Result<GainJudge<'p>, ControlError> {
        GainJudge::new(Setting {
            scenario: self.scenario.clone(),
            control_limits: design.limits,
            plant: PlantKind::Actuator,
            yaw: self.yaw,
            plan,
            feed_forward: design.feed_forward,
            settle_s: self.settle_s,
        })
    }

    /// A whole drop that has not begun.
    fn drawn(&self, drops: &dyn RandomDrops, number: u64, unknown: Unknown) -> DrawnDrop {
        let Scenario { limits, target_v_ned, .. } = &self.scenario;
        DrawnDrop::new(drops.numbered(number, unknown), VerdictBuilder::judging(*limits, *target_v_ned))
    }

    /// Flies whole drops by a design along its plan; none of a vehicle that cannot be controlled.
    fn fly_drops(
        &self,
        source: &dyn RandomDrops,
        drops: Vec<DrawnDrop>,
        design: &Design,
        plan: &Trajectory,
    ) -> Vec<FlownDrop> {
        let Scenario { vehicle, environment, target_v_ned, .. } = &self.scenario;
        let Ok(airframe) = Airframe::new(vehicle, environment) else { return Vec::new() };
        let Gains { k_ppsi, k_pr, .. } = self.yaw;
        let gains = Gains { k_ppsi, k_pr, ..Gains::longitudinal(design.gains) };
        let settings = ControlSettings { airframe, gains, limits: design.limits };
        fly_drops(drops, design, (plan, *target_v_ned), settings, source.ends_s(plan))
    }

    /// Flies the random flights of these numbers by a design: whole drops where there are any, or from t = 0.
    pub(super) fn fly_fresh(
        &self,
        numbers: Range<u64>,
        unknown: Unknown,
        (pilot, design, plan): (&GainJudge<'_>, &Design, &Trajectory),
    ) -> Vec<FreshFlight> {
        if let Some(source) = self.drops.as_deref() {
            let drops = numbers.map(|number| self.drawn(source, number, unknown)).collect();
            let flown = self.fly_drops(source, drops, design, plan);
            return flown.iter().map(|flown| flown.fresh(&self.scenario.target_v_ned)).collect();
        }
        let drawn: Vec<_> = numbers.map(|number| self.draw(number, unknown)).collect();
        let flown = pilot.measure_others(&design.gains, &drawn);
        drawn
            .iter()
            .zip(&flown)
            .map(|((start, _), flight)| {
                let JudgedFlight { j_tpf, safe, within_limits, .. } = self.judged(start, flight);
                let outcome = Outcome { j_tpf, ..flight.outcome };
                FreshFlight { outcome, safe, within_limits, end_error_m_s: flight.end_error_m_s }
            })
            .collect()
    }

    /// Altitude that a flight from this state has lost at the plan's end, since the release [m].
    fn altitude_lost_m(&self, start: &BodyState, flight: &MeasuredFlight) -> f64 {
        let t = self.delay_s;
        let fall_m = start.v_ned.z * t - 0.5 * self.scenario.environment.gravity_m_s2 * t * t;
        fall_m + flight.outcome.altitude_lost_m
    }

    /// A flight from this state, judged.
    pub(super) fn judged(&self, start: &BodyState, flight: &MeasuredFlight) -> JudgedFlight {
        let j_tpf = finite_j_tpf(flight);
        let altitude_lost_m = self.altitude_lost_m(start, flight);
        let flown = Outcome { j_tpf, altitude_lost_m, ..flight.outcome };
        let objections = judge_trial(&flown, &self.scenario.limits);
        let within_limits = objections.iter().all(Objection::is_of_the_course);
        let steady_share = JudgedFlight::share_of(flown.steady_after_s, self.horizon_s);
        JudgedFlight { j_tpf, steady_share, safe: objections.is_empty(), within_limits }
    }

    /// Whether the judge of all flights objects to nothing in a flight from this state.
    pub fn is_safe(&self, start: &BodyState, flight: &MeasuredFlight) -> bool {
        self.judged(start, flight).safe
    }
}

/// Delay beyond which no margin is told [s].
const DELAY_MOST_S: f64 = 10.0;

/// Flights between two looks at whether a design is beaten.
const PORTION: usize = 32;

/// Judge of designs, the same flights for each.
#[derive(Clone, Debug)]
pub struct DesignJudge<'a> {
    problem: PlanProblem<'a>,
    flights: DesignFlights,
    objective: DesignObjective,
    bounds: DesignBounds,
    /// Release cases, first as they are, then with their pitch off.
    cases: Vec<(BodyState, Variation)>,
    draws: Vec<(BodyState, Variation)>,
    /// Whole drops in their place, up to where a design takes over.
    drops: Vec<DrawnDrop>,
    /// Steady flight at the target, of the vehicle as it flies; `None` where there is none.
    target: Option<OperatingPoint>,
    /// The vehicle as it is known, and others near it, whose loops must be stable too: each with how far it
    /// is off.
    vehicles: Vec<(Variation, Arc<Vehicle>)>,
}

impl<'a> DesignJudge<'a> {
    /// A judge by the release cases and this many random flights with these unknowns. `problem` is the
    /// mission's own.
    pub fn new(
        problem: PlanProblem<'a>,
        flights: DesignFlights,
        (objective, bounds): (DesignObjective, DesignBounds),
        draws: usize,
        unknown: Unknown,
    ) -> Self {
        let states: Vec<BodyState> = flights.cases.iter().map(ReleaseCase::state).collect();
        let mut cases: Vec<_> = states.iter().map(|state| (*state, Variation::NONE)).collect();
        cases.extend(tipped(&states));
        let numbers = (Trials::Search.first()..).take(draws);
        let (mut draws, mut drops) = (Vec::new(), Vec::new());
        match flights.drops.as_deref() {
            Some(source) => {
                let drawn = numbers.map(|number| flights.drawn(source, number, unknown));
                drops = drawn.map(|drop| drop.advanced_to(source.held_until_s())).collect();
            }
            None => draws = numbers.map(|number| flights.draw(number, unknown)).collect(),
        }
        let target = steady_at_target(&problem);
        let vehicles = vehicles_near(&problem);
        Self { problem, flights, objective, bounds, cases, draws, drops, target, vehicles }
    }

    /// The flights.
    pub fn flights(&self) -> &DesignFlights {
        &self.flights
    }

    /// What is made small, and within which bounds.
    pub fn objective(&self) -> (DesignObjective, DesignBounds) {
        (self.objective, self.bounds)
    }

    /// How many flights judge a design.
    pub fn count(&self) -> usize {
        self.cases.len() + self.draws.len() + self.drops.len()
    }

    /// Plans a design; `None` when it cannot be planned or the solve does not converge.
    pub fn plan(&self, design: &PlanDesign) -> Option<Plan> {
        let mut problem = self.problem.clone();
        design.apply(&mut problem, &self.flights.scenario.limits.safety);
        let options = SolverOptions::default();
        let planned = plan(&problem, &Guess::StraightLine, &options, &mut |_| ControlFlow::Continue(()));
        planned.ok().filter(|plan| plan.status == Status::Converged)
    }

    /// Why flights are not flown in the vertical plane; `None` where they are.
    pub fn one_at_a_time(&self, design: &Design) -> Option<NotPlanar> {
        let plan = self.plan(&design.plan)?;
        let pilot = self.flights.pilot(&plan.trajectory, design).ok()?;
        pilot.one_at_a_time().cloned()
    }

    /// The loops of a design, linearised at the release, at the plan's greatest J_state and at the target.
    /// `None` when it has no plan.
    pub fn loops(&self, design: &Design) -> Option<Vec<LoopsAt>> {
        let points = self.operating_points(Some(&self.plan(&design.plan)?.trajectory));
        points.iter().map(|point| self.loops_at(point, self.problem.vehicle, design)).collect()
    }

    /// The loops of a design in these states, of the vehicle as it is known.
    pub fn loops_in(&self, points: &[OperatingPoint], design: &Design) -> Vec<LoopsAt> {
        points.iter().filter_map(|point| self.loops_at(point, self.problem.vehicle, design)).collect()
    }

    /// Where loops are linearised: at the release, at the plan's greatest J_state where there is a plan, and
    /// at the target where a steady flight is found there.
    pub fn operating_points(&self, plan: Option<&Trajectory>) -> Vec<OperatingPoint> {
        let problem = &self.problem;
        let nodes = plan.map_or(&[][..], Trajectory::nodes);
        let peak = nodes.iter().max_by(|a, b| {
            let j_state = |node| StateCost::of(&body_of(node), &self.flights.scenario.limits.safety).max();
            j_state(a).total_cmp(&j_state(b))
        });
        let of_weight_n = problem.vehicle.mass.mass_kg * problem.environment.gravity_m_s2
            / problem.vehicle.rotors.len().max(1) as f64;
        // Rotors at rest answer to nothing: they carry the weight here.
        let release = OperatingPoint {
            name: RELEASE,
            body: nodes.first().map_or_else(|| body_of_state(&problem.initial), body_of),
            thrust_n: [of_weight_n; MAX_ROTORS],
        };
        let at_peak = |node: &Node| OperatingPoint {
            name: "plan's peak",
            body: body_of(node),
            thrust_n: node.thrust_n,
        };
        [Some(release), peak.map(at_peak), self.target].into_iter().flatten().collect()
    }

    fn loops_at(&self, point: &OperatingPoint, vehicle: &Vehicle, design: &Design) -> Option<LoopsAt> {
        let yaw = &self.flights.yaw;
        let setting = LoopSetting {
            vehicle,
            known: self.problem.vehicle,
            environment: self.problem.environment,
            gains: &Gains { k_ppsi: yaw.k_ppsi, k_pr: yaw.k_pr, ..Gains::longitudinal(design.gains) },
            tilt_from: design.limits.tilt_from,
            thrust_curve: design.limits.thrust_curve,
            period_s: IMU_PERIOD_S,
        };
        loops_at(&setting, point).ok()
    }

    /// Each loop of a design where it keeps least to instability, of the vehicle as it is known and of others
    /// near it at each of these states; in the order of [`LOOPS`](super::LOOPS).
    pub fn worst_loops(&self, points: &[OperatingPoint], design: &Design) -> Vec<WorstLoop> {
        let mut worst: Vec<WorstLoop> = Vec::new();
        for point in points {
            for (off, vehicle) in &self.vehicles {
                let loops = self.loops_at(point, vehicle, design).map(|at| at.loops).unwrap_or_default();
                let place = LoopPlace { state: point.name, off: *off };
                for (i, (_, margins)) in loops.iter().enumerate() {
                    match worst.get_mut(i) {
                        Some(worst) => worst.note(margins, place),
                        None => worst.push(WorstLoop::of(i, margins, place)),
                    }
                }
            }
        }
        worst
    }

    /// What the loops of a design keep to instability along a plan, of each vehicle at each state: the least
    /// distance of a response from -1 ([`Judgement::modulus`]) and the least delay [s]
    /// ([`Judgement::delay_s`]).
    pub fn least_margins(&self, plan: &Trajectory, design: &Design) -> (f64, f64) {
        let worst = self.worst_loops(&self.operating_points(Some(plan)), design);
        let modulus = worst.iter().fold(1.0, |least: f64, of| least.min(of.modulus.0));
        let delays_s = worst.iter().filter_map(|of| of.delay_s).map(|(delay_s, _)| delay_s);
        let delay_s = delays_s.fold(DELAY_MOST_S, f64::min);
        if worst.iter().all(|of| of.unstable.is_none()) { (modulus, delay_s) } else { (-modulus, 0.0) }
    }

    /// Plans and flies a design, until it is known to cost more than `ceiling`.
    pub fn judge(&self, design: &Design, ceiling: f64) -> Judgement {
        let Some(plan) = self.plan(&design.plan) else { return Judgement::UNPLANNED };
        let Ok(pilot) = self.flights.pilot(&plan.trajectory, design) else {
            return Judgement::UNPLANNED;
        };
        let energy_j = shaft_energy_j(&self.problem, &plan.trajectory);
        let (modulus, delay_s) = self.least_margins(&plan.trajectory, design);
        let in_cases = Judgement { energy_j, modulus, delay_s, ..self.judge_cases(&pilot, &design.gains) };
        let of = self.draws.len() + self.drops.len();
        let mut judged = in_cases.with_draws(self.objective, &[], of);
        let mut drawn = Vec::with_capacity(of);
        for from in (0..of).step_by(PORTION) {
            if judged.cost(&self.bounds) > ceiling {
                break;
            }
            let to = of.min(from + PORTION);
            drawn.extend(self.judge_draws(&pilot, design, &plan.trajectory, from..to));
            judged = in_cases.with_draws(self.objective, &drawn, of);
        }
        judged
    }

    /// Flies the judge's whole drops of these places by a design along a plan; none where there are no drops,
    /// or of a vehicle that cannot be controlled.
    pub fn fly_drops(&self, places: Range<usize>, design: &Design, plan: &Trajectory) -> Vec<FlownDrop> {
        let Some(source) = self.flights.drops.as_deref() else { return Vec::new() };
        self.flights.fly_drops(source, self.drops[places].to_vec(), design, plan)
    }

    /// Random flights by their place.
    fn judge_draws(
        &self,
        pilot: &GainJudge<'_>,
        design: &Design,
        plan: &Trajectory,
        places: Range<usize>,
    ) -> Vec<JudgedFlight> {
        let own_air = self.flights.own_air;
        let strict = |flight: JudgedFlight| {
            let within_limits = if own_air { flight.safe } else { flight.within_limits };
            JudgedFlight { within_limits, ..flight }
        };
        if self.flights.drops.is_some() {
            let flown = self.fly_drops(places, design, plan);
            return flown.iter().map(|drop| strict(drop.judged(self.flights.horizon_s))).collect();
        }
        let portion = &self.draws[places];
        let flown = pilot.measure_others(&design.gains, portion);
        let starts = portion.iter().map(|(start, _)| start);
        starts.zip(&flown).map(|(start, flight)| strict(self.flights.judged(start, flight))).collect()
    }

    fn judge_cases(&self, pilot: &GainJudge<'_>, k: &Longitudinal) -> Judgement {
        let flown = pilot.measure_others(k, &self.cases);
        let end_s = pilot.duration_s();
        let mut judged = Judgement {
            j_tpf: 0.0,
            mean: 0.0,
            steady_share: 0.0,
            worst: 0.0,
            over_limit: 0.0,
            unrest: 0.0,
            most: [0.0; BOUNDED.len()],
            energy_j: 0.0,
            modulus: 0.0,
            delay_s: 0.0,
            flights: flown.len() as f64,
        };
        for (i, ((start, _), flight)) in self.cases.iter().zip(&flown).enumerate() {
            let JudgedFlight { j_tpf, within_limits, .. } = self.flights.judged(start, flight);
            judged.worst = judged.worst.max(j_tpf);
            judged.over_limit += f64::from(u8::from(!within_limits));
            if i >= self.flights.cases.len() {
                continue;
            }
            // What is lost is far off in everything, by finite numbers.
            let lost = !flight.evaluation.is_finite();
            let or_far = |x: f64, far: f64| if lost { far } else { x };
            judged.unrest = judged.unrest.max(or_far(flight.evaluation.unrest, 1.0));
            let now = [
                flight.outcome.steady_after_s.unwrap_or(end_s),
                or_far(self.flights.altitude_lost_m(start, flight), 1e6),
                or_far(flight.outcome.peak_tilt_deg, 180.0),
            ];
            judged.most.iter_mut().zip(now).for_each(|(most, x)| *most = most.max(x));
        }
        judged
    }
}

/// How far the motors' time constants and the rotors' thrusts may be off what is known, one at a time, with
/// the loops where they must be.
const MOTOR_LAGS: [f64; 2] = [0.7, 1.5];
const THRUSTS: [f64; 2] = [0.85, 1.15];

/// The vehicle as it is known, and others near it, each with how far it is off.
fn vehicles_near(problem: &PlanProblem<'_>) -> Vec<(Variation, Arc<Vehicle>)> {
    let lags = MOTOR_LAGS.map(|motor_lag| Variation { motor_lag, ..Variation::NONE });
    let thrusts = THRUSTS.map(|thrust| Variation { thrust, ..Variation::NONE });
    let all = std::iter::once(Variation::NONE).chain(lags).chain(thrusts);
    all.filter_map(|off| Some((off, off.applied(problem.vehicle, problem.environment)?.0))).collect()
}

/// Steady flight at the target, of the vehicle as it flies; `None` where there is none.
fn steady_at_target(problem: &PlanProblem<'_>) -> Option<OperatingPoint> {
    let trimmed = trim(problem.vehicle, problem.environment, problem.target_v_ned, 0.0).ok()?;
    let body = BodyState {
        p_ned: Vector3::zeros(),
        q_ned_from_body: trimmed.q_ned_from_body,
        v_ned: problem.target_v_ned,
        omega_body: Vector3::zeros(),
    };
    let trimmed = OperatingPoint { name: TARGET, body, thrust_n: trimmed.thrust_n };
    steady_near(problem.vehicle, problem.environment, &trimmed).ok()?.or(Some(trimmed))
}

/// J_TPF of a flight; [`LOST`] for one that was lost or is beyond it.
fn finite_j_tpf(flight: &MeasuredFlight) -> f64 {
    // What is no number is lost, too.
    if flight.evaluation.j_tpf < LOST { flight.evaluation.j_tpf } else { LOST }
}
