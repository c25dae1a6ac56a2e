//! A safe-release envelope.

use crate::envelope::ENVELOPE_LIMITS;
use crate::envelope::report::{EdgeObject, EnvelopeObject, EnvelopeOutline, EnvelopePair, PairObject};
use samara_core::assess::envelope::{AxisRange, EnvelopeAxis};
use samara_report::columns::short;

/// How what a mission draws of a quantity lies in what an envelope confirms of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coverage {
    /// Within it.
    Whole,
    /// This range is confirmed: less than is drawn, but at least a third of it either way.
    Part([f64; 2]),
    /// This range is confirmed, which is less than a third of what is drawn, on one side at least, or less
    /// than the mission's own turbulence.
    TooLittle([f64; 2]),
    /// Nothing is confirmed, either way.
    Nothing,
}

/// J_state that safe flights stay below.
pub(super) const SAFE: f64 = ENVELOPE_LIMITS[1];

impl EdgeObject {
    /// Whether both quantities were off at once, by more than arithmetic leaves of one that was not.
    fn has_both_off(&self, nominal: [f64; 2]) -> bool {
        let off = |point: [f64; 2]| {
            point.iter().zip(nominal).all(|(x, nominal)| (x - nominal).abs() > 1e-9 * nominal.abs().max(1.0))
        };
        off(self.safe) || self.first_unsafe.is_some_and(off)
    }
}

impl EnvelopeObject {
    /// Why it is no envelope to drop within, if it is none.
    pub fn fault(&self) -> Option<String> {
        let unsafe_nominal = self
            .pairs
            .iter()
            .flat_map(|pair| &pair.limits)
            .any(|limit| limit.limit >= SAFE && !limit.nominal_is_safe);
        if self.pairs.is_empty() {
            return Some("no quantity was looked at".to_owned());
        }
        let percent = short(100.0 * self.probability, 4);
        unsafe_nominal.then(|| {
            format!(
                "that {percent} % of the flights from the nominal release stay below J_state {SAFE} is not shown: \
                 one of them did not"
            )
        })
    }

    /// The pairs of quantities that were not looked at together: they are in no pair, or only the directions
    /// along one of the two are.
    fn missing(&self) -> Vec<[EnvelopeAxis; 2]> {
        let has = |axes: &[EnvelopeAxis; 2]| {
            let of_both =
                |pair: &&PairObject| axes.iter().all(|axis| pair.axes.iter().any(|name| name == axis.name()));
            self.pairs.iter().filter(of_both).any(|pair| {
                let nominal = |name: &String| self.nominal(EnvelopeAxis::named(name)?);
                let nominal = pair.axes.each_ref().map(|name| nominal(name).unwrap_or_default());
                let mut limits = pair.limits.iter().filter(|limit| limit.limit == SAFE);
                limits.any(|limit| limit.edges.iter().any(|edge| edge.has_both_off(nominal)))
            })
        };
        EnvelopeAxis::pairs().into_iter().filter(|axes| !has(axes)).collect()
    }

    /// What was not looked at, in words: quantities, and pairs of others; `None` where everything was.
    pub fn not_looked_at(&self) -> Option<String> {
        let missing = self.missing();
        let alone: Vec<EnvelopeAxis> = EnvelopeAxis::ALL
            .into_iter()
            .filter(|axis| self.pairs.iter().all(|pair| pair.axes.iter().all(|name| name != axis.name())))
            .collect();
        let mut parts: Vec<String> = Vec::new();
        if !alone.is_empty() {
            parts.push(alone.iter().map(|axis| axis.bare_words()).collect::<Vec<_>>().join(", "));
        }
        let together = missing.iter().filter(|pair| !pair.iter().any(|axis| alone.contains(axis)));
        let together: Vec<String> =
            together.map(|[x, y]| format!("{} with {}", x.bare_words(), y.bare_words())).collect();
        let seen = EnvelopeAxis::ALL.len() - alone.len();
        if !together.is_empty() {
            let all = together.len() == seen * (seen - 1) / 2;
            parts.push(if all { "any two quantities together".to_owned() } else { together.join(", ") });
        }
        (!parts.is_empty()).then(|| parts.join("; "))
    }

    /// The range that is drawn of a quantity, so far either way; no further than there is something to look
    /// at below what cannot be less.
    pub fn drawn(&self, axis: EnvelopeAxis, off: f64) -> Option<[f64; 2]> {
        let AxisRange { low, nominal, .. } = self.range(axis)?;
        let ends_at_zero =
            matches!(axis, EnvelopeAxis::Descent | EnvelopeAxis::Delay | EnvelopeAxis::Turbulence);
        let below = if ends_at_zero { off.min(nominal - low) } else { off };
        Some([nominal - below, nominal + off])
    }

    /// How what is drawn of a quantity, so far either way, lies in what is confirmed below J_state 1 with the
    /// others nominal; `None` where the quantity was not looked at. Where nothing is confirmed one way, the
    /// nominal release ends what is.
    pub fn coverage(&self, axis: EnvelopeAxis, off: f64) -> Option<Coverage> {
        let reach =
            self.one_at_a_time.iter().find(|reach| reach.axis == axis.name() && reach.limit == SAFE)?;
        let nominal = self.nominal(axis)?;
        let [from, to] = self.drawn(axis, off)?;
        let confirmed = [&reach.low, &reach.high].map(|end| end.as_ref().and_then(|end| end.confirmed));
        if confirmed == [None, None] {
            return Some(Coverage::Nothing);
        }
        let [low, high] = confirmed.map(|end| end.unwrap_or(nominal));
        let holds = |share: f64| {
            let rounding = 1e-9 * (to - from);
            low <= nominal - share * (nominal - from) + rounding
                && high >= nominal + share * (to - nominal) - rounding
        };
        Some(match (holds(1.0), holds(1.0 / 3.0)) {
            (true, _) => Coverage::Whole,
            // The mission's turbulence is in every drop: nobody can wait for less.
            (_, true) if axis != EnvelopeAxis::Turbulence => Coverage::Part([low, high]),
            _ => Coverage::TooLittle([low, high]),
        })
    }

    /// How much of what is to be looked at was not, as a share of the pairs.
    pub fn missing_share(&self) -> f64 {
        self.missing().len() as f64 / EnvelopeAxis::pairs().len() as f64
    }

    /// Whether any edge held on fresh flights.
    pub fn any_confirmed(&self) -> bool {
        let limits = self.pairs.iter().flat_map(|pair| &pair.limits);
        limits.flat_map(|limit| &limit.edges).any(|edge| edge.confirmed.is_some())
    }

    /// The value of a quantity at the nominal release, in its unit.
    pub fn nominal(&self, axis: EnvelopeAxis) -> Option<f64> {
        self.range(axis).map(|range| range.nominal)
    }

    fn range(&self, axis: EnvelopeAxis) -> Option<AxisRange> {
        let found = self.axes.iter().find(|found| found.axis == axis.name())?;
        Some(AxisRange { low: found.low, nominal: found.nominal, high: found.high })
    }

    /// The pairs of quantities, as panels show them.
    pub fn panels(&self) -> Vec<EnvelopePair> {
        let panel = |pair: &PairObject| {
            let [x, y] = pair.axes.each_ref().map(|name| EnvelopeAxis::named(name));
            let axes = [x?, y?];
            let ranges = [self.range(axes[0])?, self.range(axes[1])?];
            let nominal = ranges.map(|range| range.nominal);
            let outline = |limit: f64| {
                let edges =
                    pair.limits.iter().filter(|found| found.limit == limit).flat_map(|found| &found.edges);
                let (safe, confirmed) =
                    edges.map(|edge| (edge.safe, edge.confirmed.unwrap_or(nominal))).unzip();
                EnvelopeOutline { safe, confirmed }
            };
            Some(EnvelopePair { axes, ranges, outlines: ENVELOPE_LIMITS.map(outline) })
        };
        self.pairs.iter().filter_map(panel).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::envelope::report::{AxisObject, EnvelopeReach, LimitObject};
    use EnvelopeAxis::{Delay, Descent, Turbulence};

    /// The edges of a quarter: both quantities may only grow. Along both there is one, of which nothing is
    /// safe but the nominal release.
    fn envelope(pairs: &[[EnvelopeAxis; 2]], along_both: bool) -> EnvelopeObject {
        let edge = |safe, first_unsafe| EdgeObject { safe, first_unsafe, ..EdgeObject::default() };
        let mut edges = vec![edge([1.0, 0.0], None), edge([0.0, 0.0], Some([0.0, 0.1]))];
        edges.extend(along_both.then(|| edge([0.0, 0.0], Some([0.1, 0.1]))));
        let limit = || {
            let edges = edges.clone();
            LimitObject { limit: SAFE, nominal_is_safe: true, edges, ..LimitObject::default() }
        };
        let pair = |axes: &[EnvelopeAxis; 2]| PairObject {
            axes: axes.map(|axis| axis.name().to_owned()),
            limits: vec![limit()],
        };
        EnvelopeObject {
            probability: 0.99,
            confidence: 0.95,
            fresh_flights: 459,
            pairs: pairs.iter().map(pair).collect(),
            ..EnvelopeObject::default()
        }
    }

    /// By hand, wind with a sigma of 1.5 m/s, three of them 4.5: confirmed beyond, to two, to a half of one,
    /// one way only, not at all; turbulence has no way down.
    #[test]
    fn closed_form_what_is_drawn_within_what_is_confirmed() {
        use EnvelopeAxis::Wind;
        let end = |confirmed| Some(crate::envelope::report::ReachEnd { confirmed, is_the_end: false });
        let of = |axis: EnvelopeAxis, low, high, off: f64| {
            let reach = EnvelopeReach { axis: axis.name().to_owned(), limit: SAFE, low, high };
            let range = AxisObject { axis: axis.name().to_owned(), low: 0.0, nominal: 0.0, high: 12.0 };
            let found =
                EnvelopeObject { one_at_a_time: vec![reach], axes: vec![range], ..envelope(&[], false) };
            found.coverage(axis, off).unwrap()
        };
        let wind = |low, high| of(Wind, end(low), end(high), 4.5);
        assert_eq!(wind(Some(-5.6), Some(4.5)), Coverage::Whole);
        assert_eq!(wind(Some(-5.6), Some(3.0)), Coverage::Part([-5.6, 3.0]));
        assert_eq!(wind(Some(-5.6), Some(0.75)), Coverage::TooLittle([-5.6, 0.75]));
        assert_eq!(wind(None, Some(0.06)), Coverage::TooLittle([0.0, 0.06]));
        assert_eq!(wind(None, None), Coverage::Nothing);
        assert_eq!(of(Wind, end(None), end(Some(0.06)), 0.0), Coverage::Whole, "nothing is drawn");
        assert_eq!(of(Turbulence, None, end(Some(0.5)), 0.7), Coverage::TooLittle([0.0, 0.5]));
        assert_eq!(of(Turbulence, None, end(None), 0.0), Coverage::Nothing);
        assert_eq!(of(Turbulence, None, None, 0.0), Coverage::Nothing);
        assert_eq!(envelope(&[], false).coverage(Wind, 1.0), None);
    }

    /// A fragment says what it leaves out: quantities of no pair, pairs of the others, and where rays go
    /// along single quantities alone every two of them together; a quarter of few rays is no fragment.
    #[test]
    fn regress_a_fragment_names_what_it_leaves_out() {
        let whole = envelope(&EnvelopeAxis::pairs(), true);
        assert_eq!((whole.not_looked_at(), whole.missing_share()), (None, 0.0));
        let along_one = envelope(&EnvelopeAxis::pairs(), false);
        assert_eq!(along_one.not_looked_at().unwrap(), "any two quantities together");
        let one = envelope(&[[Delay, Turbulence]], true);
        let words = "pitch at release, pitch rate at release, descent at release, tail wind";
        assert_eq!(one.not_looked_at().unwrap(), words);
        let two = envelope(&[[Descent, Delay], [Delay, Turbulence]], true);
        let words = "pitch at release, pitch rate at release, tail wind; descent at release with turbulence";
        assert_eq!((two.not_looked_at().unwrap().as_str(), two.missing_share()), (words, 13.0 / 15.0));
        assert!(!two.any_confirmed());
    }
}
