//! Gains on flights that the tuning never saw, and which of them are best.
//!
//! The rule is the same whatever was tuned, and on what: gains must **hold the bounds** on the mission's
//! release cases with real actuators - track no worse than the bound and come to rest at the target in every
//! case; J_TPF alone would choose gains that never accelerate. Of those that do, the best have the lowest
//! worst J_TPF on the unseen flights, or on the varied ones when the tuning was for them; of equals, those
//! that track better.

use super::gains_table;
use crate::assess::Summary;
use crate::report::columns::columns;
use crate::tune::{Evaluation, Longitudinal, Objective};

/// J_TPF at which a limit is reached.
const LIMIT: f64 = 1.0;

/// Statistics of J_TPF over many flights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Number of flights.
    pub trials: usize,
    /// Mean of J_TPF.
    pub mean: f64,
    /// Standard deviation of J_TPF (n - 1).
    pub std: f64,
    /// Highest J_TPF.
    pub worst: f64,
    /// Share of the flights that stayed within every limit.
    pub p_safe: f64,
}

impl Sample {
    /// The statistics of these flights.
    pub fn of(flights: &[Evaluation]) -> Self {
        let mut summary = Summary::default();
        flights.iter().for_each(|e| summary.push(e.j_tpf));
        let safe = flights.iter().filter(|e| e.j_tpf <= LIMIT).count();
        Self {
            trials: flights.len(),
            mean: summary.mean(),
            std: summary.std(),
            worst: flights.iter().map(|e| e.j_tpf).fold(0.0, f64::max),
            p_safe: safe as f64 / flights.len() as f64,
        }
    }
}

/// A set of gains and its results.
#[derive(Clone, Debug, PartialEq)]
pub struct Contender {
    /// Name of the gains.
    pub name: String,
    /// The gains of the longitudinal loops.
    pub k: Longitudinal,
    /// Worst of the tuning's flights; infinite when one of them diverged.
    pub tuning: Evaluation,
    /// Worst of the release cases, with real actuators.
    pub cases: Evaluation,
    /// Results on random releases.
    pub unseen: Sample,
    /// Results on the same releases, each with mass, air, wind and delays of its own that the controller does
    /// not know.
    pub varied: Sample,
}

/// Sets of gains, compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Contest {
    /// The gains to compare with, and last the gains found.
    pub contenders: Vec<Contender>,
    /// Bounds that the release cases must hold.
    pub bounds: Objective,
    /// Whether the varied flights decide.
    pub robust: bool,
}

impl Contest {
    /// Whether a set of gains holds the bounds.
    pub fn allows(&self, c: &Contender) -> bool {
        c.cases.is_finite() && self.bounds.allows(&c.cases)
    }

    /// The best gains by the rule; `None` when none hold the bounds.
    pub fn best(&self) -> Option<&Contender> {
        let order = |c: &Contender| (if self.robust { c.varied.worst } else { c.unseen.worst }, c.cases.rms);
        self.contenders.iter().filter(|c| self.allows(c)).min_by(|a, b| {
            let (a, b) = (order(a), order(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    }

    /// The comparison as text for the terminal.
    pub fn text(&self) -> String {
        const WIDTHS: [usize; 12] = [14, 7, 7, 7, 7, 9, 7, 7, 9, 7, 7, 8];
        let sets: Vec<_> = self.contenders.iter().map(|c| (c.name.as_str(), c.k)).collect();
        let trials = self.contenders.first().map_or(0, |c| c.unseen.trials);
        let unseen = format!("J_TPF, {trials} unseen");
        let groups = ["", "tuning's flights", "release cases", &unseen, "J_TPF, the same varied", "within"];
        let heads =
            ["RMS", "J_TPF", "RMS", "at rest", "worst", "mean", "std", "worst", "mean", "std", "limits"];
        let mut out = gains_table(&sets) + "\n" + &columns(&[14, 15, 15, 25, 25, 8], groups);
        out += &columns(&WIDTHS, ["gains"].into_iter().chain(heads));
        for c in &self.contenders {
            let mut cells = vec![c.name.clone()];
            cells.extend([c.tuning.rms, c.tuning.j_tpf, c.cases.rms].map(fixed));
            cells.push(if c.cases.unrest == 0.0 { "yes" } else { "no" }.to_owned());
            for s in [&c.unseen, &c.varied] {
                cells.extend([s.worst, s.mean, s.std].map(fixed));
            }
            cells.push(format!("{:.1}%", 50.0 * (c.unseen.p_safe + c.varied.p_safe)));
            out += &columns(&WIDTHS, cells);
        }
        out + "\n" + &self.verdict()
    }

    /// The best gains, and why not the others.
    fn verdict(&self) -> String {
        let flights = if self.robust { "varied" } else { "unseen" };
        let mut bound = "come to rest at the target in every release case".to_owned();
        if let Objective::Safety { rms_bound, .. } = self.bounds
            && rms_bound.is_finite()
        {
            bound = format!("track within an RMS of {rms_bound:.4} and {bound}");
        }
        let mut out = match self.best() {
            Some(c) => format!(
                "best: {}, of those that {bound} the lowest worst J_TPF on the {flights} flights\n",
                c.name
            ),
            None => format!("best: none, for none of them {bound}\n"),
        };
        let others: Vec<&str> =
            self.contenders.iter().filter(|c| !self.allows(c)).map(|c| c.name.as_str()).collect();
        if !others.is_empty() && others.len() < self.contenders.len() {
            out += &format!("that do not: {}\n", others.join(", "));
        }
        out
    }
}

fn fixed(x: f64) -> String {
    if x.is_finite() { format!("{x:.4}") } else { "lost".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contender(name: &str, cases: Evaluation, unseen: f64, varied: f64) -> Contender {
        let sample = |worst| Sample { trials: 10, mean: worst, std: 0.0, worst, p_safe: 1.0 };
        let (unseen, varied) = (sample(unseen), sample(varied));
        Contender { name: name.to_owned(), k: [1.0; 7], tuning: cases, cases, unseen, varied }
    }

    /// Gains that never accelerate are safest of all, and gains that never come to rest track well: neither
    /// wins.
    #[test]
    fn the_safest_gains_that_hold_the_bounds_win() {
        let good = Evaluation { rms: 0.3, j_tpf: 0.6, unrest: 0.0 };
        let mut contest = Contest {
            contenders: vec![
                contender("lazy", Evaluation { rms: 2.0, ..good }, 0.4, 0.4),
                contender("restless", Evaluation { unrest: 0.01, ..good }, 0.5, 0.5),
                contender("lost", Evaluation::DIVERGED, 0.5, 0.5),
                contender("safe", good, 0.6, 0.9),
                contender("robust", good, 0.7, 0.8),
            ],
            bounds: Objective::Safety { rms_bound: 0.35, penalty: 1.0 },
            robust: false,
        };
        let best = |c: &Contest| c.best().map(|c| c.name.clone());
        assert_eq!(best(&contest).as_deref(), Some("safe"));
        let text = contest.text();
        assert!(
            text.contains("best: safe, of those that track within an RMS of 0.3500 and come to rest"),
            "{text}"
        );
        assert!(text.ends_with("that do not: lazy, restless, lost\n"), "{text}");
        contest.robust = true;
        assert_eq!(best(&contest).as_deref(), Some("robust"));
        contest.contenders.truncate(3);
        assert_eq!(best(&contest), None);
        assert!(contest.text().contains("best: none"));
    }

    #[test]
    fn closed_form_of_a_sample() {
        let flight = |j_tpf| Evaluation { j_tpf, ..Evaluation::PERFECT };
        let s = Sample::of(&[0.5, 0.7, 1.2].map(flight));
        assert!((s.mean - 0.8).abs() < 1e-15 && (s.std - 0.13f64.sqrt()).abs() < 1e-15, "{s:?}");
        assert_eq!((s.trials, s.worst, s.p_safe), (3, 1.2, 2.0 / 3.0));
    }
}
