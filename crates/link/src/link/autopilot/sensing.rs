//! Flying on the sensors: HIL_SENSOR and HIL_GPS as the estimator's samples and fixes, its estimate as the
//! state.
//!
//! Fields count as `fields_updated` says; inertial readings only all six together. Altitudes are PX4's, by
//! the pressure, and positions from the anchor of the site, so that the filter's origin is the local frame's
//! and home's. A HIL_GPS bears the time of its sending: its fix is of EKF2_GPS_DELAY before. (MAVLink calls
//! its `eph` and `epv` dilutions; simulators and PX4 mean centimetres.)

use mavlink::dialects::common::*;
use nalgebra::Vector3;

use crate::autopilot::estimator::{Estimator, Fix, Inertial, Sample};
use crate::link::wire::{INERTIAL, MAGNETOMETER, geo_point, vector};
use crate::model::Environment;
use crate::sim::sensors::barometer::pressure_altitude_m;
use crate::time::TimeUs;

const PRESSURE: HilSensorUpdatedFlags = HilSensorUpdatedFlags::HIL_SENSOR_UPDATED_ABS_PRESSURE;
/// The least `fix_type` that has an altitude.
pub(super) const FIX_3D: u8 = GpsFixType::GPS_FIX_TYPE_3D_FIX as u8;

/// Gives the estimator the sensors of a step, and before them the latest fix. One that has been taken is not
/// taken again, and one from the future not yet.
pub(super) fn sense(
    estimator: &mut Estimator,
    sensor: &HIL_SENSOR_DATA,
    gps: Option<&HIL_GPS_DATA>,
    site: &Environment,
) {
    let usable = gps.filter(|gps| gps.fix_type >= FIX_3D && gps.time_usec <= sensor.time_usec);
    if let Some(fix) = usable.and_then(|gps| fix(gps, estimator.settings().gps_delay_us, site)) {
        estimator.take_fix(&fix);
    }
    if let Some(sample) = sample(sensor, site) {
        estimator.take(&sample);
    }
}

/// The fix in a HIL_GPS; `None` before the receiver's delay has passed once, when it would be of before the
/// beginning.
fn fix(m: &HIL_GPS_DATA, delay_us: TimeUs, site: &Environment) -> Option<Fix> {
    // Unknown is as good as the filter believes at best.
    let accuracy_m = |cm: u16| if cm == u16::MAX { 0.0 } else { f64::from(cm) / 100.0 };
    Some(Fix {
        at_us: m.time_usec.checked_sub(delay_us)?,
        p_ned: site.local_ned(&geo_point(m.lat, m.lon, m.alt)),
        v_ned: Vector3::from([m.vn, m.ve, m.vd].map(f64::from)) / 100.0,
        horizontal_m: accuracy_m(m.eph),
        vertical_m: accuracy_m(m.epv),
    })
}

/// The sample in a HIL_SENSOR; `None` without new readings of accelerometer and gyro.
fn sample(m: &HIL_SENSOR_DATA, site: &Environment) -> Option<Sample> {
    let has = |fields| m.fields_updated.contains(fields);
    let altitude_m = || pressure_altitude_m(f64::from(m.abs_pressure)) - site.anchor.altitude_m;
    has(INERTIAL).then(|| Sample {
        at_us: m.time_usec,
        inertial: Inertial {
            specific_force_body: vector([m.xacc, m.yacc, m.zacc]),
            omega_body: vector([m.xgyro, m.ygyro, m.zgyro]),
        },
        field_body: has(MAGNETOMETER).then(|| vector([m.xmag, m.ymag, m.zmag])),
        altitude_m: has(PRESSURE).then(altitude_m),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::environment::GeoPoint;

    fn site() -> Environment {
        let anchor = GeoPoint { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 600.0 };
        Environment::new(9.8, 1.2, Vector3::zeros(), anchor).unwrap()
    }

    fn sensor(fields: u32) -> HIL_SENSOR_DATA {
        HIL_SENSOR_DATA {
            time_usec: 4_000,
            zacc: -9.8,
            xmag: 0.2,
            abs_pressure: 943.224,
            fields_updated: HilSensorUpdatedFlags::from_bits_retain(fields),
            ..HIL_SENSOR_DATA::default()
        }
    }

    #[test]
    fn closed_form_only_what_is_updated_is_read() {
        let read = |fields| {
            sample(&sensor(fields), &site()).map(|s| (s.field_body.is_some(), s.altitude_m.is_some()))
        };
        for (fields, expected) in [
            (0x1BFF, Some((true, true))),
            (0x03F, Some((false, false))),
            (0x0FF, Some((false, false))),
            (0x23F, Some((false, true))),
            (0x1C7, None),
            (0, None),
        ] {
            assert_eq!(read(fields), expected, "{fields:#x}");
        }
        // The standard atmosphere at 600 m: 943.22 hPa.
        let altitude_m = sample(&sensor(0x23F), &site()).unwrap().altitude_m.unwrap();
        assert!(altitude_m.abs() < 1.0, "{altitude_m}");
    }

    #[test]
    fn closed_form_a_fix_is_of_its_delay_ago_from_the_anchor() {
        let m = HIL_GPS_DATA {
            time_usec: 500_000,
            lat: 470_000_090,
            lon: 80_000_000,
            alt: 590_000,
            vd: -250,
            eph: 90,
            epv: u16::MAX,
            ..HIL_GPS_DATA::default()
        };
        let f = fix(&m, 110_000, &site()).unwrap();
        assert_eq!(
            (f.at_us, f.v_ned, f.horizontal_m, f.vertical_m),
            (390_000, Vector3::new(0.0, 0.0, -2.5), 0.9, 0.0)
        );
        // 9e-6 deg on a sphere of 6371 km.
        assert!((f.p_ned - Vector3::new(1.0008, 0.0, 10.0)).norm() < 1e-3, "{}", f.p_ned);
        assert_eq!(fix(&m, 500_001, &site()), None);
    }
}
