//! Air and gravity by altitude: the US Standard Atmosphere 1976, and Titan's as Huygens measured it.

use crate::math;
use crate::units::STANDARD_GRAVITY_M_S2;

/// How air and gravity of a site change with altitude.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Atmosphere {
    /// Not at all: the site's gravity and density hold at every altitude.
    #[default]
    Constant,
    /// The US Standard Atmosphere 1976 (NOAA-S/T 76-1562), from -5 to 86 km.
    Us1976,
    /// Titan's lower troposphere, from 0 to 10 km: temperature, pressure and density of the Huygens probe's
    /// descent (Fulchignoni et al., Nature 438, 785, 2005).
    Titan,
}

/// Air and gravity at an altitude.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Temperature [K].
    pub temperature_k: f64,
    /// Pressure [Pa].
    pub pressure_pa: f64,
    /// Density [kg/m^3].
    pub density_kg_m3: f64,
    /// Gravity [m/s^2].
    pub gravity_m_s2: f64,
}

impl Atmosphere {
    /// Least and greatest altitude [m] that the atmosphere is known for; `None` where it does not change.
    pub fn altitudes_m(self) -> Option<[f64; 2]> {
        match self {
            Self::Constant => None,
            Self::Us1976 => Some([-5_000.0, 86_000.0]),
            Self::Titan => Some([0.0, 10_000.0]),
        }
    }

    /// Altitudes [m] at which the formulae of the atmosphere change, its ends with them: between two of them
    /// air and gravity are smooth.
    pub fn knots_m(self) -> Vec<f64> {
        match self {
            Self::Constant => Vec::new(),
            Self::Us1976 => {
                let geometric = |base_m: f64| EARTH_RADIUS_M * base_m / (EARTH_RADIUS_M - base_m);
                let layers = LAYERS.iter().skip(1).map(|layer| geometric(layer[0]));
                layers.chain(self.altitudes_m().into_iter().flatten()).collect()
            }
            Self::Titan => HUYGENS.iter().map(|row| row[0]).collect(),
        }
    }

    /// Air and gravity at an altitude above mean sea level [m], beyond the known altitudes as at the nearest
    /// one; `None` where they do not change with altitude.
    pub fn at(self, altitude_m: f64) -> Option<Air> {
        let [low, high] = self.altitudes_m()?;
        // A number that is none gives the lowest altitude.
        let altitude_m = altitude_m.max(low).min(high);
        match self {
            Self::Constant => None,
            Self::Us1976 => Some(us_1976(altitude_m)),
            Self::Titan => Some(titan(altitude_m)),
        }
    }
}

/// Radius of the Earth for which gravity falls off as the standard has it [m].
const EARTH_RADIUS_M: f64 = 6_356_766.0;
/// Gas constant of air, R*/M_0 of the standard [J/(kg K)].
const GAS_J_KG_K: f64 = 8314.32 / 28.9644;
/// The standard's Table 4, pressures by its equations (33): base of a layer as geopotential altitude [m],
/// lapse rate [K/m], and temperature [K] and pressure [Pa] at the base.
const LAYERS: [[f64; 4]; 7] = [
    [0.0, -0.0065, 288.15, 101_325.0],
    [11_000.0, 0.0, 216.65, 22_632.06],
    [20_000.0, 0.001, 216.65, 5_474.889],
    [32_000.0, 0.0028, 228.65, 868.0187],
    [47_000.0, 0.0, 270.65, 110.9063],
    [51_000.0, -0.0028, 270.65, 66.93887],
    [71_000.0, -0.002, 214.65, 3.956_420],
];

/// Equations (18), (23), (33a), (33b) and (42) of the standard. Above 80 km its kinetic temperature is up to
/// 0.04 % lower than the molecular one here.
fn us_1976(altitude_m: f64) -> Air {
    let geopotential_m = EARTH_RADIUS_M * altitude_m / (EARTH_RADIUS_M + altitude_m);
    let layer = LAYERS.iter().rev().find(|layer| layer[0] <= geopotential_m).unwrap_or(&LAYERS[0]);
    let [base_m, lapse_k_m, base_k, base_pa] = *layer;
    let above_m = geopotential_m - base_m;
    let temperature_k = base_k + lapse_k_m * above_m;
    let pressure_pa = if lapse_k_m == 0.0 {
        base_pa * math::exp(-STANDARD_GRAVITY_M_S2 * above_m / (GAS_J_KG_K * base_k))
    } else {
        let exponent = -STANDARD_GRAVITY_M_S2 / (GAS_J_KG_K * lapse_k_m);
        base_pa * math::powf(temperature_k / base_k, exponent)
    };
    Air {
        temperature_k,
        pressure_pa,
        density_kg_m3: pressure_pa / (GAS_J_KG_K * temperature_k),
        gravity_m_s2: earth_gravity_m_s2(altitude_m),
    }
}

/// The standard's gravity at an altitude [m]: its equation (17).
pub(super) fn earth_gravity_m_s2(altitude_m: f64) -> f64 {
    let part = EARTH_RADIUS_M / (EARTH_RADIUS_M + altitude_m);
    STANDARD_GRAVITY_M_S2 * part * part
}

/// Altitude [m], temperature [K], pressure [Pa] and density [kg/m^3] on the Huygens probe's way down, from
/// the profiles of its atmospheric structure instrument.
const HUYGENS: [[f64; 4]; 9] = [
    [0.0, 93.5, 146_600.0, 5.345],
    [500.0, 92.9, 143_200.0, 5.243],
    [1_000.0, 92.35, 139_600.0, 5.144],
    [2_000.0, 91.1, 132_900.0, 4.958],
    [3_000.0, 90.1, 126_400.0, 4.766],
    [4_000.0, 89.1, 120_100.0, 4.575],
    [6_000.0, 87.3, 108_400.0, 4.203],
    [8_000.0, 85.5, 97_400.0, 3.853],
    [10_000.0, 83.9, 87_500.0, 3.524],
];

/// Titan's gravitational parameter [m^3/s^2].
const TITAN_GM_M3_S2: f64 = 8.978e12;
/// Titan's mean radius [m].
const TITAN_RADIUS_M: f64 = 2_574_700.0;

/// Between two rows of the table the temperature is linear in altitude, pressure and density exponential.
fn titan(altitude_m: f64) -> Air {
    let i = HUYGENS.windows(2).position(|rows| altitude_m < rows[1][0]).unwrap_or(HUYGENS.len() - 2);
    let (low, high) = (&HUYGENS[i], &HUYGENS[i + 1]);
    let part = (altitude_m - low[0]) / (high[0] - low[0]);
    let exponential = |k: usize| low[k] * math::powf(high[k] / low[k], part);
    Air {
        temperature_k: low[1] + part * (high[1] - low[1]),
        pressure_pa: exponential(2),
        density_kg_m3: exponential(3),
        gravity_m_s2: titan_gravity_m_s2(altitude_m),
    }
}

/// Titan's gravity at an altitude [m] above the mean radius.
pub(super) fn titan_gravity_m_s2(altitude_m: f64) -> f64 {
    let radius_m = TITAN_RADIUS_M + altitude_m;
    TITAN_GM_M3_S2 / (radius_m * radius_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table I of NOAA-S/T 76-1562, geometric altitude: temperature [K], pressure [Pa], density [kg/m^3].
    #[test]
    fn reference_us_1976_is_its_published_table() {
        for (altitude_m, temperature_k, pressure_pa, density_kg_m3) in [
            (-1_000.0, 294.651, 1.1393e5, 1.3470),
            (0.0, 288.150, 1.01325e5, 1.2250),
            (1_000.0, 281.651, 8.9876e4, 1.1117),
            (3_000.0, 268.659, 7.0121e4, 9.0925e-1),
            (5_000.0, 255.676, 5.4048e4, 7.3643e-1),
            (10_000.0, 223.252, 2.6500e4, 4.1351e-1),
            (15_000.0, 216.650, 1.2112e4, 1.9476e-1),
            (20_000.0, 216.650, 5.5293e3, 8.8910e-2),
            (30_000.0, 226.509, 1.1970e3, 1.8410e-2),
            (40_000.0, 250.350, 2.8714e2, 3.9957e-3),
            (50_000.0, 270.650, 7.9779e1, 1.0269e-3),
            (60_000.0, 247.021, 2.1958e1, 3.0968e-4),
            (70_000.0, 219.585, 5.2209, 8.2829e-5),
            (80_000.0, 198.639, 1.0524, 1.8458e-5),
        ] {
            let air = Atmosphere::Us1976.at(altitude_m).unwrap();
            assert!((air.temperature_k - temperature_k).abs() < 2e-3, "{altitude_m} m: {air:?}");
            assert!((air.pressure_pa / pressure_pa - 1.0).abs() < 1e-4, "{altitude_m} m: {air:?}");
            assert!((air.density_kg_m3 / density_kg_m3 - 1.0).abs() < 1e-4, "{altitude_m} m: {air:?}");
        }
        let gravity = |altitude_m| Atmosphere::Us1976.at(altitude_m).unwrap().gravity_m_s2;
        assert_eq!(gravity(0.0), STANDARD_GRAVITY_M_S2);
        assert!((gravity(3_000.0) - 9.7974).abs() < 5e-5 && (gravity(10_000.0) - 9.7759).abs() < 5e-5);
    }

    /// At the base of each layer the layer below gives the same pressure.
    #[test]
    fn closed_form_us_1976_is_continuous() {
        for layer in &LAYERS[1..] {
            let altitude_m = EARTH_RADIUS_M * layer[0] / (EARTH_RADIUS_M - layer[0]);
            let [below, above] = [-0.01, 0.01].map(|d| Atmosphere::Us1976.at(altitude_m + d).unwrap());
            assert!((below.pressure_pa / above.pressure_pa - 1.0).abs() < 1e-5, "{below:?} {above:?}");
        }
    }

    /// The rows of the table; between them the law of gases of N2 with 5 % CH4 (27.4 kg/kmol, factor of
    /// compressibility 0.967 at the ground) and the balance of pressure and weight.
    #[test]
    fn reference_titan_is_what_huygens_measured() {
        for [altitude_m, temperature_k, pressure_pa, density_kg_m3] in HUYGENS {
            let air = Atmosphere::Titan.at(altitude_m).unwrap();
            let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12;
            assert!(close(air.temperature_k, temperature_k) && close(air.pressure_pa, pressure_pa));
            assert!(close(air.density_kg_m3, density_kg_m3), "{altitude_m} m: {air:?}");
        }
        for altitude_m in (0..=9).map(|k| 1e3 * f64::from(k) + 250.0) {
            let air = Atmosphere::Titan.at(altitude_m).unwrap();
            let ideal = air.pressure_pa / (8314.32 / 27.4 * air.temperature_k);
            assert!((0.955..0.985).contains(&(ideal / air.density_kg_m3)), "{altitude_m} m: {air:?}");
            let [low, high] = [-200.0, 200.0].map(|d| Atmosphere::Titan.at(altitude_m + d).unwrap());
            let weight = air.density_kg_m3 * air.gravity_m_s2 * 400.0;
            assert!(((low.pressure_pa - high.pressure_pa) / weight - 1.0).abs() < 0.06, "{altitude_m} m");
        }
        let gravity = |altitude_m| Atmosphere::Titan.at(altitude_m).unwrap().gravity_m_s2;
        assert!((gravity(0.0) - 1.354).abs() < 5e-4 && (gravity(4_000.0) - 1.350).abs() < 5e-4);
    }

    #[test]
    fn beyond_what_is_known_the_edge_holds() {
        let at = |altitude_m| Atmosphere::Titan.at(altitude_m);
        assert_eq!((at(-5.0), at(2e4)), (at(0.0), at(1e4)));
        assert_eq!(at(f64::NAN), at(0.0));
        assert_eq!(Atmosphere::Constant.at(100.0), None);
    }
}
