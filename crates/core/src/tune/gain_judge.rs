//! Cost of a set of gains: its flights along the plan, judged in tracking (45)-(46), safety (51) and
//! steadiness.
//!
//! Flights begin at t = 0 of the study with the rotors at rest, are flown by the cascade at the study's
//! control period and go on after the plan's end with the target velocity commanded. Vehicles that are
//! symmetric about their x-z plane are flown in that plane ([`crate::sim::planar`]), others, and under other
//! controllers, in six degrees of freedom: eight at a time there too, where as many have the same vehicle
//! ([`crate::sim::many`]). The controller does not know of the variations of a robust tuning.

use std::fmt;
use std::ops::ControlFlow;

use super::objective::{Evaluation, Objective};
use super::unknowns::{one_at_a_time, tipped};
use super::{Longitudinal, ReleaseCase};
use crate::assess::Scenario;
use crate::assess::flights::Outcomes;
use crate::assess::safety::FlightWatch;
use crate::assess::study::StudyStart;
use crate::assess::tracking::{PITCH_MAX_RAD, SPEED_MAX_M_S, control_period_s};
use crate::assess::{BatchFlight, BatchMeasure, Outcome, ReleaseDistribution, TrackingError, judge_flights};
use crate::control::{Airframe, Cascade, ControlError, ControlLimits, Controller, Gains};
use crate::frames::pitch;
use crate::model::rigid_body::BodyState;
use crate::random::Trials;
use crate::sim::planar::{Flight, LANES, Model, NotPlanar, Release, Variation};
use crate::sim::{self, DropSimulation, FlightPlan, PlantKind, Reference, Sample, Watch, fly, fly_many};
use crate::trajectory::Trajectory;
use crate::uncertain::Uncertainty;
use crate::units::DEG_PER_RAD;

/// A flight is at rest when it is steady from so long before its end [s].
const STEADY_FOR_S: f64 = 1.0;
/// What a flight that is not at rest costs at the least, as a fraction of the target velocity.
const UNREST_LEAST: f64 = 0.01;

/// Vehicle, site, plan and limits of the flights that gains are judged by.
#[derive(Clone, Debug)]
pub struct Setting<'a> {
    /// Vehicle, site, air, target and limits.
    pub scenario: Scenario,
    /// Limits of the cascade.
    pub control_limits: ControlLimits,
    /// The actuators.
    pub plant: PlantKind,
    /// Gains whose yaw part is used.
    pub yaw: Gains,
    /// The plan to follow.
    pub plan: &'a Trajectory,
    /// Whether its acceleration is fed forward.
    pub feed_forward: bool,
    /// How long a flight goes on after the plan's end [s].
    pub settle_s: f64,
}

/// One of the flights that gains are judged by.
#[derive(Clone, Copy, Debug)]
struct Trial {
    start: BodyState,
    variation: Variation,
    /// Whether it is judged by tracking and steadiness too.
    tracked: bool,
}

/// Where and why a flight was lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// It became too fast or turned too far.
    Diverged {
        /// Time since the rotors were freed [s].
        t_s: f64,
        /// Speed then [m/s]; not a number where the state was none.
        speed_m_s: f64,
        /// Pitch then [rad].
        pitch_rad: f64,
    },
    /// The varied vehicle is none: its mass or inertia is out of bounds.
    NoVehicle,
}

/// One of the flights that gains were judged by, and how they lost it.
#[derive(Clone, Debug, PartialEq)]
pub struct LostFlight {
    /// Which flight, from 1.
    pub number: usize,
    /// How many there are.
    pub of: usize,
    /// The state that it was released in.
    pub start: BodyState,
    /// What the controller did not know of.
    pub variation: Variation,
    /// How it was lost.
    pub loss: Loss,
}

impl fmt::Display for LostFlight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (v, start_pitch) = (&self.start.v_ned, pitch(self.start.q_ned_from_body));
        write!(
            f,
            "flight {} of {}, released at [{:.2} {:.2} {:.2}] m/s, pitch {:.1} deg and {:.1} deg/s, ",
            self.number,
            self.of,
            v.x,
            v.y,
            v.z,
            start_pitch * DEG_PER_RAD,
            self.start.omega_body.y * DEG_PER_RAD,
        )?;
        if self.variation != Variation::NONE {
            let Variation { mass, inertia, aero, density, thrust, motor_lag, wind_m_s, latency_s, air } =
                &self.variation;
            write!(
                f,
                "unknown to the controller mass x {mass:.2}, inertia x {inertia:.2}, air loads x {aero:.2?}, \
                 density x {density:.2}, thrust x {thrust:.2}, motor lag x {motor_lag:.2}, wind {wind_m_s:.1?} m/s, \
                 latency {latency_s:.3} s{}, ",
                if air.is_some() { ", gusts and turbulence" } else { "" },
            )?;
        }
        match self.loss {
            Loss::Diverged { t_s, speed_m_s, pitch_rad } => write!(
                f,
                "was given up {t_s:.2} s after the rotors were freed, at {speed_m_s:.1} m/s and {:.0} deg of \
                 pitch: at most {SPEED_MAX_M_S:.0} m/s and {:.0} deg are flown on",
                pitch_rad * DEG_PER_RAD,
                PITCH_MAX_RAD * DEG_PER_RAD,
            ),
            Loss::NoVehicle => f.write_str("has a vehicle whose mass or inertia is out of bounds"),
        }
    }
}

/// One flight and what bounds may be set on beside its costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredFlight {
    /// Costs of the flight.
    pub evaluation: Evaluation,
    /// What the flight came to; its way begins at t = 0.
    pub outcome: Outcome,
    /// Distance of the velocity from the target at the end [m/s].
    pub end_error_m_s: f64,
}

impl MeasuredFlight {
    /// A flight that was lost.
    pub fn lost() -> Self {
        let (evaluation, outcome) = (Evaluation::DIVERGED, Outcome::lost());
        Self { evaluation, outcome, end_error_m_s: f64::INFINITY }
    }
}

/// Flights to judge gains by.
#[derive(Clone, Debug)]
pub struct GainJudge<'a> {
    setting: Setting<'a>,
    airframe: Airframe,
    /// The batch engine's model, or why there is none.
    planar: Result<(Model, BatchMeasure), NotPlanar>,
    trials: Vec<Trial>,
}

impl<'a> GainJudge<'a> {
    /// A judge without flights.
    ///
    /// # Errors
    /// [`ControlError`] when the rotors cannot be flown.
    pub fn new(setting: Setting<'a>) -> Result<Self, ControlError> {
        let airframe = Airframe::new(&setting.scenario.vehicle, &setting.scenario.environment)?;
        let planar = planar(&setting);
        Ok(Self { setting, airframe, planar, trials: Vec::new() })
    }

    /// Adds the flights of (46), judged in everything.
    pub fn with_cases(mut self, cases: &[ReleaseCase]) -> Self {
        let trial = |c: &ReleaseCase| Trial { start: c.state(), variation: Variation::NONE, tracked: true };
        self.trials.extend(cases.iter().map(trial));
        self
    }

    /// Adds flights from these states, judged by J_TPF.
    pub fn with_states(mut self, states: &[BodyState]) -> Self {
        self.trials.extend(states.iter().map(|s| untracked(&(*s, Variation::NONE))));
        self
    }

    /// Adds the cases with what is uncertain at its ends, one thing at a time, judged by J_TPF.
    pub fn with_variations(mut self, cases: &[ReleaseCase], uncertain: &Uncertainty) -> Self {
        let scenario = &self.setting.scenario;
        let states: Vec<BodyState> = cases.iter().map(ReleaseCase::state).collect();
        let (g, windy) = (scenario.environment.gravity_m_s2, scenario.wind.changes());
        let trials = one_at_a_time(&states, uncertain, g, windy);
        self.trials.extend(trials.iter().map(untracked));
        self
    }

    /// Adds these states with a pitch that is off ([`super::unknowns`]), judged by J_TPF.
    pub fn with_tipped(mut self, states: &[BodyState]) -> Self {
        self.trials.extend(tipped(states).iter().map(untracked));
        self
    }

    /// Adds random releases with everything that is uncertain of them at once, in the mission's air, judged
    /// by J_TPF: draws that no campaign of the seed has among its trials.
    pub fn with_draws(mut self, releases: &ReleaseDistribution, seed: u64, draws: usize) -> Self {
        let drawn = (Trials::Search.first()..).take(draws).map(|number| {
            let StudyStart { state, air, variation } = (&releases.draw(seed, number)).into();
            untracked(&(state, Variation { air: Some(air), ..variation }))
        });
        self.trials.extend(drawn);
        self
    }

    /// Length of the flights, from t = 0 [s].
    pub fn duration_s(&self) -> f64 {
        duration_s(&self.setting)
    }

    /// How many flights a candidate is judged by.
    pub fn flights(&self) -> usize {
        self.trials.len()
    }

    /// The worst of a candidate's flights.
    pub fn evaluate(&self, k: &Longitudinal) -> Evaluation {
        self.fly(k).into_iter().fold(Evaluation::PERFECT, Evaluation::worse)
    }

    /// The worst of a candidate's flights, or of some of them that show already that it costs more than
    /// `ceiling`. After those of the first cases come the last ones: releases far out, variations.
    pub fn evaluate_below(&self, k: &Longitudinal, objective: &Objective, ceiling: f64) -> Evaluation {
        let together = match self.planar {
            Ok(_) => vec![(0..self.trials.len()).collect()],
            Err(_) => beside_each_other(&self.trials),
        };
        let mut groups = together.iter().flat_map(|group: &Vec<usize>| group.chunks(LANES));
        let first = groups.next();
        let mut worst = Evaluation::PERFECT;
        for group in first.into_iter().chain(groups.rev()) {
            let trials: Vec<Trial> = group.iter().map(|i| self.trials[*i]).collect();
            worst = self.fly_trials(k, &trials).into_iter().fold(worst, Evaluation::worse);
            if objective.cost(&worst) > ceiling {
                break;
            }
        }
        worst
    }

    /// A candidate's flights, in the order in which they were added.
    pub fn fly(&self, k: &Longitudinal) -> Vec<Evaluation> {
        self.fly_trials(k, &self.trials)
    }

    /// The worst of the flights under another controller than the cascade; each is flown in six degrees of
    /// freedom.
    pub fn evaluate_controller(&self, controller: &dyn Controller) -> Evaluation {
        let flown = self.measure_in_space(controller, &self.trials);
        flown.into_iter().map(|flight| flight.evaluation).fold(Evaluation::PERFECT, Evaluation::worse)
    }

    /// The first of a candidate's flights that is lost, flown again in six degrees of freedom; `None` when
    /// none is.
    pub fn first_lost(&self, k: &Longitudinal) -> Option<LostFlight> {
        let cascade = self.cascade(k);
        self.trials.iter().enumerate().find_map(|(i, trial)| {
            let loss = self.loss(&cascade, trial)?;
            Some(LostFlight {
                number: i + 1,
                of: self.trials.len(),
                start: trial.start,
                variation: trial.variation,
                loss,
            })
        })
    }

    /// Why the cascade's flights are not flown in the vertical plane; `None` where they are.
    pub fn one_at_a_time(&self) -> Option<&NotPlanar> {
        self.planar.as_ref().err()
    }

    /// Other flights than the judge's own, judged in everything, with what bounds may be set on.
    pub fn measure_others(&self, k: &Longitudinal, others: &[(BodyState, Variation)]) -> Vec<MeasuredFlight> {
        let trial = |&(start, variation): &(BodyState, Variation)| Trial { start, variation, tracked: true };
        self.measure_trials(k, &others.iter().map(trial).collect::<Vec<_>>())
    }

    fn fly_trials(&self, k: &Longitudinal, trials: &[Trial]) -> Vec<Evaluation> {
        self.measure_trials(k, trials).into_iter().map(|flight| flight.evaluation).collect()
    }

    fn measure_trials(&self, k: &Longitudinal, trials: &[Trial]) -> Vec<MeasuredFlight> {
        let gains = self.gains(k);
        let flight =
            |t: &Trial| Some(Flight { gains, release: Release::of(&t.start).ok()?, variation: t.variation });
        let flights: Option<Vec<Flight>> = trials.iter().map(flight).collect();
        match (&self.planar, flights) {
            (Ok((model, measure)), Some(flights)) => {
                let mut judged = vec![BatchFlight::default(); flights.len()];
                judge_flights(model, measure, &flights, &mut judged);
                trials.iter().zip(&judged).map(|(trial, flight)| self.judged(trial, flight)).collect()
            }
            _ => self.measure_in_space(&self.cascade(k), trials),
        }
    }

    fn gains(&self, k: &Longitudinal) -> Gains {
        let yaw = &self.setting.yaw;
        Gains { k_ppsi: yaw.k_ppsi, k_pr: yaw.k_pr, ..Gains::longitudinal(*k) }
    }

    fn cascade(&self, k: &Longitudinal) -> Cascade {
        Cascade::new(self.airframe.clone(), self.gains(k), self.setting.control_limits)
    }

    /// Flights in six degrees of freedom, side by side.
    fn measure_in_space(&self, controller: &dyn Controller, trials: &[Trial]) -> Vec<MeasuredFlight> {
        let mut measured = vec![MeasuredFlight::lost(); trials.len()];
        for group in beside_each_other(trials) {
            // A varied vehicle may be none.
            let flight = |i: usize| Some((i, self.flight(controller, &trials[i])?));
            let (group, flights): (Vec<usize>, Vec<_>) = group.into_iter().filter_map(flight).unzip();
            let watches = flights.iter().map(|flight| self.watch(&flight.simulation.state().body)).collect();
            let tracking = vec![TrackingError::new(self.setting.plan); flights.len()];
            let lost = vec![false; flights.len()];
            let mut watch = Tracked { outcomes: Outcomes::by(watches), tracking, lost };
            fly_many(flights, &mut watch);
            let Tracked { outcomes, tracking, lost } = watch;
            for (place, outcome) in outcomes.finish().into_iter().enumerate().filter(|(i, _)| !lost[*i]) {
                let i = group[place];
                measured[i] = self.measured(&trials[i], tracking[place].rms(), outcome);
            }
        }
        measured
    }

    fn judged(&self, trial: &Trial, flight: &BatchFlight) -> MeasuredFlight {
        let BatchFlight { outcome, rms, given_up } = flight;
        if *given_up || !outcome.j_tpf.is_finite() {
            return MeasuredFlight::lost();
        }
        self.measured(trial, *rms, *outcome)
    }

    fn measured(&self, trial: &Trial, rms: f64, outcome: Outcome) -> MeasuredFlight {
        let end_error_m_s = (outcome.final_v_ned() - self.setting.scenario.target_v_ned).norm();
        MeasuredFlight {
            evaluation: self.evaluation(trial, rms, &outcome, end_error_m_s),
            outcome,
            end_error_m_s,
        }
    }

    fn evaluation(&self, trial: &Trial, rms: f64, outcome: &Outcome, end_error_m_s: f64) -> Evaluation {
        let Outcome { j_tpf, steady_after_s, .. } = *outcome;
        if !trial.tracked {
            return Evaluation { rms: 0.0, j_tpf, unrest: 0.0 };
        }
        let at_rest = steady_after_s.is_some_and(|t| t <= duration_s(&self.setting) - STEADY_FOR_S);
        let Scenario { target_v_ned, limits, .. } = &self.setting.scenario;
        let away = end_error_m_s / target_v_ned.norm().max(limits.steady_within_m_s);
        Evaluation { rms, j_tpf, unrest: if at_rest { 0.0 } else { away.max(UNREST_LEAST) } }
    }

    /// A flight in six degrees of freedom that has not begun; `None`: its varied vehicle is none.
    fn flight(&self, controller: &dyn Controller, trial: &Trial) -> Option<sim::Flight<'_>> {
        let setting = &self.setting;
        let Trial { start, variation, .. } = trial;
        let Scenario { vehicle, environment, .. } = &setting.scenario;
        // An ideal plant is what it is made of.
        let is_known = setting.plant == PlantKind::Actuator;
        let (vehicle, environment) = if is_known {
            (vehicle.clone(), variation.blown(environment))
        } else {
            variation.applied(vehicle, environment)?
        };
        let air = variation.air;
        let course =
            air.and_then(|number| setting.scenario.wind.uniform(&environment).course(&environment, number));
        let mut simulation = DropSimulation::at_t0(vehicle, environment, *start, setting.plant)
            .in_wind(course)
            .on_battery(setting.scenario.battery.clone());
        if is_known {
            simulation = simulation.varied(variation.factors(), variation.latency_s);
        }
        Some(sim::Flight {
            simulation,
            controller: controller.clone_controller(),
            plan: flight_plan(setting),
        })
    }

    /// What watches a flight from a state.
    fn watch(&self, start: &BodyState) -> FlightWatch<'_> {
        let setting = &self.setting;
        let plan_end_s = setting.plan.end_s() + 0.5 * control_period_s(setting.plan);
        FlightWatch::new(&setting.scenario, start.p_ned, plan_end_s)
    }

    /// How a flight in six degrees of freedom is lost, if it is.
    fn loss(&self, controller: &dyn Controller, trial: &Trial) -> Option<Loss> {
        let Some(sim::Flight { simulation: mut sim, mut controller, plan }) = self.flight(controller, trial)
        else {
            return Some(Loss::NoVehicle);
        };
        let mut tracking = TrackingError::new(self.setting.plan);
        let flown = fly(&mut sim, &mut *controller, &plan, &mut |sample| tracking.observe(sample));
        let end = &sim.state().body;
        flown.is_break().then(|| Loss::Diverged {
            t_s: sim.time_powered_s().unwrap_or(0.0),
            speed_m_s: end.v_ned.norm(),
            pitch_rad: pitch(end.q_ned_from_body),
        })
    }
}

/// The places of trials, those together that may fly side by side: in air that changes, or not.
fn beside_each_other(trials: &[Trial]) -> Vec<Vec<usize>> {
    let alike = |trial: &Trial| trial.variation.air.is_some();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (i, trial) in trials.iter().enumerate() {
        match groups.iter_mut().find(|group| alike(&trials[group[0]]) == alike(trial)) {
            Some(group) => group.push(i),
            None => groups.push(vec![i]),
        }
    }
    groups
}

/// Outcomes of flights and how well they track the plan.
struct Tracked<'a> {
    outcomes: Outcomes<'a>,
    tracking: Vec<TrackingError<'a>>,
    /// Which flights were given up.
    lost: Vec<bool>,
}

impl Watch for Tracked<'_> {
    fn take(&mut self, flight: usize, sample: &Sample) -> ControlFlow<()> {
        let _ = self.outcomes.take(flight, sample);
        let flown = self.tracking[flight].observe(sample);
        self.lost[flight] = flown.is_break();
        flown
    }

    #[cfg(target_arch = "x86_64")]
    fn take_abreast(&mut self, first: usize, count: usize, samples: &sim::watch::Samples<'_>) -> bool {
        let t_s = samples.t_powered_s.unwrap_or(f64::NAN);
        let going = || (0..count).filter(|i| !self.lost[first + i]);
        // What the sum of squares takes, and what may be given up, is looked at one by one.
        let motion = &samples.craft.motion;
        let in_hand = |i: usize| {
            let [vx, vy, vz] = [motion.v_ned.x, motion.v_ned.y, motion.v_ned.z].map(|v| v.as_array()[i]);
            self.tracking[first + i].takes_nothing(
                t_s,
                vx * vx + vy * vy + vz * vz,
                motion.q_ned_from_body[0].as_array()[i],
            )
        };
        going().all(in_hand) && self.outcomes.take_abreast(first, count, samples)
    }
}

fn untracked(&(start, variation): &(BodyState, Variation)) -> Trial {
    Trial { start, variation, tracked: false }
}

fn duration_s(setting: &Setting<'_>) -> f64 {
    setting.plan.end_s() + setting.settle_s
}

fn flight_plan<'a>(setting: &Setting<'a>) -> FlightPlan<'a> {
    FlightPlan::new(
        Reference::Plan {
            trajectory: setting.plan,
            then_v_ned: Some(setting.scenario.target_v_ned),
            feed_forward: setting.feed_forward,
        },
        control_period_s(setting.plan),
        duration_s(setting),
    )
}

fn planar(setting: &Setting<'_>) -> Result<(Model, BatchMeasure), NotPlanar> {
    let Setting { scenario, control_limits, plant, .. } = setting;
    let Scenario { vehicle, environment, wind, battery, target_v_ned: v, limits } = scenario;
    // An ideal plant has no motors.
    if battery.is_some() && *plant == PlantKind::Actuator {
        return Err(NotPlanar::Battery);
    }
    if v.y != 0.0 {
        return Err(NotPlanar::Sideways { what: "the target velocity" });
    }
    let model = Model::new(vehicle, environment, control_limits, *plant)?.in_wind(wind);
    let measure = BatchMeasure::new(&flight_plan(setting), Some(setting.plan), limits, [v.x, v.z])?;
    Ok((model, measure.to_plans_end(setting.plan.end_s())))
}
