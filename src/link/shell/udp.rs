//! A UDP socket with several peers: those who have spoken lately, and the default remotes.
//!
//! Everything goes to everyone, always from the same socket (ground stations remember where they heard a vehicle). A peer
//! counts once it has sent a sound frame; garbage makes nobody a peer.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::UdpSocket;

use super::super::{Decoder, Frame};
use super::clock::Since;
use super::notice::{GarbageWatch, Notice, Observer, ShellError};
use super::ports::loopback;

/// Most peers that are remembered; more than that is a mistake somewhere.
const MAX_PEERS: usize = 32;
/// Longest datagram.
const BUFFER_LEN: usize = 65_536;

/// The socket.
#[derive(Debug)]
pub struct UdpEndpoint {
    socket: UdpSocket,
    what: &'static str,
    defaults: Vec<SocketAddr>,
    peers: Vec<(SocketAddr, Since)>,
    memory: Duration,
    decoder: Decoder,
    garbage: GarbageWatch,
    buffer: Box<[u8]>,
}

impl UdpEndpoint {
    /// Binds a loopback port. `defaults` are the ports that are sent to unasked; who speaks is remembered for `memory`.
    ///
    /// # Errors
    /// [`ShellError`] naming the port.
    pub async fn bind(
        port: u16,
        what: &'static str,
        defaults: &[u16],
        memory: Duration,
        observer: &mut impl Observer,
    ) -> Result<Self, ShellError> {
        let at = loopback(port);
        let socket = UdpSocket::bind(at).await.map_err(|e| ShellError::bind("UDP", port, what, e))?;
        observer.notice(Notice::Open { protocol: "UDP", at: socket.local_addr().unwrap_or(at), what });
        Ok(Self {
            socket,
            what,
            defaults: defaults.iter().map(|p| loopback(*p)).collect(),
            peers: Vec::new(),
            memory,
            decoder: Decoder::new(),
            garbage: GarbageWatch::default(),
            buffer: vec![0; BUFFER_LEN].into_boxed_slice(),
        })
    }

    /// Waits until there is something to be received. Safe to cancel.
    pub async fn readable(&self) {
        // An error shows at the next receive.
        let _ = self.socket.readable().await;
    }

    /// Takes what has come, without waiting.
    pub fn receive<O: Observer>(&mut self, observer: &mut O, mut each: impl FnMut(&mut O, &Frame)) {
        // A flood must not keep the rest from running.
        for _ in 0..64 {
            match self.socket.try_recv_from(&mut self.buffer) {
                Ok((len, from)) => {
                    let mut sound = false;
                    self.decoder.datagram(&self.buffer[..len], |frame| {
                        sound = true;
                        each(observer, &frame);
                    });
                    if sound {
                        self.remember(from, observer);
                    }
                }
                Err(e) if e.kind() == io::ErrorKind::WouldBlock => break,
                // The answer to a datagram that nobody wanted (ECONNREFUSED); the socket is as good as before.
                Err(_) => {}
            }
        }
        self.garbage.look(self.what, self.decoder.faults(), observer);
    }

    /// Sends to everyone. What cannot be sent is lost, as datagrams are.
    pub fn send(&mut self, bytes: &[u8]) {
        let memory = self.memory;
        self.peers.retain(|(_, heard)| heard.elapsed() <= memory);
        let others = self.peers.iter().map(|(peer, _)| *peer).filter(|peer| !self.defaults.contains(peer));
        for peer in self.defaults.iter().copied().chain(others) {
            let _ = self.socket.try_send_to(bytes, peer);
        }
    }

    fn remember(&mut self, peer: SocketAddr, observer: &mut impl Observer) {
        if let Some((_, heard)) = self.peers.iter_mut().find(|(p, _)| *p == peer) {
            *heard = Since::now();
        } else if self.peers.len() < MAX_PEERS {
            self.peers.push((peer, Since::now()));
            observer.notice(Notice::Heard { peer, what: self.what });
        }
    }
}
