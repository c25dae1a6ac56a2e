//! The scale by which torque and thrust make up for a battery's voltage (MC_BAT_SCALE_EN):
//! `MulticopterRateControl::Run` and `lib/battery/battery.cpp`, lines as of the tags.
//!
//! ```text
//! scale = BAT1_V_CHARGED/(voltage of a cell without load), 1 to 1.3     v1.12.0:239-254, v1.14.3:270-285,
//!                                                                       v1.16.0:336-346
//! torque, thrust *= scale            v1.12.0: MulticopterRateControl.cpp:240-253, v1.14.3: 235-250 (cut to
//!                                    -1..1), v1.16.0: 241-256
//! ```
//!
//! How the voltage of a cell comes from what is measured differs between versions ([`CellVoltage`]). PX4
//! takes its samples at 100 Hz, here they are those of the IMU: the time constants of the filters are the
//! same. Left out: v1.16's estimate of a resistance that is not given, in whose place stands what that
//! begins with.

use super::Parameters;
use super::law::{CellVoltage, Law};

/// Time constants of the filters of voltage and throttle, and of the current [s].
const VOLTAGE_S: f64 = 1.0;
const CURRENT_S: f64 = 0.5;
/// Most that is made up for.
const MOST: f64 = 1.3;
/// Resistance of a cell that v1.16 begins to estimate at (R_DEFAULT) [ohm].
const RESISTANCE_OHM: f64 = 0.005;
/// PX4's least current that counts (FLT_EPSILON) [A].
const NO_CURRENT_A: f64 = 1.192_092_9e-7;

/// The filters of PX4's battery.
#[derive(Clone, Copy, Debug, Default)]
pub struct BatteryScale {
    /// Throttle that was last sent to the motors.
    throttle: f64,
    filtered: Option<Filtered>,
}

#[derive(Clone, Copy, Debug)]
struct Filtered {
    /// Voltage of a cell [V].
    cell_v: f64,
    current_a: f64,
    throttle: f64,
}

impl BatteryScale {
    /// The scale with the next measured voltage of the bus [V] and current of the battery [A], where that is
    /// measured, `dt_s` after those before. The first ones are taken as having been there for ever.
    pub fn step(&mut self, p: &Parameters, law: &Law, bus_v: f64, pack_a: Option<f64>, dt_s: f64) -> f64 {
        if p.bat_n_cells < 1.0 {
            return 1.0;
        }
        let (mut cell_v, current_a) = (bus_v / p.bat_n_cells, pack_a.unwrap_or(-1.0));
        if law.cell_voltage == CellVoltage::RaisedThenFiltered && current_a > NO_CURRENT_A {
            let given = p.bat_r_internal_ohm >= 0.0;
            cell_v += current_a * if given { p.bat_r_internal_ohm } else { RESISTANCE_OHM };
        }
        let new = Filtered { cell_v, current_a, throttle: self.throttle };
        let towards = |from: f64, to: f64, time_s: f64| from + dt_s / (time_s + dt_s) * (to - from);
        let filtered = self.filtered.map_or(new, |before| Filtered {
            cell_v: towards(before.cell_v, new.cell_v, VOLTAGE_S),
            current_a: towards(before.current_a, new.current_a, CURRENT_S),
            throttle: towards(before.throttle, new.throttle, VOLTAGE_S),
        });
        self.filtered = Some(filtered);
        let by_current = |counts: bool| counts.then_some(p.bat_r_internal_ohm * filtered.current_a);
        let raised_v = match law.cell_voltage {
            CellVoltage::RaisedByFilteredThrottle => {
                by_current(p.bat_r_internal_ohm >= 0.0).unwrap_or(p.bat_v_load_drop * filtered.throttle)
            }
            CellVoltage::RaisedByThrottle => {
                by_current(p.bat_r_internal_ohm >= 0.0 && filtered.current_a > NO_CURRENT_A)
                    .unwrap_or(p.bat_v_load_drop * self.throttle)
            }
            CellVoltage::RaisedThenFiltered => 0.0,
        };
        let mut open_v = filtered.cell_v + raised_v;
        if law.cell_voltage != CellVoltage::RaisedThenFiltered {
            open_v = open_v.max(p.bat_v_empty).min(p.bat_v_charged);
        }
        let scale = p.bat_v_charged / open_v;
        if scale.is_finite() { scale.clamp(1.0, MOST) } else { 1.0 }
    }

    /// Takes the throttle that was sent to the motors.
    pub fn note_throttle(&mut self, throttle: f64) {
        self.throttle = throttle;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::px4::Px4Controller;
    use crate::control::test_vehicles::{at_rest, quadrotor};
    use crate::control::{Controller, Measurement, Setpoint};
    use crate::model::VehicleOptions;
    use nalgebra::Vector3;

    const DT_S: f64 = 0.004;

    /// Six cells of 4.2 V.
    fn six_cells(law: &Law) -> Parameters {
        Parameters {
            bat_scale_en: 1.0,
            bat_n_cells: 6.0,
            bat_v_charged: 4.2,
            bat_v_empty: 3.3,
            ..law.defaults()
        }
    }

    /// After many samples.
    fn settled(p: &Parameters, law: &Law, (bus_v, pack_a): (f64, Option<f64>), throttle: f64) -> f64 {
        let mut battery = BatteryScale::default();
        battery.step(p, law, 25.2, Some(0.0), DT_S);
        battery.note_throttle(throttle);
        (0..10_000).fold(0.0, |_, _| battery.step(p, law, bus_v, pack_a, DT_S))
    }

    /// By hand from `battery.cpp` of each version: 22.2 V and 60 A of six cells of 4.2 V. Given a resistance
    /// of 4 mOhm a cell has 3.7 + 0.24 V without load; not given one, at a throttle of 0.5, v1.12 adds 0.5
    /// times 0.3 V; v1.14's default is 5 mOhm, and so is what v1.16 begins with.
    #[test]
    fn reference_the_scale_is_that_of_each_versions_battery() {
        let measured = (22.2, Some(60.0));
        for (law, not_given_v) in [(Law::V1_12, 0.15), (Law::V1_14, 0.3), (Law::V1_16, 0.3)] {
            let untold = six_cells(&law);
            let given = Parameters { bat_r_internal_ohm: 0.004, ..untold.clone() };
            for (p, raised_v) in [(&given, 0.24), (&untold, not_given_v)] {
                let scale = settled(p, &law, measured, 0.5);
                let wanted = 4.2 / (3.7 + raised_v);
                assert!((scale - wanted).abs() < 1e-9, "{}: {scale}, {wanted}", law.since);
            }
            // Without a current: 0.5 times 0.3 V less what v1.12 reads as -1 A, 0.1 V, nothing.
            let without = settled(&given, &law, (22.2, None), 0.5);
            let raised_v = match law.cell_voltage {
                CellVoltage::RaisedByFilteredThrottle => -0.004,
                CellVoltage::RaisedByThrottle => 0.5 * 0.1,
                CellVoltage::RaisedThenFiltered => 0.0,
            };
            assert!((without - 4.2 / (3.7 + raised_v)).abs() < 1e-9, "{}: {without}", law.since);
        }
    }

    /// The scale ends at 1 and 1.3, up to v1.15 at an empty cell; of a number of cells that is not known
    /// nothing is scaled.
    #[test]
    fn closed_form_the_scale_has_ends() {
        for (law, at_15_v) in [(Law::V1_12, 4.2 / 3.3), (Law::V1_14, 4.2 / 3.3), (Law::V1_16, MOST)] {
            let p = Parameters { bat_r_internal_ohm: 0.0, ..six_cells(&law) };
            let at = |bus_v: f64| settled(&p, &law, (bus_v, Some(1.0)), 0.0);
            for (scale, wanted) in [(at(15.0), at_15_v), (at(25.2), 1.0), (at(30.0), 1.0)] {
                assert!((scale - wanted).abs() < 1e-9, "{}: {scale}, {wanted}", law.since);
            }
            let unknown = Parameters { bat_n_cells: 0.0, ..p };
            assert_eq!(settled(&unknown, &law, (15.0, Some(1.0)), 0.0), 1.0);
        }
    }

    /// A step of the voltage from 25.2 to 22.2 V is met by 1 - 1/e of it after a second.
    #[test]
    fn closed_form_the_voltage_is_filtered_for_a_second() {
        for law in [Law::V1_12, Law::V1_14, Law::V1_16] {
            let p = Parameters { bat_r_internal_ohm: 0.0, ..six_cells(&law) };
            let mut battery = BatteryScale::default();
            assert_eq!(battery.step(&p, &law, 25.2, Some(1.0), DT_S), 1.0);
            let scale = (0..250).fold(0.0, |_, _| battery.step(&p, &law, 22.2, Some(1.0), DT_S));
            let wanted = 4.2 / (4.2 - 0.5 * (1.0 - 1.0 / std::f64::consts::E));
            assert!((scale - wanted).abs() < 2e-4, "{}: {scale}, {wanted}", law.since);
        }
    }

    /// Thrust and torque are multiplied by the scale, 4.2/3.7 here, and from v1.14 on cut to 1; without a
    /// battery, or with the parameter at 0, nothing is.
    #[test]
    fn reference_thrust_and_torque_are_scaled() {
        let vehicle = quadrotor([0.95; 2], [890.0; 3], [0.0; 3], VehicleOptions::default());
        for law in [Law::V1_12, Law::V1_14, Law::V1_16] {
            let flown = |bat_scale_en: f64, bus_v: Option<f64>, collective: f64| {
                let p = Parameters { bat_scale_en, bat_r_internal_ohm: 0.0, ..six_cells(&law) };
                let mut controller = Px4Controller::new(p, 1.0, 1.0).with_law(law, &vehicle, 1.0);
                let m = Measurement { bus_v, pack_a: Some(1.0), ..at_rest(0.0, 0.0, 0.0) };
                let setpoint = Setpoint::Rates { omega_body: Vector3::y() * 0.1, collective };
                // The ramp of v1.12's outputs ends after 0.55 s.
                let steps = (0..200).map(|_| controller.step(&m, &setpoint, DT_S)).last();
                (steps.unwrap().collective_n, controller.trace().torque.y)
            };
            let scale = 4.2 / 3.7;
            let (plain, scaled) = (flown(0.0, Some(22.2), 0.5), flown(1.0, Some(22.2), 0.5));
            assert_eq!((plain, plain), (flown(0.0, None, 0.5), flown(1.0, None, 0.5)), "{}", law.since);
            assert!((scaled.1 / plain.1 - scale).abs() < 1e-9, "{}: {scaled:?} {plain:?}", law.since);
            // Four rotors whose thrust is the square of the command, near enough for a small torque.
            let thrust = |flown: (f64, f64)| (flown.0 / 4.0).sqrt();
            assert!((thrust(scaled) / thrust(plain) - scale).abs() < 4e-3, "{}", law.since);
            // Thrust is cut to 1, and gives way to the torque.
            let full = flown(1.0, Some(22.2), 0.95);
            assert!((0.97..1.0).contains(&thrust(full)), "{}: {full:?}", law.since);
        }
    }
}
