//! What to fly so that a log tells what a vehicle is: standard manoeuvres, and what errors to expect of them.
//!
//! | file | holds |
//! |---|---|
//! | this one | the manoeuvres, step by step |
//! | `flight` | a manoeuvre flown by the program's own plant and controller, logged as by an autopilot |
//! | `recipe` | which of them, and how long, for wanted errors |

mod flight;
mod recipe;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;

pub use flight::{Flown, Rehearsal, SENSED_HZ, Seen};
pub use recipe::{Bounds, Recipe, Trial, USUAL, Wanted, missed};

use crate::math;

/// What is asked of an autopilot over a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Ask {
    /// To hold the place where the manoeuvre began, nose north.
    Hold,
    /// A velocity, north, east, down [m/s], nose north, and how fast it is changed to [m/s^2].
    Velocity([f64; 3], f64),
    /// Roll, pitch and yaw beside level and north [rad], and thrust as a share of the one that hovers.
    Attitude([f64; 3], f64),
}

/// Something that is asked, and for how long [s].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Length [s].
    pub length_s: f64,
    /// What is asked.
    pub ask: Ask,
}

/// How large a manoeuvre is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// Tilt of doublets and sweeps [rad].
    pub tilt_rad: f64,
    /// Turn of the nose [rad].
    pub yaw_rad: f64,
    /// Thrust beside that of a hover, as a share of it.
    pub thrust: f64,
    /// Speed of passes [m/s].
    pub speed_m_s: f64,
    /// Acceleration into passes and climbs [m/s^2].
    pub acceleration_m_s2: f64,
    /// Speed of climbs and descents [m/s].
    pub climb_m_s: f64,
}

impl Sizes {
    /// These sizes, all by a factor.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            tilt_rad: factor * self.tilt_rad,
            yaw_rad: factor * self.yaw_rad,
            thrust: factor * self.thrust,
            speed_m_s: factor * self.speed_m_s,
            acceleration_m_s2: factor * self.acceleration_m_s2,
            climb_m_s: factor * self.climb_m_s,
        }
    }
}

/// A standard manoeuvre.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Hovers, with climbs and descents: ordinary flight.
    Climbs,
    /// 3-2-1-1 doublets of roll, pitch, yaw and thrust, with a hover before each.
    Doublets,
    /// Sweeps of roll, pitch and yaw from slow to fast, with a hover before each. They begin at their full
    /// angle, so that the velocity has no mean.
    Sweeps,
    /// Passes north and south, east and west.
    Passes,
}

/// Axes of doublets and sweeps: roll, pitch, yaw, thrust; time of the shortest part of a doublet [s].
const UNITS_S: [f64; 4] = [0.18, 0.18, 0.4, 0.2];
/// Parts of a doublet, and sign of each.
const DOUBLET: [(f64, f64); 4] = [(3.0, 1.0), (2.0, -1.0), (1.0, 1.0), (1.0, -1.0)];
/// Hover before a doublet or a sweep [s]: PX4's control of the position is slower than ours, and what is left
/// of a velocity is flown through the whole doublet of yaw.
const BETWEEN_S: f64 = 3.0;
/// A sweep: length [s], frequencies [Hz], step in which it is asked for [s].
const SWEEP_S: f64 = 6.0;
const SWEEP_HZ: [f64; 2] = [0.5, 4.0];
const SWEEP_STEP_S: f64 = 0.04;
/// Length of a pass, of a climb, and of a hover beside them [s].
const PASS_S: f64 = 5.0;
const CLIMB_S: f64 = 2.0;
const HOVER_S: f64 = 4.0;

impl Kind {
    /// All manoeuvres, ordinary flight first.
    pub const ALL: [Self; 4] = [Self::Climbs, Self::Doublets, Self::Sweeps, Self::Passes];

    /// Key of the manoeuvre in results.
    pub fn key(self) -> &'static str {
        match self {
            Self::Climbs => "climbs",
            Self::Doublets => "doublets",
            Self::Sweeps => "sweeps",
            Self::Passes => "passes",
        }
    }

    /// The manoeuvre for a reader.
    pub fn words(self) -> &'static str {
        match self {
            Self::Climbs => "hover, climb and descend",
            Self::Doublets => "doublets of roll, pitch, yaw, thrust",
            Self::Sweeps => "sweeps of roll, pitch, yaw",
            Self::Passes => "fast passes both ways, along and across",
        }
    }

    /// One round of the manoeuvre; it ends where it began.
    pub fn round(self, sizes: &Sizes) -> Vec<Step> {
        let hold = Step { length_s: BETWEEN_S, ask: Ask::Hold };
        let axis = |axis: usize, x: f64| {
            let mut turn = [0.0; 3];
            let sizes = [sizes.tilt_rad, sizes.tilt_rad, sizes.yaw_rad, sizes.thrust];
            match turn.get_mut(axis) {
                Some(turn) => *turn = x * sizes[axis],
                None => return Ask::Attitude(turn, 1.0 + x * sizes[axis]),
            }
            Ask::Attitude(turn, 1.0)
        };
        let velocity = |v: [f64; 3]| Ask::Velocity(v, sizes.acceleration_m_s2);
        match self {
            Self::Climbs => {
                let climb = |v: f64| Step { length_s: CLIMB_S, ask: velocity([0.0, 0.0, v]) };
                let hover = |ask: Ask| Step { length_s: HOVER_S, ask };
                let [up, down] = [-sizes.climb_m_s, sizes.climb_m_s].map(climb);
                vec![hover(Ask::Hold), up, hover(velocity([0.0; 3])), down]
            }
            Self::Doublets => {
                let of = |of: usize| {
                    let part = move |(units, sign): (f64, f64)| Step {
                        length_s: units * UNITS_S[of],
                        ask: axis(of, sign),
                    };
                    [hold].into_iter().chain(DOUBLET.map(part))
                };
                (0..4).flat_map(of).collect()
            }
            Self::Sweeps => {
                let steps = (SWEEP_S / SWEEP_STEP_S) as usize;
                let of = |of: usize| {
                    let at = move |i: usize| {
                        let t_s = i as f64 * SWEEP_STEP_S;
                        let turns =
                            SWEEP_HZ[0] * t_s + 0.5 * (SWEEP_HZ[1] - SWEEP_HZ[0]) / SWEEP_S * t_s * t_s;
                        Step { length_s: SWEEP_STEP_S, ask: axis(of, math::cos(TAU * turns)) }
                    };
                    [hold].into_iter().chain((0..steps).map(at))
                };
                (0..3).flat_map(of).collect()
            }
            Self::Passes => {
                let s = sizes.speed_m_s;
                let pass =
                    |[north, east]: [f64; 2]| Step { length_s: PASS_S, ask: velocity([north, east, 0.0]) };
                let passes = [[s, 0.0], [-s, 0.0], [0.0, s], [0.0, -s]].map(pass);
                passes.into_iter().chain([Step { length_s: HOVER_S, ask: Ask::Hold }]).collect()
            }
        }
    }
}

/// Length of steps [s].
pub fn length_s(steps: &[Step]) -> f64 {
    steps.iter().map(|step| step.length_s).sum()
}
