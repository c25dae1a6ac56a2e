//! What a PX4 leaves on a machine: processes, a lock, ports.

use std::collections::BTreeSet;
use std::fs;
use std::net::{TcpListener, UdpSocket};
use std::path::{Path, PathBuf};

use rustix::fs::{FlockOperation, flock};
use rustix::process::{Pid, test_kill_process_group};

use super::harness::wait_for;

/// Processes that work in a folder: their numbers, groups and command lines.
pub fn working_in(folder: &Path) -> Vec<(Pid, Pid, String)> {
    let Ok(folder) = fs::canonicalize(folder) else { return Vec::new() };
    let processes = fs::read_dir("/proc").unwrap().filter_map(Result::ok).map(|entry| entry.path());
    processes
        .filter(|path| fs::read_link(path.join("cwd")).is_ok_and(|cwd| cwd.starts_with(&folder)))
        .filter_map(|path| {
            let id = Pid::from_raw(path.file_name()?.to_str()?.parse().ok()?)?;
            let stat = fs::read_to_string(path.join("stat")).ok()?;
            // pid (name) state parent group ..
            let group = stat.rsplit_once(')')?.1.split_whitespace().nth(2)?.parse().ok()?;
            let line = String::from_utf8_lossy(&fs::read(path.join("cmdline")).ok()?).replace('\0', " ");
            Some((id, Pid::from_raw(group)?, line))
        })
        .collect()
}

/// PX4's main process of those in a folder.
pub fn main_process(work: &Path) -> Option<Pid> {
    let is_main = |line: &str| line.split(' ').next().is_some_and(|program| program.ends_with("/px4"));
    working_in(work).into_iter().find(|(_, _, line)| is_main(line)).map(|(id, ..)| id)
}

/// The groups of those in a folder.
pub fn groups(work: &Path) -> BTreeSet<i32> {
    working_in(work).into_iter().map(|(_, group, _)| group.as_raw_nonzero().get()).collect()
}

/// Waits until nothing of these groups is there, the instance's lock can be had, and all its ports can be bound.
pub fn nothing_is_left(instance: u16, work: &Path, groups: &BTreeSet<i32>) {
    let gone = |group: &i32| test_kill_process_group(Pid::from_raw(*group).unwrap()).is_err();
    let is_clean = || {
        working_in(work).is_empty()
            && groups.iter().all(gone)
            && lock_is_free(instance)
            && ports_are_free(instance)
    };
    wait_for(is_clean, || {
        format!(
            "nothing left; processes {:?}, groups {groups:?} gone {}, lock free {}, ports free {}",
            working_in(work),
            groups.iter().all(gone),
            lock_is_free(instance),
            ports_are_free(instance)
        )
    });
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
