//! `samara view`: a mission in the browser, changed and flown anew at once.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::Context as _;
use clap::Args;

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
    /// The mission: a file, or a name - of a file in ./mission, or of a mission that samara brings along.
    #[arg(value_name = "NAME|FILE", default_value = DEFAULT_MISSION)]
    mission: PathBuf,
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
    let mission = open_mission(&args.mission, &args.set)?;
    has_a_drop(&mission)?;
    print(&origin(&args.mission, &mission))?;
    let typed = args.mission.display().to_string();
    let viewed = Viewed { path: mission_path(&args.mission).bad_input()?, typed, set: args.set.set };
    block_on(|stop| async move {
        let server = Server::listen(Shown::Mission(viewed), args.port)
            .with_context(|| format!("--port {}", args.port));
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
