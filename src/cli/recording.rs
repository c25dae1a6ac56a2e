//! The `.tlog` and `.ulg` files of a run: one flight each.
//!
//! Simulated time starts over when an autopilot is replaced or a simulator is. Then a new file begins,
//! `hil.2.tlog` after `hil.tlog`, so that in each the stamps are those of the messages. Later flights of an
//! earlier run in the same folder go when its first file is overwritten: the folder holds one run. After a
//! hundred flights the last file is written anew for each: a simulator that starts over for ever fills no
//! disk.

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

/// Most flights of a run that have a file each; those that follow share the last, which holds the latest.
const MOST_FLIGHTS: u32 = 100;

/// Files of one flight each: `<stem>.<extension>`, `<stem>.2.<extension>`, ..
struct FlightFiles {
    folder: OutputFolder,
    stem: &'static str,
    extension: &'static str,
    flights: u32,
}

impl FlightFiles {
    fn new(folder: &OutputFolder, stem: &'static str, extension: &'static str) -> Self {
        Self { folder: folder.clone(), stem, extension, flights: 0 }
    }

    /// The next flight's file; the first one removes the later ones of an earlier run.
    fn next(&mut self) -> io::Result<LateFile> {
        self.flights = self.following();
        for later in (2..).take_while(|_| self.flights == 1) {
            if !self.folder.clear(&self.name(later)).map_err(|failure| io::Error::other(failure.text()))? {
                break;
            }
        }
        Ok(self.folder.late(&self.name(self.flights)))
    }

    /// The next flight's file, in words, as long as it is a new one.
    fn announced(&self) -> Option<String> {
        let next = self.following();
        let later =
            if next == MOST_FLIGHTS { ", as each flight from now on, over the one before" } else { "" };
        (next != self.flights).then(|| format!("{}{later}", self.name(next)))
    }

    /// The number of the next flight's file.
    fn following(&self) -> u32 {
        (self.flights + 1).min(MOST_FLIGHTS)
    }

    fn name(&self, flight: u32) -> String {
        let Self { stem, extension, .. } = self;
        if flight == 1 { format!("{stem}.{extension}") } else { format!("{stem}.{flight}.{extension}") }
    }
}

/// Writes frames as they come; a file is made with its first frame.
pub struct Recording {
    files: FlightFiles,
    epoch_unix_us: u64,
    last: TimeUs,
    tlog: Option<Tlog<LateFile>>,
}

impl Recording {
    /// A recording of a link to `<stem>.tlog`, `<stem>.2.tlog`, ..
    pub fn new(folder: &OutputFolder, link: Link, mission: &Mission) -> Self {
        let files = FlightFiles::new(folder, stem_of(link), "tlog");
        Self { files, epoch_unix_us: mission.epoch_unix_us, last: 0, tlog: None }
    }

    /// Whether the frames of a link go here.
    pub fn records(&self, link: Link) -> bool {
        self.files.stem == stem_of(link)
    }

    /// Writes a frame; the name of the new file, if time has started over and one has been begun. That later
    /// flights share one is told once.
    pub fn write(&mut self, now: TimeUs, frame: &[u8]) -> io::Result<Option<String>> {
        let before = self.tlog.take_if(|_| now < self.last);
        let begun = before.map(Tlog::finish).transpose()?.and_then(|_| self.files.announced());
        self.last = now;
        let tlog = match &mut self.tlog {
            Some(tlog) => tlog,
            none => none.insert(Tlog::new(self.files.next()?, self.epoch_unix_us)),
        };
        tlog.write(now, frame)?;
        Ok(begun)
    }

    /// Closes the file.
    pub fn finish(self) -> io::Result<()> {
        self.tlog.map_or(Ok(()), |tlog| tlog.finish().map(|_| ()))
    }
}

/// Writes the autopilot's flight logs, `flight.ulg`, `flight.2.ulg`, ..
pub struct FlightLogs {
    files: FlightFiles,
    vehicle_name: String,
    current: Option<FlightLog<LateFile>>,
}

impl FlightLogs {
    /// The logs of a vehicle.
    pub fn new(folder: &OutputFolder, vehicle_name: &str) -> Self {
        let files = FlightFiles::new(folder, "flight", "ulg");
        Self { files, vehicle_name: vehicle_name.to_owned(), current: None }
    }

    /// Writes an entry; a flight that begins gets a file of its own.
    pub fn write(&mut self, entry: &LogEntry) -> io::Result<()> {
        if let LogEntry::Begin(at, parameters) = entry {
            if let Some(log) = self.current.take() {
                log.finish()?;
            }
            self.current = Some(FlightLog::new(self.files.next()?, *at, &self.vehicle_name, parameters)?);
        }
        self.current.as_mut().map_or(Ok(()), |log| log.write(entry))
    }

    /// Closes the file.
    pub fn finish(self) -> io::Result<()> {
        self.current.map_or(Ok(()), |log| log.finish().map(|_| ()))
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test that reads its files")]
mod tests {
    use std::fs;
    use std::io::Write as _;
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
        let folder = OutputFolder::plain(place.path()).unwrap();
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

    /// Property: however often time starts over, a run has a hundred files of a kind at most, and the last of
    /// them holds the latest flight.
    #[test]
    fn flights_without_end_fill_no_disk() {
        let place = tempfile::tempdir().unwrap();
        let folder = OutputFolder::plain(place.path()).unwrap();
        let mut files = FlightFiles::new(&folder, "hil", "tlog");
        let flights = 3 * MOST_FLIGHTS;
        for flight in 0..flights {
            let mut file = files.next().unwrap();
            file.write_all(flight.to_string().as_bytes()).unwrap();
            file.flush().unwrap();
        }
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), MOST_FLIGHTS as usize);
        let text = |name: &str| fs::read_to_string(place.path().join(name)).unwrap();
        assert_eq!([text("hil.tlog"), text("hil.2.tlog")], ["0", "1"]);
        assert_eq!(text("hil.100.tlog"), (flights - 1).to_string());
        // Told of each new file, and once of the one that is shared.
        let mission = load_mission(Path::new("mission/titan_drop.json")).unwrap();
        let mut recording = Recording::new(&folder, Link::Simulator, &mission);
        let told: Vec<String> = (0..2 * flights)
            .filter_map(|i| recording.write(TimeUs::from(1 - i % 2), &[0xFD]).unwrap())
            .collect();
        recording.finish().unwrap();
        assert_eq!(told.len(), MOST_FLIGHTS as usize - 1);
        assert_eq!(told[98], "hil.100.tlog, as each flight from now on, over the one before");
        // The next run in the folder leaves nothing of this one's later flights.
        let mut again = FlightFiles::new(&folder, "hil", "tlog");
        again.next().unwrap().write_all(b"new").unwrap();
        assert_eq!(fs::read_dir(place.path()).unwrap().count(), 1);
    }
}
