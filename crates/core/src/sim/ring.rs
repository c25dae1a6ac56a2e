//! Fluctuation of rotors' thrusts in the vortex ring, in six degrees of freedom: [`crate::model::wind`] draws
//! it, where a rotor is decides how much of it there is, and both are held within a step of the simulation.

use crate::model::environment::Ambient;
use crate::model::rigid_body::Motion;
use crate::model::vehicle::Fluctuates;
use crate::model::{DiskState, MAX_ROTORS, Vehicle};
use crate::real::Real;

/// Fluctuation of thrusts over a step of the simulation, which holds what its beginning makes of it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Fluctuation<S> {
    /// Thrusts are at their means.
    None,
    /// Deviations of thrusts well inside the ring are drawn, [`WindCourse::ring_deviations`]; with `mirrored`
    /// the mirror images of a rotor deviate alike, by the mean of what as many of them would do.
    ///
    /// [`WindCourse::ring_deviations`]: crate::model::wind::WindCourse::ring_deviations
    Drawn {
        /// Deviation of each draw, in shares of the mean.
        drawn: [S; MAX_ROTORS],
        /// Whether mirror images deviate alike.
        mirrored: bool,
    },
    /// Deviations of the thrusts, in shares of their means.
    Found([S; MAX_ROTORS]),
}

impl<S> Fluctuation<S> {
    /// Of what was drawn, of rotors that are free, or locked: those do not feel it.
    pub(super) fn of(drawn: [S; MAX_ROTORS], mirrored: bool, free: bool) -> Self {
        if free { Self::Drawn { drawn, mirrored } } else { Self::None }
    }
}

impl<S: Real> Fluctuates<S> for Fluctuation<S> {
    #[inline(always)]
    fn deviations(
        &mut self,
        vehicle: &Vehicle,
        ambient: &Ambient<S>,
        motion: &Motion<S>,
        mean_n: &[S; MAX_ROTORS],
    ) -> Option<&[S; MAX_ROTORS]> {
        if let Self::Drawn { drawn, mirrored } = self {
            *self = Self::Found(deviations(drawn, *mirrored, vehicle, ambient, motion, mean_n));
        }
        match self {
            Self::Found(deviations) => Some(deviations),
            _ => None,
        }
    }
}

/// Shares of their means [N] by which the thrusts of a vehicle in this motion deviate, of what was drawn.
#[inline(always)]
fn deviations<S: Real>(
    drawn: &[S; MAX_ROTORS],
    mirrored: bool,
    vehicle: &Vehicle,
    ambient: &Ambient<S>,
    motion: &Motion<S>,
    mean_n: &[S; MAX_ROTORS],
) -> [S; MAX_ROTORS] {
    let mut deviations = [mean_n[0].of(0.0); MAX_ROTORS];
    let Some(disks) = DiskState::of_each(vehicle, ambient, motion, mean_n) else { return deviations };
    for (i, deviation) in deviations.iter_mut().enumerate().take(vehicle.rotors.len()) {
        let (draw, of_mean) = if mirrored { draw_of_mirror_images(vehicle, i) } else { (i, 1.0) };
        *deviation = disks[i].ring_share() * of_mean * drawn[draw];
    }
    deviations
}

/// Number of the draw that rotor `i` (from 0) shares with its mirror images, the first one's, and the
/// standard deviation of the mean of as many draws as they are.
fn draw_of_mirror_images(vehicle: &Vehicle, i: usize) -> (usize, f64) {
    let size = vehicle.rotors.iter().map(|r| r.position_body_m.amax()).fold(0.0, f64::max);
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * size;
    let alike = |j: usize| {
        let (a, b) = (&vehicle.rotors[i], &vehicle.rotors[j]);
        let (p, q) = (a.position_body_m, b.position_body_m);
        near(p.x, q.x) && near(p.z, q.z) && a.interference == b.interference
    };
    let mut images = (0..vehicle.rotors.len()).filter(|j| alike(*j));
    let first = images.next().unwrap_or(i);
    (first, 1.0 / ((1 + images.count()) as f64).sqrt())
}
