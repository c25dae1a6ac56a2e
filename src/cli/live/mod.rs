//! `--view`: a flight in the browser while it flies.
//!
//! | file | holds |
//! |---|---|
//! | `watch` | what the page is told: of what happens, of frames, of the log of a simulated flight |
//! | this one | what can be typed, and the server, in a thread of its own: a flight waits for nobody |

mod watch;

use std::cell::RefCell;
use std::sync::mpsc::channel;
use std::thread::JoinHandle;

use anyhow::Context as _;
use clap::Args;
use serde_json::json;

use super::answer::{BadInput as _, Failure};
use super::narrator::Weight;
use super::terminal::print_err;
use super::view::open;
use samara::config::Mission;
use samara::link::shell::Notice;
use samara::link::{Froude, TimeUs};
use samara::report::ShownDrop;
use samara::report::replay::live;
use samara::sim::Sample;
use samara::trajectory::Trajectory;
use samara::view::live::{Feed, feed};
use samara::view::server::{Server, Shown};
pub use watch::Known;
use watch::Watch;

/// Whether a flight is looked at while it flies.
#[derive(Args, Clone, Debug, Default)]
pub struct LiveArgs {
    /// Show the flight in the browser while it flies: docs/view.md.
    ///
    /// On 127.0.0.1, on this port or a free one. The address is printed on stderr, for whoever looks on from
    /// elsewhere. The flight waits for no browser, and its files are the same.
    #[arg(long, value_name = "PORT", num_args = 0..=1, require_equals = true)]
    view: Option<Option<u16>>,
    /// With --view: print the address, and open no browser.
    #[arg(long, requires = "view", hide_short_help = true)]
    no_open: bool,
}

impl LiveArgs {
    /// Whether it is.
    pub fn asked(&self) -> bool {
        self.view.is_some()
    }
}

/// A flight that is looked at while it flies, if somebody wants to.
pub struct Live {
    watch: RefCell<Option<Watch>>,
    server: Option<JoinHandle<()>>,
}

impl Live {
    /// Opens the page of a mission's flight, if it is asked for: of the vehicle of a system, by a plan, where
    /// there is one, with the scale of its wire.
    pub fn open(
        args: &LiveArgs,
        (mission, plan): (&Mission, Option<&Trajectory>),
        known: Known,
        (system_id, froude): (u8, Option<Froude>),
    ) -> Result<Self, Failure> {
        let Some(port) = args.view else { return Ok(Self { watch: RefCell::default(), server: None }) };
        let (source, feed) = feed();
        let (address, server) = serve(feed, port.unwrap_or(0))?;
        print_err(&format!("samara: the flight is shown at {address}\n"));
        if !args.no_open {
            open(&address);
        }
        let watch = Watch::new(source, (mission, plan), known, (system_id, froude));
        Ok(Self { watch: RefCell::new(Some(watch)), server: Some(server) })
    }

    fn with(&self, tell: impl FnOnce(&mut Watch)) {
        if let Some(watch) = self.watch.borrow_mut().as_mut() {
            tell(watch);
        }
    }

    /// Something happened that has this weight.
    pub fn notice(&self, notice: &Notice, weight: Weight) {
        self.with(|watch| watch.notice(notice, weight));
    }

    /// A frame has come or gone at a simulated time.
    pub fn frame(&self, now: TimeUs, bytes: &[u8]) {
        self.with(|watch| watch.frame(now, bytes));
    }

    /// The log of the flight is this by now.
    pub fn flown(&self, log: &[Sample]) {
        self.with(|watch| watch.flown(log));
    }

    /// The flight is over and judged.
    pub fn judged(&self, drop: &ShownDrop<'_>, is_safe: bool) {
        if let Some(watch) = self.watch.take() {
            // Structs of strings, numbers and lists of them always serialise.
            watch.end(serde_json::to_value(live::end(drop, is_safe)).unwrap_or_default());
        }
    }

    /// The flight is over, in words.
    pub fn over(&self, text: &str) {
        if let Some(watch) = self.watch.take() {
            watch.end(json!({ "text": text }));
        }
    }
}

/// Those who look on are given the end.
impl Drop for Live {
    fn drop(&mut self) {
        self.watch.take();
        if let Some(server) = self.server.take() {
            // A server that has ended badly has nobody left to tell.
            let _ = server.join();
        }
    }
}

/// Serves a flight to its end, in a thread of its own; the address.
fn serve(feed: Feed, port: u16) -> Result<(String, JoinHandle<()>), Failure> {
    let (ready, opened) = channel();
    let serve = move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let listening = runtime.and_then(|runtime| {
            let server = runtime.block_on(async { Server::listen(Shown::Flight(feed), port) })?;
            Ok((runtime, server))
        });
        match listening {
            Ok((runtime, server)) => {
                let _ = ready.send(Ok(server.address()));
                runtime.block_on(server.serve_to_the_end());
            }
            Err(error) => _ = ready.send(Err(error)),
        }
    };
    let server = std::thread::Builder::new().name("view".to_owned()).spawn(serve);
    let server = server.context("a thread that serves the page")?;
    let address = opened.recv().context("a thread that serves the page")?;
    Ok((address.with_context(|| format!("--view={port}")).bad_input()?, server))
}
