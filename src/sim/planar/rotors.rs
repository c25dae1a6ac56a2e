//! Thrust, torque and speed of a front and a rear rotor: [`crate::model::rotor`] and [`crate::model::motor`] in the plane.
//!
//! A hub at `(x, z)` sees `U + Q z` and `W - Q x`; the angle of the flow against the disk is `atan2(W_i, |U_i|)`.

use super::lanes::{LANES, Lanes, atan2, clip, interval};
use crate::model::{Motor, Rotor, RotorTable};

/// Rotors and motors of the two pairs.
#[derive(Clone, Debug)]
pub(super) struct Rotors {
    /// `(x, z)` of the front and the rear hubs [m].
    hubs_m: [[f64; 2]; 2],
    rotor: LaneRotor,
    motor: Motor,
    pub(super) omega_max_rad_s: f64,
}

#[derive(Clone, Debug)]
enum LaneRotor {
    Table(Table),
    /// `T = k omega^2`, `Q = c T` at a density.
    Quadratic {
        k: f64,
        c: f64,
        density_kg_m3: f64,
    },
}

#[derive(Clone, Debug)]
struct Table {
    axes: [Axis; 3],
    /// Angle running fastest, then airspeed.
    cells: Vec<[f64; 2]>,
    /// Cells per step of speed and of airspeed.
    strides: [usize; 2],
    density_kg_m3: f64,
}

#[derive(Clone, Debug)]
struct Axis {
    knots: Vec<f64>,
    inverse_spacing: Option<f64>,
}

/// Thrust [N], and torque of the air [N m], of one rotor.
pub(super) struct LaneLoad {
    pub(super) thrust: Lanes,
    pub(super) torque: Lanes,
}

impl Rotors {
    pub(super) fn new(rotor: &Rotor, motor: &Motor, hubs_m: [[f64; 2]; 2]) -> Self {
        let rotor = match rotor {
            Rotor::Table(table) => LaneRotor::Table(Table::new(table)),
            Rotor::Quadratic { thrust_n_per_rad2_s2, torque_per_thrust_m, density_kg_m3 } => {
                LaneRotor::Quadratic {
                    k: *thrust_n_per_rad2_s2,
                    c: *torque_per_thrust_m,
                    density_kg_m3: *density_kg_m3,
                }
            }
        };
        Self { hubs_m, rotor, omega_max_rad_s: motor.omega_max_rad_s(), motor: motor.clone() }
    }

    /// Load of a rotor of pair `pair` (0 front, 1 rear) on a body that moves with `u`, `w` through the air and turns with `rate`.
    #[inline(always)]
    pub(super) fn load(
        &self,
        pair: usize,
        omega: &Lanes,
        flow: [&Lanes; 2],
        rate: &Lanes,
        density_kg_m3: &Lanes,
    ) -> LaneLoad {
        let mut load = LaneLoad { thrust: [0.0; LANES], torque: [0.0; LANES] };
        match &self.rotor {
            LaneRotor::Quadratic { k, c, density_kg_m3: reference } => {
                for i in 0..LANES {
                    load.thrust[i] = k * (density_kg_m3[i] / reference) * omega[i] * omega[i];
                    load.torque[i] = c * load.thrust[i];
                }
            }
            LaneRotor::Table(table) => {
                let [x, z] = self.hubs_m[pair];
                let (mut airspeed, mut angle) = ([0.0; LANES], [0.0; LANES]);
                for i in 0..LANES {
                    let (u, w) = (flow[0][i] + rate[i] * z, flow[1][i] - rate[i] * x);
                    airspeed[i] = (u * u + w * w).sqrt();
                    angle[i] = atan2(w, u.abs());
                }
                table.load(omega, &airspeed, &angle, density_kg_m3, &mut load);
            }
        }
        load
    }

    /// Angular acceleration [rad/s^2] at a commanded speed, speed [rad/s] and torque of the air [N m].
    #[inline(always)]
    pub(super) fn acceleration(&self, omega_c: &Lanes, omega: &Lanes, torque: &Lanes) -> Lanes {
        let mut out = [0.0; LANES];
        match self.motor {
            Motor::EscDc {
                torque_constant_nm_a: k_t,
                back_emf_constant_v_s_rad: k_e,
                resistance_ohm,
                voltage_max_v,
                current_max_a,
                current_min_a,
                esc_gain_v_s_rad: k_esc,
                rotor_inertia_kg_m2,
                ..
            } => {
                for i in 0..LANES {
                    let voltage = k_e * omega_c[i] + k_esc * (omega_c[i] - omega[i]);
                    let voltage = clip(voltage, 0.0, voltage_max_v);
                    let current =
                        clip((voltage - k_e * omega[i]) / resistance_ohm, current_min_a, current_max_a);
                    out[i] = not_backwards((k_t * current - torque[i]) / rotor_inertia_kg_m2, omega[i]);
                }
            }
            Motor::FirstOrder { tau_up_s, tau_down_s, .. } => {
                for i in 0..LANES {
                    let difference = omega_c[i] - omega[i];
                    let tau = if difference > 0.0 { tau_up_s } else { tau_down_s };
                    out[i] = not_backwards(difference / tau, omega[i]);
                }
            }
        }
        out
    }
}

/// A rotor at rest is never driven backwards.
#[inline(always)]
fn not_backwards(rate: f64, omega: f64) -> f64 {
    if (omega <= 0.0) & (rate < 0.0) { 0.0 } else { rate }
}

impl Axis {
    fn new(knots: &[f64]) -> Self {
        let n = knots.len() - 1;
        let spacing = (knots[n] - knots[0]) / n as f64;
        let even = knots.windows(2).all(|w| (w[1] - w[0] - spacing).abs() < 1e-9 * spacing);
        Self { knots: knots.to_vec(), inverse_spacing: even.then(|| 1.0 / spacing) }
    }

    /// Left knots and fractions of the intervals; clamped.
    #[inline(always)]
    fn locate(&self, x: &Lanes) -> ([usize; LANES], Lanes) {
        let last = self.knots.len() - 2;
        let mut at = [0; LANES];
        match self.inverse_spacing {
            Some(inverse) => {
                for i in 0..LANES {
                    at[i] = interval((x[i] - self.knots[0]) * inverse, last as f64);
                }
            }
            None => {
                for i in 0..LANES {
                    at[i] = self.knots[1..=last].partition_point(|&k| k <= x[i]);
                }
            }
        }
        let (mut left, mut right, mut fraction) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            left[i] = self.knots[at[i]];
            right[i] = self.knots[at[i] + 1];
        }
        for i in 0..LANES {
            fraction[i] = clip((x[i] - left[i]) / (right[i] - left[i]), 0.0, 1.0);
        }
        (at, fraction)
    }
}

impl Table {
    fn new(table: &RotorTable) -> Self {
        let knots = table.knots();
        let strides = [knots[1].len() * knots[2].len(), knots[2].len()];
        Self {
            axes: knots.map(Axis::new),
            cells: table.cells().to_vec(),
            strides,
            density_kg_m3: table.density_kg_m3(),
        }
    }

    #[inline(always)]
    fn load(
        &self,
        omega: &Lanes,
        airspeed: &Lanes,
        angle: &Lanes,
        density_kg_m3: &Lanes,
        load: &mut LaneLoad,
    ) {
        let (i_omega, a) = self.axes[0].locate(omega);
        let (i_airspeed, b) = self.axes[1].locate(airspeed);
        let (i_angle, c) = self.axes[2].locate(angle);
        for i in 0..LANES {
            let at = i_omega[i] * self.strides[0] + i_airspeed[i] * self.strides[1] + i_angle[i];
            // Two neighbours along the angle, [T Q T' Q'].
            let edge = |at: usize| {
                let [x, y] = [self.cells[at], self.cells[at + 1]];
                [x[0], x[1], y[0], y[1]]
            };
            let low = mix(edge(at), edge(at + self.strides[1]), b[i]);
            let at = at + self.strides[0];
            let high = mix(edge(at), edge(at + self.strides[1]), b[i]);
            let [t0, q0, t1, q1] = mix(low, high, a[i]);
            let scale = density_kg_m3[i] / self.density_kg_m3;
            load.thrust[i] = scale * (t0 + c[i] * (t1 - t0));
            load.torque[i] = scale * (q0 + c[i] * (q1 - q0));
        }
    }
}

#[inline(always)]
fn mix(x: [f64; 4], y: [f64; 4], s: f64) -> [f64; 4] {
    std::array::from_fn(|k| x[k] + s * (y[k] - x[k]))
}
