//! One rotor: thrust and aerodynamic torque from its speed and the flow through it.
//!
//! Three models. The **blade element** rotor carries the coefficients of a rotor whose blades are known, by
//! how its disk moves ([`super::coefficient_table`]), with the force in the rotor's plane. The **table**
//! rotor carries computed thrust and torque over (speed, airspeed, angle of the flow), so windmill,
//! vortex-ring and turbulent-wake states are in the data. The **quadratic** rotor is `T = k omega^2`, `Q = c
//! T`, which knows no inflow along its axis; across it the force in its plane is `h omega V` against its
//! motion, as far as it has an `h`. Assumptions: quasi-static (III.B.1 of the paper); no force in the plane
//! of a table's rotor.

use nalgebra::Vector3;

use super::ModelError;
use super::axis::Axis;
use super::coefficient_table::CoefficientTable;
pub use super::rotor_load::RotorLoad;
use crate::math;
use crate::real::{Cell as _, Real};
use crate::vector::V3;

/// Flow of the air at a rotor hub.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflow<S = f64> {
    /// Airspeed of the hub [m/s].
    pub airspeed_m_s: S,
    /// Angle of the flow against the rotor disk [rad]: `atan2(W_i, hypot(U_i, V_i))`; +pi/2 is flow from
    /// below, a vertical descent. Differs from the paper's (12), `atan2(W_i, U_i)`, for sideways flow only:
    /// the disk is round.
    pub angle_rad: S,
}

/// Motion of a rotor's hub through the air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HubMotion<S = f64> {
    /// Along the thrust [m/s].
    pub climb_m_s: S,
    /// In the disk's plane, body axes [m/s].
    pub in_disk_body_m_s: V3<S>,
    /// Length of what is in the disk's plane [m/s].
    pub in_plane_m_s: S,
}

impl<S: Real> HubMotion<S> {
    /// Motion of a hub at `v_body` [m/s], thrust along the unit vector `axis_body`.
    #[inline(always)]
    pub fn of(v_body: V3<S>, axis_body: &Vector3<f64>) -> Self {
        let climb_m_s = v_body.along(axis_body);
        let in_disk_body_m_s = v_body - V3::constant(climb_m_s, axis_body) * climb_m_s;
        Self { climb_m_s, in_disk_body_m_s, in_plane_m_s: in_disk_body_m_s.norm() }
    }

    /// The flow at the hub, (10)-(12).
    #[inline(always)]
    pub fn inflow(&self) -> Inflow<S> {
        let (climb, in_plane) = (self.climb_m_s, self.in_plane_m_s);
        Inflow {
            airspeed_m_s: (climb * climb + in_plane * in_plane).sqrt(),
            angle_rad: (-climb).atan2(in_plane),
        }
    }
}

/// A rotor model: thrust and torque by speed, flow and density.
#[derive(Clone, Debug, PartialEq)]
pub enum Rotor {
    /// Coefficients of known blades by how the disk moves.
    BladeElement(CoefficientTable),
    /// Thrust and torque by table.
    Table(RotorTable),
    /// `T = k omega^2`, `Q = c T`, both scaled with density over `density_kg_m3`.
    Quadratic {
        /// Thrust coefficient k [N/(rad/s)^2] at `density_kg_m3`.
        thrust_n_per_rad2_s2: f64,
        /// Torque per thrust c [m].
        torque_per_thrust_m: f64,
        /// Force in the rotor's plane over rotor speed and speed across its axis, h [N/((rad/s)(m/s))] at
        /// `density_kg_m3`; 0: none.
        drag_n_s2_per_rad_m: f64,
        /// Density that k and h hold for [kg/m^3].
        density_kg_m3: f64,
    },
}

impl Rotor {
    /// Thrust and torque at the rotor speed [rad/s] and inflow; the density [kg/m^3] scales both.
    #[inline(always)]
    pub fn load(&self, omega_rad_s: f64, inflow: Inflow, density_kg_m3: f64) -> RotorLoad {
        match self {
            Self::BladeElement(table) => {
                let (sin, cos) = math::sin_cos(inflow.angle_rad);
                let v = inflow.airspeed_m_s;
                table.load(omega_rad_s, -v * sin, (v * cos).max(0.0), density_kg_m3)
            }
            Self::Table(table) => table.load(omega_rad_s, inflow, density_kg_m3),
            Self::Quadratic { .. } => {
                let across = Vector3::x() * (inflow.airspeed_m_s * math::cos(inflow.angle_rad)).max(0.0);
                let hub = HubMotion::of(V3::constant(0.0, &across), &Vector3::z());
                self.load_at_hub(omega_rad_s, &hub, density_kg_m3)
            }
        }
    }

    /// Load of a rotor whose hub moves so through the air.
    #[inline(always)]
    pub fn load_at_hub<S: Real>(&self, omega_rad_s: S, hub: &HubMotion<S>, density_kg_m3: S) -> RotorLoad<S> {
        match self {
            Self::BladeElement(table) => {
                table.load(omega_rad_s, hub.climb_m_s, hub.in_plane_m_s, density_kg_m3)
            }
            Self::Table(table) => table.load(omega_rad_s, hub.inflow(), density_kg_m3),
            Self::Quadratic {
                thrust_n_per_rad2_s2,
                torque_per_thrust_m,
                drag_n_s2_per_rad_m,
                density_kg_m3: reference,
            } => {
                let share = density_kg_m3 / omega_rad_s.of(*reference);
                let thrust_n = share * *thrust_n_per_rad2_s2 * omega_rad_s * omega_rad_s;
                let torque_nm = thrust_n * *torque_per_thrust_m;
                let in_plane_n = share * *drag_n_s2_per_rad_m * omega_rad_s.abs() * hub.in_plane_m_s;
                RotorLoad { thrust_n, torque_nm, in_plane_n }
            }
        }
    }

    /// The rotor with its thrust, and the force in its plane, and its torque multiplied by factors.
    pub fn scaled(self, [thrust, torque]: [f64; 2]) -> Self {
        match self {
            Self::BladeElement(table) => Self::BladeElement(table.scaled([thrust, thrust, torque])),
            Self::Table(mut table) => {
                table.cells.iter_mut().for_each(|[t, q]| (*t, *q) = (thrust * *t, torque * *q));
                Self::Table(table)
            }
            Self::Quadratic {
                thrust_n_per_rad2_s2,
                torque_per_thrust_m,
                drag_n_s2_per_rad_m,
                density_kg_m3,
            } => Self::Quadratic {
                thrust_n_per_rad2_s2: thrust * thrust_n_per_rad2_s2,
                torque_per_thrust_m: torque / thrust * torque_per_thrust_m,
                drag_n_s2_per_rad_m: thrust * drag_n_s2_per_rad_m,
                density_kg_m3,
            },
        }
    }

    /// Density that the rotor's numbers hold for [kg/m^3]; 1 for coefficients, which hold for any.
    pub fn reference_density_kg_m3(&self) -> f64 {
        match self {
            Self::BladeElement(_) => 1.0,
            Self::Table(table) => table.density_kg_m3,
            Self::Quadratic { density_kg_m3, .. } => *density_kg_m3,
        }
    }

    /// Whether the flow past the hub counts.
    pub fn knows_inflow(&self) -> bool {
        match self {
            Self::BladeElement(_) | Self::Table(_) => true,
            Self::Quadratic { drag_n_s2_per_rad_m, .. } => *drag_n_s2_per_rad_m > 0.0,
        }
    }

    /// Steepest rise of the torque with the speed, either way, up to `omega_max_rad_s` and at the rotor's own
    /// density [N m s]; of coefficients at most
    /// [that in the densest air](CoefficientTable::steepest_torque_nm_s).
    pub fn steepest_torque_nm_s(&self, omega_max_rad_s: f64) -> f64 {
        match self {
            Self::BladeElement(table) => table.steepest_torque_nm_s(omega_max_rad_s),
            Self::Table(table) => table.steepest_torque_nm_s(),
            Self::Quadratic { thrust_n_per_rad2_s2: k, torque_per_thrust_m: c, .. } => {
                2.0 * c * k * omega_max_rad_s
            }
        }
    }

    /// Thrust and torque in still air at the speed [rad/s] and density [kg/m^3].
    pub fn static_load(&self, omega_rad_s: f64, density_kg_m3: f64) -> RotorLoad {
        self.load(omega_rad_s, Inflow { airspeed_m_s: 0.0, angle_rad: 0.0 }, density_kg_m3)
    }
}

/// Thrust and torque over a grid of speed, airspeed and flow angle; trilinear, clamped at the edges.
#[derive(Clone, Debug, PartialEq)]
pub struct RotorTable {
    omega: Axis,
    airspeed: Axis,
    angle: Axis,
    /// `[thrust, torque]` with the angle running fastest, then the airspeed.
    cells: Vec<[f64; 2]>,
    density_kg_m3: f64,
}

fn axis(name: &str, knots: &[f64]) -> Result<Axis, ModelError> {
    if knots.len() < 2 || knots.iter().any(|k| !k.is_finite()) {
        return Err(ModelError::Table(format!("{name}: at least 2 finite entries expected")));
    }
    super::check_increasing(knots).map_err(|e| ModelError::Table(format!("{name}: {e}")))?;
    Ok(Axis::new(knots))
}

/// Left knot and fraction of the interval; clamped.
#[inline(always)]
fn locate<S: Real>(axis: &Axis, x: S) -> (S::Cell, S) {
    let i = axis.interval(x);
    let [knot, per_width] = x.gather(&axis.intervals, i);
    let fraction = (x - knot) * per_width;
    (i, fraction.at_least(x.of(0.0)).at_most(x.of(1.0)))
}

/// A share of the way from one pair of numbers to another.
#[inline(always)]
fn mix<S: Real>(x: [S; 2], y: [S; 2], share: S) -> [S; 2] {
    [x[0] + share * (y[0] - x[0]), x[1] + share * (y[1] - x[1])]
}

impl RotorTable {
    /// A table over `omega_rad_s`, `airspeed_m_s`, `angle_rad`, valid at `density_kg_m3` and scaled with
    /// density elsewhere. `thrust_torque` holds `[N, N m]` with the angle running fastest, then the airspeed.
    ///
    /// # Errors
    /// [`ModelError::Table`] when an axis does not increase, or the cells are not finite or not as many as
    /// the grid has.
    pub fn new(
        omega_rad_s: &[f64],
        airspeed_m_s: &[f64],
        angle_rad: &[f64],
        thrust_torque: Vec<[f64; 2]>,
        density_kg_m3: f64,
    ) -> Result<Self, ModelError> {
        let (omega, airspeed, angle) = (
            axis("rotor speed", omega_rad_s)?,
            axis("airspeed", airspeed_m_s)?,
            axis("flow angle", angle_rad)?,
        );
        super::check_positive("the table's density", density_kg_m3)?;
        let expected = omega_rad_s.len() * airspeed_m_s.len() * angle_rad.len();
        if thrust_torque.len() != expected {
            return Err(ModelError::Table(format!(
                "a grid of {} speeds x {} airspeeds x {} angles has {expected} cells, found {}",
                omega_rad_s.len(),
                airspeed_m_s.len(),
                angle_rad.len(),
                thrust_torque.len()
            )));
        }
        if thrust_torque.iter().flatten().any(|x| !x.is_finite()) {
            return Err(ModelError::Table("thrust and torque must be finite".into()));
        }
        Ok(Self { omega, airspeed, angle, cells: thrust_torque, density_kg_m3 })
    }

    /// The axes of rotor speed [rad/s], airspeed [m/s] and flow angle [rad].
    pub(crate) fn axes(&self) -> [&Axis; 3] {
        [&self.omega, &self.airspeed, &self.angle]
    }

    /// Knots of rotor speed [rad/s], airspeed [m/s] and flow angle [rad].
    pub fn knots(&self) -> [&[f64]; 3] {
        self.axes().map(|axis| axis.knots.as_slice())
    }

    /// Thrust and torque `[N, N m]` at the knots, the angle running fastest, then the airspeed.
    pub fn cells(&self) -> &[[f64; 2]] {
        &self.cells
    }

    fn steepest_torque_nm_s(&self) -> f64 {
        let per_speed = self.airspeed.knots.len() * self.angle.knots.len();
        let mut steepest = 0.0f64;
        for (k, step) in self.omega.knots.windows(2).map(|w| w[1] - w[0]).enumerate() {
            let cells = &self.cells[k * per_speed..];
            for (low, high) in cells[..per_speed].iter().zip(&cells[per_speed..]) {
                steepest = steepest.max((high[1] - low[1]).abs() / step);
            }
        }
        steepest
    }

    /// Density for which the table was made [kg/m^3].
    pub fn density_kg_m3(&self) -> f64 {
        self.density_kg_m3
    }

    /// Thrust and torque; the density scales both.
    #[inline(always)]
    pub fn load<S: Real>(&self, omega_rad_s: S, inflow: Inflow<S>, density_kg_m3: S) -> RotorLoad<S> {
        let (i, a) = locate(&self.omega, omega_rad_s);
        let (j, b) = locate(&self.airspeed, inflow.airspeed_m_s);
        let (k, c) = locate(&self.angle, inflow.angle_rad);
        let (nj, nk) = (self.airspeed.knots.len(), self.angle.knots.len());
        let first = i.row(nj, j).row(nk, k);
        let mut at_speed = [[omega_rad_s; 2]; 2];
        for (faster, load) in at_speed.iter_mut().enumerate() {
            let mut at_airspeed = [[omega_rad_s; 2]; 2];
            for (more, load) in at_airspeed.iter_mut().enumerate() {
                let at = first.after((faster * nj + more) * nk);
                let [less, more] = a.gather_two(&self.cells, at);
                *load = mix(less, more, c);
            }
            *load = mix(at_airspeed[0], at_airspeed[1], b);
        }
        let [thrust, torque] = mix(at_speed[0], at_speed[1], a);
        let scale = density_kg_m3 / a.of(self.density_kg_m3);
        RotorLoad { thrust_n: scale * thrust, torque_nm: scale * torque, in_plane_n: a.of(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> RotorTable {
        let axis = [0.0, 1.0, 3.0];
        let mut cells = Vec::new();
        for w in axis {
            for v in axis {
                for a in axis {
                    cells.push([w + 2.0 * v + 3.0 * a, w * v]);
                }
            }
        }
        RotorTable::new(&axis, &axis, &axis, cells, 2.0).unwrap()
    }

    #[test]
    fn closed_form_trilinear_reproduces_a_multilinear_function_and_scales_with_density() {
        let load = table().load(0.5, Inflow { airspeed_m_s: 2.0, angle_rad: 2.5 }, 4.0);
        assert!((load.thrust_n - 2.0 * (0.5 + 4.0 + 7.5)).abs() < 1e-14);
        assert!((load.torque_nm - 2.0).abs() < 1e-14);
    }

    /// The torque of the table is w v, so its steepest rise with w is the largest v. Of 2 w^2 per unit of c:
    /// 4 w.
    #[test]
    fn closed_form_steepest_torque() {
        assert_eq!(Rotor::Table(table()).steepest_torque_nm_s(1.0), 3.0);
        assert_eq!(quadratic().steepest_torque_nm_s(10.0), 20.0);
    }

    fn quadratic() -> Rotor {
        Rotor::Quadratic {
            thrust_n_per_rad2_s2: 2.0,
            torque_per_thrust_m: 0.5,
            drag_n_s2_per_rad_m: 0.25,
            density_kg_m3: 1.0,
        }
    }

    /// Thrust and torque of a rotor that is off by factors, whatever its model.
    #[test]
    fn closed_form_factors_on_thrust_and_torque() {
        let flow = Inflow { airspeed_m_s: 2.0, angle_rad: 0.3 };
        for rotor in [quadratic(), Rotor::Table(table())] {
            let (known, off) = (rotor.load(1.5, flow, 2.0), rotor.scaled([1.25, 0.5]).load(1.5, flow, 2.0));
            assert!((off.thrust_n - 1.25 * known.thrust_n).abs() < 1e-12 * known.thrust_n);
            assert!((off.torque_nm - 0.5 * known.torque_nm).abs() < 1e-12 * known.torque_nm);
            assert!((off.in_plane_n - 1.25 * known.in_plane_n).abs() <= 1e-12 * known.in_plane_n);
        }
    }

    /// Edgewise h omega V, twice of it in twice the density, whichever way the rotor turns; nothing along the
    /// axis.
    #[test]
    fn closed_form_in_plane_force_of_a_quadratic_rotor() {
        let edgewise = Inflow { airspeed_m_s: 3.0, angle_rad: 0.0 };
        for omega in [8.0, -8.0] {
            assert_eq!(quadratic().load(omega, edgewise, 2.0).in_plane_n, 2.0 * 0.25 * 8.0 * 3.0);
        }
        let slanted = Inflow { angle_rad: std::f64::consts::FRAC_PI_3, ..edgewise };
        assert!((quadratic().load(8.0, slanted, 1.0).in_plane_n - 3.0).abs() < 1e-12);
        let along = Inflow { angle_rad: std::f64::consts::FRAC_PI_2, ..edgewise };
        assert!(quadratic().load(8.0, along, 1.0).in_plane_n < 1e-12);
        assert_eq!(quadratic().load(8.0, along, 1.0).thrust_n, 128.0);
    }

    #[test]
    fn closed_form_outside_the_grid_the_edge_holds() {
        let t = table();
        let inside = t.load(3.0, Inflow { airspeed_m_s: 3.0, angle_rad: 0.0 }, 2.0);
        assert_eq!(t.load(9.0, Inflow { airspeed_m_s: 8.0, angle_rad: -4.0 }, 2.0), inside);
    }

    #[test]
    fn bad_grids_are_refused() {
        assert!(RotorTable::new(&[0.0, 0.0], &[0.0, 1.0], &[0.0, 1.0], vec![[0.0; 2]; 8], 1.0).is_err());
        assert!(RotorTable::new(&[0.0, 1.0], &[0.0, 1.0], &[0.0, 1.0], vec![[0.0; 2]; 7], 1.0).is_err());
        assert!(RotorTable::new(&[0.0, 1.0], &[0.0, 1.0], &[0.0, 1.0], vec![[f64::NAN; 2]; 8], 1.0).is_err());
    }
}
