//! The host of studies: it flies their jobs on many threads, says how far they are, and keeps their rows, so
//! that a study that was stopped, or killed, goes on where it was and ends in the same bytes.
//!
//! | file | holds |
//! |---|---|
//! | [`kept`] | the rows that are kept, and those of an earlier run |
//! | `threads` | threads for many flights |
//! | [`shards`] | rounds cut into parts, each with a file of its own |

pub mod kept;
pub mod shards;
mod threads;

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use kept::{KeptRows, not_a_row};
use samara_study::jobs::{FlyNumbers, Jobs, Numbers, Round, Stop, Stopped};
use shards::{Ended, RoundThere, Shards};
pub use threads::Threads;

/// How far a study is, for whoever waits for it.
pub trait Progress {
    /// What is flown now.
    fn begins(&self, what: &str);
    /// So many jobs more are done; `kept`: by an earlier run.
    fn done(&self, jobs: u64, kept: bool);
}

/// Says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begins(&self, _: &str) {}
    fn done(&self, _: u64, _: bool) {}
}

/// Where rows come from, and go to.
enum Rows<'a> {
    /// One file, from the first row to the last.
    Kept(KeptRows),
    /// A file for each part of each round.
    Shards(Shards<'a>),
}

/// Flies jobs on a pool of threads until it is to stop.
pub struct Host<'a> {
    threads: &'a Threads,
    stop: Stop<'a>,
    progress: &'a dyn Progress,
    rows: Rows<'a>,
    /// Why rows could not be kept, or are none.
    failure: Option<io::Error>,
}

impl<'a> Host<'a> {
    /// A host on these threads that keeps rows so.
    pub fn new(threads: &'a Threads, stop: Stop<'a>, progress: &'a dyn Progress, kept: KeptRows) -> Self {
        Self { threads, stop, progress, rows: Rows::Kept(kept), failure: None }
    }

    /// A host on these threads that flies a shard, or puts all of them together.
    pub fn in_shards(
        threads: &'a Threads,
        stop: Stop<'a>,
        progress: &'a dyn Progress,
        shards: Shards<'a>,
    ) -> Self {
        Self { threads, stop, progress, rows: Rows::Shards(shards), failure: None }
    }

    /// Why a study was stopped, where that is an error of its rows.
    pub fn failure(&mut self) -> Option<io::Error> {
        self.failure.take()
    }

    /// How a study in shards ended, where it was stopped for the sake of others.
    pub fn ended(self) -> Option<Ended> {
        match self.rows {
            Rows::Kept(_) => None,
            Rows::Shards(shards) => shards.ended,
        }
    }
}

/// Flies the groups from job `first` on; the numbers of each row go to `take` in the order of the jobs.
fn fly_from(
    (threads, stop, progress): Hands<'_>,
    (round, first): (Round, u64),
    fly: FlyNumbers<'_>,
    mut take: impl FnMut(&[f64]) -> Result<(), Stopped>,
) -> Result<(), Stopped> {
    let groups = round.groups(first);
    let (next, ended) = (AtomicU64::new(0), AtomicBool::new(false));
    let is_over = || stop() || ended.load(Ordering::Relaxed);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let sender = sender;
            threads.all(|| {
                let sender = sender.clone();
                while !is_over() {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= groups {
                        break;
                    }
                    let Some(rows) = fly(round.group(first, number), &is_over) else { break };
                    // Nobody listens any more where a row was refused.
                    let _ = sender.send((number, rows));
                }
            });
        });
        // Threads take groups in their order, so few wait here for one before them.
        let (mut waiting, mut taken) = (BTreeMap::new(), 0);
        for (number, rows) in receiver {
            waiting.insert(number, rows);
            while let Some(rows) = waiting.remove(&taken) {
                taken += 1;
                progress.done(rows.len() as u64, false);
                if rows.iter().try_for_each(|row| take(row)).is_err() {
                    ended.store(true, Ordering::Relaxed);
                    return Err(Stopped);
                }
            }
        }
        if taken == groups { Ok(()) } else { Err(Stopped) }
    })
}

impl Jobs for Host<'_> {
    fn fly_numbers(
        &mut self,
        what: &str,
        round: Round,
        fly: FlyNumbers<'_>,
        take: &mut dyn FnMut(&[f64]) -> bool,
    ) -> Result<(), Stopped> {
        self.progress.begins(what);
        let hands = (self.threads, self.stop, self.progress);
        let flown = match &mut self.rows {
            Rows::Kept(kept) => fly_kept(kept, hands, (round, fly), take),
            Rows::Shards(shards) => fly_part(shards, hands, (round, fly), take),
        };
        flown.map_err(|error| {
            self.failure = error;
            Stopped
        })
    }
}

/// Threads, whether to stop, and who is told how far it is.
type Hands<'a> = (&'a Threads, Stop<'a>, &'a dyn Progress);

/// Takes the rows of an earlier run, flies the jobs that follow and keeps their rows. The error is why,
/// unless it was stopped.
fn fly_kept(
    kept: &mut KeptRows,
    hands: Hands<'_>,
    (round, fly): (Round, FlyNumbers<'_>),
    take: &mut dyn FnMut(&[f64]) -> bool,
) -> Result<(), Option<io::Error>> {
    let mut first = 0;
    while first < round.count {
        let Some(row) = kept.earlier() else { break };
        if !take(&row) {
            return Err(Some(not_a_row()));
        }
        first += 1;
    }
    hands.2.done(first, true);
    let mut failure = None;
    let flown = fly_from(hands, (round, first), fly, |row| {
        kept.keep(row).map_err(|error| {
            failure = Some(error);
            Stopped
        })?;
        if take(row) { Ok(()) } else { Err(Stopped) }
    });
    flown.map_err(|Stopped| failure)
}

/// Takes the rows of a round whose parts are all there; otherwise flies what is to be flown of it here, and
/// ends. The error is why, unless it was stopped or is at its end.
fn fly_part(
    shards: &mut Shards<'_>,
    hands: Hands<'_>,
    (round, fly): (Round, FlyNumbers<'_>),
    take: &mut dyn FnMut(&[f64]) -> bool,
) -> Result<(), Option<io::Error>> {
    let (of, missing) = match shards.round(round.count)? {
        RoundThere::Whole(rows) => {
            hands.2.done(round.count, true);
            return if rows.iter().all(|row| take(row)) { Ok(()) } else { Err(Some(not_a_row())) };
        }
        RoundThere::Missing(of, missing) => (of, missing),
    };
    let Some(cut) = shards.flown_here(round.count, of, missing) else { return Err(None) };
    let range = cut.range(round.count);
    let mut rows: Vec<Numbers> = Vec::new();
    let part = Round { count: range.end, ..round };
    let flown = fly_from(hands, (part, range.start), fly, |row| {
        rows.push(row.to_vec());
        Ok(())
    });
    match flown {
        Ok(()) => shards.write(cut, &rows)?,
        // Half a part is of no use to anybody.
        Err(Stopped) => shards.ended = None,
    }
    Err(None)
}

#[cfg(test)]
mod tests;
