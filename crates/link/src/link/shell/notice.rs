//! Notices of the shell to its caller, and the reasons why it cannot go on.

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::net::SocketAddr;

use super::super::faults::Faults;
use super::super::hil::HilEvent;
use super::super::session::Link;
use super::super::signing::ClockError;
use super::super::streamer::StreamerEvent;
use super::serial::SerialError;
use crate::autopilot::flight_log::LogEntry;
use crate::sim::Sample;
use crate::time::{TimeUs, Timed};

/// What a socket is for, or as which it was typed.
pub type What = Cow<'static, str>;

/// A reason why sockets cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ShellError {
    /// Another process has the port.
    #[error(
        "{protocol} port {port} ({what}) is in use: is another instance running? --instance shifts the ports"
    )]
    PortBusy {
        /// "TCP" or "UDP".
        protocol: &'static str,
        /// The port.
        port: u16,
        /// Purpose of the port.
        what: What,
    },
    /// The port cannot be had for another reason.
    #[error("{protocol} port {port} ({what})")]
    Bind {
        /// "TCP" or "UDP".
        protocol: &'static str,
        /// The port.
        port: u16,
        /// Purpose of the port.
        what: What,
        /// The system's reason.
        source: io::Error,
    },
    /// A typed endpoint whose host has no address.
    #[error("`{url}`: a host with an address is expected")]
    Host {
        /// As typed.
        url: String,
        /// The system's reason.
        source: io::Error,
    },
    /// A serial line that cannot be used.
    #[error(transparent)]
    Serial(#[from] SerialError),
    /// The time stamps of signed frames cannot be kept.
    #[error("{place}: the last time stamps of signed frames are kept there")]
    Stamps {
        /// Where they are kept.
        place: String,
        /// The reason.
        source: io::Error,
    },
    /// No frame can be signed by the clock.
    #[error("{place}")]
    Clock {
        /// Where the time stamps of signed frames are kept.
        place: String,
        /// The reason.
        source: ClockError,
    },
    /// No such instance.
    #[error("instance {instance}: 0 to {max} expected; beyond that, vehicles would share ports")]
    Instance {
        /// The instance.
        instance: u16,
        /// The highest.
        max: u16,
    },
}

impl ShellError {
    pub(super) fn bind(protocol: &'static str, at: SocketAddr, what: &What, source: io::Error) -> Self {
        let (port, what) = (at.port(), what.clone());
        if source.kind() == io::ErrorKind::AddrInUse {
            Self::PortBusy { protocol, port, what }
        } else {
            Self::Bind { protocol, port, what, source }
        }
    }
}

/// Something that happened.
#[derive(Clone, Debug, PartialEq)]
pub enum Notice {
    /// A socket, "TCP" or "UDP", is open at this address for this purpose.
    Open(&'static str, SocketAddr, What),
    /// A connection with this peer stands, for this purpose.
    Connected(SocketAddr, What),
    /// The connection with this peer has ended, for this reason.
    Disconnected(SocketAddr, String),
    /// A second autopilot has tried to connect, from this address, and has been sent away.
    TurnedAway(SocketAddr),
    /// The simulator ends, because nobody is there whom it waits for: for this reason.
    Unattended(String),
    /// Nobody listens at this address yet, where this should be; it is tried again and again.
    NobodyThere(SocketAddr, What),
    /// This peer has sent a frame on a UDP socket of this purpose for the first time, or after a silence.
    Heard(SocketAddr, What),
    /// There is no room for this further peer on the socket of this purpose.
    Crowded(SocketAddr, What),
    /// By this peer on the socket of this purpose a system and component signs by our key, but this many
    /// seconds ahead of our clock (negative: behind), and is not believed.
    OtherClock(SocketAddr, What, (u8, u8), i64),
    /// While something is waited for: frames have come and been refused, by kind.
    RefusedMeanwhile(Faults),
    /// The time stamps of signed frames can no longer be kept at this place, for this reason.
    StampsLost(String, String),
    /// At the end: everything that came by the socket of this purpose, by kind.
    Counts(What, Faults),
    /// Bytes have come by the socket of this purpose that are no frames, or frames that are not let in;
    /// reported at the 1st, 2nd, 4th, .. time, with all that the socket has dropped so far.
    Garbage(What, Faults),
    /// A serial line, by its name, is open, gone, or not what it should be.
    Line(String, LineNotice),
    /// So often the simulator was late by more than a tenth of a second, and real time was not kept.
    NotInTime(u32),
    /// A report of the simulator.
    Simulator(Timed<HilEvent>),
    /// A report of the streamer.
    Streamer(Timed<StreamerEvent>),
    /// A STATUSTEXT of the autopilot.
    Autopilot {
        /// Simulated time.
        at: TimeUs,
        /// `MAV_SEVERITY`, 0 the worst, 7 debug.
        severity: u8,
        /// The text.
        text: String,
    },
}

/// What has become of a serial line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LineNotice {
    /// It is open.
    Open,
    /// The board has sent a frame for the first time, or after a silence.
    Heard,
    /// It is gone, for this reason; it is looked for.
    Lost(String),
    /// The board does not read: so many frames have been left out so far.
    Stalled(u64),
    /// So many bytes have come, and no frame among them.
    Garbled(u64),
    /// The autopilot there is of this system, not of ours.
    OtherSystem {
        /// System of the autopilot there.
        found: u8,
        /// System of our vehicle.
        expected: u8,
    },
}

impl fmt::Display for LineNotice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open => f.write_str("open, waiting for the board"),
            Self::Heard => f.write_str("the board is heard"),
            Self::Lost(why) => write!(f, "lost ({why}); looking for it until it is plugged in again"),
            Self::Stalled(frames) => write!(f, "the board does not read: {frames} frames left out so far"),
            Self::Garbled(bytes) => write!(
                f,
                "{bytes} bytes have come and not one frame: has the board's port another baud rate (SER_*_BAUD; 921600 and 57600 are \
                 usual), or no MAVLink (MAV_*_CONFIG)?"
            ),
            Self::OtherSystem { found, expected } => write!(
                f,
                "the board is MAVLink system {found}, and {expected} is expected: MAV_SYS_ID there, or --instance N for system N + 1"
            ),
        }
    }
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(protocol, at, what) => write!(f, "{protocol} {at} open ({what})"),
            Self::Connected(peer, what) => write!(f, "connected to {what} {peer}"),
            Self::Disconnected(peer, reason) => write!(f, "connection to {peer} ended: {reason}"),
            Self::TurnedAway(peer) => write!(f, "turned {peer} away: an autopilot is connected already"),
            Self::Unattended(reason) => write!(f, "ends without an autopilot: {reason}"),
            Self::NobodyThere(at, what) => write!(f, "no {what} at {at} yet; trying on"),
            Self::Heard(peer, what) => write!(f, "heard {peer} ({what})"),
            Self::Crowded(peer, what) => write!(f, "no room for {peer} ({what}): too many peers"),
            Self::OtherClock(peer, what, (system, component), ahead_s) => {
                let way = if *ahead_s < 0 { "behind" } else { "ahead of" };
                let s = ahead_s.unsigned_abs();
                write!(f, "refused system {system}, component {component} at {peer} ({what}): ")?;
                write!(f, "rightly signed, but {s} s {way} our clock: ")?;
                f.write_str("the clocks of the two machines differ, or it was recorded")
            }
            Self::RefusedMeanwhile(faults) => {
                write!(f, "meanwhile {} frames have come and been refused ({faults})", faults.refused())?;
                if faults.replayed > 0 {
                    let why =
                        "; replayed: not later than what was believed before, by the .stamps beside the key";
                    f.write_str(why)?;
                }
                Ok(())
            }
            Self::StampsLost(place, reason) => {
                write!(f, "{place}: cannot keep the time stamps of signed frames: {reason}")
            }
            Self::Counts(what, faults) => write!(f, "{what}: {faults}"),
            Self::Garbage(what, faults) => {
                write!(f, "{what}: dropped {} bytes that are no frames", faults.skipped_bytes)?;
                if faults.refused() > 0 {
                    write!(f, ", refused {} frames", faults.refused())?;
                }
                write!(f, " ({faults})")
            }
            Self::Line(line, notice) => write!(f, "{line}: {notice}"),
            Self::NotInTime(times) => write!(
                f,
                "real time was not kept: {times} times the simulator was late by more than 0.1 s; is the machine busy?"
            ),
            Self::Simulator(event) => event.fmt(f),
            Self::Streamer(event) => event.fmt(f),
            Self::Autopilot { at, text, .. } => Timed { at: *at, event: format_args!("> {text}") }.fmt(f),
        }
    }
}

/// Receiver of what happens on the sockets.
pub trait Observer {
    /// Something happened.
    fn notice(&mut self, notice: Notice);

    /// A frame has come or gone by a link at a simulated time, for a `.tlog`.
    fn frame(&mut self, _now: TimeUs, _link: Link, _bytes: &[u8]) {}

    /// The simulator has flown on, and the flight's log is this by now; one that is shorter than before is
    /// that of a flight that has begun anew.
    fn flown(&mut self, _log: &[Sample]) {}

    /// Takes the text of a parameter file that a ground station wants kept.
    fn keep_parameters(&mut self, _text: &str) {}

    /// The autopilot has an entry for its flight log.
    fn log(&mut self, _entry: LogEntry) {}
}

impl<F: FnMut(Notice)> Observer for F {
    fn notice(&mut self, notice: Notice) {
        self(notice);
    }
}

/// Reports a decoder's faults at the 1st, 2nd, 4th, .. of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GarbageWatch {
    report_from: u64,
}

impl GarbageWatch {
    pub(super) fn look(&mut self, what: &What, faults: &Faults, observer: &mut impl Observer) {
        let bad = faults.skipped_bytes + faults.refused();
        if bad > self.report_from {
            self.report_from = bad.saturating_mul(2);
            observer.notice(Notice::Garbage(what.clone(), *faults));
        }
    }
}
