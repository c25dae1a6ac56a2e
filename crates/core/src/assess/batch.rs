//! Costs of many flights at once: what [`super::safety`] and [`super::tracking`] say of a flight, for the
//! flights of [`crate::sim::planar`].
//!
//! Pitch counts as half a turn at the most: in the plane a flight that has turned over has passed that.
//!
//! A flight is given up at the first control step at which it is faster than 60 m/s, turned by more than 6
//! rad, or no number; its peaks are those up to then. So a flight's outcome does not depend on the flights
//! beside it.

#![expect(
    clippy::needless_range_loop,
    reason = "a loop over lanes indexes many arrays at once, the same way throughout"
)]

use std::ops::ControlFlow;

use nalgebra::Vector3;

use super::limits::Limits;
use super::outcome::Outcome;
use super::safety::Peaks;
use super::steady::MeanVelocity;
use super::tracking::{DIVERGED, PITCH_MAX_RAD, SPEED_MAX_M_S};
use crate::math;
use crate::sim::FlightPlan;
use crate::sim::limits::{SafetyLimits, pitch_share};
use crate::sim::planar::{Flight, LANES, Lanes, Model, NotPlanar, Observer, SetpointTable, State, fly};
use crate::trajectory::Trajectory;

/// Setpoints, limits and plan nodes that flights are judged by.
#[derive(Clone, Debug)]
pub struct BatchMeasure {
    setpoints: SetpointTable,
    limits: SafetyLimits,
    /// Velocity of the steady state, north and down [m/s].
    target_m_s: [f64; 2],
    /// Square of the speed error within which the flight is steady [m^2/s^2].
    steady_within2: f64,
    /// What is told of each where steady flight is told by the mean of its velocity.
    mean: Option<MeanVelocity>,
    /// Last control step of the way that is measured.
    way_steps: usize,
    nodes: Vec<PlanNode>,
    /// Nodes that fall on no control step.
    missed: usize,
}

/// Longitudinal state of the plan at a control step.
#[derive(Clone, Copy, Debug)]
struct PlanNode {
    step: usize,
    /// `[q0, q2, vN, vD, Q]`.
    state: [f64; 5],
}

/// Costs, peaks and end of a flight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BatchFlight {
    /// J_RMS (45) over the plan's nodes; 1000 for a flight that was given up or did not reach the last node;
    /// 0 without a plan.
    pub rms: f64,
    /// Peaks and end of the flight; no roll.
    pub outcome: Outcome,
    /// Whether the flight was given up.
    pub given_up: bool,
}

impl BatchMeasure {
    /// Flights along `plan`, by limits that say what is steady about `target_m_s`, north and down [m/s].
    /// RMS is against the nodes of the trajectory `tracked`, where there is one; the control period must
    /// divide its intervals.
    ///
    /// # Errors
    /// [`NotPlanar`] as [`SetpointTable::new`].
    pub fn new(
        plan: &FlightPlan<'_>,
        tracked: Option<&Trajectory>,
        limits: &Limits,
        target_m_s: [f64; 2],
    ) -> Result<Self, NotPlanar> {
        let setpoints = SetpointTable::new(plan)?;
        let dt_s = setpoints.period_s();
        let nodes = tracked.map_or(&[][..], Trajectory::nodes);
        let on_grid: Vec<PlanNode> = nodes
            .iter()
            .filter_map(|n| {
                let step = (n.t_s / dt_s).round();
                let state =
                    [n.q_ned_from_body[0], n.q_ned_from_body[2], n.v_ned.x, n.v_ned.z, n.omega_body.y];
                let reached = (step * dt_s - n.t_s).abs() < 1e-6 && step <= setpoints.steps() as f64;
                reached.then_some(PlanNode { step: step as usize, state })
            })
            .collect();
        let missed = nodes.len() - on_grid.len();
        let steady_within2 = limits.steady_within_m_s * limits.steady_within_m_s;
        let [north, down] = target_m_s;
        let mean = MeanVelocity::by(limits, &Vector3::new(north, 0.0, down));
        let limits = limits.safety;
        let way_steps = setpoints.steps();
        Ok(Self { setpoints, limits, target_m_s, steady_within2, mean, way_steps, nodes: on_grid, missed })
    }

    /// Measures the way to this time [s] instead of to the flight's end.
    pub fn to_plans_end(mut self, plan_end_s: f64) -> Self {
        let steps = (plan_end_s / self.setpoints.period_s()).round();
        self.way_steps = self.setpoints.steps().min(steps.max(0.0) as usize);
        self
    }

    /// The setpoints.
    pub fn setpoints(&self) -> &SetpointTable {
        &self.setpoints
    }
}

/// Flies and judges each flight; `judged` takes as many as there are flights or places, whichever are
/// fewer. Any number of flights, in groups of [`LANES`]; threads are the caller's affair: split at multiples
/// of [`LANES`].
pub fn judge_flights(model: &Model, measure: &BatchMeasure, flights: &[Flight], judged: &mut [BatchFlight]) {
    for (flights, judged) in flights.chunks(LANES).zip(judged.chunks_mut(LANES)) {
        // A last, smaller group fills its lanes with its first flight.
        let lanes = std::array::from_fn(|i| *flights.get(i).unwrap_or(&flights[0]));
        let mut judge = Judge::new(measure);
        fly(model, &measure.setpoints, &lanes, &mut judge);
        for (i, flight) in judged.iter_mut().enumerate().take(flights.len()) {
            *flight = judge.flight(i);
        }
    }
}

/// Collects the costs of eight flights.
struct Judge<'a> {
    measure: &'a BatchMeasure,
    next_node: usize,
    sum_of_squares: Lanes,
    /// Largest square of the speed.
    speed2: Lanes,
    /// Attitude at the largest pitch either way, where q0 is lowest.
    q0: Lanes,
    q2: Lanes,
    /// Pitch rate of the largest size.
    rate: Lanes,
    /// Step since when it is steady; negative when it is not.
    steady_since: Lanes,
    /// Of each flight where steady flight is told by the mean of its velocity; else empty.
    means: Vec<MeanVelocity>,
    final_v: [Lanes; 2],
    /// Sum of the velocities north and down for the trapezoid rule [m/s].
    way: [Lanes; 2],
    /// 1 while a flight goes on, 0 once it is given up.
    going: Lanes,
    finite: [bool; LANES],
}

impl<'a> Judge<'a> {
    fn new(measure: &'a BatchMeasure) -> Self {
        Self {
            measure,
            next_node: 0,
            sum_of_squares: [0.0; LANES],
            speed2: [0.0; LANES],
            q0: [1.0; LANES],
            q2: [0.0; LANES],
            rate: [0.0; LANES],
            steady_since: [-1.0; LANES],
            means: measure.mean.iter().flat_map(|mean| vec![mean.clone(); LANES]).collect(),
            final_v: [[0.0; LANES]; 2],
            way: [[0.0; LANES]; 2],
            going: [1.0; LANES],
            finite: [true; LANES],
        }
    }

    /// Gives up the flights that are lost in this state.
    #[cold]
    fn give_up(&mut self, state: &State) -> ControlFlow<()> {
        for i in 0..LANES {
            if self.going[i] > 0.0 && !in_hand(state, i) {
                self.going[i] = 0.0;
                let numbers = [state.v_n[i], state.v_d[i], state.q0[i], state.q2[i], state.rate[i]];
                self.finite[i] = numbers.iter().all(|x| x.is_finite());
                self.final_v[0][i] = state.v_n[i];
                self.final_v[1][i] = state.v_d[i];
            }
        }
        if self.going.contains(&1.0) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    }

    #[inline(always)]
    fn track(&mut self, state: &State, node: &PlanNode) {
        for i in 0..LANES {
            let now = [state.q0[i], state.q2[i], state.v_n[i], state.v_d[i], state.rate[i]];
            let mut sum = 0.0;
            for k in 0..5 {
                let e = now[k] - node.state[k];
                sum += e * e;
            }
            self.sum_of_squares[i] += sum;
        }
    }

    /// Takes the next velocity into the means of the flights that go on.
    #[cold]
    fn observe_means(&mut self, step: usize, state: &State) {
        let t_s = step as f64 * self.measure.setpoints.period_s();
        for (i, mean) in self.means.iter_mut().enumerate() {
            let goes_on = self.going[i] > 0.0;
            mean.observe(goes_on.then_some(t_s), &Vector3::new(state.v_n[i], 0.0, state.v_d[i]));
        }
    }

    /// Takes the velocity at the end.
    fn land(&mut self, state: &State) {
        for i in 0..LANES {
            if self.going[i] > 0.0 {
                (self.final_v[0][i], self.final_v[1][i]) = (state.v_n[i], state.v_d[i]);
            }
        }
    }

    fn flight(&self, i: usize) -> BatchFlight {
        let limits = &self.measure.limits;
        let speed = self.speed2[i].sqrt();
        let pitch = 2.0 * math::atan2(self.q2[i], self.q0[i]);
        let shares = [
            speed / limits.speed_m_s,
            pitch_share(pitch, limits),
            self.rate[i].abs() / limits.pitch_rate_rad_s,
        ];
        let n = self.measure.nodes.len();
        let unfinished = self.going[i] == 0.0 || self.measure.missed > 0 || self.next_node < n;
        let period_s = self.measure.setpoints.period_s();
        let (mean, since) = (self.means.get(i).filter(|_| self.going[i] > 0.0), self.steady_since[i]);
        let at_once_s = (since >= 0.0).then_some(since * period_s);
        let peaks = Peaks {
            pitch_rad: pitch,
            pitch_rate_rad_s: self.rate[i],
            tilt_rad: pitch.abs().min(std::f64::consts::PI),
            ..Peaks::default()
        };
        let outcome = Outcome {
            j_tpf: if self.finite[i] { shares.into_iter().fold(0.0, f64::max) } else { f64::INFINITY },
            peak_speed_m_s: speed,
            steady_after_s: mean.map_or(at_once_s, MeanVelocity::steady_after_s),
            steady_rms_m_s: mean.and_then(MeanVelocity::rms_m_s),
            ..peaks.put_into(Outcome::default())
        };
        let way_ned_m = Vector3::new(self.way[0][i], 0.0, self.way[1][i]) * period_s;
        BatchFlight {
            rms: match n {
                _ if unfinished => DIVERGED,
                0 => 0.0,
                _ => (self.sum_of_squares[i] / n as f64).sqrt(),
            },
            outcome: outcome.with_way(way_ned_m).with_final_v(Vector3::new(
                self.final_v[0][i],
                0.0,
                self.final_v[1][i],
            )),
            given_up: self.going[i] == 0.0,
        }
    }
}

impl Observer for Judge<'_> {
    #[inline(always)]
    fn observe(&mut self, step: usize, state: &State) -> ControlFlow<()> {
        let [target_n, target_d] = self.measure.target_m_s;
        let near2 = self.measure.steady_within2;
        let mut lost = false;
        let ends = (step == 0) | (step == self.measure.way_steps);
        let share = if step > self.measure.way_steps {
            0.0
        } else if ends {
            0.5
        } else {
            1.0
        };
        for i in 0..LANES {
            let going = self.going[i] > 0.0;
            let (v_n, v_d) = (state.v_n[i], state.v_d[i]);
            let share = if going { share } else { 0.0 };
            self.way[0][i] += share * v_n;
            self.way[1][i] += share * v_d;
            let speed2 = v_n * v_n + v_d * v_d;
            let faster = going & (speed2 > self.speed2[i]);
            self.speed2[i] = if faster { speed2 } else { self.speed2[i] };
            let steeper = going & (state.q0[i] < self.q0[i]);
            self.q0[i] = if steeper { state.q0[i] } else { self.q0[i] };
            self.q2[i] = if steeper { state.q2[i] } else { self.q2[i] };
            let quicker = going & (state.rate[i].abs() > self.rate[i].abs());
            self.rate[i] = if quicker { state.rate[i] } else { self.rate[i] };
            let (off_n, off_d) = (v_n - target_n, v_d - target_d);
            let near = going & (off_n * off_n + off_d * off_d <= near2);
            let since = if self.steady_since[i] >= 0.0 { self.steady_since[i] } else { step as f64 };
            self.steady_since[i] = if near { since } else { -1.0 };
            lost |= going & !in_hand(state, i);
        }
        if let Some(node) = self.measure.nodes.get(self.next_node)
            && node.step == step
        {
            self.track(state, node);
            self.next_node += 1;
        }
        if !self.means.is_empty() {
            self.observe_means(step, state);
        }
        if lost {
            self.give_up(state)?;
        }
        if step == self.measure.setpoints.steps() {
            self.land(state);
        }
        ControlFlow::Continue(())
    }
}

/// `cos(PITCH_MAX_RAD/2)`: the pitch `2 atan2(q2, q0)` of a unit quaternion passes 6 rad where q0 passes
/// this.
const COS_HALF_PITCH_MAX: f64 = -0.989_992_496_600_445_4;
const _: () = assert!(PITCH_MAX_RAD == 6.0);

/// Whether a flight goes on.
#[inline(always)]
fn in_hand(state: &State, i: usize) -> bool {
    let speed2 = state.v_n[i] * state.v_n[i] + state.v_d[i] * state.v_d[i];
    (speed2 <= SPEED_MAX_M_S * SPEED_MAX_M_S)
        & (state.q0[i] >= COS_HALF_PITCH_MAX)
        & (state.rate[i].abs() < f64::INFINITY)
}
