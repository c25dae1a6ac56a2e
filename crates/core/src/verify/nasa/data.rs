//! The published results, each 5 s of their 30 s: NASA/TM-2015-218675, atmospheric cases 2, 3 and 4 (public
//! domain).
//!
//! Simulation 4 of cases 2 and 4, simulation 5 of case 3, as anonymised there. Angles are against NED, which
//! turns with the Earth; rates are against inertial space.

/// A state at a time, in the quantities and units of the report.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedState {
    /// Time [s].
    pub t_s: f64,
    /// Altitude above mean sea level [ft].
    pub altitude_ft: f64,
    /// Speed towards the Earth [ft/s].
    pub speed_down_ft_s: f64,
    /// Roll, pitch, yaw [deg].
    pub euler_deg: [f64; 3],
    /// Body rates against inertial space [deg/s].
    pub omega_deg_s: [f64; 3],
    /// Density of the air [slug/ft^3].
    pub density_slug_ft3: f64,
}

/// Case and [`PublishedState`], a line each.
const PUBLISHED: &str = include_str!("check_cases.csv");

/// The published states of a case.
pub fn published(case: u8) -> Vec<PublishedState> {
    let row = |[t_s, altitude_ft, speed_down_ft_s, roll, pitch, yaw, p, q, r, density_slug_ft3]: [f64;
                   10]| PublishedState {
        t_s,
        altitude_ft,
        speed_down_ft_s,
        euler_deg: [roll, pitch, yaw],
        omega_deg_s: [p, q, r],
        density_slug_ft3,
    };
    rows_of(PUBLISHED, case).map(row).collect()
}

/// The numbers behind the case's own in the lines of a case. What is no number in the text, or missing, is
/// NaN, with which no check holds.
pub(super) fn rows_of<const N: usize>(text: &str, case: u8) -> impl Iterator<Item = [f64; N]> {
    text.lines().filter_map(move |line| {
        let mut numbers = line.split(',').map(|x| x.parse().unwrap_or(f64::NAN));
        let mut next = || numbers.next().unwrap_or(f64::NAN);
        (next() == f64::from(case)).then(|| std::array::from_fn(|_| next()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_has_a_row_each_5_s_and_begins_with_the_same_rates() {
        for case in [2, 3, 4] {
            let rows = published(case);
            assert!(
                rows.iter().map(|r| r.t_s).eq([0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0]),
                "{case}: {rows:?}"
            );
            assert_eq!(rows[0].omega_deg_s, [10.0, 20.0, 30.0]);
            assert!(
                rows.iter().all(|r| r.density_slug_ft3 > 8e-4 && r.euler_deg.iter().all(|x| x.is_finite()))
            );
        }
    }
}
