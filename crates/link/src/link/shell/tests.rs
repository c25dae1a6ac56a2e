//! The shell on real loopback sockets.

use std::net::UdpSocket;
use std::time::Duration;

use nalgebra::Vector3;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::sync::oneshot;

use mavlink::dialects::common::{HIL_ACTUATOR_CONTROLS_DATA, MavMessage};

use super::super::autopilot::{AutopilotSession, AutopilotSetup};
use super::super::decoder::Decoder;
use super::super::encoder::Encoder;
use super::super::frame::Frame;
use super::super::hil::{HilConfig, HilEvent, HilSession, Missing};
use super::super::streamer::{Clock, StreamerConfig, StreamerEvent, StreamerSession};
use super::ports::loopback;
use super::*;
use crate::autopilot::parameters::Parameters;
use crate::control::{Airframe, ControlLimits, ControlSettings, Gains};
use crate::params::Subject;
use crate::sim::{DropEvent, DropRunConfig};
use crate::test_site;
use crate::time::Timed;
use crate::trajectory::{Node, Trajectory};

/// Collects notices and completes its signal at the first one that the test waits for.
pub(super) struct Ears<W> {
    pub(super) notices: Vec<Notice>,
    wanted: W,
    heard: Option<oneshot::Sender<()>>,
}

impl<W: FnMut(&Notice) -> bool> Observer for Ears<W> {
    fn notice(&mut self, notice: Notice) {
        if (self.wanted)(&notice)
            && let Some(heard) = self.heard.take()
        {
            let _ = heard.send(());
        }
        self.notices.push(notice);
    }
}

/// Ears, and the future that completes when they have heard what they want, or after 20 s.
pub(super) fn ears<W: FnMut(&Notice) -> bool>(wanted: W) -> (Ears<W>, impl Future<Output = ()>) {
    let (heard, signal) = oneshot::channel();
    let patience = Duration::from_secs(20);
    let stop = async move { _ = tokio::time::timeout(patience, signal).await };
    (Ears { notices: Vec::new(), wanted, heard: Some(heard) }, stop)
}

pub(super) fn block_on<F: Future>(future: F) -> F::Output {
    tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap().block_on(future)
}

/// Ports that nobody has.
pub(super) fn free_ports() -> Ports {
    let sockets: Vec<UdpSocket> = (0..7).map(|_| UdpSocket::bind(loopback(0)).unwrap()).collect();
    let port = |i: usize| sockets[i].local_addr().unwrap().port();
    Ports {
        simulator: port(0),
        autopilot_ground: port(1),
        ground_station: port(2),
        autopilot_api: port(3),
        api: port(4),
        parachute: port(5),
        viewer: port(6),
    }
}

pub(super) fn simulator(duration_us: u64) -> HilSession {
    HilSession::new(
        test_site::drop_simulation(),
        HilConfig { run: DropRunConfig { duration_us, ..DropRunConfig::default() }, ..HilConfig::default() },
    )
}

pub(super) fn autopilot() -> AutopilotSession {
    let (vehicle, environment) = (test_site::vehicle(), test_site::environment());
    let airframe = Airframe::new(&vehicle, &environment).unwrap();
    let gains = Gains::longitudinal([8.0, 2.0, 4.0, 3.0, 1.0, 1.5, 0.2]);
    let limits = ControlLimits::default();
    let subject = Subject {
        vehicle: &vehicle,
        environment: &environment,
        gains: &gains,
        limits: &limits,
        speed_m_s: 9.0,
        tilt_from: None,
        pack: None,
    };
    AutopilotSession::new(AutopilotSetup {
        system_id: 1,
        control: ControlSettings { airframe, gains, limits: ControlLimits::default() },
        controller: None,
        environment: test_site::environment(),
        estimator: None,
        rotors: 4,
        epoch_unix_us: 0,
        parameters: Parameters::of(&subject, 1).unwrap(),
        keeps_parameters: false,
    })
}

pub(super) fn streamer() -> StreamerSession {
    streamer_by(Clock::Vehicle)
}

pub(super) fn streamer_by(clock: Clock) -> StreamerSession {
    let slow = Vector3::new(0.0, 0.0, 1.0);
    let nodes = vec![Node::level(0.0, Vector3::new(0.0, 0.0, 9.0)), Node::level(2.0, slow)];
    let plan = Trajectory::new(nodes, 4).unwrap();
    let config = StreamerConfig {
        hang_s: test_site::HANG_S,
        delay_s: test_site::DELAY_S,
        target_v_ned: slow,
        end_s: Some(4.0),
        clock,
        ..StreamerConfig::default()
    };
    StreamerSession::new(config, plan)
}

/// Without an autopilot it waits for one.
fn for_ever(speed: Speed) -> (Speed, Attendance) {
    (speed, Attendance::default())
}

pub(super) fn heard(notices: &[Notice], wanted: impl Fn(&Notice) -> bool) -> bool {
    notices.iter().any(wanted)
}

#[test]
fn three_parties_on_sockets_fly_the_drop() {
    let ports = free_ports();
    let nothing = |_: &Notice| false;
    let (mut a, stop_a) = ears(nothing);
    let (mut b, stop_b) = ears(nothing);
    let (mut c, stop_c) = ears(nothing);
    let wiring = Wiring::default();
    let (flown, _, streamed) = block_on(async {
        tokio::join!(
            run_simulator(simulator(9_000_000), &ports, for_ever(Speed::Factor(8.0)), None, &mut a, stop_a),
            run_autopilot(autopilot(), &ports, &wiring, AfterSimulator::Return, &mut b, stop_b),
            run_streamer(streamer(), &ports, None, &mut c, stop_c),
        )
    });
    let flown = flown.unwrap();
    assert!(streamed.unwrap().is_over(), "{:#?}", c.notices);
    assert!(heard(&a.notices, |n| matches!(
        n,
        Notice::Simulator(Timed { event: HilEvent::Drop(DropEvent::Released { .. }), .. })
    )));
    assert!(heard(&b.notices, |n| matches!(n, Notice::Autopilot { .. })));
    assert!(heard(&c.notices, |n| matches!(n, Notice::Streamer(Timed { event: StreamerEvent::Target, .. }))));
    // As on the wire in memory; what is sent by UDP may come a step or two later.
    let mut wire = super::super::Lockstep::new(simulator(9_000_000), autopilot(), streamer());
    wire.run(&mut |_, _, _| {}).unwrap();
    let end = |session: &HilSession| session.run().log().last().unwrap().state.body.v_ned;
    assert!((end(&flown) - end(&wire.simulator)).norm() < 0.05, "{} {}", end(&flown), end(&wire.simulator));
    assert!(flown.counts().unanswered < 250, "{:?}", flown.counts());
}

#[test]
fn a_busy_port_is_named() {
    let ports = free_ports();
    let _tcp = std::net::TcpListener::bind(loopback(ports.simulator)).unwrap();
    let (mut a, stop) = ears(|_| false);
    let error =
        block_on(run_simulator(simulator(1), &ports, for_ever(Speed::Max), None, &mut a, stop)).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "TCP port {} (simulator, for the autopilot) is in use: is another instance running? --instance shifts \
             the ports",
            ports.simulator
        )
    );
    let _udp = UdpSocket::bind(loopback(ports.api)).unwrap();
    let (mut a, stop) = ears(|_| false);
    let error = block_on(run_streamer(streamer(), &ports, None, &mut a, stop)).unwrap_err();
    assert!(error.to_string().starts_with(&format!("UDP port {} (streamer", ports.api)), "{error}");
}

#[test]
fn a_peer_that_says_nothing_is_named_and_time_stops() {
    let ports = free_ports();
    let is_wait = |n: &Notice| {
        matches!(
            n,
            Notice::Simulator(Timed {
                at: 5_000_000,
                event: HilEvent::Waiting { missing: Missing::AnyFrame, .. }
            })
        )
    };
    let (mut a, stop) = ears(is_wait);
    let session = block_on(async {
        let run =
            run_simulator(simulator(45_000_000), &ports, for_ever(Speed::Factor(50.0)), None, &mut a, stop);
        let (session, _stream) = tokio::join!(run, connect(&ports));
        session.unwrap()
    });
    assert_eq!(session.now(), 5_000_000);
    assert!(heard(&a.notices, |n| n.to_string().contains("connected but sent nothing")), "{:#?}", a.notices);
}

/// Connects to the simulator as soon as it listens.
async fn connect(ports: &Ports) -> TcpStream {
    loop {
        if let Ok(stream) = TcpStream::connect(loopback(ports.simulator)).await {
            return stream;
        }
        tokio::time::sleep(Duration::from_millis(5)).await;
    }
}

/// Reads HIL_SENSORs and answers `n` of them; returns their stamps.
async fn answer(stream: &mut TcpStream, n: usize) -> Vec<u64> {
    let (mut decoder, mut encoder) = (Decoder::new(), Encoder::new(1, 1));
    let mut stamps = Vec::new();
    let mut buffer = [0; 4096];
    while stamps.len() < n {
        let len = stream.read(&mut buffer).await.unwrap();
        assert!(len > 0, "the simulator has hung up");
        decoder.push(&buffer[..len]);
        while let Some(frame) = decoder.next_frame() {
            if let Some(MavMessage::HIL_SENSOR(m)) = frame.known() {
                stamps.push(m.time_usec);
                let answer = HIL_ACTUATOR_CONTROLS_DATA { time_usec: m.time_usec, ..Default::default() };
                let bytes = encoder.encode(&MavMessage::HIL_ACTUATOR_CONTROLS(answer));
                stream.write_all(&bytes).await.unwrap();
            }
        }
    }
    stamps
}

#[test]
fn a_peer_that_leaves_is_waited_for_and_the_drop_starts_over() {
    let ports = free_ports();
    let (mut a, _) = ears(|_| false);
    let (done, stop) = oneshot::channel::<()>();
    let script = async {
        let mut first = connect(&ports).await;
        let stamps = answer(&mut first, 50).await;
        assert!(stamps.windows(2).all(|w| w[1] == w[0] + 4_000));
        // A second one is sent away while the first is there.
        let mut second = connect(&ports).await;
        assert_eq!(second.read(&mut [0; 16]).await.unwrap(), 0);
        drop(first);
        tokio::time::sleep(Duration::from_millis(50)).await;
        let mut third = connect(&ports).await;
        assert_eq!(answer(&mut third, 3).await[0], 4_000);
        done.send(()).unwrap();
    };
    let stop = async { _ = stop.await };
    let (session, ()) = block_on(async {
        tokio::join!(
            run_simulator(simulator(45_000_000), &ports, for_ever(Speed::Max), None, &mut a, stop),
            script
        )
    });
    assert!(session.unwrap().now() >= 12_000);
    assert!(heard(&a.notices, |n| matches!(n, Notice::TurnedAway(_))));
    assert!(heard(&a.notices, |n| matches!(n, Notice::Simulator(Timed { event: HilEvent::PeerLeft, .. }))));
    assert!(heard(&a.notices, |n| matches!(
        n,
        Notice::Simulator(Timed { event: HilEvent::Connected { again: true }, .. })
    )));
}

#[test]
fn a_simulator_ends_without_an_autopilot_when_it_is_told_to() {
    let ports = free_ports();
    let ends = |notices: &[Notice], why: &str| {
        heard(notices, |n| matches!(n, Notice::Unattended(reason) if reason.contains(why)))
    };
    let (mut a, stop) = ears(|_| false);
    let patience = Some(Duration::from_millis(300));
    let attendance = Attendance { once: false, patience };
    let run = run_simulator(simulator(45_000_000), &ports, (Speed::Max, attendance), None, &mut a, stop);
    block_on(run).unwrap();
    assert!(ends(&a.notices, "stood still for 0.3 s"), "{:#?}", a.notices);
    // Who connects and leaves without a flight is not the one.
    let (mut b, stop) = ears(|_| false);
    let script = async {
        drop(connect(&ports).await);
        tokio::time::sleep(Duration::from_millis(50)).await;
        let mut stream = connect(&ports).await;
        answer(&mut stream, 3).await;
    };
    let attendance = Attendance { once: true, patience: None };
    let run = run_simulator(simulator(45_000_000), &ports, (Speed::Max, attendance), None, &mut b, stop);
    let (session, ()) = block_on(async { tokio::join!(run, script) });
    assert!(session.is_ok() && ends(&b.notices, "has left"), "{:#?}", b.notices);
}

#[test]
fn a_client_that_says_nothing_makes_room() {
    let ports = free_ports();
    let (mut a, _) = ears(|_| false);
    let (done, stop) = oneshot::channel::<()>();
    let script = async {
        let mut silent = connect(&ports).await;
        let until_closed = async { while silent.read(&mut [0; 256]).await.is_ok_and(|n| n > 0) {} };
        tokio::time::timeout(Duration::from_secs(60), until_closed).await.unwrap();
        let mut next = connect(&ports).await;
        assert_eq!(answer(&mut next, 3).await[0], 4_000);
        done.send(()).unwrap();
    };
    let stop = async { _ = stop.await };
    let run = run_simulator(simulator(45_000_000), &ports, for_ever(Speed::Max), None, &mut a, stop);
    let (session, ()) = block_on(async { tokio::join!(run, script) });
    assert!(session.is_ok());
    assert!(heard(&a.notices, |n| n.to_string().contains("not one frame in 10 s")), "{:#?}", a.notices);
}

#[test]
fn garbage_on_every_socket_is_reported_and_does_no_harm() {
    let ports = free_ports();
    let (mut a, _) = ears(|_| false);
    let (done, stop) = oneshot::channel::<()>();
    let script = async {
        let mut stream = connect(&ports).await;
        // Not MAVLink, then the beginning of a frame that never ends, then an answer that must come through.
        stream.write_all(b"GET / HTTP/1.1\r\n\r\n").await.unwrap();
        stream.write_all(&[0xFD, 0xFF, 0, 0, 1, 2, 3]).await.unwrap();
        let udp = UdpSocket::bind(loopback(0)).unwrap();
        udp.send_to(&[0xFD; 400], loopback(ports.parachute)).unwrap();
        udp.send_to(&[], loopback(ports.parachute)).unwrap();
        // 5 s free run, then 1 s until the half frame is given up.
        assert!(answer(&mut stream, 1_260).await.len() >= 1_260);
        done.send(()).unwrap();
    };
    let stop = async { _ = stop.await };
    let (session, ()) = block_on(async {
        tokio::join!(
            run_simulator(simulator(45_000_000), &ports, for_ever(Speed::Factor(50.0)), None, &mut a, stop),
            script
        )
    });
    assert!(session.unwrap().counts().steps >= 1_260);
    for what in ["simulator link", "parachute"] {
        assert!(heard(&a.notices, |n| matches!(n, Notice::Garbage(w, _) if *w == what)), "{what}");
    }
    assert!(!heard(&a.notices, |n| matches!(n, Notice::Heard(..))), "garbage makes nobody a peer");
}

#[test]
fn a_streamer_alone_says_what_it_misses() {
    let ports = free_ports();
    let (mut a, stop) =
        ears(|n| matches!(n, Notice::Streamer(Timed { event: StreamerEvent::Waiting { .. }, .. })));
    let session = block_on(run_streamer(streamer(), &ports, None, &mut a, stop)).unwrap();
    assert!(!session.is_over());
    assert!(heard(&a.notices, |n| n.to_string().contains("HEARTBEAT from the autopilot of system 1")));
}

#[test]
fn ports_are_px4s() {
    let ports = Ports::of_instance(2).unwrap();
    assert_eq!((ports.simulator, ports.autopilot_ground, ports.ground_station), (4562, 18572, 14550));
    assert_eq!((ports.autopilot_api, ports.api, ports.parachute), (14582, 14542, 14602));
}

/// What a watcher on UDP does does not change the flight.
#[test]
fn a_watched_drop_reaches_the_ground_station() {
    let ports = free_ports();
    let watcher = UdpSocket::bind(loopback(ports.ground_station)).unwrap();
    watcher.set_nonblocking(true).unwrap();
    let (mut a, stop) = ears(|_| false);
    let wire = super::super::Lockstep::new(simulator(9_000_000), autopilot(), streamer());
    let mut alone = wire.clone();
    let watched =
        block_on(run_watched_drop(wire, &ports, &Wiring::default(), Speed::Factor(40.0), &mut a, stop))
            .unwrap();
    alone.run(&mut |_, _, _| {}).unwrap();
    assert!(watched.simulator.run().log() == alone.simulator.run().log());
    let (mut decoder, mut buffer) = (Decoder::new(), [0; 2048]);
    let mut senders: Vec<(u8, u8)> = Vec::new();
    while let Ok(len) = watcher.recv(&mut buffer) {
        decoder.datagram(&buffer[..len], |f: Frame| senders.push((f.system_id, f.component_id)));
    }
    // Who has not spoken hears nothing of the components behind the vehicle, as with PX4.
    assert!(senders.contains(&(1, 1)) && senders.iter().all(|s| *s == (1, 1)));
}
