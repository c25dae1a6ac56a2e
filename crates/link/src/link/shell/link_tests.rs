//! Several peers on real sockets: who gets what, TCP by URL, keys.

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use mavlink::dialects::common::*;
use tokio::sync::oneshot;

use super::super::decoder::Decoder;
use super::super::encoder::Encoder;
use super::super::frame::Frame;
use super::super::hub::{EndpointId, Hub, HubConfig};
use super::super::session::{Link, Transmit};
use super::super::signing::Key;
use super::ports::loopback;
use super::tests::{autopilot, block_on, ears, free_ports, heard};
use super::*;

/// Runs an autopilot without a simulator (it beats once a second) while `script` does what it does in a
/// thread of its own.
fn with_autopilot<T: Send + 'static>(
    ports: Ports,
    wiring: Wiring,
    script: impl FnOnce() -> T + Send + 'static,
) -> (T, Vec<Notice>) {
    // The script speaks once the autopilot has its ports.
    let (open, opened) = std::sync::mpsc::channel();
    let api = ports.autopilot_api;
    let (mut a, _) = ears(move |n| {
        if matches!(n, Notice::Open(_, at, _) if at.port() == api) {
            open.send(()).unwrap();
        }
        false
    });
    let (done, stop) = oneshot::channel();
    let script = std::thread::spawn(move || {
        opened.recv().unwrap();
        let result = script();
        done.send(()).unwrap();
        result
    });
    let stop = async { _ = stop.await };
    block_on(run_autopilot(autopilot(), &ports, &wiring, AfterSimulator::Wait, &mut a, stop)).unwrap();
    (script.join().unwrap(), a.notices)
}

fn heartbeat() -> MavMessage {
    MavMessage::HEARTBEAT(HEARTBEAT_DATA { mavtype: MavType::MAV_TYPE_GCS, ..Default::default() })
}

fn request_version() -> MavMessage {
    MavMessage::COMMAND_LONG(COMMAND_LONG_DATA {
        command: MavCmd::MAV_CMD_REQUEST_MESSAGE,
        param1: 148.0,
        target_system: 1,
        target_component: 1,
        ..Default::default()
    })
}

/// A ground station on UDP.
struct Station {
    socket: UdpSocket,
    encoder: Encoder,
    to: SocketAddr,
}

impl Station {
    fn new(vehicle_port: u16) -> Self {
        let socket = UdpSocket::bind(loopback(0)).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        Self { socket, encoder: Encoder::new(255, 190), to: loopback(vehicle_port) }
    }

    fn say(&mut self, message: &MavMessage) {
        self.socket.send_to(&self.encoder.encode(message), self.to).unwrap();
    }

    /// All frames up to and with the datagram of the first that is wanted.
    fn hear_until(&self, wanted: impl Fn(&Frame) -> bool) -> Vec<Frame> {
        let (mut frames, mut buffer) = (Vec::new(), [0; 2048]);
        loop {
            let (len, from) = self.socket.recv_from(&mut buffer).unwrap();
            assert_eq!(from, self.to, "always from the same socket");
            Decoder::new().datagram(&buffer[..len], |f| frames.push(f));
            if frames.iter().any(&wanted) {
                return frames;
            }
        }
    }
}

fn is(message_id: u32) -> impl Fn(&Frame) -> bool {
    move |frame| frame.message_id == message_id
}

#[test]
fn two_ground_stations_hear_everything_and_each_its_own_answers() {
    let ports = free_ports();
    let ((first, second), notices) = with_autopilot(ports, Wiring::default(), move || {
        let mut stations = [Station::new(ports.autopilot_ground), Station::new(ports.autopilot_ground)];
        // A third one that is gone at once: what is sent to it comes back as ECONNREFUSED.
        let mut gone = Station::new(ports.autopilot_ground);
        gone.say(&heartbeat());
        drop(gone);
        stations.iter_mut().for_each(|s| s.say(&heartbeat()));
        let mut all = stations.each_ref().map(|s| s.hear_until(is(0)));
        stations[1].say(&request_version());
        all[1].extend(stations[1].hear_until(is(77)));
        for (frames, station) in all.iter_mut().zip(&stations) {
            frames.extend(station.hear_until(is(0)));
        }
        let [first, second] = all;
        (first, second)
    });
    let ids = |frames: &[Frame]| frames.iter().map(|f| f.message_id).collect::<Vec<_>>();
    assert!(ids(&first).iter().all(|id| *id == 0), "{:?}", ids(&first));
    assert!(ids(&second).contains(&148) && ids(&second).contains(&77));
    for frames in [first, second] {
        assert!(frames.iter().enumerate().all(|(i, f)| f.sequence == i as u8), "no gaps");
    }
    assert_eq!(notices.iter().filter(|n| matches!(n, Notice::Heard(..))).count(), 3);
}

fn read_until(stream: &mut TcpStream, wanted: impl Fn(&Frame) -> bool) -> Frame {
    stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let (mut decoder, mut buffer) = (Decoder::new(), [0; 1024]);
    loop {
        let len = stream.read(&mut buffer).unwrap();
        assert!(len > 0, "closed");
        decoder.push(&buffer[..len]);
        while let Some(frame) = decoder.next_frame() {
            if wanted(&frame) {
                return frame;
            }
        }
    }
}

fn url(text: &str) -> LinkUrl {
    text.parse().unwrap()
}

#[test]
fn tcp_by_url_serves_several_clients_and_connects_again() {
    let ports = free_ports();
    let server = free_ports().simulator;
    let listener = TcpListener::bind(loopback(0)).unwrap();
    let out = listener.local_addr().unwrap();
    let wiring = Wiring {
        urls: vec![url(&format!("tcpin:127.0.0.1:{server}")), url(&format!("tcpout:{out}"))],
        sign: None,
    };
    let ((), notices) = with_autopilot(ports, wiring, move || {
        let connect = || loop {
            if let Ok(stream) = TcpStream::connect(loopback(server)) {
                return stream;
            }
            std::thread::yield_now();
        };
        let mut clients = [connect(), connect()];
        for client in &mut clients {
            read_until(client, is(0));
        }
        clients[0].write_all(&Encoder::new(255, 190).encode(&request_version())).unwrap();
        assert_eq!(read_until(&mut clients[0], is(77)).command_ack().unwrap().command, 512);
        // We listen and it comes, and comes again when we hang up.
        let (mut first, _) = listener.accept().unwrap();
        read_until(&mut first, is(0));
        drop(first);
        let (mut second, _) = listener.accept().unwrap();
        read_until(&mut second, is(0));
    });
    assert!(heard(&notices, |n| n.to_string().contains(&format!("tcpin:127.0.0.1:{server}"))));
    assert!(heard(&notices, |n| matches!(n, Notice::Disconnected(peer, _) if *peer == out)));
}

#[test]
fn a_client_that_does_not_read_is_dropped_and_nobody_waits() {
    block_on(async {
        let (mut a, _) = ears(|_| false);
        let at = free_ports().simulator;
        let mut links = links::Links::new((1, 1), Duration::from_secs(10), true, None).unwrap();
        links.open(&url(&format!("tcpin:127.0.0.1:{at}")), &mut a).await.unwrap();
        let _deaf = TcpStream::connect(loopback(at)).unwrap();
        let mut vehicle = Encoder::new(1, 1);
        for _ in 0..10_000 {
            tokio::task::yield_now().await;
            links.receive(&mut a, |_, _, _| {});
            if heard(&a.notices, |n| matches!(n, Notice::Disconnected(..))) {
                break;
            }
            for _ in 0..100 {
                links.send(&Transmit::to_all(Link::GroundStation, vehicle.encode(&request_version())));
            }
        }
        assert!(heard(&a.notices, |n| n.to_string().contains("the peer does not read")));
    });
}

/// What the wire guide allows (https://mavlink.io/en/guide/serialization.html: a receiver looks for the next
/// start after each frame), and keeps below Ethernet's 1500 bytes.
#[test]
fn frames_of_one_moment_share_datagrams_that_travel_whole() {
    block_on(async {
        let (mut a, _) = ears(|_| false);
        let station = UdpSocket::bind(loopback(0)).unwrap();
        station.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        let to = station.local_addr().unwrap().port();
        let mut links = links::Links::new((1, 1), Duration::from_secs(10), true, None).unwrap();
        let port = free_ports().autopilot_ground;
        links.bind_udp(Link::GroundStation, port, "test", &[to], &mut a).await.unwrap();
        let mut vehicle = Encoder::new(1, 1);
        let beat = vehicle.encode(&request_version());
        for count in [3, 1, 100] {
            (0..count).for_each(|_| links.queue(&Transmit::to_all(Link::GroundStation, beat.clone())));
            links.flush();
            let (mut sequences, mut lens, mut buffer) = (Vec::new(), Vec::new(), [0; 2048]);
            while sequences.len() < count {
                let len = station.recv(&mut buffer).unwrap();
                lens.push(len);
                Decoder::new().datagram(&buffer[..len], |frame| sequences.push(frame.sequence));
            }
            assert!(sequences.windows(2).all(|s| s[1] == s[0].wrapping_add(1)), "{sequences:?}");
            assert!(lens.iter().all(|len| *len <= 1400), "{lens:?}");
            assert_eq!(lens.len(), (count * beat.len()).div_ceil(1400 / beat.len() * beat.len()), "{lens:?}");
        }
    });
}

#[test]
fn an_endpoint_that_cannot_be_had_is_named() {
    let ports = free_ports();
    for (text, reason) in [
        (format!("udpin:127.0.0.1:{}", ports.autopilot_ground), "is in use"),
        ("udpout:no.such.host.invalid:14550".to_owned(), "`udpout:no.such.host.invalid:14550`: a host with"),
    ] {
        let (mut a, stop) = ears(|_| false);
        let wiring = Wiring { urls: vec![url(&text)], sign: None };
        let run = run_autopilot(autopilot(), &ports, &wiring, AfterSimulator::Wait, &mut a, stop);
        let error = block_on(run).unwrap_err().to_string();
        assert!(error.contains(reason), "{error}");
    }
}

/// Time stamps in memory.
#[derive(Debug, Default)]
struct Memory(Mutex<BTreeMap<(u8, u8), String>>);

impl StampStore for Memory {
    fn load(&self, party: (u8, u8)) -> std::io::Result<Option<String>> {
        Ok(self.0.lock().unwrap().get(&party).cloned())
    }

    fn store(&self, party: (u8, u8), text: &str) -> std::io::Result<()> {
        self.0.lock().unwrap().insert(party, text.to_owned());
        Ok(())
    }

    fn place(&self, _: (u8, u8)) -> String {
        "memory".to_owned()
    }
}

/// A station's question, signed; its hub takes the answers.
fn signed_question(key: Key) -> (Hub<()>, EndpointId, Vec<u8>) {
    let config = HubConfig { own: (255, 190), memory_us: u64::MAX, forwards: false, key: Some(key) };
    let (mut hub, now) = (Hub::new(config), clock::UnixClock::start().now_us());
    let endpoint = hub.add_endpoint(Link::GroundStation);
    hub.keep(now, endpoint, ());
    let question = Transmit::to_all(Link::GroundStation, Encoder::new(255, 190).encode(&request_version()));
    let mut signed = Vec::new();
    hub.send(now, &question, |_, (), bytes| signed = bytes.to_vec());
    (hub, endpoint, signed)
}

#[test]
fn with_a_key_strangers_get_no_answer_and_friends_do() {
    let ports = free_ports();
    let key = Key::from_passphrase("titan");
    let sign = SignWith { key, stamps: Arc::new(Memory::default()) };
    let (hub, endpoint, question) = signed_question(key);
    let (said, mut hub) = (question.clone(), hub);
    let wiring = Wiring { urls: Vec::new(), sign: Some(sign) };
    let (signed, notices) = with_autopilot(ports, wiring.clone(), move || {
        let (mut stranger, friend) =
            (Station::new(ports.autopilot_ground), Station::new(ports.autopilot_ground));
        stranger.say(&request_version());
        friend.socket.send_to(&said, friend.to).unwrap();
        let answers = friend.hear_until(is(77));
        stranger.socket.set_nonblocking(true).unwrap();
        assert!(stranger.socket.recv(&mut [0; 300]).is_err());
        let (mut accepted, now) = (0, clock::UnixClock::start().now_us());
        for answer in &answers {
            hub.datagram(now, endpoint, (), answer.bytes(), |_| accepted += 1);
        }
        assert_eq!(accepted, answers.len());
        answers.iter().all(Frame::is_signed)
    });
    assert!(signed);
    assert!(heard(&notices, |n| n.to_string().contains("refused 1 frames")
        && n.to_string().contains("unsigned 1")));

    // What was recorded is not taken by the autopilot that is started anew, the next word of the friend is.
    let (_, _, next) = signed_question(key);
    let ((), notices) = with_autopilot(ports, wiring, move || {
        let (recorded, friend) = (Station::new(ports.autopilot_ground), Station::new(ports.autopilot_ground));
        recorded.socket.send_to(&question, recorded.to).unwrap();
        friend.socket.send_to(&next, friend.to).unwrap();
        friend.hear_until(is(77));
        recorded.socket.set_nonblocking(true).unwrap();
        assert!(recorded.socket.recv(&mut [0; 300]).is_err());
    });
    assert!(heard(&notices, |n| n.to_string().contains("replayed 1")), "{notices:?}");
}
