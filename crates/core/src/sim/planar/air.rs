//! Air on the body in the plane: (13)-(18), as [`crate::model::body_aero`] has it.
//!
//! With `r = hypot(U, W)`, `cos alpha = U/r` and `sin alpha = W/r`, so
//!
//! ```text
//! F_x = rho S r (C_L W - C_D U)/2      F_z = -rho S r (C_D W + C_L U)/2      M_y = rho S b r^2 C_M/2
//! ```

use super::lanes::{LANES, Lanes, index, interval};
use crate::model::BodyAero;
use crate::model::axis::Axis;
use crate::real::straight::atan2;

/// The three splines, interleaved so that an interval's coefficients lie together.
#[derive(Clone, Debug)]
pub(super) struct AeroTable {
    /// Per interval, four rows `c0..c3` of `[C_D, C_L, C_M, left knot in the first row]`.
    pieces: Vec<[[f64; 4]; 4]>,
    axis: Axis,
    area_m2: f64,
    span_m: f64,
}

/// Velocity through the air, body axes [m/s], its size, and the angle of attack [rad].
pub(super) struct Flow {
    pub(super) u: Lanes,
    pub(super) w: Lanes,
    speed: Lanes,
    alpha: Lanes,
}

/// Force [N] and moment [N m] of the air on the body.
pub(super) struct AirLoad {
    pub(super) f_x: Lanes,
    pub(super) f_z: Lanes,
    pub(super) m_y: Lanes,
}

/// `rho S/2` with the factors on C_D, C_L and (with the span) C_M.
pub(super) struct AirScale {
    drag: Lanes,
    lift: Lanes,
    pitch: Lanes,
}

impl AeroTable {
    pub(super) fn new(aero: &BodyAero) -> Self {
        let splines = aero.coefficients();
        let axis = splines[0].axis().clone();
        let piece = |i: usize| {
            let row = |k: usize| {
                let knot = if k == 0 { axis.knots[i] } else { 0.0 };
                [splines[0].pieces()[i][k], splines[1].pieces()[i][k], splines[2].pieces()[i][k], knot]
            };
            [row(0), row(1), row(2), row(3)]
        };
        Self {
            pieces: (0..axis.knots.len() - 1).map(piece).collect(),
            axis,
            area_m2: aero.area_m2(),
            span_m: aero.span_m(),
        }
    }

    /// Scales of the load in one lane at a density [kg/m^3] and factors on the coefficients.
    pub(super) fn scale_of(&self, density_kg_m3: f64, factors: [f64; 3]) -> [f64; 3] {
        let half = 0.5 * density_kg_m3 * self.area_m2;
        [half * factors[0], half * factors[1], half * self.span_m * factors[2]]
    }

    #[inline(always)]
    fn intervals(&self, alpha: &Lanes) -> [usize; LANES] {
        let mut at = [0; LANES];
        let last = self.pieces.len() - 1;
        match self.axis.inverse_spacing {
            Some(inverse) => {
                for i in 0..LANES {
                    at[i] = index(interval((alpha[i] - self.axis.knots[0]) * inverse, last as f64));
                }
            }
            None => {
                for i in 0..LANES {
                    at[i] = self.axis.interval(alpha[i]);
                }
            }
        }
        at
    }

    /// C_D, C_L and C_M of each lane, and a fourth number without meaning.
    #[inline(always)]
    fn coefficients(&self, alpha: &Lanes) -> [[f64; 4]; LANES] {
        let at = self.intervals(alpha);
        let mut out = [[0.0; 4]; LANES];
        for i in 0..LANES {
            let [c0, c1, c2, c3] = &self.pieces[at[i]];
            let d = alpha[i] - c0[3];
            for k in 0..4 {
                out[i][k] = c0[k] + d * (c1[k] + d * (c2[k] + d * c3[k]));
            }
        }
        out
    }

    #[inline(always)]
    pub(super) fn load(&self, scale: &AirScale, flow: &Flow) -> AirLoad {
        let coefficients = self.coefficients(&flow.alpha);
        let (mut f_x, mut f_z, mut m_y) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let [c_d, c_l, c_m, _] = coefficients[i];
            let (u, w, r) = (flow.u[i], flow.w[i], flow.speed[i]);
            let (drag, lift) = (scale.drag[i] * c_d * r, scale.lift[i] * c_l * r);
            f_x[i] = lift * w - drag * u;
            f_z[i] = -(drag * w + lift * u);
            m_y[i] = scale.pitch[i] * c_m * (r * r);
        }
        AirLoad { f_x, f_z, m_y }
    }
}

impl AirScale {
    pub(super) fn new(lanes: [[f64; 3]; LANES]) -> Self {
        let component = |k: usize| std::array::from_fn(|i| lanes[i][k]);
        Self { drag: component(0), lift: component(1), pitch: component(2) }
    }
}

impl Flow {
    /// Flow past a body with `cos = q0^2 - q2^2`, `sin = 2 q0 q2` that moves through the air with `v_n`,
    /// `v_d` [m/s].
    #[inline(always)]
    pub(super) fn new(cos: &Lanes, sin: &Lanes, v_n: &Lanes, v_d: &Lanes) -> Self {
        let mut flow = Self { u: *cos, w: *cos, speed: *cos, alpha: *cos };
        for i in 0..LANES {
            let u = cos[i] * v_n[i] - sin[i] * v_d[i];
            let w = sin[i] * v_n[i] + cos[i] * v_d[i];
            flow.u[i] = u;
            flow.w[i] = w;
            flow.speed[i] = (u * u + w * w).sqrt();
            flow.alpha[i] = atan2(w, u);
        }
        flow
    }
}
