//! Safety of a flight: the peak of a state's cost J_state, which is J_TPF (51), and the verdict on a drop.
//!
//! ```text
//! J_TPF = max over all steps, ends included, of J_state
//! ```
//!
//! J_state, (47)-(50), is [`StateCost`]'s.

use std::sync::Arc;

use nalgebra::Vector3;

use super::judge::{Course, Flown, Objection, OnTheGround, objections};
use super::limits::Limits;
use super::outcome::{CANOPY_DISTANCE, Outcome};
use super::power::PowerUse;
use super::scenario::Scenario;
use super::watched::{Seen, Sight, Watched};
use crate::frames::{pitch, tilt};
use crate::model::environment::LocalAir;
use crate::model::rigid_body::BodyState;
use crate::model::supply::PackLimits;
use crate::model::{DiskState, Environment, MAX_ROTORS, Rotor, Vehicle};
use crate::sim::ground::Grounded;
use crate::sim::limits::{NOT_FINITE, SafetyLimits, StateCost};
use crate::sim::{Phase, Sample};
use crate::trajectory::Trajectory;
use crate::units::DEG_PER_RAD;
use crate::vector::V3;

/// Peaks of a flight's attitude and rates, with their signs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peaks {
    /// Largest pitch, either way [rad].
    pub pitch_rad: f64,
    /// Largest pitch rate, either way [rad/s].
    pub pitch_rate_rad_s: f64,
    /// Largest roll, either way [rad]; zero in the plane.
    pub roll_rad: f64,
    /// Largest roll rate, either way [rad/s]; zero in the plane.
    pub roll_rate_rad_s: f64,
    /// Largest angle between the body's up axis and the vertical [rad].
    pub tilt_rad: f64,
}

impl Peaks {
    /// The peaks that have been seen.
    fn of(seen: &Watched<f64>) -> Self {
        let [pitch_rad, pitch_rate_rad_s, roll_rad, roll_rate_rad_s] = seen.peaks;
        Self { pitch_rad, pitch_rate_rad_s, roll_rad, roll_rate_rad_s, tilt_rad: seen.tilt_rad }
    }

    /// A flight's numbers with these peaks among them.
    pub(super) fn put_into(&self, outcome: Outcome) -> Outcome {
        Outcome {
            peak_pitch_deg: self.pitch_rad.abs() * DEG_PER_RAD,
            peak_pitch_rate_deg_s: self.pitch_rate_rad_s.abs() * DEG_PER_RAD,
            peak_roll_deg: self.roll_rad.abs() * DEG_PER_RAD,
            peak_roll_rate_deg_s: self.roll_rate_rad_s.abs() * DEG_PER_RAD,
            peak_tilt_deg: self.tilt_rad * DEG_PER_RAD,
            ..outcome
        }
    }
}

/// Takes the samples of a flight from t = 0 for its [`Outcome`].
#[derive(Clone, Debug)]
pub struct FlightWatch<'a> {
    pub(super) scenario: &'a Scenario,
    start_ned_m: Vector3<f64>,
    pub(super) plan_end_s: f64,
    pub(super) seen: Seen,
    /// Position at the last sample of the plan, NED [m].
    pub(super) plan_end_p_ned: Vector3<f64>,
    final_v_ned: Vector3<f64>,
}

impl<'a> FlightWatch<'a> {
    /// No sample yet, of a flight that begins at a place, NED [m]; the samples of its plan come at times up
    /// to `plan_end_s` [s].
    pub fn new(scenario: &'a Scenario, start_ned_m: Vector3<f64>, plan_end_s: f64) -> Self {
        Self {
            scenario,
            start_ned_m,
            plan_end_s,
            seen: Seen::nothing(&scenario.limits, &scenario.target_v_ned),
            plan_end_p_ned: start_ned_m,
            final_v_ned: Vector3::zeros(),
        }
    }

    /// Takes the next sample.
    pub fn observe(&mut self, sample: &Sample) {
        let body = &sample.state.body;
        let now = Sight {
            motion: &body.motion(),
            turned_over: sample.turned_over,
            over: false,
            a_down_m_s2: sample.a_ned.z,
            canopy_m: None,
            steady_at_s: Some(sample.t_s),
            plan_v_ned: None,
        };
        let Scenario { limits, target_v_ned, .. } = self.scenario;
        self.seen.see(&now, limits, target_v_ned);
        self.final_v_ned = body.v_ned;
        if sample.t_s <= self.plan_end_s {
            self.plan_end_p_ned = body.p_ned;
        }
    }

    /// The flight's peaks and end, when it was steady, and its way from the start to the plan's end.
    pub fn outcome(&self) -> Outcome {
        let (seen, watched) = (&self.seen, &self.seen.watched);
        let outcome = Outcome {
            j_tpf: watched.j_tpf(),
            peak_speed_m_s: watched.speed_m_s,
            steady_after_s: seen.steady_after_s(),
            steady_rms_m_s: seen.steady_rms_m_s(),
            ..Peaks::of(watched).put_into(Outcome::default())
        };
        outcome.with_way(self.plan_end_p_ned - self.start_ned_m).with_final_v(self.final_v_ned)
    }
}

/// Verdict on a drop, from the release to the end: what it came to, of which [`judge()`] says whether it was
/// safe. Where the vehicle comes to the ground the flight ends: what it does there counts for no peak.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Limits that the flight is judged by.
    pub limits: Limits,
    /// The flight's numbers.
    pub outcome: Outcome,
    /// The parts of J_state, each at its peak.
    pub peak_cost: StateCost,
    /// Name of the quantity that J_TPF is the share of: "speed", "pitch", "pitch_rate", "roll", "roll_rate";
    /// [`NOT_FINITE`].
    pub decided_by: &'static str,
    /// Peaks of attitude and rates, with their signs.
    pub peaks: Peaks,
    /// Largest vertical acceleration, either way, with its sign (down is positive) [m/s^2].
    pub peak_vertical_acceleration_m_s2: f64,
    /// Names of the limits that were passed, as [`Objection::limits_passed`] has them.
    pub limits_passed: Vec<&'static str>,
    /// Whether it ended before the plan did that it was to fly.
    pub plan_cut: bool,
    /// How it came to the ground before the plan's end, if it did.
    pub on_the_ground: Option<OnTheGround>,
    /// Time of powered flight that each rotor is in the vortex ring, inside Johnson's stability boundary [s];
    /// empty where the blades are not known.
    pub vortex_ring_s: Vec<f64>,
    /// What the drop asked of its battery, where that has a voltage.
    pub power: Option<PowerUse>,
}

impl Verdict {
    /// Whether the canopy has come closer to the vehicle than the mission allows.
    pub fn recontact(&self) -> bool {
        CANOPY_DISTANCE.judged.is_some_and(|names| self.limits_passed.contains(&names.passed))
    }

    /// Nothing yet.
    fn begun(limits: Limits) -> Self {
        Self {
            limits,
            outcome: Outcome::default(),
            peak_cost: StateCost::default(),
            decided_by: "",
            peaks: Peaks::default(),
            peak_vertical_acceleration_m_s2: 0.0,
            limits_passed: Vec::new(),
            plan_cut: false,
            on_the_ground: None,
            vortex_ring_s: Vec::new(),
            power: None,
        }
    }
}

/// A plan that is flown, and how far the flight is from it.
#[derive(Clone, Debug)]
struct PlanWatch {
    plan: Trajectory,
    /// Way down from the plan's beginning to its lowest point [m].
    needs_m: f64,
    /// Whether its end is level or climbs.
    pulls_out: bool,
}

impl PlanWatch {
    fn new(plan: &Trajectory) -> Self {
        let (needs_m, pulls_out) = way_down(plan);
        Self { plan: plan.clone(), needs_m, pulls_out }
    }

    /// The velocity, NED [m/s], at a time that is in the plan [s].
    fn v_ned(&self, t_s: f64) -> Option<Vector3<f64>> {
        (0.0..=self.plan.end_s()).contains(&t_s).then(|| self.plan.velocity_ned(t_s))
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

/// Makes a [`Verdict`] of a flight's samples, given one by one in order of time.
#[derive(Clone, Debug)]
pub struct VerdictBuilder {
    v_cmd_ned: Vector3<f64>,
    pub(super) seen: Seen,
    /// How many samples were in the plan's time.
    pub(super) in_plan: u32,
    /// Touches so far; the rest is filled in at the end.
    verdict: Verdict,
    /// The first sample after the release: time [s] and position.
    first: Option<(f64, Vector3<f64>)>,
    /// Position when the rotors were freed.
    free_p_ned: Option<Vector3<f64>>,
    plan_end_s: f64,
    /// The plan that is flown, and how far from it.
    plan: Option<PlanWatch>,
    pub(super) plan_end_p_ned: Vector3<f64>,
    /// Way before the first sample, NED [m].
    way_before_ned_m: Vector3<f64>,
    pub(super) last: Option<BodyState>,
    /// Time of the last sample of powered flight, from t = 0 [s].
    pub(super) last_powered_s: f64,
    grounded: Grounded,
    touching: bool,
    /// Vehicle and site whose rotors are watched.
    disks: Option<(Arc<Vehicle>, Environment, LocalAir)>,
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
            seen: Seen::nothing(&limits, &v_cmd_ned),
            in_plan: 0,
            verdict: Verdict::begun(limits),
            first: None,
            free_p_ned: None,
            plan_end_s: f64::INFINITY,
            plan: None,
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
        Self { plan: Some(PlanWatch::new(plan)), ..self.to_plans_end(plan.end_s()) }
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
            self.disks = Some((vehicle.clone(), site.clone(), LocalAir::about(site, 0.0)));
        }
        self
    }

    /// Tells also what the drop asks of a battery with these limits.
    pub fn watching_battery(mut self, limits: Option<&PackLimits>) -> Self {
        self.verdict.power = limits.map(PowerUse::of);
        self
    }

    fn observe_rotors(&mut self, sample: &Sample) {
        let Some((vehicle, site, air)) = &mut self.disks else { return };
        if let Some((before_s, in_ring)) = self.in_ring {
            let times = self.verdict.vortex_ring_s.iter_mut().zip(in_ring);
            times.filter(|(_, inside)| *inside).for_each(|(time, _)| *time += sample.t_s - before_s);
        }
        self.in_ring = (sample.phase == Phase::Powered).then(|| {
            let body = &sample.state.body;
            air.follow(site, body.p_ned.z);
            let there = air.at(site, sample.wind_ned.into(), body.p_ned.z);
            let disks = DiskState::of_each(vehicle, &there, &body.motion(), &sample.balance.thrust_n);
            (
                sample.t_s,
                disks.map_or([false; MAX_ROTORS], |disks| disks.map(|disk| disk.is_in_vortex_ring())),
            )
        });
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
            let tilt_deg = tilt(before.q_ned_from_body) * DEG_PER_RAD;
            let Outcome { impact_speed_m_s, impact_tilt_deg, .. } = &mut so_far.outcome;
            for (most, now) in [(impact_speed_m_s, before.v_ned.norm()), (impact_tilt_deg, tilt_deg)] {
                *most = Some(most.map_or(now, |x| x.max(now)));
            }
            if sample.t_powered_s.is_none_or(|t| t < self.plan_end_s) && so_far.on_the_ground.is_none() {
                let (release_s, release_p_ned) = self.first.unwrap_or((sample.t_s, body.p_ned));
                let fallen_m = self.free_p_ned.map(|free| free.z - release_p_ned.z);
                so_far.on_the_ground = Some(OnTheGround {
                    after_s: sample.t_s - release_s,
                    height_m: body.p_ned.z - release_p_ned.z,
                    rotors_free: self.free_p_ned.is_some(),
                    needed: fallen_m
                        .zip(self.plan.as_ref())
                        .map(|(m, plan)| (m + plan.needs_m, plan.pulls_out)),
                });
            }
        }
        self.grounded.observe(touch.is_some(), body.p_ned.z)
    }

    /// The plan's velocity, NED [m/s], at a time that is in it [s].
    pub(super) fn plan_v_ned(&self, t_powered_s: Option<f64>) -> Option<Vector3<f64>> {
        self.plan.as_ref()?.v_ned(t_powered_s?)
    }

    /// Takes the next sample; what happens under the canopy does not count.
    pub fn observe(&mut self, sample: &Sample) {
        if sample.phase == Phase::Hanging {
            return;
        }
        let body = &sample.state.body;
        self.begin(sample.t_s, sample.phase, body);
        let over = self.observe_ground(sample);
        let limits = &self.verdict.limits;
        let plan_v_ned = self.plan_v_ned(sample.t_powered_s);
        let canopy = sample.canopy.as_ref();
        let now = Sight {
            motion: &body.motion(),
            turned_over: sample.turned_over,
            over,
            a_down_m_s2: sample.a_ned.z,
            canopy_m: canopy.map(|canopy| (canopy.state.p_ned - body.p_ned).norm()),
            steady_at_s: sample.t_powered_s.filter(|_| sample.phase == Phase::Powered),
            plan_v_ned: plan_v_ned.map(V3::from),
        };
        self.seen.see(&now, limits, &self.v_cmd_ned);
        self.in_plan += u32::from(plan_v_ned.is_some());
        self.observe_rotors(sample);
        if let Some(power) = &mut self.verdict.power {
            power.observe(sample);
        }
        if self.is_up_to_plans_end(sample.t_powered_s) {
            self.plan_end_p_ned = body.p_ned;
        }
        self.last = Some(*body);
        self.last_powered_s = sample.t_powered_s.unwrap_or(self.last_powered_s);
    }

    /// Whether a sample in a phase begins something: what is observed, or powered flight.
    pub(super) fn is_to_begin(&self, phase: Phase) -> bool {
        self.first.is_none() || (phase == Phase::Powered && self.free_p_ned.is_none())
    }

    /// Takes the first sample's time [s] and state, and the state in which the rotors were freed.
    pub(super) fn begin(&mut self, t_s: f64, phase: Phase, body: &BodyState) {
        if phase == Phase::Powered {
            self.free_p_ned.get_or_insert(body.p_ned);
        }
        if self.first.is_none() {
            self.first = Some((t_s, body.p_ned));
            let outcome = &mut self.verdict.outcome;
            outcome.release_pitch_deg = Some(pitch(body.q_ned_from_body) * DEG_PER_RAD);
            outcome.release_pitch_rate_deg_s = Some(body.omega_body.y * DEG_PER_RAD);
        }
    }

    /// Whether a time of powered flight [s] is not after the plan's end.
    pub(super) fn is_up_to_plans_end(&self, t_powered_s: Option<f64>) -> bool {
        t_powered_s.is_none_or(|t| t <= self.plan_end_s)
    }

    /// Whether the vehicle is on the ground, or has come there and not left it.
    pub(super) fn is_at_the_ground(&self) -> bool {
        self.touching || self.grounded != Grounded::default()
    }

    /// Whether what it looks for at each sample is the same as the other does, and is seen in [`Watched`].
    pub(super) fn watches_as(&self, other: &Self) -> bool {
        let plans = [self, other].map(|builder| builder.plan.as_ref().map(|plan| &plan.plan));
        self.disks.is_none()
            && self.verdict.power.is_none()
            && self.limits() == other.limits()
            && self.v_cmd_ned == other.v_cmd_ned
            && self.plan_end_s == other.plan_end_s
            && plans[0] == plans[1]
    }

    /// Limits that it judges by.
    pub(super) fn limits(&self) -> &Limits {
        &self.verdict.limits
    }

    /// Velocity that is to be reached, NED [m/s].
    pub(super) fn v_cmd_ned(&self) -> Vector3<f64> {
        self.v_cmd_ned
    }

    /// J_TPF of what was observed so far.
    pub fn j_tpf(&self) -> f64 {
        self.seen.watched.j_tpf()
    }

    /// The verdict; `None` when nothing was observed from the release on.
    pub fn finish(self) -> Option<Verdict> {
        let (last, (_, first_p_ned)) = (self.last?, self.first?);
        let way_ned_m = self.way_before_ned_m + self.plan_end_p_ned - first_p_ned;
        let plan_cut = self.plan.is_some() && self.last_powered_s + STEP_AT_MOST_S < self.plan_end_s;
        let (j_tpf, Verdict { limits, outcome, .. }) = (self.j_tpf(), &self.verdict);
        let Watched { cost, infinite, a_down_m_s2, canopy_m, distance2, .. } = self.seen.watched;
        let (peak_cost, peaks) = (StateCost::from(cost), Peaks::of(&self.seen.watched));
        let outcome = Outcome {
            j_tpf,
            peak_speed_m_s: cost[0] * limits.safety.speed_m_s,
            steady_after_s: self.seen.steady_after_s(),
            steady_rms_m_s: self.seen.steady_rms_m_s(),
            canopy_distance_m: canopy_m.is_finite().then_some(canopy_m),
            tracking_rms_m_s: self.plan.as_ref().map(|_| (distance2 / f64::from(self.in_plan)).sqrt()),
            ..peaks.put_into(*outcome)
        };
        let mut verdict = Verdict {
            outcome: outcome.with_way(way_ned_m).with_final_v(last.v_ned),
            peak_cost,
            decided_by: if infinite { NOT_FINITE } else { peak_cost.decided_by() },
            peaks,
            peak_vertical_acceleration_m_s2: a_down_m_s2,
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
    let flown = verdict.map(|v| Flown {
        outcome: &v.outcome,
        limits: &v.limits,
        cost: Some(v.peak_cost),
        plan_cut: v.plan_cut,
        on_the_ground: v.on_the_ground,
    });
    objections(flown, course)
}

/// Why a flight from t = 0, which knows neither ground nor canopy, was not safe; empty where it was.
pub fn judge_trial(outcome: &Outcome, limits: &Limits) -> Vec<Objection> {
    let flown = Flown { outcome, limits, cost: None, plan_cut: false, on_the_ground: None };
    objections(Some(flown), &Course::WHOLE)
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
