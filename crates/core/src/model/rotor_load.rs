//! What a rotor gives and takes.

/// Thrust, torque and in-plane force of a rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorLoad {
    /// Thrust along the rotor's axis [N].
    pub thrust_n: f64,
    /// Aerodynamic torque that brakes the rotor [N m].
    pub torque_nm: f64,
    /// Force in the rotor's plane against the hub's motion in it [N]; zero for a rotor that has none.
    pub in_plane_n: f64,
}
