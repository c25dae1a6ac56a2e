//! What a rotor gives and takes.

/// Thrust, torque and in-plane force of a rotor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorLoad<S = f64> {
    /// Thrust along the rotor's axis [N].
    pub thrust_n: S,
    /// Aerodynamic torque that brakes the rotor [N m].
    pub torque_nm: S,
    /// Force in the rotor's plane against the hub's motion in it [N]; zero for a rotor that has none.
    pub in_plane_n: S,
}
