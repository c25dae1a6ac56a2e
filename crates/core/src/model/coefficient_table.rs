//! A rotor's coefficients by how its disk moves: the loads of [`super::blade_element`] as a table that flies.
//!
//! The profile of the blades knows neither Reynolds nor Mach number, so thrust, in-plane force and torque
//! over `rho A ((Omega R)^2 + V^2)` depend on two numbers, each between bounds whatever the rotor does, down
//! to rest:
//!
//! ```text
//! speed share  s = V/(V + 0.1 Omega R)         0 hover, 1/2 about the induced velocity of hover, 1 at rest
//! flow share   p = W/(|W| + V_x)               -1 climb, 0 edgewise, 1 descent; W = -V_z, the flow from
//! below
//! ```
//!
//! An even grid of both, bilinear. Both are ratios of speeds: a look-up takes two divisions and one root.
//!
//! A rotor that turns backwards, its blades' trailing edges first, has a second, coarser grid with `|Omega|`
//! in the speed share, where it is wanted ([`CoefficientTable::with_backwards`]); both agree at rest.

use std::f64::consts::PI;

use super::blade_element::{Blades, DiskMotion, RotorCoefficients};
use super::rotor_load::RotorLoad;
use super::{ModelError, check_positive};
use crate::real::{Cell as _, Mask as _, Real};

/// Intervals of the grid along the speed share.
pub const SPEED_STEPS: usize = 100;
/// Intervals of the grid along the flow share.
pub const FLOW_STEPS: usize = 80;
/// Intervals of the grid along the speed share and the flow share of a rotor that turns backwards.
const BACKWARDS_STEPS: [usize; 2] = [50, 40];
/// Airspeed over tip speed at which the speed share is a half.
pub(crate) const HALF_AT: f64 = 0.1;

/// Air up to which [`CoefficientTable::steepest_torque_nm_s`] holds [kg/m^3]: a little above that of Titan's
/// ground.
const DENSEST_KG_M3: f64 = 6.0;

/// Coefficients of thrust, in-plane force and torque over speed share and flow share; bilinear.
#[derive(Clone, Debug, PartialEq)]
pub struct CoefficientTable {
    radius_m: f64,
    /// Thrust, in-plane force and torque, the flow share running fastest.
    cells: Vec<[f64; 3]>,
    /// Likewise of a rotor that turns backwards, on its own grid.
    backwards: Option<Vec<[f64; 3]>>,
}

impl CoefficientTable {
    /// The table with thrust, in-plane force and torque multiplied by factors.
    pub fn scaled(mut self, factors: [f64; 3]) -> Self {
        for cell in self.cells.iter_mut().chain(self.backwards.iter_mut().flatten()) {
            cell.iter_mut().zip(factors).for_each(|(coefficient, factor)| *coefficient *= factor);
        }
        self
    }

    /// A table of coefficients `[thrust, in-plane force, torque]` of a rotor of `radius_m` [m] at the even
    /// grid of [`SPEED_STEPS`] and [`FLOW_STEPS`] intervals, the flow share running fastest.
    ///
    /// # Errors
    /// [`ModelError::Table`] for another number of cells or one that is not finite,
    /// [`ModelError::OutOfRange`] for a radius that is not positive.
    pub fn new(radius_m: f64, cells: Vec<[f64; 3]>) -> Result<Self, ModelError> {
        check_positive("the rotor's radius", radius_m)?;
        let expected = (SPEED_STEPS + 1) * (FLOW_STEPS + 1);
        if cells.len() != expected {
            let found = cells.len();
            return Err(ModelError::Table(format!("expected {expected} cells, found {found}")));
        }
        if cells.iter().flatten().any(|x| !x.is_finite()) {
            return Err(ModelError::Table("the coefficients must be finite".into()));
        }
        Ok(Self { radius_m, cells, backwards: None })
    }

    /// The table with the coefficients of a rotor that turns backwards, at negative speeds: a solution of
    /// blade elements and momentum theory at each point of a grid of 51 shares of speed and 41 of the flow.
    /// Without them a rotor never turns backwards.
    #[must_use]
    pub fn with_backwards(self, blades: &Blades) -> Self {
        let [speeds, flows] = BACKWARDS_STEPS;
        let cells = (0..=speeds).flat_map(|i| {
            let speed = i as f64 / speeds as f64;
            (0..=flows).map(move |j| Self::motion([speed, j as f64 / (flows / 2) as f64 - 1.0]))
        });
        let solved = cells.map(|motion| {
            let found = blades.coefficients(&DiskMotion { tip: -motion.tip, ..motion });
            [found.thrust, found.in_plane, found.torque]
        });
        Self { backwards: Some(solved.collect()), ..self }
    }

    /// Speed share and flow share of each cell, in order.
    pub fn grid() -> impl Iterator<Item = [f64; 2]> {
        (0..=SPEED_STEPS).flat_map(|i| {
            let speed = i as f64 / SPEED_STEPS as f64;
            (0..=FLOW_STEPS).map(move |j| [speed, j as f64 / (FLOW_STEPS / 2) as f64 - 1.0])
        })
    }

    /// Coefficients of blades at a speed share and a flow share.
    pub fn cell(blades: &Blades, place: [f64; 2]) -> RotorCoefficients {
        blades.coefficients(&Self::motion(place))
    }

    /// Motion of the disk at a speed share and a flow share, turning forwards.
    fn motion([speed, flow]: [f64; 2]) -> DiskMotion {
        let (airspeed, tip) = (HALF_AT * speed, 1.0 - speed);
        let whole = (airspeed * airspeed + tip * tip).sqrt();
        let in_plane = 1.0 - flow.abs();
        let share = airspeed / (whole * (flow * flow + in_plane * in_plane).sqrt());
        DiskMotion { tip: tip / whole, climb: -flow * share, in_plane: in_plane * share }
    }

    /// Radius of the rotor [m].
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Coefficients of thrust, in-plane force and torque, the flow share running fastest.
    pub fn cells(&self) -> &[[f64; 3]] {
        &self.cells
    }

    /// Load of a rotor at a speed [rad/s] whose hub moves along its thrust at `climb_m_s` and in its plane at
    /// `in_plane_m_s`, zero or more [m/s]. A negative speed, backwards, needs a table
    /// [with those](Self::with_backwards); without them the rotor is at rest, as within a step that ends
    /// there.
    #[inline(always)]
    pub fn load<S: Real>(
        &self,
        omega_rad_s: S,
        climb_m_s: S,
        in_plane_m_s: S,
        density_kg_m3: S,
    ) -> RotorLoad<S> {
        let backwards = omega_rad_s.less(omega_rad_s.of(0.0));
        let turning = S::select(backwards, omega_rad_s.of(0.0), omega_rad_s);
        let hub = [climb_m_s, in_plane_m_s, density_kg_m3];
        let steps = [SPEED_STEPS, FLOW_STEPS];
        let load = self.bilinear(&self.cells, steps, turning * self.radius_m, hub);
        match &self.backwards {
            Some(cells) if backwards.any() => {
                let other = self.load_backwards(cells, -omega_rad_s * self.radius_m, hub);
                RotorLoad {
                    thrust_n: S::select(backwards, other.thrust_n, load.thrust_n),
                    torque_nm: S::select(backwards, other.torque_nm, load.torque_nm),
                    in_plane_n: S::select(backwards, other.in_plane_n, load.in_plane_n),
                }
            }
            _ => load,
        }
    }

    #[cold]
    #[inline(never)]
    fn load_backwards<S: Real>(&self, cells: &[[f64; 3]], tip_m_s: S, hub: [S; 3]) -> RotorLoad<S> {
        self.bilinear(cells, BACKWARDS_STEPS, tip_m_s, hub)
    }

    /// Load by cells on a grid of so many steps of speed share and flow share, at a tip speed of zero or
    /// more, of a hub with this climb, motion in the plane and density.
    #[inline(always)]
    fn bilinear<S: Real>(
        &self,
        cells: &[[f64; 3]],
        [speeds, flows]: [usize; 2],
        tip: S,
        [climb_m_s, in_plane_m_s, density_kg_m3]: [S; 3],
    ) -> RotorLoad<S> {
        let square = climb_m_s * climb_m_s + in_plane_m_s * in_plane_m_s;
        let airspeed = square.sqrt();
        let speed = share(airspeed, airspeed + tip * HALF_AT);
        let flow = share(-climb_m_s, climb_m_s.abs() + in_plane_m_s);
        let (i, a) = place(speed * speeds as f64, speeds);
        let (j, b) = place((flow + 1.0) * (flows / 2) as f64, flows);
        let at = i.row(flows + 1, j);
        let ([down, up], [down_faster, up_faster]) =
            (tip.gather_two(cells, at), tip.gather_two(cells, at.after(flows + 1)));
        let (slower, faster) = (mix(down, up, b), mix(down_faster, up_faster, b));
        let [thrust, in_plane, torque] = mix(slower, faster, a);
        let scale = (tip * tip + square) * (PI * self.radius_m * self.radius_m) * density_kg_m3;
        RotorLoad {
            thrust_n: scale * thrust,
            in_plane_n: scale * in_plane,
            torque_nm: scale * self.radius_m * torque,
        }
    }

    /// Steepest rise of the torque with the rotor's speed, either way [N m s], up to `omega_max_rad_s`, an
    /// airspeed of half the tip speed there, and 6 kg/m^3.
    pub fn steepest_torque_nm_s(&self, omega_max_rad_s: f64) -> f64 {
        const STEPS: u32 = 40;
        let step = omega_max_rad_s / f64::from(STEPS);
        let mut steepest = 0.0f64;
        for v in 0..=10 {
            let airspeed = 0.05 * f64::from(v) * omega_max_rad_s * self.radius_m;
            for flow in -4..=4 {
                let climb = -airspeed * f64::from(flow) / 4.0;
                let in_plane = (airspeed * airspeed - climb * climb).max(0.0).sqrt();
                let torque =
                    |k: u32| self.load(step * f64::from(k), climb, in_plane, DENSEST_KG_M3).torque_nm;
                for k in 0..STEPS {
                    steepest = steepest.max((torque(k + 1) - torque(k)).abs() / step);
                }
            }
        }
        steepest
    }
}

/// `a/b`; 0 of 0.
#[inline(always)]
fn share<S: Real>(a: S, b: S) -> S {
    let zero = a.of(0.0);
    S::select(zero.less(b), a / b, zero)
}

/// Left end and fraction of an interval of width 1.
#[inline(always)]
fn place<S: Real>(x: S, steps: usize) -> (S::Cell, S) {
    let left = x.cell(steps - 1);
    (left, x - x.of_cell(left))
}

/// A share of the way from some numbers to others.
#[inline(always)]
fn mix<S: Real>(x: [S; 3], y: [S; 3], share: S) -> [S; 3] {
    [x[0] + share * (y[0] - x[0]), x[1] + share * (y[1] - x[1]), x[2] + share * (y[2] - x[2])]
}
