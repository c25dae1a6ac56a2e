//! A trial as independent standard-normal coordinates: every draw of a campaign's trial is a function of
//! them, white noise of the air included.
//!
//! The coordinates have the distribution of [`ReleaseDistribution::draw`] and of turbulence as campaigns draw
//! it, but not their streams: normal draws are coordinates times their deviation, uniform ones come by
//! `2 Phi(z) - 1`, and white noise has a coordinate for each number that a filter takes, so that nothing of
//! its variance is left out. What a flight in the plane does not feel - turbulence across it, the vortex ring
//! of mirror images one by one - has no coordinate where the trials are flown there.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;

use super::batch::{BatchFlight, BatchMeasure, judge_flights};
use super::flights::Outcomes;
use super::outcome::Outcome;
use super::releases::{RandomRelease, ReleaseDistribution};
use super::safety::FlightWatch;
use super::study::{CONTROL_PERIOD_S, OneAtATime, SafetyStudy, StudyEntry, StudyStart};
use crate::control::Gains;
use crate::model::MAX_ROTORS;
use crate::model::parachute::TipOff;
use crate::model::wind::{FlightNoise, GivenNoise};
use crate::sim::planar::{Flight, LANES, Model, NotPlanar, Release, Variation};
use crate::sim::{self, DropSimulation, Sample, fly_many};
use crate::uncertain::{Deviations, UncertainQuantity, Uncertainty, either_way};

/// White noise over this time [s] counts as one number where a whole span moves; longer in long flights.
const SPAN_S: f64 = 0.2;
/// Most such spans of a column.
const SPANS_MOST: usize = 60;

/// A quantity that is drawn, with its coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// The quantity.
    pub quantity: DrawnQuantity,
    /// Places of its coordinates: one, or as many as the flight has control periods.
    pub range: Range<usize>,
}

/// A quantity that is drawn for a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DrawnQuantity {
    /// Amplitude of the swing theta_0.
    Amplitude,
    /// Phase of the swing phi.
    Phase,
    /// Rate about a body axis that the cut gives, 0 to 2.
    TipOffRate(usize),
    /// Velocity along a body axis that the cut gives, 0 to 2.
    TipOffVelocity(usize),
    /// How far something is off what is known.
    Off(UncertainQuantity),
    /// A column of turbulence's white noise, 0 to 4.
    Turbulence(usize),
    /// The column of a rotor in the vortex ring.
    Ring(usize),
}

impl DrawnQuantity {
    /// Name of the quantity for a reader; columns of one filter alike.
    pub fn words(self) -> &'static str {
        match self {
            Self::Amplitude => "swing, amplitude",
            Self::Phase => "swing, phase",
            Self::TipOffRate(_) => "tip-off, rates",
            Self::TipOffVelocity(_) => "tip-off, velocities",
            Self::Off(quantity) => quantity.words(),
            Self::Turbulence(0) => "turbulence along the wind",
            Self::Turbulence(1 | 2) => "turbulence across the wind",
            Self::Turbulence(_) => "turbulence, vertical",
            Self::Ring(_) => "thrusts in the vortex ring",
        }
    }

    /// Key of the quantity in files, stable; columns of one filter, and axes of one thing, alike.
    pub fn key(self) -> &'static str {
        match self {
            Self::Amplitude => "swing_amplitude",
            Self::Phase => "swing_phase",
            Self::TipOffRate(_) => "tip_off_rates",
            Self::TipOffVelocity(_) => "tip_off_velocities",
            Self::Off(quantity) => Self::off_key(quantity),
            Self::Turbulence(0) => "turbulence_along",
            Self::Turbulence(1 | 2) => "turbulence_across",
            Self::Turbulence(_) => "turbulence_vertical",
            Self::Ring(_) => "vortex_ring",
        }
    }

    /// Key of what is off in results, which stays as it was before missions had a key of their own for it.
    fn off_key(quantity: UncertainQuantity) -> &'static str {
        match quantity {
            UncertainQuantity::Wind => "wind",
            UncertainQuantity::Latency => "latency",
            UncertainQuantity::ReleaseDelay => "release_delay",
            share => share.key(),
        }
    }
}

/// Quantities that go by one name, with their coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct CoordinateGroup {
    /// Key in files.
    pub key: String,
    /// Name for a reader.
    pub words: String,
    /// Places of the coordinates.
    pub ranges: Vec<Range<usize>>,
}

/// What is drawn for a trial.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnTrial {
    /// The release, with the state at t = 0 and what is off.
    pub release: RandomRelease,
    /// White noise of the air.
    pub noise: FlightNoise,
}

/// The trials of a campaign by coordinates.
#[derive(Clone, Debug)]
pub struct TrialSpace {
    study: SafetyStudy,
    entry: StudyEntry,
    releases: ReleaseDistribution,
    plane: Result<Plane, OneAtATime>,
    parts: Vec<Part>,
    dimensions: usize,
}

#[derive(Clone, Debug)]
struct Plane {
    model: Model,
    gains: Gains,
    measure: BatchMeasure,
}

impl TrialSpace {
    /// The trials of an entry of a study from random releases.
    pub fn new(study: SafetyStudy, entry: StudyEntry, releases: ReleaseDistribution) -> Self {
        let plan = study.flight_plan(&entry, CONTROL_PERIOD_S);
        let steps = plan.steps() as usize;
        let plane = || {
            // Any release tells whether they are in the plane: the same quantities move all of them.
            let tipped = releases.tip_off_sigma.after(releases.state(0.1, 0.1));
            Release::of(&tipped)?;
            let (model, gains) = study.in_the_plane(&entry)?;
            let target_m_s = [study.scenario.target_v_ned.x, study.scenario.target_v_ned.z];
            let measure = BatchMeasure::new(&plan, None, &study.scenario.limits, target_m_s)?
                .to_plans_end(study.plan.end_s());
            Ok(Plane { model, gains, measure })
        };
        let plane: Result<Plane, OneAtATime> = plane();
        let mut study = study.clone();
        if plane.is_ok() {
            study.scenario.wind = study.scenario.wind.uniform(&study.scenario.environment).in_plane();
        }
        let quantities = quantities(&study, &releases, plane.as_ref().ok().map(|p| &p.model));
        let mut parts = Vec::new();
        let mut dimensions = 0;
        for quantity in quantities {
            let many = matches!(quantity, DrawnQuantity::Turbulence(_) | DrawnQuantity::Ring(_));
            let from = dimensions;
            dimensions += if many { steps } else { 1 };
            parts.push(Part { quantity, range: from..dimensions });
        }
        Self { study, entry, releases, plane, parts, dimensions }
    }

    /// Number of coordinates.
    pub fn dimensions(&self) -> usize {
        self.dimensions
    }

    /// The quantities that are drawn, with their coordinates in order.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The quantities by their keys: columns of one filter, axes of one thing, and what is normal together,
    /// are one group. What is correlated has no share of its own of a variance.
    pub fn groups(&self) -> Vec<CoordinateGroup> {
        let mut groups: Vec<CoordinateGroup> = Vec::new();
        for Part { quantity, range } in &self.parts {
            let (key, words) = self.group_of(*quantity);
            match groups.iter_mut().find(|group| group.key == key) {
                Some(group) => group.ranges.push(range.clone()),
                None => groups.push(CoordinateGroup { key, words, ranges: vec![range.clone()] }),
            }
        }
        groups
    }

    /// Key and name of the group of a quantity.
    fn group_of(&self, quantity: DrawnQuantity) -> (String, String) {
        let joint = match quantity {
            DrawnQuantity::Off(off) => {
                self.releases.uncertain.as_ref().and_then(|uncertain| uncertain.joint_of(off))
            }
            _ => None,
        };
        let all = joint.map_or_else(
            || vec![quantity],
            |joint| joint.quantities().iter().copied().map(DrawnQuantity::Off).collect(),
        );
        let joined = |of: fn(DrawnQuantity) -> &'static str, with: &str| {
            all.iter().map(|one| of(*one)).collect::<Vec<_>>().join(with)
        };
        (joined(DrawnQuantity::key, "_and_"), joined(DrawnQuantity::words, " and "))
    }

    /// Length of a flight [s].
    pub fn duration_s(&self) -> f64 {
        self.study.plan.end_s() + self.study.settle_s
    }

    /// The simulation of a trial in space, which has not begun.
    pub fn simulation(&self, trial: &DrawnTrial) -> DropSimulation {
        let (study, _, start) = self.in_space(trial);
        study.simulation(start)
    }

    /// Why the trials are not flown in the vertical plane; `None` where they are.
    pub fn one_at_a_time(&self) -> Option<&OneAtATime> {
        self.plane.as_ref().err()
    }

    /// Spans of coordinates that act alike: each alone, white noise by the time that it drives.
    pub fn spans(&self) -> Vec<Range<usize>> {
        let cut = |part: &Part| {
            let size =
                ((SPAN_S / CONTROL_PERIOD_S).round() as usize).max(part.range.len().div_ceil(SPANS_MOST));
            let end = part.range.end;
            part.range.clone().step_by(size).map(move |from| from..end.min(from + size)).collect::<Vec<_>>()
        };
        self.parts.iter().flat_map(cut).collect()
    }

    /// What is drawn at a point.
    pub fn drawn(&self, point: &[f64]) -> DrawnTrial {
        let (mut amplitude_rad, mut phase_rad) = (0.0, 0.0);
        let mut tip_off = TipOff::default();
        let mut coordinates = [0.0; UncertainQuantity::ALL.len()];
        let mut noise = FlightNoise::default();
        let sigma = &self.releases.tip_off_sigma;
        for Part { quantity, range } in &self.parts {
            let column = point.get(range.clone()).unwrap_or_default();
            let z = column.first().copied().unwrap_or_default();
            match quantity {
                DrawnQuantity::Amplitude => amplitude_rad = self.releases.amplitude_sigma_rad * z,
                DrawnQuantity::Phase => phase_rad = std::f64::consts::PI * either_way(z),
                DrawnQuantity::TipOffRate(axis) => tip_off.omega_body[*axis] = sigma.omega_body[*axis] * z,
                DrawnQuantity::TipOffVelocity(axis) => tip_off.v_body[*axis] = sigma.v_body[*axis] * z,
                DrawnQuantity::Off(quantity) => coordinates[*quantity as usize] = z,
                DrawnQuantity::Turbulence(k) => noise.turbulence[*k] = Arc::from(column),
                DrawnQuantity::Ring(rotor) => noise.ring[*rotor] = Arc::from(column),
            }
        }
        let at = |uncertain: &Arc<Uncertainty>| uncertain.at(|quantity| coordinates[quantity as usize]);
        let off = self.releases.uncertain.as_ref().map_or_else(Deviations::default, at);
        let state = tip_off.after(self.releases.state(amplitude_rad, phase_rad));
        let state = self.releases.delayed(state, &off);
        let release = RandomRelease { trial: 0, amplitude_rad, phase_rad, state, off };
        DrawnTrial { release, noise }
    }

    /// Flies the trials at these points; threads are the caller's affair: split at multiples of [`LANES`].
    pub fn fly(&self, points: &[impl AsRef<[f64]>]) -> Vec<Outcome> {
        points.chunks(LANES).flat_map(|some| self.fly_some(some)).collect()
    }

    fn fly_some(&self, points: &[impl AsRef<[f64]>]) -> Vec<Outcome> {
        let drawn: Vec<DrawnTrial> = points.iter().map(|point| self.drawn(point.as_ref())).collect();
        let flights = self.plane.as_ref().ok().and_then(|plane| {
            let flight = |(trial, number): (&DrawnTrial, u64)| -> Result<Flight, NotPlanar> {
                let variation = Variation { air: Some(number), ..trial.release.off.variation() };
                Ok(Flight { gains: plane.gains, release: Release::of(&trial.release.state)?, variation })
            };
            Some((plane, drawn.iter().zip(0..).map(flight).collect::<Result<Vec<Flight>, _>>().ok()?))
        });
        let Some((plane, flights)) = flights else {
            return self.fly_in_space(&drawn);
        };
        let given: Arc<[FlightNoise]> = drawn.iter().map(|trial| trial.noise.clone()).collect();
        let mut wind = self.study.scenario.wind.clone();
        wind.given = Some(GivenNoise(given));
        let mut judged = vec![BatchFlight::default(); flights.len()];
        judge_flights(&plane.model.clone().in_wind(&wind), &plane.measure, &flights, &mut judged);
        let whole = |(flight, trial): (&BatchFlight, &DrawnTrial)| {
            // A flight that the batch engine gave up on still has its peaks before it.
            if flight.given_up {
                return self.outcome(trial);
            }
            let outcome = flight.outcome;
            outcome.with_way(self.way_to_t0(trial) + outcome.way_ned_m())
        };
        judged.iter().zip(&drawn).map(whole).collect()
    }

    /// The flight of a trial in six degrees of freedom: what flies it, and its beginning.
    fn in_space(&self, trial: &DrawnTrial) -> (SafetyStudy, StudyEntry, StudyStart) {
        let (mut study, entry) = (self.study.clone(), self.entry.clone());
        study.scenario.wind.given = Some(GivenNoise(Arc::from([trial.noise.clone()])));
        let RandomRelease { state, off, .. } = trial.release;
        (study, entry, StudyStart { state, air: 0, variation: Variation { air: Some(0), ..off.variation() } })
    }

    /// Flies trials in six degrees of freedom, side by side where [`fly_many`] does.
    fn fly_in_space(&self, drawn: &[DrawnTrial]) -> Vec<Outcome> {
        let given: Arc<[FlightNoise]> = drawn.iter().map(|trial| trial.noise.clone()).collect();
        let plan_end_s = self.study.plan.end_s() + 0.5 * CONTROL_PERIOD_S;
        let plan = self.study.flight_plan(&self.entry, CONTROL_PERIOD_S);
        let flight = |(trial, air): (&DrawnTrial, u64)| {
            let (mut study, entry, start) = self.in_space(trial);
            study.scenario.wind.given = Some(GivenNoise(given.clone()));
            let simulation = study.simulation(StudyStart { air, ..start });
            sim::Flight { simulation, controller: entry.controller, plan }
        };
        let watch = |trial: &DrawnTrial| {
            FlightWatch::new(&self.study.scenario, trial.release.state.p_ned, plan_end_s)
        };
        let mut outcomes = Outcomes::by(drawn.iter().map(watch).collect());
        fly_many(drawn.iter().zip(0..).map(flight).collect(), &mut outcomes);
        let whole = |(outcome, trial): (Outcome, &DrawnTrial)| {
            outcome.with_way(self.way_to_t0(trial) + outcome.way_ned_m())
        };
        outcomes.finish().into_iter().zip(drawn).map(whole).collect()
    }

    fn outcome(&self, trial: &DrawnTrial) -> Outcome {
        let (study, entry, start) = self.in_space(trial);
        study.outcome(&entry, start)
    }

    /// The way from a trial's release to t = 0, NED [m].
    pub fn way_to_t0(&self, trial: &DrawnTrial) -> Vector3<f64> {
        self.study.way_to_t0(&trial.release.state)
    }

    /// Every sample of a trial's flight in six degrees of freedom.
    pub fn samples(&self, trial: &DrawnTrial) -> Vec<Sample> {
        let (study, entry, start) = self.in_space(trial);
        study.samples(&entry, start)
    }
}

/// The quantities that are drawn for a trial, in order.
fn quantities(
    study: &SafetyStudy,
    releases: &ReleaseDistribution,
    plane: Option<&Model>,
) -> Vec<DrawnQuantity> {
    let mut quantities = vec![DrawnQuantity::Amplitude, DrawnQuantity::Phase];
    let sigma = &releases.tip_off_sigma;
    quantities.extend((0..3).filter(|axis| sigma.omega_body[*axis] != 0.0).map(DrawnQuantity::TipOffRate));
    quantities.extend((0..3).filter(|axis| sigma.v_body[*axis] != 0.0).map(DrawnQuantity::TipOffVelocity));
    let uncertain = releases.uncertain.as_ref().map_or_else(Vec::new, |uncertain| uncertain.quantities());
    quantities.extend(uncertain.into_iter().map(DrawnQuantity::Off));
    // Noise from a file is the same for all trials.
    if let Some(turbulence) =
        study.scenario.wind.turbulence.as_ref().filter(|turbulence| turbulence.noise.is_none())
    {
        let columns = [0usize, 1, 1, 2, 2];
        let blows = |k: &usize| turbulence.sigma_m_s[columns[*k]] != 0.0;
        quantities.extend((0..columns.len()).filter(blows).map(DrawnQuantity::Turbulence));
    }
    if study.scenario.wind.ring.is_some() {
        let rotors = study.scenario.vehicle.rotors.len().min(MAX_ROTORS);
        let drawn = |rotor: &usize| plane.is_none_or(|model| model.ring_draws().any(|first| first == *rotor));
        quantities.extend((0..rotors).filter(drawn).map(DrawnQuantity::Ring));
    }
    quantities
}
