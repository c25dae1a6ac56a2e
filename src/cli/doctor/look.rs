//! What is looked at without the help of others: the program, ports, folders, PX4.

use std::fs::{self, File};
use std::io;
use std::path::Path;

use super::finding::{Finding, State};
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::pilot::px4;
use samara::control::px4::Version;
use samara::control::px4::versions::VERSIONS;
use samara::link::shell::Ports;
use samara::link::shell::ports::{BoundBy, Port};
use samara::report::json::VERSION;

/// The program, and what it runs on.
pub fn program() -> Vec<Finding> {
    let (system, processor) = (std::env::consts::OS, std::env::consts::ARCH);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let lanes = match has_avx2() {
        true => Finding::new("lanes", State::Ok, "AVX2: eight flights side by side"),
        false => {
            let found = "no AVX2: flights one by one; results are the same, and take longer";
            Finding::new("lanes", State::Absent, found)
        }
    };
    vec![
        Finding::new("samara", State::Ok, format!("{VERSION} on {system}, {processor}")),
        lanes,
        Finding::new("cores", State::Ok, cores.to_string()),
    ]
}

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    samara::simd::lanes::Avx2::found().is_some()
}

#[cfg(not(target_arch = "x86_64"))]
fn has_avx2() -> bool {
    false
}

/// The ports of an instance, each bound for a moment.
pub fn ports(instance: u16) -> Result<Vec<Finding>, Failure> {
    Ok(Ports::of_instance(instance).bad_input()?.each().iter().map(port).collect())
}

fn port(port: &Port) -> Finding {
    let Port { protocol, number, what, bound_by } = *port;
    let of = format!("{protocol} {number}");
    match (port.look(), bound_by) {
        (Ok(()), BoundBy::Others) => {
            Finding::new(&of, State::Absent, format!("no {what} listens here, and none is needed"))
        }
        (Err(_), BoundBy::Others) => Finding::new(&of, State::Ok, format!("a {what} listens here")),
        (Ok(()), _) => Finding::new(&of, State::Ok, format!("free ({what})")),
        (Err(refused), _) => Finding::new(&of, State::No, refused.to_string()).advising(format!(
            "{} cannot run here: end what holds the port, or take another --instance",
            served(bound_by)
        )),
    }
}

/// Verbs that bind a port.
const fn served(bound_by: BoundBy) -> &'static str {
    match bound_by {
        BoundBy::HostedDrop => "drops by PX4 or at a --speed, samara sim and samara stream",
        BoundBy::Autopilot | BoundBy::Others => "samara autopilot and PX4",
    }
}

/// Whether results can be written where they go.
pub fn out() -> Finding {
    let folder = Path::new("out");
    match written_to(folder) {
        Ok(()) => Finding::new("results", State::Ok, "./out can be written to"),
        Err(error) => Finding::new("results", State::No, format!("./out cannot be written to: {error}"))
            .advising("run samara in a folder of yours, or name one with --out"),
    }
}

/// Writes to a folder, and leaves nothing there.
fn written_to(folder: &Path) -> io::Result<()> {
    let is_new = !folder.exists();
    fs::create_dir_all(folder)?;
    let trial = folder.join(format!(".doctor-{}", std::process::id()));
    let written = File::options().write(true).create_new(true).open(&trial).map(drop);
    let cleared = written.and_then(|()| fs::remove_file(&trial));
    if is_new {
        // Another run may have begun to write there.
        let _ = fs::remove_dir(folder);
    }
    cleared
}

/// What opens a page, by the usual names.
pub fn browser() -> Finding {
    let openers = ["xdg-open", "open"];
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let is_there = |name: &&&str| std::env::split_paths(&folders).any(|folder| folder.join(name).is_file());
    match openers.iter().find(is_there) {
        Some(name) => {
            Finding::new("browser", State::Ok, format!("{name} opens pages (drop.html, card.html)"))
        }
        None => Finding::new("browser", State::Absent, format!("neither {} is here", openers.join(" nor ")))
            .advising("pages (drop.html, card.html) are files: open them in any browser, on any machine"),
    }
}

/// PX4, where a build folder is named.
pub fn px4(build: Option<&Path>, instance: u16) -> Vec<Finding> {
    let Some(build) = build else {
        let absent = Finding::new("PX4", State::Absent, "no build folder is named");
        let advice = "to fly PX4 itself, build its simulation and name the folder: --px4 DIR, or SAMARA_PX4";
        return vec![absent.advising(advice)];
    };
    let (program, version) = match px4::found(build) {
        Ok(found) => found,
        Err(failure) => return vec![Finding::new("PX4", State::No, failure.text())],
    };
    let (number, read) = (version.number, version.read);
    let or = if VERSIONS.last() == Some(version) {
        " or later"
    } else if version == Version::OLDEST {
        " or earlier"
    } else {
        ""
    };
    let flies = format!("{number}{or}, by its parameters: it flies, as {read} does");
    let running = match px4::look(instance) {
        Ok(()) => Finding::new("PX4 runs", State::Ok, format!("none of instance {instance}")),
        Err(failure) => Finding::new("PX4 runs", State::No, failure.text()),
    };
    vec![
        Finding::new("PX4", State::Ok, program.display().to_string()),
        Finding::new("PX4 version", State::Ok, flies),
        running,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is written to is left as it was.
    #[test]
    fn a_folder_is_left_as_it_was() {
        let place = tempfile::tempdir().unwrap();
        let (there, new) = (place.path(), place.path().join("a/b"));
        written_to(there).unwrap();
        assert_eq!(fs::read_dir(there).unwrap().count(), 0);
        written_to(&new).unwrap();
        assert!(!new.exists());
        File::options().write(true).create_new(true).open(there.join("file")).unwrap();
        assert!(written_to(&there.join("file")).is_err());
    }
}
