//! A serial line to a board: UART or USB, raw, for this program alone. It never waits, and it comes back.
//!
//! A line that is unplugged is looked for until it is there again, by its name in `/dev/serial/by-id` where
//! it has one: a board that comes back may be another `/dev/ttyACM`.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::task::{Context, Poll};
use std::time::Duration;

use super::clock::Since;
use crate::time::TimeUs;

/// The baud rate unless another is typed: what PX4's ports for telemetry are usually set to for this.
const USUAL_BAUD: u32 = 921_600;
/// Rates that lines have.
const BAUD: std::ops::RangeInclusive<u32> = 1_200..=3_000_000;
/// Bits on a line for each byte: start, eight, stop.
const BITS_PER_BYTE: u32 = 10;

/// Periods of HIL_SENSOR, the most useful first [us].
const SENSOR_PERIODS_US: [TimeUs; 4] = [4_000, 5_000, 8_000, 10_000];
/// HIL_SENSOR on the wire [bytes].
const SENSOR_LEN: TimeUs = 76;
/// What else goes to a board in a second at the most [bytes]: setpoints at 50 Hz, fixes at 20 Hz, what ground
/// stations ask.
const REST_PER_S: TimeUs = 50 * 65 + 20 * 48 + 800;
/// HIL_ACTUATOR_CONTROLS of PX4 in a second [bytes]: 200 Hz, whatever the line (`Mavlink::set_hil_enabled`).
const CONTROLS_PER_S: TimeUs = 200 * 93;

/// Most bytes that wait for the line: what is older than a fifth of a second is of no use to a board.
const MAX_WAITING: usize = 1 << 14;
/// From one look for a line that is gone to the next.
const RETRY: Duration = Duration::from_millis(250);
/// Most reads at a time: a flood must not keep the rest from running.
const READS_AT_A_TIME: usize = 16;
/// So many bytes without one frame among them are no MAVLink at this baud rate.
const GARBLED: u64 = 512;

/// A serial line as typed: `DEV` or `DEV:BAUD`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialUrl {
    /// The device, such as `/dev/ttyACM0` or a name in `/dev/serial/by-id`.
    pub device: PathBuf,
    /// Bits per second; a USB port of a board has its own pace.
    pub baud: u32,
}

/// A reason why a line cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SerialError {
    /// Another baud rate than lines have, or no device.
    #[error("`{0}`: DEV or DEV:BAUD is expected, BAUD from {min} to {max}: /dev/ttyACM0, /dev/ttyUSB0:921600", min = BAUD.start(), max = BAUD.end())]
    Url(String),
    /// Too slow for what goes over it.
    #[error(
        "{device}: {baud} Bd carry {carries} bytes a second; HIL_SENSOR at 100 Hz, setpoints and fixes take {there}, PX4's \
         HIL_ACTUATOR_CONTROLS {back}: 230400 Bd are expected at the least, 921600 are usual"
    )]
    TooSlow {
        /// The device.
        device: String,
        /// As typed.
        baud: u32,
        /// What the line carries [bytes/s].
        carries: u64,
        /// What goes to the board at the least [bytes/s].
        there: u64,
        /// What comes back [bytes/s].
        back: u64,
    },
    /// It cannot be opened or set.
    #[error("{device}: {what}")]
    Open {
        /// The device.
        device: String,
        /// What that means.
        what: &'static str,
        /// The system's reason.
        source: io::Error,
    },
}

impl FromStr for SerialUrl {
    type Err = SerialError;

    fn from_str(text: &str) -> Result<Self, SerialError> {
        let wrong = || SerialError::Url(text.to_owned());
        let is_number = |tail: &str| tail.chars().all(|c| c.is_ascii_digit());
        let (device, baud) = match text.rsplit_once(':') {
            Some((device, tail)) if is_number(tail) => (device, tail.parse().map_err(|_| wrong())?),
            _ => (text, USUAL_BAUD),
        };
        if device.is_empty() || !BAUD.contains(&baud) {
            return Err(wrong());
        }
        Ok(Self { device: device.into(), baud })
    }
}

impl fmt::Display for SerialUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_usb() {
            write!(f, "{}", self.device.display())
        } else {
            write!(f, "{} at {} Bd", self.device.display(), self.baud)
        }
    }
}

impl SerialUrl {
    /// The period of HIL_SENSOR on a line that carries it [us].
    pub const SENSOR_PERIOD_US: TimeUs = SENSOR_PERIODS_US[0];

    /// Whether it is a USB port of the board itself, whose baud rate means nothing.
    pub fn is_usb(&self) -> bool {
        let device = self.device.canonicalize().unwrap_or_else(|_| self.device.clone());
        let name = device.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        name.starts_with("ttyACM") || name.contains("usbmodem")
    }

    /// The shortest period of HIL_SENSOR that the line carries beside what else goes over it, on the wire's
    /// clock [us].
    ///
    /// # Errors
    /// [`SerialError::TooSlow`] where not even the longest useful one fits.
    pub fn sensor_period_us(&self) -> Result<TimeUs, SerialError> {
        let carries = TimeUs::from(self.baud / BITS_PER_BYTE);
        let there = |period_us: TimeUs| SENSOR_LEN * 1_000_000 / period_us + REST_PER_S;
        let fits =
            |period_us: &TimeUs| self.is_usb() || carries >= there(*period_us) && carries >= CONTROLS_PER_S;
        let [.., longest] = SENSOR_PERIODS_US;
        SENSOR_PERIODS_US.into_iter().find(fits).ok_or_else(|| SerialError::TooSlow {
            device: self.device.display().to_string(),
            baud: self.baud,
            carries,
            there: there(longest),
            back: CONTROLS_PER_S,
        })
    }
}

/// What has come by a line, or become of it.
pub(super) enum LineNews<'a> {
    /// It is there.
    Open,
    /// Bytes.
    Bytes(&'a [u8]),
    /// It is gone, and looked for, by this reason.
    Lost(String),
    /// The board does not read: so many frames have been left out so far.
    Stalled(u64),
}

/// A serial line with what waits to be sent.
#[derive(Debug)]
pub(super) struct SerialLine {
    url: SerialUrl,
    /// The name by which it is looked for.
    place: PathBuf,
    port: Option<Port>,
    is_new: bool,
    tried: Since,
    waiting: Vec<u8>,
    left_out: u64,
    told_from: u64,
    /// A frame has come.
    is_heard: bool,
    is_garbled: bool,
}

impl SerialLine {
    /// Opens a line, which must be there.
    pub(super) fn open(url: &SerialUrl) -> Result<Self, SerialError> {
        let port = Port::open(&url.device, url.baud)?;
        Ok(Self {
            place: by_id(&url.device).unwrap_or_else(|| url.device.clone()),
            url: url.clone(),
            port: Some(port),
            is_new: true,
            tried: Since::now(),
            waiting: Vec::new(),
            left_out: 0,
            told_from: 0,
            is_heard: false,
            is_garbled: false,
        })
    }

    /// Whether something may have come; arranges to be woken if not.
    pub(super) fn poll_readable(&self, cx: &mut Context<'_>) -> Poll<()> {
        match &self.port {
            Some(_) if self.is_new => Poll::Ready(()),
            Some(port) if !self.waiting.is_empty() && port.poll_writable(cx).is_ready() => Poll::Ready(()),
            Some(port) => port.poll_readable(cx),
            // The host looks again soon.
            None => Poll::Pending,
        }
    }

    /// Takes what has come, without waiting, and looks for a line that is gone.
    pub(super) fn receive(&mut self, each: &mut impl FnMut(LineNews<'_>)) {
        if self.port.is_none() && self.tried.elapsed() >= RETRY {
            self.tried = Since::now();
            self.port = Port::open(&self.place, self.url.baud).ok();
            self.is_new = self.port.is_some();
        }
        if std::mem::take(&mut self.is_new) {
            // What comes by it has its turn once that is known.
            return each(LineNews::Open);
        }
        let mut buffer = [0; 4096];
        for _ in 0..READS_AT_A_TIME {
            let Some(port) = &self.port else { break };
            match port.read(&mut buffer) {
                Ok(0) => self.lose("unplugged, or closed at the other end".to_owned(), each),
                Ok(len) => each(LineNews::Bytes(&buffer[..len])),
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => break,
                Err(e) => self.lose(e.to_string(), each),
            }
        }
        if let Err(e) = self.flush() {
            self.lose(e.to_string(), each);
        }
        if self.left_out > self.told_from {
            self.told_from = self.left_out.saturating_mul(2);
            each(LineNews::Stalled(self.left_out));
        }
    }

    fn lose(&mut self, why: String, each: &mut impl FnMut(LineNews<'_>)) {
        self.port = None;
        self.waiting.clear();
        (self.left_out, self.told_from) = (0, 0);
        each(LineNews::Lost(why));
    }

    /// Takes a frame to be sent by [`Self::flush`]; leaves it out where too much waits, or nobody is there.
    pub(super) fn queue(&mut self, frame: &[u8]) {
        if self.port.is_none() {
            return;
        }
        if self.waiting.len() + frame.len() > MAX_WAITING {
            self.left_out += 1;
            return;
        }
        self.waiting.extend_from_slice(frame);
    }

    /// Sends what there is room for; an end shows at the next [`Self::receive`], too.
    pub(super) fn flush(&mut self) -> io::Result<()> {
        let Some(port) = &self.port else { return Ok(()) };
        while !self.waiting.is_empty() {
            match port.write(&self.waiting) {
                Ok(len) => _ = self.waiting.drain(..len),
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => break,
                Err(e) => return Err(e),
            }
        }
        Ok(())
    }

    /// A frame has come.
    pub(super) fn note_frame(&mut self) {
        self.is_heard = true;
    }

    /// Whether it has become known just now that what comes is no MAVLink at this baud rate.
    pub(super) fn is_garbled_now(&mut self, skipped_bytes: u64) -> bool {
        let garbled = !self.is_heard && skipped_bytes >= GARBLED;
        garbled && !std::mem::replace(&mut self.is_garbled, true)
    }
}

/// The lasting name of a device, by which it is found again wherever it is plugged in.
fn by_id(device: &Path) -> Option<PathBuf> {
    let device = device.canonicalize().ok()?;
    let names = std::fs::read_dir("/dev/serial/by-id").ok()?;
    names
        .filter_map(|name| Some(name.ok()?.path()))
        .find(|name| name.canonicalize().is_ok_and(|to| to == device))
}

fn refused(device: &Path, what: &'static str, source: impl Into<io::Error>) -> SerialError {
    SerialError::Open { device: device.display().to_string(), what, source: source.into() }
}

#[cfg(test)]
#[cfg(unix)]
#[path = "serial_tests.rs"]
mod tests;

#[cfg(unix)]
use self::termios::Port;

#[cfg(unix)]
mod termios {
    use std::io;
    use std::os::fd::OwnedFd;
    use std::path::Path;
    use std::task::{Context, Poll};

    use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
    use rustix::io::{Errno, read, write};
    use rustix::termios::{
        ControlModes, OptionalActions, QueueSelector, ioctl_tiocexcl, tcflush, tcgetattr, tcsetattr,
    };
    use tokio::io::Interest;
    use tokio::io::unix::AsyncFd;

    use super::{SerialError, refused};

    /// An open line.
    #[derive(Debug)]
    pub(super) struct Port(AsyncFd<OwnedFd>);

    impl Port {
        pub(super) fn open(device: &Path, baud: u32) -> Result<Self, SerialError> {
            let what = |e: Errno| match e {
                Errno::NOENT | Errno::NXIO | Errno::NODEV => {
                    "no such device; a board that is plugged in has a name in /dev/serial/by-id"
                }
                Errno::ACCESS | Errno::PERM => {
                    "no permission: the group of the device is expected to have you (dialout or uucp), and you logged in since"
                }
                Errno::BUSY | Errno::WOULDBLOCK => {
                    "busy: another program has it (a ground station, ModemManager, another samara); end that first"
                }
                Errno::NOTTY | Errno::INVAL => "no serial line",
                _ => "cannot be opened as a serial line",
            };
            let refuse = |e: Errno| refused(device, what(e), e);
            let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
            let fd = open(device, flags, Mode::empty()).map_err(refuse)?;
            let mut settings = tcgetattr(&fd).map_err(refuse)?;
            // TIOCEXCL keeps out who comes later, but not root; the lock is what others look at.
            flock(&fd, FlockOperation::NonBlockingLockExclusive).map_err(refuse)?;
            ioctl_tiocexcl(&fd).map_err(refuse)?;
            settings.make_raw();
            // No modem lines; a board that goes does not hang us up.
            settings.control_modes |= ControlModes::CLOCAL | ControlModes::CREAD;
            settings.control_modes -= ControlModes::CRTSCTS;
            let set = settings.set_speed(baud).and_then(|()| tcsetattr(&fd, OptionalActions::Now, &settings));
            set.map_err(|e| refused(device, "the line does not have this baud rate", e))?;
            // What was there before us is half of something.
            tcflush(&fd, QueueSelector::IOFlush).map_err(refuse)?;
            #[allow(deprecated, reason = "its successor is unsafe, for what is no OwnedFd")]
            let fd = AsyncFd::new(fd).map_err(|e| refused(device, "cannot be waited for", e))?;
            Ok(Self(fd))
        }

        pub(super) fn poll_readable(&self, cx: &mut Context<'_>) -> Poll<()> {
            self.0.poll_read_ready(cx).map(|_| ())
        }

        pub(super) fn poll_writable(&self, cx: &mut Context<'_>) -> Poll<()> {
            self.0.poll_write_ready(cx).map(|_| ())
        }

        pub(super) fn read(&self, buffer: &mut [u8]) -> io::Result<usize> {
            self.0.try_io(Interest::READABLE, |fd| Ok(read(fd, &mut *buffer)?))
        }

        pub(super) fn write(&self, bytes: &[u8]) -> io::Result<usize> {
            self.0.try_io(Interest::WRITABLE, |fd| Ok(write(fd, bytes)?))
        }
    }
}

/// Where there is no termios there is no line.
#[cfg(not(unix))]
#[derive(Debug)]
enum Port {}

#[cfg(not(unix))]
impl Port {
    fn open(device: &Path, _: u32) -> Result<Self, SerialError> {
        let source = io::Error::from(io::ErrorKind::Unsupported);
        Err(refused(device, "serial lines are not here on this system: Linux or macOS is expected", source))
    }

    fn poll_readable(&self, _: &mut Context<'_>) -> Poll<()> {
        match *self {}
    }

    fn poll_writable(&self, _: &mut Context<'_>) -> Poll<()> {
        match *self {}
    }

    fn read(&self, _: &mut [u8]) -> io::Result<usize> {
        match *self {}
    }

    fn write(&self, _: &[u8]) -> io::Result<usize> {
        match *self {}
    }
}
