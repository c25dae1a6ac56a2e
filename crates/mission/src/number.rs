//! Numbers with a range: they refuse what is outside while the file is being parsed, so that the error knows
//! its place, and they show the range in the schema.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Deserialize, Deserializer, SeqAccess, Unexpected, Visitor};
use serde_json::Value;

/// Where a number may lie.
#[derive(Clone, Copy)]
struct Range {
    /// "a number", "an angle".
    what: &'static str,
    unit: &'static str,
    low: f64,
    low_excluded: bool,
    high: f64,
    high_excluded: bool,
}

impl Range {
    const fn from_to(low: f64, high: f64) -> Self {
        Self { what: "a number", unit: "", low, low_excluded: false, high, high_excluded: false }
    }

    const fn of(self, what: &'static str, unit: &'static str) -> Self {
        Self { what, unit, ..self }
    }

    fn contains(&self, x: f64) -> bool {
        let above = if self.low_excluded { x > self.low } else { x >= self.low };
        let below = if self.high_excluded { x < self.high } else { x <= self.high };
        above && below
    }

    fn schema(&self) -> Schema {
        // A whole number without a decimal point, as it is written in the file.
        let bound = |x: f64| if x.fract() == 0.0 { Value::from(x as i64) } else { Value::from(x) };
        let low = if self.low_excluded { "exclusiveMinimum" } else { "minimum" };
        let high = if self.high_excluded { "exclusiveMaximum" } else { "maximum" };
        json_schema!({ "type": "number", low: bound(self.low), high: bound(self.high) })
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { what, unit, low, high, .. } = self;
        match (self.low_excluded, self.high_excluded) {
            (false, false) => write!(f, "{what} from {low} to {high}{unit}"),
            (true, false) => write!(f, "{what} greater than {low} and at most {high}{unit}"),
            (false, true) => write!(f, "{what} of at least {low} and less than {high}{unit}"),
            (true, true) => write!(f, "{what} between {low} and {high}{unit}, both excluded"),
        }
    }
}

/// Reads a number and checks it where it stands.
impl Visitor<'_> for Range {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }

    fn visit_f64<E: de::Error>(self, x: f64) -> Result<f64, E> {
        if self.contains(x) { Ok(x) } else { Err(E::invalid_value(Unexpected::Float(x), &self)) }
    }

    fn visit_u64<E: de::Error>(self, x: u64) -> Result<f64, E> {
        self.visit_f64(x as f64)
    }

    fn visit_i64<E: de::Error>(self, x: i64) -> Result<f64, E> {
        self.visit_f64(x as f64)
    }
}

/// Has a type's schema stand where the type is used, not by its name.
macro_rules! inline_schema {
    ([$($generics:tt)*] $type:ty, $name:expr, |$generator:pat_param| $schema:expr) => {
        impl<$($generics)*> JsonSchema for $type {
            fn inline_schema() -> bool {
                true
            }
            fn schema_name() -> Cow<'static, str> {
                $name.into()
            }
            fn json_schema($generator: &mut SchemaGenerator) -> Schema {
                $schema
            }
        }
    };
}

macro_rules! number {
    ($(#[$doc:meta])* $name:ident $(<$max:ident>)?: $range:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(super) struct $name $(<const $max: u64>)? (f64);

        impl $(<const $max: u64>)? $name $(<$max>)? {
            const RANGE: Range = $range;

            pub(super) fn get(self) -> f64 {
                self.0
            }
        }

        impl<'de $(, const $max: u64)?> Deserialize<'de> for $name $(<$max>)? {
            fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                d.deserialize_f64(Self::RANGE).map(Self)
            }
        }

        inline_schema!(
            [$(const $max: u64)?] $name $(<$max>)?,
            format!("{} {}", stringify!($name), Self::RANGE),
            |_| Self::RANGE.schema()
        );
    };
}

number! {
    /// At most `MAX`, either way. Like the other bounds, `MAX` is far beyond anything that flies: it keeps
    /// out what would make arithmetic overflow.
    Within<MAX>: Range::from_to(-(MAX as f64), MAX as f64)
}
number! {
    /// Greater than zero, at most `MAX`.
    Positive<MAX>: Range { low_excluded: true, ..Range::from_to(0.0, MAX as f64) }
}
number! {
    /// From zero to `MAX`.
    NonNegative<MAX>: Range::from_to(0.0, MAX as f64)
}
number! {
    /// An angle of a full turn at the most, either way [deg].
    AngleDeg: Range::from_to(-180.0, 180.0).of("an angle", " deg")
}
number! {
    /// An angle strictly between level and vertical [deg].
    TiltDeg: Range { low_excluded: true, high_excluded: true, ..Range::from_to(0.0, 90.0).of("an angle", " deg") }
}
number! {
    /// A latitude, poles excluded [deg].
    LatitudeDeg: Range { low_excluded: true, high_excluded: true, ..Range::from_to(-90.0, 90.0).of("a latitude", " deg") }
}
number! {
    /// A component of a unit vector.
    UnitComponent: Range::from_to(-1.0, 1.0)
}
number! {
    /// A motor's time constant [s]: what is faster would take more than 13 steps of integration in a control
    /// period of 10 ms.
    TimeConstantS: Range::from_to(0.0005, 100.0).of("a time", " s")
}

number! {
    /// A time over which a mean is taken: many control periods, of what is only just a manoeuvre [s].
    MeanOverS: Range::from_to(1.0, 60.0).of("a time", " s")
}

/// Longest simulation [s]: a flight's record is held in memory, at 250 Hz and some 700 bytes a sample.
const LONGEST_S: f64 = 900.0;

number! {
    /// A span of time that a run may take [s].
    SpanS: Range { low_excluded: true, ..Range::from_to(0.0, LONGEST_S).of("a time", " s") }
}
number! {
    /// A time before something that comes within a run [s].
    DelayS: Range::from_to(0.0, LONGEST_S).of("a time", " s")
}

/// A whole number from `LOW` to `HIGH`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Count<const LOW: u64, const HIGH: u64>(u64);

impl<const LOW: u64, const HIGH: u64> Count<LOW, HIGH> {
    pub(super) fn get(self) -> usize {
        self.0 as usize
    }
}

impl<'de, const LOW: u64, const HIGH: u64> Deserialize<'de> for Count<LOW, HIGH> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Whole<const LOW: u64, const HIGH: u64>;
        impl<const LOW: u64, const HIGH: u64> Visitor<'_> for Whole<LOW, HIGH> {
            type Value = u64;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "a whole number from {LOW} to {HIGH}")
            }
            fn visit_u64<E: de::Error>(self, x: u64) -> Result<u64, E> {
                if (LOW..=HIGH).contains(&x) {
                    Ok(x)
                } else {
                    Err(E::invalid_value(Unexpected::Unsigned(x), &self))
                }
            }
        }
        d.deserialize_u64(Whole::<LOW, HIGH>).map(Self)
    }
}

inline_schema!(
    [const LOW: u64, const HIGH: u64] Count<LOW, HIGH>,
    format!("Count{LOW}To{HIGH}"),
    |_| json_schema!({ "type": "integer", "minimum": LOW, "maximum": HIGH })
);

/// Exactly `N` entries (serde's own arrays report a fourth entry of three as "trailing characters").
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Exactly<T, const N: usize>(pub(super) [T; N]);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Exactly<T, N> {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Entries<T, const N: usize>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>, const N: usize> Visitor<'de> for Entries<T, N> {
            type Value = [T; N];
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                write!(f, "a list of exactly {N} entries")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<[T; N], A::Error> {
                let mut entries = Vec::with_capacity(N);
                while entries.len() < N {
                    match seq.next_element()? {
                        Some(entry) => entries.push(entry),
                        None => return Err(de::Error::invalid_length(entries.len(), &self)),
                    }
                }
                if seq.next_element::<de::IgnoredAny>()?.is_some() {
                    return Err(de::Error::invalid_length(N + 1, &self));
                }
                entries.try_into().map_err(|_| de::Error::invalid_length(N + 1, &"no more"))
            }
        }
        d.deserialize_seq(Entries(std::marker::PhantomData)).map(Self)
    }
}

inline_schema!(
    [T: JsonSchema, const N: usize] Exactly<T, N>,
    format!("{}_{N}", T::schema_name()),
    |generator| {
        let items = generator.subschema_for::<T>();
        json_schema!({ "type": "array", "items": items, "minItems": N, "maxItems": N })
    }
);

impl<const MAX: u64, const N: usize> Exactly<Within<MAX>, N> {
    /// The bare numbers.
    pub(super) fn get(self) -> [f64; N] {
        self.0.map(Within::get)
    }
}

/// A name that is also the name of a file or directory: letters, digits, `_` and `-`.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Name(pub(super) String);

impl<'de> Deserialize<'de> for Name {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        struct Word;
        impl Visitor<'_> for Word {
            type Value = String;
            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a name of 1 to 64 letters, digits, `_` and `-`")
            }
            fn visit_str<E: de::Error>(self, s: &str) -> Result<String, E> {
                let plain = s.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
                if plain && (1..=64).contains(&s.len()) {
                    Ok(s.to_owned())
                } else {
                    Err(E::invalid_value(Unexpected::Str(s), &self))
                }
            }
        }
        d.deserialize_str(Word).map(Self)
    }
}

inline_schema!(
    [] Name,
    "Name",
    |_| json_schema!({ "type": "string", "pattern": "^[A-Za-z0-9_-]{1,64}$" })
);
