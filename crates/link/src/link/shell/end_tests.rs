//! What is heard of a simulation's end.

use std::io::Write as _;
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use mavlink::MessageData as _;
use mavlink::dialects::common::*;
use tokio::sync::oneshot;

use super::super::decoder::Decoder;
use super::super::encoder::Encoder;
use super::super::frame::message_id;
use super::super::parachute::{PARACHUTE_COMPONENT, T_END};
use super::super::session::Link;
use super::ports::loopback;
use super::simulator::Attendance;
use super::tests::{autopilot, block_on, ears, free_ports, simulator};
use super::*;
use crate::time::TimeUs;

/// Ten simulated seconds.
fn end() -> MavMessage {
    MavMessage::NAMED_VALUE_INT(NAMED_VALUE_INT_DATA {
        time_boot_ms: 10_000,
        value: 10_000,
        name: T_END.into(),
    })
}

fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA::default())
}

fn socket(port: u16) -> UdpSocket {
    let socket = UdpSocket::bind(loopback(port)).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    socket
}

/// Number of reports of the end among the datagrams that have come.
fn ends_heard(socket: &UdpSocket) -> usize {
    socket.set_nonblocking(true).unwrap();
    let (mut ends, mut buffer) = (0, [0; 2048]);
    while let Ok(len) = socket.recv(&mut buffer) {
        Decoder::new().datagram(&buffer[..len], |frame| {
            let is_end =
                matches!(frame.known(), Some(MavMessage::NAMED_VALUE_INT(m)) if m.name.to_str() == Ok(T_END));
            ends += usize::from(is_end && frame.component_id == PARACHUTE_COMPONENT);
        });
    }
    ends
}

/// A simulator that ends at the moment in which the autopilot reads its first HIL_SENSOR: the worst one,
/// since the end of the connection is then found without a look at the other sockets.
struct Ending {
    link: Arc<TcpStream>,
    parachute: UdpSocket,
    router: SocketAddr,
    report: Vec<u8>,
}

#[derive(Default)]
struct EndsAtFirstSight(Arc<Mutex<Option<Ending>>>);

impl Observer for EndsAtFirstSight {
    fn notice(&mut self, _: Notice) {}

    fn frame(&mut self, _: TimeUs, link: Link, bytes: &[u8]) {
        if link == Link::Simulator
            && message_id(bytes) == Some(HIL_SENSOR_DATA::ID)
            && let Some(ending) = self.0.lock().unwrap().take()
        {
            ending.parachute.send_to(&ending.report, ending.router).unwrap();
            ending.link.shutdown(Shutdown::Write).unwrap();
        }
    }
}

/// The autopilot that ends with its simulator lost the parachute's report of the end, which came first, and
/// the streamer behind it waited for 15 s: tests/e2e failed by it under load.
#[test]
fn regress_an_autopilot_that_ends_with_its_simulator_passes_the_end_on() {
    let ports = free_ports();
    let server = TcpListener::bind(loopback(ports.simulator)).unwrap();
    let (parachute, companion) = (socket(ports.parachute), socket(ports.api));
    let mut ears = EndsAtFirstSight::default();
    let ending = Arc::clone(&ears.0);
    let script = std::thread::spawn(move || {
        let (link, _) = server.accept().unwrap();
        let (link, mut buffer) = (Arc::new(link), [0; 2048]);
        companion.send_to(&Encoder::new(1, 191).encode(&heartbeat()), loopback(ports.autopilot_api)).unwrap();
        let (_, router) = parachute.recv_from(&mut buffer).unwrap();
        // Until the way from the parachute to the companion is open.
        let mut encoder = Encoder::new(1, PARACHUTE_COMPONENT);
        let mut is_open = false;
        while !is_open {
            parachute.send_to(&encoder.encode(&heartbeat()), router).unwrap();
            let len = companion.recv(&mut buffer).unwrap();
            Decoder::new().datagram(&buffer[..len], |f| is_open |= f.component_id == PARACHUTE_COMPONENT);
        }
        let report = encoder.encode(&end());
        *ending.lock().unwrap() = Some(Ending { link: Arc::clone(&link), parachute, router, report });
        let clock = MavMessage::HIL_SENSOR(HIL_SENSOR_DATA { time_usec: 4_000, ..Default::default() });
        (&*link).write_all(&Encoder::new(1, 200).encode(&clock)).unwrap();
        companion
    });
    let wiring = Wiring::default();
    let run = run_autopilot(
        autopilot(),
        &ports,
        &wiring,
        AfterSimulator::Return,
        &mut ears,
        std::future::pending(),
    );
    block_on(async { tokio::time::timeout(Duration::from_secs(20), run).await }).unwrap().unwrap();
    assert_eq!(ends_heard(&script.join().unwrap()), 1);
}

#[test]
fn a_simulator_reports_its_end_more_than_once() {
    let ports = free_ports();
    let listener = socket(0);
    let (mut a, _) = ears(|_| false);
    let (done, stop) = oneshot::channel::<()>();
    let script = std::thread::spawn(move || {
        let link = loop {
            match TcpStream::connect(loopback(ports.simulator)) {
                Ok(link) => break link,
                Err(_) => std::thread::yield_now(),
            }
        };
        // The parachute's port is open before the simulator's.
        let beat = Encoder::new(255, 190).encode(&heartbeat());
        listener.send_to(&beat, loopback(ports.parachute)).unwrap();
        listener.recv(&mut [0; 2048]).unwrap();
        done.send(()).unwrap();
        (link, listener)
    });
    let (speed, stop) = (Speed::Factor(10.0), async { _ = stop.await });
    let waits = (speed, Attendance::default());
    block_on(run_simulator(simulator(45_000_000), &ports, waits, None, &mut a, stop)).unwrap();
    let (_link, listener) = script.join().unwrap();
    assert_eq!(ends_heard(&listener), 3);
}
