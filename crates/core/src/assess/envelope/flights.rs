//! Flights of an envelope: from many starts to the end, broken off where J_state reaches the limit.
//!
//! Eight fly side by side in the batch engine, and all end with the first that is unsafe, since nothing more
//! is asked of them. What the plane cannot hold flies one at a time in six degrees of freedom.

#![expect(
    clippy::needless_range_loop,
    reason = "a loop over lanes indexes many arrays at once, the same way throughout"
)]

use std::ops::ControlFlow;

use crate::assess::Scenario;
use crate::assess::study::{CONTROL_PERIOD_S, OneAtATime, SafetyStudy, StudyEntry, StudyStart};
use crate::control::Gains;
use crate::math;
use crate::model::rigid_body::BodyState;
use crate::model::wind::Wind;
use crate::sim::planar::{Flight, LANES, Model, Observer, Release, SetpointTable, State, Variation, fly};
use crate::sim::{SafetyLimits, StateCost};

/// Flights that a look at Ctrl-C stands between.
pub const GROUP: usize = LANES;

/// A flight's beginning: the state at t = 0, rotors at rest, and what the controller does not know.
pub type EnvelopeStart = (BodyState, Variation);

/// The vehicle, site, plan and cascade that the flights of an envelope share.
#[derive(Clone, Debug)]
pub struct EnvelopeFlights {
    study: SafetyStudy,
    entry: StudyEntry,
    planar: Result<Plane, OneAtATime>,
}

#[derive(Clone, Debug)]
struct Plane {
    model: Model,
    gains: Gains,
    setpoints: SetpointTable,
}

impl EnvelopeFlights {
    /// Flights of an entry of a study, in the study's air.
    pub fn new(study: SafetyStudy, entry: StudyEntry) -> Self {
        let plane = || {
            let (model, gains) = study.in_the_plane(&entry)?;
            let setpoints = SetpointTable::new(&study.flight_plan(&entry, CONTROL_PERIOD_S))?;
            Ok(Plane { model, gains, setpoints })
        };
        let planar = plane();
        Self { study, entry, planar }
    }

    /// These flights with other gusts and turbulence.
    pub fn in_wind(mut self, wind: Wind) -> Self {
        if let Ok(plane) = &mut self.planar {
            plane.model = plane.model.clone().in_wind(&wind);
        }
        self.study.scenario.wind = wind;
        self
    }

    /// Vehicle, site, air, target and limits of the flights.
    pub fn scenario(&self) -> &Scenario {
        &self.study.scenario
    }

    /// Why the flights are flown one at a time; `None` where they are flown side by side.
    pub fn one_at_a_time(&self) -> Option<&OneAtATime> {
        self.planar.as_ref().err()
    }

    /// The place of a start, among the first [`GROUP`], whose flight does not stay below a limit of J_state,
    /// the first to reach it; `None` when all stay below.
    pub fn one_unsafe(&self, starts: &[EnvelopeStart], limit: f64) -> Option<usize> {
        let first = starts.first()?;
        let starts = &starts[..starts.len().min(GROUP)];
        let flight = |plane: &Plane, (state, variation): &EnvelopeStart| {
            let release = Release::of(state).ok()?;
            Some(Flight { gains: plane.gains, release, variation: *variation })
        };
        if let Ok(plane) = &self.planar
            && let Some(filler) = flight(plane, first)
            && let Some(flights) = starts.iter().map(|start| flight(plane, start)).collect::<Option<Vec<_>>>()
        {
            // A last, smaller group fills its lanes with its first flight.
            let lanes: [Flight; LANES] = std::array::from_fn(|i| *flights.get(i).unwrap_or(&filler));
            let mut watch = Watch::new(&self.study.scenario.limits.safety, limit);
            fly(&plane.model, &plane.setpoints, &lanes, &mut watch);
            return watch.reached_by;
        }
        starts.iter().position(|start| !self.is_safe_in_space(start, limit))
    }

    /// Whether a flight in six degrees of freedom stays below the limit.
    fn is_safe_in_space(&self, (state, variation): &EnvelopeStart, limit: f64) -> bool {
        let study = &self.study;
        let air = variation.air.unwrap_or_default();
        let start = StudyStart { state: *state, air, variation: *variation };
        let mut safe = true;
        study.fly(&self.entry, start, CONTROL_PERIOD_S, &mut |sample| {
            safe = StateCost::of_sample(sample, &study.scenario.limits.safety).max() < limit;
            if safe { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        safe
    }
}

/// Watches eight flights until one of them reaches a limit.
struct Watch {
    /// Square of the speed [m^2/s^2] at the limit.
    speed2: f64,
    /// Cosine of half the pitch at the limit: a pitch is larger where the quaternion's scalar part is less.
    cos_half_pitch: f64,
    /// Pitch rate at the limit [rad/s].
    rate: f64,
    reached_by: Option<usize>,
}

impl Watch {
    fn new(limits: &SafetyLimits, limit: f64) -> Self {
        let speed = limit * limits.speed_m_s;
        let half_pitch = (0.5 * limit * limits.pitch_rad).min(std::f64::consts::PI);
        Self {
            speed2: speed * speed,
            cos_half_pitch: math::cos(half_pitch),
            rate: limit * limits.pitch_rate_rad_s,
            reached_by: None,
        }
    }
}

impl Observer for Watch {
    #[inline(always)]
    fn observe(&mut self, _step: usize, state: &State) -> ControlFlow<()> {
        let mut safe = [false; LANES];
        let mut all = true;
        for i in 0..LANES {
            let speed2 = state.v_n[i] * state.v_n[i] + state.v_d[i] * state.v_d[i];
            // What is no number is not safe.
            safe[i] = (speed2 < self.speed2)
                & (state.q0[i] > self.cos_half_pitch)
                & (state.rate[i].abs() < self.rate);
            all &= safe[i];
        }
        if all {
            return ControlFlow::Continue(());
        }
        self.reached_by = safe.iter().position(|safe| !safe);
        ControlFlow::Break(())
    }
}
