//! A simulator that sends and does not read holds up nobody but itself.

use std::io::Write as _;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use mavlink::dialects::common::*;

use super::super::encoder::Encoder;
use super::clock::Since;
use super::ports::loopback;
use super::tests::{autopilot, block_on, ears, free_ports, heard};
use super::*;

/// Sends HIL_SENSORs until the other side has had enough; reads nothing.
fn talks_without_listening(link: &mut TcpStream) {
    let mut encoder = Encoder::new(1, 200);
    for step in 1.. {
        let clock = HIL_SENSOR_DATA { time_usec: step * 4_000, ..Default::default() };
        if link.write_all(&encoder.encode(&MavMessage::HIL_SENSOR(clock))).is_err() {
            return;
        }
    }
}

/// Takes room from the sockets of a listener's connections, so that they are full soon.
fn with_little_room(listener: TcpListener) -> TcpListener {
    #[cfg(unix)]
    rustix::net::sockopt::set_socket_recv_buffer_size(&listener, 4096).unwrap();
    listener
}

/// Ground stations heard nothing for the five seconds in which the autopilot waited for the simulator to
/// read.
#[test]
fn regress_a_simulator_that_does_not_read_stalls_no_ground_station() {
    let ports = free_ports();
    let server = with_little_room(TcpListener::bind(loopback(ports.simulator)).unwrap());
    let station = UdpSocket::bind(loopback(ports.ground_station)).unwrap();
    station.set_read_timeout(Some(Duration::from_millis(10))).unwrap();
    let simulator = std::thread::spawn(move || {
        let (mut link, _): (_, SocketAddr) = server.accept().unwrap();
        talks_without_listening(&mut link);
    });
    let is_over = Arc::new(AtomicBool::new(false));
    let listening = Arc::clone(&is_over);
    let listener = std::thread::spawn(move || {
        let (mut longest, mut since, mut buffer) = (Duration::ZERO, None::<Since>, [0; 2048]);
        while !listening.load(Ordering::Relaxed) {
            let comes = station.recv(&mut buffer).is_ok();
            longest = longest.max(since.as_ref().map_or(Duration::ZERO, Since::elapsed));
            if comes {
                since = Some(Since::now());
            }
        }
        longest
    });
    let (mut a, _) = ears(|_| false);
    let (wiring, never) = (Wiring::default(), std::future::pending());
    let run = run_autopilot(autopilot(), &ports, &wiring, AfterSimulator::Return, &mut a, never);
    block_on(async { tokio::time::timeout(Duration::from_secs(120), run).await }).unwrap().unwrap();
    is_over.store(true, Ordering::Relaxed);
    let longest = listener.join().unwrap();
    simulator.join().unwrap();
    let gone = |n: &Notice| matches!(n, Notice::Disconnected(_, why) if why.contains("read"));
    assert!(heard(&a.notices, gone), "{:#?}", a.notices);
    assert!(longest < Duration::from_secs(3), "{longest:?}");
}
