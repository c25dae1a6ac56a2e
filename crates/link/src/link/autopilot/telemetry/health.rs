//! How good the state is, for crews: the sensors' health in SYS_STATUS, and ESTIMATOR_STATUS.

use mavlink::dialects::common::*;

use crate::autopilot::estimator::{Accuracy, Estimator, NotAligned};
use crate::link::autopilot::vehicle::Vehicle;
use crate::time::TimeUs;

/// Gyroscope, accelerometer, magnetometer, barometer, satellites, ready to arm: what MAVSDK's health looks
/// at.
pub(super) const SENSORS: u32 = 0x1000_002F;
/// Bits of SYS_STATUS.
const GYRO_AND_ACCELEROMETER: u32 = 0x03;
const MAGNETOMETER: u32 = 0x04;
const BAROMETER: u32 = 0x08;
const SATELLITES: u32 = 0x20;
const READY_TO_ARM: u32 = 0x1000_0000;
/// ESTIMATOR_STATUS when everything but a height above ground is known.
const KNOWN: u16 = 0x033F;

/// The bits of SYS_STATUS that are not healthy.
pub(super) fn ailing(now: TimeUs, vehicle: &Vehicle) -> u32 {
    let ready = vehicle.state(now).is_some();
    let Some(estimator) = &vehicle.estimator else { return if ready { 0 } else { SENSORS } };
    let sensor = match estimator.check_aligned() {
        Ok(()) if ready => return 0,
        Ok(()) | Err(NotAligned::NoInertial) => GYRO_AND_ACCELEROMETER,
        Err(NotAligned::NoMagnetometer) => MAGNETOMETER,
        Err(NotAligned::NoBarometer) => BAROMETER,
        Err(NotAligned::NoSatellites | NotAligned::NoFix) => SATELLITES,
        Err(
            NotAligned::NotCarried
            | NotAligned::Starting
            | NotAligned::Tilt
            | NotAligned::Heading
            | NotAligned::Velocity,
        ) => 0,
    };
    sensor | READY_TO_ARM
}

/// ESTIMATOR_STATUS, once there is a state. The truth errs by nothing.
pub(super) fn estimator_status(now: TimeUs, vehicle: &Vehicle) -> Option<MavMessage> {
    vehicle.latest_state()?;
    let mut message = ESTIMATOR_STATUS_DATA { time_usec: now, ..ESTIMATOR_STATUS_DATA::DEFAULT };
    let known = match &vehicle.estimator {
        Some(estimator) => fill(&mut message, estimator)?,
        None => KNOWN,
    };
    message.flags =
        EstimatorStatusFlags::from_bits_retain(if vehicle.state(now).is_some() { known } else { 0 });
    Some(MavMessage::ESTIMATOR_STATUS(message))
}

/// Fills in the filter's accuracy and returns the flags of what it knows. Ratios are innovations over their
/// gates, as PX4 sends them.
fn fill(message: &mut ESTIMATOR_STATUS_DATA, estimator: &Estimator) -> Option<u16> {
    let (accuracy, ratios) = (estimator.accuracy()?, &estimator.filter()?.ratios);
    let ratio = |squared: f64| squared.sqrt() as f32;
    message.vel_ratio = ratio(ratios.velocity);
    message.pos_horiz_ratio = ratio(ratios.position);
    message.pos_vert_ratio = ratio(ratios.height);
    message.mag_ratio = ratio(ratios.heading);
    message.pos_horiz_accuracy = accuracy.horizontal_m as f32;
    message.pos_vert_accuracy = accuracy.vertical_m as f32;
    let refused = [ratios.velocity, ratios.position].into_iter().any(|ratio| !(ratio <= 1.0));
    Some(flags(&accuracy, estimator.check_aligned().is_ok(), refused))
}

fn flags(accuracy: &Accuracy, aligned: bool, fix_refused: bool) -> u16 {
    const ATTITUDE: u16 = 0x0001;
    const VELOCITY: u16 = 0x0006;
    // Horizontal (relative, absolute, and both as predicted) and vertical.
    const POSITION: u16 = 0x0338;
    const GPS_GLITCH: u16 = 0x0400;
    let bits = [
        (ATTITUDE, accuracy.knows_tilt() && accuracy.knows_heading()),
        (VELOCITY, accuracy.knows_velocity()),
        (POSITION, aligned),
        (GPS_GLITCH, fix_refused),
    ];
    bits.into_iter().filter(|(_, holds)| *holds).map(|(bit, _)| bit).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_flags_show_what_is_known() {
        let good = Accuracy {
            tilt_rad: 0.01,
            heading_rad: 0.02,
            speed_m_s: 0.1,
            horizontal_m: 0.5,
            vertical_m: 0.8,
        };
        assert_eq!(flags(&good, true, false), KNOWN);
        assert_eq!(flags(&good, true, true), KNOWN | 0x400);
        assert_eq!(flags(&good, false, false), 0x0007);
        assert_eq!(flags(&Accuracy { tilt_rad: 0.2, ..good }, false, false), 0x0006);
        assert_eq!(flags(&Accuracy { speed_m_s: f64::NAN, ..good }, false, false), 0x0001);
    }
}
