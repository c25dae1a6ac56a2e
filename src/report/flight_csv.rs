//! The flight log as CSV: one row per sample - time, state, setpoint, commands, rotors, J_state and every
//! term of the balance of forces.
//!
//! Comment lines at the top hold version, seed and the hash of the inputs; the header row names each column
//! with its unit (attitude, throttle and J_state have none). A field is empty where it has no value: the
//! plan's time before the release, the setpoint while there is none. Numbers are the shortest that read back
//! to the same bits.
//!
//! The sums to check: `m a_ned = C^T (rotor + aero) + gravity + canopy + ground` and
//! `J omega_dot = rotor_m + aero_m + reaction_m + gyro_m + ground_m - omega x J omega`.

use std::fmt::Write as _;
use std::io::{self, Write};

use nalgebra::Vector3;

use crate::assess::{SafetyLimits, StateCost};
use crate::config::Mission;
use crate::model::{ForceBalance, MAX_ROTORS, PerRotor};
use crate::sim::{Phase, Sample};

const STATE: &str = "t_s,t_powered_s,phase,north_m,east_m,down_m,q0,q1,q2,q3,vn_m_s,ve_m_s,vd_m_s,p_rad_s,q_rad_s,r_rad_s,\
                     an_m_s2,ae_m_s2,ad_m_s2,vn_sp_m_s,ve_sp_m_s,vd_sp_m_s,j_state";
/// A quantity of each rotor: the columns' name and unit, and the values.
type PerRotorColumns = (&'static str, &'static str, fn(&Sample) -> &PerRotor);
const PER_ROTOR: [PerRotorColumns; 4] = [
    ("throttle", "", |s| &s.throttle),
    ("rotor_speed", "_rad_s", |s| &s.state.rotor_speed),
    ("thrust", "_n", |s| &s.balance.thrust_n),
    ("torque", "_nm", |s| &s.balance.torque_nm),
];

/// A vector of the balance of forces and moments: the columns' name, letters of the axes and unit, and the
/// vector.
type VectorColumns = (&'static str, [char; 3], &'static str, fn(&ForceBalance) -> &Vector3<f64>);
const BODY: [char; 3] = ['x', 'y', 'z'];
const NED: [char; 3] = ['n', 'e', 'd'];
const BALANCE: [VectorColumns; 8] = [
    ("rotor_f", BODY, "_n", |b| &b.rotor_force_body),
    ("aero_f", BODY, "_n", |b| &b.aero_force_body),
    ("gravity_f", NED, "_n", |b| &b.gravity_force_ned),
    ("canopy_f", NED, "_n", |b| &b.canopy_force_ned),
    ("rotor_m", BODY, "_nm", |b| &b.rotor_moment_body),
    ("aero_m", BODY, "_nm", |b| &b.aero_moment_body),
    ("reaction_m", BODY, "_nm", |b| &b.reaction_moment_body),
    ("gyro_m", BODY, "_nm", |b| &b.gyro_moment_body),
];
/// Further vectors of a mission with ground.
const GROUND: [VectorColumns; 2] =
    [("ground_f", NED, "_n", |b| &b.ground_force_ned), ("ground_m", BODY, "_nm", |b| &b.ground_moment_body)];

fn vectors(ground: bool) -> impl Iterator<Item = &'static VectorColumns> {
    BALANCE.iter().chain(GROUND.iter().filter(move |_| ground))
}

/// Writes a flight log, row by row.
#[derive(Debug)]
pub struct FlightCsv<W: Write> {
    out: W,
    n_rotors: usize,
    /// Give J_state its scale.
    limits: SafetyLimits,
    ground: bool,
    row: String,
}

impl<W: Write> FlightCsv<W> {
    /// Begins the file of a mission's flight: comment lines and header. `out` should be buffered; `ground`:
    /// whether there are columns of the forces of the ground.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn new(mut out: W, mission: &Mission, ground: bool) -> io::Result<Self> {
        let n_rotors = mission.vehicle.rotors.len().min(MAX_ROTORS);
        let mut header = format!("{}{STATE}", mission.stamp().csv_comment());
        for (name, unit, _) in PER_ROTOR {
            for i in 1..=n_rotors {
                header += &format!(",{name}_{i}{unit}");
            }
        }
        for (name, axes, unit, _) in vectors(ground) {
            for axis in axes {
                header += &format!(",{name}{axis}{unit}");
            }
        }
        writeln!(out, "{header}")?;
        let limits = mission.limits.safety;
        Ok(Self { out, n_rotors, limits, ground, row: String::with_capacity(2048) })
    }

    /// Writes a sample.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn write(&mut self, sample: &Sample) -> io::Result<()> {
        self.row.clear();
        self.write_state(sample);
        for (.., values) in PER_ROTOR {
            self.numbers(&values(sample)[..self.n_rotors]);
        }
        for (.., vector) in vectors(self.ground) {
            self.numbers(vector(&sample.balance).as_slice());
        }
        self.row.pop();
        self.row.push('\n');
        self.out.write_all(self.row.as_bytes())
    }

    /// Ends the file and returns the output, flushed.
    ///
    /// # Errors
    /// Errors of the output.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }

    fn write_state(&mut self, sample: &Sample) {
        let body = &sample.state.body;
        self.number(sample.t_s);
        match sample.t_powered_s {
            Some(t) => self.number(t),
            None => self.row.push(','),
        }
        self.row.push_str(phase_name(sample.phase));
        self.row.push(',');
        self.numbers(body.p_ned.as_slice());
        self.numbers(&body.q_ned_from_body);
        self.numbers(body.v_ned.as_slice());
        self.numbers(body.omega_body.as_slice());
        self.numbers(sample.a_ned.as_slice());
        match sample.v_sp_ned {
            Some(v) => self.numbers(v.as_slice()),
            None => self.row.push_str(",,,"),
        }
        self.number(StateCost::of(body, &self.limits).max());
    }

    fn numbers(&mut self, values: &[f64]) {
        for &x in values {
            self.number(x);
        }
    }

    /// Appends a number and a comma.
    fn number(&mut self, x: f64) {
        push_number(&mut self.row, x);
        self.row.push(',');
    }
}

/// Appends the shortest text that reads back to the same number, as `{:?}` does; -0 as 0.
fn push_number(row: &mut String, x: f64) {
    if x == 0.0 {
        // Most fields of a flight in the plane.
        row.push_str("0.0");
    } else if (1e-5..1e-4).contains(&x.abs()) {
        // `{:?}` has an exponent here, ryu has none. Writing to a String cannot fail.
        let _ = write!(row, "{x:?}");
    } else {
        row.push_str(ryu::Buffer::new().format(x));
    }
}

fn phase_name(phase: Phase) -> &'static str {
    match phase {
        Phase::Hanging => "hanging",
        Phase::Falling => "falling",
        Phase::Powered => "powered",
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::push_number;

    proptest! {
        /// The shortest text that reads back to the same bits, as `{:?}` writes it; where a number lies
        /// halfway between two such texts (0.92639923095703125), either.
        #[test]
        fn prop_a_number_is_written_as_debug_writes_it(x in any::<f64>(), exponent in -30..30i32) {
            let power = 10f64.powi(exponent);
            for x in [x, 1.0 / x, (x % 1.0) * power, power, f64::from(exponent), f64::from(x as f32)] {
                let mut row = String::new();
                push_number(&mut row, x);
                let wanted = if x == 0.0 { "0.0".to_owned() } else { format!("{x:?}") };
                if row != wanted {
                    prop_assert_eq!(row.parse::<f64>().map(f64::to_bits), Ok(x.to_bits()));
                    let but_last_digit = |text: &str| {
                        let (digits, exponent) = text.split_at(text.find('e').unwrap_or(text.len()));
                        (digits[..digits.len() - 1].to_owned(), exponent.to_owned())
                    };
                    prop_assert_eq!(but_last_digit(&row), but_last_digit(&wanted));
                }
            }
        }
    }
}
