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

/// Serves one autopilot and never pauses, for a minute at most; reads nothing. The bytes of each turn come
/// from `next`.
fn floods(
    server: TcpListener,
    mut next: impl FnMut() -> Vec<u8> + Send + 'static,
) -> std::thread::JoinHandle<()> {
    std::thread::spawn(move || {
        let (mut link, _): (_, SocketAddr) = server.accept().unwrap();
        let since = Since::now();
        while since.elapsed() < Duration::from_secs(60) && link.write_all(&next()).is_ok() {}
    })
}

/// A station asks again and again; the thread ends with the first answer, or after a minute and a half.
fn asks(ports: &Ports) -> (std::thread::JoinHandle<bool>, tokio::sync::oneshot::Receiver<()>) {
    let station = UdpSocket::bind(loopback(0)).unwrap();
    station.set_read_timeout(Some(Duration::from_millis(100))).unwrap();
    let (at, (answered, signal)) = (loopback(ports.autopilot_ground), tokio::sync::oneshot::channel());
    let asking = std::thread::spawn(move || {
        let mut encoder = Encoder::new(255, 190);
        let (since, mut buffer) = (Since::now(), [0; 2048]);
        while since.elapsed() < Duration::from_secs(90) {
            let wish = COMMAND_LONG_DATA {
                command: MavCmd::MAV_CMD_USER_1,
                target_system: 1,
                target_component: 1,
                ..Default::default()
            };
            let _ = station.send_to(&encoder.encode(&MavMessage::COMMAND_LONG(wish)), at);
            if station.recv(&mut buffer).is_ok() {
                let _ = answered.send(());
                return true;
            }
        }
        false
    });
    (asking, signal)
}

/// A simulator that sends without a pause kept the loop from its timers, its signals and all other sockets:
/// nobody was answered, and Ctrl-C was not heeded for as long as it went on.
#[test]
fn regress_a_simulator_that_never_pauses_starves_nobody() {
    let garbage = || (0..40_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    let mut encoder = Encoder::new(1, 200);
    let mut step = 0_u64;
    let jumps = move || {
        let mut bytes = Vec::new();
        for _ in 0..500 {
            step += 1;
            let time_usec = if step.is_multiple_of(2) { step * 4_000 } else { 9_000_000_000 - step };
            let clock = HIL_SENSOR_DATA { time_usec, ..Default::default() };
            bytes.extend_from_slice(&encoder.encode(&MavMessage::HIL_SENSOR(clock)));
        }
        bytes
    };
    let kinds: [Box<dyn FnMut() -> Vec<u8> + Send>; 2] = [Box::new(garbage), Box::new(jumps)];
    for (kind, next) in kinds.into_iter().enumerate() {
        let ports = free_ports();
        let flooder = floods(TcpListener::bind(loopback(ports.simulator)).unwrap(), next);
        let (asking, answered) = asks(&ports);
        let since = Since::now();
        let (mut a, _) = ears(|_| false);
        let wiring = Wiring::default();
        // Heard by a timer, as a signal is: the runtime must have its turn.
        let stop = async {
            let _ = answered.await;
            tokio::time::sleep(Duration::from_millis(50)).await;
        };
        let run = run_autopilot(autopilot(), &ports, &wiring, AfterSimulator::Wait, &mut a, stop);
        block_on(run).unwrap();
        let took = since.elapsed();
        assert!(asking.join().unwrap() && took < Duration::from_secs(40), "flood {kind}: {took:?}");
        flooder.join().unwrap();
    }
}
