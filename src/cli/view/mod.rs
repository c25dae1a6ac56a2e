//! `samara view`: a mission in the browser, changed and flown anew at once; or a run's folder.

mod folder;

use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::Arc;

use anyhow::Context as _;
use clap::Args;

use folder::Folder;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::{DEFAULT_MISSION, SetArgs};
use super::mission::{has_a_drop, open_mission, origin};
use super::system::block_on;
use super::terminal::print;
use samara::config::mission_path;
use samara::view::server::{Server, Shown};
use samara::view::viewed::Viewed;

/// `samara view`.
#[derive(Args, Debug)]
pub struct ViewArgs {
    /// A run's folder, or the mission: a file, or a name - of a file in ./mission, or of a mission that
    /// samara brings along.
    #[arg(value_name = "NAME|FILE|RUN", default_value = DEFAULT_MISSION)]
    subject: PathBuf,
    /// The mission of a run's folder, where it is not found by its name.
    #[arg(long, value_name = "FILE", conflicts_with = "set")]
    mission: Option<PathBuf>,
    /// The port of 127.0.0.1 to listen on; 0: any free one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
    /// Print the address, and open no browser.
    #[arg(long)]
    no_open: bool,
    #[command(flatten)]
    set: SetArgs,
}

/// Serves the page until Ctrl-C.
pub fn run(args: ViewArgs) -> Result<Answer, Failure> {
    let shown = shown(&args)?;
    block_on(|stop| async move {
        let server = Server::listen(shown, args.port).with_context(|| format!("--port {}", args.port));
        let server = server.bad_input()?;
        print(&format!("{}\nCtrl-C ends it.\n", server.address()))?;
        if !args.no_open {
            open(&server.address());
        }
        tokio::select! {
            never = server.serve() => match never {},
            () = stop => Ok(Answer::Yes),
        }
    })?
}

/// What was asked for: a run's folder, or a mission.
fn shown(args: &ViewArgs) -> Result<Shown, Failure> {
    if args.subject.is_dir() {
        if !args.set.set.is_empty() {
            let text = "--set: a run is looked at as it was flown; a mission is expected with it";
            return Err(Failure::input(text.to_owned()));
        }
        return Ok(Shown::Run(Arc::new(Folder::read(&args.subject, args.mission.clone())?)));
    }
    if args.mission.is_some() {
        return Err(Failure::input("--mission: a run's folder is expected with it".to_owned()));
    }
    let mission = open_mission(&args.subject, &args.set)?;
    has_a_drop(&mission)?;
    print(&origin(&args.subject, &mission))?;
    let typed = args.subject.display().to_string();
    let path = mission_path(&args.subject).bad_input()?;
    Ok(Shown::Mission(Viewed { path, typed, set: args.set.set.clone() }))
}

/// Opens an address in the browser, where there is a display; the address was printed.
pub fn open(address: &str) {
    let shows = |display: &str| std::env::var_os(display).is_some_and(|value| !value.is_empty());
    let opener = match std::env::consts::OS {
        "macos" => "open",
        _ if shows("DISPLAY") || shows("WAYLAND_DISPLAY") => "xdg-open",
        _ => return,
    };
    let mut command = Command::new(opener);
    let quiet = command.arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    // Without such a program the address is there to be opened by hand.
    let _ = quiet.spawn();
}
