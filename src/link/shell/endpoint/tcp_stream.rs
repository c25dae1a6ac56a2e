//! One TCP connection that never makes anybody wait: what the peer does not take at once is kept, up to a
//! limit.

use std::io;
use std::net::SocketAddr;
use std::task::{Context, Poll};
use std::time::Duration;

use tokio::net::TcpStream;

use super::super::clock::Since;
use super::Arrival;

/// Most bytes that wait for a peer; at telemetry's rates more than ten seconds of it.
const MAX_WAITING: usize = 1 << 18;
/// A peer that takes nothing for this long, while something waits for it, is gone.
const PATIENCE: Duration = Duration::from_secs(5);
/// Most reads at a time: a flood must not keep the rest from running.
const AT_A_TIME: usize = 16;

/// The connection.
#[derive(Debug)]
pub(super) struct Stream {
    stream: TcpStream,
    pub(super) peer: SocketAddr,
    waiting: Vec<u8>,
    taken: Since,
    ended: Option<String>,
}

impl Stream {
    pub(super) fn new(stream: TcpStream, peer: SocketAddr) -> Self {
        // Small frames shall not wait for company.
        let _ = stream.set_nodelay(true);
        Self { stream, peer, waiting: Vec::new(), taken: Since::now(), ended: None }
    }

    pub(super) fn poll_readable(&self, cx: &mut Context<'_>) -> Poll<()> {
        if self.ended.is_some() {
            return Poll::Ready(());
        }
        self.stream.poll_read_ready(cx).map(|_| ())
    }

    /// Takes what has come and sends what waits; false once the connection has ended, which `each` has then
    /// been told.
    pub(super) fn receive(&mut self, each: &mut impl FnMut(Arrival<'_>) -> bool) -> bool {
        let mut buffer = [0; 4096];
        for _ in 0..AT_A_TIME {
            match self.stream.try_read(&mut buffer) {
                Ok(0) => {
                    self.ended.get_or_insert_with(|| "closed by the peer".to_owned());
                    break;
                }
                Ok(len) => _ = each(Arrival::Stream(self.peer, &buffer[..len])),
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => break,
                Err(e) => {
                    self.ended.get_or_insert_with(|| e.to_string());
                    break;
                }
            }
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

    pub(super) fn send(&mut self, bytes: &[u8]) {
        if self.waiting.len() + bytes.len() > MAX_WAITING {
            let reason = || format!("the peer does not read: {} kB wait for it", MAX_WAITING / 1024);
            self.ended.get_or_insert_with(reason);
            return;
        }
        if self.waiting.is_empty() {
            self.taken = Since::now();
        }
        self.waiting.extend_from_slice(bytes);
        self.flush();
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
