//! Ctrl-C for long computations without sockets: a flag that they look at between pieces of work.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

use super::net::block_on;
use super::outcome::Failure;

/// A flag that Ctrl-C (or a termination signal) raises. From the return on these do not kill the program any more, until the
/// second one does.
///
/// # Errors
/// [`Failure::Internal`] when the system gives no thread to listen on.
pub fn flag() -> Result<Arc<AtomicBool>, Failure> {
    let raised = Arc::new(AtomicBool::new(false));
    let (listening, heard) = (std::sync::mpsc::channel(), raised.clone());
    let ready = listening.0;
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
            heard.store(true, Ordering::Relaxed);
            // The handler stays in place: a second signal would be swallowed for ever.
            let _ = block_on(|stop| stop);
            std::process::exit(1);
        })
        .context("a thread that listens for Ctrl-C")?;
    // An error means that the thread has ended without a handler.
    let _ = listening.1.recv();
    Ok(raised)
}
