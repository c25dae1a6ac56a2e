//! A TCP client that tries until somebody listens, and again when the connection has ended.

use std::future::Future as _;
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use tokio::net::TcpStream;
use tokio::task::JoinHandle;

use super::super::clock::Since;
use super::super::notice::{Notice, Observer, What};
use super::Arrival;
use super::tcp_stream::Stream;

/// From one try to the next.
const RETRY: Duration = Duration::from_secs(1);

/// The client.
#[derive(Debug)]
pub(in super::super) struct TcpOut {
    at: SocketAddr,
    what: What,
    tried: Option<Since>,
    reported: bool,
    trying: Option<JoinHandle<io::Result<TcpStream>>>,
    connected: Option<Stream>,
}

impl TcpOut {
    pub(super) fn new(at: SocketAddr, what: What) -> Self {
        Self { at, what, tried: None, reported: false, trying: None, connected: None }
    }

    pub(super) fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        match (&self.connected, &mut self.trying) {
            (Some(stream), _) => stream.poll_readable(cx),
            // Looked at by the next receive.
            (None, Some(trying)) if trying.is_finished() => Poll::Ready(()),
            _ => Poll::Pending,
        }
    }

    pub(super) fn receive(
        &mut self,
        observer: &mut impl Observer,
        each: &mut impl FnMut(Arrival<'_>) -> bool,
    ) {
        if let Some(stream) = &mut self.connected {
            if !stream.receive(each) {
                self.connected = None;
            }
            return;
        }
        if let Some(result) = self.finished() {
            match result {
                Ok(stream) => {
                    self.reported = false;
                    if each(Arrival::Connected(self.at)) {
                        self.connected = Some(Stream::new(stream, self.at));
                    }
                }
                Err(_) if !std::mem::replace(&mut self.reported, true) => {
                    observer.notice(Notice::NobodyThere { at: self.at, what: self.what.clone() });
                }
                Err(_) => {}
            }
        } else if self.trying.is_none() && self.tried.is_none_or(|tried| tried.elapsed() >= RETRY) {
            self.tried = Some(Since::now());
            // A host far away may let us wait for long.
            self.trying = Some(tokio::spawn(TcpStream::connect(self.at)));
        }
    }

    /// Outcome of the running try, if it has ended.
    fn finished(&mut self) -> Option<io::Result<TcpStream>> {
        let trying = self.trying.as_mut()?;
        let mut cx = Context::from_waker(Waker::noop());
        let Poll::Ready(result) = Pin::new(trying).poll(&mut cx) else { return None };
        self.trying = None;
        Some(result.unwrap_or_else(|e| Err(io::Error::other(e))))
    }

    pub(super) fn send(&mut self, bytes: &[u8]) {
        if let Some(stream) = &mut self.connected {
            stream.send(bytes);
        }
    }
}
