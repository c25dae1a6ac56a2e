//! Work in a thread of its own, beside the interpreter: other threads of Python run on, and Ctrl-C ends it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::prelude::*;

use crate::fault::Fault;

/// Time between two looks at Python's signals.
const LOOK: Duration = Duration::from_millis(25);
/// Stack of the thread, which a main thread has, too.
const STACK_BYTES: usize = 8 << 20;

/// Raised when nobody waits for the work any more.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Whether to break off.
    pub fn raised(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Does the work and waits for it. On Ctrl-C the exception is raised at once; the work ends behind it, at its
/// next look at [`Stop`].
pub fn work<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    work_watched(py, |_| Ok(()), work)
}

/// As [`work`], with something else to do at each look at the signals; where that raises, the work ends.
pub fn work_watched<T: Send + 'static>(
    py: Python<'_>,
    mut watch: impl FnMut(Python<'_>) -> PyResult<()>,
    work: impl FnOnce(&Stop) -> Result<T, Fault> + Send + 'static,
) -> PyResult<T> {
    let (stop, (done, comes)) = (Stop::default(), channel());
    let seen = stop.clone();
    std::thread::Builder::new().name("samara".to_owned()).stack_size(STACK_BYTES).spawn(move || {
        // Nobody listens any more after Ctrl-C.
        let _ = done.send(work(&seen));
    })?;
    let mut listening = comes;
    let result = loop {
        // The listening end goes into the closure and comes back: threads cannot share it.
        let (heard, again) = py.detach(move || (listening.recv_timeout(LOOK), listening));
        listening = again;
        match heard {
            Ok(result) => break result,
            Err(RecvTimeoutError::Timeout) => {
                let looked = py.check_signals().and_then(|()| watch(py));
                looked.inspect_err(|_| stop.0.store(true, Ordering::Relaxed))?;
            }
            Err(RecvTimeoutError::Disconnected) => {
                let text = "samara has a fault: a computation broke off; stderr says where";
                break Err(Fault::Internal(text.to_owned()));
            }
        }
    };
    result.map_err(|fault| fault.raised(py))
}
