//! Where the time stamps of signed frames are kept between two starts.

use std::fmt::Debug;
use std::io;
use std::sync::Arc;

use super::super::signing::{ClockError, Key};
use super::super::stamps::{Stamps, StampsError};
use super::notice::{Notice, Observer, ShellError};

/// Keeps the time stamps of parties' signed frames, as text, from one start to the next.
pub trait StampStore: Debug + Send + Sync {
    /// What was stored last for a party of this system and component; None if nothing was.
    ///
    /// # Errors
    /// The system's reason, with the place.
    fn load(&self, party: (u8, u8)) -> io::Result<Option<String>>;

    /// Stores the text for a party in place of what was there.
    ///
    /// # Errors
    /// The system's reason, with the place.
    fn store(&self, party: (u8, u8), text: &str) -> io::Result<()>;

    /// The place of a party's stamps, for messages.
    fn place(&self, party: (u8, u8)) -> String;
}

/// How a party signs.
#[derive(Clone, Debug)]
pub struct SignWith {
    /// The key that everything but the simulator's link is signed with.
    pub key: Key,
    /// Where the time stamps survive a restart.
    pub stamps: Arc<dyn StampStore>,
}

/// The place of one party's stamps.
#[derive(Debug)]
pub(super) struct Keeper {
    store: Arc<dyn StampStore>,
    party: (u8, u8),
    failed: bool,
}

impl Keeper {
    /// With the stamps that are there.
    pub(super) fn open(sign: &SignWith, party: (u8, u8)) -> Result<(Self, Stamps), ShellError> {
        let store = sign.stamps.clone();
        let error = |source| ShellError::Stamps { place: store.place(party), source };
        let text = store.load(party).map_err(error)?.unwrap_or_default();
        let wrong = |e: StampsError| error(io::Error::new(io::ErrorKind::InvalidData, e));
        let stamps = Stamps::parse(&text).map_err(wrong)?;
        // That they cannot be kept is to be known before anybody relies on them.
        store.store(party, &stamps.to_text()).map_err(error)?;
        let keeper = Self { store: sign.stamps.clone(), party, failed: false };
        Ok((keeper, stamps))
    }

    /// By this clock they cannot be gone on from.
    pub(super) fn refuse(&self, source: ClockError) -> ShellError {
        ShellError::Clock { place: self.store.place(self.party), source }
    }

    /// Stores them; what goes wrong is told once.
    pub(super) fn store(&mut self, stamps: &Stamps, observer: &mut impl Observer) {
        let stored = self.store.store(self.party, &stamps.to_text());
        if let Err(e) = stored
            && !std::mem::replace(&mut self.failed, true)
        {
            observer.notice(Notice::StampsLost(self.store.place(self.party), e.to_string()));
        }
    }
}
