//! MAV_CMD_INJECT_FAILURE (420) as orders about faults: parameter 1 the unit, 2 the type, 3 the instance,
//! from 1; 0 or none: all that there are.
//!
//! What is not a whole number, no type of MAVLink's or no instance that is there is DENIED; a unit or a type
//! that has no fault here is UNSUPPORTED. [`CATALOGUE`] has what each injects.

use mavlink::dialects::common::{MavCmd, MavResult};

use super::frame::Command;
use crate::sim::faults::catalogue::{FailureType, FailureUnit};
use crate::sim::faults::{CATALOGUE, FaultOrder};

/// The command's number.
pub(super) const INJECT_FAILURE: u16 = MavCmd::MAV_CMD_INJECT_FAILURE as u16;
/// FAILURE_TYPE_OK, and the greatest type, FAILURE_TYPE_INTERMITTENT.
const OK: u16 = 0;
const GREATEST_TYPE: u16 = 7;

/// The orders of a command to a vehicle with so many rotors.
///
/// # Errors
/// The result that the command is answered with when it is not obeyed.
pub(super) fn orders(command: &Command, rotors: usize) -> Result<Vec<FaultOrder>, MavResult> {
    const DENIED: MavResult = MavResult::MAV_RESULT_DENIED;
    const UNSUPPORTED: MavResult = MavResult::MAV_RESULT_UNSUPPORTED;
    let number = |place| command.param(place).and_then(whole).ok_or(DENIED);
    let (unit, kind) = (number(1)?, number(2)?);
    let instance = command.param(3).map_or(Some(0), whole).ok_or(DENIED)?;
    if kind > GREATEST_TYPE {
        return Err(DENIED);
    }
    let unit = FailureUnit::ALL.into_iter().find(|u| *u as u16 == unit).ok_or(UNSUPPORTED)?;
    let there = if unit == FailureUnit::Motor { rotors } else { 1 };
    let instances = match usize::from(instance) {
        0 => 1..=there,
        instance if instance <= there => instance..=instance,
        _ => return Err(DENIED),
    };
    if kind == OK {
        return Ok(instances.map(|instance| FaultOrder::End(unit.of(instance))).collect());
    }
    let injects = |command: Option<(FailureUnit, _)>| {
        command.is_some_and(|(of, injected)| of == unit && injected as u16 == kind)
    };
    let entry = CATALOGUE.iter().find(|entry| injects(entry.command)).ok_or(UNSUPPORTED)?;
    let orders = instances.filter_map(|instance| entry.injected(instance).map(FaultOrder::Begin));
    Ok(orders.collect())
}

/// What a command is about, in words: `motor off, instance 2`.
pub(super) fn words(command: &Command) -> String {
    let [unit, kind, instance] = [1, 2, 3].map(|place| command.param(place).and_then(whole).unwrap_or(0));
    let named = FailureUnit::ALL.into_iter().find(|u| *u as u16 == unit);
    let unit = named.map_or(format!("unit {unit}"), |unit| unit.name().to_owned());
    let kind = FailureType::ALL
        .into_iter()
        .find(|k| *k as u16 == kind)
        .map_or(if kind == OK { "ok".to_owned() } else { format!("type {kind}") }, |k| k.name().to_owned());
    if instance == 0 { format!("{unit} {kind}") } else { format!("{unit} {kind}, instance {instance}") }
}

/// The motor that a command switches off, or makes sound again, counted from 0; `None` in its place: all.
pub(super) fn motor_off(command: &Command) -> Option<(Option<u8>, bool)> {
    let [unit, kind] = [1, 2].map(|place| command.param(place).and_then(whole));
    let is_off = match kind? {
        OK => false,
        kind if kind == FailureType::Off as u16 => true,
        _ => return None,
    };
    let instance = command.param(3).map_or(Some(0), whole)?;
    let motor = instance.checked_sub(1).map(|motor| u8::try_from(motor).unwrap_or(u8::MAX));
    (unit? == FailureUnit::Motor as u16).then_some((motor, is_off))
}

/// A whole number as the wire's floats hold it.
fn whole(x: f32) -> Option<u16> {
    (x >= 0.0 && x.fract() == 0.0 && x <= f32::from(u16::MAX)).then_some(x as u16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::FaultKind;
    use crate::sim::faults::{FaultUnit, MotorFault, Sensor, SensorFault};

    fn read(params: [f32; 3]) -> Result<Vec<FaultOrder>, MavResult> {
        let [p1, p2, p3] = params;
        orders(&Command { params: [p1, p2, p3, 0.0, 0.0, 0.0, 0.0], ..Command::default() }, 4)
    }

    /// The numbers of MAVLink's common dialect.
    #[test]
    fn reference_units_types_and_instances_are_mavlinks() {
        let off = |rotor| FaultOrder::Begin(FaultKind::Motor { rotor, fault: MotorFault::Off });
        assert_eq!(read([101.0, 1.0, 2.0]), Ok(vec![off(2)]));
        assert_eq!(read([101.0, 1.0, 0.0]), Ok((1..=4).map(off).collect()));
        assert_eq!(read([101.0, 1.0, f32::NAN]), read([101.0, 1.0, 0.0]));
        assert_eq!(read([101.0, 0.0, 3.0]), Ok(vec![FaultOrder::End(FaultUnit::Motor(3))]));
        for (unit, sensor) in [0.0, 1.0, 2.0, 3.0, 4.0].into_iter().zip(Sensor::ALL) {
            let stuck = FaultKind::Sensor { sensor, fault: SensorFault::Stuck };
            assert_eq!(read([unit, 2.0, 1.0]), Ok(vec![FaultOrder::Begin(stuck)]));
            assert_eq!(read([unit, 0.0, 0.0]), Ok(vec![FaultOrder::End(FaultUnit::Sensor(sensor))]));
        }
        assert_eq!(read([105.0, 1.0, 0.0]), Ok(vec![FaultOrder::Begin(FaultKind::SetpointLoss)]));
    }

    #[test]
    fn what_is_not_there_is_unsupported_and_what_means_nothing_is_denied() {
        // Flow, battery, servo, RC; a delayed gyro, an intermittent motor, a slow magnetometer.
        for params in
            [[5.0, 1.0], [100.0, 1.0], [102.0, 1.0], [104.0, 1.0], [0.0, 6.0], [101.0, 7.0], [2.0, 5.0]]
        {
            let [unit, kind] = params;
            assert_eq!(read([unit, kind, 0.0]), Err(MavResult::MAV_RESULT_UNSUPPORTED), "{params:?}");
        }
        let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.5, f32::MAX, 65_536.0];
        let each = odd.into_iter().flat_map(|x| [[x, 1.0, 1.0], [101.0, x, 1.0], [101.0, 1.0, x]]);
        // An instance that is not given is all of them.
        let denied = each.filter(|params| !params[2].is_nan());
        for params in denied.chain([[101.0, 1.0, 5.0], [0.0, 1.0, 2.0], [101.0, 8.0, 1.0]]) {
            assert_eq!(read(params), Err(MavResult::MAV_RESULT_DENIED), "{params:?}");
        }
    }
}
