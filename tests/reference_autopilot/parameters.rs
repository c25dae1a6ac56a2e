//! Parameters: listed, read, set in flight, refused, kept.

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use nalgebra::Vector3;
use samara::control::{Controller, Gains, Measurement, Setpoint};
use samara::link::Link;
use samara::params::{ParameterFile, Purpose, Value};

use super::bench::{
    Bench, COMPANION, Sent, VEHICLE, acks, actuators, cascade, command, last, texts, velocity,
};

/// PARAM_VALUE on a link, in order.
pub fn values(sent: &[Sent], link: Link) -> Vec<PARAM_VALUE_DATA> {
    sent.iter()
        .filter(|(l, _)| *l == link)
        .filter_map(|(_, f)| match f.known() {
            Some(MavMessage::PARAM_VALUE(m)) => Some(m.clone()),
            _ => None,
        })
        .collect()
}

fn list_request() -> MavMessage {
    // QGroundControl asks every component.
    MavMessage::PARAM_REQUEST_LIST(PARAM_REQUEST_LIST_DATA { target_system: VEHICLE, target_component: 0 })
}

pub fn set(name: &str, param_value: f32, param_type: MavParamType) -> MavMessage {
    MavMessage::PARAM_SET(PARAM_SET_DATA {
        param_value,
        target_system: VEHICLE,
        target_component: 1,
        param_id: name.into(),
        param_type,
    })
}

const REAL: MavParamType = MavParamType::MAV_PARAM_TYPE_REAL32;

pub fn read(name: &str, param_index: i16) -> MavMessage {
    MavMessage::PARAM_REQUEST_READ(PARAM_REQUEST_READ_DATA {
        param_index,
        target_system: VEHICLE,
        target_component: 1,
        param_id: name.into(),
    })
}

/// The whole list, one step after another.
pub fn all_parameters(bench: &mut Bench, link: Link) -> Vec<PARAM_VALUE_DATA> {
    assert!(values(&bench.send(link, &list_request()), link).is_empty());
    let mut got = Vec::new();
    loop {
        let some = values(&bench.step(), link);
        assert!(some.len() <= 5, "a few at a time");
        if some.is_empty() {
            return got;
        }
        got.extend(some);
    }
}

#[test]
fn regress_parameters_are_listed_densely_and_read_by_name_or_index() {
    let mut bench = Bench::running();
    let listed = all_parameters(&mut bench, Link::GroundStation);
    let (hash, values) = listed.split_first().unwrap();
    assert_eq!((hash.param_id.to_str(), hash.param_index), (Ok("_HASH_CHECK"), 65_535));
    assert_eq!(hash.param_type, MavParamType::MAV_PARAM_TYPE_UINT32);
    assert_eq!(hash.param_value.to_bits(), bench.session.parameters().hash());
    assert!(values.len() > 80);
    for (i, value) in values.iter().enumerate() {
        assert_eq!((usize::from(value.param_index), usize::from(value.param_count)), (i, values.len()));
        for request in [read(value.param_id.to_str().unwrap(), -1), read("", i as i16)] {
            let sent = bench.send(Link::Api, &request);
            let Some(MavMessage::PARAM_VALUE(got)) = last(&sent, Link::Api, 22) else { panic!() };
            assert_eq!(
                (got.param_id, got.param_value.to_bits()),
                (value.param_id, value.param_value.to_bits())
            );
        }
    }
    let named = |name: &str| values.iter().find(|v| v.param_id.to_str() == Ok(name)).unwrap();
    assert_eq!(named("MPC_Z_VEL_P_ACC").param_value, 3.5727);
    assert_eq!(named("MAV_SYS_ID").param_value.to_bits(), u32::from(VEHICLE), "integers travel as bytes");
    assert!(values.is_sorted_by(|a, b| a.param_id.to_str().unwrap() < b.param_id.to_str().unwrap()));
    for (request, index) in [(read("NO_SUCH", -1), -1), (read("", 9999), 9999)] {
        let sent = bench.send(Link::Api, &request);
        let Some(MavMessage::PARAM_ERROR(error)) = last(&sent, Link::Api, 345) else { panic!() };
        assert_eq!(error.error, MavParamError::MAV_PARAM_ERROR_DOES_NOT_EXIST);
        assert_eq!((error.param_index, error.target_system, error.target_component), (index, 245, 191));
    }
}

/// A ground station that knows all values by their checksum stops the list; asked for again, it starts over.
#[test]
fn regress_the_checksum_stops_the_list() {
    let mut bench = Bench::running();
    bench.send(Link::GroundStation, &list_request());
    let first = values(&bench.step(), Link::GroundStation);
    assert_eq!(first[0].param_id.to_str(), Ok("_HASH_CHECK"));
    let stop = set("_HASH_CHECK", first[0].param_value, MavParamType::MAV_PARAM_TYPE_UINT32);
    bench.send(Link::GroundStation, &stop);
    assert!(values(&bench.run(0.5), Link::GroundStation).is_empty());
    bench.send(Link::GroundStation, &list_request());
    bench.step();
    bench.send(Link::GroundStation, &list_request());
    assert_eq!(values(&bench.step(), Link::GroundStation)[0].param_index, 0);
    let sent = bench.send(Link::Api, &read("_HASH_CHECK", -1));
    let hash = &values(&sent, Link::Api)[0];
    assert_eq!((hash.param_index, hash.param_value.to_bits()), (65_535, first[0].param_value.to_bits()));
}

/// The flight with a gain set after a second is the flight of a cascade whose gain is set then, integrals
/// kept, to the bit.
#[test]
fn closed_form_a_gain_set_in_flight_acts_at_the_next_step_and_integrals_stay() {
    let mut bench = Bench::engaged();
    let velocity = velocity([1.0, 0.0, 2.0], 0x0DC7);
    bench.state.vz = 3.0;
    bench.state.pitchspeed = 0.1;
    bench.send(Link::Api, &MavMessage::SET_POSITION_TARGET_LOCAL_NED(velocity));
    bench.run(0.5);
    let measurement = Measurement {
        q_ned_from_body: [1.0, 0.0, 0.0, 0.0],
        v_ned: Vector3::new(0.0, 0.0, 3.0),
        omega_body: Vector3::new(0.0, f64::from(0.1f32), 0.0),
        bus_v: None,
        pack_a: None,
    };
    let setpoint = |v_ned| Setpoint::Velocity { v_ned, a_ff_ned: Vector3::zeros(), yaw_rad: Some(0.0) };
    // At the velocity that there is, what is commanded beyond the weight comes of the integrals.
    let of_the_integrals = |controller: &dyn Controller| {
        controller.clone_controller().step(&measurement, &setpoint(measurement.v_ned), 0.004)
    };
    let mut twin = bench.session.autopilot().controller().clone_controller();
    let integrals = of_the_integrals(&*twin);
    assert_ne!(integrals.thrust_n, of_the_integrals(&cascade()).thrust_n);
    let sent = bench.send(Link::Api, &set("MPC_Z_VEL_P_ACC", 1.5, REAL));
    for link in [Link::Api, Link::GroundStation] {
        assert_eq!(values(&sent, link)[0].param_value, 1.5, "told to all");
    }
    assert_eq!(of_the_integrals(bench.session.autopilot().controller()), integrals);
    let settings = bench.session.autopilot().control_settings();
    assert_eq!(settings.gains, Gains { k_pvz: 1.5, ..cascade().settings().gains });
    twin.configure(settings);
    let expected = twin.step(&measurement, &setpoint(Vector3::new(1.0, 0.0, 2.0)), 0.004);
    let controls = actuators(&bench.step()).controls;
    for (got, wanted) in controls.iter().zip(expected.throttle) {
        assert_eq!(*got, wanted as f32);
    }
}

#[test]
fn regress_refused_parameters_are_said_with_the_value_in_effect() {
    use MavParamError::*;
    let mut bench = Bench::running();
    let uint8 = MavParamType::MAV_PARAM_TYPE_UINT8;
    let int32 = MavParamType::MAV_PARAM_TYPE_INT32;
    for (name, value, kind, error, words) in [
        (
            "MPC_Z_VEL_P_ACC",
            f32::NAN,
            REAL,
            MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
            "NaN where 0 to 100 is expected",
        ),
        (
            "MPC_Z_VEL_P_ACC",
            1e6,
            REAL,
            MAV_PARAM_ERROR_VALUE_OUT_OF_RANGE,
            "1000000 where 0 to 100 is expected",
        ),
        ("MPC_Z_VEL_P_ACC", 2.0, int32, MAV_PARAM_ERROR_TYPE_MISMATCH, "type 9 (REAL32) expected"),
        ("MPC_Z_VEL_P_ACC", 2.0, uint8, MAV_PARAM_ERROR_TYPE_MISMATCH, "only 6 (INT32) and 9 (REAL32)"),
        ("MC_ROLL_P", 2.0, REAL, MAV_PARAM_ERROR_READ_ONLY, "follows MC_PITCH_P"),
        ("NO_SUCH", 2.0, REAL, MAV_PARAM_ERROR_DOES_NOT_EXIST, "unknown parameter NO_SUCH"),
    ] {
        let sent = bench.send(Link::Api, &set(name, value, kind));
        let Some(MavMessage::PARAM_ERROR(told)) = last(&sent, Link::Api, 345) else { panic!("{name}") };
        assert_eq!((told.error, told.param_id.to_str()), (error, Ok(name)));
        assert_eq!((told.target_system, told.target_component), COMPANION);
        assert!(texts(&sent, Link::Api).concat().contains(words), "{:?}", texts(&sent, Link::Api));
        let known = name != "NO_SUCH";
        assert_eq!(values(&sent, Link::Api).len(), usize::from(known), "the value in effect");
        assert!(last(&sent, Link::GroundStation, 345).is_none(), "the asking link only");
    }
    let Some(MavMessage::PARAM_VALUE(kept)) =
        last(&bench.send(Link::Api, &read("MPC_Z_VEL_P_ACC", -1)), Link::Api, 22)
    else {
        panic!()
    };
    assert_eq!(kept.param_value, 3.5727);
    // A type that no enum knows.
    let mut payload = vec![0; 25];
    payload[4..6].copy_from_slice(&[VEHICLE, 1]);
    payload[6..16].copy_from_slice(b"MC_PITCH_P");
    payload[22] = 77;
    let bytes = bench.encoder(Link::Api).encode_payload(23, PARAM_SET_DATA::EXTRA_CRC, &payload);
    let sent = bench.send_bytes(Link::Api, &bytes);
    let Some(MavMessage::PARAM_ERROR(told)) = last(&sent, Link::Api, 345) else { panic!() };
    assert_eq!(told.error, MAV_PARAM_ERROR_TYPE_UNSUPPORTED);
}

#[test]
fn regress_parameters_are_kept_in_a_file_that_can_be_read_again() {
    let mut bench = Bench::running();
    bench.send(Link::Api, &set("RTL_RETURN_ALT", 42.0, REAL));
    let store = |what: f32| command(MavCmd::MAV_CMD_PREFLIGHT_STORAGE, &[what]);
    assert_eq!(acks(&bench.send(Link::GroundStation, &store(1.0)))[0].result, 0);
    let text = bench.session.take_saved_parameters().unwrap();
    let file = ParameterFile::parse(&text).unwrap();
    assert_eq!(file.purpose(), Some(Purpose::Samara));
    assert_eq!(
        (file.len(), file.get("RTL_RETURN_ALT")),
        (bench.session.parameters().len(), Some(Value::Real(42.0)))
    );
    let mut other = Bench::running();
    assert_eq!(other.session.load_parameters(&file), Vec::<String>::new());
    assert_eq!(other.session.parameters().hash(), bench.session.parameters().hash());
    assert_eq!(acks(&bench.send(Link::GroundStation, &store(2.0)))[0].result, 0);
    assert_eq!(bench.session.parameters().get("RTL_RETURN_ALT"), Some(Value::Real(60.0)));
    let mut armed = Bench::engaged();
    let sent = armed.send(Link::GroundStation, &store(1.0));
    assert_eq!(acks(&sent)[0].result, 1);
    assert!(armed.session.take_saved_parameters().is_none());
}
