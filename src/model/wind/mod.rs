//! The wind over a flight: a mean wind, steady or by altitude, discrete gusts, and turbulence.
//!
//! | file | holds |
//! |---|---|
//! | `profile` | the mean wind by altitude |
//! | `gust` | discrete gusts, of MIL-F-8785C and of CS-25 |
//! | `turbulence` | strength and scale of turbulence |
//! | `dryden` | Dryden's filters, exact at the step |
//!
//! The wind is held within a step of the simulation: gusts at their value in its middle, turbulence at the
//! value of the filters. One velocity acts on the whole vehicle; what is left out by that is how much the air
//! differs from rotor to rotor: across a gust over a distance r small against L, an rms of about
//! `sigma sqrt(3 r/L)`.

use nalgebra::Vector3;

mod dryden;
mod gust;
mod profile;
mod turbulence;

pub use dryden::Draw;
pub use gust::{Gust, GustLength, GustShape};
pub use profile::WindProfile;
use turbulence::Eddies;
pub use turbulence::{Turbulence, TurbulenceScale};

use crate::model::Environment;

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
    /// Turbulence about all of these.
    pub turbulence: Option<Turbulence>,
    /// Altitude of the ground above mean sea level [m], where turbulence takes its scale from the height
    /// above it.
    pub ground_altitude_m: f64,
}

/// The wind over one flight.
#[derive(Clone, Debug)]
pub struct WindCourse {
    wind: Wind,
    site_wind_ned: Vector3<f64>,
    site_altitude_m: f64,
    eddies: Option<Eddies>,
    /// Distance flown through the air since each gust began [m].
    distances_m: Vec<f64>,
}

impl Wind {
    /// Whether the wind is the site's own at all times and altitudes.
    pub fn is_steady(&self) -> bool {
        self.profile.is_none() && self.gusts.is_empty() && self.turbulence.is_none()
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

    /// The wind without its turbulence across the mean wind: all that a flight in the plane of the mean wind
    /// feels.
    pub fn in_plane(mut self) -> Self {
        if let Some(turbulence) = &mut self.turbulence {
            turbulence.sigma_m_s[1] = 0.0;
        }
        self
    }

    /// The wind of flight `number` at a site, whose wind is the mean one at its altitude; `None` where it
    /// [is steady](Self::is_steady). Each flight has turbulence of its own.
    pub fn course(&self, site: &Environment, number: u64) -> Option<WindCourse> {
        (!self.is_steady()).then(|| WindCourse {
            site_wind_ned: site.wind_ned_m_s,
            site_altitude_m: site.anchor.altitude_m,
            eddies: self.turbulence.as_ref().map(|t| t.eddies(number)),
            distances_m: vec![0.0; self.gusts.len()],
            wind: self.clone(),
        })
    }
}

impl WindCourse {
    /// The mean wind at the site's altitude, NED [m/s].
    pub fn site_wind_ned(&self) -> Vector3<f64> {
        self.site_wind_ned
    }

    /// The mean wind at an altitude above mean sea level, NED [m/s].
    fn mean_ned(&self, altitude_m: f64) -> Vector3<f64> {
        match &self.wind.profile {
            Some(profile) => self.site_wind_ned + (profile.at(altitude_m) - profile.at(self.site_altitude_m)),
            None => self.site_wind_ned,
        }
    }

    /// The wind of the step of `dt_s` [s] that begins now, `t_s` from t = 0, for a vehicle `down_m` below the
    /// local origin that moves at `v_ned` over ground: NED [m/s]. Each call is a step.
    pub fn step(&mut self, t_s: f64, dt_s: f64, down_m: f64, v_ned: Vector3<f64>) -> Vector3<f64> {
        let altitude_m = self.site_altitude_m - down_m;
        let mean = self.mean_ned(altitude_m);
        let airspeed_m_s = (v_ned - mean).norm();
        let mut wind = mean;
        let middle_s = t_s + 0.5 * dt_s;
        for (gust, flown_m) in self.wind.gusts.iter().zip(&mut self.distances_m) {
            let inside_s = (t_s + dt_s - gust.start_s).clamp(0.0, dt_s);
            wind += Vector3::from(gust.at(middle_s, *flown_m + 0.5 * airspeed_m_s * inside_s));
            *flown_m += airspeed_m_s * inside_s;
        }
        if let (Some(turbulence), Some(eddies)) = (&self.wind.turbulence, &mut self.eddies) {
            wind += along(mean, eddies.velocity(), turbulence.sigma_m_s);
            let flown_m = airspeed_m_s.max(LEAST_CONVECTION_M_S) * dt_s;
            let scale_m = turbulence.scale.at_height_m(altitude_m - self.wind.ground_altitude_m);
            eddies.advance(scale_m.map(|l| flown_m / l));
        }
        wind
    }
}

/// Velocities along the mean wind (north, where there is none), across it to the right, and down, as NED.
fn along(mean_ned: Vector3<f64>, velocity: [f64; 3], sigma: [f64; 3]) -> Vector3<f64> {
    let speed = mean_ned.xy().norm();
    let (n, e) = if speed > 0.0 { (mean_ned.x / speed, mean_ned.y / speed) } else { (1.0, 0.0) };
    let [u, v, w] = [0, 1, 2].map(|i| sigma[i] * velocity[i]);
    Vector3::new(u * n - v * e, u * e + v * n, w)
}
