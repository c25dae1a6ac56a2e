//! SET_ATTITUDE_TARGET and SET_POSITION_TARGET_LOCAL_NED read as setpoints: what the type masks mean.
//!
//! A bit that is set means "ignore". Flown are, as PX4 names them:
//!
//! | message | type mask | what |
//! |---|---|---|
//! | SET_POSITION_TARGET_LOCAL_NED | 0x0DF8 | position |
//! | | 0x0DC0 | position with velocity feed-forward |
//! | | 0x0DE3 | height, horizontal velocity |
//! | | 0x0C3F | acceleration |
//! | | 0x0DC7 | velocity |
//! | | 0x09C7, 0x05C7, 0x01C7 | velocity and yaw, yaw rate, or both |
//! | | 0x0C07, 0x0807, 0x0407 | the same with acceleration feed-forward |
//! | SET_POSITION_TARGET_GLOBAL_INT | the same | position by latitude, longitude and altitude |
//! | SET_ATTITUDE_TARGET | 0x07 | attitude and thrust |
//! | | 0x80 | body rates and thrust |
//!
//! in frame LOCAL_NED (1) or BODY_NED (8: turned by the heading; the yaw stays absolute, as in PX4; a
//! position is not taken there). North and east of a kind come together or not at all; every axis needs one
//! of the three kinds. Acceleration beside a position or velocity is fed forward. A yaw rate beside a yaw has
//! the yaw go on turning until the next setpoint. What is not flown is refused with its reason, never flown
//! in part; as in PX4 the bit that makes forces of accelerations (0x200) counts only where there are any, and
//! a global position only whole. GLOBAL_INT's altitude is above mean sea level (frame 5) or above home (6).

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use nalgebra::Vector3;

use super::vehicle::Vehicle;
use crate::autopilot::{Autopilot, OffboardSetpoint, SetpointRefusal, Severity, VelocityFrame, YawSetpoint};
use crate::link::frame::Frame;
use crate::link::wire::{geo_point, vector};
use crate::model::Environment;
use crate::time::TimeUs;

/// Why a setpoint message is not flown; the text for the crew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum SetpointFault {
    /// A position in a frame that turns with the vehicle.
    #[error("setpoint refused: no position in BODY_NED")]
    BodyPosition,
    /// A global frame other than the two that are flown.
    #[error("setpoint refused: GLOBAL_INT frame must be 5 or 6")]
    GlobalFrame,
    /// A latitude or longitude that is none.
    #[error("setpoint refused: no such place")]
    NoPlace,
    /// An altitude above a home that is not known.
    #[error("setpoint refused: no home yet")]
    NoHome,
    /// Force instead of acceleration.
    #[error("setpoint refused: force is not flown")]
    Force,
    /// One of two axes.
    #[error("setpoint refused: give north and east or neither")]
    PartialAxes,
    /// An axis with neither position nor velocity nor acceleration.
    #[error("setpoint refused: an axis has no setpoint")]
    EmptyAxis,
    /// A frame other than LOCAL_NED and BODY_NED.
    #[error("setpoint refused: frame must be 1 or 8")]
    Frame,
    /// Body rates that are not zero beside an attitude.
    #[error("setpoint refused: attitude or rates, not both")]
    AttitudeAndRates,
    /// Neither attitude nor rates.
    #[error("setpoint refused: needs attitude or rates")]
    NoAttitude,
    /// No thrust.
    #[error("setpoint refused: needs thrust")]
    NoThrust,
    /// Thrust along three axes.
    #[error("setpoint refused: thrust vector is not flown")]
    ThrustVector,
    /// Numbers that cannot be flown.
    #[error(transparent)]
    Value(#[from] SetpointRefusal),
}

/// The setpoint in a frame, or why it is not flown, with the system and component that it is addressed to;
/// `None` for any other message.
pub(super) fn read(
    frame: &Frame,
    vehicle: &Vehicle,
) -> Option<((u8, u8), Result<OffboardSetpoint, SetpointFault>)> {
    /// Where both messages have the target system in their payload.
    const TARGET_AT: usize = 50;
    match frame.known() {
        Some(MavMessage::SET_POSITION_TARGET_LOCAL_NED(m)) => Some((frame.target(), local_setpoint(m))),
        Some(MavMessage::SET_ATTITUDE_TARGET(m)) => Some((frame.target(), attitude_setpoint(m))),
        Some(MavMessage::SET_POSITION_TARGET_GLOBAL_INT(m)) => {
            let home = vehicle.home.place_ned();
            Some((frame.target(), global_setpoint(m, &vehicle.environment, home.as_ref())))
        }
        // A frame that no enum knows is owed the same refusal as one that is not flown.
        None => {
            let fault = match frame.message_id {
                SET_POSITION_TARGET_LOCAL_NED_DATA::ID => SetpointFault::Frame,
                SET_POSITION_TARGET_GLOBAL_INT_DATA::ID => SetpointFault::GlobalFrame,
                _ => return None,
            };
            let p = frame.payload();
            Some(((p.u8(TARGET_AT), p.u8(TARGET_AT + 1)), Err(fault)))
        }
        _ => None,
    }
}

/// The [`Motion`] of either message, whose fields for it have the same names.
macro_rules! motion_of {
    ($message:ident) => {
        Motion {
            type_mask: $message.type_mask,
            v: [$message.vx, $message.vy, $message.vz],
            a: [$message.afx, $message.afy, $message.afz],
            yaw: $message.yaw,
            yaw_rate: $message.yaw_rate,
        }
    };
}

/// Reads SET_POSITION_TARGET_LOCAL_NED; its numbers are checked by the autopilot.
fn local_setpoint(message: &SET_POSITION_TARGET_LOCAL_NED_DATA) -> Result<OffboardSetpoint, SetpointFault> {
    #[expect(deprecated, reason = "PX4 takes it")]
    let frame = match message.coordinate_frame {
        MavFrame::MAV_FRAME_LOCAL_NED => VelocityFrame::Ned,
        MavFrame::MAV_FRAME_BODY_NED => VelocityFrame::Heading,
        _ => return Err(SetpointFault::Frame),
    };
    let p = axes(message.type_mask.bits(), 0, [message.x, message.y, message.z])?;
    if frame == VelocityFrame::Heading && p.iter().any(Option::is_some) {
        return Err(SetpointFault::BodyPosition);
    }
    motion_of!(message).setpoint(frame, p)
}

/// Reads SET_POSITION_TARGET_GLOBAL_INT in the place of an environment, with home in NED [m] where it is
/// known.
fn global_setpoint(
    message: &SET_POSITION_TARGET_GLOBAL_INT_DATA,
    environment: &Environment,
    home_ned: Option<&Vector3<f64>>,
) -> Result<OffboardSetpoint, SetpointFault> {
    let is_whole = message.type_mask.bits() & 0b111 == 0;
    let p = if is_whole { global_place(message, environment, home_ned)?.map(Some) } else { [None; 3] };
    motion_of!(message).setpoint(VelocityFrame::Ned, p)
}

/// The position of a SET_POSITION_TARGET_GLOBAL_INT, NED [m].
fn global_place(
    message: &SET_POSITION_TARGET_GLOBAL_INT_DATA,
    environment: &Environment,
    home_ned: Option<&Vector3<f64>>,
) -> Result<[f64; 3], SetpointFault> {
    let altitude_m = f64::from(message.alt);
    #[expect(deprecated, reason = "PX4 takes these")]
    let down_m = match message.coordinate_frame {
        MavFrame::MAV_FRAME_GLOBAL_INT => environment.anchor.altitude_m - altitude_m,
        MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT => home_ned.ok_or(SetpointFault::NoHome)?.z - altitude_m,
        _ => return Err(SetpointFault::GlobalFrame),
    };
    let place = geo_point(message.lat_int, message.lon_int, 0);
    if !(place.latitude_deg.abs() < 90.0 && place.longitude_deg.abs() <= 180.0) {
        return Err(SetpointFault::NoPlace);
    }
    let level = environment.local_ned(&place);
    Ok([level.x, level.y, down_m])
}

/// What both messages say beside a position.
struct Motion {
    type_mask: PositionTargetTypemask,
    v: [f32; 3],
    a: [f32; 3],
    yaw: f32,
    yaw_rate: f32,
}

impl Motion {
    fn setpoint(&self, frame: VelocityFrame, p: [Option<f64>; 3]) -> Result<OffboardSetpoint, SetpointFault> {
        use PositionTargetTypemask as Mask;
        let (flags, mask) = (self.type_mask, self.type_mask.bits());
        let v = axes(mask, 3, self.v)?;
        let a = axes(mask, 6, self.a)?;
        if a.iter().any(Option::is_some) && flags.contains(Mask::POSITION_TARGET_TYPEMASK_FORCE_SET) {
            return Err(SetpointFault::Force);
        }
        if (0..3).any(|i| p[i].is_none() && v[i].is_none() && a[i].is_none()) {
            return Err(SetpointFault::EmptyAxis);
        }
        let gives = |ignore| !flags.contains(ignore);
        let (yaw, yaw_rate) =
            (Mask::POSITION_TARGET_TYPEMASK_YAW_IGNORE, Mask::POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE);
        let yaw = match (gives(yaw), gives(yaw_rate)) {
            (false, false) => YawSetpoint::Keep,
            (true, false) => YawSetpoint::Angle(f64::from(self.yaw)),
            (false, true) => YawSetpoint::Rate(f64::from(self.yaw_rate)),
            (true, true) => {
                YawSetpoint::Turning { angle: f64::from(self.yaw), rate: f64::from(self.yaw_rate) }
            }
        };
        // Velocity along three axes, with three accelerations or none.
        if let ([None, None, None], [Some(north), Some(east), Some(down)]) = (p, v)
            && (a.iter().all(Option::is_some) || a.iter().all(Option::is_none))
        {
            let a_ff = a.map(|a| a.unwrap_or(0.0)).into();
            return Ok(OffboardSetpoint::Velocity { frame, v: Vector3::new(north, east, down), a_ff, yaw });
        }
        Ok(OffboardSetpoint::Place { frame, p, v, a, yaw })
    }
}

/// The axes of one kind that a mask does not ignore.
fn axes(mask: u16, shift: u32, values: [f32; 3]) -> Result<[Option<f64>; 3], SetpointFault> {
    let given = |i: usize| mask >> shift & 1 << i == 0;
    if given(0) != given(1) {
        return Err(SetpointFault::PartialAxes);
    }
    Ok(std::array::from_fn(|i| given(i).then_some(f64::from(values[i]))))
}

/// Reads SET_ATTITUDE_TARGET; its numbers are checked by the autopilot.
fn attitude_setpoint(message: &SET_ATTITUDE_TARGET_DATA) -> Result<OffboardSetpoint, SetpointFault> {
    use AttitudeTargetTypemask as Mask;
    let (flags, mask) = (message.type_mask, message.type_mask.bits());
    if flags.contains(Mask::ATTITUDE_TARGET_TYPEMASK_THRUST_BODY_SET) {
        return Err(SetpointFault::ThrustVector);
    }
    if flags.contains(Mask::ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE) {
        return Err(SetpointFault::NoThrust);
    }
    let collective = f64::from(message.thrust);
    let rates = [message.body_roll_rate, message.body_pitch_rate, message.body_yaw_rate];
    if !flags.contains(Mask::ATTITUDE_TARGET_TYPEMASK_ATTITUDE_IGNORE) {
        // Zero rates beside an attitude say nothing: scripts that leave the mask at 0 send them.
        let rates_count = (0..3).any(|i| mask & 1 << i == 0 && rates[i] != 0.0);
        if rates_count {
            return Err(SetpointFault::AttitudeAndRates);
        }
        return Ok(OffboardSetpoint::Attitude { q_ned_from_body: message.q.map(f64::from), collective });
    }
    match mask & 0b111 {
        0b000 => Ok(OffboardSetpoint::Rates { omega_body: vector(rates), collective }),
        0b111 => Err(SetpointFault::NoAttitude),
        _ => Err(SetpointFault::PartialAxes),
    }
}

/// Hands setpoints to the autopilot. A fault is reported once in ten seconds, not fifty times a second while
/// a stream of bad setpoints lasts.
#[derive(Clone, Debug, Default)]
pub(super) struct SetpointInput {
    reported: Vec<(SetpointFault, TimeUs)>,
}

impl SetpointInput {
    const QUIET_US: TimeUs = 10_000_000;

    /// Offers the autopilot a setpoint that was read, or reports why it is not flown.
    pub(super) fn handle(
        &mut self,
        now: TimeUs,
        setpoint: Result<OffboardSetpoint, SetpointFault>,
        autopilot: &mut Autopilot,
    ) {
        let taken = setpoint.and_then(|setpoint| Ok(autopilot.offer_setpoint(now, setpoint)?));
        if let Err(fault) = taken
            && self.is_news(now, fault)
        {
            autopilot.say(Severity::Error, fault.to_string());
        }
    }

    fn is_news(&mut self, now: TimeUs, fault: SetpointFault) -> bool {
        let recent =
            |(f, at): &(SetpointFault, TimeUs)| *f == fault && now.saturating_sub(*at) < Self::QUIET_US;
        if self.reported.iter().any(recent) {
            return false;
        }
        self.reported.retain(|(f, _)| *f != fault);
        self.reported.push((fault, now));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::environment::GeoPoint;
    use crate::units::EARTH_RADIUS_M;

    fn velocity(mask: u16) -> SET_POSITION_TARGET_LOCAL_NED_DATA {
        SET_POSITION_TARGET_LOCAL_NED_DATA {
            coordinate_frame: MavFrame::MAV_FRAME_LOCAL_NED,
            type_mask: PositionTargetTypemask::from_bits_retain(mask),
            vx: 1.0,
            vy: 2.0,
            vz: 3.0,
            afx: 4.0,
            afy: 5.0,
            afz: 6.0,
            yaw: 0.5,
            yaw_rate: 0.25,
            ..Default::default()
        }
    }

    #[test]
    fn regress_px4_type_masks_of_velocity() {
        let none = Vector3::zeros();
        let a = Vector3::new(4.0, 5.0, 6.0);
        for (mask, a_ff, yaw) in [
            (0x0DC7, none, YawSetpoint::Keep),
            (0x09C7, none, YawSetpoint::Angle(0.5)),
            (0x05C7, none, YawSetpoint::Rate(0.25)),
            (0x01C7, none, YawSetpoint::Turning { angle: 0.5, rate: 0.25 }),
            // Force, without an acceleration that could be one.
            (0x0FC7, none, YawSetpoint::Keep),
            (0x0C07, a, YawSetpoint::Keep),
            (0x0807, a, YawSetpoint::Angle(0.5)),
            (0x0407, a, YawSetpoint::Rate(0.25)),
        ] {
            let expected = OffboardSetpoint::Velocity {
                frame: VelocityFrame::Ned,
                v: Vector3::new(1.0, 2.0, 3.0),
                a_ff,
                yaw,
            };
            assert_eq!(local_setpoint(&velocity(mask)), Ok(expected), "{mask:#06x}");
        }
        for (mask, fault) in [
            (0x0DC6, SetpointFault::PartialAxes),
            (0x0E07, SetpointFault::Force),
            (0x0DCF, SetpointFault::PartialAxes),
            (0x0D47, SetpointFault::PartialAxes),
            (0x0DFF, SetpointFault::EmptyAxis),
            (0x0DE7, SetpointFault::EmptyAxis),
            (0x0DFC, SetpointFault::EmptyAxis),
        ] {
            assert_eq!(local_setpoint(&velocity(mask)), Err(fault), "{mask:#06x}");
        }
        for (frame, fault) in [
            (MavFrame::MAV_FRAME_GLOBAL, SetpointFault::Frame),
            (MavFrame::MAV_FRAME_BODY_FRD, SetpointFault::Frame),
        ] {
            let message = SET_POSITION_TARGET_LOCAL_NED_DATA { coordinate_frame: frame, ..velocity(0x0DC7) };
            assert_eq!(local_setpoint(&message), Err(fault));
        }
    }

    #[test]
    fn regress_px4_type_masks_of_position_and_acceleration() {
        let position =
            |mask: u16| SET_POSITION_TARGET_LOCAL_NED_DATA { x: 7.0, y: 8.0, z: 9.0, ..velocity(mask) };
        let (p, v, a) = ([7.0, 8.0, 9.0].map(Some), [1.0, 2.0, 3.0].map(Some), [4.0, 5.0, 6.0].map(Some));
        let none = [None; 3];
        for (mask, p, v, a, yaw) in [
            (0x0DF8, p, none, none, YawSetpoint::Keep),
            (0x0DC0, p, v, none, YawSetpoint::Keep),
            (0x0800, p, v, a, YawSetpoint::Angle(0.5)),
            (0x0DE3, [None, None, p[2]], [v[0], v[1], None], none, YawSetpoint::Keep),
            (0x05F8, p, none, none, YawSetpoint::Rate(0.25)),
            (0x0C3F, none, none, a, YawSetpoint::Keep),
            (0x0CC7, none, v, [None, None, a[2]], YawSetpoint::Keep),
        ] {
            let expected = OffboardSetpoint::Place { frame: VelocityFrame::Ned, p, v, a, yaw };
            assert_eq!(local_setpoint(&position(mask)), Ok(expected), "{mask:#06x}");
        }
        let body = |mask: u16| {
            #[expect(deprecated, reason = "PX4 takes it")]
            let frame = MavFrame::MAV_FRAME_BODY_NED;
            local_setpoint(&SET_POSITION_TARGET_LOCAL_NED_DATA { coordinate_frame: frame, ..position(mask) })
        };
        assert_eq!(body(0x0DF8), Err(SetpointFault::BodyPosition));
        assert!(matches!(body(0x0C3F), Ok(OffboardSetpoint::Place { frame: VelocityFrame::Heading, .. })));
    }

    /// Closed form: a ten-thousandth of a degree north and east of the anchor at 47 deg, 30 m above it or 30
    /// m above a home that is 10 m above it; as PX4 has it, a position that is not whole is none.
    #[test]
    fn closed_form_global_setpoints() {
        let anchor = GeoPoint { latitude_deg: 47.0, longitude_deg: 8.0, altitude_m: 600.0 };
        let environment = Environment::new(9.80665, 1.2, Vector3::zeros(), anchor).unwrap();
        #[expect(deprecated, reason = "PX4 takes them")]
        let (msl, above_home) = (MavFrame::MAV_FRAME_GLOBAL_INT, MavFrame::MAV_FRAME_GLOBAL_RELATIVE_ALT_INT);
        let message = |frame, mask: u16, alt: f32| SET_POSITION_TARGET_GLOBAL_INT_DATA {
            coordinate_frame: frame,
            type_mask: PositionTargetTypemask::from_bits_retain(mask),
            lat_int: 470_001_000,
            lon_int: 80_001_000,
            alt,
            vx: 1.0,
            vy: 2.0,
            vz: 3.0,
            yaw: 0.5,
            ..Default::default()
        };
        let home = Vector3::new(5.0, 5.0, -10.0);
        let read = |message: &_, home| global_setpoint(message, &environment, home);
        let degree_m = EARTH_RADIUS_M.to_radians();
        for (frame, alt, down_m) in [(msl, 630.0, -30.0), (above_home, 30.0, -40.0)] {
            let Ok(OffboardSetpoint::Place { p: [Some(north), Some(east), Some(down)], v, yaw, .. }) =
                read(&message(frame, 0x09F8, alt), Some(&home))
            else {
                panic!("no position")
            };
            let expected = [1e-4 * degree_m, 1e-4 * degree_m * crate::math::cos(47f64.to_radians()), down_m];
            for (found, expected) in [north, east, down].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{found} {expected}");
            }
            assert_eq!((v, yaw), ([None; 3], YawSetpoint::Angle(0.5)));
        }
        let velocity = Vector3::new(1.0, 2.0, 3.0);
        for mask in [0x0DC7, 0x0DC4, 0x0DC1] {
            let read = read(&message(msl, mask, 630.0), None);
            let is_velocity = |s| matches!(s, OffboardSetpoint::Velocity { v, .. } if v == velocity);
            assert!(read.is_ok_and(is_velocity), "{mask:#06x}: {read:?}");
        }
        for (message, fault) in [
            (message(above_home, 0x0DF8, 30.0), SetpointFault::NoHome),
            (message(MavFrame::MAV_FRAME_LOCAL_NED, 0x0DF8, 30.0), SetpointFault::GlobalFrame),
            (message(msl, 0x0DFC, 30.0), SetpointFault::EmptyAxis),
            (
                SET_POSITION_TARGET_GLOBAL_INT_DATA { lat_int: i32::MAX, ..message(msl, 0x0DF8, 630.0) },
                SetpointFault::NoPlace,
            ),
        ] {
            assert_eq!(read(&message, None), Err(fault));
        }
    }

    #[test]
    fn regress_px4_type_masks_of_attitude() {
        let attitude = |mask: u8, rate: f32| {
            attitude_setpoint(&SET_ATTITUDE_TARGET_DATA {
                q: [1.0, 0.0, 0.0, 0.0],
                body_pitch_rate: rate,
                thrust: 0.25,
                type_mask: AttitudeTargetTypemask::from_bits_retain(mask),
                ..Default::default()
            })
        };
        let level = OffboardSetpoint::Attitude { q_ned_from_body: [1.0, 0.0, 0.0, 0.0], collective: 0.25 };
        assert_eq!(attitude(0x07, 1.0), Ok(level));
        assert_eq!(attitude(0x00, 0.0), Ok(level));
        assert_eq!(attitude(0x00, 0.1), Err(SetpointFault::AttitudeAndRates));
        let rates = OffboardSetpoint::Rates { omega_body: Vector3::new(0.0, 0.5, 0.0), collective: 0.25 };
        assert_eq!(attitude(0x80, 0.5), Ok(rates));
        assert_eq!(attitude(0x81, 0.5), Err(SetpointFault::PartialAxes));
        assert_eq!(attitude(0x87, 0.5), Err(SetpointFault::NoAttitude));
        assert_eq!(attitude(0x47, 0.0), Err(SetpointFault::NoThrust));
        assert_eq!(attitude(0x27, 0.0), Err(SetpointFault::ThrustVector));
    }
}
