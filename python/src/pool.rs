//! Threads for many flights.

use samara::host::Threads;

use crate::fault::Fault;

/// Threads of the call's own, so that calls from several threads of Python do not wait for each other.
pub fn pool(threads: Option<usize>) -> Result<Threads, Fault> {
    Threads::new(threads).map_err(|error| Fault::Internal(format!("starting threads: {error}")))
}
