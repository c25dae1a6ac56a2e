//! The planner's dynamics with three more states, for what is one number of the whole plan or adds up along
//! it: the altitude lost, the peak of J_state, and the factor by which time is stretched.
//!
//! ```text
//! x = [q0 q1 q2 q3, vn ve vd, P Q R | altitude lost [m], peak, stretch]
//! x' = stretch [f(x, u) | vd, 0, 0]
//! ```
//!
//! Peak and stretch do not change; where they are free, the solver chooses their value at the first node.

use nalgebra::{SMatrix, SVector};

use super::dynamics::{BODY_STATES, Curvature, Dynamics, Linearisation, VehicleDynamics};

/// Number of states of the extended dynamics.
pub const EXTENDED_STATES: usize = BODY_STATES + 3;
/// Index of the altitude lost since the first node [m].
pub const ALTITUDE_LOST: usize = BODY_STATES;
/// Index of the peak of J_state.
pub const PEAK: usize = BODY_STATES + 1;
/// Index of the factor by which time is stretched.
pub const STRETCH: usize = BODY_STATES + 2;
/// Index of the velocity down [m/s].
const DOWN: usize = 6;

/// A vehicle with `NU` rotors as the planner sees it, with altitude lost, peak and stretch of time.
#[derive(Clone, Debug)]
pub struct ExtendedDynamics<const NU: usize>(pub VehicleDynamics<NU>);

/// The states of the body among the extended ones.
#[inline(always)]
pub fn body_of(x: &SVector<f64, EXTENDED_STATES>) -> SVector<f64, BODY_STATES> {
    SVector::from_fn(|i, _| x[i])
}

impl<const NU: usize> Dynamics<EXTENDED_STATES, NU> for ExtendedDynamics<NU> {
    #[inline(never)]
    fn value(
        &self,
        x: &SVector<f64, EXTENDED_STATES>,
        u: &SVector<f64, NU>,
    ) -> SVector<f64, EXTENDED_STATES> {
        extend(&self.0.value(&body_of(x), u), x)
    }

    #[inline(never)]
    fn linearise(
        &self,
        x: &SVector<f64, EXTENDED_STATES>,
        u: &SVector<f64, NU>,
    ) -> Linearisation<EXTENDED_STATES, NU> {
        let body = self.0.linearise(&body_of(x), u);
        let stretch = x[STRETCH];
        let mut a = SMatrix::<f64, EXTENDED_STATES, EXTENDED_STATES>::zeros();
        let mut b = SMatrix::<f64, EXTENDED_STATES, NU>::zeros();
        a.fixed_view_mut::<BODY_STATES, BODY_STATES>(0, 0).copy_from(&(body.a * stretch));
        a.fixed_view_mut::<BODY_STATES, 1>(0, STRETCH).copy_from(&body.f);
        a[(ALTITUDE_LOST, DOWN)] = stretch;
        a[(ALTITUDE_LOST, STRETCH)] = x[DOWN];
        b.fixed_view_mut::<BODY_STATES, NU>(0, 0).copy_from(&(body.b * stretch));
        Linearisation { f: extend(&body.f, x), a, b }
    }

    #[inline(never)]
    fn curvature(
        &self,
        x: &SVector<f64, EXTENDED_STATES>,
        u: &SVector<f64, NU>,
        weights: &SVector<f64, EXTENDED_STATES>,
    ) -> Curvature<EXTENDED_STATES, NU> {
        let (body, w, stretch) = (body_of(x), body_of(weights), x[STRETCH]);
        let own = self.0.curvature(&body, u, &(w * stretch));
        let first = self.0.linearise(&body, u);
        let mut by_stretch = first.a.tr_mul(&w);
        by_stretch[DOWN] += weights[ALTITUDE_LOST];
        let mut curvature = Curvature::<EXTENDED_STATES, NU>::zero();
        curvature.xx.fixed_view_mut::<BODY_STATES, BODY_STATES>(0, 0).copy_from(&own.xx);
        curvature.xx.fixed_view_mut::<BODY_STATES, 1>(0, STRETCH).copy_from(&by_stretch);
        curvature.xx.fixed_view_mut::<1, BODY_STATES>(STRETCH, 0).copy_from(&by_stretch.transpose());
        curvature.ux.fixed_view_mut::<NU, BODY_STATES>(0, 0).copy_from(&own.ux);
        curvature.ux.fixed_view_mut::<NU, 1>(0, STRETCH).copy_from(&first.b.tr_mul(&w));
        curvature.uu = own.uu;
        curvature
    }
}

fn extend(
    body_rate: &SVector<f64, BODY_STATES>,
    x: &SVector<f64, EXTENDED_STATES>,
) -> SVector<f64, EXTENDED_STATES> {
    let mut f = SVector::<f64, EXTENDED_STATES>::zeros();
    f.fixed_rows_mut::<BODY_STATES>(0).copy_from(&(body_rate * x[STRETCH]));
    f[ALTITUDE_LOST] = x[DOWN] * x[STRETCH];
    f
}

/// A vehicle as the planner's dynamics have it, with any number of states beside those of the body.
pub(super) trait PlannedVehicle<const NX: usize, const NU: usize>: Dynamics<NX, NU> {
    /// The rigid body's dynamics.
    fn body(&self) -> &VehicleDynamics<NU>;
    /// The state of the body at a state.
    fn body_state(x: &SVector<f64, NX>) -> SVector<f64, BODY_STATES>;
    /// The states of a guess or a plan moved on, made from those of the body: `first` is the state that the
    /// problem gives.
    fn states(
        body: Vec<SVector<f64, BODY_STATES>>,
        first: &SVector<f64, NX>,
        dt_s: f64,
    ) -> Vec<SVector<f64, NX>>;
    /// The factor by which time is stretched at a state.
    fn stretch(x: &SVector<f64, NX>) -> f64;
}

impl<const NU: usize> PlannedVehicle<BODY_STATES, NU> for VehicleDynamics<NU> {
    fn body(&self) -> &VehicleDynamics<NU> {
        self
    }

    fn body_state(x: &SVector<f64, BODY_STATES>) -> SVector<f64, BODY_STATES> {
        *x
    }

    fn states(
        body: Vec<SVector<f64, BODY_STATES>>,
        _: &SVector<f64, BODY_STATES>,
        _: f64,
    ) -> Vec<SVector<f64, BODY_STATES>> {
        body
    }

    fn stretch(_: &SVector<f64, BODY_STATES>) -> f64 {
        1.0
    }
}

impl<const NU: usize> PlannedVehicle<EXTENDED_STATES, NU> for ExtendedDynamics<NU> {
    fn body(&self) -> &VehicleDynamics<NU> {
        &self.0
    }

    fn body_state(x: &SVector<f64, EXTENDED_STATES>) -> SVector<f64, BODY_STATES> {
        body_of(x)
    }

    fn states(
        body: Vec<SVector<f64, BODY_STATES>>,
        first: &SVector<f64, EXTENDED_STATES>,
        dt_s: f64,
    ) -> Vec<SVector<f64, EXTENDED_STATES>> {
        let (mut lost_m, mut v_down) = (first[ALTITUDE_LOST], first[6]);
        let extend = |x: &SVector<f64, BODY_STATES>| {
            lost_m += 0.5 * dt_s * (v_down + x[6]);
            v_down = x[6];
            let mut all = *first;
            all.fixed_rows_mut::<BODY_STATES>(0).copy_from(x);
            all[ALTITUDE_LOST] = lost_m;
            all
        };
        let mut states: Vec<_> = body.iter().map(extend).collect();
        if let Some(x) = states.first_mut() {
            x[ALTITUDE_LOST] = first[ALTITUDE_LOST];
        }
        states
    }

    fn stretch(x: &SVector<f64, EXTENDED_STATES>) -> f64 {
        x[STRETCH]
    }
}
