//! Why PX4 cannot be started or cannot fly a mission.

use std::io;
use std::path::PathBuf;

use samara::control::px4::NotQuadX;

/// Why PX4 cannot fly.
#[derive(Debug, thiserror::Error)]
pub enum Px4Error {
    /// The folder is no build folder.
    #[error(
        "{}: no `{missing}` in it. A build folder of PX4's simulation is expected, as `make px4_sitl_default` leaves it in \
         build/px4_sitl_default: it holds bin/px4 and etc/init.d-posix/rcS",
        folder.display()
    )]
    NotABuild {
        /// The folder.
        folder: PathBuf,
        /// What is not there.
        missing: &'static str,
    },
    /// None of the models that are known to leave the simulator to others.
    #[error("{}: none of the models {known} in it, found {found}", folder.display())]
    NoModel {
        /// The folder of airframes.
        folder: PathBuf,
        /// What was looked for.
        known: String,
        /// What is there.
        found: String,
    },
    /// PX4 mixes for rotors that the vehicle has not got.
    #[error("vehicle {vehicle}: this PX4 mixes by `quad_x`")]
    Rotors {
        /// The vehicle.
        vehicle: String,
        /// Which rotor is another.
        #[source]
        why: NotQuadX,
    },
    /// The site's gravity is not PX4's.
    #[error(
        "PX4 has 9.80665 m/s^2 compiled in and its estimator aligns between 0.8 and 1.2 of it; the mission's site has {gravity_m_s2} \
         m/s^2: scale the wire with \"px4_clock\": \"froude\", as mission/titan_px4.json does"
    )]
    Gravity {
        /// Of the site.
        gravity_m_s2: f64,
    },
    /// A barometer that never changes counts as broken.
    #[error(
        "the mission's barometer has no noise: PX4 takes a constant one for stale and its estimator never starts; set \
         sensors.barometer.noise_hpa (0.01)"
    )]
    Barometer,
    /// What stands where PX4's working directory would be made anew is not ours.
    #[error(
        "{}: PX4's working directory is made anew there for each flight, and what stands there is not one that samara made (no \
         {marker} in it): move it away, or choose another --out",
        work.display()
    )]
    NotOurs {
        /// The folder.
        work: PathBuf,
        /// What would be in it.
        marker: &'static str,
    },
    /// The working directory would be in PX4's build folder, or the build folder in it.
    #[error(
        "{}: PX4's working directory is made anew there for each flight, and it lies in PX4's build folder {} or holds it: choose \
         another --out",
        work.display(),
        build.display()
    )]
    InTheBuild {
        /// The working directory.
        work: PathBuf,
        /// The build folder.
        build: PathBuf,
    },
    /// A folder that cannot stand in a PATH.
    #[error(
        "{}: PX4's start-up script is told the vehicle's mixer by way of its PATH, and a folder with a colon in its name cannot \
         stand there: choose another --out",
        work.display()
    )]
    Colon {
        /// The working directory.
        work: PathBuf,
    },
    /// Another PX4 has the number, or what is left of one.
    #[error(
        "PX4 instance {instance} is running already: {} is held by {holders}. (A killed PX4 leaves its start-up script behind, which holds \
         it on.) End that, or choose another --instance",
        lock.display()
    )]
    Running {
        /// The number.
        instance: u16,
        /// PX4's lock.
        lock: PathBuf,
        /// The processes that hold the lock.
        holders: String,
    },
    /// A processor that cannot be had.
    #[error("--cpu {wanted}: {had} expected")]
    Cpu {
        /// The one that was asked for.
        wanted: usize,
        /// What can be had.
        had: String,
    },
    /// PX4's simulation is for Unix.
    #[cfg(not(unix))]
    #[error("PX4's simulation runs under Linux and macOS; here only --autopilot reference flies")]
    NotHere,
    /// A file or folder, or the process itself.
    #[error("{what}")]
    Io {
        /// What was to be done.
        what: String,
        /// The system's reason.
        source: io::Error,
    },
}

impl Px4Error {
    /// The error of a file, a folder or the system; `what` was to be done.
    pub fn io(what: impl Into<String>) -> impl FnOnce(io::Error) -> Self {
        let what = what.into();
        move |source| Self::Io { what, source }
    }
}
