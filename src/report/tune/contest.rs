//! Gains on flights that the tuning never saw, and which of them are best.
//!
//! The rule is the same whatever was tuned, and on what: gains must **hold the bounds** on the mission's
//! release cases with real actuators - track no worse than the bound and come to rest at the target in every
//! case; J_TPF alone would choose gains that never accelerate. Of those that do, the best have the lowest
//! worst J_TPF on the unseen flights, or on the varied ones when the tuning was for them; of equals, those
//! that track better.

use super::gains_table;
use crate::assess::Tally;
use crate::report::columns::columns;
use crate::tune::{Evaluation, Longitudinal, Objective};

/// J_TPF at which a limit is reached.
const LIMIT: f64 = 1.0;

/// J_TPF of these flights, and how many of them stayed within every limit.
pub fn tally(flights: &[Evaluation]) -> Tally {
    let mut tally = Tally::default();
    for flight in flights {
        tally.j_tpf.push(flight.j_tpf);
        tally.safe.push(flight.j_tpf <= LIMIT);
    }
    tally
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
    pub unseen: Tally,
    /// Results on the same releases, each with mass, air, wind and delays of its own that the controller does
    /// not know.
    pub varied: Tally,
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
        let order = |c: &Contender| (if self.robust { c.varied } else { c.unseen }.j_tpf.max(), c.cases.rms);
        self.contenders.iter().filter(|c| self.allows(c)).min_by(|a, b| {
            let (a, b) = (order(a), order(b));
            a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    }

    /// The comparison as text for the terminal.
    pub fn text(&self) -> String {
        const WIDTHS: [usize; 12] = [14, 7, 7, 7, 7, 9, 7, 7, 9, 7, 7, 8];
        let sets: Vec<_> = self.contenders.iter().map(|c| (c.name.as_str(), c.k)).collect();
        let trials = self.contenders.first().map_or(0, |c| c.unseen.j_tpf.count());
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
            for j in [&c.unseen.j_tpf, &c.varied.j_tpf] {
                cells.extend([j.max(), j.mean(), j.std()].map(fixed));
            }
            let p_safe = [&c.unseen, &c.varied].map(|tally| tally.safe.probability());
            cells.push(format!("{:.1}%", 50.0 * (p_safe[0] + p_safe[1])));
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
        let flown = |j_tpf| tally(&[Evaluation { j_tpf, ..Evaluation::PERFECT }; 10]);
        let (unseen, varied) = (flown(unseen), flown(varied));
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
    fn closed_form_of_a_tally() {
        let flight = |j_tpf| Evaluation { j_tpf, ..Evaluation::PERFECT };
        let Tally { j_tpf: j, safe } = tally(&[0.5, 0.7, 1.2].map(flight));
        assert!((j.mean() - 0.8).abs() < 1e-15 && (j.std() - 0.13f64.sqrt()).abs() < 1e-15, "{j:?}");
        assert_eq!((j.count(), j.max(), safe.probability()), (3, 1.2, 2.0 / 3.0));
        assert_eq!(tally(&[flight(LIMIT)]).safe.probability(), 1.0);
    }
}
