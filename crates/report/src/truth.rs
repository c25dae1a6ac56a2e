//! Two flights' `flight.csv` held against each other: is the truth the same, to the last digit?
//!
//! Comment lines, which hold the inputs' hash, are passed over, and so are the columns of the setpoint: it
//! went on another link than what the simulator was told, as another kind of number.

use super::json::{Head, object, text};
use samara_mission::Mission;

/// Columns that are not compared.
const SETPOINT: [&str; 3] = ["vn_sp_m_s", "ve_sp_m_s", "vd_sp_m_s"];

/// What came of the comparison.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Truth {
    /// So many rows are the same, and there are no others.
    Equal {
        /// The rows.
        rows: usize,
    },
    /// The files have other columns.
    OtherColumns,
    /// One has more rows; those that both have are the same.
    OtherLength {
        /// Rows of the one that was recorded.
        recorded: usize,
        /// Rows of the one that was flown again.
        replayed: usize,
    },
    /// A field differs, the first.
    Differs {
        /// Line of the recorded file, from 1.
        line: usize,
        /// Simulated time, as the file has it [s].
        t_s: String,
        /// Name of the column.
        column: String,
        /// The field as it was recorded.
        recorded: String,
        /// The field as it was flown again.
        replayed: String,
    },
}

impl Truth {
    /// Compares the text of a recorded `flight.csv` with that of a flight that was flown again.
    pub fn of(recorded: &str, replayed: &str) -> Self {
        let rows = |text: &str| -> Vec<(usize, String)> {
            let lines = (1..).zip(text.lines()).filter(|(_, line)| !line.starts_with('#'));
            lines.map(|(number, line)| (number, line.to_owned())).collect()
        };
        let (recorded, replayed) = (rows(recorded), rows(replayed));
        let ([(_, head), recorded @ ..], [(_, other_head), replayed @ ..]) = (&recorded[..], &replayed[..])
        else {
            return Self::OtherColumns;
        };
        if head != other_head {
            return Self::OtherColumns;
        }
        let names: Vec<&str> = head.split(',').collect();
        for ((line, a), (_, b)) in recorded.iter().zip(replayed) {
            let (mut a_fields, mut b_fields) = (a.split(','), b.split(','));
            for name in &names {
                let (a, b) = (a_fields.next().unwrap_or_default(), b_fields.next().unwrap_or_default());
                if a != b && !SETPOINT.contains(name) {
                    return Self::Differs {
                        line: *line,
                        t_s: a_first(recorded, *line),
                        column: (*name).to_owned(),
                        recorded: a.to_owned(),
                        replayed: b.to_owned(),
                    };
                }
            }
        }
        match (recorded.len(), replayed.len()) {
            (a, b) if a == b => Self::Equal { rows: a },
            (recorded, replayed) => Self::OtherLength { recorded, replayed },
        }
    }

    /// Whether all rows are the same.
    pub fn is_equal(&self) -> bool {
        matches!(self, Self::Equal { .. })
    }

    /// In words.
    pub fn text(&self) -> String {
        match self {
            Self::Equal { rows } => format!("the truth is that of flight.csv in all {rows} rows"),
            Self::OtherColumns => {
                "flight.csv has other columns: it is of another mission or version".to_owned()
            }
            Self::OtherLength { recorded, replayed } => {
                format!(
                    "flight.csv has {recorded} rows, the replay {replayed}; those that both have are the same"
                )
            }
            Self::Differs { line, t_s, column, recorded, replayed } => format!(
                "the truth differs from flight.csv first in line {line}, at {t_s} s: {column} {recorded}, replayed \
                 {replayed}"
            ),
        }
    }
}

/// What came of flying a recording again, for people: how many messages of the simulator are as recorded, the
/// first that is not, and the truth, where there is a file of it.
pub fn replay_text(equal_messages: usize, difference: Option<&str>, truth: Option<&Truth>) -> String {
    let messages = match difference {
        None => format!("all {equal_messages} messages of the simulator are as recorded\n"),
        Some(what) => {
            format!("the first {equal_messages} messages of the simulator are as recorded; {what}\n")
        }
    };
    let truth = truth.map_or("no flight.csv beside the recording".to_owned(), Truth::text);
    format!("{messages}{truth}\n")
}

/// That as a JSON object.
pub fn replay_json(
    mission: &Mission,
    equal_messages: usize,
    difference: Option<&str>,
    truth: Option<&Truth>,
) -> String {
    let truth = truth.map(|truth| object! { equal: truth.is_equal(), text: truth.text() });
    text(&object! {
        #[serde(flatten)] head: Head::of(mission),
        equal_messages: equal_messages,
        difference: difference,
        truth: truth,
    })
}

/// The first field of a line: the time.
fn a_first(rows: &[(usize, String)], line: usize) -> String {
    let row = rows.iter().find(|(number, _)| *number == line);
    row.and_then(|(_, row)| row.split(',').next()).unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: comments and setpoints do not count, the first other field is named, and so is a file that
    /// ends early or has other columns.
    #[test]
    fn the_first_difference_is_named() {
        let a = "# samara\n# seed 1\nt_s,vn_sp_m_s,north_m\n0.0,,1.0\n0.004,2.0,1.5\n";
        let same = "# other\nt_s,vn_sp_m_s,north_m\n0.0,,1.0\n0.004,,1.5\n";
        assert_eq!(Truth::of(a, same), Truth::Equal { rows: 2 });
        let differs = Truth::of(a, &same.replace("1.5", "1.25"));
        let text =
            "the truth differs from flight.csv first in line 5, at 0.004 s: north_m 1.5, replayed 1.25";
        assert_eq!(differs.text(), text);
        let short = Truth::of(a, &same.replace("0.004,,1.5\n", ""));
        assert_eq!(short, Truth::OtherLength { recorded: 2, replayed: 1 });
        for other in ["", "# only\n", "t_s,north_m\n0.0,1.0\n"] {
            assert_eq!(Truth::of(a, other), Truth::OtherColumns);
        }
    }
}
