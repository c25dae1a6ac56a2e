//! The lines of a campaign, as `samara assess` writes them, read for what campaigns can be compared by.

use std::collections::BTreeSet;
use std::io::{self, BufRead as _, BufReader, Read};

use samara_core::assess::outcome::{ALTITUDE_LOST, J_TPF, PEAK_SPEED, PEAK_TILT, STEADY_AFTER};
use samara_core::assess::{ByTrial, Quantity, Share};
use samara_mission::Mission;
use samara_mission::bounded::BoundedLines;
use samara_report::json::VERSION;

/// Lines of the head.
const HEAD_LINES: usize = 4;
/// Longest line that is read [bytes].
const LINE_MOST: usize = 1 << 16;
/// Most trials of a campaign.
const TRIALS_MOST: usize = 100_000_000;

/// The quantities that are compared.
pub(super) const QUANTITIES: [Quantity; 5] = [J_TPF, ALTITUDE_LOST, STEADY_AFTER, PEAK_SPEED, PEAK_TILT];

/// A campaign by one way to fly.
#[derive(Clone, Debug, PartialEq)]
pub struct CampaignLines {
    /// Version of samara that flew it.
    pub version: String,
    /// Seed of its draws.
    pub seed: u64,
    /// The campaign in the words of its file.
    pub flown: String,
    /// SHA-256 of what it was flown with.
    pub input_hash: String,
    /// Numbers of the trials.
    pub trials: BTreeSet<u64>,
    /// Those that failed, where the lines say so.
    pub failed: Option<BTreeSet<u64>>,
    /// The values of each of [`QUANTITIES`], with a place for every trial.
    pub(super) quantities: [ByTrial; QUANTITIES.len()],
}

/// Why a file is not the lines of a campaign of this mission.
#[derive(Debug, thiserror::Error)]
pub enum LinesError {
    /// The head is not what `samara assess` writes.
    #[error("line {line}: `{expected}` is expected: the lines of a campaign, as `samara assess` writes them")]
    Head {
        /// Number of the line, from 1.
        line: usize,
        /// Expected in its place.
        expected: &'static str,
    },
    /// The campaign is of other inputs.
    #[error("this campaign is of another {what}: {found}, expected {expected}")]
    Other {
        /// Name of the difference.
        what: &'static str,
        /// The value in the file.
        found: String,
        /// The mission's own.
        expected: String,
    },
    /// A column is missing.
    #[error("there is no column {0}")]
    Column(&'static str),
    /// A line is not one of a trial.
    #[error("line {line}, {column}: {expected} is expected, found `{found}`")]
    Cell {
        /// Number of the line, from 1.
        line: u64,
        /// The column.
        column: String,
        /// Expected in its place.
        expected: &'static str,
        /// Found in the file.
        found: String,
    },
    /// A trial stands there twice.
    #[error("line {line}: trial {trial} stands there twice")]
    Twice {
        /// Number of the line, from 1.
        line: u64,
        /// The trial.
        trial: u64,
    },
    /// There are more trials than any campaign has.
    #[error("more than {TRIALS_MOST} trials stand there")]
    Endless,
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// The file is no CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
}

impl CampaignLines {
    /// Reads the lines of a campaign of this mission and seed, with one of these sets of inputs: a campaign
    /// by PX4 or by its model has the parameter file among them.
    ///
    /// # Errors
    /// [`LinesError`]: it is no such file, or is of other inputs, another seed or another version of samara;
    /// it has no end, or a line that has none.
    pub fn read(from: impl Read, mission: &Mission, input_hashes: &[&str]) -> Result<Self, LinesError> {
        Self::read_if(from, |head| head.check(mission, input_hashes))
    }

    /// Reads the lines of a campaign of any mission, seed and version of samara.
    ///
    /// # Errors
    /// [`LinesError`]: it is no such file; it has no end, or a line that has none.
    pub fn read_any(from: impl Read) -> Result<Self, LinesError> {
        Self::read_if(from, |_| Ok(()))
    }

    /// How many did not fail, where the lines say so.
    pub fn safe(&self) -> Option<Share> {
        let (failed, trials) = (self.failed.as_ref()?.len() as u64, self.trials.len() as u64);
        Some(Share::of(trials - failed, trials))
    }

    /// The values of a quantity by the number of the trial; nothing of one that is not read.
    pub fn values(&self, quantity: &Quantity) -> Option<&ByTrial> {
        let place = QUANTITIES.iter().position(|read| read == quantity)?;
        self.quantities.get(place)
    }

    fn read_if(
        from: impl Read,
        check: impl FnOnce(&Head) -> Result<(), LinesError>,
    ) -> Result<Self, LinesError> {
        let mut from = BufReader::new(BoundedLines::new(from, LINE_MOST));
        let mut top = String::new();
        for _ in 0..HEAD_LINES {
            from.read_line(&mut top)?;
        }
        let head = Head::of(&top)?;
        check(&head)?;
        // The head once more, so that lines are counted from the file's first.
        let whole = top.as_bytes().chain(from);
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(whole);
        let names = reader.headers()?.clone();
        let place = |column: &str| names.iter().position(|name| name == column);
        let trial_at = place("trial").ok_or(LinesError::Column("trial"))?;
        let mut places = [0; QUANTITIES.len()];
        for (at, quantity) in places.iter_mut().zip(&QUANTITIES) {
            *at = place(quantity.key).ok_or(LinesError::Column(quantity.key))?;
        }
        let failure_at = place("failure");
        let Head { version, seed, input_hash, flown } = head;
        let mut lines = Self {
            version,
            seed,
            flown,
            input_hash,
            trials: BTreeSet::new(),
            failed: failure_at.map(|_| BTreeSet::new()),
            quantities: Default::default(),
        };
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, csv::Position::line);
            let cell = |at: usize| record.get(at).unwrap_or_default();
            let bad = |at: usize, expected| LinesError::Cell {
                line,
                column: names.get(at).unwrap_or_default().to_owned(),
                expected,
                found: cell(at).to_owned(),
            };
            let trial: u64 = cell(trial_at).parse().map_err(|_| bad(trial_at, "the number of a trial"))?;
            if !lines.trials.insert(trial) {
                return Err(LinesError::Twice { line, trial });
            }
            if lines.trials.len() > TRIALS_MOST {
                return Err(LinesError::Endless);
            }
            for (values, at) in lines.quantities.iter_mut().zip(places) {
                let value: Option<f64> = match cell(at) {
                    "" => None,
                    text => Some(text.parse().map_err(|_| bad(at, "a number, or nothing,"))?),
                };
                values.insert(trial, value.filter(|x| x.is_finite()));
            }
            if let (Some(at), Some(failed)) = (failure_at, &mut lines.failed)
                && !cell(at).is_empty()
            {
                failed.insert(trial);
            }
        }
        Ok(lines)
    }
}

/// The comment lines at the top.
struct Head {
    version: String,
    seed: u64,
    input_hash: String,
    flown: String,
}

impl Head {
    fn of(text: &str) -> Result<Self, LinesError> {
        let mut comments = text.lines().take_while(|line| line.starts_with('#'));
        let mut after = |line: usize, expected: &'static str| {
            let rest = comments.next().and_then(|comment| comment.strip_prefix(expected));
            rest.map(|rest| rest.trim().to_owned()).ok_or(LinesError::Head { line, expected })
        };
        let version = after(1, "# samara ")?;
        let seed = after(2, "# seed ")?.parse();
        let seed = seed.map_err(|_| LinesError::Head { line: 2, expected: "# seed " })?;
        let input_hash = after(3, "# inputs sha256 ")?;
        // Without the gains themselves, in brackets.
        let flown = after(4, "# ")?;
        let flown = match (flown.find(" ["), flown.find(']')) {
            (Some(from), Some(to)) if from < to => format!("{}{}", &flown[..from], &flown[to + 1..]),
            _ => flown,
        };
        Ok(Self { version, seed, input_hash, flown })
    }

    /// Refuses what is not of this mission, its seed and one of these sets of inputs, by this version.
    fn check(&self, mission: &Mission, input_hashes: &[&str]) -> Result<(), LinesError> {
        let own = input_hashes.first().copied().unwrap_or_default();
        let expected_hash = match input_hashes.contains(&self.input_hash.as_str()) {
            true => self.input_hash.clone(),
            false => format!("{own}, or that of the same mission by another autopilot"),
        };
        let pairs = [
            ("version of samara", self.version.clone(), VERSION.to_owned()),
            ("seed", self.seed.to_string(), mission.seed.to_string()),
            ("set of inputs", self.input_hash.clone(), expected_hash),
        ];
        match pairs.into_iter().find(|(_, found, expected)| found != expected) {
            None => Ok(()),
            Some((what, found, expected)) => Err(LinesError::Other { what, found, expected }),
        }
    }
}
