//! PX4's own lock: one instance of a number on a machine.
//!
//! PX4 locks `/tmp/px4_lock-N` and hands the open file down to its start-up script and what that starts. A
//! PX4 that is killed alone leaves them behind: the next one of that number then ends at once ("PX4 daemon
//! already running for instance N").

use std::fs::{self, File};
use std::io;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use rustix::fs::{FlockOperation, flock};
use rustix::io::Errno;

/// The path of PX4's lock, but for the instance.
const LOCK: &str = "/tmp/px4_lock-";
/// Characters of a command line that are shown at most.
const COMMAND_AT_MOST: usize = 100;

/// Refuses an instance that is running already, with those who hold its lock.
pub fn look(instance: u16) -> Result<()> {
    look_at(instance, Path::new(&format!("{LOCK}{instance}")))
}

fn look_at(instance: u16, lock: &Path) -> Result<()> {
    let context = || format!("PX4's lock {}", lock.display());
    #[expect(clippy::disallowed_methods, reason = "PX4's lock")]
    let file = match File::open(lock) {
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(()),
        other => other.with_context(context)?,
    };
    // Held for a moment, until the file is closed.
    match flock(&file, FlockOperation::NonBlockingLockExclusive) {
        Err(Errno::WOULDBLOCK) => bail!(
            "PX4 instance {instance} is running already: {} is held by {}. (A killed PX4 leaves its start-up script behind, which holds \
             it on.) End that, or choose another --instance",
            lock.display(),
            words_of(&holders(lock), lock)
        ),
        other => other.with_context(context),
    }
}

/// Processes that have the file open, with their command lines; none where the system does not show them.
fn holders(lock: &Path) -> Vec<(u32, String)> {
    let ours = std::process::id();
    let processes = fs::read_dir("/proc").into_iter().flatten().filter_map(Result::ok);
    let mut found: Vec<(u32, String)> = processes
        .filter_map(|process| Some((process.file_name().to_str()?.parse().ok()?, process.path())))
        .filter(|(id, path)| *id != ours && has_open(path, lock))
        .map(|(id, path)| (id, command_line(&path)))
        .collect();
    found.sort();
    found
}

fn has_open(process: &Path, file: &Path) -> bool {
    let open = fs::read_dir(process.join("fd")).into_iter().flatten().filter_map(Result::ok);
    open.filter_map(|fd| fs::read_link(fd.path()).ok()).any(|target| target == file)
}

fn command_line(process: &Path) -> String {
    #[expect(clippy::disallowed_methods, reason = "what the system shows of a process")]
    let bytes = fs::read(process.join("cmdline")).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes).replace('\0', " ");
    text.trim().chars().take(COMMAND_AT_MOST).collect()
}

fn words_of(holders: &[(u32, String)], lock: &Path) -> String {
    if holders.is_empty() {
        return format!("somebody (`lsof {}` may tell)", lock.display());
    }
    let words: Vec<String> = holders.iter().map(|(id, line)| format!("process {id} ({line})")).collect();
    words.join(", ")
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that makes files and processes")]
mod tests {
    use std::process::{Command, Stdio};

    use super::*;

    /// Free, or soon: what another test starts has our open files for a moment, between fork and exec.
    fn becomes_free(lock: &Path) -> bool {
        let tries = std::iter::repeat_with(|| look_at(3, lock).is_ok());
        tries.take(500).any(|free| {
            if !free {
                std::thread::sleep(std::time::Duration::from_millis(10));
            }
            free
        })
    }

    #[test]
    fn a_lock_is_free_when_it_is_not_there_not_held_or_let_go() {
        let place = tempfile::tempdir().unwrap();
        let lock = place.path().join("lock");
        look_at(3, &lock).unwrap();
        let file = File::create(&lock).unwrap();
        assert!(becomes_free(&lock));
        flock(&file, FlockOperation::LockExclusive).unwrap();
        assert!(look_at(3, &lock).is_err());
        drop(file);
        assert!(becomes_free(&lock));
    }

    /// As PX4's start-up script does: the lock is handed down, and outlives the one who took it.
    #[test]
    #[cfg(target_os = "linux")]
    fn what_a_killed_one_left_is_named() {
        let place = tempfile::tempdir().unwrap();
        let lock = place.path().join("lock");
        let file = File::create(&lock).unwrap();
        flock(&file, FlockOperation::LockExclusive).unwrap();
        let mut heir = Command::new("sleep").arg("1000").stdin(Stdio::from(file)).spawn().unwrap();
        // Between exec and its first instruction a process shows no command line yet.
        let shows = || !command_line(Path::new(&format!("/proc/{}", heir.id()))).is_empty();
        assert!((0..500).any(|_| {
            std::thread::sleep(std::time::Duration::from_millis(10));
            shows()
        }));
        let error = look_at(3, &lock).unwrap_err().to_string();
        heir.kill().unwrap();
        heir.wait().unwrap();
        assert!(error.starts_with("PX4 instance 3 is running already"), "{error}");
        assert!(error.contains(&format!("process {} (sleep 1000)", heir.id())), "{error}");
        assert!(error.contains("--instance"), "{error}");
        assert!(becomes_free(&lock));
    }
}
