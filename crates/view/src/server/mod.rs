//! The server: one browser on this machine asks, nobody else is heard.
//!
//! | file | holds |
//! |---|---|
//! | [`guard`] | who may ask |
//! | `answers` | the door, the files of the page, and who answers what else is asked |
//! | `mission` | what is asked of a mission: flights, campaigns, files |
//! | `body` | answers and their bodies, also what is new of a flight; bodies that come |
//! | this one | the listener and its connections |

mod answers;
mod body;
pub mod guard;
mod mission;

use std::convert::Infallible;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;

use answers::Answers;
pub use answers::Shown;
use guard::Token;

/// Connections at once; others wait until one of them ends.
const CONNECTIONS_MOST: usize = 32;
/// Time in which the head of a request is to be there, and then its body.
const PATIENCE: Duration = Duration::from_secs(5);

/// For so long at most those who look on are given what a flight has ended with.
const LAST_WORDS: Duration = Duration::from_secs(1);
/// So often it is looked whether a flight has ended.
const END_LOOKED_FOR_EVERY: Duration = Duration::from_millis(20);

/// A server that listens on this machine's own address.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    answers: Arc<Answers>,
    address: SocketAddr,
    token: Token,
    patience: Duration,
}

impl Server {
    /// Listens on a port of 127.0.0.1, on any free one where it is 0, for whoever has the address with its
    /// token, which is new. To be called within a runtime of tokio.
    ///
    /// # Errors
    /// Of the system: the port is taken, there is no randomness, or no thread.
    pub fn listen(shown: Shown, port: u16) -> io::Result<Self> {
        let listener = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        listener.set_nonblocking(true)?;
        let (listener, token) = (TcpListener::from_std(listener)?, Token::new()?);
        let address = listener.local_addr()?;
        let answers = Arc::new(Answers::new(shown, address.port(), token)?);
        Ok(Self { listener, answers, address, token, patience: PATIENCE })
    }

    /// This server with another patience.
    #[cfg(test)]
    fn patient_for(self, patience: Duration) -> Self {
        Self { patience, ..self }
    }

    /// The address that a browser is to open: the token is behind `#`, which no browser sends to anybody.
    pub fn address(&self) -> String {
        format!("http://{}/#{}", self.address, self.token)
    }

    /// Serves until it is dropped; to be called within a runtime of tokio. Whatever is being computed ends
    /// soon after that.
    pub async fn serve(self) -> Infallible {
        let room = Arc::new(Semaphore::new(CONNECTIONS_MOST));
        let _ends = EndsWithIt(self.answers.clone());
        loop {
            let Ok(place) = room.clone().acquire_owned().await else { std::future::pending().await };
            let Ok((stream, _)) = self.listener.accept().await else {
                // Out of files, say: others are to end first.
                tokio::time::sleep(Duration::from_millis(50)).await;
                continue;
            };
            let _ = stream.set_nodelay(true);
            let (answers, patience) = (self.answers.clone(), self.patience);
            tokio::spawn(async move {
                let service = service_fn(|request| async {
                    Ok::<_, Infallible>(answers.clone().answer(request, patience).await)
                });
                let mut http = http1::Builder::new();
                http.timer(TokioTimer::new()).header_read_timeout(patience).max_buf_size(guard::HEAD_MOST);
                // What a connection ended by is its peer's affair.
                let _ = http.serve_connection(TokioIo::new(stream), service).await;
                drop(place);
            });
        }
    }

    /// Serves a flight until those who look on have had its end; who does not read is not waited for. To be
    /// called within a runtime of tokio.
    pub async fn serve_to_the_end(self) {
        let Some(feed) = self.answers.flight().cloned() else { return };
        let end = async {
            while !feed.has_ended() {
                tokio::time::sleep(END_LOOKED_FOR_EVERY).await;
            }
            let had = async {
                while feed.readers() > 0 {
                    tokio::time::sleep(END_LOOKED_FOR_EVERY).await;
                }
                // What the last one was given is on its way.
                tokio::time::sleep(END_LOOKED_FOR_EVERY).await;
            };
            let _ = tokio::time::timeout(LAST_WORDS, had).await;
        };
        tokio::select! {
            never = self.serve() => match never {},
            () = end => {}
        }
    }
}

/// Has everything end that is being computed.
struct EndsWithIt(Arc<Answers>);

impl Drop for EndsWithIt {
    fn drop(&mut self) {
        self.0.end();
    }
}

#[cfg(test)]
mod tests;
