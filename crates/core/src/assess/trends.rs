//! What section V.A says of a campaign in words, as numbers: how J_TPF hangs on pitch and pitch rate at the
//! release, and how far the trials' velocities lie apart there and at the end.

use super::outcome::Outcome;
use super::statistics::{Share, Summary};
use crate::frames::pitch;
use crate::model::rigid_body::BodyState;

/// Side of zero on which a pitch or a pitch rate lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Below zero: nose down.
    Negative,
    /// Above zero: nose up.
    Positive,
}

impl Side {
    /// The side of a number; none of zero and of what is no number.
    fn of(x: f64) -> Option<Self> {
        if x < 0.0 {
            Some(Self::Negative)
        } else if x > 0.0 {
            Some(Self::Positive)
        } else {
            None
        }
    }
}

/// J_TPF by the release, and velocities at release and end, of a campaign. Nothing is kept of a trial.
#[derive(Clone, Copy, Debug)]
pub struct ReleaseTrends {
    pitch_beyond_rad: f64,
    rate_beyond_rad_s: f64,
    all: Summary,
    /// By side of the pitch, then of the pitch rate.
    quarters: [[Summary; 2]; 2],
    beyond_pitch: Summary,
    beyond_rate: Summary,
    /// North, east, down, as below.
    release_v: [Summary; 3],
    end_v: [Summary; 3],
    steady: Share,
}

impl ReleaseTrends {
    /// Trends of no trial yet, with the sizes of pitch [rad] and pitch rate [rad/s] beyond which a release is
    /// counted apart.
    pub fn new(pitch_beyond_rad: f64, rate_beyond_rad_s: f64) -> Self {
        Self {
            pitch_beyond_rad,
            rate_beyond_rad_s,
            all: Summary::default(),
            quarters: Default::default(),
            beyond_pitch: Summary::default(),
            beyond_rate: Summary::default(),
            release_v: Default::default(),
            end_v: Default::default(),
            steady: Share::default(),
        }
    }

    /// Takes the next trial: its state at t = 0, and what came of it.
    pub fn push(&mut self, release: &BodyState, outcome: &Outcome) {
        let (pitch, rate, j_tpf) = (pitch(release.q_ned_from_body), release.omega_body.y, outcome.j_tpf);
        self.all.push(j_tpf);
        if let (Some(pitch), Some(rate)) = (Side::of(pitch), Side::of(rate)) {
            self.quarters[pitch as usize][rate as usize].push(j_tpf);
        }
        if pitch.abs() > self.pitch_beyond_rad {
            self.beyond_pitch.push(j_tpf);
        }
        if rate.abs() > self.rate_beyond_rad_s {
            self.beyond_rate.push(j_tpf);
        }
        for (parts, v_ned) in [(&mut self.release_v, release.v_ned), (&mut self.end_v, outcome.final_v_ned())]
        {
            parts.iter_mut().zip(v_ned.iter()).for_each(|(part, v)| part.push(*v));
        }
        self.steady.push(outcome.steady_after_s.is_some());
    }

    /// J_TPF of all trials.
    pub fn all(&self) -> &Summary {
        &self.all
    }

    /// J_TPF of the releases in a quarter of the plane of pitch and pitch rate. Releases on an axis are in
    /// none.
    pub fn quarter(&self, pitch: Side, rate: Side) -> &Summary {
        &self.quarters[pitch as usize][rate as usize]
    }

    /// J_TPF of the releases with a pitch on a side.
    pub fn pitch_side(&self, pitch: Side) -> Summary {
        self.quarter(pitch, Side::Negative).joined(self.quarter(pitch, Side::Positive))
    }

    /// J_TPF of the releases with a pitch rate on a side.
    pub fn rate_side(&self, rate: Side) -> Summary {
        self.quarter(Side::Negative, rate).joined(self.quarter(Side::Positive, rate))
    }

    /// J_TPF of the releases whose pitch is beyond the given size, either way.
    pub fn beyond_pitch(&self) -> &Summary {
        &self.beyond_pitch
    }

    /// J_TPF of the releases whose pitch rate is beyond the given size, either way.
    pub fn beyond_rate(&self) -> &Summary {
        &self.beyond_rate
    }

    /// Variance of the velocity at t = 0 among the trials [m^2/s^2]: the sum of its components' variances
    /// over ground, each with n - 1; the mean square of the distance from the mean velocity.
    pub fn variance_at_release(&self) -> f64 {
        variance(&self.release_v)
    }

    /// [`Self::variance_at_release`] of the velocity at the flights' end.
    pub fn variance_at_end(&self) -> f64 {
        variance(&self.end_v)
    }

    /// Mean velocity at the flights' end, NED [m/s].
    pub fn mean_end_v_ned(&self) -> [f64; 3] {
        self.end_v.map(|part| part.mean())
    }

    /// How many flights are steady at their end: at the target velocity to within what is called steady.
    pub fn steady(&self) -> Share {
        self.steady
    }
}

fn variance(parts: &[Summary; 3]) -> f64 {
    parts.iter().map(|part| part.std() * part.std()).sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::Side::{Negative, Positive};
    use super::*;
    use crate::frames::quaternion_from_euler;

    /// Pitch [rad], pitch rate [rad/s], J_TPF, velocity at the release and at the end [m/s].
    type Trial = (f64, f64, f64, [f64; 3], [f64; 3]);

    fn trends(trials: &[Trial]) -> ReleaseTrends {
        let mut trends = ReleaseTrends::new(0.07, 0.14);
        for (pitch, rate, j_tpf, release, end) in trials {
            let state = BodyState {
                p_ned: Vector3::zeros(),
                q_ned_from_body: quaternion_from_euler(0.0, *pitch, 0.0),
                v_ned: Vector3::from(*release),
                omega_body: Vector3::new(0.0, *rate, 0.0),
            };
            let steady_after_s = (*j_tpf < 0.65).then_some(1.0);
            let outcome = Outcome { j_tpf: *j_tpf, steady_after_s, ..Outcome::default() };
            trends.push(&state, &outcome.with_final_v(Vector3::from(*end)));
        }
        trends
    }

    /// Four releases, one in each quarter, and one on the axes, with J_TPF of round means: by hand.
    #[test]
    fn closed_form_means_by_quarter_and_side() {
        let at = |pitch, rate, j_tpf| (pitch, rate, j_tpf, [0.0; 3], [0.0; 3]);
        let t = trends(&[
            at(-0.1, 0.1, 0.5),
            at(-0.1, 0.2, 0.7),
            at(-0.05, -0.2, 0.9),
            at(0.05, -0.1, 0.4),
            at(0.1, 0.1, 0.6),
            at(0.0, 0.0, 0.5),
        ]);
        let near = |x: f64, y: f64| assert!((x - y).abs() < 1e-15, "{x} against {y}");
        near(t.all().mean(), 0.6);
        near(t.quarter(Negative, Positive).mean(), 0.6);
        near(t.quarter(Positive, Negative).mean(), 0.4);
        near(t.pitch_side(Negative).mean(), 0.7);
        near(t.rate_side(Negative).mean(), 0.65);
        near(t.rate_side(Positive).mean(), 0.6);
        near(t.beyond_pitch().mean(), 0.6);
        near(t.beyond_rate().mean(), 0.8);
        assert_eq!((t.rate_side(Positive).count(), t.steady().hits()), (3, 4));
    }

    /// A square of half the side a about the mean, and half as large at the end: 8/3 a^2, and a quarter.
    #[test]
    fn closed_form_variances_of_the_velocity() {
        let a = 0.3;
        let corners = [[a, 0.0, a], [a, 0.0, -a], [-a, 0.0, a], [-a, 0.0, -a]];
        let moved = |v: [f64; 3], by: f64| [4.0 + by * v[0], 0.0, 3.7 + by * v[2]];
        let t = trends(&corners.map(|v| (0.1, 0.1, 0.6, moved(v, 1.0), moved(v, 0.5))));
        assert!((t.variance_at_release() - 8.0 / 3.0 * a * a).abs() < 1e-14);
        assert!((t.variance_at_release() / t.variance_at_end() - 4.0).abs() < 1e-12);
        let [north, east, down] = t.mean_end_v_ned();
        assert!((north - 4.0).abs() < 1e-15 && east == 0.0 && (down - 3.7).abs() < 1e-15);
    }
}
