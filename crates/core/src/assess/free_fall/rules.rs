//! Rules that could tell a fall from a descent, side by side on the same readings, for the choice among them.
//!
//! Each is a statistic that grows while the specific force is below a level and is zero when nothing speaks
//! for a fall; a rule finds a fall when its statistic reaches a threshold, and may find another once it has
//! been back at zero.

/// Levels of the specific force that are compared, as shares of gravity.
pub const LEVELS: [f64; 6] = [0.15, 0.2, 0.3, 0.4, 0.5, 0.6];
/// Times that are compared [s]: in which a fall is found that begins at once and without noise.
pub const TIMES_S: [f64; 6] = [0.05, 0.075, 0.1, 0.15, 0.2, 0.3];
/// Number of all rules.
pub const RULES: usize = 2 * LEVELS.len() * TIMES_S.len();

/// What a rule sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RuleKind {
    /// The lack of specific force, less what is more than the level:
    /// [`FreeFallDetector`](crate::control::FreeFallDetector)'s.
    Lack,
    /// The time without a reading at or above the level: PX4's, whose LNDMC_FFALL_THR and LNDMC_FFALL_TTRI
    /// are 2 m/s^2 and 0.3 s.
    Hold,
}

impl RuleKind {
    /// Both kinds.
    pub const ALL: [Self; 2] = [Self::Lack, Self::Hold];

    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lack => "lack",
            Self::Hold => "hold",
        }
    }
}

/// A rule: what it sums, its level and its time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Kind of what is summed.
    pub kind: RuleKind,
    /// Level, as a share of gravity.
    pub level: f64,
    /// Time in which a clean fall is found [s].
    pub time_s: f64,
}

impl Rule {
    /// Every rule, in the order in which they are counted: by kind, level and time.
    pub fn all() -> impl Iterator<Item = Self> {
        RuleKind::ALL.into_iter().flat_map(|kind| {
            LEVELS
                .into_iter()
                .flat_map(move |level| TIMES_S.into_iter().map(move |time_s| Self { kind, level, time_s }))
        })
    }
}

/// The statistic of a kind at a level, and which of its times it has reached since it was last zero.
#[derive(Clone, Copy, Debug)]
struct Statistic {
    kind: RuleKind,
    level_m_s2: f64,
    /// Threshold per second of a rule's time.
    per_s: f64,
    value: f64,
    reached: usize,
    /// Whether the riser was slack since it was last zero.
    slack: bool,
}

/// All rules at work on one vehicle's readings.
#[derive(Clone, Debug)]
pub struct Rules {
    statistics: Vec<Statistic>,
}

impl Rules {
    /// Rules that have read nothing, under gravity [m/s^2], where the air carries `fall_m_s2` [m/s^2] of a
    /// vehicle that has been released. A level below that finds nothing by the lack.
    pub fn new(gravity_m_s2: f64, fall_m_s2: f64) -> Self {
        let statistic = |kind, level: f64| {
            let level_m_s2 = level * gravity_m_s2;
            let per_s = match kind {
                RuleKind::Lack if level_m_s2 > fall_m_s2 => level_m_s2 - fall_m_s2,
                RuleKind::Lack => f64::INFINITY,
                RuleKind::Hold => 1.0,
            };
            Statistic { kind, level_m_s2, per_s, value: 0.0, reached: 0, slack: false }
        };
        let statistics =
            RuleKind::ALL.into_iter().flat_map(|kind| LEVELS.map(|level| statistic(kind, level)));
        Self { statistics: statistics.collect() }
    }

    /// Takes the size of the specific force [m/s^2] that has been for `dt_s` [s], and whether the riser was
    /// slack; calls `found` with the number of each rule that finds a fall by it, and whether the riser was
    /// slack since it began.
    pub fn take(&mut self, force_m_s2: f64, dt_s: f64, slack: bool, mut found: impl FnMut(usize, bool)) {
        for (k, statistic) in self.statistics.iter_mut().enumerate() {
            let lack_m_s2 = statistic.level_m_s2 - force_m_s2;
            let value = match statistic.kind {
                RuleKind::Lack => (statistic.value + lack_m_s2 * dt_s).max(0.0),
                RuleKind::Hold if lack_m_s2 > 0.0 => statistic.value + dt_s,
                RuleKind::Hold => 0.0,
            };
            statistic.value = value;
            if value == 0.0 {
                (statistic.reached, statistic.slack) = (0, false);
                continue;
            }
            statistic.slack |= slack;
            // Sums of steps come a rounding short of a time that is a multiple of them.
            while statistic.reached < TIMES_S.len()
                && value >= (TIMES_S[statistic.reached] - 1e-9) * statistic.per_s
            {
                found(k * TIMES_S.len() + statistic.reached, statistic.slack);
                statistic.reached += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clean fall is found by every rule after its own time, a short spell by those alone that are shorter;
    /// each rule finds it once.
    #[test]
    fn closed_form_each_rule_finds_a_clean_fall_after_its_time() {
        let (g, dt_s) = (9.8, 0.001);
        let mut rules = Rules::new(g, 0.0);
        let mut found = vec![Vec::new(); RULES];
        let fall = |step: u32| (500..620).contains(&step) || step >= 1000;
        for step in 0..1400 {
            let force = if fall(step) { 0.0 } else { g };
            rules.take(force, dt_s, step < 620, |rule, slack| found[rule].push((step, slack)));
        }
        for (rule, found) in Rule::all().zip(found) {
            let steps = (rule.time_s / dt_s).round() as u32 - 1;
            let spell = (rule.time_s < 0.12).then_some((500 + steps, true));
            let wanted: Vec<(u32, bool)> = spell.into_iter().chain([(1000 + steps, false)]).collect();
            assert_eq!(found, wanted, "{rule:?}");
        }
    }

    /// A single reading above the level undoes a hold and takes from a lack no more than it is above.
    #[test]
    fn closed_form_a_spike_undoes_a_hold_alone() {
        let mut rules = Rules::new(10.0, 0.0);
        let mut found = Vec::new();
        for step in 0..100 {
            let force = if step == 60 { 5.0 } else { 0.0 };
            rules.take(force, 0.001, false, |rule, _| found.push(rule));
        }
        let has = |kind, level: f64, time_s: f64| {
            let number = Rule::all().position(|r| r == Rule { kind, level, time_s }).unwrap();
            found.contains(&number)
        };
        assert!(has(RuleKind::Lack, 0.3, 0.075) && !has(RuleKind::Hold, 0.3, 0.075));
        assert!(has(RuleKind::Hold, 0.3, 0.05) && has(RuleKind::Hold, 0.6, 0.1));
    }
}
