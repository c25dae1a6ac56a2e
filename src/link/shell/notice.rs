//! What the shell tells its caller, and why it cannot go on.

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::net::SocketAddr;

use super::super::{Faults, HilEvent, Link, LogEntry, StreamerEvent, TimeUs, Timed};

/// What a socket is for, or as which it was typed.
pub type What = Cow<'static, str>;

/// Why sockets cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ShellError {
    /// Somebody else has the port.
    #[error(
        "{protocol} port {port} ({what}) is in use: is another instance running? --instance shifts the ports"
    )]
    PortBusy {
        /// "TCP" or "UDP".
        protocol: &'static str,
        /// The port.
        port: u16,
        /// What it is for.
        what: What,
    },
    /// The port cannot be had for another reason.
    #[error("{protocol} port {port} ({what})")]
    Bind {
        /// "TCP" or "UDP".
        protocol: &'static str,
        /// The port.
        port: u16,
        /// What it is for.
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
    /// A socket is open.
    Open {
        /// "TCP" or "UDP".
        protocol: &'static str,
        /// Where.
        at: SocketAddr,
        /// What for.
        what: What,
    },
    /// A connection stands.
    Connected {
        /// To whom.
        peer: SocketAddr,
        /// What for.
        what: What,
    },
    /// A connection has ended.
    Disconnected {
        /// Whose.
        peer: SocketAddr,
        /// Why.
        reason: String,
    },
    /// A second autopilot has tried to connect and has been sent away.
    TurnedAway {
        /// Who.
        peer: SocketAddr,
    },
    /// Nobody listens there yet; it is tried again and again.
    NobodyThere {
        /// Where.
        at: SocketAddr,
        /// What should be there.
        what: What,
    },
    /// A peer has spoken on a UDP socket for the first time, or after a silence.
    Heard {
        /// Who.
        peer: SocketAddr,
        /// On which socket.
        what: What,
    },
    /// There is no room for a further peer.
    Crowded {
        /// Who.
        peer: SocketAddr,
        /// On which socket.
        what: What,
    },
    /// At the end: everything that came, by kind.
    Counts {
        /// On which socket.
        what: What,
        /// The counts.
        faults: Faults,
    },
    /// Bytes have come that are no frames, or frames that are not let in; told at the 1st, 2nd, 4th, .. time.
    Garbage {
        /// On which socket.
        what: What,
        /// All that this socket has dropped so far.
        faults: Faults,
    },
    /// Of the simulator.
    Simulator(Timed<HilEvent>),
    /// Of the streamer.
    Streamer(Timed<StreamerEvent>),
    /// The autopilot's STATUSTEXT.
    Autopilot {
        /// Simulated time.
        at: TimeUs,
        /// `MAV_SEVERITY`, 0 the worst, 7 debug.
        severity: u8,
        /// The text.
        text: String,
    },
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open { protocol, at, what } => write!(f, "{protocol} {at} open ({what})"),
            Self::Connected { peer, what } => write!(f, "connected to {what} {peer}"),
            Self::Disconnected { peer, reason } => write!(f, "connection to {peer} ended: {reason}"),
            Self::TurnedAway { peer } => {
                write!(f, "turned {peer} away: an autopilot is connected already")
            }
            Self::NobodyThere { at, what } => write!(f, "no {what} at {at} yet; trying on"),
            Self::Heard { peer, what } => write!(f, "heard {peer} ({what})"),
            Self::Crowded { peer, what } => write!(f, "no room for {peer} ({what}): too many peers"),
            Self::Counts { what, faults } => write!(f, "{what}: {faults}"),
            Self::Garbage { what, faults } => {
                write!(f, "{what}: dropped {} bytes that are no frames", faults.skipped_bytes)?;
                if faults.refused() > 0 {
                    write!(f, ", refused {} frames", faults.refused())?;
                }
                write!(f, " ({faults})")
            }
            Self::Simulator(event) => event.fmt(f),
            Self::Streamer(event) => event.fmt(f),
            Self::Autopilot { at, text, .. } => Timed { at: *at, event: format_args!("> {text}") }.fmt(f),
        }
    }
}

/// Who wants to know.
pub trait Observer {
    /// Something happened.
    fn notice(&mut self, notice: Notice);

    /// A frame has come or gone by `link` at simulated time `now`, for a `.tlog`.
    fn frame(&mut self, now: TimeUs, link: Link, bytes: &[u8]) {
        let _ = (now, link, bytes);
    }

    /// A ground station wants the parameters kept: the text of a parameter file.
    fn keep_parameters(&mut self, text: &str) {
        let _ = text;
    }

    /// The autopilot has an entry for its flight log.
    fn log(&mut self, entry: LogEntry) {
        let _ = entry;
    }
}

impl<F: FnMut(Notice)> Observer for F {
    fn notice(&mut self, notice: Notice) {
        self(notice);
    }
}

/// Tells of a decoder's faults at the 1st, 2nd, 4th, .. of them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct GarbageWatch {
    tell_from: u64,
}

impl GarbageWatch {
    pub(super) fn look(&mut self, what: &What, faults: &Faults, observer: &mut impl Observer) {
        let bad = faults.skipped_bytes + faults.refused();
        if bad > self.tell_from {
            self.tell_from = bad.saturating_mul(2);
            observer.notice(Notice::Garbage { what: what.clone(), faults: *faults });
        }
    }
}
