//! What is in a flight log or table: whose it is, its topics, what was flown, what it tells of the vehicle.

use samara_core::logged_flight::phases::{Phase, phases};
use samara_core::logged_flight::tells::{Tells, tells};
use samara_core::logged_flight::{LoggedFlight, Series};
use samara_core::printable::printable;
use samara_core::ulog::{Topic, Ulog};

use crate::document::{Document, Grid, Passage, Section};
use crate::json::{VERSION, finite, result_objects, text};

/// Texts of the vehicle's up to this severity are shown: warnings and worse.
const WARNING: u8 = 4;
/// So many texts, the newest.
const TEXTS: usize = 8;
/// What a log says of itself, in the order in which it is shown.
const SAYS: [(&str, &str); 5] = [
    ("sys_name", "autopilot"),
    ("ver_hw", "board"),
    ("ver_sw_release", "version"),
    ("ver_sw", "commit"),
    ("sys_toolchain_ver", "compiler"),
];

/// A flight log or a flight's table, and what was found in it.
pub struct LogReport<'a> {
    /// Name of the file.
    pub name: &'a str,
    /// The log; a table is none.
    log: Option<&'a Ulog<'a>>,
    record: LoggedFlight,
    phases: Vec<Phase>,
    tells: Vec<Tells>,
}

/// A quantity with where it was read from, how many values it has, their rate and the longest gap.
type Quantity = (&'static str, Option<(&'static str, usize, f64, f64)>);

impl<'a> LogReport<'a> {
    /// Looks through a flight, and the log that it was read from where it is no table.
    pub fn of(name: &'a str, record: LoggedFlight, log: Option<&'a Ulog<'a>>) -> Self {
        let phases = phases(&record);
        let tells = tells(&record, &phases);
        Self { name, log, record, phases, tells }
    }

    /// Facts that the log states, each with its name.
    fn says(&self) -> Vec<(&'static str, String)> {
        let Some(log) = self.log else { return Vec::new() };
        let release = log.release().map(|[major, minor, patch, kind]| {
            // PX4's kinds: alpha from 64, beta from 128, candidates from 192, 255 the release itself.
            let kind = match kind {
                255 => "",
                192.. => " (release candidate)",
                128.. => " (beta)",
                _ => " (development)",
            };
            format!("v{major}.{minor}.{patch}{kind}")
        });
        let of = |(key, name): (&str, &'static str)| {
            let said =
                if key == "ver_sw_release" { release.clone() } else { log.text(key).map(str::to_owned) };
            Some((name, printable(&said.filter(|said| !said.is_empty())?).into_owned()))
        };
        SAYS.into_iter().filter_map(of).collect()
    }

    fn quantities(&self) -> [Quantity; 9] {
        fn of<const N: usize>(series: Option<&Series<N>>) -> Option<(&'static str, usize, f64, f64)> {
            series.map(|s| (s.from, s.t_s.len(), s.rate_hz(), s.longest_gap_s()))
        }
        let r = &self.record;
        [
            ("commands to the rotors", of(r.motors.as_ref())),
            ("commanded thrust", of(r.thrust.as_ref())),
            ("specific force", of(r.force_body_m_s2.as_ref())),
            ("angular rates", of(r.rates_body_rad_s.as_ref())),
            ("attitude", of(r.attitude.as_ref())),
            ("velocity", of(r.velocity_ned_m_s.as_ref())),
            ("battery", of(r.battery.as_ref())),
            ("armed", of(r.armed.as_ref())),
            ("landed", of(r.landed.as_ref())),
        ]
    }

    fn topics(&self) -> impl Iterator<Item = &'a Topic> {
        self.log.into_iter().flat_map(Ulog::topics)
    }

    /// Rows of all topics; of a table its own, as far as they have anything.
    fn rows(&self) -> usize {
        let longest = || self.quantities().iter().filter_map(|(_, found)| Some(found.as_ref()?.1)).max();
        self.log.map_or_else(|| longest().unwrap_or(0), Ulog::rows)
    }

    /// How it was flown, and what cannot be read, in sentences.
    fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if let Some((log, first)) = self.log.and_then(|log| Some((log, log.lost.first()?))) {
            remarks.push(format!(
                "{} bytes in {} places are damaged and were passed over, the first from byte {} on",
                log.lost_bytes(),
                log.lost.len(),
                first.start
            ));
        }
        let dropouts = self.log.map_or(&[][..], |log| &log.dropouts);
        if !dropouts.is_empty() {
            let lasted_ms: u64 = dropouts.iter().map(|(_, ms)| u64::from(*ms)).sum();
            let count = dropouts.len();
            remarks.push(format!("{count} times the card was too slow: {lasted_ms} ms in all are missing"));
        }
        if self.phases.is_empty() {
            let words = "when it flew is not known, which takes specific force and arming: all of it is taken \
                         for a flight";
            remarks.push(words.to_owned());
        }
        remarks
    }

    /// What there is to say of it; `topics`: with a table of all topics.
    pub fn document(&self, topics: bool) -> Document {
        let title = format!("Flight log {}", printable(self.name));
        let says: Vec<String> =
            self.says().into_iter().map(|(name, said)| format!("{name} {said}")).collect();
        let of_topics = self.log.map_or(String::new(), |log| {
            format!(" of {} topics, {} parameters", log.topics().count(), log.parameters.len())
        });
        let lead = format!(
            "{}: {:.1} s, {} rows{of_topics}{}{}",
            printable(self.name),
            self.record.end_s(),
            self.rows(),
            if says.is_empty() { "" } else { "; " },
            says.join(", ")
        );
        let remarks = self.remarks().into_iter().map(Passage::Remark);
        let mut flown: Vec<Passage> = vec![Passage::Table(self.quantity_table())];
        if !self.phases.is_empty() {
            flown.push(Passage::Table(self.phase_table()));
        }
        flown.push(Passage::Table(self.tells_table()));
        let texts = self.log.into_iter().flat_map(|log| log.texts.iter().map(|text| (log.start_us, text)));
        let texts: Vec<String> = texts
            .filter(|(_, said)| said.level <= WARNING)
            .map(|(start_us, said)| {
                let t_s = (said.time_us as f64 - start_us as f64) * 1e-6;
                format!("  {t_s:8.3} s  {}\n", printable(&said.text))
            })
            .collect();
        if !texts.is_empty() {
            let newest = texts.get(texts.len().saturating_sub(TEXTS)..).unwrap_or_default();
            flown.push(Passage::OnTerminal(format!(
                "Warnings, the newest of {}\n{}",
                texts.len(),
                newest.concat()
            )));
        }
        if topics {
            flown.push(Passage::Table(self.topic_table()));
        }
        let section =
            Section { id: "flight", title: "Flight", passages: flown.into_iter().chain(remarks).collect() };
        Document {
            tab: title.clone(),
            title,
            lead: vec![Passage::Said(lead)],
            sections: vec![section],
            ..Document::default()
        }
    }

    fn quantity_table(&self) -> Grid {
        let mut grid = Grid::new("What was logged", ["", "values", "rate [Hz]", "longest gap [s]", "from"]);
        for (name, found) in self.quantities() {
            match found {
                Some((from, count, rate, gap)) => {
                    let cells = [count.to_string(), number(rate, 1), number(gap, 2), from.to_owned()];
                    grid.row(name, cells);
                }
                None => grid.row(name, ["0".to_owned(), "-".to_owned(), "-".to_owned(), String::new()]),
            }
        }
        grid
    }

    fn phase_table(&self) -> Grid {
        let mut grid = Grid::new("What was flown", ["", "from [s]", "to [s]", "for [s]"]);
        for phase in &self.phases {
            let times = [phase.from_s, phase.to_s, phase.length_s()].map(|t_s| format!("{t_s:.1}"));
            grid.row(phase.doing.words(), times);
        }
        grid
    }

    fn tells_table(&self) -> Grid {
        let mut grid = Grid::new("What it may tell of the vehicle", ["", "", "why not"]);
        for tells in &self.tells {
            let can = if tells.lacks.is_empty() { "yes" } else { "no" };
            grid.row(
                tells.quantity.words(),
                [can.to_owned(), tells.lacks.first().cloned().unwrap_or_default()],
            );
            for lack in tells.lacks.iter().skip(1) {
                grid.row("", [String::new(), lack.clone()]);
            }
        }
        grid.words = true;
        grid
    }

    fn topic_table(&self) -> Grid {
        let mut grid = Grid::new("Topics", ["", "instance", "rows", "columns"]);
        for topic in self.topics() {
            let cells =
                [topic.instance.to_string(), topic.len().to_string(), topic.columns().count().to_string()];
            grid.row(&printable(&topic.name), cells);
        }
        grid
    }

    /// The object of `--json`.
    pub fn json(&self) -> String {
        text(&LogObject::of(self))
    }
}

fn number(x: f64, decimals: usize) -> String {
    if x.is_finite() { format!("{x:.decimals$}") } else { "-".to_owned() }
}

result_objects! {
    /// What is in a flight log, as `samara log --json` prints it.
    LogObject(of: &LogReport<'_>) {
        /// Version of samara that made the result.
        version: String = VERSION.to_owned(),
        /// Name of the file.
        file: String = of.name.to_owned(),
        /// From its start to its last value [s].
        length_s: f64 = of.record.end_s(),
        /// Rows of all topics, or of the table.
        rows: usize = of.rows(),
        /// Number of parameters.
        parameters: usize = of.log.map_or(0, |log| log.parameters.len()),
        /// Bytes that are no messages and were passed over.
        lost_bytes: usize = of.log.map_or(0, Ulog::lost_bytes),
        /// Facts that the log states.
        says: Vec<LogSaysObject> = of.says().into_iter().map(LogSaysObject::of).collect(),
        /// Quantities of the flight.
        quantities: Vec<LogQuantityObject> = of.quantities().iter().map(LogQuantityObject::of).collect(),
        /// What was flown, one behind the other.
        phases: Vec<LogPhaseObject> = of.phases.iter().map(LogPhaseObject::of).collect(),
        /// Quantities of the vehicle, and whether the log may tell them.
        tells: Vec<LogTellsObject> = of.tells.iter().map(LogTellsObject::of).collect(),
        /// Topics that have rows.
        topics: Vec<LogTopicObject> = of.topics().map(LogTopicObject::of).collect(),
    }

    /// What a log says of itself.
    LogSaysObject(says: (&'static str, String)) {
        /// Of what.
        name: String = says.0.to_owned(),
        /// In its words.
        text: String = says.1.clone(),
    }

    /// A quantity of a flight.
    LogQuantityObject(of: &Quantity) [let found = of.1;] {
        /// Name of the quantity.
        name: String = of.0.to_owned(),
        /// Topic and columns that it was read from; null: the log does not have it.
        from: Option<String> = found.map(|(from, ..)| from.to_owned()),
        /// Number of values.
        values: usize = found.map_or(0, |(_, count, ..)| count),
        /// Rate, by the median interval [Hz].
        rate_hz: Option<f64> = found.and_then(|(_, _, rate, _)| finite(rate)),
        /// Longest time without a value [s].
        longest_gap_s: Option<f64> = found.and_then(|(.., gap)| finite(gap)),
    }

    /// A time in which the vehicle was doing one thing.
    LogPhaseObject(phase: &Phase) {
        /// One of `disarmed`, `on the ground`, `carried, rotors still`, `falling`, `hovering`,
        /// `manoeuvring`.
        doing: String = phase.doing.words().to_owned(),
        /// From this time on since the log's start [s].
        from_s: f64 = phase.from_s,
        /// To that time [s].
        to_s: f64 = phase.to_s,
    }

    /// What the log may tell of a quantity.
    LogTellsObject(tells: &Tells) {
        /// The quantity.
        quantity: String = tells.quantity.words().to_owned(),
        /// Whether it may.
        can: bool = tells.lacks.is_empty(),
        /// Why not, each reason by itself.
        lacks: Vec<String> = tells.lacks.clone(),
    }

    /// A topic.
    LogTopicObject(topic: &Topic) {
        /// Name of the message.
        name: String = topic.name.clone(),
        /// Number of the instance.
        instance: u8 = topic.instance,
        /// Number of rows.
        rows: usize = topic.len(),
        /// Number of columns.
        columns: usize = topic.columns().count(),
    }
}
