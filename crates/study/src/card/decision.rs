//! Whether to go: within the whole envelope, restricted to a part of what the mission draws, or not.
//!
//! The envelope knows quantities one at a time. For each, three standard deviations of what the mission draws
//! ([`Mission::drawn_off`](samara_mission::Mission::drawn_off)) must lie within what is confirmed below
//! J_state 1. Where they do not but one standard deviation does, either way, the release is **restricted** to
//! what is confirmed: two of three draws lie there, and whoever releases can wait for them. (Not for less
//! turbulence, which the mission has in every drop: of that all must be confirmed.) What is smaller, or where
//! nothing is confirmed, is no envelope to release within.

use super::finding::Coverage;
use super::sections::range_words;
use super::{Card, Reason, ReasonKind};
use samara_core::assess::envelope::EnvelopeAxis;

/// The decision of a card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// To go, within the envelope.
    Go,
    /// To go, where the release lies within restrictions.
    Restricted,
    /// Not to go.
    NoGo,
}

impl Decision {
    /// Name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Go => "go",
            Self::Restricted => "go_restricted",
            Self::NoGo => "no_go",
        }
    }

    /// What the sheet says in large letters.
    pub fn words(self) -> &'static str {
        match self {
            Self::Go => "GO",
            Self::Restricted => "GO, restricted",
            Self::NoGo => "NO GO",
        }
    }

    /// Whether it is a go, restricted or not.
    pub fn is_go(self) -> bool {
        self != Self::NoGo
    }
}

/// A range that a quantity of the release must lie in, since what the mission draws goes beyond what is
/// confirmed.
#[derive(Clone, Debug, PartialEq)]
pub struct Restriction {
    /// The quantity.
    pub axis: EnvelopeAxis,
    /// Least value, in the quantity's unit.
    pub from: f64,
    /// Greatest value.
    pub to: f64,
    /// What is drawn: three standard deviations either way; the mission's own turbulence.
    pub drawn: [f64; 2],
    /// The evidence that it rests on.
    pub by: Vec<String>,
}

impl Restriction {
    /// The restriction in words: `tail wind from -5.6 to 3 m/s (the mission draws -4.5 to 4.5)`.
    pub fn words(&self) -> String {
        let [low, high] = self.drawn.map(range_words);
        let [from, to] = [self.from, self.to].map(range_words);
        let (what, unit) = (self.axis.bare_words(), self.axis.unit());
        format!("{what} from {from} to {to} {unit} (the mission draws {low} to {high})")
    }
}

impl Card<'_> {
    /// How each envelope covers what the mission draws of each quantity that it knows, with its number and
    /// what is drawn.
    fn coverages(&self) -> Vec<(String, EnvelopeAxis, Coverage, [f64; 2])> {
        let drawn_off = self.mission.drawn_off();
        let of_each = self.envelopes().flat_map(|(id, envelope)| {
            EnvelopeAxis::ALL.into_iter().zip(drawn_off).filter_map(move |(axis, off)| {
                let (coverage, drawn) = (envelope.coverage(axis, off)?, envelope.drawn(axis, off)?);
                Some((id.clone(), axis, coverage, drawn))
            })
        });
        of_each.collect()
    }

    /// What the release must be restricted to, quantity by quantity; by several envelopes what all of them
    /// confirm.
    pub fn restrictions(&self) -> Vec<Restriction> {
        let mut restrictions: Vec<Restriction> = Vec::new();
        for (id, axis, coverage, drawn) in self.coverages() {
            let Coverage::Part([from, to]) = coverage else { continue };
            match restrictions.iter_mut().find(|restriction| restriction.axis == axis) {
                Some(known) => {
                    (known.from, known.to) = (known.from.max(from), known.to.min(to));
                    known.by.push(id);
                }
                None => restrictions.push(Restriction { axis, from, to, drawn, by: vec![id] }),
            }
        }
        restrictions
    }

    /// Reasons not to go where an envelope confirms nothing of a quantity, or less than a third of what the
    /// mission draws of it.
    pub(super) fn not_covered(&self) -> Vec<Reason> {
        let reason = |(id, axis, coverage, drawn): (String, EnvelopeAxis, Coverage, [f64; 2])| {
            let (what, unit) = (axis.bare_words(), axis.unit());
            let text = match coverage {
                Coverage::Whole | Coverage::Part(_) => return None,
                Coverage::Nothing => format!("envelope: nothing confirmed of {what}"),
                Coverage::TooLittle(confirmed) => {
                    let [[from, to], [low, high]] = [confirmed, drawn].map(|range| range.map(range_words));
                    format!(
                        "envelope: {what} is confirmed from {from} to {to} {unit} alone, and the mission draws {low} to {high}"
                    )
                }
            };
            Some(Reason { kind: ReasonKind::Failed, text, from: vec![id] })
        };
        // The nominal release that is not safe is a reason already, and the only one that matters.
        let safe = self.envelopes().all(|(_, envelope)| envelope.fault().is_none());
        self.coverages().into_iter().filter(|_| safe).filter_map(reason).collect()
    }

    /// The decision.
    pub fn decision(&self) -> Decision {
        match (self.reasons().is_empty(), self.restrictions().is_empty()) {
            (false, _) => Decision::NoGo,
            (true, false) => Decision::Restricted,
            (true, true) => Decision::Go,
        }
    }

    /// The decision in words, with what speaks against a go; without a full stop.
    pub(super) fn verdict(&self, reasons: &[Reason]) -> String {
        if reasons.is_empty() {
            let restrictions: Vec<String> = self.restrictions().iter().map(Restriction::words).collect();
            let to = match restrictions.is_empty() {
                true => "within the envelope below".to_owned(),
                false => format!("restricted to {}", restrictions.join(" and ")),
            };
            return format!(
                "Go, {to}: every piece of evidence that is asked for is there and belongs to these inputs"
            );
        }
        let has = |kind: ReasonKind| reasons.iter().any(|reason| reason.kind == kind);
        let (failed, missing) = (has(ReasonKind::Failed), has(ReasonKind::Missing));
        let which = if failed {
            "some that is asked for is missing"
        } else {
            "evidence that is asked for is missing"
        };
        let clauses = [
            (failed, "the evidence speaks against it"),
            (missing, which),
            (has(ReasonKind::Estimated), "what is estimated is not accepted"),
        ];
        let clauses: Vec<&str> = clauses.into_iter().filter_map(|(is, text)| is.then_some(text)).collect();
        format!("No go: {}", clauses.join(", and "))
    }
}
