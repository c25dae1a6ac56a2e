//! The motion of a flight or a plan over time since the rotors were freed, as figures show it.

use nalgebra::Vector3;

use crate::plan_motion::plan_motion;
use samara_core::assess::StateCost;
use samara_core::frames::{bank, pitch, rotate_ned_from_body};
use samara_core::model::PerRotor;
use samara_core::model::rigid_body::BodyState;
use samara_core::sim::{Phase, Sample};
use samara_core::trajectory::Trajectory;
use samara_core::units::RAD_PER_DEG;
use samara_mission::Mission;

/// Part of the flight before the release that is shown, as a fraction of what is shown after it.
const BEFORE_RELEASE: f64 = 0.06;

/// The motion at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrackPoint {
    /// Time since the rotors were freed [s]; negative before.
    pub(crate) t_s: f64,
    /// Position from the release [m]; of a plan, from its beginning.
    pub(crate) north_m: f64,
    pub(crate) east_m: f64,
    pub(crate) down_m: f64,
    pub(crate) v_ned: Vector3<f64>,
    pub(crate) pitch_rad: f64,
    pub(crate) pitch_rate_rad_s: f64,
    pub(crate) roll_rad: f64,
    pub(crate) roll_rate_rad_s: f64,
    /// The body's axis that points down, NED.
    pub(crate) z_ned: Vector3<f64>,
    /// Thrust of each rotor [N].
    pub(crate) thrust_n: PerRotor,
    /// Bus voltage [V] and current of the pack [A], where they are known.
    pub(crate) bus: Option<(f64, f64)>,
    pub(crate) j_state: f64,
    /// The quantity whose share of its limit is J_state.
    pub(crate) decided_by: &'static str,
}

/// The motion in order of time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Track {
    pub(crate) instants: Vec<TrackPoint>,
    /// Time of the release [s]; `None`: it did not happen.
    pub(crate) release_s: Option<f64>,
    /// Whether time counts from when the rotors were freed.
    pub(crate) since_free: bool,
}

impl TrackPoint {
    /// The point of a body whose position is that on the figure.
    fn of(mission: &Mission, t_s: f64, body: &BodyState, thrust_n: &PerRotor) -> Self {
        let cost = StateCost::of(body, &mission.limits.safety);
        Self {
            t_s,
            north_m: body.p_ned.x,
            east_m: body.p_ned.y,
            down_m: body.p_ned.z,
            v_ned: body.v_ned,
            pitch_rad: pitch(body.q_ned_from_body),
            pitch_rate_rad_s: body.omega_body.y,
            roll_rad: bank(body.q_ned_from_body),
            roll_rate_rad_s: body.omega_body.x,
            z_ned: rotate_ned_from_body(body.q_ned_from_body, Vector3::z()),
            thrust_n: *thrust_n,
            bus: None,
            j_state: cost.max(),
            decided_by: cost.decided_by(),
        }
    }
}

impl Track {
    /// The track of a flight, from shortly before its release; of all of it when it was not released, with
    /// time from the start of the simulation.
    pub(crate) fn of_flight(mission: &Mission, samples: &[Sample]) -> Self {
        let free_s = samples.iter().rev().find_map(|s| s.t_powered_s.map(|t| s.t_s - t));
        let zero_s = free_s.unwrap_or(0.0);
        let end_s = samples.last().map_or(0.0, |s| s.t_s - zero_s);
        let released = samples.iter().find(|s| s.phase != Phase::Hanging);
        let origin = released.map_or(Vector3::zeros(), |s| s.state.body.p_ned);
        let release_s = released.map(|s| s.t_s - zero_s);
        let from_s = release_s.map_or(f64::NEG_INFINITY, |t| t - BEFORE_RELEASE * (end_s - t));
        let instant = |s: &Sample| {
            let body = BodyState { p_ned: s.state.body.p_ned - origin, ..s.state.body };
            let bus = s.bus.map(|bus| (bus.bus_v, bus.pack_a));
            let cost = StateCost::of_sample(s, &mission.limits.safety);
            let (j_state, decided_by) = (cost.max(), cost.decided_by());
            let point = TrackPoint::of(mission, s.t_s - zero_s, &body, &s.balance.thrust_n);
            TrackPoint { bus, j_state, decided_by, ..point }
        };
        let instants = samples.iter().map(instant).filter(|i| i.t_s >= from_s).collect();
        Self { instants, release_s, since_free: free_s.is_some() }
    }

    /// The track of a plan that begins at that place [m].
    pub(crate) fn of_plan(mission: &Mission, plan: &Trajectory, start_ned: Vector3<f64>) -> Self {
        let states = plan_motion(plan, start_ned);
        let point =
            |(t_s, body): &(f64, BodyState)| TrackPoint::of(mission, *t_s, body, &plan.thrust_n(*t_s));
        let instants = states.iter().map(point).collect();
        Self { instants, release_s: None, since_free: true }
    }

    /// This track up to a time, and with less before the release.
    pub(crate) fn until(mut self, t_s: f64) -> Self {
        if let Some(release_s) = self.release_s.filter(|_| t_s.is_finite()) {
            let from_s = release_s - BEFORE_RELEASE * (t_s - release_s);
            self.instants.retain(|i| i.t_s >= from_s);
        }
        self.instants.truncate(self.instants.partition_point(|i| i.t_s <= t_s + 1e-9));
        self
    }

    /// Whether the magnitude of a quantity ever reaches `least`.
    pub(crate) fn reaches(&self, least: f64, quantity: impl Fn(&TrackPoint) -> f64) -> bool {
        self.instants.iter().any(|i| quantity(i).abs() >= least)
    }

    /// Whether the roll is large enough for the verdict to report it.
    pub(crate) fn rolls(&self) -> bool {
        const SHOWN_RAD: f64 = 0.005 * RAD_PER_DEG;
        self.reaches(SHOWN_RAD, |i| i.roll_rad) || self.reaches(SHOWN_RAD, |i| i.roll_rate_rad_s)
    }

    /// A quantity over time.
    pub(crate) fn curve(&self, quantity: impl Fn(&TrackPoint) -> f64) -> Vec<(f64, f64)> {
        self.instants.iter().map(|i| (i.t_s, quantity(i))).collect()
    }

    /// First and last time [s].
    pub(crate) fn span_s(&self) -> Option<(f64, f64)> {
        Some((self.instants.first()?.t_s, self.instants.last()?.t_s))
    }

    /// The first instant at or after `t_s`.
    pub(crate) fn at(&self, t_s: f64) -> Option<&TrackPoint> {
        self.instants.get(self.instants.partition_point(|i| i.t_s < t_s - 1e-9))
    }

    /// The instant of the largest J_state from the release on, the first of equals.
    pub(crate) fn riskiest(&self) -> Option<&TrackPoint> {
        let from_s = self.release_s.unwrap_or(f64::NEG_INFINITY);
        let falling = self.instants.iter().filter(|i| i.t_s >= from_s - 1e-9);
        falling.reduce(|worst, i| if i.j_state > worst.j_state { i } else { worst })
    }
}
