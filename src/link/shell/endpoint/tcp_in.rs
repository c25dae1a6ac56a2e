//! A TCP server with any number of clients that the hub has room for.

use std::net::SocketAddr;
use std::task::{Context, Poll, Waker};

use tokio::net::{TcpListener, TcpStream};

use super::super::notice::{Notice, Observer, ShellError, What};
use super::Arrival;
use super::tcp_stream::Stream;

/// The server and its clients.
#[derive(Debug)]
pub(in super::super) struct TcpIn {
    listener: TcpListener,
    /// Accepted while waiting.
    new: Vec<(TcpStream, SocketAddr)>,
    clients: Vec<Stream>,
}

impl TcpIn {
    /// Binds and listens.
    pub(super) async fn bind(
        at: SocketAddr,
        what: &What,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let listener = TcpListener::bind(at).await.map_err(|e| ShellError::bind("TCP", at, what, e))?;
        let at = listener.local_addr().unwrap_or(at);
        observer.notice(Notice::Open { protocol: "TCP", at, what: what.clone() });
        Ok(Self { listener, new: Vec::new(), clients: Vec::new() })
    }

    pub(super) fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        // A connection that is gone before it is accepted is nobody's loss.
        if let Poll::Ready(Ok(accepted)) = self.listener.poll_accept(cx) {
            self.new.push(accepted);
            return Poll::Ready(());
        }
        // Each must be asked, to be woken by any of them.
        let mut ready = false;
        for client in &self.clients {
            ready |= client.poll_readable(cx).is_ready();
        }
        if ready { Poll::Ready(()) } else { Poll::Pending }
    }

    pub(super) fn receive(&mut self, each: &mut impl FnMut(Arrival<'_>) -> bool) {
        // Also when nobody has waited in the meantime.
        let mut cx = Context::from_waker(Waker::noop());
        while let Poll::Ready(Ok(accepted)) = self.listener.poll_accept(&mut cx) {
            self.new.push(accepted);
        }
        for (stream, peer) in self.new.drain(..) {
            if each(Arrival::Connected(peer)) {
                self.clients.push(Stream::new(stream, peer));
            }
        }
        self.clients.retain_mut(|client| client.receive(each));
    }

    pub(super) fn send(&mut self, to: SocketAddr, bytes: &[u8]) {
        if let Some(client) = self.clients.iter_mut().find(|c| c.peer == to) {
            client.send(bytes);
        }
    }
}
