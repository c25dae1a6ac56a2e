//! Whether the estimate is good enough to fly by, for autopilots that fly on one: a reason not to arm while
//! it is not, and said when it becomes so, when it ceases to be so, and when it does not become so for long.

use super::estimator::NotAligned;
use super::event::Severity;

/// After this time without alignment it is reported what is wanting [us].
const PATIENCE_US: u64 = 15_000_000;

/// What is known of the alignment. Without an estimator nothing is ever wanting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Alignment {
    now: Result<(), NotAligned>,
    /// When the filter was first heard of [us].
    since_us: Option<u64>,
    /// What the crew knows: aligned or not; `None` before anything was said.
    reported: Option<bool>,
}

impl Default for Alignment {
    fn default() -> Self {
        Self { now: Ok(()), since_us: None, reported: None }
    }
}

impl Alignment {
    pub(super) fn now(&self) -> Result<(), NotAligned> {
        self.now
    }

    /// Takes the alignment of a step; what is worth saying of it.
    pub(super) fn follow(
        &mut self,
        now_us: u64,
        aligned: Result<(), NotAligned>,
    ) -> Option<(Severity, String)> {
        self.now = aligned;
        let waited_us = now_us.saturating_sub(*self.since_us.get_or_insert(now_us));
        let news = match (aligned, self.reported) {
            (Ok(()), Some(true)) | (Err(_), Some(false)) => return None,
            (Err(_), None) if waited_us < PATIENCE_US => return None,
            (Ok(()), _) => (Severity::Info, "estimator aligned".to_owned()),
            (Err(why), None) => {
                (Severity::Warning, format!("{} s not aligned: {why}", PATIENCE_US / 1_000_000))
            }
            (Err(why), Some(true)) => (Severity::Critical, why.to_string()),
        };
        self.reported = Some(aligned.is_ok());
        Some(news)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_each_change_is_reported_once_and_waiting_only_when_it_is_long() {
        let mut alignment = Alignment::default();
        assert_eq!(alignment.now(), Ok(()), "no estimator, nothing wanting");
        let mut follow =
            |s: u64, aligned| alignment.follow(s * 1_000_000, aligned).map(|(severity, _)| severity);
        let (lost, waiting) = (Err(NotAligned::NoFix), Err(NotAligned::NoSatellites));
        assert_eq!([follow(4, waiting), follow(18, waiting)], [None; 2]);
        assert_eq!([follow(19, waiting), follow(40, waiting)], [Some(Severity::Warning), None]);
        assert_eq!([follow(41, Ok(())), follow(42, Ok(()))], [Some(Severity::Info), None]);
        assert_eq!([follow(43, lost), follow(44, lost)], [Some(Severity::Critical), None]);
        assert_eq!(follow(45, Ok(())), Some(Severity::Info));
    }
}
