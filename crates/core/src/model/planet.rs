//! Worlds with an air to fly in: gravity and density at the altitude of a release, for drafts of missions.
//! Earth's and Titan's are those of [`Atmosphere`]; Mars has a model of its own.

use super::atmosphere::{earth_gravity_m_s2, titan_gravity_m_s2};
use super::{Atmosphere, ModelError, check};
use crate::math;

/// Part of a world's gravity by which that of a site may differ: latitude stays within.
const SAME_GRAVITY: f64 = 0.01;

/// A world with an air to fly in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planet {
    /// US Standard Atmosphere 1976, to 20 km.
    Earth,
    /// Descent of Huygens, to 10 km.
    Titan,
    /// NASA Glenn Research Center's "Mars Atmosphere Model", of Mars Global Surveyor's measurements, to 30
    /// km: <https://www.grc.nasa.gov/www/k-12/airplane/atmosmrm.html>.
    Mars,
}

impl Planet {
    /// Every world there is.
    pub const ALL: [Self; 3] = [Self::Earth, Self::Titan, Self::Mars];

    /// The world with this gravity [m/s^2] at an altitude [m], to a hundredth; `None`: no world has it.
    pub fn of_gravity(gravity_m_s2: f64, altitude_m: f64) -> Option<Self> {
        let has = |planet: &Self| (gravity_m_s2 / planet.gravity_m_s2(altitude_m) - 1.0).abs() < SAME_GRAVITY;
        Self::ALL.into_iter().find(has)
    }

    /// Name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Earth => "earth",
            Self::Titan => "titan",
            Self::Mars => "mars",
        }
    }

    /// Source of the density, in a few words.
    pub fn source(self) -> &'static str {
        match self {
            Self::Earth => "the US Standard Atmosphere 1976",
            Self::Titan => "Huygens' descent (Fulchignoni et al., Nature 438, 785, 2005)",
            Self::Mars => "NASA Glenn's Mars Atmosphere Model",
        }
    }

    /// Gravity [m/s^2] at an altitude [m] above mean sea level or the mean radius.
    pub fn gravity_m_s2(self, altitude_m: f64) -> f64 {
        match self {
            Self::Earth => earth_gravity_m_s2(altitude_m),
            Self::Titan => titan_gravity_m_s2(altitude_m),
            // GM and mean radius.
            Self::Mars => 4.282_837e13 / square(3_389_500.0 + altitude_m),
        }
    }

    /// Density of the air [kg/m^3] at an altitude [m].
    ///
    /// # Errors
    /// [`ModelError::OutOfRange`] where the model does not reach.
    pub fn density_kg_m3(self, altitude_m: f64) -> Result<f64, ModelError> {
        let (reaches, expected) = match self {
            Self::Earth => ((-500.0..=20_000.0).contains(&altitude_m), "from -500 to 20000 m on Earth"),
            Self::Titan => ((0.0..=10_000.0).contains(&altitude_m), "from 0 to 10000 m on Titan"),
            Self::Mars => ((-8000.0..=30_000.0).contains(&altitude_m), "from -8000 to 30000 m on Mars"),
        };
        check(reaches, "altitude", expected, altitude_m)?;
        Ok(match self {
            Self::Earth => known(Atmosphere::Us1976, altitude_m),
            Self::Titan => known(Atmosphere::Titan, altitude_m),
            Self::Mars => mars(altitude_m),
        })
    }
}

fn square(x: f64) -> f64 {
    x * x
}

fn known(atmosphere: Atmosphere, altitude_m: f64) -> f64 {
    atmosphere.at(altitude_m).map_or(f64::NAN, |air| air.density_kg_m3)
}

fn mars(altitude_m: f64) -> f64 {
    let (t_0, lapse) = if altitude_m < 7000.0 { (-31.0, 0.000_998) } else { (-23.4, 0.002_22) };
    let t_k = t_0 - lapse * altitude_m + 273.1;
    let p_kpa = 0.699 * math::exp(-0.000_09 * altitude_m);
    p_kpa / (0.1921 * t_k)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: poles and equator of Earth differ by half a percent, and nothing is between the worlds.
    #[test]
    fn closed_form_a_world_is_known_by_its_gravity() {
        let of = |gravity_m_s2: f64, altitude_m: f64| Planet::of_gravity(gravity_m_s2, altitude_m);
        assert_eq!(
            [of(9.780, 0.0), of(9.832, 0.0), of(1.35, 1000.0)].map(|p| p.map(Planet::name)),
            [Some("earth"), Some("earth"), Some("titan")]
        );
        assert_eq!([of(3.72, 0.0), of(9.65, 0.0), of(f64::NAN, 0.0)], [Some(Planet::Mars), None, None]);
    }

    /// Table I of the standard (geometric altitude), to its digits.
    #[test]
    fn reference_earth_is_the_standard_atmosphere() {
        let table = [
            (-500.0, 1.2849, 9.8082),
            (0.0, 1.2250, 9.8066),
            (1000.0, 1.1117, 9.8036),
            (3000.0, 0.90925, 9.7974),
            (5000.0, 0.73643, 9.7912),
            (10_000.0, 0.41351, 9.7759),
            (15_000.0, 0.19476, 9.7605),
            (20_000.0, 0.088910, 9.7452),
        ];
        for (h, rho, g) in table {
            let found = Planet::Earth.density_kg_m3(h).unwrap();
            assert!((found / rho - 1.0).abs() < 6e-5, "{h} m: {found}, the table {rho}");
            assert!((Planet::Earth.gravity_m_s2(h) - g).abs() < 6e-5, "{h} m");
        }
    }

    #[test]
    fn reference_titan_and_mars_are_as_published() {
        for (h, rho) in [(0.0, 5.345), (1000.0, 5.144), (10_000.0, 3.524)] {
            assert!((Planet::Titan.density_kg_m3(h).unwrap() / rho - 1.0).abs() < 1e-14);
        }
        let between = Planet::Titan.density_kg_m3(5000.0).unwrap();
        assert!(between < 4.575 && between > 4.203);
        assert!((Planet::Titan.gravity_m_s2(0.0) - 1.354).abs() < 5e-4);
        // By hand: 0.699/(0.1921 x 242.1), and both pieces of the temperature at 7 km to 0.3 K.
        assert!((Planet::Mars.density_kg_m3(0.0).unwrap() - 0.015_030).abs() < 1e-6);
        let (low, high) = (mars(6999.999), mars(7000.0));
        assert!((low / high - 1.0).abs() < 0.006, "{low} {high}");
        assert!((Planet::Mars.gravity_m_s2(0.0) - 3.728).abs() < 5e-4);
        for (planet, h) in [(Planet::Earth, 20_001.0), (Planet::Titan, -1.0), (Planet::Mars, f64::NAN)] {
            assert!(planet.density_kg_m3(h).is_err());
        }
    }
}
