//! What is fuzzed, as plain functions: `fuzz/fuzz_targets/` hands them to libFuzzer, `tests/fuzz.rs` replays the kept inputs
//! and some thousand mutations of them.
//!
//! Whatever the bytes are: no panic, no endless loop, and what is said to hold beside each target.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use mavlink::Message as _;
use mavlink::dialects::common::{ATTITUDE_DATA, HEARTBEAT_DATA, HIL_SENSOR_DATA, MavMessage};
use samara::assess::logged_drop::LoggedDrop;
use samara::autopilot::parameters::Parameters;
use samara::checksum::crc32_iso;
use samara::config::foreign::{KnownVehicle, known_vehicle};
use samara::config::{
    Mission, decode_plan_grid, load_gains, load_mission, load_parameters, load_vehicle, read_flight_table,
    read_trajectory_csv,
};
use samara::control::{Airframe, ControlSettings};
use samara::link::px4_events::{Event, EventTexts};
use samara::link::streamer::Procedure;
use samara::link::{
    AutopilotSession, AutopilotSetup, Decoder, Encoder, Hub, HubConfig, Link, Session as _, StreamerConfig,
    StreamerSession,
};
use samara::logged_flight::Series;
use samara::trajectory::{Node, Trajectory};
use samara::ulog::Ulog;

/// A target: takes any bytes, and panics where something is wrong.
pub type Target = fn(&[u8]);

/// The targets by name.
pub const TARGETS: [(&str, Target); 14] = [
    ("decoder", decoder),
    ("services", services),
    ("streamer", streamer),
    ("events", events),
    ("mission", mission),
    ("vehicle", vehicle),
    ("gains", gains),
    ("trajectory", trajectory),
    ("params", params),
    ("plan_grid", plan_grid),
    ("ulog", ulog),
    ("flight_table", flight_table),
    ("airframe", airframe),
    ("sdf", sdf),
];

/// Bytes off a wire. However a stream is cut, the frames are the same; and what is counted adds up.
pub fn decoder(data: &[u8]) {
    let frames = |chunk: usize| {
        let mut decoder = Decoder::new();
        let mut frames = Vec::new();
        for bytes in data.chunks(chunk.max(1)) {
            decoder.push(bytes);
            while let Some(frame) = decoder.next_frame() {
                frames.push(frame.bytes().to_vec());
            }
        }
        let held: usize = frames.iter().map(Vec::len).sum();
        let faults = decoder.faults();
        let passed = faults.skipped_bytes + faults.unknown_bytes;
        assert_eq!(held + passed as usize + decoder.pending(), data.len());
        frames
    };
    assert!(frames(data.len()) == frames(1 + data.len() % 13), "depends on how it is cut");
    let mut hub: Hub<u8> =
        Hub::new(HubConfig { own: (1, 1), memory_us: 1_000_000, forwards: true, key: None });
    let endpoint = hub.add_endpoint(Link::GroundStation);
    for (i, bytes) in data.chunks(64).enumerate() {
        hub.datagram(i as u64 * 1000, endpoint, i as u8, bytes, |frame| {
            let _ = (frame.target(), frame.command(), frame.set_mode(), frame.command_ack());
        });
    }
}

/// Frames of any content, soundly framed, at the reference autopilot: link, message number, length, payload, and so on.
/// Its motors stay in range.
pub fn services(data: &[u8]) {
    static WAITING: LazyLock<AutopilotSession> = LazyLock::new(autopilot);
    let mut session = WAITING.clone();
    let mut decoder = Decoder::new();
    let mut encoders = [Encoder::new(255, 190), Encoder::new(245, 190), Encoder::new(1, 200)];
    let mut rest = data;
    let mut now = 0;
    while let [link, low, high, len, tail @ ..] = rest {
        let payload = &tail[..tail.len().min(usize::from(*len))];
        rest = &tail[payload.len()..];
        let id = u32::from(u16::from_le_bytes([*low, *high]));
        let which = usize::from(*link % 3);
        let by = [Link::GroundStation, Link::Api, Link::Simulator][which];
        let bytes = encoders[which].encode_payload(id, MavMessage::extra_crc(id), payload);
        decoder.datagram(&bytes, |frame| session.handle_input(by, &frame));
        now = session.time().unwrap_or(now).saturating_add(4000);
        let sensor = HIL_SENSOR_DATA { time_usec: now, zacc: -1.35, ..Default::default() };
        let step = encoders[2].encode(&MavMessage::HIL_SENSOR(sensor));
        decoder.datagram(&step, |frame| session.handle_input(Link::Simulator, &frame));
        while let Some(sent) = session.poll_output() {
            let check = |frame: samara::link::Frame| {
                if let Some(MavMessage::HIL_ACTUATOR_CONTROLS(m)) = frame.known() {
                    assert!(m.controls.iter().all(|c| (0.0..=1.0).contains(c)), "{:?}", m.controls);
                }
            };
            decoder.datagram(&sent.bytes, check);
        }
    }
}

/// Frames of any content, soundly framed, at the streamer in the names of its autopilot and its parachute: who, message number,
/// length, payload, and so on. What it reports acts on no terminal and is bounded, and so is what it sends.
pub fn streamer(data: &[u8]) {
    static MET: LazyLock<StreamerSession> = LazyLock::new(met_streamer);
    let mut session = MET.clone();
    let mut decoder = Decoder::new();
    let mut encoders = [Encoder::new(1, 1), Encoder::new(1, 161)];
    let (mut rest, mut time_boot_ms) = (data, 1_000);
    while let [who, low, high, len, tail @ ..] = rest {
        let payload = &tail[..tail.len().min(usize::from(*len))];
        rest = &tail[payload.len()..];
        let id = u32::from(u16::from_le_bytes([*low, *high]));
        let bytes = encoders[usize::from(*who % 2)].encode_payload(id, MavMessage::extra_crc(id), payload);
        decoder.datagram(&bytes, |frame| session.handle_input(Link::Api, &frame));
        time_boot_ms += 4;
        let clock = MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms, ..Default::default() });
        decoder.datagram(&encoders[0].encode(&clock), |frame| session.handle_input(Link::Api, &frame));
        while let Some(event) = session.poll_event() {
            let text = event.to_string();
            assert!(!text.contains(char::is_control) && text.len() < 500_000, "{text:?}");
        }
        let sent = std::iter::from_fn(|| session.poll_output()).count();
        assert!(sent < 100, "{sent} frames at once");
    }
}

/// Metadata of PX4's events: what is taken has texts for all events, which act on no terminal and are bounded.
pub fn events(data: &[u8]) {
    let Ok(texts) = EventTexts::parse(data) else { return };
    for id in (0..=0xFF).flat_map(|number| [number, 1 << 24 | number]) {
        for byte in [0, 1, 0xFF] {
            let event = Event { id, sequence: 0, level: 0, arguments: [byte; 40] };
            if let Some(text) = texts.text(&event) {
                assert!(!text.contains(char::is_control) && text.len() <= 10_000, "{text:?}");
            }
        }
    }
}

/// A mission file beside the project's vehicles and gains.
pub fn mission(data: &[u8]) {
    if let Ok(mission) = load_mission(&put("mission/fuzzed.json", data)) {
        assert!(mission.release.hang_s.is_finite() && mission.duration_s.is_finite());
    }
}

/// A vehicle file.
pub fn vehicle(data: &[u8]) {
    if let Ok(file) = load_vehicle(&put("params/vehicles/fuzzed.json", data)) {
        assert!(!file.vehicle.rotors.is_empty());
    }
}

/// A gains file.
pub fn gains(data: &[u8]) {
    let _ = load_gains(&put("params/gains/fuzzed.json", data));
}

/// A trajectory: what is taken has finite values wherever it is looked at.
pub fn trajectory(data: &[u8]) {
    if let Ok(trajectory) = read_trajectory_csv(&put("fuzzed.csv", data)) {
        for i in 0..10 {
            let v_ned = trajectory.velocity_ned(f64::from(i));
            assert!(v_ned.iter().all(|x| x.is_finite()), "{v_ned}");
        }
    }
}

/// A PX4 parameter file: what is taken and written again is taken again.
pub fn params(data: &[u8]) {
    if let Ok(file) = load_parameters(&put("fuzzed.params", data)) {
        assert!(file.len() <= 16_384 && file.remarks().len() <= 32, "{:?}", file.remarks());
        assert!(file.own().all(|(_, entry)| entry.value.as_f64().is_finite()));
    }
}

/// An airframe's script.
pub fn airframe(data: &[u8]) {
    known(&put("4019_fuzzed", data));
}

/// A model of Gazebo's.
pub fn sdf(data: &[u8]) {
    known(&put("mission/fuzzed.sdf", data));
}

/// What is taken of a vehicle is finite, and its rotors are as many as a vehicle has.
fn known(file: &Path) {
    let Ok(KnownVehicle { numbers, rotors, .. }) = known_vehicle(&[file.to_owned()]) else { return };
    assert!(numbers.values().all(|number| number.value.is_finite()));
    let rotors = rotors.map_or(Vec::new(), |known| known.value.rotors);
    assert!(rotors.is_empty() || (3..=8).contains(&rotors.len()));
    assert!(rotors.iter().all(|rotor| rotor.position_body_m.iter().all(|x| x.is_finite())));
}

/// A grid of plans, with the checksum that it has and with the right one: what is taken has finite values wherever
/// it is looked at.
pub fn plan_grid(data: &[u8]) {
    let mut sealed = data.to_vec();
    if let Some(end) = data.len().checked_sub(4) {
        let checksum = crc32_iso(&data[..end]);
        sealed[end..].copy_from_slice(&checksum.to_le_bytes());
    }
    for bytes in [data, &sealed] {
        if let Ok(file) = decode_plan_grid(bytes) {
            for state in [[0.0; 4], [0.1, 9.0, -0.2, 0.3], [f64::MAX; 4], [f64::NAN; 4]] {
                let plan = file.grid.at(&state).trajectory;
                let v_ned = plan.velocity_ned(0.5 * plan.end_s());
                assert!(v_ned.iter().all(|x| x.is_finite()), "{v_ned}");
            }
        }
    }
}

/// Writes what is fuzzed to where a file of its kind would be, in a copy of the project's folders.
fn put(name: &str, data: &[u8]) -> PathBuf {
    static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = std::env::temp_dir().join(format!("samara-fuzz-{}", std::process::id()));
        for part in ["mission", "params/vehicles", "params/gains", "params/px4"] {
            std::fs::create_dir_all(folder.join(part)).unwrap();
            for entry in std::fs::read_dir(project().join(part)).into_iter().flatten() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    std::fs::copy(&path, folder.join(part).join(path.file_name().unwrap())).unwrap();
                }
            }
        }
        folder
    });
    let path = FOLDER.join(name);
    std::fs::write(&path, data).unwrap();
    path
}

fn project() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    if here.ends_with("fuzz") { here.parent().unwrap_or(here) } else { here }
}

/// A streamer that has met its vehicle.
fn met_streamer() -> StreamerSession {
    let node = |t_s: f64, down_m_s: f64| Node {
        t_s,
        q_ned_from_body: samara::frames::LEVEL,
        v_ned: nalgebra::Vector3::new(0.0, 0.0, down_m_s),
        omega_body: nalgebra::Vector3::zeros(),
        thrust_n: Default::default(),
        a_ned: nalgebra::Vector3::zeros(),
    };
    let nodes = vec![node(0.0, 9.0), node(2.0, 1.0)];
    let config = StreamerConfig { procedure: Some(Procedure::default()), ..StreamerConfig::default() };
    let mut session = StreamerSession::new(config, Trajectory::new(nodes, 4).unwrap());
    let mut vehicle = Encoder::new(1, 1);
    let beat = MavMessage::HEARTBEAT(HEARTBEAT_DATA::default());
    let clock = MavMessage::ATTITUDE(ATTITUDE_DATA { time_boot_ms: 1_000, ..Default::default() });
    for message in [beat, clock] {
        Decoder::new().datagram(&vehicle.encode(&message), |frame| session.handle_input(Link::Api, &frame));
    }
    session
}

fn autopilot() -> AutopilotSession {
    let m: Mission = load_mission(&project().join("mission/titan_drop.json")).unwrap();
    let airframe = Airframe::new(&m.vehicle, &m.site.environment).unwrap();
    AutopilotSession::new(AutopilotSetup {
        system_id: 1,
        control: ControlSettings { airframe, gains: m.control.gains, limits: m.control.limits },
        controller: None,
        environment: m.site.environment.clone(),
        estimator: None,
        rotors: m.vehicle.rotors.len(),
        epoch_unix_us: m.epoch_unix_us,
        parameters: Parameters::of(&m.parameter_subject(), 1).unwrap(),
        keeps_parameters: false,
    })
}

/// A flight log. All columns have as many values as there are rows, and what is lost lies in order in the file.
pub fn ulog(data: &[u8]) {
    let Ok(log) = Ulog::read(data) else { return };
    for topic in log.topics().take(64) {
        let columns: Vec<&str> = topic.columns().take(256).collect();
        for column in columns {
            assert_eq!(log.values(topic, column).unwrap().count(), topic.len());
        }
    }
    assert!(log.lost.is_sorted_by(|a, b| a.end <= b.start) && log.lost.iter().all(|part| !part.is_empty()));
    assert!(log.lost.last().is_none_or(|part| part.end <= data.len()));
}

/// A flight in a table. Times rise, all columns have as many values, and what is found of a drop is of numbers and in order.
pub fn flight_table(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(flight) = read_flight_table(text, Path::new("fuzzed.csv")) else { return };
    fn is_sound<const N: usize>(series: &Option<Series<N>>) {
        let Some(series) = series else { return };
        assert_eq!(series.t_s.len(), series.values.len());
        assert!(series.t_s.is_sorted_by(|a, b| a < b));
    }
    is_sound(&flight.motors);
    is_sound(&flight.rotor_speeds_rad_s);
    is_sound(&flight.force_body_m_s2);
    is_sound(&flight.rates_body_rad_s);
    is_sound(&flight.attitude);
    is_sound(&flight.velocity_ned_m_s);
    // A flight of days is looked through for as long.
    if flight.end_s() < 3600.0
        && let Ok(drop) = LoggedDrop::of(&flight, 9.80665, 0.5)
    {
        assert!(drop.samples.is_sorted_by(|a, b| a.t_s < b.t_s));
        assert!(drop.samples.iter().all(|sample| sample.state.body.v_ned.iter().all(|x| x.is_finite())));
    }
}
