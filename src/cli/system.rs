//! What the program takes from the system: the wall clock (to show durations and to wait for processes),
//! threads, Ctrl-C, and the runtime of sockets.
#![expect(clippy::disallowed_types, clippy::disallowed_methods, reason = "the command line's clock")]

use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Context as _;

use super::answer::Failure;

/// The wall time since a moment.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds since the start.
    pub fn ms(&self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }
}

/// Waits, for a process to end.
pub fn pause(length: Duration) {
    std::thread::sleep(length);
}

/// A pool of `threads` threads; `None`: one for each core. Results are collected in order, so they do not
/// depend on the number of threads.
pub fn thread_pool(threads: Option<u16>) -> anyhow::Result<rayon::ThreadPool> {
    let threads = threads.map_or(0, usize::from);
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().context("starting threads")
}

/// Completes on Ctrl-C (or a termination signal, where there is one). From the call on, not only once it is
/// awaited, these do not kill the program any more.
#[cfg(unix)]
fn interrupted() -> std::io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
        }
    })
}

/// Completes on Ctrl-C.
#[cfg(windows)]
fn interrupted() -> std::io::Result<impl Future<Output = ()>> {
    let mut interrupt = tokio::signal::windows::ctrl_c()?;
    Ok(async move { _ = interrupt.recv().await })
}

/// Runs something with sockets to its end on a runtime of one thread; `run` is given the future that
/// completes on Ctrl-C.
pub fn block_on<F: Future>(
    run: impl FnOnce(Pin<Box<dyn Future<Output = ()>>>) -> F,
) -> Result<F::Output, Failure> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("the runtime for sockets")?;
    runtime.block_on(async {
        let stop = interrupted().context("the signal of Ctrl-C")?;
        Ok(run(Box::pin(stop)).await)
    })
}

/// A flag that Ctrl-C (or a termination signal) raises, for long computations without sockets: they look at
/// it between pieces of work. From the return on these signals do not kill the program any more, until the
/// second one does.
pub fn interrupt_flag() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = flag.clone();
    let (ready, listening) = std::sync::mpsc::channel();
    std::thread::Builder::new()
        .name("interrupt".to_owned())
        .spawn(move || {
            let listened = block_on(|stop| async {
                let _ = ready.send(());
                stop.await;
            });
            if listened.is_err() {
                // Without a handler the signal ends the program, as it does by default.
                return;
            }
            raised.store(true, Ordering::Relaxed);
            // The handler stays in place: a second signal would be swallowed for ever.
            let _ = block_on(|stop| stop);
            std::process::exit(1);
        })
        .context("a thread that listens for Ctrl-C")?;
    // An error means that the thread has ended without a handler.
    let _ = listening.recv();
    Ok(flag)
}
