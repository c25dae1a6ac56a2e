//! A campaign, and the probabilities that it leaves possible.

use super::Shortfall;
use super::envelope::SAFE;
use crate::campaign::json::{AssessObject, CampaignObject};
use samara_core::assess::{ChosenAmong, Share};
use samara_report::columns::short;

impl AssessObject {
    /// The trials that are judged.
    pub fn judged(&self) -> Option<&CampaignObject> {
        self.campaigns.first()
    }

    /// Why it speaks against a go, if it does: a trial failed, where no probability of failure is `accepted`,
    /// or more than that is left possible by trials that failed.
    pub fn fault(&self, accepted: Option<f64>, among: ChosenAmong) -> Option<String> {
        let trials = self.judged()?;
        let CampaignObject { trials: flown, unsafe_trials: failed, .. } = *trials;
        if failed == 0 {
            return None;
        }
        match accepted {
            Some(accepted) => trials.too_likely(accepted, among),
            None => {
                let worst = trials.worst.first();
                let example = worst.and_then(|trial| Some((trial.trial, trial.failure.as_deref()?)));
                let example = example
                    .map_or_else(String::new, |(trial, why)| format!(", such as trial {trial}: {why}"));
                Some(format!("{failed} of {flown} trials failed{example}"))
            }
        }
    }

    /// Why it is not enough for a go, if it is not: not all of the `asked` trials were flown, a laxer J_TPF
    /// judged them, or they are too few for the probability of failure that is `demanded`.
    pub fn shortfall(&self, asked: Option<u64>, demanded: f64, among: ChosenAmong) -> Option<Shortfall> {
        let Some(trials) = self.judged().filter(|trials| trials.trials > 0) else {
            return Some(Shortfall::of_kind("it has no trial".to_owned()));
        };
        if let Some(asked) = asked.filter(|asked| *asked != trials.trials) {
            let why = format!("it was stopped after {} of {asked} trials", trials.trials);
            return Some(Shortfall::of_kind(why));
        }
        if self.bound > SAFE {
            let why = format!("it is judged by J_TPF below {}, not below {SAFE}", short(self.bound, 4));
            return Some(Shortfall::of_kind(why));
        }
        let why = trials.too_likely(demanded, among)?;
        Some(Shortfall { distance: trials.failing_at_most(among), why })
    }
}

impl CampaignObject {
    fn share(&self) -> Share {
        Share::of(self.trials.saturating_sub(self.unsafe_trials), self.trials)
    }

    /// The greatest probability of failure that so few failures leave possible, one-sided, of what was chosen
    /// among so many by these trials.
    pub fn failing_at_most(&self, among: ChosenAmong) -> f64 {
        among.misses_at_most(&self.share())
    }

    /// That a larger probability of failure than this is possible, in words; `None`: it is not.
    fn too_likely(&self, p: f64, among: ChosenAmong) -> Option<String> {
        let at_most = self.failing_at_most(among);
        (at_most > p).then(|| {
            format!(
                "{} of {} trials failed, which leaves a probability of failure of {} possible; at most {} is asked for",
                self.unsafe_trials,
                self.trials,
                probability(at_most, f64::ceil),
                short(p, 12)
            )
        })
    }

    /// The share of trials that failed, and the ends of the exact interval of its probability, of what was
    /// chosen among so many by these trials.
    pub fn failing(&self, among: ChosenAmong) -> (f64, [f64; 2]) {
        let (low, high) = self.share().interval_at(among.confidence());
        (self.unsafe_trials as f64 / self.trials as f64, [1.0 - high, 1.0 - low])
    }
}

/// The fewest trials that show, without a failure among them, that no more than the share `p` of all fails:
/// `(1 - p)^n` is at most what the confidence leaves.
pub fn fewest_trials(p: f64, among: ChosenAmong) -> u64 {
    (samara_core::math::ln(1.0 - among.confidence()) / samara_core::math::ln_1p(-p)).ceil() as u64
}

/// A number rounded to a whole one as is said, but for what arithmetic has added to one.
fn rounded(x: f64, by: fn(f64) -> f64) -> f64 {
    let nearest = x.round();
    if (x - nearest).abs() < 1e-9 { nearest } else { by(x) }
}

/// A probability in two digits, the second rounded as is said: `f64::ceil` for what it is at most,
/// `f64::floor` for what it is at least, `f64::round` for an estimate.
pub fn probability(p: f64, by: fn(f64) -> f64) -> String {
    if !(p > 0.0 && p < 1.0) {
        return short(p, 4);
    }
    let exponent = samara_core::math::log10(p).floor() as i32;
    let scale = 10f64.powi(1 - exponent);
    let p = rounded(p * scale, by) / scale;
    if exponent < -4 { format!("{p:.1e}") } else { format!("{p:.*}", (1 - exponent) as usize) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trials(trials: u64, unsafe_trials: u64) -> CampaignObject {
        CampaignObject { trials, unsafe_trials, ..CampaignObject::default() }
    }

    /// Without a failure `1 - 0.05^(1/n)`; 299 trials are the fewest that show 0.01 (Wilks 1941).
    #[test]
    fn closed_form_probability_of_failure() {
        let none = trials(1000, 0);
        let wanted = 1.0 - samara_core::math::powf(0.05, 1e-3);
        assert!((none.failing_at_most(ChosenAmong::ONE) - wanted).abs() < 1e-12);
        assert_eq!([0.01, 1e-3, 0.5].map(|p| fewest_trials(p, ChosenAmong::ONE)), [299, 2995, 5]);
        assert!(
            trials(299, 0).failing_at_most(ChosenAmong::ONE) <= 0.01
                && trials(298, 0).failing_at_most(ChosenAmong::ONE) > 0.01
        );
        let (share, [low, high]) = trials(1000, 3).failing(ChosenAmong::ONE);
        assert!(
            share == 0.003
                && low < share
                && share < high
                && trials(1000, 3).failing_at_most(ChosenAmong::ONE) < high
        );
    }

    /// The upper end of an interval is rounded up, the lower one down, an estimate to the nearest: 70 of 600
    /// is 0.11666.., of which 0.12 is no lower bound.
    #[test]
    fn closed_form_probabilities_are_rounded_away_from_what_they_bound() {
        let all = |p: f64| [f64::floor, f64::round, f64::ceil].map(|rounded| probability(p, rounded));
        for (p, expected) in [
            (70.0 / 600.0, ["0.11", "0.12", "0.12"]),
            (0.00291, ["0.0029", "0.0029", "0.0030"]),
            (0.003, ["0.0030", "0.0030", "0.0030"]),
            (0.01, ["0.010", "0.010", "0.010"]),
            (0.996, ["0.99", "1.00", "1.00"]),
            (2.91e-6, ["2.9e-6", "2.9e-6", "3.0e-6"]),
            (0.0, ["0", "0", "0"]),
            (1.0, ["1", "1", "1"]),
        ] {
            assert_eq!(all(p), expected, "{p}");
        }
    }

    /// A failure speaks against a go unless a probability of failure is accepted, which decides then; what is
    /// too short, stopped or judged by less is not enough, but no failure.
    #[test]
    fn a_campaign_must_be_whole_long_enough_and_without_a_failure() {
        let campaign = |n, failed, bound| AssessObject {
            bound,
            plan_j_tpf: 0.5,
            campaigns: vec![trials(n, failed)],
            ..AssessObject::default()
        };
        let short = |shortfall: Option<Shortfall>| shortfall.map(|shortfall| shortfall.why);
        let good = campaign(299, 0, 1.0);
        assert_eq!(
            (good.fault(None, ChosenAmong::ONE), short(good.shortfall(Some(299), 0.01, ChosenAmong::ONE))),
            (None, None)
        );
        for (shortfall, expected) in [
            (short(good.shortfall(Some(300), 0.01, ChosenAmong::ONE)), "stopped after 299 of 300"),
            (
                short(campaign(298, 0, 1.0).shortfall(None, 0.01, ChosenAmong::ONE)),
                "at most 0.01 is asked for",
            ),
            (short(campaign(299, 0, 1.1).shortfall(None, 0.01, ChosenAmong::ONE)), "below 1.1, not below 1"),
            (short(campaign(0, 0, 1.0).shortfall(None, 0.01, ChosenAmong::ONE)), "no trial"),
            (campaign(100_000, 1, 1.0).fault(None, ChosenAmong::ONE), "1 of 100000 trials failed"),
            (campaign(100, 5, 1.0).fault(Some(0.01), ChosenAmong::ONE), "leaves a probability of failure of"),
        ] {
            assert!(
                shortfall.as_deref().is_some_and(|why| why.contains(expected)),
                "{shortfall:?}: {expected}"
            );
        }
        let few = campaign(100_000, 1, 1.0);
        assert_eq!(
            (few.fault(Some(0.01), ChosenAmong::ONE), short(few.shortfall(None, 0.01, ChosenAmong::ONE))),
            (None, None)
        );
    }
}
