//! What kinds of studies and campaigns have, and why one has not what it has not: the words that
//! the program says where that is asked for.

/// What a kind may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Going on after it was stopped, or killed: `--resume`.
    Resume,
    /// Parts that are flown apart, on any machines: `--shard`.
    Shard,
    /// One of its flights again, alone: `--only`.
    Only,
    /// Rows of its flights that stay, as one likes: `--keep`.
    Keep,
    /// All of it on one page of HTML.
    Page,
    /// A test case for continuous integration, as JUnit.
    Junit,
    /// Figures, as SVG.
    Figure,
    /// Tables, as CSV.
    Csv,
    /// One JSON object, also printed by `--json`.
    Json,
    /// Python flies it: a function of the wheel, or its driver of campaigns.
    Python,
    /// A line of the release card.
    Card,
}

impl Feature {
    /// All, in the order of the table.
    pub const ALL: [Self; 11] = [
        Self::Resume,
        Self::Shard,
        Self::Only,
        Self::Keep,
        Self::Page,
        Self::Junit,
        Self::Figure,
        Self::Csv,
        Self::Json,
        Self::Python,
        Self::Card,
    ];

    /// Name, in lower case: `--resume` asks for `resume`.
    pub fn name(self) -> String {
        format!("{self:?}").to_lowercase()
    }
}

/// What a kind has not, each with the reason.
pub type Refusals = &'static [(Feature, &'static str)];

/// Why what is compared is no test, and nothing for a card.
pub(crate) const COMPARES: &str = "it compares, and judges nothing";
