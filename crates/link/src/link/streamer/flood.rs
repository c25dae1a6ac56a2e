//! How many of the vehicle's texts are reported: a vehicle whose time jumps, or a network that doubles what
//! it says, may bring thousands.

use core::time::Duration;

/// Most texts that are reported within [`WINDOW`].
const MOST: u32 = 50;
const WINDOW: Duration = Duration::from_secs(10);

/// Whether a text is reported.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Told {
    Yes,
    /// It is the first that is not.
    Last,
    No,
}

/// The texts of the present stretch of wall time. A host that tells no wall time has no network, and a
/// vehicle whose own reports are bounded: all are told.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Flood {
    since: Duration,
    texts: u32,
}

impl Flood {
    /// Counts a text that has come at `wall`, in wall time since the host began.
    pub(super) fn take(&mut self, wall: Option<Duration>) -> Told {
        let Some(wall) = wall else { return Told::Yes };
        if wall >= self.since + WINDOW {
            *self = Self { since: wall, texts: 0 };
        }
        self.texts = self.texts.saturating_add(1);
        match self.texts {
            ..=MOST => Told::Yes,
            n if n == MOST + 1 => Told::Last,
            _ => Told::No,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_told_once_and_ends_with_its_stretch_of_time() {
        let at = |s: u64| Some(Duration::from_secs(s));
        let mut flood = Flood::default();
        let told: Vec<Told> = (0..u64::from(MOST) + 3).map(|i| flood.take(at(1 + i % 2))).collect();
        assert!(told[..MOST as usize].iter().all(|t| *t == Told::Yes), "{told:?}");
        assert_eq!(told[MOST as usize..], [Told::Last, Told::No, Told::No]);
        assert_eq!(
            [flood.take(at(9)), flood.take(at(10)), flood.take(at(10))],
            [Told::No, Told::Yes, Told::Yes]
        );
    }

    #[test]
    fn a_host_without_a_clock_is_told_all() {
        let mut flood = Flood::default();
        assert!((0..10_000).all(|_| flood.take(None) == Told::Yes));
    }
}
