//! Threads for many flights. Results are in order, so that they do not depend on how many threads there are.

use std::io;

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// A pool of threads.
#[derive(Debug)]
pub struct Threads(ThreadPool);

impl Threads {
    /// So many threads; `None`: one for each core.
    ///
    /// # Errors
    /// Of the system, where it starts none.
    pub fn new(count: Option<usize>) -> io::Result<Self> {
        let pool = ThreadPoolBuilder::new().num_threads(count.unwrap_or(0)).build();
        pool.map(Self).map_err(io::Error::other)
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Does something for each item by itself; what comes of them, in their order.
    pub fn each<T: Sync, R: Send>(&self, items: &[T], each: impl Fn(&T) -> R + Sync) -> Vec<R> {
        self.0.install(|| items.par_iter().with_max_len(1).map(&each).collect())
    }

    /// The number of the thread that asks, among those of the pool that it is of; 0 outside of any.
    pub fn place() -> usize {
        rayon::current_thread_index().unwrap_or(0)
    }

    /// Lets each thread do the same thing.
    pub(crate) fn all(&self, each: impl Fn() + Sync) {
        self.0.broadcast(|_| each());
    }
}
