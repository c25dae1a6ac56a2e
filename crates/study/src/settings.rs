//! The settings of a kind of study, declared once: options of the program, keywords of Python, circumstances
//! in a manifest, lines of a help are made of one table.
//!
//! ```text
//! settings! {
//!     /// How what decides is estimated.
//!     pub SobolSettings {
//!         /// Trials of each of the two samples.
//!         points("N"): usize = "2048", whole(64..=1_000_000);
//!     }
//! }
//! ```

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// A setting of a kind of study.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Name: `per_level` is the option `--per-level` and the keyword `per_level`.
    pub name: &'static str,
    /// What stands for its value in a help; of a switch, which is on or off, it is empty.
    pub value: &'static str,
    /// Text of the usual value.
    pub usual: &'static str,
    /// Sentences about it, the first of which says what it is.
    pub about: &'static str,
    /// Reads a value: the text that means it, or what is expected.
    pub read: fn(&str) -> Result<String, String>,
}

/// Values of settings, as texts that were read.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Values(BTreeMap<&'static str, String>);

impl Values {
    /// Those of a table, each as usual.
    pub fn usual(table: &[Setting]) -> Self {
        let usual = |setting: &Setting| (setting.name, (setting.read)(setting.usual).unwrap_or_default());
        Self(table.iter().map(usual).collect())
    }

    /// Gives a setting of a table another value.
    ///
    /// # Errors
    /// What is expected in place of the value, or of the name.
    pub fn put(&mut self, table: &[Setting], name: &str, value: &str) -> Result<(), String> {
        let Some(setting) = table.iter().find(|setting| setting.name == name) else {
            let names: Vec<&str> = table.iter().map(|setting| setting.name).collect();
            return Err(format!("no such setting; expected one of {}", names.join(", ")));
        };
        let value = (setting.read)(value).map_err(|expected| format!("{expected}, found `{value}`"))?;
        self.0.insert(setting.name, value);
        Ok(())
    }

    /// The text of a setting; nothing where there is none of this name.
    pub fn text(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// Names and texts, in the order of a table.
    pub fn in_order(&self, table: &[Setting]) -> Vec<(&'static str, String)> {
        table.iter().map(|setting| (setting.name, self.text(setting.name).to_owned())).collect()
    }
}

/// Settings of a kind of study: a struct, and the table that declares it. Behind a name stands in brackets
/// what its value is called in a help, behind the type the usual value as it is typed, and what reads it.
#[macro_export]
macro_rules! settings {
    ($(#[$about:meta])* $visible:vis $name:ident {
        $($(#[doc = $help:literal])+ $field:ident($value:literal): $type:ty = $usual:literal, $read:expr;)*
    }) => {
        $(#[$about])*
        #[derive(Clone, Debug)]
        $visible struct $name {
            $($(#[doc = $help])+ pub $field: $type,)*
        }

        impl $name {
            /// The table of the settings.
            pub const TABLE: &'static [$crate::settings::Setting] = &[$($crate::settings::Setting {
                name: stringify!($field),
                value: $value,
                usual: $usual,
                about: concat!($($help, "\n"),+),
                read: |text| ($read)(text).map(|value: $type| value.to_string()),
            }),*];

            /// The settings of values that were read.
            ///
            /// # Errors
            /// Where a value is not one of such a setting.
            pub fn of(values: &$crate::settings::Values) -> Result<Self, String> {
                Ok(Self {
                    $($field: ($read)(values.text(stringify!($field)))
                        .map_err(|expected: String| format!("{}: {expected}", stringify!($field)))?,)*
                })
            }
        }
    };
}

/// A whole number in a range, in digits or as `1e8`.
pub fn whole<N: TryFrom<u64>>(
    range: RangeInclusive<u64>,
) -> impl Fn(&str) -> Result<N, String> + Clone + Send + Sync + 'static {
    move |text| {
        // Below 2^53 every whole number is one of f64's.
        let scaled = || text.parse().ok().filter(|x: &f64| x.fract() == 0.0 && (0.0..9e15).contains(x));
        let number = text.parse::<u64>().ok().or_else(|| Some(scaled()? as u64));
        let number = number.filter(|n| range.contains(n));
        number
            .and_then(|n| N::try_from(n).ok())
            .ok_or_else(|| format!("a whole number from {} to {} is expected", range.start(), range.end()))
    }
}

/// A number that fits; otherwise what is expected.
pub fn number(text: &str, fits: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| fits(*x)).ok_or_else(|| expected.to_owned())
}

/// A bound on J_TPF.
pub fn bound(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x <= 1e6, "a number above 0, up to 1e6, is expected")
}

/// On or off.
pub fn switch(text: &str) -> Result<bool, String> {
    text.parse().map_err(|_| "`true` or `false` is expected".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    settings! {
        /// Settings of these tests.
        Tried {
            /// How many.
            ///
            /// There may be more.
            count("N"): u64 = "1e3", whole(2..=5000);
            /// Whether they are wet.
            wet(""): bool = "false", switch;
        }
    }

    /// A value is kept as the text that means it, and read back as what it means.
    #[test]
    fn settings_are_read_once_and_mean_what_they_say() {
        let mut values = Values::usual(Tried::TABLE);
        assert_eq!(values.in_order(Tried::TABLE), [("count", "1000".into()), ("wet", "false".into())]);
        values.put(Tried::TABLE, "count", "2.5e3").unwrap();
        values.put(Tried::TABLE, "wet", "true").unwrap();
        let Tried { count, wet } = Tried::of(&values).unwrap();
        assert_eq!((count, wet, values.text("count")), (2500, true, "2500"));
        let refused = |name: &str, value: &str| values.clone().put(Tried::TABLE, name, value).unwrap_err();
        assert_eq!(refused("count", "1"), "a whole number from 2 to 5000 is expected, found `1`");
        assert_eq!(refused("dry", "1"), "no such setting; expected one of count, wet");
        assert!(Tried::of(&Values::default()).is_err());
    }

    #[test]
    fn whole_numbers_are_read_in_digits_and_as_powers_of_ten() {
        let trials = whole::<u64>(2..=1_000_000_000);
        for (text, number) in [("17", 17), ("1e8", 100_000_000), ("2.5e3", 2500), ("1E+9", 1_000_000_000)] {
            assert_eq!(trials(text), Ok(number), "{text}");
        }
        for text in ["1", "1e10", "1.5", "1e-3", "-2", "nan", "inf", "", "1e400", "many"] {
            assert_eq!(trials(text), Err("a whole number from 2 to 1000000000 is expected".into()), "{text}");
        }
        assert_eq!(whole::<u64>(0..=u64::MAX)("18446744073709551615"), Ok(u64::MAX));
    }
}
