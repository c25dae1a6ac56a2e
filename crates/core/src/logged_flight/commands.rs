//! What the rotors were commanded, as throttles: shares of the full speed that a speed controller was told.
//!
//! PX4 logs commands twice: `actuator_motors` are shares of the thrust, before THR_MDL_FAC bends them;
//! `actuator_outputs` are what leaves the board, pulse widths on a vehicle and shares in a simulator.

use std::collections::BTreeMap;

use super::{MOST_ROTORS, Series};
use crate::ulog::Parameter;

type Parameters = BTreeMap<String, Parameter>;

/// Greater ones are pulse widths [us].
const LARGEST_SHARE: f64 = 2.0;
/// Pulse widths of throttle 0 and 1 where no parameter has them [us].
const PULSES_US: [f64; 2] = [1000.0, 2000.0];
/// Outputs whose parameters name what they drive.
const BANKS: [&str; 2] = ["MAIN", "AUX"];
/// PWM_MAIN_FUNCn of the first motor.
const FIRST_MOTOR: f64 = 101.0;
/// What is logged this much more often is taken.
const QUICKER: f64 = 1.5;

/// Throttles out of commanded shares of the thrust and of what left the board: of the latter where thrusts
/// are bent on the way, and of what is logged more often.
pub(super) fn throttles(
    parameters: &Parameters,
    commanded: Option<Series<MOST_ROTORS>>,
    put_out: Option<Series<MOST_ROTORS>>,
) -> Option<Series<MOST_ROTORS>> {
    let put_out = put_out.map(|series| of_outputs(parameters, series));
    let factor = real(parameters, "THR_MDL_FAC").unwrap_or(0.0);
    match (commanded, put_out) {
        (Some(commanded), Some(put_out)) => {
            let needed = if factor > 0.0 { 1.0 / QUICKER } else { QUICKER };
            if put_out.rate_hz() > needed * commanded.rate_hz() {
                Some(put_out)
            } else {
                Some(unbent(factor, commanded))
            }
        }
        (Some(commanded), None) => Some(unbent(factor, commanded)),
        (None, put_out) => put_out,
    }
}

fn real(parameters: &Parameters, name: &str) -> Option<f64> {
    parameters.get(name).map(|parameter| match parameter {
        Parameter::Int(value) => f64::from(*value),
        Parameter::Real(value) => f64::from(*value),
    })
}

/// `thrust = f throttle^2 + (1 - f) throttle`, PX4's THR_MDL_FAC, solved for the throttle.
fn unbent(factor: f64, mut series: Series<MOST_ROTORS>) -> Series<MOST_ROTORS> {
    if factor > 0.0 {
        for thrust in series.values.iter_mut().flatten() {
            let linear = 1.0 - factor;
            let root = (linear * linear + 4.0 * factor * thrust.max(0.0)).sqrt();
            *thrust = (root - linear) / (2.0 * factor);
        }
    }
    series
}

/// Throttles of outputs: in the order of the motors that the parameters name, between the pulse widths that
/// they have.
fn of_outputs(parameters: &Parameters, mut series: Series<MOST_ROTORS>) -> Series<MOST_ROTORS> {
    let largest = series.values.iter().flatten().copied().filter(|x| x.is_finite()).fold(0.0, f64::max);
    if largest <= LARGEST_SHARE {
        return series;
    }
    let columns = BANKS.into_iter().find_map(|bank| motors_of(parameters, bank));
    let columns = columns.unwrap_or_else(|| {
        std::array::from_fn(|column| Some((column, pulses_us(parameters, "MAIN", column))))
    });
    for row in &mut series.values {
        let outputs = *row;
        for (throttle, column) in row.iter_mut().zip(&columns) {
            *throttle = column.map_or(f64::NAN, |(column, [stop_us, full_us])| {
                ((outputs.get(column).copied().unwrap_or(f64::NAN) - stop_us) / (full_us - stop_us)).max(0.0)
            });
        }
    }
    series
}

/// Column and pulse widths [us] of each motor.
type Columns = [Option<(usize, [f64; 2])>; MOST_ROTORS];

/// The columns of a bank that drive motors, in the motors' order; `None` where none does.
fn motors_of(parameters: &Parameters, bank: &str) -> Option<Columns> {
    let mut columns: Columns = [None; MOST_ROTORS];
    for column in 0..MOST_ROTORS {
        let function = real(parameters, &format!("PWM_{bank}_FUNC{}", column + 1)).unwrap_or(0.0);
        let motor = function - FIRST_MOTOR;
        if (0.0..MOST_ROTORS as f64).contains(&motor) {
            columns[motor as usize] = Some((column, pulses_us(parameters, bank, column)));
        }
    }
    columns[0].is_some().then_some(columns)
}

/// Pulse widths of throttle 0 and 1 of a column [us], by its own parameters, the bank's or all outputs'.
fn pulses_us(parameters: &Parameters, bank: &str, column: usize) -> [f64; 2] {
    let number = column + 1;
    let find = |end: &str, default: f64| {
        let names = [format!("PWM_{bank}_{end}{number}"), format!("PWM_{bank}_{end}"), format!("PWM_{end}")];
        names.iter().filter_map(|name| real(parameters, name)).find(|us| *us > 0.0).unwrap_or(default)
    };
    let [stop_us, full_us] = [find("MIN", PULSES_US[0]), find("MAX", PULSES_US[1])];
    if full_us > stop_us { [stop_us, full_us] } else { PULSES_US }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(from: &'static str, hz: f64, row: [f64; MOST_ROTORS]) -> Option<Series<MOST_ROTORS>> {
        let t_s = (0..10).map(|i| f64::from(i) / hz).collect();
        Some(Series { from, t_s, values: vec![row; 10] })
    }

    /// By hand: pulse widths between those of the parameters, in the order of the motors that these name.
    #[test]
    fn closed_form_pulse_widths_become_throttles() {
        let parameters = [
            ("PWM_AUX_FUNC1", Parameter::Int(102)),
            ("PWM_AUX_FUNC3", Parameter::Int(101)),
            ("PWM_AUX_MIN3", Parameter::Int(1100)),
            ("PWM_AUX_MAX3", Parameter::Int(1900)),
        ];
        let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
        let widths = [1250.0, 900.0, 1500.0, 900.0, 0.0, 0.0, 0.0, 0.0];
        let found = throttles(&parameters, None, series("out", 50.0, widths)).unwrap();
        assert_eq!(found.values[0][..2], [0.5, 0.25]);
        assert!(found.values[0][2].is_nan());
        let found = throttles(&Parameters::new(), None, series("out", 50.0, widths)).unwrap();
        assert_eq!(found.values[0][..3], [0.25, 0.0, 0.5]);
    }

    /// By hand: 0.3 u^2 + 0.7 u at u = 0.5 is 0.425; what leaves the board is taken as it is, if it is there
    /// as often.
    #[test]
    fn closed_form_bent_thrusts_become_throttles() {
        let parameters = [("THR_MDL_FAC".to_owned(), Parameter::Real(0.3))].into();
        let row = [0.425; MOST_ROTORS];
        let alone = throttles(&parameters, series("in", 50.0, row), None).unwrap();
        assert!((alone.values[0][0] - 0.5).abs() < 1e-7);
        let both = |hz| {
            throttles(&parameters, series("in", 50.0, row), series("out", hz, [0.5; MOST_ROTORS]))
                .unwrap()
                .from
        };
        assert_eq!([both(50.0), both(10.0)], ["out", "in"]);
        let straight =
            throttles(&Parameters::new(), series("in", 50.0, row), series("out", 50.0, row)).unwrap();
        assert_eq!((straight.from, straight.values[0]), ("in", row));
    }
}
