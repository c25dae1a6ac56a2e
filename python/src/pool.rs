//! Threads for many flights.

use std::num::NonZero;
use std::thread::available_parallelism;

use samara::host::kept::KeptRows;
use samara::host::{Host, Silent};
use samara::study::jobs::Stopped;

use crate::fault::Fault;
use crate::work::Stop;

/// Threads of the call's own, so that calls from several threads of Python do not wait for each other.
pub fn pool(threads: Option<usize>) -> Result<rayon::ThreadPool, Fault> {
    let threads = threads.unwrap_or_else(|| available_parallelism().map_or(1, NonZero::get));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|error| Fault::Internal(format!("starting threads: {error}")))
}

/// Runs a study on threads of the call's own, until nobody waits for it any more.
pub fn hosted<T>(
    threads: Option<usize>,
    stop: &Stop,
    study: impl FnOnce(&mut Host<'_>) -> Result<T, Stopped>,
) -> Result<T, Fault> {
    let (pool, is_stopped) = (pool(threads)?, || stop.raised());
    study(&mut Host::new(&pool, &is_stopped, &Silent, KeptRows::nowhere()))
        .map_err(|Stopped| Fault::stopped())
}
