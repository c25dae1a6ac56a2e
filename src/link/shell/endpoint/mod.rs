//! The sockets of a link, by kind. They move bytes; who a peer is and what it gets is the hub's business.
//!
//! Each kind is one file and one arm of the matches below; none of them ever waits.

mod tcp_in;
mod tcp_out;
mod tcp_stream;
mod udp;

use std::net::SocketAddr;
use std::task::{Context, Poll};

use super::notice::{Observer, ShellError, What};
use super::url::{Kind, LinkUrl};
use tcp_in::TcpIn;
use tcp_out::TcpOut;
use udp::Udp;

/// What has come by an endpoint.
pub(super) enum Arrival<'a> {
    /// A datagram.
    Datagram(SocketAddr, &'a [u8]),
    /// A connection stands; whether there is room for it.
    Connected(SocketAddr),
    /// Bytes of a connection.
    Stream(SocketAddr, &'a [u8]),
    /// A connection has ended, and why.
    Ended(SocketAddr, String),
}

/// A socket, or a server with its connections.
#[derive(Debug)]
pub(super) enum Endpoint {
    Udp(Udp),
    TcpIn(TcpIn),
    TcpOut(TcpOut),
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
        match url.kind {
            Kind::UdpIn => Self::udp(at, what, observer).await,
            Kind::UdpOut => Self::udp_towards(at, what, observer).await,
            Kind::TcpIn => TcpIn::bind(at, what, observer).await.map(Self::TcpIn),
            Kind::TcpOut => Ok(Self::TcpOut(TcpOut::new(at, what.clone()))),
        }
    }

    /// A UDP socket that serves whoever speaks to it.
    pub(super) async fn udp(
        at: SocketAddr,
        what: &What,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        Udp::bind(at, what, observer).await.map(Self::Udp)
    }

    /// A UDP socket that speaks to one remote.
    pub(super) async fn udp_towards(
        remote: SocketAddr,
        what: &What,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        Udp::towards(remote, what, observer).await.map(Self::Udp)
    }

    /// The remote that is spoken to unasked.
    pub(super) fn default_remote(&self) -> Option<SocketAddr> {
        match self {
            Self::Udp(udp) => udp.remote,
            Self::TcpIn(_) | Self::TcpOut(_) => None,
        }
    }

    /// Whether something may have come; arranges to be woken if not.
    pub(super) fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        match self {
            Self::Udp(udp) => udp.poll_readable(cx),
            Self::TcpIn(server) => server.poll_readable(cx),
            Self::TcpOut(client) => client.poll_readable(cx),
        }
    }

    /// Takes what has come, without waiting; `each` answers whether it has room for a connection.
    pub(super) fn receive(
        &mut self,
        observer: &mut impl Observer,
        each: &mut impl FnMut(Arrival<'_>) -> bool,
    ) {
        match self {
            Self::Udp(udp) => udp.receive(each),
            Self::TcpIn(server) => server.receive(each),
            Self::TcpOut(client) => client.receive(observer, each),
        }
    }

    /// Sends to one address. What cannot be sent is lost, as datagrams are; a connection that cannot take
    /// more has ended, as the next [`Self::receive`] reports.
    pub(super) fn send(&mut self, to: SocketAddr, bytes: &[u8]) {
        match self {
            Self::Udp(udp) => udp.send(to, bytes),
            Self::TcpIn(server) => server.send(to, bytes),
            Self::TcpOut(client) => client.send(bytes),
        }
    }
}
