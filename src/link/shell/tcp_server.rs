//! The simulator's TCP server: one autopilot at a time.

use std::net::SocketAddr;

use tokio::net::{TcpListener, TcpStream};

use super::notice::{Notice, Observer, ShellError};
use super::ports::loopback;

/// Listens on a loopback port.
#[derive(Debug)]
pub struct TcpServer {
    listener: TcpListener,
}

impl TcpServer {
    /// Binds and listens.
    ///
    /// # Errors
    /// [`ShellError`] naming the port.
    pub async fn bind(
        port: u16,
        what: &'static str,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let at = loopback(port);
        let listener =
            TcpListener::bind(at).await.map_err(|e| ShellError::bind("TCP", at, &what.into(), e))?;
        observer.notice(Notice::Open {
            protocol: "TCP",
            at: listener.local_addr().unwrap_or(at),
            what: what.into(),
        });
        Ok(Self { listener })
    }

    /// The next connection, without Nagle's delay. Safe to cancel.
    pub async fn accept(&self) -> (TcpStream, SocketAddr) {
        loop {
            // A connection that is gone before it is accepted is nobody's loss.
            if let Ok((stream, peer)) = self.listener.accept().await {
                let _ = stream.set_nodelay(true);
                return (stream, peer);
            }
            tokio::task::yield_now().await;
        }
    }
}
