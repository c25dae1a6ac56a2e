//! Numbers with a range: they refuse what is outside while the file is being parsed, so that the error knows its place,
//! and they show the range in the schema.

use std::borrow::Cow;
use std::fmt;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{self, Deserialize, Deserializer, SeqAccess, Unexpected, Visitor};

/// Reads a number and checks it where it stands.
struct Checked {
    expected: &'static str,
    holds: fn(f64) -> bool,
}

impl Visitor<'_> for Checked {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.expected)
    }

    fn visit_f64<E: de::Error>(self, x: f64) -> Result<f64, E> {
        if x.is_finite() && (self.holds)(x) {
            Ok(x)
        } else {
            Err(E::invalid_value(Unexpected::Float(x), &self))
        }
    }

    fn visit_u64<E: de::Error>(self, x: u64) -> Result<f64, E> {
        self.visit_f64(x as f64)
    }

    fn visit_i64<E: de::Error>(self, x: i64) -> Result<f64, E> {
        self.visit_f64(x as f64)
    }
}

macro_rules! number {
    ($(#[$doc:meta])* $name:ident: $expected:literal, $holds:expr, { $($schema:tt)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(super) struct $name(f64);

        impl $name {
            pub(super) fn get(self) -> f64 {
                self.0
            }
        }

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
                d.deserialize_f64(Checked { expected: $expected, holds: $holds }).map(Self)
            }
        }

        impl JsonSchema for $name {
            fn inline_schema() -> bool {
                true
            }
            fn schema_name() -> Cow<'static, str> {
                stringify!($name).into()
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({ "type": "number", $($schema)* })
            }
        }
    };
}

number! {
    /// Any finite number.
    Finite: "a finite number", |_| true, {}
}
number! {
    /// Greater than zero.
    Positive: "a number greater than 0", |x| x > 0.0, { "exclusiveMinimum": 0 }
}
number! {
    /// Zero or more.
    NonNegative: "a number of at least 0", |x| x >= 0.0, { "minimum": 0 }
}
number! {
    /// An angle of a full turn at the most, either way [deg].
    AngleDeg: "an angle from -180 to 180 deg", |x| x.abs() <= 180.0, { "minimum": -180, "maximum": 180 }
}
number! {
    /// An angle strictly between level and vertical [deg].
    TiltDeg: "an angle between 0 and 90 deg, both excluded", |x| x > 0.0 && x < 90.0,
    { "exclusiveMinimum": 0, "exclusiveMaximum": 90 }
}
number! {
    /// A latitude, poles excluded [deg].
    LatitudeDeg: "a latitude between -90 and 90 deg, both excluded", |x| x.abs() < 90.0,
    { "exclusiveMinimum": -90, "exclusiveMaximum": 90 }
}
number! {
    /// A component of a unit vector.
    UnitComponent: "a number from -1 to 1", |x| x.abs() <= 1.0, { "minimum": -1, "maximum": 1 }
}
number! {
    /// A span of time that a run may take [s].
    SpanS: "a time greater than 0 and at most 86400 s", |x| x > 0.0 && x <= 86_400.0,
    { "exclusiveMinimum": 0, "maximum": 86400 }
}
number! {
    /// A time before something that comes within a day [s].
    DelayS: "a time from 0 to 86400 s", |x| (0.0..=86_400.0).contains(&x), { "minimum": 0, "maximum": 86400 }
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

impl<const LOW: u64, const HIGH: u64> JsonSchema for Count<LOW, HIGH> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        format!("Count{LOW}To{HIGH}").into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "integer", "minimum": LOW, "maximum": HIGH })
    }
}

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

impl<T: JsonSchema, const N: usize> JsonSchema for Exactly<T, N> {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        format!("{}_{N}", T::schema_name()).into()
    }
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let items = generator.subschema_for::<T>();
        json_schema!({ "type": "array", "items": items, "minItems": N, "maxItems": N })
    }
}

impl<const N: usize> Exactly<Finite, N> {
    /// The bare numbers.
    pub(super) fn get(self) -> [f64; N] {
        self.0.map(Finite::get)
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

impl JsonSchema for Name {
    fn inline_schema() -> bool {
        true
    }
    fn schema_name() -> Cow<'static, str> {
        "Name".into()
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "pattern": "^[A-Za-z0-9_-]{1,64}$" })
    }
}
