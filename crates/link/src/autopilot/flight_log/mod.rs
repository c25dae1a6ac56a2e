//! The flight log of an autopilot: PX4's ULog, for pyulog, PlotJuggler and Flight Review.
//!
//! | file | holds |
//! |---|---|
//! | `record` | what the autopilot knew and commanded at a control step |
//! | `topics` | its rows, under PX4's names |
//! | [`ulog`] | the container |
//!
//! Stamps are microseconds of simulated time since the vehicle's boot; `vehicle_gps_position.time_utc_usec`
//! has the mission's own date. The same flight gives the same bytes.

mod record;
mod topics;
pub mod ulog;

use std::collections::BTreeMap;
use std::io::{self, Write};

pub use record::{BatteryState, LogEntry, Pose, SatelliteFix, Sensors, StepRecord};
use topics::TOPICS;
use ulog::{Scalar, Ulog};

use crate::params::Value;
use crate::time::TimeUs;

/// `ver_data_format` of PX4's logger since v1.14.
const DATA_FORMAT: u32 = 2;
/// PX4's parameters of the time flown before this flight [us], in two halves.
const FLIGHT_TIME: [&str; 2] = ["LND_FLIGHT_T_HI", "LND_FLIGHT_T_LO"];

/// Writes the flight log of one flight.
#[derive(Debug)]
pub struct FlightLog<W: Write> {
    ulog: Ulog<W>,
}

impl<W: Write> FlightLog<W> {
    /// Begins a log; give it a buffered writer.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(
        out: W,
        start: TimeUs,
        vehicle_name: &str,
        parameters: &BTreeMap<String, Value>,
    ) -> io::Result<Self> {
        let information = [
            ("sys_name", Scalar::Text("samara")),
            ("ver_hw", Scalar::Text(vehicle_name)),
            ("ver_sw", Scalar::Text(env!("CARGO_PKG_VERSION"))),
            ("time_ref_utc", Scalar::Int(0)),
            // As logged by PX4 v1.16: what Flight Review goes by for the names of fields.
            ("ver_data_format", Scalar::Count(DATA_FORMAT)),
        ];
        let parameters: Vec<_> = parameters
            .iter()
            .map(|(name, value)| (name.clone(), scalar(*value)))
            // A vehicle that has never flown before, for those who read its flight time.
            .chain(FLIGHT_TIME.map(|name| (name.to_owned(), Scalar::Int(0))))
            .collect();
        let any = StepRecord::default();
        let ulog = Ulog::new(out, start, &information, &parameters, &TOPICS, &any)?;
        Ok(Self { ulog })
    }

    /// Writes an entry. [`LogEntry::Begin`] writes nothing: it asks for a new log.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn write(&mut self, entry: &LogEntry) -> io::Result<()> {
        match entry {
            LogEntry::Begin(..) => Ok(()),
            LogEntry::Step(record) => self.ulog.write(record.at, &TOPICS, record.as_ref()),
            LogEntry::Said(at, event) => self.ulog.text(*at, event.severity as u8, &event.text),
            LogEntry::Parameter(name, value) => self.ulog.parameter(name, scalar(*value)),
            LogEntry::Gap => self.ulog.dropout(1),
        }
    }

    /// The writer, flushed.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<W> {
        self.ulog.finish()
    }
}

fn scalar(value: Value) -> Scalar<'static> {
    match value {
        Value::Int(value) => Scalar::Int(value),
        Value::Real(value) => Scalar::Float(value),
    }
}
