//! What a fault makes of a sensor's readings.
//!
//! A sensor that fails is read on, so that its noise after the fault is that of a flight without it.

use nalgebra::Vector3;

use crate::random::{Purpose, Stream};
use crate::sim::faults::{FaultCourse, Sensor, SensorFault};
use crate::units::{RAD_PER_DEG, STANDARD_GRAVITY_M_S2};

/// The readings of all sensors as their faults leave them.
#[derive(Clone, Debug)]
pub struct FaultySensors {
    seed: u64,
    /// The last readings that were given out, position and velocity of a fix.
    last: [Option<[Vector3<f64>; 2]>; Sensor::ALL.len()],
    garbage: [Option<Stream>; Sensor::ALL.len()],
}

impl FaultySensors {
    /// Sensors of which nothing has been read; `seed` draws what is garbage.
    pub fn new(seed: u64) -> Self {
        Self { seed, last: [None; Sensor::ALL.len()], garbage: [const { None }; Sensor::ALL.len()] }
    }

    /// What of a reading at `t_s` [s] since the simulation began is given out, in the sensor's unit; `None`:
    /// nothing.
    pub fn reading(
        &mut self,
        faults: &FaultCourse,
        sensor: Sensor,
        reading: Vector3<f64>,
        t_s: f64,
    ) -> Option<Vector3<f64>> {
        self.pair(faults, sensor, [reading, Vector3::zeros()], t_s).map(|[reading, _]| reading)
    }

    /// What of a satellite fix at `t_s` [s] since the simulation began is given out, position [m] and
    /// velocity [m/s], NED; `None`: nothing. A receiver without a fix is the caller's to tell from one that
    /// is off.
    pub fn fix(
        &mut self,
        faults: &FaultCourse,
        fix: [Vector3<f64>; 2],
        t_s: f64,
    ) -> Option<[Vector3<f64>; 2]> {
        self.pair(faults, Sensor::Gps, fix, t_s)
    }

    fn pair(
        &mut self,
        faults: &FaultCourse,
        sensor: Sensor,
        pair: [Vector3<f64>; 2],
        t_s: f64,
    ) -> Option<[Vector3<f64>; 2]> {
        let [reading, second] = pair;
        let given = match faults.of_sensor(sensor) {
            None => Some(pair),
            Some((SensorFault::Off | SensorFault::NoFix, _)) => return None,
            Some((SensorFault::Stuck, _)) => self.last[sensor as usize].or(Some(pair)),
            Some((SensorFault::Drift { rate }, since_s)) => Some([reading + rate * (t_s - since_s), second]),
            Some((SensorFault::Wrong { offset, scale }, _)) => Some([reading * scale + offset, second]),
            Some((SensorFault::Garbage, _)) => Some(self.garbage(sensor)),
        };
        self.last[sensor as usize] = given;
        given
    }

    fn garbage(&mut self, sensor: Sensor) -> [Vector3<f64>; 2] {
        let stream = self.garbage[sensor as usize]
            .get_or_insert_with(|| Stream::of_part(self.seed, Purpose::Garbage, sensor as u32, 0));
        let mut within = |low: f64, high: f64| Vector3::from_fn(|_, _| stream.between(low, high));
        let either_way = |greatest: f64| (-greatest, greatest);
        let (low, high) = match sensor {
            Sensor::Gyro => either_way(2000.0 * RAD_PER_DEG),
            Sensor::Accelerometer => either_way(16.0 * STANDARD_GRAVITY_M_S2),
            Sensor::Magnetometer => either_way(8.0),
            Sensor::Barometer => (10.0, 1200.0),
            Sensor::Gps => either_way(10_000.0),
        };
        let reading = within(low, high);
        let second = if sensor == Sensor::Gps { within(-100.0, 100.0) } else { Vector3::zeros() };
        [reading, second]
    }
}
