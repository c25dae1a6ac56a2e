//! Threads for many flights.

use std::num::NonZero;
use std::thread::available_parallelism;

use crate::fault::Fault;

/// Threads of the call's own, so that calls from several threads of Python do not wait for each other.
pub fn pool(threads: Option<usize>) -> Result<rayon::ThreadPool, Fault> {
    let threads = threads.unwrap_or_else(|| available_parallelism().map_or(1, NonZero::get));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| Fault::Internal(format!("starting threads: {error}")))
}
