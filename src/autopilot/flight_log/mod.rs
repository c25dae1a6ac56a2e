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

pub use record::{LogEntry, Pose, SatelliteFix, Sensors, StepRecord};
use topics::TOPICS;
use ulog::{Scalar, Ulog};

use crate::params::Value;
use crate::time::TimeUs;

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
        ];
        let parameters: Vec<_> =
            parameters.iter().map(|(name, value)| (name.clone(), scalar(*value))).collect();
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
