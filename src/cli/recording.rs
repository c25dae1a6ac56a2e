//! The `.tlog` and `.ulg` files of a run: one flight each.
//!
//! Simulated time starts over when an autopilot is replaced or a simulator is. Then a new file begins,
//! `hil.2.tlog` after `hil.tlog`, so that in each the stamps are those of the messages. Later flights of an
//! earlier run in the same folder go when its first file is overwritten: the folder holds one run.

use std::fs;
use std::io;

use super::results::{LateFile, OutputFolder};
use samara::config::Mission;
use samara::link::{FlightLog, Link, LogEntry, TimeUs, Tlog};

/// The stem of the file that a link is recorded to: that of the simulator, of ground stations, and of
/// companions, where the streamer and the parachute speak. Frames are numbered by link: in one file the
/// numbers of two would seem to have gaps.
fn stem_of(link: Link) -> &'static str {
    match link {
        Link::Simulator => "hil",
        Link::GroundStation => "vehicle",
        Link::Api | Link::Parachute => "companion",
    }
}

/// Writes frames as they come; a file is made with its first frame.
pub struct Recording {
    folder: OutputFolder,
    stem: &'static str,
    epoch_unix_us: u64,
    flights: u32,
    last: Option<TimeUs>,
    tlog: Tlog<LateFile>,
}

impl Recording {
    /// A recording of a link to `<stem>.tlog`, `<stem>.2.tlog`, ..
    pub fn new(folder: &OutputFolder, link: Link, mission: &Mission) -> Self {
        let stem = stem_of(link);
        let epoch_unix_us = mission.epoch_unix_us;
        let tlog = Tlog::new(folder.late(&name(stem, "tlog", 1)), epoch_unix_us);
        Self { folder: folder.clone(), stem, epoch_unix_us, flights: 1, last: None, tlog }
    }

    /// Whether the frames of a link go here.
    pub fn records(&self, link: Link) -> bool {
        self.stem == stem_of(link)
    }

    /// Writes a frame; the name of the new file, if time has started over and one has been begun.
    pub fn write(&mut self, now: TimeUs, frame: &[u8]) -> io::Result<Option<String>> {
        let mut begun = None;
        if self.last.is_none() {
            remove_leftovers(&self.folder, self.stem, "tlog")?;
        }
        if self.last.is_some_and(|last| now < last) {
            self.flights += 1;
            let name = name(self.stem, "tlog", self.flights);
            let next = Tlog::new(self.folder.late(&name), self.epoch_unix_us);
            std::mem::replace(&mut self.tlog, next).finish()?;
            begun = Some(name);
        }
        self.last = Some(now);
        self.tlog.write(now, frame)?;
        Ok(begun)
    }

    /// Closes the file.
    pub fn finish(self) -> io::Result<()> {
        self.tlog.finish().map(|_| ())
    }
}

/// Writes the autopilot's flight logs, `flight.ulg`, `flight.2.ulg`, ..
pub struct FlightLogs {
    folder: OutputFolder,
    vehicle_name: String,
    flights: u32,
    current: Option<FlightLog<LateFile>>,
}

impl FlightLogs {
    /// The logs of a vehicle.
    pub fn new(folder: &OutputFolder, vehicle_name: &str) -> Self {
        Self { folder: folder.clone(), vehicle_name: vehicle_name.to_owned(), flights: 0, current: None }
    }

    /// Writes an entry; a flight that begins gets a file of its own.
    pub fn write(&mut self, entry: &LogEntry) -> io::Result<()> {
        if let LogEntry::Begin(at, parameters) = entry {
            if let Some(log) = self.current.take() {
                log.finish()?;
            }
            self.flights += 1;
            if self.flights == 1 {
                remove_leftovers(&self.folder, "flight", "ulg")?;
            }
            let file = self.folder.late(&name("flight", "ulg", self.flights));
            self.current = Some(FlightLog::new(file, *at, &self.vehicle_name, parameters)?);
        }
        self.current.as_mut().map_or(Ok(()), |log| log.write(entry))
    }

    /// Closes the file.
    pub fn finish(self) -> io::Result<()> {
        self.current.map_or(Ok(()), |log| log.finish().map(|_| ()))
    }
}

fn remove_leftovers(folder: &OutputFolder, stem: &str, extension: &str) -> io::Result<()> {
    for flight in 2.. {
        match fs::remove_file(folder.path().join(name(stem, extension, flight))) {
            Ok(()) => {}
            Err(e) if e.kind() == io::ErrorKind::NotFound => break,
            Err(e) => return Err(e),
        }
    }
    Ok(())
}

fn name(stem: &str, extension: &str, flight: u32) -> String {
    if flight == 1 { format!("{stem}.{extension}") } else { format!("{stem}.{flight}.{extension}") }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that reads its files")]
mod tests {
    use std::path::Path;

    use super::*;
    use samara::config::load_mission;

    /// Stamps since the epoch of one-byte frames.
    fn stamps(path: &Path, epoch: u64) -> Vec<u64> {
        let stamp = |record: &[u8]| u64::from_be_bytes(record[..8].try_into().unwrap()) - epoch;
        fs::read(path).unwrap().chunks(9).map(stamp).collect()
    }

    #[test]
    fn each_flight_has_a_file_of_its_own_with_its_own_times() {
        let mission = load_mission(Path::new("mission/titan_drop.json")).unwrap();
        let place = tempfile::tempdir().unwrap();
        let folder = OutputFolder::create(Some(place.path()), "").unwrap();
        let mut recording = Recording::new(&folder, Link::Simulator, &mission);
        let mut begun = Vec::new();
        for now in [0, 0, 4, 8, 12, 4, 8, 8, 0] {
            begun.extend(recording.write(now, &[0xFD]).unwrap());
        }
        recording.finish().unwrap();
        assert_eq!(begun, ["hil.2.tlog", "hil.3.tlog"]);
        let of = |name: &str| stamps(&place.path().join(name), mission.epoch_unix_us);
        assert_eq!(of("hil.tlog"), [0, 0, 4, 8, 12]);
        assert_eq!(of("hil.2.tlog"), [4, 8, 8]);
        assert_eq!(of("hil.3.tlog"), [0]);

        // Another run that has only one flight.
        let mut recording = Recording::new(&folder, Link::Simulator, &mission);
        assert!(place.path().join("hil.3.tlog").exists(), "a run that never begins leaves all alone");
        recording.write(4, &[0xFD]).unwrap();
        recording.finish().unwrap();
        let left = fs::read_dir(place.path()).unwrap().count();
        assert_eq!((of("hil.tlog"), left), (vec![4], 1));
    }
}
