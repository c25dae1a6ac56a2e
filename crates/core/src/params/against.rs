//! The version of PX4 that parameters are held against, and why that one.

use std::fmt;

use super::file::ParameterFile;
use super::metadata::Metadata;
use crate::control::px4::Law;
use crate::control::px4::versions::Number;

/// What named a version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedBy {
    /// Whoever asks.
    Asked,
    /// The PX4 that flies, or the model of one.
    Flown,
    /// The file, by the line `# Version:` of its header.
    File,
    /// Nothing: it is the newest that is known.
    Nothing,
}

impl NamedBy {
    /// Name of it in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Asked => "asked",
            Self::Flown => "flown",
            Self::File => "file",
            Self::Nothing => "nothing",
        }
    }
}

/// The version of PX4 that parameters are held against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Against {
    /// The version's parameters.
    pub metadata: Metadata,
    /// The version that was named; another one than the parameters' where that is not known.
    pub named: Option<Number>,
    /// What named it.
    pub by: NamedBy,
}

impl Against {
    /// The newest version that is known.
    pub fn newest() -> Self {
        Self { metadata: Metadata::newest(), named: None, by: NamedBy::Nothing }
    }

    /// A version that was asked for.
    pub fn asked(version: Number) -> Self {
        Self { metadata: Metadata::of(version), named: Some(version), by: NamedBy::Asked }
    }

    /// The version of the PX4 that flies.
    pub fn flown(version: Number) -> Self {
        Self { by: NamedBy::Flown, ..Self::asked(version) }
    }

    /// The version of a law that flies.
    pub fn of_law(law: &Law) -> Self {
        law.since.parse().map_or_else(|_| Self::newest(), Self::flown)
    }

    /// The version that a file names, or the newest that is known.
    pub fn of(file: &ParameterFile) -> Self {
        file.version().map_or_else(Self::newest, |version| Self { by: NamedBy::File, ..Self::asked(version) })
    }
}

/// Writes the version, and what named it: `PX4 v1.16 (the file's)`.
impl fmt::Display for Against {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let held = self.metadata.version();
        write!(f, "PX4 {held} (")?;
        if let Some(named) = self.named.filter(|named| *named != held) {
            let end = if named < held { "oldest" } else { "newest" };
            write!(f, "the {end} that is known, for {named}, ")?;
        }
        f.write_str(match self.by {
            NamedBy::Asked => "as asked)",
            NamedBy::Flown => "which flies)",
            NamedBy::File => "as the file says)",
            NamedBy::Nothing => "the newest that is known: no version is named)",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_says_which_version_and_why() {
        let of = |head: &str| {
            let file = ParameterFile::parse(&format!("{head}1\t1\tMC_PITCH_P\t4\t9\n")).unwrap();
            Against::of(&file).to_string()
        };
        assert_eq!(of("# Version: 1.16.0\n"), "PX4 v1.16 (as the file says)");
        assert_eq!(of("# Version: 1.14.3-rc2 \n"), "PX4 v1.14 (as the file says)");
        assert_eq!(
            of("# Version: 1.10.1\n"),
            "PX4 v1.12 (the oldest that is known, for v1.10, as the file says)"
        );
        let newest = "PX4 v1.18 (the newest that is known: no version is named)";
        assert_eq!([of(""), of("# Version: samara 0.2.0\n"), of("# Version: none\n")], [newest; 3]);
        let number = |minor| Number { major: 1, minor };
        assert_eq!(Against::asked(number(13)).to_string(), "PX4 v1.13 (as asked)");
        assert_eq!(Against::flown(number(16)).to_string(), "PX4 v1.16 (which flies)");
    }
}
