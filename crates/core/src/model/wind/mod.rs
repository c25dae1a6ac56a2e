//! The wind over a flight: a mean wind, steady or by altitude, discrete gusts, and turbulence.
//!
//! | file | holds |
//! |---|---|
//! | `profile` | the mean wind by altitude |
//! | `gust` | discrete gusts, of MIL-F-8785C and of CS-25 |
//! | `turbulence` | strength and scale of turbulence |
//! | `dryden` | Dryden's filters, exact at the step |
//! | `given` | white noise of flights that is given instead of drawn |
//! | `ring` | fluctuation of rotors' thrusts in the vortex ring, which is no wind but goes with it |
//!
//! The wind is held within a step of the simulation: gusts at their value in its middle, turbulence at the
//! value of the filters. One velocity acts on the whole vehicle; what is left out by that is how much the air
//! differs from rotor to rotor: across a gust over a distance r small against L, an rms of about
//! `sigma sqrt(3 r/L)`.
//!
//! Turbulence lies along the mean wind at the site's altitude throughout a flight. The one at the vehicle's
//! own altitude may pass through zero on the way down, and turbulence along it would turn about at once.

use nalgebra::Vector3;

#[expect(clippy::needless_range_loop, reason = "lanes are indexed alike, side by side")]
mod dryden;
mod given;
mod gust;
mod profile;
mod ring;
mod turbulence;

pub use dryden::Draw;
pub use given::{FlightNoise, GivenNoise};
pub use gust::{Gust, GustLength, GustShape};
pub use profile::WindProfile;
use ring::RingCourse;
pub use ring::RingFluctuation;
use turbulence::Eddies;
pub use turbulence::{Turbulence, TurbulenceScale};

use crate::model::{Environment, MAX_ROTORS};

/// Turbulence passes the vehicle at its airspeed, but at least at this speed [m/s]: eddies change, and pass,
/// when the vehicle stands in the air.
pub const LEAST_CONVECTION_M_S: f64 = 1.0;

/// The wind of a mission, beside the mean one of its [`Environment`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Wind {
    /// Mean wind by altitude: its differences from the one at the site's altitude, which is in the
    /// [`Environment`].
    pub profile: Option<WindProfile>,
    /// Gusts, in addition to the mean wind and to each other.
    pub gusts: Vec<Gust>,
    /// Turbulence about all of these, along and across the mean wind at the site's altitude.
    pub turbulence: Option<Turbulence>,
    /// Altitude of the ground above mean sea level [m], where turbulence takes its scale from the height
    /// above it.
    pub ground_altitude_m: f64,
    /// Fluctuation of rotors' thrusts in the vortex ring.
    pub ring: Option<RingFluctuation>,
    /// White noise that drives turbulence and vortex ring, given by flight instead of drawn.
    pub given: Option<GivenNoise>,
}

/// The wind over `N` flights side by side, of one as a rule.
#[derive(Clone, Debug)]
pub struct WindCourse<const N: usize = 1> {
    wind: Wind,
    /// The mean wind at the site's altitude, NED [m/s].
    site_wind_ned: [[f64; N]; 3],
    site_altitude_m: f64,
    /// The share of gusts and turbulence that each flight feels: all or nothing.
    share: [f64; N],
    eddies: Option<Eddies<N>>,
    /// Distance flown through the air since each gust began [m].
    distances_m: Vec<[f64; N]>,
    ring: Option<RingCourse<N>>,
}

impl Wind {
    /// Whether the wind is the site's own at all times and altitudes.
    pub fn is_steady(&self) -> bool {
        self.profile.is_none() && self.gusts.is_empty() && self.turbulence.is_none()
    }

    /// Whether anything of it changes over a flight: the wind, or rotors' thrusts in the vortex ring.
    pub fn changes(&self) -> bool {
        !self.is_steady() || self.ring.is_some()
    }

    /// The wind with the mean wind and the scale of turbulence of the site's altitude everywhere: that of
    /// flights which take gravity and density from there.
    pub fn uniform(&self, site: &Environment) -> Self {
        let height_m = site.anchor.altitude_m - self.ground_altitude_m;
        let turbulence = self.turbulence.clone().map(|turbulence| {
            let scale = TurbulenceScale::Fixed(turbulence.scale.at_height_m(height_m));
            Turbulence { scale, ..turbulence }
        });
        Self { profile: None, turbulence, ..self.clone() }
    }

    /// The wind without its turbulence across the mean wind, and with a vortex ring that treats mirror images
    /// alike: all that a flight in the plane of the mean wind feels.
    pub fn in_plane(mut self) -> Self {
        if let Some(turbulence) = &mut self.turbulence {
            turbulence.sigma_m_s[1] = 0.0;
        }
        if let Some(ring) = &mut self.ring {
            ring.mirrored = true;
        }
        self
    }

    /// The wind of flight `number` at a site, whose wind is the mean one at its altitude; `None` where
    /// nothing of it [changes](Self::changes). Each flight has turbulence of its own.
    pub fn course(&self, site: &Environment, number: u64) -> Option<WindCourse> {
        self.courses(site, [site.wind_ned_m_s], [Some(number)])
    }

    /// The wind of flights side by side with these mean winds at a site's altitude, NED [m/s]; a flight
    /// without a number feels neither gusts nor turbulence.
    pub fn courses<const N: usize>(
        &self,
        site: &Environment,
        mean_ned: [Vector3<f64>; N],
        numbers: [Option<u64>; N],
    ) -> Option<WindCourse<N>> {
        self.changes().then(|| WindCourse {
            site_wind_ned: [0, 1, 2].map(|k| mean_ned.map(|mean| mean[k])),
            site_altitude_m: site.anchor.altitude_m,
            share: numbers.map(|number| if number.is_some() { 1.0 } else { 0.0 }),
            eddies: self
                .turbulence
                .as_ref()
                .map(|t| t.eddies(numbers.map(Option::unwrap_or_default), self.given.as_ref())),
            distances_m: vec![[0.0; N]; self.gusts.len()],
            ring: self
                .ring
                .map(|ring| ring.course(numbers.map(Option::unwrap_or_default), self.given.as_ref())),
            wind: self.clone(),
        })
    }
}

impl WindCourse {
    /// The mean wind at the site's altitude, NED [m/s].
    pub fn site_wind_ned(&self) -> Vector3<f64> {
        Vector3::from(self.site_wind_ned.map(|[component]| component))
    }

    /// The wind of flights at a site side by side, each of which goes on where it is; `None` where it is not
    /// the same [`Wind`].
    pub fn abreast<const N: usize>(each: [&Self; N]) -> Option<WindCourse<N>> {
        let first = each[0];
        if !each.iter().all(|one| one.wind == first.wind && one.site_altitude_m == first.site_altitude_m) {
            return None;
        }
        let eddies = match &first.eddies {
            Some(_) => {
                let eddies: Vec<_> = each.iter().filter_map(|one| one.eddies.as_ref()).collect();
                Some(Eddies::abreast(eddies.try_into().ok()?)?)
            }
            None => None,
        };
        let ring = match &first.ring {
            Some(_) => {
                let rings: Vec<_> = each.iter().filter_map(|one| one.ring.as_ref()).collect();
                Some(RingCourse::abreast(rings.try_into().ok()?)?)
            }
            None => None,
        };
        let distances = |gust: usize| each.map(|one| one.distances_m[gust][0]);
        Some(WindCourse {
            wind: first.wind.clone(),
            site_wind_ned: [0, 1, 2].map(|k| each.map(|one| one.site_wind_ned[k][0])),
            site_altitude_m: first.site_altitude_m,
            share: each.map(|one| one.share[0]),
            eddies,
            distances_m: (0..first.distances_m.len()).map(distances).collect(),
            ring,
        })
    }
}

impl<const N: usize> WindCourse<N> {
    /// How much more the mean wind is `to_down_m` below the local origin than `from_down_m` below it, NED
    /// [m/s]: gusts and turbulence are the same at both.
    pub fn difference_ned(&self, from_down_m: f64, to_down_m: f64) -> Vector3<f64> {
        match &self.wind.profile {
            Some(profile) => {
                let at = |down_m: f64| profile.at(self.site_altitude_m - down_m);
                at(to_down_m) - at(from_down_m)
            }
            None => Vector3::zeros(),
        }
    }
}

impl<const N: usize> WindCourse<N> {
    /// The mean wind at altitudes above mean sea level, NED [m/s].
    #[inline(always)]
    fn mean_ned(&self, altitude_m: &[f64; N]) -> [[f64; N]; 3] {
        let mut mean = self.site_wind_ned;
        if let Some(profile) = &self.wind.profile {
            let there = profile.at(self.site_altitude_m);
            for i in 0..N {
                let more = profile.at(altitude_m[i]) - there;
                for k in 0..3 {
                    mean[k][i] += more[k];
                }
            }
        }
        mean
    }

    /// The wind of the step of `dt_s` [s] that begins now, `t_s` from t = 0, for vehicles `down_m` below the
    /// local origin that move at `v_ned` over ground: NED [m/s]. Each call is a step.
    #[inline(always)]
    pub fn step(
        &mut self,
        t_s: &[f64; N],
        dt_s: f64,
        down_m: &[f64; N],
        v_ned: &[[f64; N]; 3],
    ) -> [[f64; N]; 3] {
        let altitude_m = down_m.map(|down| self.site_altitude_m - down);
        let mean = self.mean_ned(&altitude_m);
        let mut airspeed_m_s = [0.0; N];
        for i in 0..N {
            let [n, e, d] = [0, 1, 2].map(|k| v_ned[k][i] - mean[k][i]);
            airspeed_m_s[i] = (n * n + e * e + d * d).sqrt();
        }
        let mut wind = mean;
        for (gust, flown_m) in self.wind.gusts.iter().zip(&mut self.distances_m) {
            for i in 0..N {
                let middle_s = t_s[i] + 0.5 * dt_s;
                let inside_s = (t_s[i] + dt_s - gust.start_s).clamp(0.0, dt_s);
                let blown = gust.at(middle_s, flown_m[i] + 0.5 * airspeed_m_s[i] * inside_s);
                for k in 0..3 {
                    wind[k][i] += self.share[i] * blown[k];
                }
                flown_m[i] += airspeed_m_s[i] * inside_s;
            }
        }
        if let (Some(turbulence), Some(eddies)) = (&self.wind.turbulence, &mut self.eddies) {
            let velocity = along(&self.site_wind_ned, &eddies.velocity(), turbulence.sigma_m_s);
            let mut distances = [[0.0; N]; 3];
            for i in 0..N {
                for k in 0..3 {
                    wind[k][i] += self.share[i] * velocity[k][i];
                }
                let speed = airspeed_m_s[i];
                let convection = if speed > LEAST_CONVECTION_M_S { speed } else { LEAST_CONVECTION_M_S };
                let scale_m = turbulence.scale.at_height_m(altitude_m[i] - self.wind.ground_altitude_m);
                for k in 0..3 {
                    distances[k][i] = convection * dt_s / scale_m[k];
                }
            }
            eddies.advance(distances);
        }
        wind
    }
}

impl<const N: usize> WindCourse<N> {
    /// Shares of their means by which thrusts well inside the vortex ring deviate in the step of `dt_s` [s]
    /// that begins now: of each draw by number, from 0, and each flight. `None` where they do not fluctuate,
    /// else each call is a step.
    #[inline(always)]
    pub fn ring_deviations(&mut self, dt_s: f64) -> Option<[[f64; N]; MAX_ROTORS]> {
        let ring = self.ring.as_mut()?;
        let mut deviations = [[0.0; N]; MAX_ROTORS];
        for (rotor, deviation) in deviations.iter_mut().enumerate() {
            *deviation = ring.deviation(rotor);
            for (deviation, share) in deviation.iter_mut().zip(&self.share) {
                *deviation *= share;
            }
        }
        ring.advance(dt_s);
        Some(deviations)
    }

    /// Whether mirror images fluctuate alike in the vortex ring.
    pub fn ring_is_mirrored(&self) -> bool {
        self.ring.as_ref().is_some_and(RingCourse::is_mirrored)
    }
}

/// Velocities along the mean wind (north, where there is none), across it to the right, and down, as NED.
#[inline(always)]
fn along<const N: usize>(
    mean_ned: &[[f64; N]; 3],
    velocity: &[[f64; N]; 3],
    sigma: [f64; 3],
) -> [[f64; N]; 3] {
    let mut ned = [[0.0; N]; 3];
    for i in 0..N {
        let (n, e) = (mean_ned[0][i], mean_ned[1][i]);
        let speed = (n * n + e * e).sqrt();
        let blows = speed > 0.0;
        let divisor = if blows { speed } else { 1.0 };
        let (n, e) = (if blows { n / divisor } else { 1.0 }, if blows { e / divisor } else { 0.0 });
        let [u, v, w] = [0, 1, 2].map(|k| sigma[k] * velocity[k][i]);
        ned[0][i] = u * n - v * e;
        ned[1][i] = u * e + v * n;
        ned[2][i] = w;
    }
    ned
}
