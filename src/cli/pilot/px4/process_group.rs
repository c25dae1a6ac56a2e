//! A process group that ends with this program.
//!
//! PX4 has children that outlive it, and this program may be killed without a word. So PX4's group is led by
//! a keeper: a shell that reads from a pipe which only this program holds. When the program is gone, however
//! that came, the pipe ends and the keeper kills the group, itself with it.

use std::os::unix::process::CommandExt as _;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use anyhow::{Context as _, Result};
use rustix::process::{Pid, Signal, kill_process_group, test_kill_process_group};

use crate::cli::system::{Stopwatch, pause};

/// The keeper does not heed the SIGTERM that asks the group to end, so that it is there until the end.
const SCRIPT: &str = "trap '' TERM INT HUP; read -r _; kill -KILL 0";
/// How long a killed group may take to be gone.
const PATIENCE: Duration = Duration::from_secs(3);
/// How often that is looked for.
const LOOK: Duration = Duration::from_millis(2);

/// A group of processes, led by its keeper.
#[derive(Debug)]
pub struct ProcessGroup {
    /// The keeper.
    shell: Child,
    id: Pid,
    ended: bool,
}

impl ProcessGroup {
    /// Makes a group with its keeper in it.
    pub fn start() -> Result<Self> {
        let shell = Command::new("/bin/sh")
            .args(["-c", SCRIPT])
            .current_dir("/")
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0)
            .spawn()
            .context("cannot start /bin/sh")?;
        let id = Pid::from_child(&shell);
        Ok(Self { shell, id, ended: false })
    }

    /// Has a program start in the group.
    pub fn adopt(&self, command: &mut Command) {
        command.process_group(self.id.as_raw_nonzero().get());
    }

    /// Asks all of the group to end; some may not.
    pub fn ask(&self) {
        // A group that is gone is what is wanted.
        _ = (!self.ended).then(|| kill_process_group(self.id, Signal::TERM));
    }

    /// Kills what is left of the group. The caller then waits for its own child in it, and calls
    /// [`ProcessGroup::wait`].
    pub fn kill(&self) {
        _ = (!self.ended).then(|| kill_process_group(self.id, Signal::KILL));
    }

    /// Returns once nothing of a killed group is left.
    pub fn wait(&mut self) {
        if self.ended {
            return;
        }
        // The number stays the group's while one of it is there; afterwards it may be another's.
        _ = self.shell.wait();
        self.ended = true;
        let since = Stopwatch::start();
        while !is_gone(self.id) && since.ms() < 1e3 * PATIENCE.as_secs_f64() {
            pause(LOOK);
        }
    }
}

/// Whether nothing of a group runs. The dead that nobody has collected yet do not count: orphans are the
/// system's first process's to collect, which takes its time, in a container for ever.
fn is_gone(group: Pid) -> bool {
    test_kill_process_group(group).is_err() || is_dead(group)
}

#[cfg(target_os = "linux")]
fn is_dead(group: Pid) -> bool {
    let processes = std::fs::read_dir("/proc").into_iter().flatten().filter_map(Result::ok);
    #[expect(clippy::disallowed_methods, reason = "what the system shows of a process")]
    let mut stats = processes.filter_map(|process| std::fs::read_to_string(process.path().join("stat")).ok());
    let runs = |stat: &String| {
        // Number, (name), state, parent, group.
        let mut words = stat.rsplit_once(") ")?.1.split(' ');
        let (state, of) = (words.next()?, words.nth(1)?.parse::<i32>().ok()?);
        Some(of == group.as_raw_nonzero().get() && !matches!(state, "Z" | "X"))
    };
    !stats.any(|stat| runs(&stat).unwrap_or(false))
}

#[cfg(not(target_os = "linux"))]
fn is_dead(_: Pid) -> bool {
    false
}

impl Drop for ProcessGroup {
    fn drop(&mut self) {
        self.kill();
        self.wait();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A child of the group that has a child of its own, as PX4 has.
    fn family(group: &ProcessGroup) -> Child {
        let mut command = Command::new("/bin/sh");
        command.args(["-c", "sleep 1000 & trap '' TERM; wait; sleep 1000"]);
        group.adopt(&mut command);
        command.spawn().unwrap()
    }

    #[test]
    fn a_killed_group_is_gone_with_the_children_of_its_children() {
        let mut group = ProcessGroup::start().unwrap();
        let mut child = family(&group);
        assert!(!is_gone(group.id));
        group.ask();
        group.kill();
        child.wait().unwrap();
        group.wait();
        assert!(is_gone(group.id));
    }

    /// Our end is the pipe's end; here only the pipe's.
    #[test]
    fn the_group_ends_when_nobody_holds_the_pipe() {
        let mut group = ProcessGroup::start().unwrap();
        let mut child = family(&group);
        drop(group.shell.stdin.take());
        child.wait().unwrap();
        group.wait();
        assert!(is_gone(group.id));
    }
}
