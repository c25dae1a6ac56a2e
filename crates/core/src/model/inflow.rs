//! Velocity that a rotor induces at its own disk, in climb, hover, descent and edgewise flow: momentum theory
//! where it holds, and the mean of what was measured where it does not, in the vortex ring.
//!
//! All velocities are in units of `v_h = sqrt(T/(2 rho A))`, the velocity that the same thrust induces in
//! hover. `V_z` is the disk's velocity through the air along the thrust (climb positive), `V_x` that in the
//! disk's plane, `v` the induced velocity, against the thrust.
//!
//! Momentum theory (Glauert): `v sqrt(V_x^2 + (V_z + v)^2) = 1`. It has up to three roots in descent; above
//! `V_z = -3/2` the greatest is taken (the air still goes down through the disk), below it the least, the
//! windmill brake. In between, inside `1.5 V_x^2 + (2 V_z + 3)^2 < 1`, stands Johnson's cubic
//! `v = V_z (0.373 V_z^2 + 0.598 V_x^2 - 1.991)`, which meets momentum theory on the axis.
//!
//! On this baseline comes the **vortex ring**: W. Johnson, *Model for Vortex Ring State Influence on
//! Rotorcraft Flight Dynamics*, NASA/TP-2005-213477, pp. 23-24. `V_z + v`, the flow through the disk, falls
//! on descending to 0.85 at N, then rises to 1.25 at X: thrust at a constant rotor speed goes the other way,
//! so between N and X heave is not damped. Cubics of `V_z` lead from the baseline at D through N and X to
//! the baseline at E:
//!
//! ```text
//! on the axis      D -0.2   N -0.45, V_z + v = 0.85   X -1.5, V_z + v = 1.25   E -2
//! N(V_x) = -0.975 + 0.525 (1 - (V_x/0.95)^2)^0.2      X(V_x) = -0.975 - 0.525 (1 - (V_x/0.95)^2)^1.5
//! E(V_x) = -2 + (X(V_x) - X(0))                       increments at N and X times (1 - (V_x/0.95)^6)^0.5
//! ```
//!
//! The report itself was not at hand: points, exponents and matching conditions are those that LADAC (TU
//! Braunschweig, `inducedVelocityVortexRingState.m`) quotes from those pages.

use crate::math;
use crate::real::{Mask as _, Real};

/// Edgewise velocity beyond which there is no vortex ring, `V_xM`.
pub const RING_ENDS_AT: f64 = 0.95;
const D: f64 = -0.2;
const N: f64 = -0.45;
const X: f64 = -1.5;
const E: f64 = -2.0;
const THROUGH_AT_N: f64 = 0.85;
const THROUGH_AT_X: f64 = 1.25;

/// The climb velocities N and X between which heave is not damped at an edgewise velocity, both in units of
/// `v_h`, the higher first; `None` from [`RING_ENDS_AT`] on.
pub fn vortex_ring(in_plane: f64) -> Option<[f64; 2]> {
    let (exists, between) = ring_between(in_plane);
    exists.then_some(between)
}

/// Whether there is a vortex ring at an edgewise velocity, and between which climb velocities, over any
/// [`Real`].
#[inline(always)]
fn ring_between<S: Real>(in_plane: S) -> (S::Mask, [S; 2]) {
    let one = in_plane.of(1.0);
    let share = in_plane / one.of(RING_ENDS_AT);
    let left = one - share * share;
    let exists = one.of(0.0).less(left);
    let left = S::select(exists, left, one);
    let (middle, half) = (one.of(0.5 * (N + X)), 0.5 * (N - X));
    // left^0.2, left^1.5
    let fifth_root = (left.ln() * -0.2).exp_of_minus();
    (exists, [middle + fifth_root * half, middle - left * left.sqrt() * half])
}

/// Whether a disk that moves along its thrust at `climb` and in its plane at `in_plane`, both in units of
/// `v_h`, is in the vortex ring: inside Johnson's stability boundary, between N and X.
#[inline(always)]
pub fn is_in_vortex_ring<S: Real>(climb: S, in_plane: S) -> S::Mask {
    let near = climb.of(X).less(climb) & climb.less(climb.of(N));
    if !near.any() {
        return near;
    }
    let (exists, [n, x]) = ring_between(in_plane);
    near & exists & x.less(climb) & climb.less(n)
}

/// Distance inside the stability boundary over which the fluctuation of a rotor's thrust comes up, in units
/// of `v_h`: a choice, so that nothing jumps at the boundary.
pub const RING_RISE: f64 = 0.1;

/// Share of the full fluctuation in the vortex ring that the thrust of a disk has which moves along its
/// thrust at `climb` and in its plane at `in_plane`, both in units of `v_h`: 0 outside N to X, rising
/// linearly over [`RING_RISE`] inside, 1 beyond.
#[inline(always)]
pub fn ring_share<S: Real>(climb: S, in_plane: S) -> S {
    let (zero, one) = (climb.of(0.0), climb.of(1.0));
    let near = climb.of(X).less(climb) & climb.less(climb.of(N));
    if !near.any() {
        return zero;
    }
    let (exists, [n, x]) = ring_between(in_plane);
    let inside = (n - climb).at_most(climb - x) / zero.of(RING_RISE);
    S::select(near & exists, inside.at_least(zero).at_most(one), zero)
}

/// Induced velocity of a disk that moves along its thrust at `climb` and in its plane at `in_plane`, all in
/// units of `v_h`.
pub fn induced(climb: f64, in_plane: f64) -> f64 {
    baseline(climb, in_plane).0 + vortex_ring_increment(climb, in_plane)
}

/// Induced velocity without the vortex ring, and its derivative with the climb.
fn baseline(climb: f64, in_plane: f64) -> (f64, f64) {
    let (z2, x2) = (climb * climb, in_plane * in_plane);
    let descent = 2.0 * climb + 3.0;
    if 1.5 * x2 + descent * descent < 1.0 {
        return (climb * (0.373 * z2 + 0.598 * x2 - 1.991), 1.119 * z2 + 0.598 * x2 - 1.991);
    }
    let v = momentum(climb, in_plane);
    let through = climb + v;
    (v, -v * through / (x2 + through * through + v * through))
}

/// Induced velocity by momentum theory.
fn momentum(climb: f64, in_plane: f64) -> f64 {
    let x2 = in_plane * in_plane;
    let excess = |v: f64| v * v * (x2 + (climb + v) * (climb + v)) - 1.0;
    // `excess` rises from -1 at 0, but for a fall between two turning points in descent.
    let (mut low, mut high) = (0.0, 1.0 - climb.min(0.0));
    let spread = climb * climb - 8.0 * x2;
    if climb < 0.0 && spread > 0.0 {
        let spread = spread.sqrt();
        let [first, second] = [0.25 * (climb - spread) - climb, 0.25 * (climb + spread) - climb];
        let [peak, trough] = [excess(first), excess(second)];
        if peak >= 0.0 && (climb <= X || trough >= 0.0) {
            high = first;
        } else {
            low = second;
        }
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if excess(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// What the vortex ring adds to the induced velocity.
fn vortex_ring_increment(climb: f64, in_plane: f64) -> f64 {
    let Some([n, x]) = vortex_ring(in_plane) else { return 0.0 };
    let e = E + (x - X);
    if !(e < climb && climb < D) {
        return 0.0;
    }
    let share = in_plane / RING_ENDS_AT;
    let fading = (1.0 - math::powf(share, 6.0)).sqrt();
    // The increment at N or X and its slope there, so that `V_z + v` has an extreme.
    let at = |point: f64, on_axis: f64, through: f64| {
        let increment = through - (on_axis + baseline(on_axis, 0.0).0);
        (increment * fading, -(1.0 + baseline(point, in_plane).1))
    };
    if climb >= n {
        cubic(climb, [D, n], (0.0, 0.0), at(n, N, THROUGH_AT_N))
    } else if climb >= x {
        cubic(climb, [n, x], at(n, N, THROUGH_AT_N), at(x, X, THROUGH_AT_X))
    } else {
        // `b V_z + c V_z^2 + d V_z^3` with value and slope at X, and zero at E: divided by V_z a parabola.
        let (at_x, slope) = at(x, X, THROUGH_AT_X);
        let (value, turn) = (at_x / x, (slope - at_x / x) / x);
        let span = e - x;
        let bend = (-value - turn * span) / (span * span);
        let along = climb - x;
        climb * (value + along * (turn + along * bend))
    }
}

/// Hermite's cubic between two points with a value and a slope each.
fn cubic(x: f64, [x0, x1]: [f64; 2], (y0, s0): (f64, f64), (y1, s1): (f64, f64)) -> f64 {
    let h = x1 - x0;
    let t = (x - x0) / h;
    let u = 1.0 - t;
    u * u * (y0 * (1.0 + 2.0 * t) + h * s0 * t) + t * t * (y1 * (1.0 + 2.0 * u) - h * s1 * u)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Momentum theory on the axis: climb and hover, and the windmill brake.
    #[test]
    fn closed_form_axial_flight() {
        for climb in [0.0, 0.3, 1.0, 4.0, 50.0] {
            let v: f64 = induced(climb, 0.0);
            assert!((v - ((0.25 * climb * climb + 1.0).sqrt() - 0.5 * climb)).abs() < 1e-14, "{climb}: {v}");
        }
        for climb in [-2.001f64, -2.5, -4.0, -50.0] {
            let v = induced(climb, 0.0);
            assert!((v + 0.5 * climb + (0.25 * climb * climb - 1.0).sqrt()).abs() < 1e-14, "{climb}: {v}");
        }
    }

    /// The report's points on the axis, and extremes of `V_z + v` at N and X, where the damping of heave
    /// changes its sign.
    #[test]
    fn reference_johnsons_points() {
        let through = |climb: f64| climb + induced(climb, 0.0);
        assert!((through(-0.45) - 0.85).abs() < 1e-14);
        assert!((through(-1.5) - 1.25).abs() < 1e-14);
        let slope = |climb: f64| (through(climb + 1e-5) - through(climb - 1e-5)) / 2e-5;
        assert!(slope(-0.45).abs() < 1e-4 && slope(-1.5).abs() < 1e-3, "{} {}", slope(-0.45), slope(-1.5));
        for (climb, rises) in [(-0.3, true), (-0.6, false), (-1.4, false), (-1.6, true), (-1.9, true)] {
            assert_eq!(slope(climb) > 0.0, rises, "{climb}");
        }
        assert_eq!(
            vortex_ring(0.0).map(|[n, x]| [n, x].map(|v| (v * 1e12).round() / 1e12)),
            Some([-0.45, -1.5])
        );
        assert_eq!(vortex_ring(0.95), None);
        let [n, x] = vortex_ring(0.949_999_999).unwrap();
        assert!((n - x).abs() < 0.02 && (n + 0.975).abs() < 0.02, "{n} {x}");
        assert!(
            is_in_vortex_ring(-1.0, 0.5) && !is_in_vortex_ring(-0.4, 0.0) && !is_in_vortex_ring(-1.0, 0.95)
        );
    }

    /// Thrust fluctuates inside Johnson's boundary only: nothing at N, X and beyond the greatest edgewise
    /// velocity, half of it half way up the rise, all of it in the middle.
    #[test]
    fn closed_form_thrust_fluctuates_inside_the_ring_only() {
        for (climb, in_plane, share) in [
            (0.5, 0.0, 0.0),
            (-0.449, 0.0, 0.0),
            (-0.5, 0.0, 0.5),
            (-0.55, 0.0, 1.0),
            (-1.0, 0.3, 1.0),
            (-1.45, 0.0, 0.5),
            (-1.501, 0.0, 0.0),
            (-2.5, 0.0, 0.0),
            (-0.975, 0.95, 0.0),
            (-0.975, 2.0, 0.0),
        ] {
            let found = ring_share(climb, in_plane);
            assert!((found - share).abs() < 1e-12, "{climb} {in_plane}: {found}");
            assert_eq!(
                found > 1e-12,
                is_in_vortex_ring(climb, in_plane) && share > 0.0,
                "{climb} {in_plane}"
            );
        }
    }

    /// Where the ring and Johnson's cubic end, the induced velocity goes on: exactly at D and E, within 0.02
    /// at the cubic's rim on the axis, within 0.07 all around it.
    #[test]
    fn closed_form_the_pieces_meet() {
        for in_plane in [0.0, 0.3, 0.6, 0.9] {
            let shift = vortex_ring(in_plane).map_or(0.0, |[_, x]| x - X);
            for at in [D, E + shift, vortex_ring(in_plane).unwrap()[0], vortex_ring(in_plane).unwrap()[1]] {
                let jump =
                    vortex_ring_increment(at + 1e-9, in_plane) - vortex_ring_increment(at - 1e-9, in_plane);
                assert!(jump.abs() < 1e-6, "{at} {in_plane}: {jump}");
            }
        }
        for k in 0..=200 {
            let angle = f64::from(k) * std::f64::consts::PI / 200.0;
            let (sin, cos) = math::sin_cos(angle);
            let rim = |r: f64| baseline(-1.5 + 0.5 * r * cos, r * sin / 1.5f64.sqrt()).0;
            let jump = rim(1.0 + 1e-9) - rim(1.0 - 1e-9);
            assert!(jump.abs() < if sin < 1e-6 { 0.02 } else { 0.07 }, "{angle}: {jump}");
        }
    }

    proptest! {
        /// Outside ring and cubic the induced velocity satisfies momentum theory.
        #[test]
        fn prop_momentum_theory_holds_where_it_should(climb in -6.0f64..6.0, in_plane in 0.0f64..6.0) {
            let v = induced(climb, in_plane);
            prop_assert!(v > 0.0 && v < 2.8, "{v}");
            let descent = 2.0 * climb + 3.0;
            if in_plane >= RING_ENDS_AT || !(-2.2..=D).contains(&climb) {
                prop_assert!(1.5 * in_plane * in_plane + descent * descent >= 1.0);
                let flow = (in_plane * in_plane + (climb + v) * (climb + v)).sqrt();
                prop_assert!((v * flow - 1.0).abs() < 1e-12, "{}", v * flow);
            }
        }
    }
}
