//! How strong turbulence is and how large its eddies are.

use std::sync::Arc;

use super::dryden::{Draw, Longitudinal, Noise, Step, Transverse};
use super::given::GivenNoise;
use crate::random::{Purpose, Stream};
use crate::real::straight::{exp_of_minus, ln};

/// Turbulence in Dryden's form.
#[derive(Clone, Debug, PartialEq)]
pub struct Turbulence {
    /// Standard deviations of the air's velocity along the mean wind at the site's altitude, across it and
    /// vertically [m/s].
    pub sigma_m_s: [f64; 3],
    /// Scale lengths of the eddies.
    pub scale: TurbulenceScale,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Whether that is the mission's, and another one's where a mission is given another.
    pub follows_mission: bool,
    /// Random numbers given instead of drawn, [`Draw`] by step of the simulation.
    pub noise: Option<Arc<[Draw]>>,
}

/// Scale lengths of turbulence, longitudinal, lateral, vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TurbulenceScale {
    /// Given [m].
    Fixed([f64; 3]),
    /// By height above ground h [ft]: `L_w = h`, `L_u = L_v = h/(0.177 + 0.000823 h)^1.2` from 10 to 1000 ft
    /// (MIL-F-8785C, 3.7.3.1), linear from there to the free atmosphere at 2000 ft.
    LowAltitude,
    /// 1750 ft, all three (MIL-F-8785C, 3.7.2.3).
    FreeAtmosphere,
}

const M_PER_FT: f64 = 0.3048;
const FREE_FT: f64 = 1750.0;

impl TurbulenceScale {
    /// Scale lengths [m] at a height above ground [m].
    pub fn at_height_m(self, height_m: f64) -> [f64; 3] {
        match self {
            Self::Fixed(scale_m) => scale_m,
            Self::FreeAtmosphere => [FREE_FT * M_PER_FT; 3],
            Self::LowAltitude => {
                let h = (height_m / M_PER_FT).clamp(10.0, 2000.0);
                let low = h.min(1000.0);
                let along = low / exp_of_minus(-1.2 * ln(0.177 + 0.000_823 * low));
                let share = ((h - 1000.0) / 1000.0).max(0.0);
                [along, along, low].map(|l| (l + share * (FREE_FT - l)) * M_PER_FT)
            }
        }
    }
}

/// The turbulence of `N` flights side by side; none where its standard deviation is zero.
#[derive(Clone, Debug)]
pub struct Eddies<const N: usize> {
    along: Option<Longitudinal<N>>,
    across: Option<Transverse<N>>,
    vertical: Option<Transverse<N>>,
}

impl Turbulence {
    /// Turbulence of the same standard deviation along each axis [m/s] and of one scale length [m] at every
    /// height, drawn by the mission's seed.
    pub fn isotropic(sigma_m_s: f64, scale_m: f64, seed: u64) -> Self {
        let scale = TurbulenceScale::Fixed([scale_m; 3]);
        Self { sigma_m_s: [sigma_m_s; 3], scale, seed, follows_mission: true, noise: None }
    }

    /// The turbulence of flights of these numbers at its beginning: each has its own draw of a seed, or is
    /// driven by what is `given` for its number; noise from a file is the same for all.
    pub fn eddies<const N: usize>(&self, numbers: [u64; N], given: Option<&GivenNoise>) -> Eddies<N> {
        let noise = |axis: u32, places: [usize; 2]| {
            if let Some(rows) = &self.noise {
                let columns = places.map(|place| rows.iter().map(|row| row[place]).collect::<Arc<[f64]>>());
                Noise::Given { columns: Box::new([(); N].map(|()| columns.clone())), next: 0 }
            } else if let Some(given) = given {
                Noise::Given {
                    columns: Box::new(numbers.map(|number| given.turbulence(number, places))),
                    next: 0,
                }
            } else {
                let stream = |number| Stream::of_part(self.seed, Purpose::Turbulence, axis, number);
                Noise::Drawn(Box::new(numbers.map(stream)))
            }
        };
        let [along, across, vertical] = self.sigma_m_s.map(|sigma| sigma != 0.0);
        Eddies {
            along: along.then(|| Longitudinal::new(noise(0, [0, 0]))),
            across: across.then(|| Transverse::new(noise(1, [1, 2]))),
            vertical: vertical.then(|| Transverse::new(noise(2, [3, 4]))),
        }
    }
}

impl<const N: usize> Eddies<N> {
    /// The eddies of flights side by side, each where it is; `None` where they cannot be.
    pub fn abreast(each: [&Eddies<1>; N]) -> Option<Self> {
        let first = each[0];
        let across = |of: fn(&Eddies<1>) -> Option<&Transverse<1>>| -> Option<Option<Transverse<N>>> {
            if of(first).is_none() {
                return Some(None);
            }
            let filters: Vec<_> = each.iter().filter_map(|one| of(one)).collect();
            Transverse::abreast(filters.try_into().ok()?).map(Some)
        };
        let along = match &first.along {
            Some(_) => {
                let filters: Vec<_> = each.iter().filter_map(|one| one.along.as_ref()).collect();
                Some(Longitudinal::abreast(filters.try_into().ok()?)?)
            }
            None => None,
        };
        Some(Self {
            along,
            across: across(|one| one.across.as_ref())?,
            vertical: across(|one| one.vertical.as_ref())?,
        })
    }

    /// Velocities now, along the mean wind, across it and vertical, over their standard deviations.
    #[inline(always)]
    pub fn velocity(&self) -> [[f64; N]; 3] {
        let across = |filter: &Option<Transverse<N>>| filter.as_ref().map_or([0.0; N], Transverse::velocity);
        let along = self.along.as_ref().map_or([0.0; N], Longitudinal::velocity);
        [along, across(&self.across), across(&self.vertical)]
    }

    /// Goes on by distances through the air, along, across and vertical, each in units of that scale.
    #[inline(always)]
    pub fn advance(&mut self, distances: [[f64; N]; 3]) {
        let mut last: Option<Step<N>> = None;
        if let Some(filter) = &mut self.along {
            filter.advance(&step_over(distances[0], &mut last));
        }
        if let Some(filter) = &mut self.across {
            filter.advance(&step_over(distances[1], &mut last));
        }
        if let Some(filter) = &mut self.vertical {
            filter.advance(&step_over(distances[2], &mut last));
        }
    }
}

/// The step over a distance, taken from the last one where it is the same: scales often are. (Not a closure,
/// which the compiler leaves out of what it makes for wider registers.)
#[inline(always)]
fn step_over<const N: usize>(distance: [f64; N], last: &mut Option<Step<N>>) -> Step<N> {
    match last {
        Some(step) if step.is_over(&distance) => *step,
        _ => *last.insert(Step::over(distance)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// MIL-F-8785C by hand: at 1000 ft both lengths are 1000 ft; at 500 ft 500/0.5885^1.2 = 944.66 ft; half
    /// way to 2000 ft, 1375 ft; below 10 ft as at 10 ft.
    #[test]
    fn closed_form_scales_by_height() {
        let at = |height_ft: f64| {
            TurbulenceScale::LowAltitude.at_height_m(height_ft * M_PER_FT).map(|l| l / M_PER_FT)
        };
        for (height_ft, along, vertical) in [
            (1000.0, 1000.0, 1000.0),
            (500.0, 944.66, 500.0),
            (1500.0, 1375.0, 1375.0),
            (2000.0, 1750.0, 1750.0),
            (9000.0, 1750.0, 1750.0),
            (3.0, at(10.0)[0], 10.0),
            (-50.0, at(10.0)[0], 10.0),
        ] {
            let [u, v, w] = at(height_ft);
            assert!(
                (u - along).abs() < 0.005 && u == v && (w - vertical).abs() < 1e-9,
                "{height_ft}: {u} {w}"
            );
        }
        assert_eq!(TurbulenceScale::FreeAtmosphere.at_height_m(50.0), [533.4; 3]);
    }
}
