//! Statistics of campaigns whose parts may be flown apart: a tree over fixed blocks of trials.
//!
//! Sums of floating-point numbers depend on their order. Here it depends on the numbers of the trials alone:
//! a block is [`BLOCK_TRIALS`] trials, counted from trial 0, summed in their order; two neighbours of 2^k
//! blocks of which the first begins at a multiple of 2^(k+1) blocks are joined; and what is left of the
//! campaign at the end is joined from its beginning on. A part keeps the plain values of the trials before
//! its first whole block and after its last one, so that parts with cuts anywhere come to the sums, to the
//! bit, of the campaign that was flown in one go.

use super::statistics::{Share, Summary};

/// Trials of a block.
pub const BLOCK_TRIALS: u64 = 256;

/// Whole blocks that are joined: 2^level of them, from a multiple of as many on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockNode {
    /// Binary logarithm of the number of blocks.
    pub level: u32,
    /// The values of their trials.
    pub summary: Summary,
}

impl BlockNode {
    /// The number of trials.
    fn trials(&self) -> Option<u64> {
        BLOCK_TRIALS.checked_shl(self.level).filter(|trials| trials >> self.level == BLOCK_TRIALS)
    }
}

/// Statistics of a quantity over consecutive trials, from any trial on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockSummary {
    first: u64,
    end: u64,
    /// Values of the trials before the first whole block.
    head: Vec<Option<f64>>,
    nodes: Vec<BlockNode>,
    /// Values of the trials after the last whole block.
    tail: Vec<Option<f64>>,
}

/// Why parts do not make statistics of consecutive trials.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BlockError {
    /// A part does not begin where the trials before it end.
    #[error("a part that begins with trial {expected} is expected, found trial {found}")]
    NotNext {
        /// The next trial.
        expected: u64,
        /// The first trial of the part.
        found: u64,
    },
    /// Blocks are not where blocks are.
    #[error("blocks of {BLOCK_TRIALS} trials, counted from trial 0, are expected after trial {0}")]
    NotBlocks(u64),
}

fn summed(values: &[Option<f64>]) -> Summary {
    let mut summary = Summary::default();
    values.iter().flatten().for_each(|x| summary.push(*x));
    summary
}

impl BlockSummary {
    /// No trials yet, the first of which will be trial number `first`.
    pub fn from_trial(first: u64) -> Self {
        Self { first, end: first, ..Self::default() }
    }

    /// Statistics of trials from `first` on: values before the first whole block, blocks, values after them.
    ///
    /// # Errors
    /// [`BlockError`] where those do not follow each other.
    pub fn from_parts(
        first: u64,
        head: &[Option<f64>],
        nodes: &[BlockNode],
        tail: &[Option<f64>],
    ) -> Result<Self, BlockError> {
        let mut whole = Self::from_trial(first);
        head.iter().for_each(|x| whole.push(*x));
        for node in nodes {
            whole.push_node(*node)?;
        }
        tail.iter().for_each(|x| whole.push(*x));
        Ok(whole)
    }

    /// Values before the first whole block, blocks, and values after them.
    pub fn parts(&self) -> (&[Option<f64>], &[BlockNode], &[Option<f64>]) {
        (&self.head, &self.nodes, &self.tail)
    }

    /// Number of the first trial.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// Number of the trial after the last.
    pub fn end(&self) -> u64 {
        self.end
    }

    /// Takes the next trial; one without a value counts as a trial.
    pub fn push(&mut self, value: Option<f64>) {
        let boundary = self.first.checked_next_multiple_of(BLOCK_TRIALS);
        let in_head = boundary.is_none_or(|boundary| self.end < boundary);
        self.end = self.end.saturating_add(1);
        if in_head {
            self.head.push(value);
            return;
        }
        self.tail.push(value);
        if self.tail.len() as u64 == BLOCK_TRIALS {
            let node = BlockNode { level: 0, summary: summed(&self.tail) };
            self.tail.clear();
            self.join(node);
        }
    }

    /// Takes the trials of a part that follows.
    ///
    /// # Errors
    /// [`BlockError::NotNext`] where it does not.
    pub fn append(&mut self, part: &Self) -> Result<(), BlockError> {
        if part.first != self.end {
            return Err(BlockError::NotNext { expected: self.end, found: part.first });
        }
        part.head.iter().for_each(|x| self.push(*x));
        for node in &part.nodes {
            self.push_node(*node)?;
        }
        part.tail.iter().for_each(|x| self.push(*x));
        Ok(())
    }

    fn push_node(&mut self, node: BlockNode) -> Result<(), BlockError> {
        let trials = node.trials().filter(|trials| self.end.is_multiple_of(*trials));
        let end = trials.and_then(|trials| self.end.checked_add(trials));
        self.end = end.filter(|_| self.tail.is_empty()).ok_or(BlockError::NotBlocks(self.end))?;
        self.join(node);
        Ok(())
    }

    /// Joins whole blocks that end with the last trial to those before them.
    fn join(&mut self, node: BlockNode) {
        let mut node = node;
        while let Some(before) = self.nodes.last().filter(|before| before.level == node.level) {
            // Two neighbours end together where a node of twice the size ends.
            if !self.end.is_multiple_of(BLOCK_TRIALS << (node.level + 1)) {
                break;
            }
            node = BlockNode { level: node.level + 1, summary: before.summary.joined(&node.summary) };
            self.nodes.pop();
        }
        self.nodes.push(node);
    }

    /// Statistics of all trials.
    pub fn summary(&self) -> Summary {
        let head = summed(&self.head);
        let blocks = self.nodes.iter().fold(head, |sum, node| sum.joined(&node.summary));
        blocks.joined(&summed(&self.tail))
    }

    /// Number of trials with a value.
    pub fn count(&self) -> u64 {
        self.summary().count()
    }

    /// Mean, as [`Summary::mean`].
    pub fn mean(&self) -> f64 {
        self.summary().mean()
    }

    /// Standard deviation, as [`Summary::std`].
    pub fn std(&self) -> f64 {
        self.summary().std()
    }

    /// Least value.
    pub fn min(&self) -> f64 {
        self.summary().min()
    }

    /// Greatest value.
    pub fn max(&self) -> f64 {
        self.summary().max()
    }

    /// Interval of the mean, as [`Summary::mean_interval`].
    pub fn mean_interval(&self) -> (f64, f64) {
        self.summary().mean_interval()
    }
}

/// Statistics of a campaign's trials.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// J_TPF.
    pub j_tpf: BlockSummary,
    /// Trials that stayed below the bound.
    pub safe: Share,
}

impl Tally {
    /// Takes the next trial; it is safe when J_TPF is below `bound`.
    pub fn push(&mut self, j_tpf: f64, bound: f64) {
        self.j_tpf.push(Some(j_tpf));
        self.safe.push(j_tpf < bound);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::random::{Purpose, Stream};

    fn value(trial: u64) -> Option<f64> {
        let x = Stream::new(3, Purpose::Dice, trial).normal();
        (!trial.is_multiple_of(7)).then_some(1e3 + x)
    }

    fn flown(first: u64, end: u64) -> BlockSummary {
        let mut part = BlockSummary::from_trial(first);
        (first..end).for_each(|trial| part.push(value(trial)));
        part
    }

    /// By hand: 1000 trials are three blocks and 232 values; the first two blocks are joined, then the third
    /// joins them, then the rest.
    #[test]
    fn closed_form_the_tree_of_a_thousand_trials() {
        let of = |from: u64, to: u64| summed(&(from..to).map(value).collect::<Vec<_>>());
        let pair = of(0, 256).joined(&of(256, 512));
        assert_eq!(flown(0, 1000).summary(), pair.joined(&of(512, 768)).joined(&of(768, 1000)));
        assert_eq!(flown(0, 200).summary(), of(0, 200));
        let part = flown(100, 1000);
        let (head, nodes, tail) = part.parts();
        assert_eq!((head.len(), nodes.len(), tail.len()), (156, 2, 232));
    }

    #[test]
    fn what_does_not_follow_is_refused() {
        let mut part = flown(0, 300);
        assert_eq!(part.append(&flown(301, 400)), Err(BlockError::NotNext { expected: 300, found: 301 }));
        let node = BlockNode { level: 0, summary: Summary::default() };
        let of = |first: u64, head: usize, level: u32| {
            BlockSummary::from_parts(first, &vec![None; head], &[BlockNode { level, ..node }], &[])
        };
        assert_eq!(of(0, 0, 0).map(|s| s.end()), Ok(256));
        assert_eq!(of(0, 5, 0), Err(BlockError::NotBlocks(5)));
        assert_eq!(of(256, 0, 1), Err(BlockError::NotBlocks(256)));
        for level in [56, 63, 64, 200] {
            assert_eq!(of(256, 0, level), Err(BlockError::NotBlocks(256)), "{level}");
        }
    }

    proptest! {
        /// Parts with cuts anywhere, also inside a block, joined in any grouping, are the whole to the bit;
        /// so they are after having been taken apart.
        #[test]
        fn prop_any_cut_gives_the_same_bits(
            end in 1u64..6000,
            mut cuts in prop::collection::vec(0u64..6000, 0..6),
        ) {
            cuts.retain(|cut| *cut < end);
            cuts.extend([0, end]);
            cuts.sort_unstable();
            let parts: Vec<BlockSummary> = cuts.windows(2).map(|cut| flown(cut[0], cut[1])).collect();
            let whole = flown(0, end);
            let mut forward = BlockSummary::default();
            for part in &parts {
                let (head, nodes, tail) = part.parts();
                let again = BlockSummary::from_parts(part.first(), head, nodes, tail).unwrap();
                prop_assert_eq!(&again, part);
                forward.append(&again).unwrap();
            }
            prop_assert_eq!(&forward, &whole);
            let mut backward = BlockSummary::from_trial(end);
            for part in parts.iter().rev() {
                let mut part = part.clone();
                part.append(&backward).unwrap();
                backward = part;
            }
            prop_assert_eq!(&backward, &whole);
            prop_assert_eq!(backward.summary(), whole.summary());
        }
    }
}
