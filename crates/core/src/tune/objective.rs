//! The number that a search makes small, and the costs of flights that it is made of.

/// Costs of one flight, or the worst of several. Infinite throughout when a flight diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation {
    /// J_RMS, (45); 0 where tracking is not judged.
    pub rms: f64,
    /// J_TPF, (51).
    pub j_tpf: f64,
    /// 0 for a flight that has come to rest at the target a second before its end. Otherwise the distance of
    /// its velocity from the target at the end, at least 0.01, as a fraction of the target's size or, where
    /// that is larger, of the distance that is steady.
    pub unrest: f64,
}

impl Evaluation {
    /// Nothing amiss.
    pub const PERFECT: Self = Self { rms: 0.0, j_tpf: 0.0, unrest: 0.0 };
    /// A flight that was lost.
    pub const DIVERGED: Self = Self { rms: f64::INFINITY, j_tpf: f64::INFINITY, unrest: f64::INFINITY };

    /// The worse of two in each number.
    pub fn worse(self, other: Self) -> Self {
        if !(self.is_finite() && other.is_finite()) {
            return Self::DIVERGED;
        }
        Self {
            rms: self.rms.max(other.rms),
            j_tpf: self.j_tpf.max(other.j_tpf),
            unrest: self.unrest.max(other.unrest),
        }
    }

    /// Whether every flight came to its end.
    pub fn is_finite(&self) -> bool {
        self.rms.is_finite() && self.j_tpf.is_finite() && self.unrest.is_finite()
    }
}

/// Quantity that a search makes small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Objective {
    /// The paper's (46): the worst tracking RMS of the mission's cases.
    Rms,
    /// The worst J_TPF. Ill-posed alone: gains that never accelerate are safe and useless.
    JTpf,
    /// The worst J_TPF of gains that track as well as `rms_bound` and come to rest at the target.
    Safety {
        /// Largest worst RMS.
        rms_bound: f64,
        /// J_TPF that it costs to be over a bound by as much again ([`PENALTY`]).
        penalty: f64,
    },
}

/// One percent over a bound costs 0.02 of J_TPF. It must cost more than it gains, or the best gains lie
/// beyond the bounds: along the front of both, near the paper's RMS, a percent gains 0.01. It should not cost
/// much more: the valley along the bound gets as narrow as the penalty is steep, and a search loses its way
/// in it.
pub const PENALTY: f64 = 2.0;
/// Weight of tracking beside J_TPF: it decides where the release alone sets J_TPF, as on Earth.
const TIE: f64 = 0.01;

impl Objective {
    /// The cost: infinite for gains with a flight that diverged.
    pub fn cost(&self, e: &Evaluation) -> f64 {
        if !e.is_finite() {
            return f64::INFINITY;
        }
        match self {
            Self::Rms => e.rms,
            Self::JTpf => e.j_tpf,
            Self::Safety { rms_bound, penalty } => {
                let over = (e.rms / rms_bound - 1.0).max(0.0) + e.unrest;
                e.j_tpf + TIE * e.rms + penalty * over
            }
        }
    }

    /// The largest worst tracking RMS that is allowed, where there is a bound.
    pub fn rms_bound(&self) -> Option<f64> {
        match self {
            Self::Safety { rms_bound, .. } => Some(*rms_bound),
            Self::Rms | Self::JTpf => None,
        }
    }

    /// Whether the bounds hold.
    pub fn allows(&self, e: &Evaluation) -> bool {
        match self {
            Self::Safety { rms_bound, .. } => e.rms <= *rms_bound && e.unrest == 0.0,
            Self::Rms | Self::JTpf => e.is_finite(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_costs() {
        let e = Evaluation { rms: 0.4, j_tpf: 0.6, unrest: 0.01 };
        assert_eq!((Objective::Rms.cost(&e), Objective::JTpf.cost(&e)), (0.4, 0.6));
        let cost = |rms_bound| Objective::Safety { rms_bound, penalty: 10.0 }.cost(&e);
        assert!((cost(0.4) - 0.704).abs() < 1e-12 && (cost(0.32) - 3.204).abs() < 1e-12);
        assert!(!Objective::Safety { rms_bound: 0.5, penalty: PENALTY }.allows(&e));
        let lost = Evaluation { rms: f64::NAN, ..e };
        assert_eq!(Objective::JTpf.cost(&lost), f64::INFINITY);
    }
}
