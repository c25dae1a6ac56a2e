//! The autopilot's TCP client: tries until the simulator is there, as PX4 does.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::TcpStream;

use super::clock::Since;
use super::notice::{Notice, Observer};
use super::ports::loopback;

/// Between two tries.
const RETRY: Duration = Duration::from_millis(250);

/// Tries to connect to a loopback port.
#[derive(Debug)]
pub struct TcpClient {
    at: SocketAddr,
    what: &'static str,
    tried: Option<Since>,
    reported: bool,
}

impl TcpClient {
    /// For the port on which `what` should listen.
    pub fn new(port: u16, what: &'static str) -> Self {
        Self { at: loopback(port), what, tried: None, reported: false }
    }

    /// How long until it is time for the next try.
    pub fn until_next_try(&self) -> Duration {
        self.tried.map_or(Duration::ZERO, |tried| RETRY.saturating_sub(tried.elapsed()))
    }

    /// Tries once, if it is time to; the connection has no Nagle's delay. That nobody is there is reported
    /// once.
    pub async fn try_connect(&mut self, observer: &mut impl Observer) -> Option<(TcpStream, SocketAddr)> {
        if !self.until_next_try().is_zero() {
            return None;
        }
        self.tried = Some(Since::now());
        // On the loopback interface this is decided at once.
        if let Ok(stream) = TcpStream::connect(self.at).await {
            let _ = stream.set_nodelay(true);
            self.reported = false;
            observer.notice(Notice::Connected { peer: self.at, what: self.what.into() });
            return Some((stream, self.at));
        }
        if !self.reported {
            self.reported = true;
            observer.notice(Notice::NobodyThere { at: self.at, what: self.what.into() });
        }
        None
    }
}
