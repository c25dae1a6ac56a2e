//! Parameters that a vehicle is given: what it must show before it is released. The vehicle does what PX4's
//! `mavlink_parameters.cpp` does after v1.17, where PARAM_ERROR tells the kinds of refusal; MAVLink's kinds
//! that PX4 does not use are there too.

use std::collections::BTreeMap;

use mavlink::dialects::common::*;

use super::scripted_px4::{ALIGNED, PASS, ScriptedPx4, Writing};
use super::scripted_vehicle::WILLING;
use super::*;
use crate::params::Value;
use crate::params::px4_required::DropEnvelope;

const DELAY: &str = "SENS_GPS0_DELAY";
const OLD_DELAY: &str = "EKF2_GPS_DELAY";

/// A vehicle after v1.17 that is to be given these, of a drop whose satellite fixes are 110 ms old.
fn given(parameters: &[(&str, Value)]) -> ScriptedPx4 {
    let parameters: BTreeMap<_, _> = parameters.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect();
    let mut px4 = ScriptedPx4::with(Some(ALIGNED), PASS, WILLING, |config| {
        let envelope = DropEnvelope { satellite_delay_s: Some(0.11), ..DropEnvelope::default() };
        let uploads = Uploads::of_one(parameters);
        config.procedure = Some(Procedure { envelope, uploads, ..Procedure::default() });
    });
    px4.lacks.push(OLD_DELAY);
    px4
}

/// v1.18.0-beta1: an INT32 of that name, and none of the old one. Sent as REAL32 it was refused, the refusal
/// was read as absence, and every drop was late.
#[test]
fn regress_the_age_of_satellite_fixes_reaches_a_px4_that_has_it_as_a_whole_number() {
    let mut px4 = given(&[(DELAY, Value::Real(110.0)), (OLD_DELAY, Value::Real(110.0))]);
    px4.on_board.insert(DELAY, (Value::Int(10), Writing::Takes));
    px4.until(StreamerState::Hanging);
    let (delay, _) = px4.on_board[DELAY];
    assert_eq!(delay, Value::Int(110));
    let reports = px4.reports();
    assert!(reports.contains(&"1 parameters set, each echoed".to_owned()), "{reports:#?}");
}

/// A required parameter that is refused or reads back as something else: no release, and the reason by name.
#[test]
fn what_a_vehicle_does_not_take_stops_the_drop_before_the_release() {
    use MavParamError::*;
    let real = Value::Real;
    for (has, writing, words) in [
        (real(10.0), Writing::Keeps, "reads back as 10"),
        (real(10.0), Writing::Refuses(MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE), "out of range there"),
        (real(10.0), Writing::Refuses(MAV_PARAM_ERROR_READ_ONLY), "read-only there"),
        (real(10.0), Writing::Refuses(MAV_PARAM_ERROR_PERMISSION_DENIED), "not permitted"),
        (real(10.0), Writing::Refuses(MAV_PARAM_ERROR_TYPE_MISMATCH), "of another type there"),
    ] {
        let mut px4 = given(&[(DELAY, real(110.0))]);
        px4.on_board.insert(DELAY, (has, writing));
        px4.until(StreamerState::Failed);
        assert_eq!(px4.armings(), 0);
        let failure = px4.script.streamer.failure().unwrap().to_owned();
        let expected =
            format!("the vehicle does not take {DELAY} = 110 ({words}): it would not fly what was meant");
        assert_eq!(failure, expected);
    }
}

/// What is told to another station about the same name is not told to us.
#[test]
fn an_error_that_is_anothers_does_not_count() {
    let mut px4 = given(&[(DELAY, Value::Real(110.0))]);
    px4.on_board.insert(DELAY, (Value::Int(10), Writing::Takes));
    px4.until(StreamerState::Parameters);
    let error = MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST;
    while px4.script.streamer.state() == StreamerState::Parameters {
        px4.refuse(DELAY, error, (255, 190));
        px4.step();
    }
    assert_eq!(px4.on_board[DELAY].0, Value::Int(110));
}

/// A name that a version does not have is reported, and the drop goes on: releases differ.
#[test]
fn a_parameter_that_is_not_there_is_reported_and_no_more() {
    let mut px4 = given(&[("MPC_ONCE", Value::Real(1.0)), (DELAY, Value::Real(110.0))]);
    px4.lacks.push("MPC_ONCE");
    px4.until(StreamerState::Hanging);
    let reports = px4.reports();
    let words = "1 parameters set, each echoed; unknown to this autopilot: MPC_ONCE";
    assert!(reports.contains(&words.to_owned()), "{reports:#?}");
}

/// What every version has and this one does not answer about, four times, is no value to fly by, whether it
/// was to be set or only to be looked at; what is not required is said and no more.
#[test]
fn regress_a_required_parameter_that_is_never_answered_stops_the_drop() {
    for name in ["COM_DISARM_PRFLT", "MPC_THR_MAX"] {
        for set in [&[(DELAY, Value::Real(110.0))][..], &[("COM_DISARM_PRFLT", Value::Real(-1.0))]] {
            let mut px4 = given(set);
            px4.silent.push(name);
            px4.until(StreamerState::Failed);
            let failure = px4.script.streamer.failure().unwrap_or_default().to_owned();
            assert_eq!(failure, format!("the vehicle does not answer what {name} is: a drop depends on it"));
        }
    }
    let mut px4 = given(&[("MPC_ONCE", Value::Real(1.0)), (DELAY, Value::Real(110.0))]);
    px4.silent.push("MPC_ONCE");
    px4.until(StreamerState::Hanging);
    let words = "1 parameters set, each echoed; not answered: MPC_ONCE";
    assert!(px4.reports().contains(&words.to_owned()), "{:#?}", px4.reports());
}
