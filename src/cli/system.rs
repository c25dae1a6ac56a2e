//! What the program takes from the system: the wall clock (to show durations and to wait for processes),
//! threads, Ctrl-C, and the runtime of sockets.
#![expect(clippy::disallowed_types, clippy::disallowed_methods, reason = "the command line's clock")]

use std::future::Future;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use anyhow::Context as _;

use super::answer::{BadInput as _, Failure};
use samara::host::Threads;

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

/// A time of the wall clock to the minute: `2026-11-28 09:05 UTC`.
pub fn utc(time: SystemTime) -> String {
    let since = time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let minutes = since.as_secs() / 60;
    let (year, month, day) = civil(minutes / 1440);
    format!("{year}-{month:02}-{day:02} {:02}:{:02} UTC", minutes / 60 % 24, minutes % 60)
}

/// Year, month and day of so many days since 1970-01-01, by `civil_from_days` of
/// <https://howardhinnant.github.io/date_algorithms.html> for days that are not negative.
fn civil(days: u64) -> (u64, u64, u64) {
    let since_march_of_0 = days + 719_468;
    let (era, day_of_era) = (since_march_of_0 / 146_097, since_march_of_0 % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (400 * era + year_of_era + u64::from(month <= 2), month, day)
}

/// Waits, for a process to end.
pub fn pause(length: Duration) {
    std::thread::sleep(length);
}

/// So many threads; `None`: one for each core.
pub fn threads(count: Option<u16>) -> anyhow::Result<Threads> {
    Threads::new(count.map(usize::from)).context("starting threads")
}

/// Whether this process has been asked to end.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Whether Ctrl-C or a termination signal has come, and was heard by who was at work.
pub fn was_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Completes on Ctrl-C, on a termination signal or when the terminal is closed. From the call on, not only
/// once it is awaited, these do not kill the program any more.
#[cfg(unix)]
fn interrupted() -> std::io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let (mut interrupt, mut terminate) = (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?);
    let mut hangup = if hangup_ends() { Some(signal(SignalKind::hangup())?) } else { None };
    let hung_up = async move {
        match &mut hangup {
            Some(hangup) => _ = hangup.recv().await,
            None => std::future::pending().await,
        }
    };
    Ok(async move {
        tokio::select! {
            _ = interrupt.recv() => {}
            _ = terminate.recv() => {}
            () = hung_up => {}
        }
    })
}

/// Whether SIGHUP would end the program: not under nohup, which has it ignored, and not where that cannot be
/// known.
#[cfg(unix)]
fn hangup_ends() -> bool {
    const SIGHUP_BIT: u64 = 1;
    let ignored = std::fs::read_to_string("/proc/self/status").ok().and_then(|status| {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?;
        u64::from_str_radix(mask.trim(), 16).ok()
    });
    ignored.is_some_and(|mask| mask & SIGHUP_BIT == 0)
}

/// From now on a file that grows beyond its limit (ulimit -f) is an error of who writes it, which names the
/// file, and no signal that kills the program; where signals cannot be heard, they stay as they are.
#[cfg(unix)]
pub fn let_limits_be_errors() {
    use tokio::signal::unix::{SignalKind, signal};
    let runtime = || tokio::runtime::Builder::new_current_thread().enable_io().build().ok();
    if let Some(runtime) = check_descriptors().ok().and_then(|()| runtime()) {
        let _inside = runtime.enter();
        // The handler stays when nobody listens any more.
        drop(signal(SignalKind::from_raw(rustix::process::Signal::XFSZ.as_raw())));
    }
}

/// The runtime for sockets and signals needs some file descriptors, and does not end well without.
#[cfg(unix)]
fn check_descriptors() -> Result<(), Failure> {
    const PAIRS: usize = 4;
    let pairs: std::io::Result<Vec<_>> = (0..PAIRS).map(|_| std::os::unix::net::UnixStream::pair()).collect();
    pairs.map(|_| ()).context("too few files may be open (ulimit -n)").bad_input()
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
    #[cfg(unix)]
    check_descriptors()?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .context("the runtime for sockets")?;
    runtime.block_on(async {
        let stop = interrupted().context("the signal of Ctrl-C")?;
        let stop = async {
            stop.await;
            INTERRUPTED.store(true, Ordering::Relaxed);
        };
        Ok(run(Box::pin(stop)).await)
    })
}

/// Raises a flag when the process that started this one has ended: `parent`, where its number is known, so
/// that one that ended before this looked is noticed. The system's own signal for that would come when the
/// thread that started this one ends.
#[cfg(unix)]
pub fn raise_without_parent(flag: &Arc<AtomicBool>, parent: Option<u32>) -> Result<(), Failure> {
    const LOOK_EVERY: Duration = Duration::from_millis(100);
    let raised = flag.clone();
    let parent = parent.unwrap_or_else(std::os::unix::process::parent_id);
    let watch = move || {
        while std::os::unix::process::parent_id() == parent {
            pause(LOOK_EVERY);
        }
        raised.store(true, Ordering::Relaxed);
    };
    let started = std::thread::Builder::new().name("parent".to_owned()).spawn(watch);
    started.map(|_| ()).context("a thread that watches the parent").map_err(Failure::from)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand and by `date -u -d @N`: an epoch, a leap day, the end of a year, a century that has none.
    #[test]
    fn closed_form_times_of_the_wall_clock() {
        let of = |seconds: u64| utc(SystemTime::UNIX_EPOCH + Duration::from_secs(seconds));
        assert_eq!(of(0), "1970-01-01 00:00 UTC");
        assert_eq!(of(951_782_400 + 3661), "2000-02-29 01:01 UTC");
        assert_eq!(of(1_798_761_599), "2026-12-31 23:59 UTC");
        assert_eq!(of(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}
