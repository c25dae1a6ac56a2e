//! Thrust, torque, in-plane force and speed of one rotor of each group: [`crate::model::rotor`] and
//! [`crate::model::motor`] in the plane.
//!
//! A hub at `(x, z)` sees `U + Q z` and `W - Q x`; the angle of the flow against the disk is `atan2(W_i,
//! |U_i|)`.

use std::f64::consts::PI;

use super::groups::{MOST_GROUPS, RotorGroup, of_groups};
use super::lanes::{LANES, Lanes, clip, index, interval};
use crate::model::axis::Axis;
use crate::model::coefficient_table::{FLOW_STEPS, HALF_AT, SPEED_STEPS};
use crate::model::{CoefficientTable, Motor, Rotor, RotorTable, inflow};
use crate::real::straight::atan2;

/// Rotors and motors of the groups.
#[derive(Clone, Debug)]
pub(super) struct Rotors {
    /// `(x, z)` of the hubs of each group [m].
    hubs_m: [[f64; 2]; MOST_GROUPS],
    rotor: LaneRotor,
    /// Density that the rotor's numbers hold for [kg/m^3].
    density_kg_m3: f64,
    /// What other rotors' wakes leave of each group's thrust and torque.
    interference: [[f64; 2]; MOST_GROUPS],
    motor: LaneMotor,
    omega_max_rad_s: f64,
}

#[derive(Clone, Debug)]
enum LaneRotor {
    Table(Table),
    Coefficients(Coefficients),
    /// `T = k omega^2`, `Q = c T`, `-h omega U_i` forward.
    Quadratic {
        k: f64,
        c: f64,
        h: f64,
    },
}

/// A [`Motor`] with reciprocals in place of divisors.
#[derive(Clone, Debug)]
enum LaneMotor {
    EscDc {
        k_t: f64,
        k_e: f64,
        k_esc: f64,
        conductance: f64,
        voltage_max: f64,
        current: [f64; 2],
        per_inertia: f64,
    },
    FirstOrder {
        per_tau_up: f64,
        per_tau_down: f64,
    },
}

#[derive(Clone, Debug)]
struct Table {
    /// Grid of rotor speed, airspeed and angle.
    axes: [Axis; 3],
    /// `[T Q]` of a point and of its neighbour along the angle, the angle running fastest, then the airspeed.
    edges: Vec<[f64; 4]>,
    /// Number of points per step of speed and of airspeed.
    strides: [usize; 2],
}

/// Coefficients by speed share and flow share ([`CoefficientTable`]).
#[derive(Clone, Debug)]
struct Coefficients {
    radius_m: f64,
    /// Thrust, in-plane force and torque at a point, and a number without meaning; the flow share runs
    /// fastest.
    cells: Vec<[f64; 4]>,
}

/// Thrust [N], torque of the air [N m] and force forward in the rotor's plane [N] of one rotor; or factors on
/// them.
pub(super) struct LaneLoad {
    pub(super) thrust: Lanes,
    pub(super) torque: Lanes,
    pub(super) forward: Lanes,
}

impl Rotors {
    pub(super) fn new(rotor: &Rotor, motor: &Motor, groups: &[RotorGroup]) -> Self {
        let density_kg_m3 = rotor.reference_density_kg_m3();
        let rotor = match rotor {
            Rotor::BladeElement(table) => LaneRotor::Coefficients(Coefficients::new(table)),
            Rotor::Table(table) => LaneRotor::Table(Table::new(table)),
            Rotor::Quadratic {
                thrust_n_per_rad2_s2: k,
                torque_per_thrust_m: c,
                drag_n_s2_per_rad_m: h,
                ..
            } => LaneRotor::Quadratic { k: *k, c: *c, h: *h },
        };
        let omega_max_rad_s = motor.omega_max_rad_s();
        Self {
            hubs_m: of_groups(groups, |g| g.hub_m),
            rotor,
            density_kg_m3,
            interference: of_groups(groups, |g| [g.interference.thrust, g.interference.torque]),
            motor: LaneMotor::new(motor),
            omega_max_rad_s,
        }
    }

    /// Factors of the air's density [kg/m^3] and of other rotors' wakes on thrust and torque of each group.
    pub(super) fn scale<const G: usize>(&self, density_kg_m3: &Lanes) -> [LaneLoad; G] {
        let scaled = |factor: f64| density_kg_m3.map(|density| factor * (density / self.density_kg_m3));
        std::array::from_fn(|group| {
            let [thrust, torque] = self.interference[group].map(scaled);
            LaneLoad { thrust, torque, forward: thrust }
        })
    }

    /// Whether the rotors have forces in their planes.
    #[inline(always)]
    pub(super) fn push_in_plane(&self) -> bool {
        match &self.rotor {
            LaneRotor::Coefficients(_) => true,
            LaneRotor::Quadratic { h, .. } => *h > 0.0,
            LaneRotor::Table(_) => false,
        }
    }

    /// How far the hubs of a group are below the centre of mass [m].
    #[inline(always)]
    pub(super) fn hub_down_m(&self, group: usize) -> f64 {
        self.hubs_m[group][1]
    }

    /// What another rotor's wake leaves of a group's thrust.
    pub(super) fn thrust_share(&self, group: usize) -> f64 {
        self.interference[group][0]
    }

    /// Commanded speeds of the groups [rad/s] for commanded thrusts [N] of at most `thrust_max_n`.
    #[inline(always)]
    pub(super) fn commanded<const G: usize>(&self, thrust: &[Lanes; G], thrust_max_n: f64) -> [Lanes; G] {
        let mut omega_c = [[0.0; LANES]; G];
        for group in 0..G {
            for i in 0..LANES {
                omega_c[group][i] = self.omega_max_rad_s * (thrust[group][i] / thrust_max_n).sqrt();
            }
        }
        omega_c
    }

    /// Load of a rotor of a group on a body that moves with `[u, w]` through the air
    /// and turns with `rate`.
    #[inline(always)]
    pub(super) fn load(
        &self,
        group: usize,
        omega: &Lanes,
        flow: [&Lanes; 2],
        rate: &Lanes,
        scale: &LaneLoad,
    ) -> LaneLoad {
        let nothing = [0.0; LANES];
        let mut load = LaneLoad { thrust: nothing, torque: nothing, forward: nothing };
        match &self.rotor {
            LaneRotor::Coefficients(coefficients) => {
                let [x, z] = self.hubs_m[group];
                let (mut u, mut w) = (nothing, nothing);
                for i in 0..LANES {
                    u[i] = flow[0][i] + rate[i] * z;
                    w[i] = flow[1][i] - rate[i] * x;
                }
                load = coefficients.load(omega, &u, &w);
                for i in 0..LANES {
                    load.forward[i] *= scale.forward[i];
                }
            }
            LaneRotor::Quadratic { k, c, h } => {
                let z = self.hubs_m[group][1];
                for i in 0..LANES {
                    load.thrust[i] = k * omega[i] * omega[i];
                    load.torque[i] = c * load.thrust[i];
                    load.forward[i] = -h * omega[i].abs() * (flow[0][i] + rate[i] * z) * scale.forward[i];
                }
            }
            LaneRotor::Table(table) => {
                let [x, z] = self.hubs_m[group];
                let (mut airspeed, mut angle) = ([0.0; LANES], [0.0; LANES]);
                for i in 0..LANES {
                    let (u, w) = (flow[0][i] + rate[i] * z, flow[1][i] - rate[i] * x);
                    airspeed[i] = (u * u + w * w).sqrt();
                    angle[i] = atan2(w, u.abs());
                }
                load = table.load(omega, &airspeed, &angle);
            }
        }
        for i in 0..LANES {
            load.thrust[i] *= scale.thrust[i];
            load.torque[i] *= scale.torque[i];
        }
        load
    }

    /// Share of the full fluctuation in the vortex ring that the thrust of a rotor of a group has
    /// ([`inflow::ring_share`]), on a body as [`Self::load`] has it, at a density of the air [kg/m^3];
    /// nothing where the blades are not known.
    pub(super) fn ring_share(
        &self,
        group: usize,
        omega: &Lanes,
        flow: [&Lanes; 2],
        rate: &Lanes,
        (scale, density_kg_m3): (&LaneLoad, &Lanes),
    ) -> Lanes {
        let mut share = [0.0; LANES];
        let LaneRotor::Coefficients(Coefficients { radius_m, .. }) = &self.rotor else { return share };
        let load = self.load(group, omega, flow, rate, scale);
        let [x, z] = self.hubs_m[group];
        for i in 0..LANES {
            let v_h = (0.5 * load.thrust[i].abs() / (density_kg_m3[i] * (PI * radius_m * radius_m))).sqrt();
            if v_h > 0.0 {
                let (u, w) = (flow[0][i] + rate[i] * z, flow[1][i] - rate[i] * x);
                share[i] = inflow::ring_share(-w / v_h, u.abs() / v_h);
            }
        }
        share
    }

    /// Angular acceleration [rad/s^2] at a commanded speed, speed [rad/s] and torque of the air [N m].
    #[inline(always)]
    pub(super) fn acceleration(&self, omega_c: &Lanes, omega: &Lanes, torque: &Lanes) -> Lanes {
        let mut out = [0.0; LANES];
        match self.motor {
            LaneMotor::EscDc {
                k_t,
                k_e,
                k_esc,
                conductance,
                voltage_max,
                current: [low, high],
                per_inertia,
            } => {
                for i in 0..LANES {
                    let voltage = k_e * omega_c[i] + k_esc * (omega_c[i] - omega[i]);
                    let voltage = clip(voltage, 0.0, voltage_max);
                    let current = clip((voltage - k_e * omega[i]) * conductance, low, high);
                    out[i] = not_backwards((k_t * current - torque[i]) * per_inertia, omega[i]);
                }
            }
            LaneMotor::FirstOrder { per_tau_up, per_tau_down } => {
                for i in 0..LANES {
                    let difference = omega_c[i] - omega[i];
                    let per_tau = if difference > 0.0 { per_tau_up } else { per_tau_down };
                    out[i] = not_backwards(difference * per_tau, omega[i]);
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

impl LaneMotor {
    fn new(motor: &Motor) -> Self {
        match *motor {
            Motor::EscDc(m) => Self::EscDc {
                k_t: m.torque_constant_nm_a,
                k_e: m.back_emf_constant_v_s_rad,
                k_esc: m.esc_gain_v_s_rad,
                conductance: 1.0 / m.resistance_ohm,
                voltage_max: m.voltage_max_v,
                current: [m.current_min_a, m.current_max_a],
                per_inertia: 1.0 / m.rotor_inertia_kg_m2,
            },
            Motor::FirstOrder { tau_up_s, tau_down_s, .. } => {
                Self::FirstOrder { per_tau_up: 1.0 / tau_up_s, per_tau_down: 1.0 / tau_down_s }
            }
        }
    }
}

/// Left knots, counted from 0, and fractions of the intervals; clamped.
#[inline(always)]
fn locate(axis: &Axis, x: &Lanes) -> (Lanes, Lanes) {
    let last = axis.knots.len() - 2;
    let (mut left, mut fraction) = ([0.0; LANES], [0.0; LANES]);
    match axis.inverse_spacing {
        Some(inverse) => {
            for i in 0..LANES {
                let along = (x[i] - axis.knots[0]) * inverse;
                left[i] = interval(along, last as f64);
                fraction[i] = clip(along - left[i], 0.0, 1.0);
            }
        }
        // Past each knot in turn: the axes are short, and a search would go lane by lane.
        None => {
            let (mut from, mut to) = ([axis.knots[0]; LANES], [axis.knots[1]; LANES]);
            for (k, w) in axis.knots.windows(2).enumerate().skip(1) {
                for i in 0..LANES {
                    let past = w[0] <= x[i];
                    left[i] = if past { k as f64 } else { left[i] };
                    from[i] = if past { w[0] } else { from[i] };
                    to[i] = if past { w[1] } else { to[i] };
                }
            }
            for i in 0..LANES {
                fraction[i] = clip((x[i] - from[i]) / (to[i] - from[i]), 0.0, 1.0);
            }
        }
    }
    (left, fraction)
}

impl Table {
    fn new(table: &RotorTable) -> Self {
        let knots = table.knots();
        let edge = |w: &[[f64; 2]]| [w[0][0], w[0][1], w[1][0], w[1][1]];
        Self {
            axes: table.axes().map(Axis::clone),
            edges: table.cells().windows(2).map(edge).collect(),
            strides: [knots[1].len() * knots[2].len(), knots[2].len()],
        }
    }

    /// Thrust and torque at the table's density.
    #[inline(always)]
    fn load(&self, omega: &Lanes, airspeed: &Lanes, angle: &Lanes) -> LaneLoad {
        let (i_omega, a) = locate(&self.axes[0], omega);
        let (i_airspeed, b) = locate(&self.axes[1], airspeed);
        let (i_angle, c) = locate(&self.axes[2], angle);
        let [per_omega, per_airspeed] = self.strides;
        let mut at = [0; LANES];
        for i in 0..LANES {
            at[i] = index(i_omega[i] * per_omega as f64 + i_airspeed[i] * per_airspeed as f64 + i_angle[i]);
        }
        let mut mixed = [[0.0; 4]; LANES];
        for i in 0..LANES {
            let (low, high) = (at[i], at[i] + per_omega);
            let low = mix(&self.edges[low], &self.edges[low + per_airspeed], b[i]);
            let high = mix(&self.edges[high], &self.edges[high + per_airspeed], b[i]);
            mixed[i] = mix(&low, &high, a[i]);
        }
        let nothing = [0.0; LANES];
        let mut load = LaneLoad { thrust: nothing, torque: nothing, forward: nothing };
        for i in 0..LANES {
            let [t0, q0, t1, q1] = mixed[i];
            load.thrust[i] = t0 + c[i] * (t1 - t0);
            load.torque[i] = q0 + c[i] * (q1 - q0);
        }
        load
    }
}

impl Coefficients {
    fn new(table: &CoefficientTable) -> Self {
        let cells = table.cells().iter().map(|[t, h, q]| [*t, *h, *q, 0.0]).collect();
        Self { radius_m: table.radius_m(), cells }
    }

    /// Load at a density of 1 kg/m^3 of a rotor that pushes up and whose hub moves with `u` forward and `w`
    /// down through the air.
    #[inline(always)]
    fn load(&self, omega: &Lanes, u: &Lanes, w: &Lanes) -> LaneLoad {
        const ROW: usize = FLOW_STEPS + 1;
        let area = PI * self.radius_m * self.radius_m;
        let (mut a, mut b, mut scale) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let mut at = [0; LANES];
        for i in 0..LANES {
            // A stage of a step within which the rotor comes to rest.
            let turning = if omega[i] < 0.0 { 0.0 } else { omega[i] };
            let tip = turning * self.radius_m;
            let square = u[i] * u[i] + w[i] * w[i];
            let airspeed = square.sqrt();
            scale[i] = area * (tip * tip + square);
            let speed = airspeed / above_zero(airspeed + HALF_AT * tip) * SPEED_STEPS as f64;
            let flow = (w[i] / above_zero(w[i].abs() + u[i].abs()) + 1.0) * (FLOW_STEPS / 2) as f64;
            let left = interval(speed, (SPEED_STEPS - 1) as f64);
            let low = interval(flow, (FLOW_STEPS - 1) as f64);
            a[i] = clip(speed - left, 0.0, 1.0);
            b[i] = clip(flow - low, 0.0, 1.0);
            at[i] = index(left * ROW as f64 + low);
        }
        let mut load = LaneLoad { thrust: [0.0; LANES], torque: [0.0; LANES], forward: [0.0; LANES] };
        for i in 0..LANES {
            let (near, far) = (at[i], at[i] + ROW);
            let near = mix(&self.cells[near], &self.cells[near + 1], b[i]);
            let far = mix(&self.cells[far], &self.cells[far + 1], b[i]);
            let [thrust, in_plane, torque, _] = mix(&near, &far, a[i]);
            load.thrust[i] = scale[i] * thrust;
            load.forward[i] = scale[i] * in_plane * 1.0f64.copysign(-u[i]);
            load.torque[i] = scale[i] * self.radius_m * torque;
        }
        load
    }
}

/// The number, or the least positive one of full precision.
#[inline(always)]
fn above_zero(x: f64) -> f64 {
    if x > f64::MIN_POSITIVE { x } else { f64::MIN_POSITIVE }
}

#[inline(always)]
fn mix(x: &[f64; 4], y: &[f64; 4], s: f64) -> [f64; 4] {
    let mut out = [0.0; 4];
    for k in 0..4 {
        out[k] = x[k] + s * (y[k] - x[k]);
    }
    out
}
