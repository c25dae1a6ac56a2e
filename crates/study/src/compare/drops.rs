//! Two drops: their verdicts beside each other, and what they came to.

use super::sides::sides;
use samara_core::assess::Quantity;
use samara_core::assess::outcome::COUNTED;
use samara_report::columns::fixed;
use samara_report::document::{Grid, Passage};
use samara_report::json::{DropObject, result_objects};

/// Two drops.
#[derive(Clone, Debug, PartialEq)]
pub struct DropPair {
    /// The drops, as `drop.json` holds them.
    pub drops: [DropObject; 2],
}

/// A quantity of both drops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ValuePair {
    /// The quantity.
    pub quantity: Quantity,
    /// The values of A and of B.
    pub values: [Option<f64>; 2],
}

impl ValuePair {
    /// The difference, B less A, where both have a value.
    pub fn difference(&self) -> Option<f64> {
        let [a, b] = self.values;
        Some(b? - a?)
    }
}

impl DropPair {
    /// What both came to.
    pub fn quantities(&self) -> impl Iterator<Item = ValuePair> {
        let of = |quantity: &Quantity| self.drops.each_ref().map(|drop| quantity.of(&drop.outcome.0));
        COUNTED.iter().map(move |quantity| ValuePair { quantity: *quantity, values: of(quantity) })
    }

    /// What is said of them.
    pub fn passages(&self) -> Vec<Passage> {
        let words = |drop: &DropObject| {
            let by = drop.autopilot.as_ref().map_or(String::new(), |by| format!(", flown by {by}"));
            let (head, gains) = (&drop.head, &drop.gains);
            format!("{}, gains {gains}{by}, samara {}: {}", head.mission, head.version, verdict(drop))
        };
        let mut grid = Grid::new("What the drops came to", ["", "A", "B", "B - A"]);
        for pair in self.quantities() {
            let Quantity { decimals, without, .. } = pair.quantity;
            let number = |x: Option<f64>, none: &str| x.map_or(none.to_owned(), |x| fixed(x, decimals));
            let [a, b] = pair.values.map(|x| number(x, without));
            grid.row(&pair.quantity.head(), [a, b, number(pair.difference(), "-")]);
        }
        let table = [Passage::Table(grid)];
        sides(self.drops.each_ref().map(words)).into_iter().chain(table).collect()
    }
}

/// The verdict on a drop in words.
fn verdict(drop: &DropObject) -> String {
    match drop.safe {
        true => "safe".to_owned(),
        false => format!("NOT safe: {}", drop.objections.join("; ")),
    }
}

result_objects! {
    /// Two drops.
    DropPairObject(pair: &DropPair) [let [a, b] = &pair.drops;] {
        /// Drop A.
        a: ComparedDropObject = ComparedDropObject::of(a),
        /// Drop B.
        b: ComparedDropObject = ComparedDropObject::of(b),
        /// The quantities.
        quantities: Vec<ValuePairObject> = pair.quantities().map(|pair| ValuePairObject::of(&pair)).collect(),
    }

    /// One of two drops.
    ComparedDropObject(drop: &DropObject) {
        /// Name of the mission.
        mission: String = drop.head.mission.clone(),
        /// Version of samara that flew it.
        version: String = drop.head.version.clone(),
        /// SHA-256 of all inputs, files and options, hexadecimal.
        input_hash: String = drop.head.input_hash.clone(),
        /// Name of the gains.
        gains: String = drop.gains.clone(),
        /// The autopilot; null where it is not known.
        autopilot: Option<String> = drop.autopilot.clone(),
        /// Whether the drop was safe.
        safe: bool = drop.safe,
        /// Why it was not safe, in words, the cause first; empty where it was.
        objections: Vec<String> = drop.objections.clone(),
    }

    /// A quantity of both drops.
    ValuePairObject(pair: &ValuePair) [let [a, b] = pair.values;] {
        /// Name of the quantity; it ends in its unit.
        name: String = pair.quantity.key.to_owned(),
        /// The value of A; null where it has none.
        a: Option<f64> = a,
        /// The value of B; null where it has none.
        b: Option<f64> = b,
        /// The difference, B less A; null where one has no value.
        difference: Option<f64> = pair.difference(),
    }
}
