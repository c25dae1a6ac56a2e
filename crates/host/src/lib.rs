//! The host of studies: it flies their jobs on many threads, says how far they are, and keeps their rows, so
//! that a study that was stopped, or killed, goes on where it was and ends in the same bytes.
//!
//! | file | holds |
//! |---|---|
//! | [`kept`] | the rows that are kept, and those of an earlier run |

pub mod kept;

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;

use kept::KeptRows;
use rayon::ThreadPool;
use samara_study::jobs::{Fly, Jobs, Round, Row, Stop, Stopped};

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

/// Flies jobs on a pool of threads until it is to stop.
pub struct Host<'a> {
    pool: &'a ThreadPool,
    stop: Stop<'a>,
    progress: &'a dyn Progress,
    kept: KeptRows,
    /// Why rows could not be kept.
    failure: Option<io::Error>,
}

impl<'a> Host<'a> {
    /// A host on these threads that keeps rows so.
    pub fn new(pool: &'a ThreadPool, stop: Stop<'a>, progress: &'a dyn Progress, kept: KeptRows) -> Self {
        Self { pool, stop, progress, kept, failure: None }
    }

    /// Why a study was stopped, where that is an error of keeping its rows.
    pub fn failure(&mut self) -> Option<io::Error> {
        self.failure.take()
    }
}

/// Flies the groups from job `first` on; each row goes to `take` in the order of the jobs.
fn fly_from<R: Row>(
    (pool, stop, progress): (&ThreadPool, Stop<'_>, &dyn Progress),
    (round, first): (Round, u64),
    fly: Fly<'_, R>,
    mut take: impl FnMut(R) -> Result<(), Stopped>,
) -> Result<(), Stopped> {
    let groups = round.groups(first);
    let (next, ended) = (AtomicU64::new(0), AtomicBool::new(false));
    let is_over = || stop() || ended.load(Ordering::Relaxed);
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let sender = sender;
            pool.broadcast(|_| {
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
                if rows.into_iter().try_for_each(&mut take).is_err() {
                    ended.store(true, Ordering::Relaxed);
                    return Err(Stopped);
                }
            }
        }
        if taken == groups { Ok(()) } else { Err(Stopped) }
    })
}

impl Jobs for Host<'_> {
    fn fly<R: Row>(&mut self, what: &str, round: Round, fly: Fly<'_, R>) -> Result<Vec<R>, Stopped> {
        self.progress.begins(what);
        let mut rows = Vec::new();
        while (rows.len() as u64) < round.count {
            match self.kept.earlier() {
                Ok(Some(row)) => rows.push(row),
                Ok(None) => break,
                Err(error) => {
                    self.failure = Some(error);
                    return Err(Stopped);
                }
            }
        }
        self.progress.done(rows.len() as u64, true);
        let first = rows.len() as u64;
        let mut kept = std::mem::take(&mut self.kept);
        let mut failure = None;
        let hands = (self.pool, self.stop, self.progress);
        let flown = fly_from(hands, (round, first), fly, |row| {
            if let Err(error) = kept.keep(&row) {
                failure = Some(error);
                return Err(Stopped);
            }
            rows.push(row);
            Ok(())
        });
        self.kept = kept;
        self.failure = failure;
        flown.map(|()| rows)
    }
}

#[cfg(test)]
mod tests;
