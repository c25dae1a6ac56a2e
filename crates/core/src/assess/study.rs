//! The paper's safety study, section V: controllers flown from many releases on the plant with actuators.
//!
//! A flight begins at t = 0 of the study (rotors at rest and free), is commanded at 100 Hz, and lasts as
//! long as the plan, in a study that is not the paper's a while longer; its cost is J_TPF, (51). Any
//! [`Controller`] flies. The cascade's trials fly side by side on the planar engine ([`crate::sim::planar`])
//! where it can hold them; all others in six degrees of freedom. The two agree to 1e-9 in the
//! air of the plane ([`SafetyStudy::in_trials_air`]).

use std::borrow::Cow;
use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::batch::{BatchFlight, BatchMeasure, judge_flights};
use super::flights::Outcomes;
use super::outcome::Outcome;
use super::releases::RandomRelease;
use super::safety::FlightWatch;
use super::scenario::Scenario;
use super::tracking::{self, TrackingError};
use crate::control::{Airframe, Controller, Gains};
use crate::frames::rotate_body_from_ned;
use crate::model::rigid_body::BodyState;
use crate::sim::faults::Fault;
use crate::sim::limits::StateCost;
use crate::sim::planar::{Flight, Model, NotPlanar, Release, Variation};
use crate::sim::{self, DropSimulation, FlightPlan, PlantKind, Reference, Sample, fly, fly_many};
use crate::trajectory::Trajectory;

/// Period of control and of the simulation's steps [s].
pub const CONTROL_PERIOD_S: f64 = tracking::NOMINAL_PERIOD_S;
/// A trace keeps about so many instants.
const TRACE_INSTANTS: f64 = 1500.0;

/// Velocity that a controller follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StudyReference {
    /// The target velocity at once.
    Step,
    /// The velocity of the optimal trajectory.
    Optimal,
}

/// A controller with what it follows: a row of Table 5, a campaign.
#[derive(Clone, Debug)]
pub struct StudyEntry {
    /// Name in files: `near_hover_step`.
    pub name: &'static str,
    /// Name of the controller's gains.
    pub gains_name: String,
    /// The controller.
    pub controller: Box<dyn Controller>,
    /// Velocity that the controller follows.
    pub reference: StudyReference,
}

impl StudyEntry {
    /// The gains, where the controller is the cascade.
    pub fn gains(&self) -> Option<&Gains> {
        self.controller.cascade_settings().map(|settings| &settings.gains)
    }
}

/// Why flights are flown in six degrees of freedom: eight side by side where [`fly_many`] does, else one at a
/// time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OneAtATime {
    /// The batch engine flies the cascade alone.
    #[error("the batch engine flies no controller but the cascade")]
    Controller,
    /// The controller is built for another vehicle than the one that is flown.
    #[error("the controller's model of the vehicle is not that of the vehicle that is flown")]
    Airframe,
    /// A motor that fails leaves the rotors without their mirror images.
    #[error("the mission has faults (faults.list), and the batch engine flies sound vehicles alone")]
    Faults,
    /// The vehicle, the site, a release or the reference leaves the vertical plane.
    #[error(transparent)]
    NotPlanar(#[from] NotPlanar),
}

/// The vehicle, site, limits and plan that all flights of a study share.
#[derive(Clone, Debug)]
pub struct SafetyStudy {
    /// Vehicle, site, air, target and limits. Each trial has turbulence of its own.
    pub scenario: Scenario,
    /// The plan from the nominal release.
    pub plan: Trajectory,
    /// Whether its acceleration is fed forward.
    pub feed_forward: bool,
    /// How long a flight goes on after the plan's end, the target velocity commanded [s]; 0 in the paper's.
    pub settle_s: f64,
    /// Time from the release to t = 0 [s], whose fall is part of the altitude lost.
    pub delay_s: f64,
    /// Faults of every flight; those of motors act. With any of them flights are flown one at a time.
    pub faults: Vec<Fault>,
}

/// A flight at an instant, for figures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceInstant {
    /// Time since the rotors were freed [s].
    pub t_s: f64,
    /// Way north and down since t = 0 [m].
    pub north_down_m: (f64, f64),
    /// Velocity, NED [m/s].
    pub v_ned: Vector3<f64>,
    /// Velocity, body axes [m/s].
    pub v_body: Vector3<f64>,
    /// J_state, (47).
    pub j_state: f64,
}

/// The beginning of a study's flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StudyStart {
    /// State at t = 0, rotors at rest.
    pub state: BodyState,
    /// Number of the flight whose turbulence it meets: 0 of a release case, trial k's is k + 1.
    pub air: u64,
    /// How far vehicle and air are off what the controller knows.
    pub variation: Variation,
}

impl From<&RandomRelease> for StudyStart {
    fn from(release: &RandomRelease) -> Self {
        Self { state: release.state, air: release.trial + 1, variation: release.off.variation() }
    }
}

impl From<&BodyState> for StudyStart {
    fn from(state: &BodyState) -> Self {
        Self { state: *state, air: 0, variation: Variation::NONE }
    }
}

impl SafetyStudy {
    /// Flies a trial from each release: side by side where [`Self::one_at_a_time`] has nothing against it.
    /// The outcome of a release does not depend on the others in the slice.
    pub fn fly_releases(&self, entry: &StudyEntry, releases: &[RandomRelease]) -> Vec<Outcome> {
        match self.side_by_side(entry, releases) {
            Ok((model, measure, flights)) => {
                let mut judged = vec![BatchFlight::default(); flights.len()];
                judge_flights(&model, &measure, &flights, &mut judged);
                // A flight that the batch engine gave up on still has its peaks before it.
                let whole = |(flight, release): (&BatchFlight, &RandomRelease)| {
                    if flight.given_up {
                        return self.in_air_of_the_plane().outcome(entry, release);
                    }
                    let outcome = flight.outcome;
                    outcome.with_way(self.way_to_t0(&release.state) + outcome.way_ned_m())
                };
                judged.iter().zip(releases).map(whole).collect()
            }
            Err(_) => self.fly_in_space(entry, releases),
        }
    }

    /// Flies a trial from each release in six degrees of freedom.
    fn fly_in_space(&self, entry: &StudyEntry, releases: &[RandomRelease]) -> Vec<Outcome> {
        let plan_end_s = self.plan.end_s() + 0.5 * CONTROL_PERIOD_S;
        let plan = self.flight_plan(entry, CONTROL_PERIOD_S);
        let watch = |r: &RandomRelease| FlightWatch::new(&self.scenario, r.state.p_ned, plan_end_s);
        let mut outcomes = Outcomes::by(releases.iter().map(watch).collect());
        let flight = |release: &RandomRelease| sim::Flight {
            simulation: self.simulation(release.into()),
            controller: entry.controller.clone(),
            plan,
        };
        fly_many(releases.iter().map(flight).collect(), &mut outcomes);
        let ways = releases.iter().map(|release| self.way_to_t0(&release.state));
        let flown = outcomes.finish().into_iter().zip(ways);
        flown.map(|(outcome, way)| outcome.with_way(way + outcome.way_ned_m())).collect()
    }

    /// A flight from t = 0 that has not begun.
    pub fn simulation(&self, start: StudyStart) -> DropSimulation {
        let StudyStart { state, air, variation } = start;
        let (vehicle, environment) =
            (self.scenario.vehicle.clone(), variation.blown(&self.scenario.environment));
        let course = self.scenario.wind.uniform(&environment).course(&environment, air);
        DropSimulation::at_t0(vehicle, environment, state, PlantKind::Actuator)
            .varied(variation.factors(), variation.latency_s)
            .in_wind(course)
            .on_battery(self.scenario.battery.clone())
            .with_faults(&self.faults)
    }

    /// Why the flights from such releases are not flown in the vertical plane; `None` where they are.
    pub fn one_at_a_time(&self, entry: &StudyEntry, releases: &[RandomRelease]) -> Option<OneAtATime> {
        self.side_by_side(entry, releases).err()
    }

    /// The study whose flights one at a time, such as [`Self::samples`], meet the air of
    /// [`Self::fly_releases`] from these releases: where those fly side by side, no turbulence across the
    /// plane, and mirror images alike in the vortex ring; elsewhere the study as it is.
    pub fn in_trials_air(&self, entry: &StudyEntry, releases: &[RandomRelease]) -> Cow<'_, Self> {
        match self.one_at_a_time(entry, releases) {
            None => Cow::Owned(self.in_air_of_the_plane()),
            Some(_) => Cow::Borrowed(self),
        }
    }

    fn in_air_of_the_plane(&self) -> Self {
        let wind = self.scenario.wind.uniform(&self.scenario.environment).in_plane();
        Self { scenario: Scenario { wind, ..self.scenario.clone() }, ..self.clone() }
    }

    fn side_by_side(
        &self,
        entry: &StudyEntry,
        releases: &[RandomRelease],
    ) -> Result<(Model, BatchMeasure, Vec<Flight>), OneAtATime> {
        let (model, gains) = self.in_the_plane(entry)?;
        let target_m_s = [self.scenario.target_v_ned.x, self.scenario.target_v_ned.z];
        let plan = self.flight_plan(entry, CONTROL_PERIOD_S);
        let measure = BatchMeasure::new(&plan, None, &self.scenario.limits, target_m_s)?
            .to_plans_end(self.plan.end_s());
        let flight = |release: &RandomRelease| {
            let StudyStart { air, variation, .. } = release.into();
            let variation = Variation { air: Some(air), ..variation };
            Ok(Flight { gains, release: Release::of(&release.state)?, variation })
        };
        Ok((model, measure, releases.iter().map(flight).collect::<Result<_, NotPlanar>>()?))
    }

    /// The batch engine's model of the vehicle under the cascade, and the gains.
    pub(super) fn in_the_plane(&self, entry: &StudyEntry) -> Result<(Model, Gains), OneAtATime> {
        let settings = entry.controller.cascade_settings().ok_or(OneAtATime::Controller)?;
        if !self.faults.is_empty() {
            return Err(OneAtATime::Faults);
        }
        if self.scenario.battery.is_some() {
            return Err(NotPlanar::Battery.into());
        }
        let known = Airframe::new(&self.scenario.vehicle, &self.scenario.environment)
            .map(|airframe| airframe.with_thrust_curve(settings.limits.thrust_curve));
        if known.as_ref() != Ok(&settings.airframe) {
            return Err(OneAtATime::Airframe);
        }
        let model = Model::new(
            &self.scenario.vehicle,
            &self.scenario.environment,
            &settings.limits,
            PlantKind::Actuator,
        )?;
        Ok((model.in_wind(&self.scenario.wind), settings.gains))
    }

    pub(super) fn flight_plan(&self, entry: &StudyEntry, period_s: f64) -> FlightPlan<'_> {
        let reference = match entry.reference {
            StudyReference::Step => Reference::Step(self.scenario.target_v_ned),
            StudyReference::Optimal => {
                let then_v_ned = (self.settle_s > 0.0).then_some(self.scenario.target_v_ned);
                let feed_forward = self.feed_forward;
                Reference::Plan { trajectory: &self.plan, then_v_ned, feed_forward }
            }
        };
        FlightPlan::new(reference, period_s, self.plan.end_s() + self.settle_s)
    }

    /// The way from the release to a state at t = 0, in free fall, NED [m].
    pub fn way_to_t0(&self, start: &BodyState) -> Vector3<f64> {
        let t = self.delay_s;
        start.v_ned * t - Vector3::z() * (0.5 * self.scenario.environment.gravity_m_s2 * t * t)
    }

    /// Flies from t = 0.
    pub fn outcome(&self, entry: &StudyEntry, start: impl Into<StudyStart>) -> Outcome {
        let start = start.into();
        let plan_end_s = self.plan.end_s() + 0.5 * CONTROL_PERIOD_S;
        let mut watch = FlightWatch::new(&self.scenario, start.state.p_ned, plan_end_s);
        self.fly(entry, start, CONTROL_PERIOD_S, &mut |sample| {
            watch.observe(sample);
            ControlFlow::Continue(())
        });
        let outcome = watch.outcome();
        outcome.with_way(self.way_to_t0(&start.state) + outcome.way_ned_m())
    }

    /// Distance from the plan, (45), of a flight whose steps fall on the plan's nodes.
    pub fn tracking_rms(&self, entry: &StudyEntry, start: impl Into<StudyStart>) -> f64 {
        let mut error = TrackingError::new(&self.plan);
        let period_s = tracking::control_period_s(&self.plan);
        self.fly(entry, start, period_s, &mut |sample| error.observe(sample));
        error.rms()
    }

    /// A flight for figures, in about 1500 instants.
    pub fn trace(&self, entry: &StudyEntry, start: impl Into<StudyStart>) -> Vec<TraceInstant> {
        let steps = self.plan.end_s() / CONTROL_PERIOD_S;
        let every = ((steps / TRACE_INSTANTS).round() as usize).max(1);
        let (mut trace, mut count) = (Vec::new(), 0);
        self.fly(entry, start, CONTROL_PERIOD_S, &mut |sample| {
            if count % every == 0 {
                trace.push(self.trace_instant(sample));
            }
            count += 1;
            ControlFlow::Continue(())
        });
        trace
    }

    /// Every sample of a flight.
    pub fn samples(&self, entry: &StudyEntry, start: impl Into<StudyStart>) -> Vec<Sample> {
        let mut samples = Vec::new();
        self.fly(entry, start, CONTROL_PERIOD_S, &mut |sample| {
            samples.push(*sample);
            ControlFlow::Continue(())
        });
        samples
    }

    fn trace_instant(&self, sample: &Sample) -> TraceInstant {
        let body = &sample.state.body;
        TraceInstant {
            t_s: sample.t_s,
            north_down_m: (body.p_ned.x, body.p_ned.z),
            v_ned: body.v_ned,
            v_body: rotate_body_from_ned(body.q_ned_from_body, body.v_ned),
            j_state: StateCost::of_sample(sample, &self.scenario.limits.safety).max(),
        }
    }

    pub(super) fn fly(
        &self,
        entry: &StudyEntry,
        start: impl Into<StudyStart>,
        period_s: f64,
        observe: &mut impl FnMut(&Sample) -> ControlFlow<()>,
    ) {
        let mut sim = self.simulation(start.into());
        let flight = self.flight_plan(entry, period_s);
        // Whether it was broken off is the observer's to know.
        let _ = fly(&mut sim, &mut *entry.controller.clone(), &flight, observe);
    }
}
