//! PX4 under another gravity, by Froude's similarity.
//!
//! PX4 has `g0 = 9.80665 m/s^2` compiled in; under `g` a vehicle and its image under `g0` move alike when lengths and masses are the
//! same and time runs `k = sqrt(g0/g)` times faster: velocities and rates times k, accelerations times k^2, and forces too, so that
//! attitude, thrust over weight and the commands to the motors stay as they are. So everything that has seconds in its unit is
//! scaled where a message becomes bytes or is read, and nowhere else: the sessions live in the site's units and time, **the wire is
//! PX4's**.
//!
//! PX4 wants a HIL_SENSOR every 4 ms of its clock. The simulator's step is that times k, to the microsecond, and k is the ratio of
//! the two, so that whole steps are whole steps on both sides (1.35 m/s^2: 10.781 ms, k = 2.69525, 1.3e-5 beside the root).
//! Pressure and magnetic field are not scaled: PX4 makes an altitude, a length, of the one, and a direction of the other.

use mavlink::dialects::common::{COMMAND_LONG_DATA, MavCmd, MavMessage};

use super::TimeUs;
use super::parachute::{T_END, T_RELEASE};
use crate::units::STANDARD_GRAVITY_M_S2;

/// Period of HIL_SENSOR on PX4's clock.
const PX4_STEP_US: TimeUs = 4_000;

/// The scale between a site and the wire of a PX4 that lives under standard gravity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Froude {
    step_us: TimeUs,
}

impl Froude {
    /// For a site's gravity [m/s^2].
    pub fn under(gravity_m_s2: f64) -> Self {
        let k = (STANDARD_GRAVITY_M_S2 / gravity_m_s2).sqrt();
        Self { step_us: ((PX4_STEP_US as f64 * k).round() as TimeUs).max(1) }
    }

    /// How much faster time runs for PX4: k.
    pub fn k(self) -> f64 {
        self.step_us as f64 / PX4_STEP_US as f64
    }

    /// The simulator's step, 4 ms of PX4's clock, in the site's time.
    pub fn step_us(self) -> TimeUs {
        self.step_us
    }

    /// The site's time of a time on the wire.
    pub fn site_us(self, wire_us: TimeUs) -> TimeUs {
        ratio(wire_us, self.step_us, PX4_STEP_US)
    }

    /// The time on the wire of a time of the site's.
    pub fn wire_us(self, site_us: TimeUs) -> TimeUs {
        ratio(site_us, PX4_STEP_US, self.step_us)
    }

    /// A message in the site's units as PX4 is to read it. What has no seconds in it stays; so does a message that samara does not
    /// send to PX4 or its companions.
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

/// What is too much for the field is its largest value.
fn scale_i16<const N: usize>(fields: [&mut i16; N], factor: f64) {
    fields.into_iter().for_each(|x| *x = (f64::from(*x) * factor).round() as i16);
}

fn scale_u16<const N: usize>(fields: [&mut u16; N], factor: f64) {
    fields.into_iter().for_each(|x| *x = (f64::from(*x) * factor).round() as u16);
}
