//! A drop in time: its clock, its phases, and when one ends and the next begins.

use nalgebra::Vector3;

use crate::model::rigid_body::BodyState;

/// Phase of a drop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Under the canopy.
    Hanging,
    /// Released, rotors locked.
    Falling,
    /// Rotors free.
    Powered,
}

/// Motion of the vehicle from the release to t = 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// The drop: the body falls for t_d under gravity and the air, and turns as it was turning.
    Release,
    /// The paper's study: at t = 0 the vehicle has the attitude and rates of the release and `v_d` is larger
    /// by `g t_d`, (44). In between it falls in a vacuum without turning (the rate is carried along, not
    /// propagated).
    T0,
}

/// A phase boundary closer than this to the end of a step [s] is taken to be there.
pub(super) const BOUNDARY_TOLERANCE_S: f64 = 1e-9;

/// Where a drop is in time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) clock: Clock,
    pub(super) phase: Phase,
    pub(super) start: Start,
    /// When the release is meant to be [s], and when it is known to come [s].
    pub(super) nominal_release_s: f64,
    pub(super) release_at_s: Option<f64>,
    /// When a canopy that is a body of its own takes over from what held the vehicle [s].
    pub(super) canopy_at_s: Option<f64>,
    /// Time from the release until the rotors are free [s].
    pub(super) delay_s: f64,
    pub(super) released: Option<Released>,
}

/// The release.
#[derive(Clone, Copy, Debug)]
pub(super) struct Released {
    /// When it was [s].
    pub(super) time_s: f64,
    /// The vehicle's state right after it.
    pub(super) state: BodyState,
}

/// Simulated time as a compensated sum, so that 10 000 steps of 4 ms end at 40 s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Clock {
    pub(super) time_s: f64,
    lost_s: f64,
}

impl Clock {
    pub(super) fn advance(&mut self, dt_s: f64) {
        let term = dt_s - self.lost_s;
        let sum = self.time_s + term;
        self.lost_s = (sum - self.time_s) - term;
        self.time_s = sum;
    }
}

impl Course {
    /// A drop before its release, at its beginning.
    pub(super) fn hanging(nominal_release_s: f64, delay_s: f64, start: Start) -> Self {
        let (clock, phase) = (Clock::default(), Phase::Hanging);
        Self {
            clock,
            phase,
            start,
            nominal_release_s,
            release_at_s: None,
            canopy_at_s: None,
            delay_s,
            released: None,
        }
    }

    /// Powered flight from a state at its beginning.
    pub(super) fn powered(state: BodyState) -> Self {
        let released = Some(Released { time_s: 0.0, state });
        Self { phase: Phase::Powered, released, ..Self::hanging(0.0, 0.0, Start::T0) }
    }

    /// Time from which the rotors are free [s], once the release has happened.
    pub(super) fn powered_from_s(&self) -> Option<f64> {
        self.released.map(|released| released.time_s + self.delay_s)
    }

    /// When t = 0 is meant to be [s].
    pub(super) fn nominal_t0_s(&self) -> f64 {
        match self.released {
            Some(_) => 0.0,
            None => self.nominal_release_s + self.delay_s,
        }
    }

    /// Time at which the present phase ends, or a canopy takes over [s], if that is known.
    pub(super) fn boundary_s(&self) -> Option<f64> {
        match self.phase {
            Phase::Hanging => match (self.canopy_at_s, self.release_at_s) {
                (Some(canopy_s), Some(release_s)) => Some(canopy_s.min(release_s)),
                (canopy_s, release_s) => canopy_s.or(release_s),
            },
            Phase::Falling => self.powered_from_s(),
            Phase::Powered => None,
        }
    }

    /// How much of a step of `dt_s` [s] is in the present phase [s].
    pub(super) fn within_phase_s(&self, dt_s: f64) -> f64 {
        match self.boundary_s() {
            Some(b) if b - self.clock.time_s < dt_s - BOUNDARY_TOLERANCE_S => {
                (b - self.clock.time_s).max(0.0)
            }
            _ => dt_s,
        }
    }

    /// Whether the present phase is over.
    pub(super) fn is_at_boundary(&self) -> bool {
        self.boundary_s().is_some_and(|b| self.clock.time_s >= b - BOUNDARY_TOLERANCE_S)
    }

    /// Whether a canopy that is a body of its own is to take over now.
    pub(super) fn is_canopy_due(&self) -> bool {
        let due = |at_s: f64| self.clock.time_s >= at_s - BOUNDARY_TOLERANCE_S;
        self.phase == Phase::Hanging && self.canopy_at_s.is_some_and(due)
    }

    /// Whether the vehicle falls under gravity and the air.
    pub(super) fn falls_in_air(&self) -> bool {
        self.phase == Phase::Falling && self.start == Start::Release
    }

    /// Time since the nominal release [s].
    pub(super) fn since_nominal_s(&self) -> f64 {
        self.clock.time_s - self.nominal_release_s
    }

    /// The fall of [`Start::T0`] under this gravity, NED [m/s^2], since a release.
    pub(super) fn vacuum_fall(&self, released: &Released, g: Vector3<f64>) -> BodyState {
        let (t, from) = (self.clock.time_s - released.time_s, released.state);
        BodyState {
            p_ned: from.p_ned + from.v_ned * t + g * (0.5 * t * t),
            v_ned: from.v_ned + g * t,
            ..from
        }
    }
}
