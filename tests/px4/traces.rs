//! What a PX4 leaves on a machine: processes, a lock, ports.

use std::collections::BTreeSet;
use std::fs;
use std::net::{TcpListener, UdpSocket};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use rustix::process::Pid;

use super::harness::wait_for;

/// A process: its number, group, state and command line.
struct Process {
    id: Pid,
    group: i32,
    dead: bool,
    line: String,
    cwd: Option<PathBuf>,
}

fn processes() -> Vec<Process> {
    let paths = fs::read_dir("/proc").unwrap().filter_map(Result::ok).map(|entry| entry.path());
    paths
        .filter_map(|path| {
            let stat = fs::read_to_string(path.join("stat")).ok()?;
            // Number, (name), state, parent, group.
            let mut words = stat.rsplit_once(") ")?.1.split(' ');
            let line = String::from_utf8_lossy(&fs::read(path.join("cmdline")).ok()?).replace('\0', " ");
            Some(Process {
                id: Pid::from_raw(path.file_name()?.to_str()?.parse().ok()?)?,
                // What is dead and not collected is the system's affair.
                dead: words.next()? == "Z",
                group: words.nth(1)?.parse().ok()?,
                line,
                cwd: fs::read_link(path.join("cwd")).ok(),
            })
        })
        .filter(|process| !process.dead)
        .collect()
}

fn working_in(folder: &Path) -> Vec<Process> {
    let Ok(folder) = fs::canonicalize(folder) else { return Vec::new() };
    let works = |p: &Process| p.cwd.as_ref().is_some_and(|cwd| cwd.starts_with(&folder));
    processes().into_iter().filter(works).collect()
}

/// PX4's main process of those that work in a folder.
pub fn main_process(work: &Path) -> Option<Pid> {
    let is_main = |line: &str| line.split(' ').next().is_some_and(|program| program.ends_with("/px4"));
    working_in(work).into_iter().find(|process| is_main(&process.line)).map(|process| process.id)
}

/// The groups of those that work in a folder.
pub fn groups(work: &Path) -> BTreeSet<i32> {
    working_in(work).into_iter().map(|process| process.group).collect()
}

/// Waits until nothing of these groups runs, the instance's lock can be had, and all its ports can be bound.
pub fn nothing_is_left(instance: u16, work: &Path, groups: &BTreeSet<i32>) {
    let left = || -> Vec<String> {
        let of_them = |p: &Process| groups.contains(&p.group);
        let mut left: Vec<String> = processes().into_iter().filter(of_them).map(|p| p.line).collect();
        left.extend(working_in(work).into_iter().map(|p| p.line));
        left.extend((!lock_is_free(instance)).then(|| "PX4's lock".to_owned()));
        left.extend((!ports_are_free(instance)).then(|| "a port".to_owned()));
        left
    };
    wait_for(|| left().is_empty(), || format!("nothing left; there is still {:?}", left()));
}

/// Waits until nobody works in a folder and the instance's lock can be had.
pub fn nobody_works_in(work: &Path, instance: u16) {
    let is_so = || working_in(work).is_empty() && lock_is_free(instance);
    wait_for(is_so, || format!("nobody in {}", work.display()));
}

fn lock_is_free(instance: u16) -> bool {
    let lock = PathBuf::from(format!("/tmp/px4_lock-{instance}"));
    fs::File::open(lock).map_or(true, |file| flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok())
}

/// The simulator's, PX4's two, the streamer's and the parachute's.
fn ports_are_free(instance: u16) -> bool {
    let udp =
        [18570, 14580, 14540, 14600].map(|port| UdpSocket::bind(("127.0.0.1", port + instance)).is_ok());
    udp == [true; 4] && TcpListener::bind(("127.0.0.1", 4560 + instance)).is_ok()
}

/// Memory of a process that is in use [kB].
pub fn resident_kb(id: Pid) -> u64 {
    let status = fs::read_to_string(format!("/proc/{}/status", id.as_raw_nonzero())).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}
