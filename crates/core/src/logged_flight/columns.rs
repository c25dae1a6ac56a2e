//! A flight out of columns of a table under names that are known, those of `flight.csv`: its own, a motion
//! capture's or another autopilot's.

use nalgebra::Vector3;

use super::{LoggedFlight, MOST_ROTORS, Series};
use crate::frames::rotate_body_from_ned;
use crate::units::STANDARD_GRAVITY_M_S2;

/// Names of columns that are read, each group as a whole or not at all.
pub const KNOWN: &str = "t_s; throttle_1, ..; rotor_speed_1_rad_s, ..; fx_m_s2, fy_m_s2, fz_m_s2 (specific force, \
                         body axes) or an_m_s2, ae_m_s2, ad_m_s2 (acceleration) with q0 .. q3; p_rad_s, q_rad_s, \
                         r_rad_s; q0, q1, q2, q3; vn_m_s, ve_m_s, vd_m_s; north_m, east_m, down_m; density_kg_m3; \
                         armed; landed";

/// The flight of a table's columns, found by name; `None` without times. Rows whose time does not rise are
/// left out.
pub fn flight<'c>(column: impl Fn(&str) -> Option<&'c [f64]>) -> Option<LoggedFlight> {
    let table = Table::of(column("t_s")?, column);
    let attitude = table.of_names(["q0", "q1", "q2", "q3"]);
    let force = table.of_names(["fx_m_s2", "fy_m_s2", "fz_m_s2"]);
    let accelerated = || Some(felt(table.of_names(["an_m_s2", "ae_m_s2", "ad_m_s2"])?, attitude.as_ref()?));
    Some(LoggedFlight {
        motors: table.of_rotors("throttle", |rotor| format!("throttle_{rotor}")),
        rotor_speeds_rad_s: table.of_rotors("rotor_speed", |rotor| format!("rotor_speed_{rotor}_rad_s")),
        force_body_m_s2: force.or_else(accelerated),
        rates_body_rad_s: table.of_names(["p_rad_s", "q_rad_s", "r_rad_s"]),
        velocity_ned_m_s: table.of_names(["vn_m_s", "ve_m_s", "vd_m_s"]),
        position_ned_m: table.of_names(["north_m", "east_m", "down_m"]),
        density_kg_m3: table.of_names(["density_kg_m3"]),
        armed: table.of_names(["armed"]),
        landed: table.of_names(["landed"]),
        attitude,
        ..LoggedFlight::default()
    })
}

/// Specific force of an acceleration at an attitude, under standard gravity.
fn felt(acceleration: Series<3>, attitude: &Series<4>) -> Series<3> {
    let of = |(t_s, a_ned): (&f64, &[f64; 3])| {
        let [north, east, down] = *a_ned;
        let q = attitude.at(*t_s).copied().unwrap_or([f64::NAN; 4]);
        let f_body = rotate_body_from_ned(q, Vector3::new(north, east, down - STANDARD_GRAVITY_M_S2));
        [f_body.x, f_body.y, f_body.z]
    };
    Series { values: acceleration.t_s.iter().zip(&acceleration.values).map(of).collect(), ..acceleration }
}

/// Columns, and their rows whose times rise.
struct Table<'c, C: Fn(&str) -> Option<&'c [f64]>> {
    column: C,
    t_s: Vec<f64>,
    rows: Vec<usize>,
}

impl<'c, C: Fn(&str) -> Option<&'c [f64]>> Table<'c, C> {
    fn of(times: &[f64], column: C) -> Self {
        let mut table = Self { column, t_s: Vec::new(), rows: Vec::new() };
        let mut newest = f64::NEG_INFINITY;
        let from_s = times.iter().copied().find(|t_s| t_s.is_finite()).unwrap_or(0.0);
        for (row, t_s) in times.iter().enumerate() {
            if *t_s > newest {
                newest = *t_s;
                table.t_s.push(t_s - from_s);
                table.rows.push(row);
            }
        }
        table
    }

    /// Columns that are all there.
    fn of_names<const N: usize>(&self, names: [&'static str; N]) -> Option<Series<N>> {
        let mut columns = [&[][..]; N];
        for (found, name) in columns.iter_mut().zip(names) {
            *found = (self.column)(name)?;
        }
        Some(self.series(names[0], columns))
    }

    /// A column for each rotor, as far as there are some.
    fn of_rotors(&self, from: &'static str, name: impl Fn(usize) -> String) -> Option<Series<MOST_ROTORS>> {
        let mut columns = [&[][..]; MOST_ROTORS];
        for (rotor, found) in columns.iter_mut().enumerate() {
            *found = (self.column)(&name(rotor + 1)).unwrap_or_default();
        }
        (!columns[0].is_empty()).then(|| self.series(from, columns))
    }

    fn series<const N: usize>(&self, from: &'static str, columns: [&[f64]; N]) -> Series<N> {
        let mut series = Series { from, t_s: Vec::new(), values: Vec::new() };
        for (row, t_s) in self.rows.iter().zip(&self.t_s) {
            let values = columns.map(|column| column.get(*row).copied().unwrap_or(f64::NAN));
            // Rows of other columns alone are none of these.
            if values.iter().any(|x| x.is_finite()) {
                series.t_s.push(*t_s);
                series.values.push(values);
            }
        }
        series
    }
}
