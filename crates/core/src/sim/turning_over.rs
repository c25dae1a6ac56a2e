//! Whether a flight has turned over.
//!
//! It has once its up axis, which had gone below the horizon on one side, is below it on the other side: it
//! has passed beneath. In the vertical plane that is a pitch beyond 180 deg, either way. A vehicle that leans
//! past the horizon and comes back the way it went has not turned over. This is a definition of samara's: the
//! paper's flights stay upright.

use nalgebra::Vector3;

use crate::frames::{Quaternion, rotate_ned_from_body};

/// Follows the attitudes of a flight in order of time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TurningOver {
    /// The side, north and east, on which the up axis was first below the horizon; `None` above it.
    side: Option<[f64; 2]>,
    over: bool,
}

impl TurningOver {
    /// Takes the next attitude, at most a quarter of a turn from the one before; whether the flight has
    /// turned over by then.
    pub fn observe(&mut self, q_ned_from_body: Quaternion) -> bool {
        let up_ned = rotate_ned_from_body(q_ned_from_body, -Vector3::z());
        if up_ned.z > 0.0 {
            let [north, east] = *self.side.get_or_insert([up_ned.x, up_ned.y]);
            self.over |= up_ned.x * north + up_ned.y * east < 0.0;
        } else {
            self.side = None;
        }
        self.over
    }

    /// Whether the up axis was above the horizon at the last attitude.
    pub(super) fn was_upright(&self) -> bool {
        self.side.is_none()
    }

    /// Whether the flight has turned over so far.
    pub fn is_over(&self) -> bool {
        self.over
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::frames::quaternion_from_euler;
    use crate::math;
    use crate::units::RAD_PER_DEG;

    fn turned_over(attitudes: impl IntoIterator<Item = Quaternion>) -> bool {
        let mut course = TurningOver::default();
        attitudes.into_iter().fold(false, |_, q| course.observe(q))
    }

    fn pitched(to_deg: i32) -> impl Iterator<Item = Quaternion> {
        let step = to_deg.signum();
        (0..=to_deg.abs()).map(move |k| quaternion_from_euler(0.0, f64::from(k * step) * RAD_PER_DEG, 0.0))
    }

    /// In the plane a flight has turned over where its pitch passes 180 deg, and stays so through any number
    /// of turns; one that comes back before has not.
    #[test]
    fn closed_form_in_the_plane_it_is_a_pitch_beyond_half_a_turn() {
        for (to_deg, wanted) in
            [(80, false), (179, false), (181, true), (-179, false), (-181, true), (350, true), (800, true)]
        {
            assert_eq!(turned_over(pitched(to_deg)), wanted, "{to_deg}");
        }
        let back: Vec<_> = pitched(179).collect();
        assert!(!turned_over(back.iter().chain(back.iter().rev()).copied()));
    }

    /// A turn about any level axis, under any heading: what counts is where the up axis goes.
    #[test]
    fn prop_it_does_not_depend_on_the_heading() {
        for heading in 0..12 {
            for (most, wanted) in [(0.97, false), (1.03, true)] {
                let (sin, cos) = math::sin_cos(f64::from(heading) * PI / 6.0);
                let about = |angle: f64| {
                    let (s, c) = math::sin_cos(0.5 * angle);
                    [c, s * cos, s * sin, 0.0]
                };
                let course = (0..=100).map(|k| about(f64::from(k) * 0.01 * most * PI));
                assert_eq!(turned_over(course), wanted, "{heading} {most}");
            }
        }
    }
}
