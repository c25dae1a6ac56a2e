//! The riser: a spring with a damper that never pushes, from the canopy to the confluence point, which is
//! fixed to the vehicle.
//!
//! ```text
//! T = max(0, k (r - L) + c r_dot) where r > L, else 0
//! ```
//!
//! with r the distance from the canopy to the confluence point. The legs of the bridle, from there to the
//! vehicle, are taut and stiff, so that the point does not move in the body; a bridle whose legs go slack is
//! not modelled. The riser has no mass and no drag of its own.

use nalgebra::Vector3;

use super::super::rigid_body::{BodyState, Motion};
use super::super::{ModelError, check, check_positive};
use crate::frames::{Turn, rotate_ned_from_body};
use crate::real::{Mask as _, Real};
use crate::vector::V3;

/// A riser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Riser {
    /// Length without load, from the canopy to the confluence point [m].
    pub length_m: f64,
    /// Stiffness [N/m].
    pub stiffness_n_m: f64,
    /// Damping [N s/m].
    pub damping_n_s_m: f64,
    /// Confluence point, from the vehicle's centre of mass, body axes [m].
    pub attachment_body_m: Vector3<f64>,
}

/// Pull of a riser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pull<S = f64> {
    /// Tension, not below zero [N].
    pub tension_n: S,
    /// Force on the vehicle, NED [N]; that on the canopy is the opposite.
    pub force_ned: V3<S>,
    /// Moment on the vehicle about its centre of mass, body [N m].
    pub moment_body: V3<S>,
}

impl<S: Real> Pull<S> {
    /// No pull, for numbers of a kind of which one is given.
    #[inline(always)]
    pub fn none(kind: S) -> Self {
        let none = V3::zero(kind);
        Self { tension_n: none.x, force_ned: none, moment_body: none }
    }
}

impl Riser {
    /// Checks length [m], stiffness [N/m], damping [N s/m] and confluence point [m].
    ///
    /// # Errors
    /// [`ModelError`] when length or stiffness is not positive, the damping is negative, or the confluence
    /// point is not above the centre of mass.
    pub fn new(
        length_m: f64,
        stiffness_n_m: f64,
        damping_n_s_m: f64,
        attachment_body_m: Vector3<f64>,
    ) -> Result<Self, ModelError> {
        check_positive("riser length", length_m)?;
        check_positive("riser stiffness", stiffness_n_m)?;
        let damps = damping_n_s_m.is_finite() && damping_n_s_m >= 0.0;
        check(damps, "riser damping", "at least zero", damping_n_s_m)?;
        let above = attachment_body_m.iter().all(|x| x.is_finite()) && attachment_body_m.z < 0.0;
        let expected = "above the centre of mass (z, down, below zero)";
        check(above, "attachment of the riser", expected, attachment_body_m.z)?;
        Ok(Self { length_m, stiffness_n_m, damping_n_s_m, attachment_body_m })
    }

    /// What is left of the riser when it hangs by one leg of the bridle alone, fixed at a point of the
    /// vehicle, body axes [m]: it is longer by the leg, which is taut and stiff as all are.
    pub fn by_one_leg(&self, fixed_body_m: Vector3<f64>) -> Self {
        let leg_m = (fixed_body_m - self.attachment_body_m).norm();
        Self { length_m: self.length_m + leg_m, attachment_body_m: fixed_body_m, ..*self }
    }

    /// Position and velocity of the confluence point, NED [m, m/s].
    pub fn confluence(&self, body: &BodyState) -> (Vector3<f64>, Vector3<f64>) {
        let turned = |x: Vector3<f64>| rotate_ned_from_body(body.q_ned_from_body, x);
        (
            body.p_ned + turned(self.attachment_body_m),
            body.v_ned + turned(body.omega_body.cross(&self.attachment_body_m)),
        )
    }

    /// Pull on a vehicle at a place, NED [m], in this motion, and on a canopy of this position and velocity,
    /// NED [m, m/s].
    #[inline(always)]
    pub fn pull<S: Real>(&self, p_ned: V3<S>, motion: &Motion<S>, canopy: [V3<S>; 2]) -> Pull<S> {
        let none = Pull::none(p_ned.x);
        let attachment_body_m = V3::constant(p_ned.x, &self.attachment_body_m);
        let turn = Turn::of(motion.q_ned_from_body);
        let [canopy_p_ned, canopy_v_ned] = canopy;
        let span = p_ned + turn.to_ned(attachment_body_m) - canopy_p_ned;
        let distance_m = span.norm();
        let stretch_m = distance_m - self.length_m;
        let taut = none.tension_n.less(stretch_m);
        if !taut.any() {
            return none;
        }
        let v_ned = motion.v_ned + turn.to_ned(motion.omega_body.cross(attachment_body_m));
        let along = span / distance_m;
        let lengthens_m_s = along.dot(v_ned - canopy_v_ned);
        let tension_n =
            (stretch_m * self.stiffness_n_m + lengthens_m_s * self.damping_n_s_m).at_least(none.tension_n);
        let force_ned = along * -tension_n;
        let moment_body = attachment_body_m.cross(turn.to_body(force_ned));
        Pull {
            tension_n: S::select(taut, tension_n, none.tension_n),
            force_ned: V3::select(taut, force_ned, none.force_ned),
            moment_body: V3::select(taut, moment_body, none.moment_body),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::CanopyState;
    use super::*;
    use crate::frames::{LEVEL, quaternion_from_euler};

    fn pull_of(riser: &Riser, body: &BodyState, canopy: &CanopyState) -> Pull {
        riser.pull(body.p_ned.into(), &body.motion(), [canopy.p_ned.into(), canopy.v_ned.into()])
    }

    fn body(p_ned: [f64; 3], v_ned: [f64; 3]) -> BodyState {
        BodyState {
            p_ned: p_ned.into(),
            q_ned_from_body: LEVEL,
            v_ned: v_ned.into(),
            omega_body: Vector3::zeros(),
        }
    }

    fn canopy() -> CanopyState {
        CanopyState { p_ned: Vector3::zeros(), v_ned: Vector3::zeros() }
    }

    /// Spring and damper along the line, nothing when slack, never a push.
    #[test]
    fn closed_form_a_riser_pulls_along_its_line() {
        let riser = Riser::new(5.0, 100.0, 10.0, Vector3::new(0.0, 0.0, -1.0)).unwrap();
        let pull = pull_of(&riser, &body([0.0, 0.0, 6.5], [0.0; 3]), &canopy());
        assert_eq!((pull.tension_n, pull.force_ned), (50.0, V3::new(0.0, 0.0, -50.0)));
        assert_eq!(pull.moment_body, V3::zero(0.0));
        assert_eq!(pull_of(&riser, &body([0.0, 0.0, 6.5], [0.0, 0.0, 2.0]), &canopy()).tension_n, 70.0);
        assert_eq!(pull_of(&riser, &body([0.0, 0.0, 6.5], [0.0, 0.0, -20.0]), &canopy()).tension_n, 0.0);
        assert_eq!(pull_of(&riser, &body([0.0, 0.0, 5.5], [0.0, 0.0, 20.0]), &canopy()), Pull::none(0.0));
        // 3-4-5: the confluence point is at (3.6, 0, 4.8), 6 m away.
        let pull = pull_of(&riser, &body([3.6, 0.0, 5.8], [0.0; 3]), &canopy());
        assert!((pull.force_ned - V3::new(-60.0, 0.0, -80.0)).norm() < 1e-12, "{pull:?}");
        assert!((pull.moment_body - V3::new(0.0, 60.0, 0.0)).norm() < 1e-12, "{pull:?}");
    }

    /// The power of the pull is what spring and damper take up: `T r_dot`.
    #[test]
    fn closed_form_power_of_a_pull() {
        let riser = Riser::new(4.0, 300.0, 20.0, Vector3::new(0.3, -0.2, -1.0)).unwrap();
        let body = BodyState {
            q_ned_from_body: quaternion_from_euler(0.3, -0.4, 0.9),
            omega_body: Vector3::new(0.4, -0.7, 0.2),
            ..body([1.0, 0.5, 6.0], [0.3, -0.2, 0.4])
        };
        let canopy = CanopyState { v_ned: Vector3::new(0.1, 0.2, -0.3), ..canopy() };
        let pull = pull_of(&riser, &body, &canopy);
        let (p_ned, v_ned) = riser.confluence(&body);
        let r_dot = (p_ned - canopy.p_ned).normalize().dot(&(v_ned - canopy.v_ned));
        let power = pull.force_ned.along(&body.v_ned) + pull.moment_body.along(&body.omega_body)
            - pull.force_ned.along(&canopy.v_ned);
        assert!(pull.tension_n > 1.0 && (power + pull.tension_n * r_dot).abs() < 1e-10);
    }

    #[test]
    fn impossible_risers_are_refused() {
        let above = Vector3::new(0.0, 0.0, -1.0);
        assert!(Riser::new(0.0, 1.0, 0.0, above).is_err() && Riser::new(1.0, 0.0, 0.0, above).is_err());
        assert!(Riser::new(1.0, 1.0, -1.0, above).is_err() && Riser::new(1.0, 1.0, 0.0, -above).is_err());
        assert!(Riser::new(1.0, 1.0, 0.0, Vector3::new(0.0, 0.0, f64::NAN)).is_err());
        assert!(Riser::new(1.0, 1.0, 0.0, above).is_ok());
    }
}
