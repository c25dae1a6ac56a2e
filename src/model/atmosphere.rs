//! Gravity and density of the air over altitude, for the sites of missions: Earth's standard atmosphere,
//! Titan's as Huygens measured it, and a model of Mars'.
//!
//! A flight takes both for constant (a drop of half a minute); here they are worked out once, at the altitude
//! of the release.

use super::{ModelError, check};
use crate::math;

/// A world with an air to fly in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Planet {
    /// US Standard Atmosphere 1976 (NASA-TM-X-74335), to 20 km: 6.5 K/km up to 11 km of geopotential
    /// altitude, 216.65 K above.
    Earth,
    /// Descent of Huygens (Fulchignoni et al., Nature 438, 785, 2005, doi 10.1038/nature04314), to 10 km;
    /// between its altitudes the logarithm of the density is interpolated.
    Titan,
    /// NASA Glenn Research Center's "Mars Atmosphere Model", of Mars Global Surveyor's measurements, to 30
    /// km: <https://www.grc.nasa.gov/www/k-12/airplane/atmosmrm.html>.
    Mars,
}

/// Altitude [m] and density [kg/m^3] on Titan.
const TITAN: [(f64, f64); 9] = [
    (0.0, 5.345),
    (500.0, 5.243),
    (1000.0, 5.144),
    (2000.0, 4.958),
    (3000.0, 4.766),
    (4000.0, 4.575),
    (6000.0, 4.203),
    (8000.0, 3.853),
    (10_000.0, 3.524),
];

impl Planet {
    /// Every world there is.
    pub const ALL: [Self; 3] = [Self::Earth, Self::Titan, Self::Mars];

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
            // The standard's gravity and radius.
            Self::Earth => 9.80665 * square(6_356_766.0 / (6_356_766.0 + altitude_m)),
            // GM and mean radius.
            Self::Titan => 8.978e12 / square(2_574_700.0 + altitude_m),
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
            Self::Earth => earth(altitude_m),
            Self::Titan => titan(altitude_m),
            Self::Mars => mars(altitude_m),
        })
    }
}

fn square(x: f64) -> f64 {
    x * x
}

fn earth(altitude_m: f64) -> f64 {
    const G0: f64 = 9.80665;
    const R_PER_M: f64 = 8314.32 / 28.9644;
    const LAPSE: f64 = 0.0065;
    let geopotential_m = 6_356_766.0 * altitude_m / (6_356_766.0 + altitude_m);
    let below_m = geopotential_m.min(11_000.0);
    let t_k = 288.15 - LAPSE * below_m;
    let mut p_pa = 101_325.0 * math::powf(t_k / 288.15, G0 / (R_PER_M * LAPSE));
    p_pa *= math::exp(-G0 * (geopotential_m - below_m) / (R_PER_M * t_k));
    p_pa / (R_PER_M * t_k)
}

fn titan(altitude_m: f64) -> f64 {
    let above = TITAN.iter().position(|(h, _)| *h >= altitude_m).unwrap_or(TITAN.len() - 1).max(1);
    let ((h0, rho0), (h1, rho1)) = (TITAN[above - 1], TITAN[above]);
    rho0 * math::powf(rho1 / rho0, (altitude_m - h0) / (h1 - h0))
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
        for (h, rho) in TITAN {
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
