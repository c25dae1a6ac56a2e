//! Whether PX4 has come to rest: none of its threads runs or wants to.
//!
//! In lockstep PX4's threads sleep by simulated time, so one that is awake still has to do something about
//! the step that was made. How much of its start PX4 has done when the next step comes would otherwise be a
//! matter of the machine, and with it the step at which it answers first, on which the phases of its
//! slower loops depend for the rest of the flight.

#[cfg(target_os = "linux")]
use std::fs;

/// Whether no thread of process `pid`, nor of those that it has started, runs or wants to, as two looks in a
/// row have it. Where the system does not say: yes.
#[cfg(target_os = "linux")]
pub fn is_idle(pid: u32) -> bool {
    let look = || sleeps(pid, 0);
    look() && look()
}

/// Generations of processes that are looked at: PX4, its start script, a command of that.
#[cfg(target_os = "linux")]
const GENERATIONS: u32 = 4;

#[cfg(target_os = "linux")]
#[expect(clippy::disallowed_methods, reason = "the system's own account of a process")]
fn sleeps(pid: u32, generation: u32) -> bool {
    let Ok(tasks) = fs::read_dir(format!("/proc/{pid}/task")) else { return true };
    for task in tasks.flatten() {
        // "pid (name) state ..", and the name may hold anything.
        let stat = fs::read_to_string(task.path().join("stat")).unwrap_or_default();
        if stat.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with(['R', 'D'])) {
            return false;
        }
    }
    let children = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
    let mut children = children.split_whitespace().filter_map(|child| child.parse().ok());
    generation >= GENERATIONS || children.all(|child| sleeps(child, generation + 1))
}

#[cfg(not(target_os = "linux"))]
pub fn is_idle(_: u32) -> bool {
    true
}
