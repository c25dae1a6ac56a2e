//! Waiting for an autopilot's answer without giving the processor up, while that pays.
//!
//! PX4 answers a step within some 40 us; to put a processor to sleep and be woken on it may take as long
//! again. So at full speed the answer is looked for at once. It pays where the autopilot runs on another
//! processor, or goes before the simulator on the same; where it waits for this very one, looking for it only
//! holds it up, which is noticed.

use std::time::Duration;

use super::clock::Speed;
use super::connection::Connection;

/// An answer is looked for this long.
const PATIENCE: Duration = Duration::from_micros(200);
/// After so many answers in a row that did not come meanwhile, this does not pay here.
const MISSES: u32 = 4;
/// For so many answers it is then left alone.
const REST: u32 = 1_000;
/// After so many answers that came meanwhile the other sockets have their turn.
const PER_TURN: u32 = 16;

/// Busy waiting for an answer, as long as that pays.
#[derive(Debug)]
pub(super) struct BusyWait {
    pays: bool,
    misses: u32,
    rest: u32,
    since_turn: u32,
}

impl BusyWait {
    /// Waits busily at full speed only: a host that keeps the pace of a clock has time.
    pub(super) fn new(speed: Speed) -> Self {
        Self { pays: speed == Speed::Max, misses: 0, rest: 0, since_turn: 0 }
    }

    /// Looks for an answer. Whether something has come, to be received.
    pub(super) fn look(&mut self, connection: Option<&mut Connection>) -> bool {
        let Some(connection) = connection.filter(|_| self.pays) else { return false };
        if self.rest > 0 {
            self.rest -= 1;
            return false;
        }
        let came = connection.spin(PATIENCE);
        self.misses = if came { 0 } else { self.misses + 1 };
        if self.misses == MISSES {
            (self.misses, self.rest) = (0, REST);
        }
        came
    }

    /// Whether the other sockets have waited long enough; asked after each answer that came.
    pub(super) fn others_are_due(&mut self) -> bool {
        self.since_turn = (self.since_turn + 1) % PER_TURN;
        self.since_turn == 0
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use mavlink::dialects::common::{HEARTBEAT_DATA, MavMessage};
    use tokio::io::AsyncWriteExt as _;
    use tokio::net::{TcpListener, TcpStream};

    use super::super::super::{Encoder, Frame};
    use super::super::notice::Notice;
    use super::super::tests::block_on;
    use super::*;

    /// A connection whose other end is in our hands.
    async fn connected() -> (Connection, TcpStream) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let (far, near) = tokio::join!(TcpStream::connect(listener.local_addr().unwrap()), listener.accept());
        let (near, peer) = near.unwrap();
        (Connection::new(near, peer, "a test's link"), far.unwrap())
    }

    fn received(connection: &mut Connection) -> Vec<u32> {
        let mut ids = Vec::new();
        connection
            .receive(&mut |_: Notice| (), |_, frame: &Frame| ids.push(frame.message_id))
            .expect("the connection stands");
        ids
    }

    #[test]
    fn what_does_not_pay_is_left_alone_for_a_while_and_nothing_is_lost() {
        block_on(async {
            let (mut connection, mut far) = connected().await;
            let heartbeat = Encoder::new(1, 1).encode(&MavMessage::HEARTBEAT(HEARTBEAT_DATA::default()));
            let mut busy_wait = BusyWait::new(Speed::Max);
            far.write_all(&heartbeat).await.unwrap();
            assert!(busy_wait.look(Some(&mut connection)));
            assert_eq!(received(&mut connection), [0]);
            assert!((0..MISSES).all(|_| !busy_wait.look(Some(&mut connection))));
            far.write_all(&heartbeat).await.unwrap();
            assert!((0..REST).all(|_| !busy_wait.look(Some(&mut connection))), "it rests");
            assert!(busy_wait.look(Some(&mut connection)));
            assert_eq!(received(&mut connection), [0]);
            assert!(!busy_wait.look(None));
            assert!(!BusyWait::new(Speed::Factor(2.0)).look(Some(&mut connection)));
        });
    }

    #[test]
    fn an_end_is_left_to_who_receives() {
        block_on(async {
            let (mut connection, far) = connected().await;
            drop(far);
            assert!(!BusyWait::new(Speed::Max).look(Some(&mut connection)));
            Connection::ready(Some(&connection)).await;
            assert!(connection.receive(&mut |_: Notice| (), |_, _: &Frame| ()).is_err());
        });
    }

    #[test]
    fn the_other_sockets_have_their_turn() {
        let mut busy_wait = BusyWait::new(Speed::Max);
        let turns = (0..10 * PER_TURN).filter(|_| busy_wait.others_are_due()).count();
        assert_eq!(turns, 10);
    }
}
