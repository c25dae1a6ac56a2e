//! The dynamics of the planner, `x_dot = f(x, u)` of (25), with exact first and second derivatives.
//!
//! State `x = [q0 q1 q2 q3, vn ve vd, P Q R]` (the position is not penalised and left out, as in the paper),
//! input `u` = thrust of each rotor [N], actuators left out. The derivatives are written by hand: the
//! attitude enters through products of at most degree two, so only the map from air velocity to body loads
//! has derivatives worth the name, and [`BodyAero::jet`] has those. [`Vehicle::thrust_derivative`], the code
//! that flies, is what they are checked against.

use std::ops::AddAssign;

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::block::{add_mul, add_tr_mul, mul, tr_mul};
use crate::frames::dcm_body_from_ned;
use crate::model::{BodyAero, Environment, Vehicle};

/// Number of states of the rigid body in the planner.
pub const BODY_STATES: usize = 10;

/// Value and Jacobians of the dynamics at a point.
#[derive(Clone, Copy, Debug)]
pub struct Linearisation<const NX: usize, const NU: usize> {
    /// Value `f(x, u)`.
    pub f: SVector<f64, NX>,
    /// Jacobian `df/dx`.
    pub a: SMatrix<f64, NX, NX>,
    /// Jacobian `df/du`.
    pub b: SMatrix<f64, NX, NU>,
}

/// Second derivatives of `weights . f(x, u)` at a point.
#[derive(Clone, Copy, Debug)]
pub struct Curvature<const NX: usize, const NU: usize> {
    /// Second derivatives by the states, symmetric.
    pub xx: SMatrix<f64, NX, NX>,
    /// Second derivatives by inputs (rows) and states (columns).
    pub ux: SMatrix<f64, NU, NX>,
    /// Second derivatives by the inputs, symmetric.
    pub uu: SMatrix<f64, NU, NU>,
}

impl<const NX: usize, const NU: usize> Curvature<NX, NU> {
    /// The zero curvature, that of a linear function.
    pub fn zero() -> Self {
        Self { xx: SMatrix::zeros(), ux: SMatrix::zeros(), uu: SMatrix::zeros() }
    }
}

impl<const NX: usize, const NU: usize> AddAssign for Curvature<NX, NU> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        self.xx += other.xx;
        self.ux += other.ux;
        self.uu += other.uu;
    }
}

/// A system that the planner can steer: `x_dot = f(x, u)`, twice continuously differentiable, not depending
/// on time. Another vehicle model (with actuator states, say) is another implementation.
pub trait Dynamics<const NX: usize, const NU: usize> {
    /// Value `f(x, u)`.
    fn value(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> SVector<f64, NX>;
    /// Value and Jacobians of `f` at `(x, u)`.
    fn linearise(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> Linearisation<NX, NU>;
    /// Second derivatives of `weights . f` at `(x, u)`.
    fn curvature(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        weights: &SVector<f64, NX>,
    ) -> Curvature<NX, NU>;
}

impl<D: Dynamics<NX, NU>, const NX: usize, const NU: usize> Dynamics<NX, NU> for &D {
    #[inline(always)]
    fn value(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> SVector<f64, NX> {
        (**self).value(x, u)
    }

    #[inline(always)]
    fn linearise(&self, x: &SVector<f64, NX>, u: &SVector<f64, NU>) -> Linearisation<NX, NU> {
        (**self).linearise(x, u)
    }

    #[inline(always)]
    fn curvature(
        &self,
        x: &SVector<f64, NX>,
        u: &SVector<f64, NU>,
        weights: &SVector<f64, NX>,
    ) -> Curvature<NX, NU> {
        (**self).curvature(x, u, weights)
    }
}

/// A vehicle with `NU` rotors as the planner sees it.
#[derive(Clone, Debug)]
pub struct VehicleDynamics<const NU: usize> {
    aero: BodyAero,
    density: f64,
    gravity: f64,
    wind_ned: Vector3<f64>,
    mass: f64,
    inertia: Matrix3<f64>,
    inertia_inverse: Matrix3<f64>,
    /// Body force per newton of thrust.
    force_map: SMatrix<f64, 3, NU>,
    /// Body moment per newton of thrust [N m/N].
    moment_map: SMatrix<f64, 3, NU>,
    /// `inertia_inverse * moment_map`.
    angular_map: SMatrix<f64, 3, NU>,
}

impl<const NU: usize> VehicleDynamics<NU> {
    /// The planner's dynamics of a vehicle at its site; `None` unless it has `NU` rotors.
    pub fn new(vehicle: &Vehicle, environment: &Environment) -> Option<Self> {
        if vehicle.rotors.len() == NU { Self::padded(vehicle, environment) } else { None }
    }

    /// The planner's dynamics of a vehicle with at most `NU` rotors: inputs beyond these do nothing. `None`
    /// where it has more.
    pub fn padded(vehicle: &Vehicle, environment: &Environment) -> Option<Self> {
        let rotors = vehicle.rotors.len();
        if rotors > NU {
            return None;
        }
        let there = |x: f64, j: usize| if j < rotors { x } else { 0.0 };
        let force_map =
            SMatrix::from_fn(|i, j| vehicle.rotors.get(j).map_or(0.0, |rotor| rotor.axis_body[i]));
        let moments: [Vector3<f64>; NU] =
            std::array::from_fn(|j| vehicle.moment_per_thrust(j.min(rotors - 1), environment.density_kg_m3));
        let moment_map = SMatrix::from_fn(|i, j| there(moments[j][i], j));
        Some(Self {
            aero: vehicle.aero.clone(),
            density: environment.density_kg_m3,
            gravity: environment.gravity_m_s2,
            wind_ned: environment.wind_ned_m_s,
            mass: vehicle.mass.mass_kg,
            inertia: vehicle.mass.inertia_kg_m2,
            inertia_inverse: vehicle.mass.inertia_inverse,
            force_map,
            moment_map,
            angular_map: vehicle.mass.inertia_inverse * moment_map,
        })
    }
}

/// `[a]x`, the matrix of `a x .`.
#[inline(always)]
fn skew(a: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// Derivative of `C(q) v` (`sign` = -1) or of `C(q)^T v` (`sign` = +1) with respect to q:
/// `C(q)^T v = (q0^2 - e.e) v + 2 e (e.v) + 2 q0 e x v`, and with -q0 for the inverse.
#[inline(always)]
pub(super) fn rotation_gradient(q: &[f64; 4], v: &Vector3<f64>, sign: f64) -> SMatrix<f64, 3, 4> {
    let e = Vector3::new(q[1], q[2], q[3]);
    let by_scalar = (v * q[0] + e.cross(v) * sign) * 2.0;
    let by_vector = (e * v.transpose() - v * e.transpose() - skew(v) * (sign * q[0])) * 2.0;
    let along = 2.0 * e.dot(v);
    let mut d = SMatrix::<f64, 3, 4>::zeros();
    d.set_column(0, &by_scalar);
    for j in 0..3 {
        for i in 0..3 {
            d[(i, j + 1)] = by_vector[(i, j)];
        }
        d[(j, j + 1)] += along;
    }
    d
}

/// Second derivative of `w . C(q) v` with respect to q, a constant.
#[inline(always)]
pub(super) fn rotation_hessian(w: &Vector3<f64>, v: &Vector3<f64>) -> SMatrix<f64, 4, 4> {
    let wv = w.dot(v);
    let corner = w.cross(v);
    let outer = w * v.transpose();
    let mut h = SMatrix::<f64, 4, 4>::zeros();
    h[(0, 0)] = 2.0 * wv;
    for i in 0..3 {
        h[(0, i + 1)] = 2.0 * corner[i];
        h[(i + 1, 0)] = 2.0 * corner[i];
        for j in 0..3 {
            h[(i + 1, j + 1)] = 2.0 * (outer[(i, j)] + outer[(j, i)]);
        }
        h[(i + 1, i + 1)] -= 2.0 * wv;
    }
    h
}

#[inline(always)]
fn split(x: &SVector<f64, BODY_STATES>) -> ([f64; 4], Vector3<f64>, Vector3<f64>) {
    ([x[0], x[1], x[2], x[3]], Vector3::new(x[4], x[5], x[6]), Vector3::new(x[7], x[8], x[9]))
}

/// `qdot = Xi(q) omega`, (2), the factor one half taken in.
#[inline(always)]
fn quaternion_rate_map(q: &[f64; 4]) -> SMatrix<f64, 4, 3> {
    let [a, b, c, d] = q.map(|x| 0.5 * x);
    SMatrix::<f64, 4, 3>::new(-b, -c, -d, a, -d, c, d, a, -b, -c, b, a)
}

impl<const NU: usize> Dynamics<BODY_STATES, NU> for VehicleDynamics<NU> {
    #[inline(always)]
    fn value(&self, x: &SVector<f64, BODY_STATES>, u: &SVector<f64, NU>) -> SVector<f64, BODY_STATES> {
        let (q, v, omega) = split(x);
        let c = dcm_body_from_ned(q);
        let load = self.aero.load((c * (v - self.wind_ned)).into(), self.density);
        let force = Vector3::from(load.force_body) + mul(&self.force_map, u);
        let moment =
            Vector3::from(load.moment_body) + mul(&self.moment_map, u) - omega.cross(&(self.inertia * omega));
        let q_dot = quaternion_rate_map(&q) * omega;
        let mut v_dot = c.tr_mul(&force) / self.mass;
        v_dot.z += self.gravity;
        let omega_dot = self.inertia_inverse * moment;
        let mut f = SVector::<f64, BODY_STATES>::zeros();
        f.fixed_rows_mut::<4>(0).copy_from(&q_dot);
        f.fixed_rows_mut::<3>(4).copy_from(&v_dot);
        f.fixed_rows_mut::<3>(7).copy_from(&omega_dot);
        f
    }

    #[inline(always)]
    fn linearise(
        &self,
        x: &SVector<f64, BODY_STATES>,
        u: &SVector<f64, NU>,
    ) -> Linearisation<BODY_STATES, NU> {
        let (q, v, omega) = split(x);
        let v_air = v - self.wind_ned;
        let c = dcm_body_from_ned(q);
        let jet = self.aero.jet(&(c * v_air), self.density);
        let mut force = mul(&self.force_map, u);
        force.x += jet.value[0];
        force.z += jet.value[1];
        let side_gradient = jet.side.map_or(Vector3::zeros(), |(side, gradient, _)| {
            force.y += side;
            gradient
        });
        let momentum = self.inertia * omega;
        let mut moment = mul(&self.moment_map, u) - omega.cross(&momentum);
        moment.y += jet.value[2];

        let xi = quaternion_rate_map(&q);
        let inverse_mass = 1.0 / self.mass;
        let mut v_dot = c.tr_mul(&force) * inverse_mass;
        v_dot.z += self.gravity;

        // Air velocity in body axes by q and v; loads by it.
        let d = rotation_gradient(&q, &v_air, -1.0);
        let force_by_air = Matrix3::from_rows(&[
            (jet.gradient[0] * inverse_mass).transpose(),
            (side_gradient * inverse_mass).transpose(),
            (jet.gradient[1] * inverse_mass).transpose(),
        ]);
        let c_force = c.tr_mul(&force_by_air);
        let mut v_by_q = rotation_gradient(&q, &(force * inverse_mass), 1.0);
        add_mul(&mut v_by_q, &c_force, &d);
        let v_by_v = c_force * c;
        let lever = self.inertia_inverse.column(1);
        let air_gradient = jet.gradient[2].transpose();
        let omega_by_q = lever * (air_gradient * d);
        let omega_by_v = lever * (air_gradient * c);
        let omega_by_omega = self.inertia_inverse * (skew(&momentum) - skew(&omega) * self.inertia);

        let mut a = SMatrix::<f64, BODY_STATES, BODY_STATES>::zeros();
        let [p, y, r] = [0.5 * omega.x, 0.5 * omega.y, 0.5 * omega.z];
        let q_by_q = SMatrix::<f64, 4, 4>::new(
            0.0, -p, -y, -r, //
            p, 0.0, r, -y, //
            y, -r, 0.0, p, //
            r, y, -p, 0.0,
        );
        a.fixed_view_mut::<4, 4>(0, 0).copy_from(&q_by_q);
        a.fixed_view_mut::<4, 3>(0, 7).copy_from(&xi);
        a.fixed_view_mut::<3, 4>(4, 0).copy_from(&v_by_q);
        a.fixed_view_mut::<3, 3>(4, 4).copy_from(&v_by_v);
        a.fixed_view_mut::<3, 4>(7, 0).copy_from(&omega_by_q);
        a.fixed_view_mut::<3, 3>(7, 4).copy_from(&omega_by_v);
        a.fixed_view_mut::<3, 3>(7, 7).copy_from(&omega_by_omega);
        let mut b = SMatrix::<f64, BODY_STATES, NU>::zeros();
        b.fixed_view_mut::<3, NU>(4, 0).copy_from(&(tr_mul(&c, &self.force_map) * inverse_mass));
        b.fixed_view_mut::<3, NU>(7, 0).copy_from(&self.angular_map);
        let mut f = SVector::<f64, BODY_STATES>::zeros();
        f.fixed_rows_mut::<4>(0).copy_from(&(xi * omega));
        f.fixed_rows_mut::<3>(4).copy_from(&v_dot);
        f.fixed_rows_mut::<3>(7).copy_from(&(self.inertia_inverse * moment));
        Linearisation { f, a, b }
    }

    /// With `l = (l_q, l_v, l_w)` the weights, `a(q) = C(q) l_v/m` and `b = J^-T l_w`:
    /// `l . f = l_q . Xi(q) w + a . (F_air + F_u u) + b . (M_air + M_u u - w x J w) + const`.
    #[inline(always)]
    fn curvature(
        &self,
        x: &SVector<f64, BODY_STATES>,
        u: &SVector<f64, NU>,
        weights: &SVector<f64, BODY_STATES>,
    ) -> Curvature<BODY_STATES, NU> {
        let (q, v, _) = split(x);
        let (l_q, l_v, l_w) = split(weights);
        let l_v = l_v / self.mass;
        let v_air = v - self.wind_ned;
        let c = dcm_body_from_ned(q);
        let jet = self.aero.jet(&(c * v_air), self.density);
        let a = c * l_v;
        let b = self.inertia_inverse.tr_mul(&l_w);
        let mut force = mul(&self.force_map, u);
        force.x += jet.value[0];
        force.z += jet.value[1];
        // Gradient and Hessian of the weighted air loads by the air velocity in body axes.
        let mut gradient = jet.gradient[0] * a.x + jet.gradient[1] * a.z + jet.gradient[2] * b.y;
        let mut phi = jet.hessian[0] * a.x + jet.hessian[1] * a.z + jet.hessian[2] * b.y;
        let d = rotation_gradient(&q, &v_air, -1.0);
        let l = rotation_gradient(&q, &l_v, -1.0);
        // d(F_air)/d(air velocity), times d(a)/dq from the left: 4x3.
        let mut l_force = SMatrix::<f64, 4, 3>::zeros();
        for j in 0..3 {
            for i in 0..4 {
                l_force[(i, j)] = l[(0, i)] * jet.gradient[0][j] + l[(2, i)] * jet.gradient[1][j];
            }
        }
        if let Some((side, side_gradient, hessian)) = jet.side {
            force.y += side;
            gradient += side_gradient * a.y;
            phi += hessian * a.y;
            l_force += l.row(1).transpose() * side_gradient.transpose();
        }
        let half = mul(&l_force, &d);
        let phi_d = mul(&phi, &d);
        let mut qq = half + half.transpose();
        add_tr_mul(&mut qq, &d, &phi_d);
        qq += rotation_hessian(&gradient, &v_air) + rotation_hessian(&force, &l_v);
        let mut vq = rotation_gradient(&q, &gradient, 1.0);
        let c_phi = c.tr_mul(&phi);
        add_mul(&mut vq, &c_phi, &d);
        add_tr_mul(&mut vq, &c, &l_force.transpose());
        let vv = c_phi * c;
        let [a0, a1, a2, a3] = l_q.map(|x| 0.5 * x);
        let q_omega = SMatrix::<f64, 4, 3>::new(a1, a2, a3, -a0, a3, -a2, -a3, -a0, a1, a2, -a1, -a0);
        let spin = skew(&b) * self.inertia;

        let mut xx = SMatrix::<f64, BODY_STATES, BODY_STATES>::zeros();
        xx.fixed_view_mut::<4, 4>(0, 0).copy_from(&qq);
        xx.fixed_view_mut::<3, 4>(4, 0).copy_from(&vq);
        xx.fixed_view_mut::<4, 3>(0, 4).copy_from(&vq.transpose());
        xx.fixed_view_mut::<3, 3>(4, 4).copy_from(&vv);
        xx.fixed_view_mut::<4, 3>(0, 7).copy_from(&q_omega);
        xx.fixed_view_mut::<3, 4>(7, 0).copy_from(&q_omega.transpose());
        xx.fixed_view_mut::<3, 3>(7, 7).copy_from(&(spin + spin.transpose()));
        let mut ux = SMatrix::<f64, NU, BODY_STATES>::zeros();
        ux.fixed_view_mut::<NU, 4>(0, 0).copy_from(&tr_mul(&self.force_map, &l));
        Curvature { xx, ux, uu: SMatrix::zeros() }
    }
}
