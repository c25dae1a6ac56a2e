//! One TCP connection as frames.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

use super::super::decoder::Decoder;

use super::super::frame::Frame;
use super::clock::Since;
use super::notice::{GarbageWatch, Observer, What};

/// A peer that does not read for this long is gone.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// Pauses of the processor between two looks of [`Connection::spin`]: a sibling on the same core shall not
/// suffer.
#[cfg(unix)]
const PAUSES: u32 = 60;

/// A peer is given this long to close its side as well.
const FAREWELL: Duration = Duration::from_millis(200);

/// The connection.
#[derive(Debug)]
pub(super) struct Connection {
    stream: TcpStream,
    pub(super) peer: SocketAddr,
    what: What,
    decoder: Decoder,
    garbage: GarbageWatch,
    outgoing: Vec<u8>,
}

impl Connection {
    pub(super) fn new(stream: TcpStream, peer: SocketAddr, what: &'static str) -> Self {
        // Small frames shall not wait for company.
        let _ = stream.set_nodelay(true);
        let (decoder, garbage, outgoing) = (Decoder::new(), GarbageWatch::default(), Vec::new());
        Self { stream, peer, what: what.into(), decoder, garbage, outgoing }
    }

    /// Waits until there is something to read; for ever without a connection. Safe to cancel.
    pub(super) async fn readable(connection: Option<&Self>) {
        match connection {
            // An error shows at the next receive.
            Some(connection) => _ = connection.stream.readable().await,
            None => std::future::pending().await,
        }
    }

    /// Looks for something to read, again and again for `patience`, without giving the processor up: to be
    /// woken takes longer than an autopilot's step. Whether there was something; it is received at the next
    /// [`Self::receive`].
    #[cfg(unix)]
    pub(super) fn spin(&mut self, patience: Duration) -> bool {
        use rustix::io::Errno;
        use rustix::net::{RecvFlags, recv};

        let since = Since::now();
        let mut buffer = [0; 4096];
        while since.elapsed() < patience {
            match recv(&self.stream, &mut buffer, RecvFlags::DONTWAIT) {
                Ok((len, _)) if len > 0 => {
                    self.decoder.push(&buffer[..len]);
                    return true;
                }
                Err(Errno::AGAIN) => (0..PAUSES).for_each(|_| std::hint::spin_loop()),
                // An end or an error shows at the next receive.
                _ => return false,
            }
        }
        false
    }

    /// Never finds anything.
    #[cfg(not(unix))]
    pub(super) fn spin(&mut self, _: Duration) -> bool {
        false
    }

    /// Reads what has come, without waiting; the reason when the connection has ended.
    pub(super) fn receive<O: Observer>(
        &mut self,
        observer: &mut O,
        mut each: impl FnMut(&mut O, &Frame),
    ) -> Result<(), String> {
        let mut buffer = [0; 4096];
        match self.stream.try_read(&mut buffer) {
            Ok(0) => return Err("closed by the peer".to_owned()),
            Ok(len) => self.decoder.push(&buffer[..len]),
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => {}
            Err(e) => return Err(e.to_string()),
        }
        while let Some(frame) = self.decoder.next_frame() {
            each(observer, &frame);
        }
        self.garbage.look(&self.what, self.decoder.faults(), observer);
        Ok(())
    }

    /// The peer is silent: a half frame that waits for its rest is not going to get it.
    pub(super) fn give_up_half_frames<O: Observer>(
        &mut self,
        observer: &mut O,
        mut each: impl FnMut(&mut O, &Frame),
    ) {
        while self.decoder.pending() > 0 {
            self.decoder.give_up();
            while let Some(frame) = self.decoder.next_frame() {
                each(observer, &frame);
            }
        }
        self.garbage.look(&self.what, self.decoder.faults(), observer);
    }

    /// Ends it so that the peer reads all that was sent and then the end. (To close with something unread
    /// would be a reset, which may overtake the last messages.)
    pub(super) async fn close(mut self) {
        let _ = self.stream.shutdown().await;
        let mut unread = [0; 4096];
        let drain = async { while self.stream.read(&mut unread).await.is_ok_and(|len| len > 0) {} };
        let _ = tokio::time::timeout(FAREWELL, drain).await;
    }

    /// Collects a frame to be sent.
    pub(super) fn queue(&mut self, bytes: &[u8]) {
        self.outgoing.extend_from_slice(bytes);
    }

    /// Sends what has been collected, in one piece; the reason when that cannot be done. Not safe to cancel.
    pub(super) async fn flush(&mut self) -> Result<(), String> {
        if self.outgoing.is_empty() {
            return Ok(());
        }
        // There is room, but for a peer that has not read for long.
        let gone = match self.stream.try_write(&self.outgoing) {
            Ok(len) => len,
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => 0,
            Err(e) => {
                self.outgoing.clear();
                return Err(e.to_string());
            }
        };
        let rest = &self.outgoing[gone..];
        let sent = if rest.is_empty() {
            Ok(Ok(()))
        } else {
            tokio::time::timeout(WRITE_TIMEOUT, self.stream.write_all(rest)).await
        };
        self.outgoing.clear();
        match sent {
            Ok(Ok(())) => Ok(()),
            Ok(Err(e)) => Err(e.to_string()),
            Err(_) => Err(format!("the peer has not read for {} s", WRITE_TIMEOUT.as_secs())),
        }
    }
}
