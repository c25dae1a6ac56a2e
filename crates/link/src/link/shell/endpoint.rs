//! The sockets of a link: UDP, and TCP as server and as client; and a serial line. They move bytes; who a
//! peer is and what it gets is the hub's business. None of them ever waits.

use std::future::Future as _;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::pin::Pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use tokio::net::{TcpListener, TcpStream, UdpSocket};
use tokio::task::JoinHandle;

use super::clock::Since;
use super::notice::{Notice, Observer, ShellError, What};
use super::serial::{LineNews, SerialLine};
use super::url::{Kind, LinkUrl};

/// Longest datagram.
const DATAGRAM_LEN: usize = 65_536;
/// Longest datagram that several frames share [bytes]: it travels whole over Ethernet, with room for tunnels.
const SHARED_LEN: usize = 1400;
/// Most datagrams that are taken at a time: a flood must not keep the rest from running. A datagram may hold
/// thousands of frames: once so many bytes have come, no further one is taken.
const DATAGRAMS_AT_A_TIME: usize = 64;
const BYTES_AT_A_TIME: usize = 1 << 16;
/// Most reads of a connection at a time, for the same reason.
const READS_AT_A_TIME: usize = 4;
/// Most bytes that wait for a connection's peer; at telemetry's rates more than ten seconds of it.
const MAX_WAITING: usize = 1 << 18;
/// A connection's peer that takes nothing for this long, while something waits for it, is gone.
const PATIENCE: Duration = Duration::from_secs(5);
/// From one try to connect to the next.
const RETRY: Duration = Duration::from_secs(1);

/// What has come by an endpoint.
pub(super) enum Arrival<'a> {
    /// A datagram.
    Datagram(SocketAddr, &'a [u8]),
    /// Somebody has connected.
    Accepted(SocketAddr),
    /// A connection of our own stands; whether there is room for it.
    Connected(SocketAddr),
    /// Bytes of a connection.
    Stream(SocketAddr, &'a [u8]),
    /// A connection has ended, and why.
    Ended(SocketAddr, String),
    /// Nobody listens there yet.
    NobodyThere(SocketAddr),
    /// News of a serial line.
    Line(LineNews<'a>),
}

/// Stands for the other end of a serial line, which has no address.
pub(super) const LINE_END: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::UNSPECIFIED), 0);

/// A socket with its connections, or a serial line.
#[derive(Debug)]
pub(super) enum Endpoint {
    /// Hears everybody (`udpin`) or one remote (`udpout`), and always sends from where it hears.
    Udp {
        socket: UdpSocket,
        remote: Option<SocketAddr>,
        buffer: Box<[u8]>,
        queued: Vec<(SocketAddr, Vec<u8>)>,
    },
    /// As many connections as the hub has room for (`tcpin`), or one (`tcpout`).
    Tcp(TcpSource, Vec<Stream>),
    /// One board.
    Serial(Box<SerialLine>),
}

impl Endpoint {
    /// Opens what was typed.
    pub(super) async fn open(
        url: &LinkUrl,
        what: &What,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let resolved = url.resolve();
        let at = resolved.map_err(|source| ShellError::Host { url: url.to_string(), source })?;
        let source = match url.kind {
            Kind::UdpIn => return Self::udp(at, None, what, observer).await,
            Kind::UdpOut => return Self::udp_towards(at, what, observer).await,
            Kind::TcpIn => TcpSource::Server(listen(at, what, observer).await?, Vec::new()),
            Kind::TcpOut => TcpSource::Client { at, tried: None, reported: false, trying: None },
        };
        Ok(Self::Tcp(source, Vec::new()))
    }

    /// A UDP socket that serves whoever speaks to it, or the `remote` alone.
    pub(super) async fn udp(
        at: SocketAddr,
        remote: Option<SocketAddr>,
        what: &What,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let socket = UdpSocket::bind(at).await.map_err(|e| ShellError::bind("UDP", at, what, e))?;
        // Until the system says so once, nothing can be sent.
        let _ = socket.writable().await;
        let at = socket.local_addr().unwrap_or(at);
        observer.notice(Notice::Open("UDP", at, what.clone()));
        let buffer = vec![0; DATAGRAM_LEN].into_boxed_slice();
        Ok(Self::Udp { socket, remote, buffer, queued: Vec::new() })
    }

    /// A UDP socket on any port that speaks to one remote; on a loopback port if that is a loopback address.
    pub(super) async fn udp_towards(
        remote: SocketAddr,
        what: &What,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let ip: IpAddr = match (remote.ip(), remote.ip().is_loopback()) {
            (IpAddr::V4(_), true) => Ipv4Addr::LOCALHOST.into(),
            (IpAddr::V4(_), false) => Ipv4Addr::UNSPECIFIED.into(),
            (IpAddr::V6(_), true) => Ipv6Addr::LOCALHOST.into(),
            (IpAddr::V6(_), false) => Ipv6Addr::UNSPECIFIED.into(),
        };
        Self::udp(SocketAddr::new(ip, 0), Some(remote), what, observer).await
    }

    /// The remote that is spoken to unasked.
    pub(super) fn default_remote(&self) -> Option<SocketAddr> {
        match self {
            Self::Udp { remote, .. } => *remote,
            Self::Tcp(..) => None,
            Self::Serial(_) => Some(LINE_END),
        }
    }

    /// Whether something may have come; arranges to be woken if not. Errors show at the next receive.
    pub(super) fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        match self {
            Self::Udp { socket, .. } => socket.poll_recv_ready(cx).map(|_| ()),
            Self::Tcp(source, streams) => {
                // Each must be asked, to be woken by any of them.
                let mut ready = source.poll_new(streams.is_empty(), cx);
                for stream in streams {
                    ready |= stream.ended.is_some() || stream.stream.poll_read_ready(cx).is_ready();
                }
                if ready { Poll::Ready(()) } else { Poll::Pending }
            }
            Self::Serial(line) => line.poll_readable(cx),
        }
    }

    /// Takes what has come, without waiting; `each` answers whether it has room for a connection. Whether
    /// nothing more is there.
    pub(super) fn receive(&mut self, each: &mut impl FnMut(Arrival<'_>) -> bool) -> bool {
        match self {
            Self::Udp { socket, remote, buffer, .. } => {
                let mut bytes = 0;
                for _ in 0..DATAGRAMS_AT_A_TIME {
                    if bytes > BYTES_AT_A_TIME {
                        break;
                    }
                    match socket.try_recv_from(buffer) {
                        Ok((len, from)) if remote.is_none_or(|remote| remote == from) => {
                            bytes += len;
                            each(Arrival::Datagram(from, &buffer[..len]));
                        }
                        Ok(_) => {}
                        Err(e) if e.kind() == io::ErrorKind::WouldBlock => return true,
                        // The answer to a datagram that nobody wanted (ECONNREFUSED); the socket is as good
                        // as before.
                        Err(_) => {}
                    }
                }
                false
            }
            Self::Tcp(source, streams) => {
                let is_server = matches!(source, TcpSource::Server(..));
                for (stream, peer) in source.take_new(streams.is_empty(), each) {
                    let new = if is_server { Arrival::Accepted(peer) } else { Arrival::Connected(peer) };
                    if each(new) {
                        streams.push(Stream::new(stream, peer));
                    }
                }
                streams.retain_mut(|stream| stream.receive(each));
                true
            }
            Self::Serial(line) => {
                line.receive(&mut |news| _ = each(Arrival::Line(news)));
                true
            }
        }
    }

    /// Closes a connection, for a reason that the next [`Self::receive`] reports.
    pub(super) fn close(&mut self, peer: SocketAddr, reason: &str) {
        if let Self::Tcp(_, streams) = self
            && let Some(stream) = streams.iter_mut().find(|s| s.peer == peer)
        {
            stream.ended.get_or_insert_with(|| reason.to_owned());
        }
    }

    /// Takes a frame for one address, to be sent by [`Self::flush`]: what is queued for an address until then
    /// shares datagrams.
    pub(super) fn queue(&mut self, to: SocketAddr, frame: &[u8]) {
        match self {
            Self::Udp { socket, queued, .. } => {
                let Some((_, bytes)) = queued.iter_mut().find(|q| q.0 == to) else {
                    return queued.push((to, frame.to_vec()));
                };
                if bytes.len() + frame.len() > SHARED_LEN {
                    _ = socket.try_send_to(bytes, to);
                    bytes.clear();
                }
                bytes.extend_from_slice(frame);
            }
            Self::Tcp(_, streams) => {
                if let Some(stream) = streams.iter_mut().find(|s| s.peer == to) {
                    stream.queue(frame);
                }
            }
            Self::Serial(line) => line.queue(frame),
        }
    }

    /// Sends what is queued. What cannot be sent is lost, as datagrams are; a connection that cannot take
    /// more has ended, as the next [`Self::receive`] reports.
    pub(super) fn flush(&mut self) {
        match self {
            Self::Udp { socket, queued, .. } => {
                for (to, bytes) in queued.drain(..) {
                    _ = socket.try_send_to(&bytes, to);
                }
            }
            Self::Tcp(_, streams) => streams.iter_mut().for_each(Stream::flush),
            // What is wrong shows at the next receive.
            Self::Serial(line) => _ = line.flush(),
        }
    }
}

/// Binds a TCP port and listens.
pub(super) async fn listen(
    at: SocketAddr,
    what: &What,
    observer: &mut impl Observer,
) -> Result<TcpListener, ShellError> {
    let listener = TcpListener::bind(at).await.map_err(|e| ShellError::bind("TCP", at, what, e))?;
    let at = listener.local_addr().unwrap_or(at);
    observer.notice(Notice::Open("TCP", at, what.clone()));
    Ok(listener)
}

/// Where connections come from.
#[derive(Debug)]
pub(super) enum TcpSource {
    /// Others make them; those that were accepted while waiting are kept.
    Server(TcpListener, Vec<(TcpStream, SocketAddr)>),
    /// We make one, trying until somebody listens, and another when it has ended.
    Client {
        at: SocketAddr,
        tried: Option<Since>,
        reported: bool,
        trying: Option<JoinHandle<io::Result<TcpStream>>>,
    },
}

impl TcpSource {
    /// Whether there may be a new connection; `idle`: there is none so far.
    fn poll_new(&mut self, idle: bool, cx: &mut Context<'_>) -> bool {
        match self {
            Self::Server(listener, accepted) => {
                // A connection that is gone before it is accepted is nobody's loss.
                if let Poll::Ready(Ok(new)) = listener.poll_accept(cx) {
                    accepted.push(new);
                }
                !accepted.is_empty()
            }
            Self::Client { trying, .. } => idle && trying.as_ref().is_some_and(JoinHandle::is_finished),
        }
    }

    /// The connections that are new. That nobody listens is reported once.
    fn take_new(
        &mut self,
        idle: bool,
        each: &mut impl FnMut(Arrival<'_>) -> bool,
    ) -> Vec<(TcpStream, SocketAddr)> {
        let mut cx = Context::from_waker(Waker::noop());
        match self {
            Self::Server(listener, accepted) => {
                // Also when nobody has waited in the meantime.
                while let Poll::Ready(Ok(new)) = listener.poll_accept(&mut cx) {
                    accepted.push(new);
                }
                return std::mem::take(accepted);
            }
            Self::Client { at, reported, trying: running @ Some(_), .. } if idle => {
                let Some(Poll::Ready(result)) = running.as_mut().map(|r| Pin::new(r).poll(&mut cx)) else {
                    return Vec::new();
                };
                *running = None;
                if let Ok(Ok(stream)) = result {
                    *reported = false;
                    return vec![(stream, *at)];
                }
                if !std::mem::replace(reported, true) {
                    each(Arrival::NobodyThere(*at));
                }
            }
            Self::Client { at, tried, trying, .. } => {
                if idle && tried.is_none_or(|tried| tried.elapsed() >= RETRY) {
                    *tried = Some(Since::now());
                    // A host far away may let us wait for long.
                    *trying = Some(tokio::spawn(TcpStream::connect(*at)));
                }
            }
        }
        Vec::new()
    }
}

/// One TCP connection that never makes anybody wait: what the peer does not take at once is kept, up to a
/// limit.
#[derive(Debug)]
pub(super) struct Stream {
    stream: TcpStream,
    peer: SocketAddr,
    waiting: Vec<u8>,
    taken: Since,
    ended: Option<String>,
}

impl Stream {
    fn new(stream: TcpStream, peer: SocketAddr) -> Self {
        // Small frames shall not wait for company.
        let _ = stream.set_nodelay(true);
        Self { stream, peer, waiting: Vec::new(), taken: Since::now(), ended: None }
    }

    /// Takes what has come and sends what waits; false once the connection has ended, which `each` has then
    /// heard.
    fn receive(&mut self, each: &mut impl FnMut(Arrival<'_>) -> bool) -> bool {
        let mut buffer = [0; 4096];
        for _ in 0..READS_AT_A_TIME {
            let reason = match self.stream.try_read(&mut buffer) {
                Ok(0) => "closed by the peer".to_owned(),
                Ok(len) => {
                    each(Arrival::Stream(self.peer, &buffer[..len]));
                    continue;
                }
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => break,
                Err(e) => e.to_string(),
            };
            self.ended.get_or_insert(reason);
            break;
        }
        self.flush();
        match self.ended.take() {
            Some(reason) => {
                each(Arrival::Ended(self.peer, reason));
                false
            }
            None => true,
        }
    }

    fn queue(&mut self, bytes: &[u8]) {
        if self.waiting.len() + bytes.len() > MAX_WAITING {
            self.flush();
        }
        if self.waiting.len() + bytes.len() > MAX_WAITING {
            let reason = || format!("the peer does not read: {} kB wait for it", MAX_WAITING / 1024);
            self.ended.get_or_insert_with(reason);
            return;
        }
        if self.waiting.is_empty() {
            self.taken = Since::now();
        }
        self.waiting.extend_from_slice(bytes);
    }

    fn flush(&mut self) {
        while !self.waiting.is_empty() && self.ended.is_none() {
            match self.stream.try_write(&self.waiting) {
                Ok(len) => {
                    self.waiting.drain(..len);
                    self.taken = Since::now();
                }
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => {
                    if self.taken.elapsed() > PATIENCE {
                        self.ended = Some(format!("the peer has not read for {} s", PATIENCE.as_secs()));
                    }
                    return;
                }
                Err(e) => self.ended = Some(e.to_string()),
            }
        }
    }
}
