//! A population on its way up: levels of points, each sampled beyond a threshold that the one before reached.

use crate::math;
use crate::random::{Purpose, Stream, normal_pair};

/// Share of a level's points that begin the next.
pub(super) const SHARE: f64 = 0.1;
/// Share of accepted steps that the width is steered to (Papaioannou et al. 2015, 4.2).
const ACCEPTED: f64 = 0.44;
/// Width of the first steps.
const FIRST_WIDTH: f64 = 0.6;

/// A level of a population.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Score that all of its points reach; minus infinity of the first.
    pub threshold: f64,
    /// Probability of reaching that, by this population.
    pub probability: f64,
    /// Scores of its points, the highest first.
    pub scores: Vec<f64>,
    /// Share of the steps that were accepted; 1 of the first level, which has none.
    pub accepted: f64,
}

/// How a population climbed.
#[derive(Clone, Debug, PartialEq)]
pub struct Ascent {
    /// The levels, from the bottom up.
    pub levels: Vec<Level>,
    /// Points that were scored.
    pub scored: u64,
    /// Whether it ended below the bound because so many points have the same score that no threshold lies
    /// above it.
    pub stalled: bool,
}

impl Level {
    /// How many of its points have a score of at least `x`.
    pub fn reached(&self, x: f64) -> usize {
        self.scores.partition_point(|score| *score >= x)
    }
}

impl Ascent {
    /// The probability that a score is at least `x`: of the highest level whose threshold is not above `x`.
    pub fn exceedance(&self, x: f64) -> f64 {
        self.level_at(x).map_or(1.0, |(_, level)| {
            level.probability * level.reached(x) as f64 / level.scores.len().max(1) as f64
        })
    }

    /// The highest level whose threshold is not above `x`, with its number from 0.
    pub(super) fn level_at(&self, x: f64) -> Option<(usize, &Level)> {
        self.levels.iter().enumerate().rev().find(|(_, level)| level.threshold <= x)
    }

    /// The threshold of the highest level.
    pub fn top(&self) -> f64 {
        self.levels.last().map_or(f64::NEG_INFINITY, |level| level.threshold)
    }
}

/// A point with its score.
#[derive(Clone, Debug)]
struct Scored {
    point: Vec<f64>,
    score: f64,
}

/// A population on its way up.
pub(super) struct Population {
    seed: u64,
    number: u64,
    size: usize,
    dimensions: usize,
    done: Vec<Level>,
    threshold: f64,
    probability: f64,
    /// Scores of the level so far.
    scores: Vec<f64>,
    /// The best points of the level so far, at least as many as begin the next.
    best: Vec<Scored>,
    /// Number of them at which those that are not needed are let go.
    prune_at: usize,
    /// Where each chain is; none on the first level.
    chains: Vec<Scored>,
    /// Steps that each chain has taken on this level.
    steps: usize,
    /// Width of a step: the share of a standard deviation that is drawn anew.
    width: f64,
    moved: (u64, u64),
    scored: u64,
    ended: bool,
    stalled: bool,
}

impl Population {
    pub(super) fn new(seed: u64, number: u64, size: usize, dimensions: usize) -> Self {
        Self {
            seed,
            number,
            size,
            dimensions,
            done: Vec::new(),
            threshold: f64::NEG_INFINITY,
            probability: 1.0,
            scores: Vec::new(),
            best: Vec::new(),
            prune_at: 0,
            chains: Vec::new(),
            steps: 0,
            width: FIRST_WIDTH,
            moved: (0, 0),
            scored: 0,
            ended: false,
            stalled: false,
        }
    }

    /// The number of points that begin a level.
    fn seeds(&self) -> usize {
        ((SHARE * self.size as f64).round() as usize).clamp(1, self.size)
    }

    /// Normal numbers of a chain's step, from a stream of their own.
    fn normals(&self, chain: usize) -> Vec<f64> {
        let level = self.done.len() as u64;
        let place = [(self.number, 4), (level, 8), (chain as u64, 26), (self.steps as u64, 26)];
        let number = place.into_iter().fold(0, |number, (part, bits)| number << bits | part);
        let mut stream = Stream::new(self.seed, Purpose::RareFailures, number);
        let mut normals = Vec::with_capacity(self.dimensions + 1);
        while normals.len() < self.dimensions {
            normals.extend(normal_pair(stream.bits()));
        }
        normals.truncate(self.dimensions);
        normals
    }

    /// The next points to be scored; none once it has ended.
    pub(super) fn propose(&mut self) -> Vec<Vec<f64>> {
        if self.ended {
            return Vec::new();
        }
        let left = self.size - self.scores.len();
        if self.chains.is_empty() {
            // As many at a time as chains step, so that no more points are held than there.
            let fresh = (0..self.seeds().min(left)).map(|chain| self.normals(chain));
            return fresh.collect();
        }
        let keeps = (1.0 - self.width * self.width).sqrt();
        let step = |(chain, at): (usize, &Scored)| {
            let mut point = self.normals(chain);
            for (x, from) in point.iter_mut().zip(&at.point) {
                *x = keeps * from + self.width * *x;
            }
            point
        };
        self.chains.iter().enumerate().take(left).map(step).collect()
    }

    /// Takes the proposed points with their scores; at a level's end begins the next, or ends.
    pub(super) fn take(&mut self, scored: Vec<(Vec<f64>, f64)>, bound: f64, thresholds: usize) {
        if self.ended {
            return;
        }
        self.scored += scored.len() as u64;
        self.steps += 1;
        if self.chains.is_empty() {
            for (point, score) in scored {
                self.keep(Scored { point, score });
            }
        } else {
            let count = scored.len().max(1);
            let mut accepted = 0;
            for (chain, (point, score)) in scored.into_iter().enumerate() {
                if score >= self.threshold {
                    accepted += 1;
                    self.chains[chain] = Scored { point, score };
                }
                self.keep(self.chains[chain].clone());
            }
            self.moved.0 += accepted;
            self.moved.1 += count as u64;
            let off = accepted as f64 / count as f64 - ACCEPTED;
            self.width = (self.width * math::exp(off / (self.steps as f64).sqrt())).clamp(1e-3, 1.0);
        }
        if self.scores.len() >= self.size {
            self.end_level(bound, thresholds);
        }
    }

    /// Counts a point, and holds it while it is among the best.
    fn keep(&mut self, scored: Scored) {
        self.scores.push(scored.score);
        self.best.push(scored);
        let seeds = self.seeds();
        if self.best.len() >= self.prune_at {
            // All that are as good as the last of them stay: which of those go on is not theirs to decide.
            let mut scores: Vec<f64> = self.best.iter().map(|scored| scored.score).collect();
            scores.sort_by(|a, b| b.total_cmp(a));
            let least = scores.get(seeds - 1).copied().unwrap_or(f64::NEG_INFINITY);
            self.best.retain(|scored| scored.score >= least);
            self.prune_at = self.best.len() + seeds;
        }
    }

    fn end_level(&mut self, bound: f64, thresholds: usize) {
        let mut scores = std::mem::take(&mut self.scores);
        scores.sort_by(|a, b| b.total_cmp(a));
        self.best.sort_by(|a, b| b.score.total_cmp(&a.score));
        let seeds = self.seeds();
        let failing = scores.partition_point(|score| *score >= bound);
        let next = threshold(&scores, seeds);
        self.stalled = failing < seeds && next.is_none();
        self.ended = failing >= seeds || next.is_none() || self.done.len() >= thresholds;
        let (accepted, tried) = self.moved;
        let accepted = if tried > 0 { accepted as f64 / tried as f64 } else { 1.0 };
        let (threshold, probability) = (self.threshold, self.probability);
        if let Some(next) = next.filter(|_| !self.ended) {
            let reached = scores.partition_point(|score| *score >= next);
            self.probability *= reached as f64 / scores.len() as f64;
            self.threshold = next;
            self.climb();
        }
        self.done.push(Level { threshold, probability, scores, accepted });
    }

    /// Begins chains at the best points, which are the first of the next level.
    fn climb(&mut self) {
        let mut best = std::mem::take(&mut self.best);
        best.truncate(best.partition_point(|scored| scored.score >= self.threshold));
        best.iter().for_each(|seed| self.scores.push(seed.score));
        self.chains.clone_from(&best);
        self.best = best;
        self.steps = 0;
        self.moved = (0, 0);
    }

    /// How it climbed, and the failures among the points that it holds.
    pub(super) fn finish(self, bound: f64) -> (Ascent, Vec<Vec<f64>>) {
        let Self { done: levels, scored, stalled, best, .. } = self;
        let failures = best.into_iter().filter(|scored| scored.score >= bound).map(|scored| scored.point);
        (Ascent { levels, scored, stalled }, failures.collect())
    }
}

/// The score that the best `seeds` of a level reach, `scores` from the highest on; a higher one where so many
/// have that score that most points reach it. `None` where all are alike.
fn threshold(scores: &[f64], seeds: usize) -> Option<f64> {
    let next = *scores.get(seeds.checked_sub(1)?)?;
    let reached = scores.partition_point(|score| *score >= next);
    if 2 * reached <= scores.len() {
        return Some(next);
    }
    let above = scores.partition_point(|score| *score > next);
    scores.get(above.checked_sub(1)?).copied()
}
