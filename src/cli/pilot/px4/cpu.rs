//! Where PX4 and its simulator run.
//!
//! PX4's threads hand over to each other many times in a step, and to wake a sleeping processor costs more
//! than they gain: all of PX4 runs fastest on one. The simulator runs best on another: what it need not do
//! before it answers, it does while PX4 is at work. Where each processor has a PX4 of its own there is no
//! other, and both share one.

#[cfg(target_os = "linux")]
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

#[cfg(target_os = "linux")]
use anyhow::Context as _;
use anyhow::{Result, bail};

/// The processors that PX4 and the simulator run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cpu {
    /// PX4 on one of those that this process may use, by the instance; the simulator on the others.
    Apart,
    /// Both on one of them, by the instance.
    Together,
    /// Both wherever the system puts them.
    Any,
    /// Both on this one.
    Number(usize),
}

/// Keeps this thread, and what it starts meanwhile, on one processor, as long as the value lives.
#[derive(Debug, Default)]
pub struct Pinned {
    #[cfg(target_os = "linux")]
    before: Option<CpuSet>,
    /// The processors that the thread leaves for when all has been started.
    #[cfg(target_os = "linux")]
    aside: Option<CpuSet>,
}

#[cfg(target_os = "linux")]
impl Pinned {
    /// Pins the calling thread for an instance.
    pub fn pin(cpu: Cpu, instance: u16) -> Result<Self> {
        if cpu == Cpu::Any {
            return Ok(Self::default());
        }
        let had = sched_getaffinity(None).context(BY_THE_SYSTEM)?;
        let allowed: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|n| had.is_set(*n)).collect();
        let chosen = match cpu {
            // From the last one on: the first has the system's interrupts.
            Cpu::Apart | Cpu::Together => allowed.iter().rev().cycle().nth(usize::from(instance)).copied(),
            Cpu::Number(n) => Some(n),
            Cpu::Any => None,
        };
        let Some(chosen) = chosen else { return Ok(Self::default()) };
        if !allowed.contains(&chosen) {
            bail!("--cpu {chosen}: {} expected", list(&allowed));
        }
        let mut one = CpuSet::new();
        one.set(chosen);
        sched_setaffinity(None, &one).context(BY_THE_SYSTEM)?;
        let mut others = had;
        others.unset(chosen);
        let aside = (cpu == Cpu::Apart && others.count() > 0).then_some(others);
        Ok(Self { before: Some(had), aside })
    }

    /// All has been started: with [`Cpu::Apart`] the thread leaves the processor to it.
    pub fn step_aside(&self) -> Result<()> {
        self.aside.map_or(Ok(()), |others| sched_setaffinity(None, &others)).context(BY_THE_SYSTEM)
    }
}

#[cfg(target_os = "linux")]
impl Drop for Pinned {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // What was allowed before is allowed again.
            _ = sched_setaffinity(None, before);
        }
    }
}

/// What cannot be done when the system refuses.
#[cfg(target_os = "linux")]
const BY_THE_SYSTEM: &str = "cannot choose a processor (--cpu any leaves it to the system)";

/// "0", "0 or 1", "0, 1 or 2".
#[cfg(target_os = "linux")]
fn list(numbers: &[usize]) -> String {
    let texts: Vec<String> = numbers.iter().map(usize::to_string).collect();
    match texts.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        _ => texts.concat(),
    }
}

#[cfg(not(target_os = "linux"))]
impl Pinned {
    /// Pins nothing: the system chooses.
    pub fn pin(cpu: Cpu, _: u16) -> Result<Self> {
        match cpu {
            Cpu::Apart | Cpu::Together | Cpu::Any => Ok(Self {}),
            Cpu::Number(wanted) => {
                bail!("--cpu {wanted}: auto or any (a number under Linux only) expected")
            }
        }
    }

    /// Does nothing.
    pub fn step_aside(&self) -> Result<()> {
        Ok(())
    }
}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use std::process::Command;

    use super::*;

    /// What the system says of a process that is started now.
    fn of_a_child() -> String {
        let command = Command::new("grep").args(["Cpus_allowed_list", "/proc/self/status"]).output().unwrap();
        String::from_utf8(command.stdout).unwrap().split_whitespace().last().unwrap().to_owned()
    }

    #[test]
    fn what_is_started_meanwhile_has_one_processor_and_afterwards_all() {
        let before = of_a_child();
        let pinned = Pinned::pin(Cpu::Together, 0).unwrap();
        let one: usize = of_a_child().parse().unwrap();
        pinned.step_aside().unwrap();
        assert_eq!(of_a_child(), one.to_string());
        drop(pinned);
        assert_eq!(of_a_child(), before);
        let pinned = Pinned::pin(Cpu::Number(one), 5).unwrap();
        assert_eq!(of_a_child(), one.to_string());
        drop(pinned);
        let _pinned = Pinned::pin(Cpu::Any, 0).unwrap();
        assert_eq!(of_a_child(), before);
    }

    #[test]
    fn neighbours_have_different_ones_where_there_are_two() {
        let of = |instance| {
            let _pinned = Pinned::pin(Cpu::Together, instance).unwrap();
            of_a_child()
        };
        let available = std::thread::available_parallelism().unwrap().get();
        assert!(available < 2 || of(0) != of(1));
        assert_eq!(of(0), of(u16::try_from(available).unwrap()));
    }

    #[test]
    fn the_simulator_leaves_px4_alone_where_there_is_another() {
        let available = std::thread::available_parallelism().unwrap().get();
        let pinned = Pinned::pin(Cpu::Apart, 0).unwrap();
        let px4s = of_a_child();
        assert!(px4s.parse::<usize>().is_ok(), "{px4s}");
        pinned.step_aside().unwrap();
        assert_eq!(of_a_child() == px4s, available == 1);
    }

    #[test]
    fn a_processor_that_is_not_there_is_refused_with_those_that_are() {
        let error = Pinned::pin(Cpu::Number(1_000), 0).unwrap_err().to_string();
        assert!(error.starts_with("--cpu 1000: ") && error.ends_with("expected"), "{error}");
    }
}
