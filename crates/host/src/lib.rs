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
use samara_study::jobs::{Clock, FlyNumbers, Jobs, Numbers, Round, Stage, Stop, Stopped};
use shards::{Ended, RoundThere, Shards};
pub use threads::Threads;

/// How far a study is, for whoever waits for it.
pub trait Progress {
    /// What is flown now.
    fn begins(&self, what: &str);
    /// So many jobs more are done; `kept`: by an earlier run.
    fn done(&self, jobs: u64, kept: bool);
    /// Another stage begins, of so many jobs at most, whose name for people this is.
    fn stage(&self, unit: &'static str, jobs: u64) {
        let _ = (unit, jobs);
    }
}

/// Says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begins(&self, _: &str) {}
    fn done(&self, _: u64, _: bool) {}
}

/// The rows of a study's first stage.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FirstStage {
    /// So many bytes of the file that keeps rows.
    Kept(u64),
    /// The text of such a file.
    Text(String),
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
    clock: Option<Clock>,
    /// Jobs that were flown here.
    flown: u64,
    /// Why rows could not be kept, or are none.
    failure: Option<io::Error>,
}

impl<'a> Host<'a> {
    /// A host on these threads that keeps rows so.
    pub fn new(threads: &'a Threads, stop: Stop<'a>, progress: &'a dyn Progress, kept: KeptRows) -> Self {
        Self::of((threads, stop, progress), Rows::Kept(kept))
    }

    /// A host on these threads that flies a shard, or puts all of them together.
    pub fn in_shards(
        threads: &'a Threads,
        stop: Stop<'a>,
        progress: &'a dyn Progress,
        shards: Shards<'a>,
    ) -> Self {
        Self::of((threads, stop, progress), Rows::Shards(shards))
    }

    fn of((threads, stop, progress): Hands<'a>, rows: Rows<'a>) -> Self {
        Self { threads, stop, progress, rows, clock: None, flown: 0, failure: None }
    }

    /// This host with a clock.
    #[must_use]
    pub fn with_clock(self, clock: Clock) -> Self {
        Self { clock: Some(clock), ..self }
    }

    /// The rows of the study's first stage, where another one follows: it may go on for longer.
    ///
    /// # Errors
    /// Of reading shards.
    pub fn first_stage(&self) -> io::Result<Option<FirstStage>> {
        Ok(match &self.rows {
            Rows::Kept(kept) => kept.first_stage().map(FirstStage::Kept),
            Rows::Shards(shards) => shards.first_stage()?.map(FirstStage::Text),
        })
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
        let count = AtomicU64::new(0);
        let counted: FlyNumbers<'_> = &|jobs, stop| {
            let rows = fly(jobs, stop)?;
            count.fetch_add(rows.len() as u64, Ordering::Relaxed);
            Some(rows)
        };
        let flown = match &mut self.rows {
            Rows::Kept(kept) => fly_kept(kept, hands, (round, counted), take),
            Rows::Shards(shards) => fly_part(shards, hands, (round, counted), take),
        };
        self.flown += count.into_inner();
        flown.map_err(|error| {
            self.failure = error;
            Stopped
        })
    }

    fn stage(&mut self, stage: &Stage<'_>) -> Result<(), Stopped> {
        self.progress.stage(stage.unit, stage.jobs);
        let begun = match &mut self.rows {
            Rows::Kept(kept) => kept.stage(stage.hangs_on),
            Rows::Shards(shards) => {
                shards.stage(stage.hangs_on);
                Ok(())
            }
        };
        begun.map_err(|error| {
            self.failure = Some(error);
            Stopped
        })
    }

    fn wants_so_far(&self) -> bool {
        matches!(self.rows, Rows::Kept(_)) && self.failure.is_none()
    }

    fn flown(&self) -> u64 {
        self.flown
    }

    fn clock(&self) -> Option<Clock> {
        self.clock.clone()
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
        let Some(row) = kept.earlier().map_err(Some)? else { break };
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
