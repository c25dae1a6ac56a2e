//! A rotor in hover, axial climb and slow descent by blade-element and momentum theory, against the table
//! that flies.
//!
//! The lander's table was made by these very equations (`rotor.table.about` in `params/vehicles/titan.json`).
//! So this does not check the theory, nor that the lander is like a real rotor: it checks that the file holds
//! what it says, and that the inflow's signs and angle, the scales of thrust and torque and the air's density
//! are right on the way from the file to a load in flight.
//!
//! With the climb ratio `x = V_c/v_h`, uniform inflow `lambda` and a blade without twist:
//!
//! ```text
//! C_T0 = sigma a/2 (theta/3 - lambda/2),   lambda = (x + v_i/v_h) sqrt(C_T0/2)
//! v_i/v_h = -x/2 + sqrt(x^2/4 + 1)                                        climb and hover, x >= 0
//! v_i/v_h = 1 - 1.125 x - 1.372 x^2 - 1.718 x^3 - 0.655 x^4               vortex ring state, -2 < x < 0
//! C_T  = C_T0 (1 - loss exp(-((x - x_v)/w)^2))
//! C_Q  = C_T (kappa v_i + V_c)/(Omega R) + sigma c_d0/8
//! ```
//!
//! Source: J. G. Leishman, *Principles of Helicopter Aerodynamics*, 2nd ed. (2006), 2.13 (climb and descent,
//! the quartic) and ch. 3 (blade elements). The loss in the vortex ring is the lander's own.

use std::f64::consts::PI;

use nalgebra::Vector3;

use super::{Check, CheckGroup};
use crate::math;
use crate::model::Rotor;
use crate::model::rotor::{HubMotion, RotorLoad};

/// Geometry and coefficients that a rotor's table was made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blades {
    /// Radius R of the rotor [m].
    pub radius_m: f64,
    /// Solidity sigma, blade area over disk area.
    pub solidity: f64,
    /// Slope of the lift coefficient a [1/rad].
    pub lift_slope: f64,
    /// Collective pitch theta [rad].
    pub collective_rad: f64,
    /// Drag coefficient c_d0 of the blade's profile.
    pub profile_drag: f64,
    /// Induced power factor kappa.
    pub induced_power: f64,
    /// Greatest loss of thrust in the vortex ring.
    pub vortex_ring_loss: f64,
    /// Climb ratio x_v at which the loss in the vortex ring is greatest.
    pub vortex_ring_at: f64,
    /// Width w of the vortex ring in climb ratio.
    pub vortex_ring_width: f64,
}

/// Blades of the notional lander: `rotor.table.about` in `params/vehicles/titan.json`.
pub const LANDER: Blades = Blades {
    radius_m: 0.65,
    solidity: 0.1,
    lift_slope: 5.7,
    collective_rad: 0.18,
    profile_drag: 0.012,
    induced_power: 1.15,
    vortex_ring_loss: 0.15,
    vortex_ring_at: -1.2,
    vortex_ring_width: 0.5,
};

impl Blades {
    /// Induced velocity over that of hover at the climb ratio `x`, above -2.
    fn induced_ratio(x: f64) -> f64 {
        if x >= 0.0 {
            (0.25 * x * x + 1.0).sqrt() - 0.5 * x
        } else {
            1.0 - x * (1.125 + x * (1.372 + x * (1.718 + 0.655 * x)))
        }
    }

    /// Induced velocity of the thrust in hover [m/s], in closed form: the root of `2 v^2 = sigma a/2 (theta/3
    /// - v/2)`, less what the vortex ring takes as far off as that.
    fn hover_induced_m_s(&self, omega_rad_s: f64) -> f64 {
        let b = 0.25 * self.solidity * self.lift_slope;
        let v = 0.25 * ((b * b + 16.0 * b * self.collective_rad / 3.0).sqrt() - b);
        let off = self.vortex_ring_at / self.vortex_ring_width;
        v * omega_rad_s * self.radius_m * (1.0 - self.vortex_ring_loss * math::exp(-off * off)).sqrt()
    }

    /// Thrust and torque at the rate of climb [m/s], negative in descent, above -2 v_h.
    pub fn load(&self, omega_rad_s: f64, climb_m_s: f64, density_kg_m3: f64) -> RotorLoad {
        let tip_m_s = omega_rad_s * self.radius_m;
        let climb = climb_m_s / tip_m_s;
        let inflow = |v_h: f64| climb + v_h * Self::induced_ratio(climb / v_h);
        let blade =
            |lambda: f64| 0.5 * self.solidity * self.lift_slope * (self.collective_rad / 3.0 - 0.5 * lambda);
        // Blades give less the greater the inflow, momentum theory more: one crossing.
        let (mut low, mut high) = (1e-6, 1.0);
        for _ in 0..200 {
            let v_h = 0.5 * (low + high);
            if blade(inflow(v_h)) > 2.0 * v_h * v_h { low = v_h } else { high = v_h }
        }
        let v_h = 0.5 * (low + high);
        let off = (climb / v_h - self.vortex_ring_at) / self.vortex_ring_width;
        let c_thrust = 2.0 * v_h * v_h * (1.0 - self.vortex_ring_loss * math::exp(-off * off));
        let induced = inflow(v_h) - climb;
        let c_torque =
            c_thrust * (self.induced_power * induced + climb) + self.solidity * self.profile_drag / 8.0;
        let scale_n = density_kg_m3 * PI * self.radius_m * self.radius_m * tip_m_s * tip_m_s;
        RotorLoad {
            thrust_n: scale_n * c_thrust,
            torque_nm: scale_n * self.radius_m * c_torque,
            in_plane_n: 0.0,
        }
    }
}

/// A speed [rad/s] that is a knot of the lander's table, where it does not interpolate.
const OMEGA_RAD_S: f64 = 105.0;
const FLIGHT: [(&str, f64); 5] = [
    ("hover", 0.0),
    ("climb, 2 m/s", 2.0),
    ("climb, 5 m/s", 5.0),
    ("descent, 2 m/s", -2.0),
    ("vortex ring, 6 m/s", -6.0),
];

/// The rotor of the lander in axial flight at 105 rad/s.
pub fn rotor(rotor: &Rotor, density_kg_m3: f64, blades: &Blades) -> CheckGroup {
    let up_body = -Vector3::z();
    let mut checks = Vec::new();
    for (name, climb_m_s) in FLIGHT {
        let inflow = HubMotion::of((up_body * climb_m_s).into(), &up_body).inflow();
        let flown = rotor.load(OMEGA_RAD_S, inflow, density_kg_m3);
        let theory = blades.load(OMEGA_RAD_S, climb_m_s, density_kg_m3);
        checks.push(Check::new(format!("{name}: thrust"), "N", flown.thrust_n, theory.thrust_n, 1e-9));
        checks.push(Check::new(format!("{name}: torque"), "N m", flown.torque_nm, theory.torque_nm, 1e-10));
    }
    let hover_n = rotor.static_load(OMEGA_RAD_S, density_kg_m3).thrust_n;
    let disk_kg_m = density_kg_m3 * PI * blades.radius_m * blades.radius_m;
    checks.push(Check::new(
        "induced velocity in hover",
        "m/s",
        (hover_n / (2.0 * disk_kg_m)).sqrt(),
        blades.hover_induced_m_s(OMEGA_RAD_S),
        1e-10,
    ));
    CheckGroup {
        title: "Lander's rotor in axial flight, 105 rad/s",
        source: "momentum theory and blade elements (Leishman 2006, 2.13, ch. 3), blades as titan.json tells them",
        checks,
    }
}
