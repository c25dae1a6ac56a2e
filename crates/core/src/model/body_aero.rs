//! Body aerodynamics (13)-(18): drag, lift and pitching moment from tables over the angle of attack.
//!
//! With the air-relative body velocity `[U V W]`, `alpha = atan2(W, U)` and `qbar = rho (U^2+V^2+W^2)/2`:
//!
//! ```text
//! F_x = qbar S (-C_D cos a + C_L sin a)      F_z = qbar S (-C_D sin a - C_L cos a)      M_y = qbar S b C_M
//! ```
//!
//! Differs from the paper: element (3,3) of (16) is printed 1; it is cos alpha. Airspeed is relative to the
//! air (the paper has no wind). Assumptions: rolling and yawing moments are zero and the coefficients do not
//! depend on sideslip, as in the paper; no rate damping.
//!
//! The paper has no side force either. A body with a **side area** S_y has one; along each axis the air then
//! acts by the component of the flow, as on a body whose drag is the same from all sides. With the airspeed
//! `V_a` and its part `r = sqrt(U^2+W^2)` in the plane of symmetry
//!
//! ```text
//! F_y = -rho S_y V_a V/2      qbar = rho V_a r/2 in F_x, F_z and M_y
//! ```
//!
//! which in flow without a part from the side is what the paper has. Without a side area, flow from the side
//! adds to the dynamic pressure of the flow in the plane of symmetry and has no force of its own.

use nalgebra::{Matrix3, Vector3};

use super::ModelError;
use super::spline::PeriodicSpline;
use crate::real::Real;
use crate::real::straight;
use crate::vector::V3;

/// The body's coefficient tables and reference dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyAero {
    area_m2: f64,
    span_m: f64,
    c_drag: PeriodicSpline,
    c_lift: PeriodicSpline,
    c_pitch: PeriodicSpline,
    side_area_m2: Option<f64>,
}

/// Force and moment of the air on the body, body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AeroLoad<S = f64> {
    /// Force [N], body axes.
    pub force_body: V3<S>,
    /// Moment about the centre of mass [N m], body axes.
    pub moment_body: V3<S>,
}

/// [`BodyAero`]'s components (force x, force z, moment y, and force y where there is one) with derivatives
/// with respect to the air-relative body velocity.
#[derive(Clone, Copy, Debug)]
pub struct AeroJet {
    /// Values of `F_x` [N], `F_z` [N] and `M_y` [N m].
    pub value: [f64; 3],
    /// Gradients of `F_x`, `F_z` and `M_y` with respect to `[U V W]`.
    pub gradient: [Vector3<f64>; 3],
    /// Hessians of `F_x`, `F_z` and `M_y` with respect to `[U V W]`.
    pub hessian: [Matrix3<f64>; 3],
    /// Value [N], gradient and Hessian of `F_y`, of a body with a side area.
    pub side: Option<(f64, Vector3<f64>, Matrix3<f64>)>,
}

impl BodyAero {
    /// Builds the body from coefficient tables over `alpha_rad`, which runs from -pi to pi.
    ///
    /// # Errors
    /// [`ModelError`] for a reference dimension that is not positive, or for a table that
    /// [`PeriodicSpline::new`] refuses or that does not span the whole turn.
    pub fn new(
        area_m2: f64,
        span_m: f64,
        alpha_rad: &[f64],
        c_drag: &[f64],
        c_lift: &[f64],
        c_pitch: &[f64],
    ) -> Result<Self, ModelError> {
        super::check_positive("reference area", area_m2)?;
        super::check_positive("reference span", span_m)?;
        let spline = |name: &str, values: &[f64]| {
            PeriodicSpline::new(alpha_rad, values).map_err(|e| ModelError::Table(format!("{name}: {e}")))
        };
        let aero = Self {
            area_m2,
            span_m,
            c_drag: spline("drag coefficient", c_drag)?,
            c_lift: spline("lift coefficient", c_lift)?,
            c_pitch: spline("pitching moment coefficient", c_pitch)?,
            side_area_m2: None,
        };
        let ends = (alpha_rad[0], alpha_rad[alpha_rad.len() - 1]);
        let pi = std::f64::consts::PI;
        if (ends.0 + pi).abs() > 1e-9 || (ends.1 - pi).abs() > 1e-9 {
            return Err(ModelError::Table("the angle of attack must run from -180 to 180 deg".into()));
        }
        Ok(aero)
    }

    /// This body with a side force: the drag area of flow across the plane of symmetry [m^2].
    ///
    /// # Errors
    /// [`ModelError`] when the area is not positive.
    pub fn with_side_area(self, side_area_m2: f64) -> Result<Self, ModelError> {
        super::check_positive("side area", side_area_m2)?;
        Ok(Self { side_area_m2: Some(side_area_m2), ..self })
    }

    /// Drag area of flow across the plane of symmetry [m^2]; `None` without a side force.
    pub fn side_area_m2(&self) -> Option<f64> {
        self.side_area_m2
    }

    /// Reference area S [m^2].
    pub fn area_m2(&self) -> f64 {
        self.area_m2
    }

    /// Reference span b [m].
    pub fn span_m(&self) -> f64 {
        self.span_m
    }

    /// The splines of C_D, C_L and C_M over the angle of attack [rad]; they have the same knots.
    pub fn coefficients(&self) -> [&PeriodicSpline; 3] {
        [&self.c_drag, &self.c_lift, &self.c_pitch]
    }

    /// This body with the force along its x axis, and that across it, multiplied by the factors `[along,
    /// across]`; the pitching moment stays.
    pub fn along_axes(&self, [along, across]: [f64; 2]) -> Self {
        let [drag, lift] = [0, 1].map(|which| {
            let knots = self.c_drag.knots().iter().zip(self.c_drag.values()).zip(self.c_lift.values());
            let turned = |((alpha, drag), lift): ((&f64, f64), f64)| {
                let (sin, cos) = crate::math::sin_cos(*alpha);
                let (x, z) = (along * (lift * sin - drag * cos), -across * (drag * sin + lift * cos));
                [-x * cos - z * sin, x * sin - z * cos][which]
            };
            knots.map(turned).collect::<Vec<f64>>()
        });
        let spline = |values: &[f64], before: &PeriodicSpline| {
            PeriodicSpline::new(self.c_drag.knots(), values).unwrap_or_else(|_| before.clone())
        };
        Self {
            c_drag: spline(&drag, &self.c_drag),
            c_lift: spline(&lift, &self.c_lift),
            side_area_m2: self.side_area_m2.map(|area| across * area),
            ..self.clone()
        }
    }

    /// This body with C_D (and the side area), C_L and C_M multiplied by the factors `[drag, lift, pitch]`.
    pub fn scaled(&self, [drag, lift, pitch]: [f64; 3]) -> Self {
        Self {
            side_area_m2: self.side_area_m2.map(|area| drag * area),
            c_drag: self.c_drag.scaled(drag),
            c_lift: self.c_lift.scaled(lift),
            c_pitch: self.c_pitch.scaled(pitch),
            ..self.clone()
        }
    }

    /// Force and moment at the air-relative body velocity [m/s] and density [kg/m^3].
    #[inline(always)]
    pub fn load<S: Real>(&self, v_air_body: V3<S>, density: S) -> AeroLoad<S> {
        self.load_off(v_air_body, density, None)
    }

    /// Force and moment as [`Self::load`] has them, with factors on C_D (and the side force), C_L and C_M.
    #[inline(always)]
    pub fn load_off<S: Real>(&self, v_air_body: V3<S>, density: S, factors: Option<&[S; 3]>) -> AeroLoad<S> {
        let V3 { x: u, y: v, z: w } = v_air_body;
        let zero = density.of(0.0);
        let in_plane = u * u + w * w;
        let squared = in_plane + v * v;
        let mut side = match self.side_area_m2 {
            Some(area_m2) => {
                let side = -(density * 0.5 * area_m2 * squared.sqrt() * v);
                S::select(zero.less(squared), side, zero)
            }
            None => zero,
        };
        let alpha = w.atan2(u);
        let inverse = density.of(1.0) / in_plane.sqrt();
        let (cos, sin) = (u * inverse, w * inverse);
        let pressure = match self.side_area_m2 {
            Some(_) => (squared * in_plane).sqrt(),
            None => squared,
        };
        let qs = density * 0.5 * self.area_m2 * pressure;
        // All three have the same knots.
        let place = self.c_drag.place(alpha);
        let (mut cd, mut cl, mut cm) = (self.c_drag.at(place), self.c_lift.at(place), self.c_pitch.at(place));
        if let Some([drag, lift, pitch]) = factors {
            (cd, cl, cm, side) = (cd * *drag, cl * *lift, cm * *pitch, side * *drag);
        }
        // Without flow in the plane of symmetry alpha is undefined. At rest all loads vanish; so do, in a
        // purely lateral flow, all but the side force.
        let flows = !in_plane.less(zero.of(f64::MIN_POSITIVE));
        AeroLoad {
            force_body: V3::new(
                S::select(flows, qs * (cl * sin - cd * cos), zero),
                side,
                S::select(flows, -(qs * (cd * sin + cl * cos)), zero),
            ),
            moment_body: V3::new(zero, S::select(flows, qs * self.span_m * cm, zero), zero),
        }
    }

    /// The load with exact first and second derivatives with respect to the air-relative body velocity.
    ///
    /// Each component in the plane is `qbar(U, V, W) G(alpha)`: products of a pressure and a function of one
    /// angle, so the Hessian is `G qbar'' + G' (qbar' alpha'^T + alpha' qbar'^T) + qbar (G'' alpha' alpha'^T
    /// + G' alpha'')`.
    #[inline(always)]
    pub fn jet(&self, v_air_body: &Vector3<f64>, density: f64) -> AeroJet {
        let (u, w) = (v_air_body.x, v_air_body.z);
        let r2 = u * u + w * w;
        let side = self.side_area_m2.map(|area_m2| side_jet(v_air_body, 0.5 * density * area_m2));
        if r2 <= 0.0 {
            return AeroJet {
                value: [0.0; 3],
                gradient: [Vector3::zeros(); 3],
                hessian: [Matrix3::zeros(); 3],
                side,
            };
        }
        let alpha = straight::atan2(w, u);
        let r = r2.sqrt();
        let (cos, sin) = (u / r, w / r);
        let (d, l, m) = (self.c_drag.jet(alpha), self.c_lift.jet(alpha), self.c_pitch.jet(alpha));
        // Functions of alpha alone and their first two derivatives.
        let g = [
            [
                l.value * sin - d.value * cos,
                (l.first + d.value) * sin + (l.value - d.first) * cos,
                (l.second + 2.0 * d.first - l.value) * sin + (2.0 * l.first + d.value - d.second) * cos,
            ],
            [
                -d.value * sin - l.value * cos,
                (l.value - d.first) * sin - (d.value + l.first) * cos,
                (2.0 * l.first + d.value - d.second) * sin + (l.value - 2.0 * d.first - l.second) * cos,
            ],
            [self.span_m * m.value, self.span_m * m.first, self.span_m * m.second],
        ];
        let rs = density * self.area_m2;
        let squared = v_air_body.norm_squared();
        let (q, dq, ddq) = match self.side_area_m2 {
            None => (0.5 * rs * squared, v_air_body * rs, Matrix3::from_diagonal_element(rs)),
            Some(_) => product_of_speeds(v_air_body, squared.sqrt(), r, 0.5 * rs),
        };
        let (r4, r2i) = (1.0 / (r2 * r2), 1.0 / r2);
        let da = Vector3::new(-w * r2i, 0.0, u * r2i);
        let (auu, auw) = (2.0 * u * w * r4, (w * w - u * u) * r4);
        let dda = Matrix3::new(auu, 0.0, auw, 0.0, 0.0, 0.0, auw, 0.0, -auu);
        let dq_da = dq * da.transpose();
        let cross = dq_da + dq_da.transpose();
        let da_da = da * da.transpose();
        let term = |g: &[f64; 3]| {
            let hessian = ddq * g[0] + cross * g[1] + da_da * (q * g[2]) + dda * (q * g[1]);
            (q * g[0], dq * g[0] + da * (q * g[1]), hessian)
        };
        let parts = [term(&g[0]), term(&g[1]), term(&g[2])];
        AeroJet {
            value: [parts[0].0, parts[1].0, parts[2].0],
            gradient: [parts[0].1, parts[1].1, parts[2].1],
            hessian: [parts[0].2, parts[1].2, parts[2].2],
            side,
        }
    }
}

/// `k V_a r` with gradient and Hessian with respect to the velocity, whose length is `speed` and whose part
/// in the plane of symmetry is `r` long; neither is zero.
fn product_of_speeds(v: &Vector3<f64>, speed: f64, r: f64, k: f64) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let (along, in_plane) = (v / speed, Vector3::new(v.x / r, 0.0, v.z / r));
    let mixed = along * in_plane.transpose();
    let of_speed = (Matrix3::identity() - along * along.transpose()) * (r / speed);
    let of_r = (Matrix3::from_diagonal(&Vector3::new(1.0, 0.0, 1.0)) - in_plane * in_plane.transpose())
        * (speed / r);
    (k * speed * r, (along * r + in_plane * speed) * k, (of_speed + of_r + mixed + mixed.transpose()) * k)
}

/// `F_y = -k V_a V` with gradient and Hessian.
fn side_jet(v: &Vector3<f64>, k: f64) -> (f64, Vector3<f64>, Matrix3<f64>) {
    let speed = v.norm();
    if speed <= 0.0 {
        return (0.0, Vector3::zeros(), Matrix3::zeros());
    }
    let along = v / speed;
    let mixed = along * Vector3::y().transpose();
    let of_speed = (Matrix3::identity() - along * along.transpose()) * (v.y / speed);
    let gradient = along * v.y + Vector3::y() * speed;
    (-k * speed * v.y, gradient * -k, (of_speed + mixed + mixed.transpose()) * -k)
}
