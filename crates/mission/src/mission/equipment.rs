//! What is aboard: the errors of the sensors. A sensor that is not named has no errors (a barometer has its
//! little noise).

use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::Deserialize;

use super::px4::Px4Clock;
use crate::error::ConfigError;
use crate::number::{Count, NonNegative, Positive};
use crate::source::Source;
use samara_core::model::Environment;
use samara_core::model::magnetic_field::earth_ned_gauss;
use samara_core::sim::SensorSettings;
use samara_core::sim::sensors::{Barometer, Magnetometer, Satellite, Triad};
use samara_core::units::US_PER_S;

/// Errors of the sensors that the simulator reports. A sensor that is left out is ideal.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SensorsJson {
    /// Remarks for the reader.
    #[serde(rename = "about")]
    _about: Option<String>,
    /// Accelerometer.
    accelerometer: Option<AccelerometerJson>,
    /// Gyroscope.
    gyroscope: Option<GyroscopeJson>,
    /// Magnetometer; in a dipole's field when left out.
    magnetometer: Option<MagnetometerJson>,
    /// Barometer; with noise of 0.01 hPa when left out.
    barometer: Option<BarometerJson>,
    /// Satellite receiver; 10 Hz when left out.
    gps: Option<GpsJson>,
}

/// Errors of the accelerometer, the same on each axis.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct AccelerometerJson {
    /// Noise density N: Allan's deviation is N / sqrt(tau) [m/s^2/sqrt(Hz)].
    noise_m_s2_per_sqrt_hz: NonNegative<100>,
    /// Random walk K of the bias: its standard deviation after t is K sqrt(t) [m/s^2/sqrt(s)].
    walk_m_s2_per_sqrt_s: NonNegative<100>,
    /// Standard deviation of the bias at turn-on [m/s^2].
    turn_on_bias_m_s2: NonNegative<100>,
    /// Smallest step of a reading [m/s^2]; 0: none.
    resolution_m_s2: NonNegative<100>,
    /// Greatest reading, either way [m/s^2]; no limit when left out.
    range_m_s2: Option<Positive<100_000>>,
}

/// Errors of the gyroscope, the same on each axis.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GyroscopeJson {
    /// Noise density N: Allan's deviation is N / sqrt(tau) [rad/s/sqrt(Hz)].
    noise_rad_s_per_sqrt_hz: NonNegative<100>,
    /// Random walk K of the bias: its standard deviation after t is K sqrt(t) [rad/s/sqrt(s)].
    walk_rad_s_per_sqrt_s: NonNegative<100>,
    /// Standard deviation of the bias at turn-on [rad/s].
    turn_on_bias_rad_s: NonNegative<100>,
    /// Smallest step of a reading [rad/s]; 0: none.
    resolution_rad_s: NonNegative<100>,
    /// Greatest reading, either way [rad/s]; no limit when left out.
    range_rad_s: Option<Positive<100_000>>,
}

/// The magnetometer.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct MagnetometerJson {
    /// The field at the site.
    field: FieldJson,
    /// Readings in a second [Hz], by the site's time; one at each step of the simulation when left out.
    rate_hz: Option<Count<1, 250>>,
    /// Standard deviation of a reading's noise, each axis [gauss].
    noise_gauss: NonNegative<100>,
}

/// The magnetic field at the site.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum FieldJson {
    /// A dipole along the axis of rotation: no declination.
    Dipole,
    /// Earth's, by the World Magnetic Model on the day of epoch_unix_us (2020 to 2029); on Earth, or where
    /// px4_clock is "froude": PX4 looks up the declination of Earth's field where it is.
    WorldMagneticModel,
}

/// Errors of the barometer.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct BarometerJson {
    /// Readings in a second [Hz], by the site's time; one at each step of the simulation when left out.
    rate_hz: Option<Count<1, 250>>,
    /// Standard deviation of a reading's noise [hPa]; PX4 takes a barometer without any for dead.
    noise_hpa: NonNegative<1000>,
    /// Random walk of the bias: its standard deviation after t is this sqrt(t) [hPa/sqrt(s)].
    drift_hpa_per_sqrt_s: NonNegative<1000>,
}

/// Rate and errors of the satellite receiver.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GpsJson {
    /// Fixes in a second [Hz].
    rate_hz: Count<5, 20>,
    /// Standard deviation of north and east, each [m].
    horizontal_noise_m: NonNegative<100>,
    /// Standard deviation of the altitude [m].
    vertical_noise_m: NonNegative<100>,
    /// Standard deviation of each component of the velocity [m/s].
    velocity_noise_m_s: NonNegative<10>,
    /// Age of a fix when it is reported, to the nearest step of the simulation [s].
    delay_s: NonNegative<1>,
}

impl SensorsJson {
    /// Whether the satellite receiver is named.
    pub(super) fn has_receiver(&self) -> bool {
        self.gps.is_some()
    }
}

/// The sensors of a mission at its site, on the day of `epoch_unix_us`.
pub(super) fn sensors(
    source: &Source,
    json: Option<&SensorsJson>,
    site: &Environment,
    epoch_unix_us: u64,
    px4: Px4Clock,
) -> Result<SensorSettings, ConfigError> {
    let mut settings = SensorSettings::default();
    let Some(sensors) = json else { return Ok(settings) };
    if let Some(a) = &sensors.accelerometer {
        settings.accelerometer = Triad {
            noise_density: a.noise_m_s2_per_sqrt_hz.get(),
            walk: a.walk_m_s2_per_sqrt_s.get(),
            turn_on_bias: a.turn_on_bias_m_s2.get(),
            resolution: a.resolution_m_s2.get(),
            range: a.range_m_s2.map(Positive::get),
        };
    }
    if let Some(g) = &sensors.gyroscope {
        settings.gyroscope = Triad {
            noise_density: g.noise_rad_s_per_sqrt_hz.get(),
            walk: g.walk_rad_s_per_sqrt_s.get(),
            turn_on_bias: g.turn_on_bias_rad_s.get(),
            resolution: g.resolution_rad_s.get(),
            range: g.range_rad_s.map(Positive::get),
        };
    }
    if let Some(m) = &sensors.magnetometer {
        settings.magnetometer = Magnetometer {
            period_us: m.rate_hz.map_or(0, period_us),
            field_ned_gauss: match m.field {
                FieldJson::Dipole => None,
                FieldJson::WorldMagneticModel => Some(earths_field(source, site, epoch_unix_us, px4)?),
            },
            noise_gauss: m.noise_gauss.get(),
        };
    }
    if let Some(b) = &sensors.barometer {
        settings.barometer = Barometer {
            period_us: b.rate_hz.map_or(0, period_us),
            noise_hpa: b.noise_hpa.get(),
            drift_hpa_per_sqrt_s: b.drift_hpa_per_sqrt_s.get(),
        };
    }
    if let Some(g) = &sensors.gps {
        settings.satellite = Satellite {
            period_us: period_us(g.rate_hz),
            horizontal_noise_m: g.horizontal_noise_m.get(),
            vertical_noise_m: g.vertical_noise_m.get(),
            speed_noise_m_s: g.velocity_noise_m_s.get(),
            delay_us: (g.delay_s.get() * US_PER_S).round() as u64,
        };
    }
    Ok(settings)
}

fn period_us<const LOW: u64, const HIGH: u64>(rate_hz: Count<LOW, HIGH>) -> u64 {
    (US_PER_S / rate_hz.get() as f64).round() as u64
}

/// Earth's magnetic field, NED [gauss], which is refused where gravity is not Earth's, unless it is so for
/// PX4.
fn earths_field(
    source: &Source,
    site: &Environment,
    epoch_unix_us: u64,
    px4: Px4Clock,
) -> Result<Vector3<f64>, ConfigError> {
    let refuse = |message| source.refuse("sensors.magnetometer.field", message);
    if !site.has_earths_gravity() && px4 != Px4Clock::Froude {
        return Err(refuse(format!(
            "expected \"dipole\" where site.gravity_m_s2 is {}: the World Magnetic Model is Earth's",
            site.gravity_m_s2
        )));
    }
    earth_ned_gauss(&site.anchor, epoch_unix_us as i64 / 1_000_000)
        .map_err(|e| refuse(format!("{e}; the day is that of epoch_unix_us, the place the site's")))
}
