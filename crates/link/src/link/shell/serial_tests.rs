//! Serial lines on pseudo-terminals: one end is a line as a board has it, the other is in the test's hands.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::os::unix::fs::symlink;
use std::path::PathBuf;
use std::time::Duration;

use mavlink::dialects::common::{HEARTBEAT_DATA, MavMessage};
use rustix::fs::{OFlags, fcntl_setfl};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use tokio::net::UdpSocket;

use super::super::super::encoder::Encoder;
use super::super::super::hil::{HilConfig, HilSession, Stamps};
use super::super::super::streamer::{Clock, STREAMER_SYSTEM};
use super::super::clock::Since;
use super::super::ports::loopback;
use super::super::tests::{autopilot, block_on, ears, free_ports, heard, simulator, streamer_by};
use super::super::{Attendance, LineNotice, Notice, run_board};
use super::*;
use crate::link::{Decoder, Frame, Link, Session as _};
use crate::sim::{DropRunConfig, Phase};

/// A pseudo-terminal: the far end, and a name of the near one that may point elsewhere later.
struct Pty {
    far: Option<File>,
    place: tempfile::TempDir,
}

impl Pty {
    fn new() -> Self {
        let mut pty = Self { far: None, place: tempfile::tempdir().unwrap() };
        pty.plug_in();
        pty
    }

    fn name(&self) -> PathBuf {
        self.place.path().join("board")
    }

    fn url(&self) -> SerialUrl {
        SerialUrl { device: self.name(), baud: USUAL_BAUD }
    }

    fn plug_in(&mut self) {
        let far = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&far).unwrap();
        unlockpt(&far).unwrap();
        fcntl_setfl(&far, OFlags::NONBLOCK).unwrap();
        let near = ptsname(&far, Vec::new()).unwrap().into_string().unwrap();
        _ = std::fs::remove_file(self.name());
        symlink(near, self.name()).unwrap();
        self.far = Some(File::from(far));
    }

    fn unplug(&mut self) {
        std::fs::remove_file(self.name()).unwrap();
        self.far = None;
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.far.as_mut().and_then(|far| far.write(bytes).ok()).unwrap_or(0)
    }

    fn read(&mut self) -> Vec<u8> {
        let mut buffer = vec![0; 1 << 16];
        let len = self.far.as_mut().and_then(|far| far.read(&mut buffer).ok()).unwrap_or(0);
        buffer.truncate(len);
        buffer
    }
}

async fn turn() {
    tokio::time::sleep(Duration::from_micros(200)).await;
}

/// Bytes that are no text: each depends on its place.
fn pattern(len: usize) -> Vec<u8> {
    (0..len).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect()
}

#[test]
fn closed_form_what_is_typed_is_what_is_meant() {
    for (text, device, baud) in [
        ("/dev/ttyUSB0", "/dev/ttyUSB0", 921_600),
        ("/dev/ttyUSB0:57600", "/dev/ttyUSB0", 57_600),
        (
            "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0",
            "/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0",
            921_600,
        ),
    ] {
        let url: SerialUrl = text.parse().unwrap();
        assert_eq!((url.device.to_str().unwrap(), url.baud), (device, baud));
    }
    for text in
        ["", ":57600", "/dev/ttyUSB0:", "/dev/ttyUSB0:0", "/dev/ttyUSB0:3000001", "/dev/ttyUSB0:99999999999"]
    {
        let error = text.parse::<SerialUrl>().unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("`{text}`: DEV or DEV:BAUD is expected, BAUD from 1200 to 3000000")),
            "{error}"
        );
    }
}

/// By hand, at ten bits a byte: 921 600 Bd hold 250 x 76 + 5 010 and 200 x 93 bytes/s, 230 400 Bd hold
/// 200 x 76 + 5 010.
#[test]
fn closed_form_what_a_line_carries() {
    let period = |text: &str| text.parse::<SerialUrl>().unwrap().sensor_period_us();
    for (baud, period_us) in [(921_600, 4_000), (460_800, 4_000), (230_400, 5_000), (200_000, 8_000)] {
        assert_eq!(period(&format!("/dev/ttyUSB0:{baud}")).unwrap(), period_us);
    }
    for baud in [57_600, 115_200] {
        let error = period(&format!("/dev/ttyUSB0:{baud}")).unwrap_err().to_string();
        assert!(
            error.contains("HIL_ACTUATOR_CONTROLS 18600: 230400 Bd are expected at the least"),
            "{error}"
        );
    }
    // USB has its own pace.
    assert_eq!(period("/dev/ttyACM0:57600").unwrap(), 4_000);
}

/// 1 MB each way, in pieces that end anywhere.
#[test]
fn a_megabyte_goes_both_ways_without_a_wrong_byte() {
    block_on(async {
        let mut pty = Pty::new();
        let mut line = SerialLine::open(&pty.url()).unwrap();
        let sent = pattern(1 << 20);
        let (mut there, mut back) = (Vec::new(), Vec::new());
        let (mut queued, mut written) = (0, 0);
        while there.len() < sent.len() || back.len() < sent.len() {
            let piece = &sent[queued..sent.len().min(queued + 281)];
            if line.waiting.len() + piece.len() <= MAX_WAITING {
                line.queue(piece);
                queued += piece.len();
            }
            written += pty.write(&sent[written..sent.len().min(written + 977)]);
            line.receive(&mut |news| {
                if let LineNews::Bytes(bytes) = news {
                    back.extend_from_slice(bytes);
                }
            });
            there.extend(pty.read());
            if queued % 16 == 0 {
                turn().await;
            }
        }
        assert!(there == sent && back == sent);
        assert_eq!(line.left_out, 0);
    });
}

#[test]
fn who_does_not_read_holds_nobody_up_and_little_is_kept_for_him() {
    block_on(async {
        let pty = Pty::new();
        let mut line = SerialLine::open(&pty.url()).unwrap();
        let mut told = Vec::new();
        let began = Since::now();
        for _ in 0..20_000 {
            line.queue(&[0x55; 76]);
            line.flush().unwrap();
            line.receive(&mut |news| {
                if let LineNews::Stalled(frames) = news {
                    told.push(frames);
                }
            });
        }
        assert!(line.waiting.len() <= MAX_WAITING && line.left_out > 10_000, "{} left out", line.left_out);
        assert!(told.len() > 5 && told.len() < 20 && told.windows(2).all(|w| w[1] > 2 * w[0]), "{told:?}");
        assert!(began.elapsed() < Duration::from_secs(5));
    });
}

#[test]
fn what_cannot_be_a_line_is_refused_with_what_is_the_matter() {
    block_on(async {
        let refusal = |device: &Path| {
            let url = SerialUrl { device: device.to_owned(), baud: USUAL_BAUD };
            SerialLine::open(&url).map(|_| ()).unwrap_err().to_string()
        };
        let pty = Pty::new();
        let _first = SerialLine::open(&pty.url()).unwrap();
        assert!(refusal(&pty.name()).contains("busy: another program has it"));
        let file = pty.place.path().join("file");
        File::create_new(&file).unwrap();
        assert!(refusal(&file).contains("no serial line"));
        assert!(refusal(Path::new("/dev/null")).contains("no serial line"));
        assert!(refusal(Path::new("/dev/ttyNONE")).contains("no such device"));
        let closed = std::os::unix::fs::PermissionsExt::from_mode(0o000);
        std::fs::set_permissions(&file, closed).unwrap();
        // Nothing is closed to root.
        if !rustix::process::geteuid().is_root() {
            assert!(refusal(&file).contains("no permission"));
        }
    });
}

fn board_simulator(stamps: Stamps) -> HilSession {
    let run = DropRunConfig { duration_us: 12_000_000, ..DropRunConfig::default() };
    let config = HilConfig { run, real_time: Some(stamps), ..simulator(1).config().to_owned() };
    HilSession::new(crate::test_site::drop_simulation(), config)
}

/// Garbage, a board of another system, and, after it was unplugged, our own at another place.
#[test]
fn a_line_is_told_of_whatever_becomes_of_it_and_found_again() {
    let mut pty = Pty::new();
    let url = pty.url();
    let (ports, mut lines) = (free_ports(), Vec::new());
    let (mut ears, stop) = ears(|notice| {
        if let Notice::Line(_, news) = notice {
            lines.push(news.clone());
        }
        lines.iter().filter(|news| **news == LineNotice::Heard).count() == 2
    });
    let heartbeat =
        |system: u8| Encoder::new(system, 1).encode(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default()));
    let board = async {
        let wait = || tokio::time::sleep(Duration::from_millis(150));
        wait().await;
        // What a frame looks like at another baud rate.
        pty.write(&vec![0xF8; 600]);
        wait().await;
        pty.write(&heartbeat(3));
        wait().await;
        pty.unplug();
        wait().await;
        pty.plug_in();
        tokio::time::sleep(RETRY * 2).await;
        pty.write(&heartbeat(1));
        std::future::pending::<()>().await;
    };
    let session = board_simulator(Stamps::Autopilots);
    block_on(async {
        let run = run_board((session, None), &ports, &url, (1.0, Attendance::default()), &mut ears, stop);
        tokio::select! {
            result = run => drop(result.unwrap()),
            () = board => {}
        }
    });
    drop(ears);
    let is = |i: usize, wanted: fn(&LineNotice) -> bool| assert!(wanted(&lines[i]), "{i}: {lines:?}");
    is(0, |news| *news == LineNotice::Open);
    is(1, |news| matches!(news, LineNotice::Garbled(512..)));
    is(2, |news| *news == LineNotice::Heard);
    is(3, |news| *news == LineNotice::OtherSystem { found: 3, expected: 1 });
    is(4, |news| matches!(news, LineNotice::Lost(_)));
    is(5, |news| *news == LineNotice::Open);
    is(6, |news| *news == LineNotice::Heard);
    assert!(lines[1].to_string().contains("has the board's port another baud rate"));
}

/// A whole drop, ten times as fast as a clock: the reference autopilot is the board, the streamer beside the
/// simulator goes by the board's ports. What the board says to all reaches a ground station that has not
/// spoken, byte for byte.
#[test]
fn a_board_flies_a_drop_and_a_ground_station_hears_what_it_says() {
    let mut pty = Pty::new();
    let url = pty.url();
    let ports = free_ports();
    let (mut ears, stop) = ears(|_| false);
    let mut said = Vec::new();
    let (simulator, streamer, told) = block_on(async {
        let station = UdpSocket::bind(loopback(ports.ground_station)).await.unwrap();
        let board = async {
            let (mut pilot, mut decoder, began) = (autopilot(), Decoder::new(), Since::now());
            pilot.simulator_connected();
            loop {
                decoder.push(&pty.read());
                while let Some(frame) = decoder.next_frame() {
                    let hil = (100..120).contains(&frame.message_id) || frame.system_id != STREAMER_SYSTEM;
                    pilot.handle_input(if hil { Link::Simulator } else { Link::Api }, &frame);
                }
                pilot.handle_time(began.elapsed_us());
                while let Some(sent) = pilot.poll_output() {
                    if sent.link == Link::GroundStation {
                        continue;
                    }
                    let mut left = &sent.bytes[..];
                    while !left.is_empty() {
                        left = &left[pty.write(left)..];
                    }
                    said.push(sent.bytes);
                }
                turn().await;
            }
        };
        let sessions = (board_simulator(Stamps::Simulated), Some(streamer_by(Clock::Caller)));
        let run = run_board(sessions, &ports, &url, (10.0, Attendance::default()), &mut ears, stop);
        let (simulator, streamer) = tokio::select! {
            // What is said to a line before it is open is lost.
            biased;
            result = run => result.unwrap(),
            () = board => unreachable!(),
        };
        let (mut told, mut buffer) = (Vec::new(), vec![0; 1 << 16]);
        while let Ok(len) = station.try_recv(&mut buffer) {
            Decoder::new().datagram(&buffer[..len], |frame: Frame| told.push(frame.bytes().to_vec()));
        }
        (simulator, streamer.unwrap(), told)
    });
    assert_ne!(simulator.run().simulation().phase(), Phase::Hanging, "{:?}", ears.notices);
    assert!(streamer.failure().is_none() && streamer.is_plan_over());
    assert!(heard(&ears.notices, |n| matches!(n, Notice::Line(_, LineNotice::Heard))));
    let of_the_board: Vec<_> = told.iter().filter(|bytes| bytes[6] == 1).collect();
    assert!(of_the_board.len() > 50);
    assert!(of_the_board.iter().all(|bytes| said.contains(bytes)));
}
