//! Safety of a flight: the peak of a state's cost J_state, which is J_TPF (51), and the verdict on a drop.
//!
//! ```text
//! J_TPF = max over all steps, ends included, of J_state
//! ```
//!
//! J_state, (47)-(50), is [`StateCost`]'s.

use std::sync::Arc;

use nalgebra::Vector3;

use super::power::PowerUse;
use crate::frames::{bank, pitch, tilt};
use crate::model::rigid_body::BodyState;
use crate::model::supply::PackLimits;
use crate::model::{DiskState, Environment, MAX_ROTORS, Rotor, Vehicle};
use crate::sim::limits::{NOT_FINITE, SafetyLimits, StateCost};
use crate::sim::{Phase, Sample};

/// The peaks and the end of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrialOutcome {
    /// J_TPF, (51); infinite when a state was no number.
    pub j_tpf: f64,
    /// Largest speed [m/s].
    pub peak_speed_m_s: f64,
    /// Largest pitch, either way, with its sign [rad].
    pub peak_pitch_rad: f64,
    /// Largest pitch rate, either way, with its sign [rad/s].
    pub peak_pitch_rate_rad_s: f64,
    /// Largest roll, either way, with its sign [rad]; zero in the plane.
    pub peak_roll_rad: f64,
    /// Largest roll rate, either way, with its sign [rad/s]; zero in the plane.
    pub peak_roll_rate_rad_s: f64,
    /// Velocity at the end, or where the flight was given up, NED [m/s].
    pub final_v_ned: Vector3<f64>,
    /// Largest angle between the body's up axis and the vertical [rad].
    pub peak_tilt_rad: f64,
    /// Way from the release to the plan's end, or to where the flight was given up, NED [m]; the way down is
    /// the altitude lost.
    pub way_ned_m: Vector3<f64>,
    /// Time after t = 0 from which the velocity stays within what is steady, to the end [s].
    pub steady_after_s: Option<f64>,
}

/// Limits beside those of J_state; each is judged where it is given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FlightLimits {
    /// Way down from the release to the plan's end [m].
    pub altitude_lost_m: Option<f64>,
    /// Angle between the body's up axis and the vertical [rad].
    pub tilt_rad: Option<f64>,
    /// Time after t = 0 by which the flight is steady [s].
    pub steady_after_s: Option<f64>,
}

impl FlightLimits {
    /// Names of the limits that a flight has passed: "altitude_lost", "tilt", "steady_after". A flight that
    /// is never steady has passed none by that.
    pub fn passed(
        &self,
        altitude_lost_m: f64,
        tilt_rad: f64,
        steady_after_s: Option<f64>,
    ) -> impl Iterator<Item = &'static str> + use<> {
        let over =
            |value: Option<f64>, limit: Option<f64>| value.zip(limit).is_some_and(|(x, most)| x > most);
        let passed = [
            ("altitude_lost", over(Some(altitude_lost_m), self.altitude_lost_m)),
            ("tilt", over(Some(tilt_rad), self.tilt_rad)),
            ("steady_after", over(steady_after_s, self.steady_after_s)),
        ];
        passed.into_iter().filter(|(_, passed)| *passed).map(|(name, _)| name)
    }
}

impl TrialOutcome {
    /// Takes the next sample of the flight.
    pub(super) fn observe(&mut self, sample: &Sample, limits: &SafetyLimits) {
        let body = &sample.state.body;
        self.j_tpf = self.j_tpf.max(StateCost::of_sample(sample, limits).max());
        self.peak_speed_m_s = self.peak_speed_m_s.max(body.v_ned.norm());
        keep_larger([
            (&mut self.peak_pitch_rad, pitch(body.q_ned_from_body)),
            (&mut self.peak_pitch_rate_rad_s, body.omega_body.y),
            (&mut self.peak_roll_rad, bank(body.q_ned_from_body)),
            (&mut self.peak_roll_rate_rad_s, body.omega_body.x),
        ]);
        self.final_v_ned = body.v_ned;
        self.peak_tilt_rad = self.peak_tilt_rad.max(tilt(body.q_ned_from_body));
    }
}

/// Verdict on a drop, from the release to the end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// J_TPF, (51).
    pub j_tpf: f64,
    /// Name of the quantity that J_TPF is the share of: "speed", "pitch", "pitch_rate", "roll", "roll_rate";
    /// [`NOT_FINITE`].
    pub decided_by: &'static str,
    /// Largest speed [m/s].
    pub peak_speed_m_s: f64,
    /// Largest pitch, either way, with its sign [rad].
    pub peak_pitch_rad: f64,
    /// Largest pitch rate, either way, with its sign [rad/s].
    pub peak_pitch_rate_rad_s: f64,
    /// Largest roll, either way, with its sign [rad].
    pub peak_roll_rad: f64,
    /// Largest roll rate, either way, with its sign [rad/s].
    pub peak_roll_rate_rad_s: f64,
    /// Largest vertical acceleration, either way, with its sign (down is positive) [m/s^2].
    pub peak_vertical_acceleration_m_s2: f64,
    /// Way down from the release to the end of the plan, or of the flight where there is none or that came
    /// first [m].
    pub altitude_lost_m: f64,
    /// Time after the rotors were freed [s] from which `|v - v_cmd|` stays within [`steady_within_m_s`], or
    /// what the mission says instead, to the end.
    pub steady_after_s: Option<f64>,
    /// Names of the limits that were passed: "speed", "pitch", "pitch_rate", "roll", "roll_rate"; "state is
    /// not finite" when a state was no number, "impact", "separation"; those of [`FlightLimits`].
    pub limits_passed: Vec<&'static str>,
    /// Velocity at the end, NED [m/s].
    pub final_v_ned: Vector3<f64>,
    /// Fastest that it came to the ground, if it did [m/s].
    pub impact_speed_m_s: Option<f64>,
    /// Largest angle between the body's up axis and the vertical [rad].
    pub peak_tilt_rad: f64,
    /// Way from the release to the end of the plan, or of the flight where there is none or that came first,
    /// NED [m].
    pub way_ned_m: Vector3<f64>,
    /// Least distance from the canopy to the vehicle's centre of mass after the release [m], where the canopy
    /// is a body of its own.
    pub canopy_distance_m: Option<f64>,
    /// Time of powered flight that each rotor is in the vortex ring, inside Johnson's stability boundary [s];
    /// empty where the blades are not known.
    pub vortex_ring_s: Vec<f64>,
    /// What the drop asked of its battery, where that has a voltage.
    pub power: Option<PowerUse>,
}

impl Verdict {
    /// Whether the canopy has come closer to the vehicle than the mission allows.
    pub fn recontact(&self) -> bool {
        self.limits_passed.contains(&SEPARATION)
    }
}

/// Name of the limit that a canopy passes which comes too close.
const SEPARATION: &str = "separation";

/// Steady within this fraction of the commanded velocity.
const STEADY_FRACTION: f64 = 0.01;

/// Steady within this velocity [m/s] at the least: 1 % of a hover would be nothing.
const STEADY_LEAST_M_S: f64 = 0.02;

/// How close to a commanded velocity is steady [m/s]: 1 % of it, and 0.02 m/s at the least.
pub fn steady_within_m_s(v_cmd_ned: &Vector3<f64>) -> f64 {
    (STEADY_FRACTION * v_cmd_ned.norm()).max(STEADY_LEAST_M_S)
}

/// Keeps in each pair the number of the larger size, with its sign.
fn keep_larger<const N: usize>(peaks: [(&mut f64, f64); N]) {
    for (peak, now) in peaks {
        if now.abs() > peak.abs() {
            *peak = now;
        }
    }
}

/// Makes a [`Verdict`] of a flight's samples, given one by one in order of time.
#[derive(Clone, Debug)]
pub struct VerdictBuilder {
    limits: SafetyLimits,
    v_cmd_ned: Vector3<f64>,
    steady_within_m_s: f64,
    peak: StateCost,
    infinite: bool,
    /// Peaks, steadiness and impact so far; the rest is filled in at the end.
    verdict: Verdict,
    first_p_ned: Option<Vector3<f64>>,
    plan_end_s: f64,
    plan_end_p_ned: Vector3<f64>,
    last: Option<BodyState>,
    impact_limit_m_s: Option<f64>,
    flight_limits: FlightLimits,
    separation_limit_m: Option<f64>,
    touching: bool,
    /// Vehicle and site whose rotors are watched.
    disks: Option<(Arc<Vehicle>, Environment)>,
    /// Time of the sample before [s], and which rotors were in the vortex ring then.
    in_ring: Option<(f64, [bool; MAX_ROTORS])>,
}

impl VerdictBuilder {
    /// Judges against `limits`; steady means close to `v_cmd_ned` [m/s].
    pub fn new(limits: SafetyLimits, v_cmd_ned: Vector3<f64>) -> Self {
        Self {
            limits,
            v_cmd_ned,
            steady_within_m_s: steady_within_m_s(&v_cmd_ned),
            peak: StateCost::default(),
            infinite: false,
            verdict: Verdict::default(),
            first_p_ned: None,
            plan_end_s: f64::INFINITY,
            plan_end_p_ned: Vector3::zeros(),
            last: None,
            impact_limit_m_s: None,
            flight_limits: FlightLimits::default(),
            separation_limit_m: None,
            touching: false,
            disks: None,
            in_ring: None,
        }
    }

    /// Steady means within this of the commanded velocity [m/s].
    pub fn steady_within(self, steady_within_m_s: f64) -> Self {
        Self { steady_within_m_s, ..self }
    }

    /// Counts the altitude lost to the plan's end [s from the start of powered flight]: what comes after it
    /// is steady descent.
    pub fn to_plans_end(self, plan_end_s: f64) -> Self {
        Self { plan_end_s, ..self }
    }

    /// Judges also how fast the vehicle comes to the ground [m/s]: a limit of its own, no part of J_TPF.
    pub fn judging_impacts(mut self, limit_m_s: f64) -> Self {
        self.impact_limit_m_s = Some(limit_m_s);
        self
    }

    /// Judges also altitude lost, tilt and time to steady flight, where there are limits: no part of J_TPF.
    pub fn within(mut self, limits: FlightLimits) -> Self {
        self.flight_limits = limits;
        self
    }

    /// Judges also how close the canopy comes after the release [m], where there is a limit: no part of
    /// J_TPF.
    pub fn apart_from_canopy(mut self, least_m: Option<f64>) -> Self {
        self.separation_limit_m = least_m;
        self
    }

    /// Tells also how long each rotor of the vehicle at a site is in the vortex ring, where its blades are
    /// known.
    pub fn watching_rotors(mut self, vehicle: &Arc<Vehicle>, site: &Environment) -> Self {
        if matches!(vehicle.rotor, Rotor::BladeElement(_)) {
            self.verdict.vortex_ring_s = vec![0.0; vehicle.rotors.len()];
            self.disks = Some((vehicle.clone(), site.clone()));
        }
        self
    }

    /// Tells also what the drop asks of a battery with these limits.
    pub fn watching_battery(mut self, limits: Option<&PackLimits>) -> Self {
        self.verdict.power = limits.map(PowerUse::of);
        self
    }

    fn observe_rotors(&mut self, sample: &Sample) {
        let Some((vehicle, site)) = &self.disks else { return };
        if let Some((before_s, in_ring)) = self.in_ring {
            let times = self.verdict.vortex_ring_s.iter_mut().zip(in_ring);
            times.filter(|(_, inside)| *inside).for_each(|(time, _)| *time += sample.t_s - before_s);
        }
        let inside = |i: usize| {
            let (body, thrust_n) = (&sample.state.body, sample.balance.thrust_n[i]);
            DiskState::of(vehicle, i, site, body, &sample.wind_ned, thrust_n)
                .is_some_and(|disk| disk.is_in_vortex_ring())
        };
        let powered = sample.phase == Phase::Powered;
        self.in_ring = powered.then(|| (sample.t_s, std::array::from_fn(inside)));
    }

    /// A touch counts with the speed of the sample before it; what stood there from the start has not come
    /// down.
    fn observe_ground(&mut self, sample: &Sample) {
        let touching = sample.balance.ground_force_ned.z < 0.0;
        let sank_m_s = match self.last {
            Some(last) => last.v_ned.z,
            None if sample.phase == Phase::Falling => sample.state.body.v_ned.z,
            None => 0.0,
        };
        if touching && !self.touching && sank_m_s > 0.0 {
            let worst = &mut self.verdict.impact_speed_m_s;
            *worst = Some(worst.map_or(sank_m_s, |worst| worst.max(sank_m_s)));
        }
        self.touching = touching;
    }

    /// Takes the next sample; what happens under the canopy does not count.
    pub fn observe(&mut self, sample: &Sample) {
        if sample.phase == Phase::Hanging {
            return;
        }
        let body = &sample.state.body;
        let cost = StateCost::of_sample(sample, &self.limits);
        self.infinite |= cost.max() == f64::INFINITY;
        self.peak = self.peak.worse(&cost);
        let so_far = &mut self.verdict;
        keep_larger([
            (&mut so_far.peak_pitch_rad, pitch(body.q_ned_from_body)),
            (&mut so_far.peak_pitch_rate_rad_s, body.omega_body.y),
            (&mut so_far.peak_roll_rad, bank(body.q_ned_from_body)),
            (&mut so_far.peak_roll_rate_rad_s, body.omega_body.x),
            (&mut so_far.peak_vertical_acceleration_m_s2, sample.a_ned.z),
        ]);
        so_far.peak_tilt_rad = so_far.peak_tilt_rad.max(tilt(body.q_ned_from_body));
        let near = (body.v_ned - self.v_cmd_ned).norm() <= self.steady_within_m_s;
        if let Some(canopy) = &sample.canopy {
            let distance_m = (canopy.state.p_ned - body.p_ned).norm();
            let least = &mut self.verdict.canopy_distance_m;
            *least = Some(least.map_or(distance_m, |least| least.min(distance_m)));
        }
        self.observe_ground(sample);
        self.observe_rotors(sample);
        if let Some(power) = &mut self.verdict.power {
            power.observe(sample);
        }
        match sample.t_powered_s {
            // What was steady when it came to the ground stays so.
            _ if self.verdict.impact_speed_m_s.is_some() => {}
            Some(t) if near && sample.phase == Phase::Powered => {
                self.verdict.steady_after_s.get_or_insert(t);
            }
            _ => self.verdict.steady_after_s = None,
        }
        self.first_p_ned.get_or_insert(body.p_ned);
        if sample.t_powered_s.is_none_or(|t| t <= self.plan_end_s) {
            self.plan_end_p_ned = body.p_ned;
        }
        self.last = Some(*body);
    }

    /// J_TPF of what was observed so far.
    pub fn j_tpf(&self) -> f64 {
        if self.infinite { f64::INFINITY } else { self.peak.max() }
    }

    /// The verdict; `None` when nothing was observed from the release on.
    pub fn finish(self) -> Option<Verdict> {
        let (last, first_p_ned) = (self.last?, self.first_p_ned?);
        let way_ned_m = self.plan_end_p_ned - first_p_ned;
        let Verdict { peak_tilt_rad, steady_after_s, .. } = self.verdict;
        let beside = self.flight_limits.passed(way_ned_m.z, peak_tilt_rad, steady_after_s);
        let impact =
            self.verdict.impact_speed_m_s.zip(self.impact_limit_m_s).is_some_and(|(v, limit)| v > limit);
        let passed = self.peak.parts().map(|(name, cost)| (name, cost > 1.0));
        let apart = self.verdict.canopy_distance_m.zip(self.separation_limit_m);
        let contact = apart.is_some_and(|(distance_m, least_m)| distance_m < least_m);
        let beyond = [(NOT_FINITE, self.infinite), ("impact", impact), (SEPARATION, contact)];
        let passed = passed.into_iter().chain(beyond);
        Some(Verdict {
            j_tpf: self.j_tpf(),
            decided_by: if self.infinite { NOT_FINITE } else { self.peak.decided_by() },
            peak_speed_m_s: self.peak.speed * self.limits.speed_m_s,
            altitude_lost_m: way_ned_m.z,
            way_ned_m,
            limits_passed: passed.filter(|(_, passed)| *passed).map(|(name, _)| name).chain(beside).collect(),
            final_v_ned: last.v_ned,
            ..self.verdict
        })
    }
}
