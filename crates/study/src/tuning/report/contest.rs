//! Gains on flights that the tuning never saw, which of them are best, and whether those found are better
//! than the mission's own.
//!
//! The objective that was asked for decides. For safety, gains must **hold the bounds** on the mission's
//! release cases with real actuators - track no worse than the bound and come to rest at the target in every
//! case; of those that do, the best have the lowest worst J_TPF on the unseen flights, or on the varied ones
//! when the tuning was for them; of equals, those that track better. For tracking or for J_TPF alone that
//! number's worst on these flights decides. Better than the mission's own are gains by a margin only
//! ([`clearly_less`]): less is what arithmetic and a few flights make of gains that are as good. Gains that
//! lose one of the flights that decide, which are in the air that the mission names, are never the best.

use super::gains_grid;
use samara_core::assess::{LEAST_DIFFERENCE, Tally, clearly_less};
use samara_core::hints::No;
use samara_core::tune::{Evaluation, Longitudinal, Objective, are_same_gains};
use samara_report::document::{Grid, Passage};

/// The results of one set of gains on flights that no tuning saw.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct UnseenFlights {
    /// J_TPF of the flights, and how many of them were safe.
    pub tally: Tally,
    /// Worst tracking RMS, (45); infinite when a flight was lost.
    pub rms_worst: f64,
}

impl UnseenFlights {
    /// Takes a flight in, with whether it was safe.
    pub fn push(&mut self, flight: &Evaluation, safe: bool) {
        self.tally.j_tpf.push(Some(flight.j_tpf));
        self.tally.safe.push(safe);
        self.rms_worst = self.rms_worst.max(flight.rms);
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
    pub unseen: UnseenFlights,
    /// Results on the same releases, each with mass, air, wind and delays of its own that the controller does
    /// not know.
    pub varied: UnseenFlights,
}

/// Sets of gains, compared.
#[derive(Clone, Debug, PartialEq)]
pub struct Contest {
    /// The gains to compare with, and last the gains found.
    pub contenders: Vec<Contender>,
    /// Place of the mission's own gains among them.
    pub own: usize,
    /// What is to be small, with the bounds that the release cases must hold.
    pub objective: Objective,
    /// Whether the varied flights decide.
    pub robust: bool,
}

/// How the gains found stand beside the mission's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Standing {
    /// They are better.
    Better,
    /// They are the mission's own, found again.
    Same,
    /// They are not better.
    NotBetter,
}

/// In what gains are clearly better than others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Deciding {
    /// In the number that the objective makes small.
    Number,
    /// In tracking: that number is as good.
    Tracking,
}

impl Standing {
    /// The no of gains that stand so, which keep all bounds or not.
    pub fn no(self, allowed: bool) -> Option<No> {
        match (self, allowed) {
            (Self::Better | Self::Same, _) => None,
            (Self::NotBetter, true) => Some(No::NotBetter),
            (Self::NotBetter, false) => Some(No::BreaksABound),
        }
    }

    /// The word for it in JSON.
    pub fn word(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::Same => "same",
            Self::NotBetter => "not_better",
        }
    }
}

impl Contest {
    /// Whether a set of gains holds the bounds, and loses none of the flights that decide.
    pub fn allows(&self, c: &Contender) -> bool {
        c.cases.is_finite() && self.objective.allows(&c.cases) && !self.loses(c)
    }

    /// Whether a set of gains loses one of the flights that decide.
    fn loses(&self, c: &Contender) -> bool {
        let flown = self.deciding(c);
        flown.tally.j_tpf.count() > 0 && !flown.tally.j_tpf.max().is_finite()
    }

    /// The best gains by the rule; `None` when none hold the bounds.
    pub fn best(&self) -> Option<&Contender> {
        self.contenders.iter().filter(|c| self.allows(c)).min_by(|a, b| self.order(a, b))
    }

    /// How the gains found stand beside the mission's own: better when they alone hold the bounds, or when
    /// both do and the number that decides is clearly less, or as good and their tracking clearly better.
    pub fn standing(&self) -> Standing {
        let Some((own, found)) = self.own_and_found() else { return Standing::NotBetter };
        if are_same_gains(&own.k, &found.k) {
            return Standing::Same;
        }
        let first = !self.allows(own) || self.decides(own, found).is_some();
        if self.allows(found) && first { Standing::Better } else { Standing::NotBetter }
    }

    /// The mission's own gains; `None` in an empty contest.
    pub fn own(&self) -> Option<&Contender> {
        self.contenders.get(self.own)
    }

    fn own_and_found(&self) -> Option<(&Contender, &Contender)> {
        Some((self.own()?, self.contenders.last()?))
    }

    fn deciding<'c>(&self, c: &'c Contender) -> &'c UnseenFlights {
        if self.robust { &c.varied } else { &c.unseen }
    }

    /// The number that decides, and its name.
    fn number(&self, c: &Contender) -> (f64, &'static str) {
        let flown = self.deciding(c);
        match self.objective {
            Objective::Rms => (flown.rms_worst, "worst tracking RMS"),
            Objective::JTpf | Objective::Safety { .. } => (flown.tally.j_tpf.max(), "worst J_TPF"),
        }
    }

    fn order(&self, a: &Contender, b: &Contender) -> std::cmp::Ordering {
        let number = |c| self.number(c).0;
        number(a).total_cmp(&number(b)).then(a.cases.rms.total_cmp(&b.cases.rms))
    }

    /// What the gains found are clearly better in than the mission's own, if they are: the number that
    /// decides, or tracking, where that number is as good.
    fn decides(&self, own: &Contender, found: &Contender) -> Option<Deciding> {
        let number = |c| self.number(c).0;
        let (number_own, number_found) = (number(own), number(found));
        if clearly_less(number_found, number_own) {
            return Some(Deciding::Number);
        }
        let as_good = !clearly_less(number_own, number_found);
        (as_good && clearly_less(found.cases.rms, own.cases.rms)).then_some(Deciding::Tracking)
    }

    /// What is said of the comparison; the verdict is the caller's last line.
    pub fn passages(&self) -> Vec<Passage> {
        let sets: Vec<_> = self.contenders.iter().map(|c| (c.name.as_str(), c.k)).collect();
        let trials = self.contenders.first().map_or(0, |c| c.unseen.tally.j_tpf.count());
        let title = format!(
            "Tuning's flights, release cases, J_TPF of {trials} unseen flights and of the same varied"
        );
        let heads = [
            "gains",
            "RMS",
            "J_TPF",
            "cases RMS",
            "rest",
            "unseen max",
            "mean",
            "std",
            "varied max",
            "mean",
            "std",
            "safe",
        ];
        let mut grid = Grid::new(&title, heads);
        for c in &self.contenders {
            let mut cells: Vec<_> = [c.tuning.rms, c.tuning.j_tpf, c.cases.rms].map(fixed).into();
            cells.push(if c.cases.unrest == 0.0 { "yes" } else { "no" }.to_owned());
            for j in [&c.unseen.tally.j_tpf, &c.varied.tally.j_tpf] {
                cells.extend([j.max(), j.mean(), j.std()].map(fixed));
            }
            let p_safe = [&c.unseen, &c.varied].map(|flown| flown.tally.safe.probability());
            cells.push(format!("{:.1}%", 50.0 * (p_safe[0] + p_safe[1])));
            grid.row(&c.name, cells);
        }
        let mut passages = vec![Passage::Table(gains_grid(&sets)), Passage::Table(grid)];
        self.tell_bounds(&mut passages);
        passages
    }

    /// What the bounds are, which gains do not hold them, and the best of those that do.
    fn tell_bounds(&self, passages: &mut Vec<Passage>) {
        let Objective::Safety { rms_bound, .. } = self.objective else { return };
        passages.push(Passage::Said(format!(
            "bounds: a tracking RMS of at most {rms_bound:.4} and rest at the target, in every release case"
        )));
        let others: Vec<&str> =
            self.contenders.iter().filter(|c| !self.allows(c)).map(|c| c.name.as_str()).collect();
        if !others.is_empty() {
            passages.push(Passage::Remark(format!("not within them: {}", others.join(", "))));
        }
        let best = self.best().map_or("none", |c| &c.name);
        let kind = self.kind();
        passages.push(Passage::Remark(format!("lowest worst J_TPF within them, {kind} flights: {best}")));
    }

    fn kind(&self) -> &'static str {
        if self.robust { "varied" } else { "unseen" }
    }

    /// The answer in a sentence: whether the gains found are better than the mission's own.
    pub fn verdict(&self) -> String {
        let Some((own, found)) = self.own_and_found() else { return String::new() };
        let (own_name, name) = (&own.name, &found.name);
        let numbers = || {
            let ((own, what), (found, _)) = (self.number(own), self.number(found));
            let count = self.deciding(&self.contenders[0]).tally.j_tpf.count();
            let (found, own) = apart(found, own);
            format!("{what} {found} against {own} on {count} {} flights", self.kind())
        };
        let margin = || match self.decides(own, found) {
            Some(Deciding::Tracking) => {
                let (found, own) = apart(found.cases.rms, own.cases.rms);
                format!("{}, as good; tracking RMS {found} against {own} in the release cases", numbers())
            }
            Some(Deciding::Number) => numbers(),
            None if self.number(found).0 < self.number(own).0 => {
                format!("{}, which is less than {} % apart", numbers(), 100.0 * LEAST_DIFFERENCE)
            }
            None => numbers(),
        };
        let outside = |c: &Contender| match (c.cases.is_finite(), c.cases.unrest == 0.0) {
            (false, _) => "loses a release case".to_owned(),
            (true, false) => "does not come to rest in every release case".to_owned(),
            (true, true) if self.loses(c) => format!("loses one of the {} flights", self.kind()),
            (true, true) => "breaks the bound on tracking in a release case".to_owned(),
        };
        match (self.standing(), self.allows(own), self.allows(found)) {
            (Standing::Same, ..) => format!("{name} is {own_name} found again: nothing changes"),
            (Standing::Better, true, _) => format!("{name} is better than {own_name} ({})", margin()),
            (Standing::Better, false, _) => {
                format!("{name} is better than {own_name}, which {}", outside(own))
            }
            (Standing::NotBetter, own_holds, false) => {
                let then = if own_holds { format!("keep {own_name}") } else { "neither will do".to_owned() };
                format!("{name} is not better than {own_name} (it {}): {then}", outside(found))
            }
            (Standing::NotBetter, _, true) => {
                format!("{name} is not better than {own_name} ({}): keep {own_name}", margin())
            }
        }
    }
}

/// Two numbers with as many digits, three or more, as tell them apart.
fn apart(a: f64, b: f64) -> (String, String) {
    let text = |digits: usize| {
        [a, b].map(|x| if x.is_finite() { format!("{x:.digits$}") } else { "lost".to_owned() })
    };
    let [a, b] = (3..9).map(text).find(|[a, b]| a != b).unwrap_or_else(|| text(3));
    (a, b)
}

fn fixed(x: f64) -> String {
    if x.is_finite() { format!("{x:.4}") } else { "lost".to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn results_of(flights: &[(Evaluation, bool)]) -> UnseenFlights {
        let mut unseen = UnseenFlights::default();
        flights.iter().for_each(|(flight, safe)| unseen.push(flight, *safe));
        unseen
    }
    use samara_report::document::Document;

    fn contender(name: &str, cases: Evaluation, unseen: f64, varied: f64) -> Contender {
        let flown = |j_tpf| results_of(&[(Evaluation { j_tpf, ..Evaluation::PERFECT }, j_tpf < 1.0); 10]);
        let (unseen, varied) = (flown(unseen), flown(varied));
        // Gains of its own.
        let k = [name.len() as f64; 7];
        Contender { name: name.to_owned(), k, tuning: cases, cases, unseen, varied }
    }

    const GOOD: Evaluation = Evaluation { rms: 0.3, j_tpf: 0.6, unrest: 0.0 };
    const SAFETY: Objective = Objective::Safety { rms_bound: 0.35, penalty: 1.0 };

    /// Gains that never accelerate are safest of all, and gains that never come to rest track well: neither
    /// wins.
    #[test]
    fn the_safest_gains_that_hold_the_bounds_win() {
        let mut contest = Contest {
            contenders: vec![
                contender("lazy", Evaluation { rms: 2.0, ..GOOD }, 0.4, 0.4),
                contender("restless", Evaluation { unrest: 0.01, ..GOOD }, 0.5, 0.5),
                contender("lost", Evaluation::DIVERGED, 0.5, 0.5),
                contender("safe", GOOD, 0.6, 0.9),
                contender("robust", GOOD, 0.7, 0.8),
            ],
            own: 3,
            objective: SAFETY,
            robust: false,
        };
        let said = |c: &Contest| Document::of_one(String::new(), String::new(), c.passages()).text();
        let best = |c: &Contest| c.best().map(|c| c.name.clone());
        assert_eq!(best(&contest).as_deref(), Some("safe"));
        let text = said(&contest);
        assert!(text.contains("bounds: a tracking RMS of at most 0.3500 and rest at the target"), "{text}");
        assert!(text.contains("not within them: lazy, restless, lost\n"), "{text}");
        assert!(text.contains("within them, unseen flights: safe\n"), "{text}");
        assert_eq!(
            contest.verdict(),
            "robust is not better than safe (worst J_TPF 0.700 against 0.600 on 10 unseen flights): keep safe"
        );
        contest.robust = true;
        assert_eq!(best(&contest).as_deref(), Some("robust"));
        assert_eq!(
            contest.verdict(),
            "robust is better than safe (worst J_TPF 0.800 against 0.900 on 10 varied flights)"
        );
        contest.contenders.truncate(3);
        assert_eq!(best(&contest), None);
        assert!(
            said(&contest).contains("unseen flights: none")
                || said(&contest).contains("varied flights: none")
        );
    }

    /// Gains that lose one of the flights that decide win nothing, also where no bound is asked for and where
    /// nothing else is left.
    #[test]
    fn gains_that_tumble_are_never_the_best() {
        for objective in [SAFETY, Objective::JTpf] {
            let mut contest = Contest {
                contenders: vec![
                    contender("ours", GOOD, f64::INFINITY, 0.9),
                    contender("tuned", GOOD, 0.5, f64::INFINITY),
                ],
                own: 0,
                objective,
                robust: false,
            };
            assert_eq!(contest.best().map(|c| c.name.as_str()), Some("tuned"));
            assert_eq!(contest.verdict(), "tuned is better than ours, which loses one of the unseen flights");
            contest.robust = true;
            assert_eq!(contest.best().map(|c| c.name.as_str()), Some("ours"));
            let verdict = contest.verdict();
            assert!(verdict.ends_with("(it loses one of the varied flights): keep ours"), "{verdict}");
            contest.contenders.remove(0);
            assert_eq!(contest.best(), None);
        }
    }

    /// The mission's own gains and those found, each within the bounds or not, and the same gains again.
    #[test]
    fn the_answer_names_the_reason() {
        let restless = Evaluation { unrest: 0.01, ..GOOD };
        let between = |own: Evaluation, found: Evaluation, objective| {
            let contenders = vec![contender("ours", own, 0.6, 0.6), contender("tuned", found, 0.5, 0.5)];
            Contest { contenders, own: 0, objective, robust: false }
        };
        for (own, found, standing, verdict) in [
            (GOOD, GOOD, Standing::Better, "(worst J_TPF 0.500 against 0.600 on 10 unseen flights)"),
            (
                restless,
                GOOD,
                Standing::Better,
                "tuned is better than ours, which does not come to rest in every release case",
            ),
            (
                GOOD,
                restless,
                Standing::NotBetter,
                "(it does not come to rest in every release case): keep ours",
            ),
            (GOOD, Evaluation::DIVERGED, Standing::NotBetter, "(it loses a release case): keep ours"),
            (
                GOOD,
                Evaluation { rms: 0.4, ..GOOD },
                Standing::NotBetter,
                "(it breaks the bound on tracking in a release case): keep ours",
            ),
            (restless, restless, Standing::NotBetter, "): neither will do"),
        ] {
            let contest = between(own, found, SAFETY);
            assert_eq!(contest.standing(), standing, "{own:?} {found:?}");
            assert!(contest.verdict().ends_with(verdict), "{}", contest.verdict());
        }
        // J_TPF alone asks for no rest, tracking for the tracking of the unseen flights.
        assert_eq!(between(GOOD, restless, Objective::JTpf).standing(), Standing::Better);
        let mut tracking = between(GOOD, GOOD, Objective::Rms);
        tracking.contenders.iter_mut().for_each(|c| c.unseen.rms_worst = 0.3);
        assert_eq!(tracking.standing(), Standing::NotBetter, "as good is not better");
        tracking.contenders[1].unseen.rms_worst = 0.2996;
        assert_eq!(tracking.standing(), Standing::Better);
        let mut again = between(GOOD, GOOD, SAFETY);
        again.contenders[1].k = again.contenders[0].k;
        assert_eq!(again.standing(), Standing::Same);
        assert_eq!(again.verdict(), "tuned is ours found again: nothing changes");
    }

    /// Numbers that differ by arithmetic, or by less than a thousandth, make nothing better; where the number
    /// is as good the tracking decides, by a thousandth, too; gains that differ in their last bits are the
    /// same.
    #[test]
    fn regress_what_is_less_by_a_bit_is_not_better() {
        let between = |found_j: f64, found_rms: f64| {
            let found = Evaluation { rms: found_rms, ..GOOD };
            let contenders = vec![contender("ours", GOOD, 0.6, 0.6), contender("tuned", found, found_j, 0.5)];
            Contest { contenders, own: 0, objective: SAFETY, robust: false }
        };
        for (j, rms, standing) in [
            (0.6 - 1e-12, 0.3, Standing::NotBetter),
            (0.5996, 0.3 - 1e-12, Standing::NotBetter),
            (0.5993, 0.34, Standing::Better),
            (0.6, 0.2, Standing::Better),
            (0.6004, 0.2, Standing::Better),
            (0.6007, 0.2, Standing::NotBetter),
        ] {
            assert_eq!(between(j, rms).standing(), standing, "{j} {rms}");
        }
        let verdict = between(0.5997, 0.3).verdict();
        let expected = "tuned is not better than ours (worst J_TPF 0.5997 against 0.6000 on 10 unseen flights, which is less \
                        than 0.1 % apart): keep ours";
        assert_eq!(verdict, expected);
        let verdict = between(0.6, 0.2).verdict();
        assert!(
            verdict.ends_with("as good; tracking RMS 0.200 against 0.300 in the release cases)"),
            "{verdict}"
        );
        let mut again = between(0.4, 0.2);
        again.contenders[1].k = again.contenders[0].k.map(|k| k * (1.0 + f64::EPSILON));
        assert_eq!(again.standing(), Standing::Same);
    }

    #[test]
    fn closed_form_of_a_tally() {
        let flight = |j_tpf| (Evaluation { j_tpf, rms: j_tpf / 2.0, ..Evaluation::PERFECT }, j_tpf < 1.0);
        let UnseenFlights { tally: Tally { j_tpf: j, safe }, rms_worst } =
            results_of(&[0.5, 0.7, 1.2].map(flight));
        assert!((j.mean() - 0.8).abs() < 1e-15 && (j.std() - 0.13f64.sqrt()).abs() < 1e-15, "{j:?}");
        assert_eq!((j.count(), j.max(), safe.probability()), (3, 1.2, 2.0 / 3.0));
        assert_eq!(rms_worst, 0.6);
    }
}
