//! A flight as a log has it: what was measured and commanded, by quantity, whatever it was logged by.
//!
//! | file | holds |
//! |---|---|
//! | this one | series, and the quantities of a flight |
//! | `of_ulog` | where PX4's topics of v1.12 to v1.18 have them |
//! | `commands` | what the rotors were commanded, as shares of the full throttle |
//! | [`columns`](mod@columns) | columns of a table under names that are known |
//! | [`phases`] | when it stood, hung, fell, hovered, manoeuvred |
//! | [`tells`] | what such a log can tell of its vehicle, and why not |

pub mod columns;
mod commands;
mod of_ulog;
pub mod phases;
pub mod tells;

#[cfg(test)]
mod tests;

/// Rotors that are looked at, at most.
pub const MOST_ROTORS: usize = 8;

/// Values in the order of their times.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<const N: usize> {
    /// Topic and columns that were read: `vehicle_acceleration.xyz`.
    pub from: &'static str,
    /// Times since the log's start [s], rising.
    pub t_s: Vec<f64>,
    /// The values; NaN where there is none.
    pub values: Vec<[f64; N]>,
}

impl<const N: usize> Series<N> {
    /// A series without values.
    pub fn empty(from: &'static str) -> Self {
        Self { from, t_s: Vec::new(), values: Vec::new() }
    }

    /// Puts a value behind the others.
    pub fn put(&mut self, t_s: f64, value: [f64; N]) {
        self.t_s.push(t_s);
        self.values.push(value);
    }

    /// How often there is a value, by the median of the intervals [Hz]; NaN of fewer than two.
    pub fn rate_hz(&self) -> f64 {
        1.0 / self.intervals().map_or(f64::NAN, |sorted| sorted[sorted.len() / 2])
    }

    /// The longest time without a value [s]; NaN of fewer than two.
    pub fn longest_gap_s(&self) -> f64 {
        self.intervals().and_then(|sorted| sorted.last().copied()).unwrap_or(f64::NAN)
    }

    /// Times between values [s], the shortest first; `None` where there are none.
    fn intervals(&self) -> Option<Vec<f64>> {
        let mut intervals: Vec<f64> = self.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        intervals.sort_by(f64::total_cmp);
        (!intervals.is_empty()).then_some(intervals)
    }

    /// The newest value that is no later than a time [s].
    pub fn at(&self, t_s: f64) -> Option<&[f64; N]> {
        let behind = self.t_s.partition_point(|t| *t <= t_s);
        self.values.get(behind.checked_sub(1)?)
    }

    /// How many of the columns, from the first on, are commanded one thing and then another.
    pub fn moved(&self) -> usize {
        let moves = |column: &usize| {
            let values = || self.values.iter().filter_map(|row| row.get(*column)).filter(|x| x.is_finite());
            values().copied().fold(f64::INFINITY, f64::min)
                < values().copied().fold(f64::NEG_INFINITY, f64::max)
        };
        (0..N).filter(moves).count()
    }

    /// The values at a time [s], linearly between those before and behind, the last ones held; `None` where
    /// those are further away than so long [s], or no numbers. Of quaternions it is the shorter way, not
    /// normalised.
    pub fn linear(&self, t_s: f64, apart_s: f64) -> Option<[f64; N]> {
        let behind = self.t_s.partition_point(|t| *t <= t_s);
        let before = behind.checked_sub(1)?;
        let (from_s, a) = (*self.t_s.get(before)?, self.values.get(before)?);
        let (to_s, b) = (*self.t_s.get(behind).unwrap_or(&from_s), self.values.get(behind).unwrap_or(a));
        let share = if to_s > from_s { (t_s - from_s) / (to_s - from_s) } else { 0.0 };
        // Quaternions of either sign are one attitude.
        let is_turned = N == 4 && a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() < 0.0;
        let sign = if is_turned { -1.0 } else { 1.0 };
        let mixed = std::array::from_fn(|i| a[i] + share * (sign * b[i] - a[i]));
        let is_near = to_s - from_s <= apart_s && t_s - from_s <= apart_s;
        (is_near && mixed.iter().all(|x: &f64| x.is_finite())).then_some(mixed)
    }

    /// The values between two times [s].
    pub fn between(&self, from_s: f64, to_s: f64) -> &[[f64; N]] {
        let (from, to) =
            (self.t_s.partition_point(|t| *t < from_s), self.t_s.partition_point(|t| *t <= to_s));
        self.values.get(from..to.max(from)).unwrap_or_default()
    }
}

/// What a log has of a flight. Body axes are forward, right, down; local ones north, east, down.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedFlight {
    /// Throttles of the rotors in their order, 0..1, as the speed controllers were told; NaN beyond their
    /// number.
    pub motors: Option<Series<MOST_ROTORS>>,
    /// Commanded thrust along the body's axes, as a share of the greatest.
    pub thrust: Option<Series<3>>,
    /// Specific force in body axes [m/s^2].
    pub force_body_m_s2: Option<Series<3>>,
    /// Angular rates in body axes [rad/s].
    pub rates_body_rad_s: Option<Series<3>>,
    /// Attitude: quaternion from body to local axes, scalar first.
    pub attitude: Option<Series<4>>,
    /// Velocity in local axes [m/s].
    pub velocity_ned_m_s: Option<Series<3>>,
    /// Position in local axes [m].
    pub position_ned_m: Option<Series<3>>,
    /// Velocity that the velocity loop was asked for, local axes [m/s]; NaN where it was not asked.
    pub velocity_sp_ned_m_s: Option<Series<3>>,
    /// Speeds of the rotors in their order [rad/s], as the speed controllers reported them.
    pub rotor_speeds_rad_s: Option<Series<MOST_ROTORS>>,
    /// Density of the air [kg/m^3].
    pub density_kg_m3: Option<Series<1>>,
    /// Bus voltage [V] and current [A].
    pub battery: Option<Series<2>>,
    /// Whether it was armed: 1 or 0.
    pub armed: Option<Series<1>>,
    /// Whether it stood on the ground, by its own land detector: 1 or 0.
    pub landed: Option<Series<1>>,
}

impl LoggedFlight {
    /// Time of the last value of any of its series since the log's start [s]; 0 without any.
    pub fn end_s(&self) -> f64 {
        fn end<const N: usize>(series: Option<&Series<N>>) -> f64 {
            series.and_then(|series| series.t_s.last().copied()).unwrap_or(0.0)
        }
        let ends = [
            end(self.motors.as_ref()),
            end(self.thrust.as_ref()),
            end(self.force_body_m_s2.as_ref()),
            end(self.rates_body_rad_s.as_ref()),
            end(self.attitude.as_ref()),
            end(self.velocity_ned_m_s.as_ref()),
            end(self.position_ned_m.as_ref()),
            end(self.velocity_sp_ned_m_s.as_ref()),
            end(self.rotor_speeds_rad_s.as_ref()),
            end(self.density_kg_m3.as_ref()),
            end(self.battery.as_ref()),
            end(self.armed.as_ref()),
            end(self.landed.as_ref()),
        ];
        ends.into_iter().fold(0.0, f64::max)
    }
}
