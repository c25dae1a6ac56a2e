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
use std::fmt::{self, Display, Formatter, Write as _};
use std::ops::RangeInclusive;

use samara_core::units::{UnitError, in_unit};

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
    /// Whether few ask for it: a short help leaves it out.
    pub rare: bool,
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
/// what its value is called in a help (with `...` behind it, it may be given more than once), behind the type
/// the usual value as it is typed, and what reads it; `rare` stands behind what a short help leaves out.
#[macro_export]
macro_rules! settings {
    ($(#[$about:meta])* $visible:vis $name:ident {
        $($(#[doc = $help:literal])+ $field:ident($value:literal): $type:ty = $usual:literal, $read:expr
            $(, $rare:ident)?;)*
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
                rare: [$(stringify!($rare).len(),)? 0][0] > 0,
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

/// The text of a value that is left to what is usual.
pub const LEFT: &str = "default";

/// A value that may be left to what is usual, by the text [`LEFT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Maybe<T>(pub Option<T>);

impl<T: Display> Display for Maybe<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Some(value) => value.fmt(f),
            None => f.write_str(LEFT),
        }
    }
}

/// What reads a value that may be left to what is usual.
pub fn maybe<T>(read: impl Fn(&str) -> Result<T, String>) -> impl Fn(&str) -> Result<Maybe<T>, String> {
    move |text| if text == LEFT { Ok(Maybe(None)) } else { read(text).map(|value| Maybe(Some(value))) }
}

/// A word of a few, and what it means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word<T> {
    /// The word.
    pub word: &'static str,
    /// Meaning of the word.
    pub means: T,
}

impl<T> Display for Word<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.word)
    }
}

/// One of a few words.
pub fn one_of<T: Copy>(words: &[(&'static str, T)]) -> impl Fn(&str) -> Result<Word<T>, String> {
    move |text| {
        let found = words.iter().find(|(word, _)| *word == text);
        found.map(|&(word, means)| Word { word, means }).ok_or_else(|| {
            let words: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            format!("one of {} is expected", words.join(", "))
        })
    }
}

/// Some values, as they are typed with this character between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Several<T, const BETWEEN: char>(pub Vec<T>);

impl<T: Display, const BETWEEN: char> Display for Several<T, BETWEEN> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        for (i, value) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_char(BETWEEN)?;
            }
            value.fmt(f)?;
        }
        Ok(())
    }
}

/// What reads some values with a character between them.
pub fn several<T, const BETWEEN: char>(
    read: impl Fn(&str) -> Result<T, String>,
) -> impl Fn(&str) -> Result<Several<T, BETWEEN>, String> {
    move |text| {
        let values = text.split(BETWEEN).filter(|value| !value.is_empty()).map(&read);
        values.collect::<Result<_, _>>().map(Several)
    }
}

/// A name that is also the name of a file.
pub fn plain_name(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let fits = !text.is_empty() && text.chars().all(plain);
    fits.then(|| text.to_owned()).ok_or_else(|| "letters, digits, _ and - are expected".to_owned())
}

/// A positive number.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text, |x| x.is_finite() && x > 0.0, "a positive number is expected")
}

/// A number in a unit, alone or with another unit of the kind behind it (`160mm`), that fits; otherwise what
/// is expected.
pub fn measured(text: &str, unit: &str, fits: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    match in_unit(text, unit) {
        Ok(x) if fits(x) => Ok(x),
        Err(error @ UnitError::Unit(..)) => Err(error.to_string()),
        _ => Err(expected.to_owned()),
    }
}

/// A positive number in a unit, alone or with another unit of the kind behind it.
pub fn positive_in(
    unit: &'static str,
) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static {
    move |text| measured(text, unit, |x| x > 0.0, "a positive number is expected")
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
