//! PX4 under another gravity, by Froude's similarity.
//!
//! PX4 has `g0 = 9.80665 m/s^2` compiled in; under `g` a vehicle and its image under `g0` move alike when
//! lengths and masses are the same and time runs `k = sqrt(g0/g)` times faster: velocities and rates times k,
//! accelerations times k^2, and forces too, so that attitude, thrust over weight and the commands to the
//! motors stay as they are. So everything that has seconds in its unit is scaled where a message becomes
//! bytes or is read, and nowhere else: the sessions live in the site's units and time, **the wire is PX4's**.
//!
//! PX4 wants a HIL_SENSOR every 4 ms of its clock. The simulator's step is that times k, to the microsecond,
//! and k is the ratio of the two, so that whole steps are whole steps on both sides (1.35 m/s^2: 10.781 ms, k
//! = 2.69525, 1.3e-5 beside the root). Pressure and magnetic field are not scaled: PX4 makes an altitude, a
//! length, of the one, and a direction of the other.

use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavMessage};

use crate::control::px4::timing::IMU_PERIOD_US;
use crate::time::TimeUs;
use crate::units::STANDARD_GRAVITY_M_S2;

/// Name of the NAMED_VALUE_INT that carries the instant of the release [ms].
pub const T_RELEASE: &str = "t_release";
/// Name of the NAMED_VALUE_INT that carries the end of the simulation [ms].
pub const T_END: &str = "t_end";

/// The scale between a site and the wire of a PX4 that lives under standard gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Froude {
    step_us: TimeUs,
}

impl Froude {
    /// For a site's gravity [m/s^2].
    pub fn under(gravity_m_s2: f64) -> Self {
        let k = (STANDARD_GRAVITY_M_S2 / gravity_m_s2).sqrt();
        Self { step_us: ((IMU_PERIOD_US as f64 * k).round() as TimeUs).max(1) }
    }

    /// Factor k by which time runs faster for PX4.
    pub fn k(self) -> f64 {
        self.step_us as f64 / IMU_PERIOD_US as f64
    }

    /// The simulator's step, 4 ms of PX4's clock, in the site's time.
    pub fn step_us(self) -> TimeUs {
        self.step_us
    }

    /// The site's time of a time on the wire.
    pub fn site_us(self, wire_us: TimeUs) -> TimeUs {
        ratio(wire_us, self.step_us, IMU_PERIOD_US)
    }

    /// The time on the wire of a time of the site's.
    pub fn wire_us(self, site_us: TimeUs) -> TimeUs {
        ratio(site_us, IMU_PERIOD_US, self.step_us)
    }

    /// A message in the site's units as PX4 is to read it. What has no seconds in it stays; so does a message
    /// that samara does not send to PX4 or its companions.
    pub fn wire_message(self, message: &MavMessage) -> MavMessage {
        let mut message = message.clone();
        let k = self.k();
        match &mut message {
            MavMessage::HIL_SENSOR(m) => {
                m.time_usec = self.wire_us(m.time_usec);
                scale([&mut m.xacc, &mut m.yacc, &mut m.zacc], k * k);
                scale([&mut m.xgyro, &mut m.ygyro, &mut m.zgyro], k);
                scale([&mut m.diff_pressure], k * k);
            }
            MavMessage::HIL_GPS(m) => {
                m.time_usec = self.wire_us(m.time_usec);
                scale_i16([&mut m.vn, &mut m.ve, &mut m.vd], k);
                scale_u16([&mut m.vel], k);
            }
            MavMessage::HIL_STATE_QUATERNION(m) => {
                m.time_usec = self.wire_us(m.time_usec);
                scale([&mut m.rollspeed, &mut m.pitchspeed, &mut m.yawspeed], k);
                scale_i16([&mut m.vx, &mut m.vy, &mut m.vz], k);
                scale_u16([&mut m.ind_airspeed, &mut m.true_airspeed], k);
                scale_i16([&mut m.xacc, &mut m.yacc, &mut m.zacc], k * k);
            }
            MavMessage::ODOMETRY(m) => {
                m.time_usec = self.wire_us(m.time_usec);
                scale([&mut m.vx, &mut m.vy, &mut m.vz], k);
                scale([&mut m.rollspeed, &mut m.pitchspeed, &mut m.yawspeed], k);
            }
            MavMessage::SET_ATTITUDE_TARGET(m) => {
                m.time_boot_ms = self.wire_ms(m.time_boot_ms);
                scale([&mut m.body_roll_rate, &mut m.body_pitch_rate, &mut m.body_yaw_rate], k);
            }
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(m) => {
                m.time_boot_ms = self.wire_ms(m.time_boot_ms);
                scale([&mut m.vx, &mut m.vy, &mut m.vz, &mut m.yaw_rate], k);
                scale([&mut m.afx, &mut m.afy, &mut m.afz], k * k);
            }
            MavMessage::NAMED_VALUE_INT(m) => {
                m.time_boot_ms = self.wire_ms(m.time_boot_ms);
                if matches!(m.name.to_str(), Ok(T_RELEASE | T_END)) {
                    let value = self.wire_ms(u32::try_from(m.value).unwrap_or(0));
                    m.value = i32::try_from(value).unwrap_or(i32::MAX);
                }
            }
            MavMessage::COMMAND_LONG(m) => self.wire_interval(m),
            _ => {}
        }
        message
    }

    /// The interval of a SET_MESSAGE_INTERVAL [us]; 0 and -1 are no intervals.
    fn wire_interval(self, m: &mut COMMAND_LONG_DATA) {
        if m.command == MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL && m.param2 > 0.0 {
            scale([&mut m.param2], 1.0 / self.k());
        }
    }

    fn wire_ms(self, site_ms: u32) -> u32 {
        u32::try_from(self.wire_us(TimeUs::from(site_ms))).unwrap_or(u32::MAX)
    }
}

/// `t * to / from`, to the nearest.
fn ratio(t: TimeUs, to: TimeUs, from: TimeUs) -> TimeUs {
    let product = u128::from(t) * u128::from(to) + u128::from(from / 2);
    TimeUs::try_from(product / u128::from(from)).unwrap_or(TimeUs::MAX)
}

fn scale<const N: usize>(fields: [&mut f32; N], factor: f64) {
    fields.into_iter().for_each(|x| *x = (f64::from(*x) * factor) as f32);
}

/// A value too large for the field becomes the field's largest.
fn scale_i16<const N: usize>(fields: [&mut i16; N], factor: f64) {
    fields.into_iter().for_each(|x| *x = (f64::from(*x) * factor).round() as i16);
}

fn scale_u16<const N: usize>(fields: [&mut u16; N], factor: f64) {
    fields.into_iter().for_each(|x| *x = (f64::from(*x) * factor).round() as u16);
}

#[cfg(test)]
mod tests {
    use mavlink::dialects::common::*;

    use super::*;

    const TITAN: f64 = 1.35;

    #[test]
    fn closed_form_titans_step_is_the_root_of_the_gravities_to_the_microsecond() {
        let froude = Froude::under(TITAN);
        assert_eq!((froude.step_us(), froude.k()), (10_781, 2.69525));
        assert!((froude.k() / (STANDARD_GRAVITY_M_S2 / TITAN).sqrt() - 1.0).abs() < 0.5 / 10_781.0);
        assert_eq!(Froude::under(STANDARD_GRAVITY_M_S2).k(), 1.0);
        assert_eq!(Froude::under(STANDARD_GRAVITY_M_S2 * 4.0).k(), 0.5);
    }

    /// Whole steps are whole steps on both sides, also in milliseconds; in between, a time comes back to half
    /// a unit of the coarser side.
    #[test]
    fn prop_times_survive_the_wire() {
        for gravity in [0.1, 1.35, 1.62, 3.71, 8.87, 9.80665, 24.8] {
            let froude = Froude::under(gravity);
            for n in [0, 1, 2, 3, 7, 250, 8_811, 83_000_000] {
                let (site, wire) = (n * froude.step_us(), n * 4_000);
                assert_eq!((froude.wire_us(site), froude.site_us(wire)), (wire, site), "{gravity} {n}");
                // What is cut off of a millisecond is less than half a one on the wire from k = 2 on.
                if froude.k() >= 2.0 {
                    assert_eq!(froude.wire_us(site / 1_000), n * 4, "{gravity} {n}");
                }
            }
            for t in [1, 999, 10_123_457, 899_999_999] {
                let back = froude.site_us(froude.wire_us(t));
                assert!(
                    back.abs_diff(t) as f64 <= (froude.k() / 2.0).max(0.5).ceil(),
                    "{gravity} {t} {back}"
                );
            }
        }
    }

    /// k = 2.5: every factor is exact.
    fn froude() -> Froude {
        let froude = Froude::under(STANDARD_GRAVITY_M_S2 / 6.25);
        assert_eq!(froude.k(), 2.5);
        froude
    }

    #[test]
    fn closed_form_what_has_seconds_in_it_is_scaled_and_nothing_else() {
        let sensor = HIL_SENSOR_DATA {
            time_usec: 20_000,
            zacc: -2.0,
            ygyro: 0.5,
            xmag: 0.25,
            abs_pressure: 900.0,
            pressure_alt: 988.0,
            temperature: 8.5,
            ..Default::default()
        };
        let expected = HIL_SENSOR_DATA { time_usec: 8_000, zacc: -12.5, ygyro: 1.25, ..sensor.clone() };
        assert_eq!(froude().wire_message(&MavMessage::HIL_SENSOR(sensor)), MavMessage::HIL_SENSOR(expected));

        let fix = HIL_GPS_DATA {
            time_usec: 20_000,
            lat: 70_000_000,
            alt: 1_000_000,
            eph: 90,
            vel: 500,
            vn: -300,
            vd: 400,
            cog: 18_000,
            ..Default::default()
        };
        let expected = HIL_GPS_DATA { time_usec: 8_000, vel: 1_250, vn: -750, vd: 1_000, ..fix.clone() };
        assert_eq!(froude().wire_message(&MavMessage::HIL_GPS(fix)), MavMessage::HIL_GPS(expected));

        let setpoint = SET_POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: 20,
            x: 3.0,
            vx: 4.0,
            vz: 4.0,
            afz: -1.0,
            yaw: 0.5,
            yaw_rate: 0.5,
            ..Default::default()
        };
        let expected = SET_POSITION_TARGET_LOCAL_NED_DATA {
            time_boot_ms: 8,
            vx: 10.0,
            vz: 10.0,
            afz: -6.25,
            yaw_rate: 1.25,
            ..setpoint.clone()
        };
        assert_eq!(
            froude().wire_message(&MavMessage::SET_POSITION_TARGET_LOCAL_NED(setpoint)),
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(expected)
        );
    }

    #[test]
    fn what_is_too_fast_for_an_integer_is_its_largest_value() {
        let fix = HIL_GPS_DATA { vn: -20_000, vd: 20_000, vel: 40_000, ..Default::default() };
        let MavMessage::HIL_GPS(m) = froude().wire_message(&MavMessage::HIL_GPS(fix)) else { unreachable!() };
        assert_eq!((m.vn, m.vd, m.vel), (i16::MIN, i16::MAX, u16::MAX));
    }

    #[test]
    fn instants_and_intervals_are_on_the_wires_clock() {
        let named = |name: &str, value| {
            let m = NAMED_VALUE_INT_DATA { time_boot_ms: 100, value, name: name.into() };
            match froude().wire_message(&MavMessage::NAMED_VALUE_INT(m)) {
                MavMessage::NAMED_VALUE_INT(m) => (m.time_boot_ms, m.value),
                _ => unreachable!(),
            }
        };
        assert_eq!(named(T_RELEASE, 10_000), (40, 4_000));
        assert_eq!(named("answer", 42), (40, 42), "not an instant");
        let interval = |command, param2| {
            let m = COMMAND_LONG_DATA { command, param1: 30.0, param2, ..Default::default() };
            match froude().wire_message(&MavMessage::COMMAND_LONG(m)) {
                MavMessage::COMMAND_LONG(m) => (m.param1, m.param2),
                _ => unreachable!(),
            }
        };
        assert_eq!(interval(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, 10_000.0), (30.0, 4_000.0));
        assert_eq!(interval(MavCmd::MAV_CMD_SET_MESSAGE_INTERVAL, -1.0), (30.0, -1.0));
        assert_eq!(interval(MavCmd::MAV_CMD_DO_SET_MODE, 6.0), (30.0, 6.0));
    }
}
