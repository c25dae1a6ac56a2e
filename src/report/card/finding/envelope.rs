//! A safe-release envelope.

use serde::Deserialize;

use crate::assess::envelope::{AxisRange, EnvelopeAxis};
use crate::config::ENVELOPE_LIMITS;
use crate::report::columns::short;
use crate::report::envelope::{EnvelopeOutline, EnvelopePair, EnvelopeReach};

/// J_state that safe flights stay below.
pub(super) const SAFE: f64 = ENVELOPE_LIMITS[1];

/// `envelope.json`.
#[derive(Clone, Debug, Deserialize)]
pub struct EnvelopeFound {
    /// Share of flights that are safe at a confirmed edge.
    pub probability: f64,
    /// Confidence at each edge.
    pub confidence: f64,
    /// Fresh flights that confirm an edge.
    pub fresh_flights: u64,
    axes: Vec<AxisFound>,
    /// How far each quantity goes by itself.
    pub one_at_a_time: Vec<EnvelopeReach>,
    pairs: Vec<PairFound>,
}

#[derive(Clone, Debug, Deserialize)]
struct AxisFound {
    axis: String,
    low: f64,
    nominal: f64,
    high: f64,
}

#[derive(Clone, Debug, Deserialize)]
struct PairFound {
    axes: [String; 2],
    limits: Vec<LimitFound>,
}

#[derive(Clone, Debug, Deserialize)]
struct LimitFound {
    limit: f64,
    nominal_is_safe: bool,
    edges: Vec<EdgeFound>,
}

#[derive(Clone, Debug, Deserialize)]
struct EdgeFound {
    safe: [f64; 2],
    confirmed: Option<[f64; 2]>,
}

impl EnvelopeFound {
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
        unsafe_nominal
            .then(|| format!("fewer than {percent} % of the flights from the nominal release are safe"))
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
        let panel = |pair: &PairFound| {
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
