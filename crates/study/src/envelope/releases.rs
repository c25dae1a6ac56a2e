//! A mission's releases about a point of its safe-release envelope, and their flights.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::controller::along_plan;
use crate::uncertain::uncertain_or_usual;
use samara_core::assess::envelope::flights::{EnvelopeStart, GROUP};
use samara_core::assess::envelope::{
    AxisRange, Edge, EdgeSearch, EnvelopeAxis, EnvelopeFlights, EnvelopePoint, Ray, RayFlights, Stopped,
};
use samara_core::assess::{OneAtATime, ReleaseDistribution, Scenario};
use samara_core::control::ControlError;
use samara_core::frames::{pitch, quaternion_from_euler};
use samara_core::model::rigid_body::BodyState;
use samara_core::model::wind::{Turbulence, Wind};
use samara_core::model::{MAX_ROTORS, Parachute};
use samara_core::random::Trials;
use samara_core::sim::planar::Variation;
use samara_core::sim::plant::Plant;
use samara_core::sim::{PlantKind, PlantState, Start};
use samara_core::trajectory::Trajectory;
use samara_core::uncertain::Uncertainty;
use samara_core::units::{DEG_PER_RAD, RAD_PER_DEG};
use samara_mission::Mission;

/// Limits of J_state whose edges are searched, the lowest first.
pub const ENVELOPE_LIMITS: [f64; 2] = [0.7, 1.0];
/// Scale of the turbulence of a point, in each axis [m].
const TURBULENCE_SCALE_M: f64 = 100.0;
/// The strongest turbulence that is looked at, as a share of the limit of speed.
const TURBULENCE_SHARE: f64 = 0.5;
/// The longest delay that is looked at [s].
const DELAY_MOST_S: f64 = 60.0;
/// Steps of the fall between release and t = 0 [s]: no rotor turns, and what moves it is smooth.
const FALL_STEP_S: f64 = 0.02;

/// The mission's releases, flights and what is looked at.
#[derive(Clone, Debug)]
pub struct MissionEnvelope {
    ranges: [AxisRange; 6],
    /// The distribution at the release: without a delay, which is the point's.
    releases: ReleaseDistribution,
    /// What is off in each draw.
    uncertain: Arc<Uncertainty>,
    start: Start,
    seed: u64,
    flights: EnvelopeFlights,
}

impl MissionEnvelope {
    /// The envelope of the mission's gains along a plan.
    ///
    /// # Errors
    /// [`ControlError`] for a vehicle that cannot be controlled.
    pub fn new(mission: &Mission, plan: &Trajectory) -> Result<Self, ControlError> {
        let entry = along_plan(mission, "envelope")?;
        let of_t0 = mission.releases();
        let delay_s = of_t0.parachute.delay_s;
        let releases = ReleaseDistribution {
            parachute: Parachute { delay_s: 0.0, ..of_t0.parachute },
            uncertain: None,
            ..of_t0
        };
        Ok(Self {
            ranges: ranges(mission, &releases.state(0.0, 0.0), delay_s),
            releases,
            uncertain: uncertain_or_usual(mission),
            start: mission.release.start,
            seed: mission.seed,
            flights: EnvelopeFlights::new(mission.safety_study(plan), entry),
        })
    }

    /// What is looked at of each quantity: pitch and pitch rate to their limits, the descent to the limit of
    /// speed, the delay until a fall without air reaches that limit (at most a minute), wind to it either
    /// way, turbulence to half of it.
    pub fn ranges(&self) -> &[AxisRange; 6] {
        &self.ranges
    }

    /// Why the flights are flown one at a time; `None` where they are flown side by side.
    pub fn one_at_a_time(&self) -> Option<&OneAtATime> {
        self.flights.one_at_a_time()
    }

    /// Which of [`ENVELOPE_LIMITS`] the flights from the nominal release stay below; `stop` is asked between
    /// flights.
    ///
    /// # Errors
    /// [`Stopped`] when `stop` says so.
    pub fn nominal(
        &self,
        search: &EdgeSearch,
        ray: &Ray,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<[bool; 2], Stopped> {
        let mut flights = self.along(ray, stop);
        let mut safe = [false; 2];
        for (safe, limit) in safe.iter_mut().zip(ENVELOPE_LIMITS) {
            *safe = search.begins_safe(limit, &mut flights)?;
        }
        Ok(safe)
    }

    /// The edges of limits, the lowest first, along the ray of this number.
    ///
    /// # Errors
    /// [`Stopped`] when `stop` says so.
    pub fn edges(
        &self,
        search: &EdgeSearch,
        (number, ray): (u64, &Ray),
        limits: &[f64],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<Edge>, Stopped> {
        search.edges(number, limits, &mut self.along(ray, stop))
    }

    fn along<'a>(&'a self, ray: &'a Ray, stop: &'a (dyn Fn() -> bool + Sync)) -> Along<'a> {
        Along { envelope: self, ray, stop, in_turbulence: None }
    }

    /// The start of a draw's flight about a point: the release is off by as much as that of the campaigns'
    /// draw is from the nominal one, falls for the delay, and everything else is off that the controller does
    /// not know of.
    fn start(&self, point: &EnvelopePoint, draw: u64) -> EnvelopeStart {
        let number = Trials::Envelope.first() + draw;
        let value = |axis| point.value(axis);
        let (nominal, drawn) = (self.releases.state(0.0, 0.0), self.releases.draw(self.seed, number).state);
        // Its delay is the point's, so what the delay is off by is no part of its state.
        let uncertain = Some(self.uncertain.clone());
        let off = self.releases.with_uncertain(uncertain).draw(self.seed, number).off;
        let wind_m_s = value(EnvelopeAxis::Wind);
        let drift = Vector3::new(wind_m_s, 0.0, value(EnvelopeAxis::Descent) - nominal.v_ned.z);
        let rate_rad_s = value(EnvelopeAxis::PitchRate) * RAD_PER_DEG - nominal.omega_body.y;
        let pitch_rad = value(EnvelopeAxis::Pitch) * RAD_PER_DEG - pitch(nominal.q_ned_from_body);
        let release = BodyState {
            q_ned_from_body: quaternion_from_euler(0.0, pitch(drawn.q_ned_from_body) + pitch_rad, 0.0),
            v_ned: drawn.v_ned + drift,
            omega_body: drawn.omega_body + Vector3::new(0.0, rate_rad_s, 0.0),
            ..drawn
        };
        let mut state = self.fallen(release, value(EnvelopeAxis::Delay), wind_m_s);
        state.v_ned.z += self.releases.gravity_m_s2 * off.release_delay_s();
        let mut variation = Variation { air: Some(number + 1), ..off.variation() };
        variation.wind_m_s[0] += wind_m_s;
        (state, variation)
    }

    /// The state at t = 0 after a release, as the mission's drops come there (`release.start`).
    fn fallen(&self, mut release: BodyState, delay_s: f64, wind_m_s: f64) -> BodyState {
        let Scenario { vehicle, environment, .. } = self.flights.scenario();
        if self.start == Start::T0 {
            release.v_ned.z += environment.gravity_m_s2 * delay_s;
            return release;
        }
        let mut environment = environment.clone();
        environment.wind_ned_m_s.x += wind_m_s;
        let mut plant = Plant::new(vehicle.clone(), environment, PlantKind::Actuator);
        let mut state = PlantState::rotors_at_rest(release);
        let steps = (delay_s / FALL_STEP_S).ceil();
        for _ in 0..steps as u64 {
            plant.step(&mut state, &[0.0; MAX_ROTORS], true, delay_s / steps);
        }
        BodyState { p_ned: Vector3::zeros(), ..state.body }
    }

    /// The flights in turbulence of a strength in each axis, in place of the mission's own.
    fn in_turbulence(&self, sigma_m_s: f64) -> EnvelopeFlights {
        let turbulence =
            (sigma_m_s > 0.0).then(|| Turbulence::isotropic(sigma_m_s, TURBULENCE_SCALE_M, self.seed));
        self.flights.clone().in_wind(Wind { turbulence, ..self.flights.scenario().wind.clone() })
    }
}

/// What is looked at, about the nominal release.
fn ranges(mission: &Mission, nominal: &BodyState, delay_s: f64) -> [AxisRange; 6] {
    let limits = &mission.limits.safety;
    let speed_m_s = limits.speed_m_s;
    let about = |low: f64, nominal: f64, high: f64| AxisRange {
        low: low.min(nominal),
        nominal,
        high: high.max(nominal),
    };
    let (pitch_deg, rate_deg_s) = (limits.pitch_rad * DEG_PER_RAD, limits.pitch_rate_rad_s * DEG_PER_RAD);
    let descent_m_s = nominal.v_ned.z;
    let fall_s = (speed_m_s - descent_m_s) / mission.site.environment.gravity_m_s2;
    [
        about(-pitch_deg, pitch(nominal.q_ned_from_body) * DEG_PER_RAD, pitch_deg),
        about(-rate_deg_s, nominal.omega_body.y * DEG_PER_RAD, rate_deg_s),
        about(0.0, descent_m_s, speed_m_s),
        about(0.0, delay_s, fall_s.min(DELAY_MOST_S)),
        about(-speed_m_s, 0.0, speed_m_s),
        about(0.0, 0.0, TURBULENCE_SHARE * speed_m_s),
    ]
}

/// Flights along a ray.
struct Along<'a> {
    envelope: &'a MissionEnvelope,
    ray: &'a Ray,
    stop: &'a (dyn Fn() -> bool + Sync),
    /// The flights in the last turbulence, with its strength [m/s].
    in_turbulence: Option<(f64, EnvelopeFlights)>,
}

impl RayFlights for Along<'_> {
    fn one_unsafe(&mut self, share: f64, limit: f64, draws: &[u64]) -> Result<Option<u64>, Stopped> {
        let (envelope, point) = (self.envelope, self.ray.at(share));
        let flights = if point.sets_turbulence {
            let sigma_m_s = point.value(EnvelopeAxis::Turbulence);
            let known = self.in_turbulence.take().filter(|(of, _)| *of == sigma_m_s);
            let of_point = known.unwrap_or_else(|| (sigma_m_s, envelope.in_turbulence(sigma_m_s)));
            &self.in_turbulence.insert(of_point).1
        } else {
            &envelope.flights
        };
        for group in draws.chunks(GROUP) {
            if (self.stop)() {
                return Err(Stopped);
            }
            let starts: Vec<EnvelopeStart> = group.iter().map(|draw| envelope.start(&point, *draw)).collect();
            if let Some(place) = flights.one_unsafe(&starts, limit) {
                return Ok(group.get(place).copied());
            }
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use samara_core::assess::StudyStart;
    use samara_core::plan::{Guess, SolverOptions, plan};
    use samara_core::sim::nominal_state_at_t0;

    fn titan() -> (Mission, Trajectory) {
        let mission = Mission::shipped("titan_paper").unwrap();
        let observe = &mut |_: &_| std::ops::ControlFlow::Continue(());
        let options = SolverOptions::default();
        let plan = plan(&mission.plan_problem(), &Guess::StraightLine, &options, observe).unwrap();
        (mission, plan.trajectory)
    }

    fn point(envelope: &MissionEnvelope) -> EnvelopePoint {
        EnvelopePoint { values: envelope.ranges.map(|range| range.nominal), sets_turbulence: false }
    }

    /// By hand: with the paper's fall two points differ in their starts by as much as they are apart, the
    /// delay by g, whatever was drawn; the nominal release is the mission's.
    #[test]
    fn closed_form_starts_about_a_point() {
        let (mut mission, plan) = titan();
        mission.release.start = Start::T0;
        let envelope = MissionEnvelope::new(&mission, &plan).unwrap();
        let here = point(&envelope);
        assert_eq!(here.values, [0.0, 0.0, 3.0, 0.5, 0.0, 0.0]);
        let mut there = here;
        there.values = [5.0, -7.0, 4.5, 1.5, 2.0, 0.0];
        for draw in 0..5 {
            let ((a, a_off), (b, b_off)) = (envelope.start(&here, draw), envelope.start(&there, draw));
            let turned = pitch(b.q_ned_from_body) - pitch(a.q_ned_from_body);
            assert!((turned - 5.0 * RAD_PER_DEG).abs() < 1e-12);
            assert!((b.omega_body.y - a.omega_body.y + 7.0 * RAD_PER_DEG).abs() < 1e-12);
            assert!((b.v_ned - a.v_ned - Vector3::new(2.0, 0.0, 1.5 + 1.35)).norm() < 1e-12);
            assert!((b_off.wind_m_s[0] - a_off.wind_m_s[0] - 2.0).abs() < 1e-12);
            assert_eq!((a_off.mass, a_off.air), (b_off.mass, b_off.air));
            assert_ne!(envelope.start(&here, draw + 1), (a, a_off));
        }
        // A limit that is passed at the release ends a range: no pitch and no speed is looked at beyond.
        assert_eq!(envelope.ranges[0], AxisRange { low: -45.0, nominal: 0.0, high: 45.0 });
        assert!((envelope.ranges[3].high - 9.0 / 1.35).abs() < 1e-12);
    }

    /// The fall of a drop, by the simulation of drops.
    #[test]
    fn reference_a_release_falls_as_a_drop_does() {
        let (mut mission, plan) = titan();
        mission.release.parachute.pendulum.amplitude_rad = 0.2;
        mission.release.parachute.pendulum.phase_rad = 0.3;
        let envelope = MissionEnvelope::new(&mission, &plan).unwrap();
        let parachute = mission.release.parachute;
        let dropped = nominal_state_at_t0(
            mission.vehicle.clone(),
            mission.site.environment.clone(),
            parachute,
            Start::Release,
        );
        let released = Parachute { delay_s: 0.0, ..parachute }.state_at_t0(1.35);
        let fallen = envelope.fallen(released, parachute.delay_s, 0.0);
        assert!((fallen.v_ned - dropped.v_ned).norm() < 1e-7, "{fallen:?} {dropped:?}");
        assert!((pitch(fallen.q_ned_from_body) - pitch(dropped.q_ned_from_body)).abs() < 1e-7);
        assert!((fallen.omega_body - dropped.omega_body).norm() < 1e-7);
    }

    /// J_TPF of the study's flights in six degrees of freedom: a flight is safe a little above it and not a
    /// little below, and of eight side by side it is one above the limit that is found.
    #[test]
    fn reference_flights_end_at_their_j_tpf() {
        let (mission, plan) = titan();
        let envelope = MissionEnvelope::new(&mission, &plan).unwrap();
        let study = mission.safety_study(&plan);
        let entry = along_plan(&mission, "envelope").unwrap();
        let here = point(&envelope);
        let starts: Vec<EnvelopeStart> = (0..6).map(|draw| envelope.start(&here, draw)).collect();
        let costs: Vec<f64> = starts
            .iter()
            .map(|(state, off)| {
                let start = StudyStart { state: *state, air: off.air.unwrap(), variation: *off };
                study.outcome(&entry, start).j_tpf
            })
            .collect();
        for (start, cost) in starts.iter().zip(&costs) {
            let one = std::slice::from_ref(start);
            assert_eq!(envelope.flights.one_unsafe(one, cost * (1.0 + 1e-6)), None, "{cost}");
            assert_eq!(envelope.flights.one_unsafe(one, cost * (1.0 - 1e-6)), Some(0), "{cost}");
        }
        let mut sorted = costs.clone();
        sorted.sort_by(f64::total_cmp);
        let limit = 0.5 * (sorted[4] + sorted[5]);
        let found = envelope.flights.one_unsafe(&starts, limit).unwrap();
        assert_eq!(costs[found], sorted[5]);
    }
}
