//! Loss of interpolating plans on a grid against solving for each release: J_TPF of flights along both.

use super::chosen::quantile_rank;
use crate::units::RAD_PER_DEG;

/// Most that interpolating may add to the J_TPF of 99 % of the flights, each against its own.
pub const GRID_LOSS_MOST: f64 = 0.01;

/// Error of the pitch rate at t = 0 that interpolating is compared with [rad/s]: 0.1 deg/s.
pub const MISREAD_RATE_RAD_S: f64 = 0.1 * RAD_PER_DEG;

/// J_TPF of flights from one release along four plans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridFlight {
    /// Along the plan that was solved for the release.
    pub solved: f64,
    /// Along the plan that was interpolated for it.
    pub interpolated: f64,
    /// Along the plan that was solved for a pitch rate off by [`MISREAD_RATE_RAD_S`].
    pub misread: f64,
    /// Along the plan from the nominal release.
    pub nominal: f64,
}

impl GridFlight {
    /// What another plan than the solved one cost this flight: below 0 where it flew better, 0 where both
    /// were lost.
    fn loss(&self, j_tpf: f64) -> f64 {
        if j_tpf == self.solved { 0.0 } else { j_tpf - self.solved }
    }
}

/// Least, middle, 99 % and greatest of some numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The least.
    pub min: f64,
    /// What half of them do not exceed.
    pub p50: f64,
    /// What 99 % of them do not exceed.
    pub p99: f64,
    /// The greatest.
    pub max: f64,
}

impl Spread {
    /// Of these numbers; NaN of none.
    fn of(numbers: impl Iterator<Item = f64>) -> Self {
        let mut ascending: Vec<f64> = numbers.collect();
        ascending.sort_by(f64::total_cmp);
        let at = |p: f64| {
            let rank = quantile_rank(ascending.len(), p);
            rank.checked_sub(1).map_or(f64::NAN, |i| ascending[i])
        };
        Self {
            min: ascending.first().copied().unwrap_or(f64::NAN),
            p50: at(0.5),
            p99: at(0.99),
            max: at(1.0),
        }
    }
}

/// Flights from many releases, each along four plans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridLoss {
    /// Number of releases.
    pub releases: usize,
    /// J_TPF along the solved plans.
    pub solved: Spread,
    /// J_TPF along the interpolated plans.
    pub interpolated: Spread,
    /// J_TPF along the one nominal plan.
    pub nominal: Spread,
    /// J_TPF along the interpolated plan less that along the solved one, release by release.
    pub by_release: Spread,
    /// J_TPF along the plan solved for the misread pitch rate less that along the solved one, likewise: how
    /// far flights differ along plans that nobody can tell apart.
    pub misread: Spread,
}

impl GridLoss {
    /// Of these flights.
    pub fn of(flights: &[GridFlight]) -> Self {
        let spread = |of: fn(&GridFlight) -> f64| Spread::of(flights.iter().map(of));
        Self {
            releases: flights.len(),
            solved: spread(|flight| flight.solved),
            interpolated: spread(|flight| flight.interpolated),
            nominal: spread(|flight| flight.nominal),
            by_release: spread(|flight| flight.loss(flight.interpolated)),
            misread: spread(|flight| flight.loss(flight.misread)),
        }
    }

    /// Whether interpolating costs 99 % of the flights at most [`GRID_LOSS_MOST`], or no more than the
    /// misread pitch rate does.
    pub fn is_small(&self) -> bool {
        self.by_release.p99 <= GRID_LOSS_MOST.max(self.misread.p99)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 1 to 100 hundredths 99 do not exceed 0.99. A flight that is lost along both plans loses nothing,
    /// one that is lost along the interpolated one alone loses all.
    #[test]
    fn closed_form_loss() {
        let flight = |i: i32, misread: f64| {
            let solved = f64::from(i) / 100.0;
            let interpolated = solved + if i > 90 { 0.03125 } else { 0.0 };
            GridFlight { solved, interpolated, misread: solved + misread, nominal: 2.0 }
        };
        let flights = |misread: f64| (1..=100).rev().map(|i| flight(i, misread)).collect::<Vec<_>>();
        let loss = GridLoss::of(&flights(0.5));
        assert!(loss.is_small() && (loss.misread.min - 0.5).abs() < 1e-15);
        let mut flights = flights(0.0);
        let loss = GridLoss::of(&flights);
        assert_eq!((loss.releases, loss.solved.p50, loss.solved.p99, loss.solved.max), (100, 0.5, 0.99, 1.0));
        assert!(!loss.is_small() && loss.by_release.p50 == 0.0 && loss.misread.max == 0.0);
        assert!((loss.by_release.p99 - 0.03125).abs() < 1e-15 && loss.by_release.max >= loss.by_release.p99);
        assert_eq!((loss.nominal.min, loss.nominal.max), (2.0, 2.0));
        let lost = GridFlight { interpolated: f64::INFINITY, ..flights[0] };
        flights[0] = GridFlight { solved: f64::INFINITY, misread: f64::INFINITY, ..lost };
        assert!(GridLoss::of(&flights).by_release.max.is_finite());
        flights[..2].fill(lost);
        let lost = GridLoss::of(&flights);
        assert!(lost.by_release.max == f64::INFINITY && !lost.is_small());
        let none = GridLoss::of(&[]);
        assert!(none.releases == 0 && none.solved.min.is_nan());
    }
}
