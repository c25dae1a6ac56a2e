//! A UDP socket: it hears everybody (`udpin`) or one remote (`udpout`), and always sends from where it hears.

use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::task::{Context, Poll};

use tokio::net::UdpSocket;

use super::super::notice::{Notice, Observer, ShellError, What};
use super::Arrival;

/// Longest datagram.
const BUFFER_LEN: usize = 65_536;
/// A flood must not keep the rest from running: most datagrams that are taken at a time.
const AT_A_TIME: usize = 64;

/// The socket.
#[derive(Debug)]
pub(in super::super) struct Udp {
    socket: UdpSocket,
    /// The only one that is heard and spoken to.
    pub(super) remote: Option<SocketAddr>,
    buffer: Box<[u8]>,
}

impl Udp {
    /// Binds `at`.
    pub(super) async fn bind(
        at: SocketAddr,
        what: &What,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let socket = UdpSocket::bind(at).await.map_err(|e| ShellError::bind("UDP", at, what, e))?;
        // Until the system says so once, nothing can be sent.
        let _ = socket.writable().await;
        let at = socket.local_addr().unwrap_or(at);
        observer.notice(Notice::Open { protocol: "UDP", at, what: what.clone() });
        Ok(Self { socket, remote: None, buffer: vec![0; BUFFER_LEN].into_boxed_slice() })
    }

    /// Any port, to speak to `remote`; a loopback port if that is a loopback address.
    pub(super) async fn towards(
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
        let bound = Self::bind(SocketAddr::new(ip, 0), what, observer).await?;
        Ok(Self { remote: Some(remote), ..bound })
    }

    pub(super) fn poll_readable(&self, cx: &mut Context<'_>) -> Poll<()> {
        // An error shows at the next receive.
        self.socket.poll_recv_ready(cx).map(|_| ())
    }

    pub(super) fn receive(&mut self, each: &mut impl FnMut(Arrival<'_>) -> bool) {
        for _ in 0..AT_A_TIME {
            match self.socket.try_recv_from(&mut self.buffer) {
                Ok((len, from)) if self.remote.is_none_or(|remote| remote == from) => {
                    each(Arrival::Datagram(from, &self.buffer[..len]));
                }
                Ok(_) => {}
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => break,
                // The answer to a datagram that nobody wanted (ECONNREFUSED); the socket is as good as
                // before.
                Err(_) => {}
            }
        }
    }

    pub(super) fn send(&self, to: SocketAddr, bytes: &[u8]) {
        let _ = self.socket.try_send_to(bytes, to);
    }
}
