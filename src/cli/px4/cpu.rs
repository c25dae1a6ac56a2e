//! PX4 and its simulator on one processor.
//!
//! In lockstep one of the two always waits for the other: a second processor gains nothing, and to wake a sleeping one costs more than
//! a step's work. So both run on one, by default on another for each instance.

use super::Px4Error;

/// Which.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cpu {
    /// One of those that this process may use, by the instance.
    Auto,
    /// Wherever the system puts it.
    Any,
    /// This one.
    Number(usize),
}

/// This thread, and what it starts meanwhile, on one processor. Ends with the value.
#[derive(Debug)]
pub struct Pinned {
    #[cfg(target_os = "linux")]
    before: Option<rustix::thread::CpuSet>,
}

#[cfg(target_os = "linux")]
mod linux {
    use std::fmt::Write as _;
    use std::io;

    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

    use super::{Cpu, Pinned, Px4Error};

    impl Pinned {
        /// Pins the calling thread for an instance.
        ///
        /// # Errors
        /// [`Px4Error::Cpu`] when there is no such processor for us.
        pub fn pin(cpu: Cpu, instance: u16) -> Result<Self, Px4Error> {
            let had = match cpu {
                Cpu::Any => return Ok(Self { before: None }),
                Cpu::Auto | Cpu::Number(_) => sched_getaffinity(None).map_err(of_the_system)?,
            };
            let allowed: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|n| had.is_set(*n)).collect();
            let chosen = match cpu {
                // From the last one on: the first has the system's interrupts.
                Cpu::Auto => allowed.iter().rev().cycle().nth(usize::from(instance)).copied(),
                Cpu::Number(n) => Some(n),
                Cpu::Any => None,
            };
            let Some(chosen) = chosen else { return Ok(Self { before: None }) };
            if !allowed.contains(&chosen) {
                return Err(Px4Error::Cpu { wanted: chosen, had: list(&allowed) });
            }
            let mut one = CpuSet::new();
            one.set(chosen);
            sched_setaffinity(None, &one).map_err(of_the_system)?;
            Ok(Self { before: Some(had) })
        }
    }

    impl Drop for Pinned {
        fn drop(&mut self) {
            if let Some(before) = &self.before {
                // What was allowed before is allowed again.
                _ = sched_setaffinity(None, before);
            }
        }
    }

    fn of_the_system(error: rustix::io::Errno) -> Px4Error {
        Px4Error::io("cannot choose a processor (--cpu any leaves it to the system)")(io::Error::from(error))
    }

    fn list(numbers: &[usize]) -> String {
        let mut text = String::new();
        for (i, n) in numbers.iter().enumerate() {
            let before = match i {
                0 => "",
                _ if i + 1 == numbers.len() => " or ",
                _ => ", ",
            };
            _ = write!(text, "{before}{n}");
        }
        text
    }
}

#[cfg(not(target_os = "linux"))]
impl Pinned {
    /// Nothing: the system chooses.
    ///
    /// # Errors
    /// [`Px4Error::Cpu`] when one is asked for.
    pub fn pin(cpu: Cpu, _: u16) -> Result<Self, Px4Error> {
        match cpu {
            Cpu::Auto | Cpu::Any => Ok(Self {}),
            Cpu::Number(wanted) => {
                Err(Px4Error::Cpu { wanted, had: "auto or any (a number under Linux only)".to_owned() })
            }
        }
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
        let pinned = Pinned::pin(Cpu::Auto, 0).unwrap();
        let one: usize = of_a_child().parse().unwrap();
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
            let _pinned = Pinned::pin(Cpu::Auto, instance).unwrap();
            of_a_child()
        };
        let available = std::thread::available_parallelism().unwrap().get();
        assert!(available < 2 || of(0) != of(1));
        assert_eq!(of(0), of(u16::try_from(available).unwrap()));
    }

    #[test]
    fn a_processor_that_is_not_there_is_refused_with_those_that_are() {
        let error = Pinned::pin(Cpu::Number(1_000), 0).unwrap_err().to_string();
        assert!(error.starts_with("--cpu 1000: ") && error.ends_with("expected"), "{error}");
    }
}
