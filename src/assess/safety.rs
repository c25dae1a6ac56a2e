//! Safety of a flight: the peak of a state's cost J_state, which is J_TPF (51), and the verdict on a drop.
//!
//! ```text
//! J_TPF = max over all steps, ends included, of J_state
//! ```
//!
//! J_state, (47)-(50), is [`StateCost`]'s.

use std::sync::Arc;

use nalgebra::Vector3;

use super::judge::{Course, Limit, Limits, Numbers, Objection, OnTheGround, objections};
use super::power::PowerUse;
use crate::frames::{bank, pitch, tilt};
use crate::model::rigid_body::BodyState;
use crate::model::supply::PackLimits;
use crate::model::{DiskState, Environment, MAX_ROTORS, Rotor, Vehicle};
use crate::sim::ground::Grounded;
use crate::sim::limits::{NOT_FINITE, SafetyLimits, StateCost};
use crate::sim::{Phase, Sample};
use crate::trajectory::Trajectory;

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

/// Verdict on a drop, from the release to the end: what it came to, of which [`judge()`] says whether it was
/// safe. Where the vehicle comes to the ground the flight ends: what it does there counts for no peak.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Limits that the flight is judged by.
    pub limits: Limits,
    /// J_TPF, (51).
    pub j_tpf: f64,
    /// The parts of J_state, each at its peak.
    pub peak_cost: StateCost,
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
    /// Names of the limits that were passed, as [`Objection::limits_passed`] has them.
    pub limits_passed: Vec<&'static str>,
    /// Velocity at the end, NED [m/s].
    pub final_v_ned: Vector3<f64>,
    /// Fastest that it came to the ground, if it did: its whole speed over ground at the touch [m/s].
    pub impact_speed_m_s: Option<f64>,
    /// Largest angle between the body's up axis and the vertical when it came to the ground, if it did [rad].
    pub impact_tilt_rad: Option<f64>,
    /// Whether it ended before the plan did that it was to fly.
    pub plan_cut: bool,
    /// How it came to the ground before the plan's end, if it did.
    pub on_the_ground: Option<OnTheGround>,
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
        self.limits_passed.contains(&Limit::Separation.name())
    }

    /// Nothing yet.
    fn begun(limits: Limits) -> Self {
        Self {
            limits,
            j_tpf: 0.0,
            peak_cost: StateCost::default(),
            decided_by: "",
            peak_speed_m_s: 0.0,
            peak_pitch_rad: 0.0,
            peak_pitch_rate_rad_s: 0.0,
            peak_roll_rad: 0.0,
            peak_roll_rate_rad_s: 0.0,
            peak_vertical_acceleration_m_s2: 0.0,
            altitude_lost_m: 0.0,
            steady_after_s: None,
            limits_passed: Vec::new(),
            final_v_ned: Vector3::zeros(),
            impact_speed_m_s: None,
            impact_tilt_rad: None,
            plan_cut: false,
            on_the_ground: None,
            peak_tilt_rad: 0.0,
            way_ned_m: Vector3::zeros(),
            canopy_distance_m: None,
            vortex_ring_s: Vec::new(),
            power: None,
        }
    }
}

/// A flight whose last sample is so close to an end has come to it [s].
pub const STEP_AT_MOST_S: f64 = 0.02;

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
    v_cmd_ned: Vector3<f64>,
    infinite: bool,
    /// Peaks, steadiness and touches so far; the rest is filled in at the end.
    verdict: Verdict,
    /// The first sample after the release: time [s] and position.
    first: Option<(f64, Vector3<f64>)>,
    /// Position when the rotors were freed.
    free_p_ned: Option<Vector3<f64>>,
    plan_end_s: f64,
    /// The way down that the plan needs at the most, from t = 0 [m], and whether it ends level or climbing.
    plan_needs: Option<(f64, bool)>,
    plan_end_p_ned: Vector3<f64>,
    /// Way before the first sample, NED [m].
    way_before_ned_m: Vector3<f64>,
    last: Option<BodyState>,
    /// Time of the last sample of powered flight, from t = 0 [s].
    last_powered_s: f64,
    grounded: Grounded,
    touching: bool,
    /// Vehicle and site whose rotors are watched.
    disks: Option<(Arc<Vehicle>, Environment)>,
    /// Time of the sample before [s], and which rotors were in the vortex ring then.
    in_ring: Option<(f64, [bool; MAX_ROTORS])>,
}

impl VerdictBuilder {
    /// Judges J_state alone, by these limits; steady means close to `v_cmd_ned` [m/s].
    pub fn new(safety: SafetyLimits, v_cmd_ned: Vector3<f64>) -> Self {
        Self::judging(Limits::of_j_state(safety, steady_within_m_s(&v_cmd_ned)), v_cmd_ned)
    }

    /// Judges by these limits; steady means close to `v_cmd_ned` [m/s].
    pub fn judging(limits: Limits, v_cmd_ned: Vector3<f64>) -> Self {
        Self {
            v_cmd_ned,
            infinite: false,
            verdict: Verdict::begun(limits),
            first: None,
            free_p_ned: None,
            plan_end_s: f64::INFINITY,
            plan_needs: None,
            plan_end_p_ned: Vector3::zeros(),
            way_before_ned_m: Vector3::zeros(),
            last: None,
            last_powered_s: f64::NEG_INFINITY,
            grounded: Grounded::default(),
            touching: false,
            disks: None,
            in_ring: None,
        }
    }

    /// Counts the altitude lost to the plan's end [s from the start of powered flight]: what comes after it
    /// is steady descent.
    pub fn to_plans_end(self, plan_end_s: f64) -> Self {
        Self { plan_end_s, ..self }
    }

    /// The flight is along this plan: counts the altitude lost to its end, and says what height it needs of a
    /// flight that comes to the ground before.
    pub fn along(self, plan: &Trajectory) -> Self {
        Self { plan_needs: Some(way_down(plan)), ..self.to_plans_end(plan.end_s()) }
    }

    /// The first sample is so far from the release [m]: the fall to t = 0 of a flight that begins there.
    pub fn after(self, way_before_ned_m: Vector3<f64>) -> Self {
        Self { way_before_ned_m, ..self }
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

    /// Whether the flight is over because the vehicle has come to the ground. A touch counts with velocity
    /// and attitude of the sample before it; what stood there from the start has not come down.
    fn observe_ground(&mut self, sample: &Sample) -> bool {
        let touching = sample.balance.ground_force_ned.z < 0.0;
        let body = &sample.state.body;
        let before = match self.last {
            Some(last) => Some(last),
            None if sample.phase == Phase::Falling => Some(*body),
            None => None,
        };
        let touch = before.filter(|before| touching && !self.touching && before.v_ned.z > 0.0);
        self.touching = touching;
        if let Some(before) = touch {
            let so_far = &mut self.verdict;
            let (speed_m_s, tilt_rad) = (before.v_ned.norm(), tilt(before.q_ned_from_body));
            so_far.impact_speed_m_s = Some(so_far.impact_speed_m_s.map_or(speed_m_s, |x| x.max(speed_m_s)));
            so_far.impact_tilt_rad = Some(so_far.impact_tilt_rad.map_or(tilt_rad, |x| x.max(tilt_rad)));
            if sample.t_powered_s.is_none_or(|t| t < self.plan_end_s) && so_far.on_the_ground.is_none() {
                let (release_s, release_p_ned) = self.first.unwrap_or((sample.t_s, body.p_ned));
                let fallen_m = self.free_p_ned.map(|free| free.z - release_p_ned.z);
                so_far.on_the_ground = Some(OnTheGround {
                    after_s: sample.t_s - release_s,
                    height_m: body.p_ned.z - release_p_ned.z,
                    rotors_free: self.free_p_ned.is_some(),
                    needed: fallen_m.zip(self.plan_needs).map(|(m, (needs_m, out))| (m + needs_m, out)),
                });
            }
        }
        self.grounded.observe(touch.is_some(), body.p_ned.z)
    }

    /// Takes the next sample; what happens under the canopy does not count.
    pub fn observe(&mut self, sample: &Sample) {
        if sample.phase == Phase::Hanging {
            return;
        }
        let body = &sample.state.body;
        if sample.phase == Phase::Powered {
            self.free_p_ned.get_or_insert(body.p_ned);
        }
        let over = self.observe_ground(sample);
        let cost = StateCost::of_sample(sample, &self.verdict.limits.safety);
        self.infinite |= cost.max() == f64::INFINITY;
        let so_far = &mut self.verdict;
        if !over {
            so_far.peak_cost = so_far.peak_cost.worse(&cost);
            keep_larger([
                (&mut so_far.peak_pitch_rad, pitch(body.q_ned_from_body)),
                (&mut so_far.peak_pitch_rate_rad_s, body.omega_body.y),
                (&mut so_far.peak_roll_rad, bank(body.q_ned_from_body)),
                (&mut so_far.peak_roll_rate_rad_s, body.omega_body.x),
                (&mut so_far.peak_vertical_acceleration_m_s2, sample.a_ned.z),
            ]);
            so_far.peak_tilt_rad = so_far.peak_tilt_rad.max(tilt(body.q_ned_from_body));
        }
        let near = (body.v_ned - self.v_cmd_ned).norm() <= so_far.limits.steady_within_m_s;
        if let Some(canopy) = &sample.canopy {
            let distance_m = (canopy.state.p_ned - body.p_ned).norm();
            let least = &mut so_far.canopy_distance_m;
            *least = Some(least.map_or(distance_m, |least| least.min(distance_m)));
        }
        self.observe_rotors(sample);
        if let Some(power) = &mut self.verdict.power {
            power.observe(sample);
        }
        match sample.t_powered_s {
            // What was steady when it came to the ground stays so.
            _ if over => {}
            Some(t) if near && sample.phase == Phase::Powered => {
                self.verdict.steady_after_s.get_or_insert(t);
            }
            _ => self.verdict.steady_after_s = None,
        }
        self.first.get_or_insert((sample.t_s, body.p_ned));
        if sample.t_powered_s.is_none_or(|t| t <= self.plan_end_s) {
            self.plan_end_p_ned = body.p_ned;
        }
        self.last = Some(*body);
        self.last_powered_s = sample.t_powered_s.unwrap_or(self.last_powered_s);
    }

    /// J_TPF of what was observed so far.
    pub fn j_tpf(&self) -> f64 {
        if self.infinite { f64::INFINITY } else { self.verdict.peak_cost.max() }
    }

    /// The verdict; `None` when nothing was observed from the release on.
    pub fn finish(self) -> Option<Verdict> {
        let (last, (_, first_p_ned)) = (self.last?, self.first?);
        let way_ned_m = self.way_before_ned_m + self.plan_end_p_ned - first_p_ned;
        let plan_cut = self.plan_needs.is_some() && self.last_powered_s + STEP_AT_MOST_S < self.plan_end_s;
        let (j_tpf, Verdict { peak_cost, limits, .. }) = (self.j_tpf(), &self.verdict);
        let mut verdict = Verdict {
            j_tpf,
            decided_by: if self.infinite { NOT_FINITE } else { peak_cost.decided_by() },
            peak_speed_m_s: peak_cost.speed * limits.safety.speed_m_s,
            altitude_lost_m: way_ned_m.z,
            way_ned_m,
            final_v_ned: last.v_ned,
            plan_cut,
            ..self.verdict
        };
        let objections = judge(Some(&verdict), &Course::WHOLE);
        verdict.limits_passed = objections.iter().flat_map(Objection::limits_passed).collect();
        Some(verdict)
    }
}

/// Why a drop was not safe, the cause first; empty where it was. Without a verdict nothing was released.
pub fn judge(verdict: Option<&Verdict>, course: &Course) -> Vec<Objection> {
    let numbers = |v: &Verdict| Numbers {
        j_tpf: v.j_tpf,
        cost: Some(v.peak_cost),
        altitude_lost_m: v.altitude_lost_m,
        peak_tilt_rad: v.peak_tilt_rad,
        steady_after_s: v.steady_after_s,
        touch: v.impact_speed_m_s.zip(v.impact_tilt_rad),
        plan_cut: v.plan_cut,
        on_the_ground: v.on_the_ground,
        canopy_distance_m: v.canopy_distance_m,
    };
    objections(verdict.map(|v| (numbers(v), &v.limits)), course)
}

/// Why a flight from t = 0, which knows neither ground nor canopy, was not safe; empty where it was.
pub fn judge_trial(flown: &TrialOutcome, limits: &Limits) -> Vec<Objection> {
    let numbers = Numbers {
        j_tpf: flown.j_tpf,
        cost: None,
        altitude_lost_m: flown.way_ned_m.z,
        peak_tilt_rad: flown.peak_tilt_rad,
        steady_after_s: flown.steady_after_s,
        touch: None,
        plan_cut: false,
        on_the_ground: None,
        canopy_distance_m: None,
    };
    objections(Some((numbers, limits)), &Course::WHOLE)
}

/// The way down from a plan's beginning to its lowest point [m], and whether its end is level or climbs.
fn way_down(plan: &Trajectory) -> (f64, bool) {
    let (mut down_m, mut most_m) = (0.0, 0.0f64);
    for pair in plan.nodes().windows(2) {
        // Simpson's rule, exact for the cubic between nodes.
        let [from, to] = [pair[0].t_s, pair[1].t_s];
        let v_down = |t_s: f64| plan.velocity_ned(t_s).z;
        down_m += (to - from) / 6.0 * (v_down(from) + 4.0 * v_down(0.5 * (from + to)) + v_down(to));
        most_m = most_m.max(down_m);
    }
    let pulls_out = plan.velocity_ned(plan.end_s()).z <= 0.05 * plan.velocity_ned(0.0).z.abs();
    (most_m, pulls_out)
}
