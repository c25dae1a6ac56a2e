//! Peers at the other end of a link.
//!
//! A link may have several peers: ground stations on one UDP port, clients of one TCP server. A frame says by
//! which it came ([`super::Frame::peer`]), so that the answer goes to whoever asked and to nobody else; what
//! is for everybody goes to all of them.

/// A peer of a party, by the number that the receiving side gave it; never used again for another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct PeerId(pub u32);

impl PeerId {
    /// The party at the other end of a wire in memory, or of a link that has one peer only.
    pub const ONLY: Self = Self(0);
}

/// Whom a frame is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recipient {
    /// Every peer of the link.
    All,
    /// The peer that asked.
    Peer(PeerId),
    /// Those that are there by arrangement (default remotes, connections), and these two; nobody else who has
    /// merely spoken.
    KeptAnd([PeerId; 2]),
}

impl Recipient {
    /// Whether a frame with this recipient goes to `peer`, which is not there by arrangement.
    pub fn includes(self, peer: PeerId) -> bool {
        match self {
            Self::All => true,
            Self::Peer(one) => one == peer,
            Self::KeptAnd(two) => two.contains(&peer),
        }
    }
}
