//! What each flight may have of its own.

use super::NotPlanar;
use crate::control::Gains;
use crate::frames::pitch;
use crate::model::rigid_body::BodyState;

/// One flight of a batch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// Gains; those for yaw are not used.
    pub gains: Gains,
    /// State at t = 0, rotors at rest.
    pub release: Release,
    /// How vehicle and air differ from what the control law takes them for.
    pub variation: Variation,
}

/// State at t = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Release {
    /// Velocity north [m/s].
    pub v_north_m_s: f64,
    /// Velocity down [m/s].
    pub v_down_m_s: f64,
    /// Pitch [rad].
    pub pitch_rad: f64,
    /// Pitch rate [rad/s].
    pub pitch_rate_rad_s: f64,
}

impl Release {
    /// The planar part of a state.
    ///
    /// # Errors
    /// [`NotPlanar::Sideways`] when the state has a lateral part beyond rounding (1e-9).
    pub fn of(body: &BodyState) -> Result<Self, NotPlanar> {
        let q = &body.q_ned_from_body;
        let lateral = [q[1], q[3], body.v_ned.y, body.omega_body.x, body.omega_body.z];
        if lateral.iter().any(|x| !(x.abs() < 1e-9)) {
            return Err(NotPlanar::Sideways { what: "the release" });
        }
        Ok(Self {
            v_north_m_s: body.v_ned.x,
            v_down_m_s: body.v_ned.z,
            pitch_rad: pitch(*q),
            pitch_rate_rad_s: body.omega_body.y,
        })
    }
}

/// Factors on what is flown, wind, gust and delay; the control law keeps the nominal numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation {
    /// On the mass.
    pub mass: f64,
    /// On the moment of inertia about the pitch axis.
    pub inertia: f64,
    /// On C_D, C_L and C_M.
    pub aero: [f64; 3],
    /// On the density of the air: body and rotors.
    pub density: f64,
    /// Wind besides the site's, north and down [m/s].
    pub wind_m_s: [f64; 2],
    /// A gust on top of it.
    pub gust: Option<Gust>,
    /// Whether the control law sees the state of one control period ago (at t = 0 the state itself).
    pub delayed: bool,
}

impl Variation {
    /// None at all.
    pub const NONE: Self = Self {
        mass: 1.0,
        inertia: 1.0,
        aero: [1.0; 3],
        density: 1.0,
        wind_m_s: [0.0; 2],
        gust: None,
        delayed: false,
    };
}

impl Default for Variation {
    fn default() -> Self {
        Self::NONE
    }
}

/// A gust: air that moves for a while. It is held within a control period, at its value in the middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gust {
    /// Its course over time.
    pub shape: GustShape,
    /// Its beginning, from t = 0 [s].
    pub start_s: f64,
    /// How long it lasts [s]; may be infinite for a step.
    pub length_s: f64,
    /// Its largest velocity, north and down [m/s].
    pub peak_m_s: [f64; 2],
}

/// SetpointTable of a gust over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GustShape {
    /// At once at its peak, at once gone.
    Step,
    /// `(1 - cos(2 pi t/length))/2`, the discrete gust of airworthiness codes.
    OneMinusCosine,
}

impl Gust {
    /// Velocity of the gust at `t_s`, north and down [m/s].
    pub fn at(&self, t_s: f64) -> [f64; 2] {
        let t = t_s - self.start_s;
        if !(t >= 0.0 && t < self.length_s) {
            return [0.0; 2];
        }
        let share = match self.shape {
            GustShape::Step => 1.0,
            GustShape::OneMinusCosine => 0.5 * (1.0 - (std::f64::consts::TAU * t / self.length_s).cos()),
        };
        self.peak_m_s.map(|v| share * v)
    }
}
