//! One TCP connection as frames.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, Interest};
use tokio::net::TcpStream;

use super::super::decoder::Decoder;

use super::super::frame::Frame;
use super::clock::Since;
use super::notice::{GarbageWatch, Observer, What};

/// A peer that does not read for this long is gone.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);
/// Most bytes that wait for a peer; beyond, it is gone.
const MAX_WAITING: usize = 1 << 20;

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
    /// What the peer has not taken yet.
    outgoing: Vec<u8>,
    /// When it took something last, or had nothing to take.
    taken: Since,
}

impl Connection {
    pub(super) fn new(stream: TcpStream, peer: SocketAddr, what: &'static str) -> Self {
        // Small frames shall not wait for company.
        let _ = stream.set_nodelay(true);
        let (decoder, garbage, outgoing) = (Decoder::new(), GarbageWatch::default(), Vec::new());
        Self { stream, peer, what: what.into(), decoder, garbage, outgoing, taken: Since::now() }
    }

    /// Waits until there is something to read, or room for what waits to be sent; for ever without a
    /// connection. Safe to cancel.
    pub(super) async fn ready(connection: Option<&Self>) {
        match connection {
            // An error shows at the next receive.
            Some(connection) if connection.outgoing.is_empty() => _ = connection.stream.readable().await,
            Some(connection) => _ = connection.stream.ready(Interest::READABLE | Interest::WRITABLE).await,
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
        let _ = tokio::time::timeout(FAREWELL, self.stream.write_all(&self.outgoing)).await;
        let _ = self.stream.shutdown().await;
        let mut unread = [0; 4096];
        let drain = async { while self.stream.read(&mut unread).await.is_ok_and(|len| len > 0) {} };
        let _ = tokio::time::timeout(FAREWELL, drain).await;
    }

    /// Collects a frame to be sent.
    pub(super) fn queue(&mut self, bytes: &[u8]) {
        if self.outgoing.is_empty() {
            self.taken = Since::now();
        }
        self.outgoing.extend_from_slice(bytes);
    }

    /// Sends what has been collected, as much of it as there is room for; the rest waits for the next call.
    /// The reason when the peer is gone, or has not read for too long.
    pub(super) fn flush(&mut self) -> Result<(), String> {
        if self.outgoing.is_empty() {
            return Ok(());
        }
        match self.stream.try_write(&self.outgoing) {
            Ok(len) => {
                self.outgoing.drain(..len);
                self.taken = Since::now();
            }
            Err(e) if e.kind() == io::ErrorKind::WouldBlock => {}
            Err(e) => return Err(e.to_string()),
        }
        if self.outgoing.len() > MAX_WAITING {
            return Err(format!("the peer does not read: {} kB wait for it", MAX_WAITING / 1024));
        }
        if self.taken.elapsed() > WRITE_TIMEOUT {
            return Err(format!("the peer has not read for {} s", WRITE_TIMEOUT.as_secs()));
        }
        Ok(())
    }

    /// Whether something waits for the peer to read.
    pub(super) fn is_held_up(&self) -> bool {
        !self.outgoing.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use tokio::net::TcpListener;

    use super::super::tests::block_on;
    use super::*;

    /// More than the system's own buffers take, all at once: the patience of five seconds has not begun.
    #[test]
    fn who_reads_nothing_is_gone_once_a_mebibyte_waits() {
        block_on(async {
            let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
            let (far, near) =
                tokio::join!(TcpStream::connect(listener.local_addr().unwrap()), listener.accept());
            let ((near, peer), _far) = (near.unwrap(), far.unwrap());
            let mut connection = Connection::new(near, peer, "a test's link");
            connection.stream.writable().await.unwrap();
            let mut queued = 0;
            let why = loop {
                connection.queue(&[0; 1 << 16]);
                queued += 1 << 16;
                if let Err(why) = connection.flush() {
                    break why;
                }
                assert!(queued < 256 << 20, "everything is kept");
            };
            assert!(why.contains("1024 kB wait for it"), "{why}");
            assert!(connection.outgoing.len() <= MAX_WAITING + (1 << 16));
        });
    }
}
