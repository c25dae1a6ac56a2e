//! What is asked of campaigns, declared once.

use samara_mission::Mission;

use super::Keep;
use crate::asked::Asked;
use crate::settings;
use crate::settings::{Setting, Values, bound, whole};

settings! {
    /// What is asked of campaigns. Nothing typed of trials and lines means what the mission has, and what is
    /// usual of so many.
    pub CampaignSettings {
        /// Trials of each campaign.
        ///
        /// Instead of the mission's `monte_carlo.trials`.
        trials("N"): u64 = "", whole(2..=1_000_000_000);
        /// Lines to keep of the trials: `all`, those of `failures`, or none.
        ///
        /// `summary` keeps the statistics alone: quantiles to half a bin (docs/clusters.md), and nothing to
        /// go on from. [default: all, of more than 1000000 trials summary]
        keep("LINES"): Keep = "", str::parse;
        /// J_TPF that a safe trial stays below.
        bound("B"): f64 = "1", bound;
    }
}

/// Of campaigns of a mission's own gains.
pub const OWN: &[Setting] = CampaignSettings::TABLE;
/// Of the paper's study, whose differences are taken line by line.
pub const PAPER: &[Setting] = &[OWN[0], OWN[2]];
/// Of whole drops, which the mission's limits judge.
pub const DROPS: &[Setting] = &[OWN[0], OWN[1]];

impl CampaignSettings {
    /// The settings of a mission's campaigns, and their texts.
    ///
    /// # Errors
    /// Where a value is not one of such a setting.
    pub fn of_mission(values: &Values, mission: &Mission) -> Result<(Self, Values), String> {
        let mut values = values.clone();
        let mut fill = |name: &str, text: String| match values.text(name) {
            "" => values.put(Self::TABLE, name, &text).map(|()| text),
            text => Ok(text.to_owned()),
        };
        let trials = fill("trials", mission.study.monte_carlo.trials.to_string())?;
        fill("keep", Keep::usual(trials.parse().unwrap_or_default()).to_string())?;
        fill("bound", "1".to_owned())?;
        Ok((Self::of(&values)?, values))
    }
}

/// The settings of a table as options of a command: how many trials, and what is not as usual.
pub fn options(table: &[Setting], asked: &Asked) -> Vec<String> {
    let text = |name: &str| asked.settings.iter().find(|(of, _)| of == name).map(|(_, text)| text.as_str());
    let trials = text("trials").and_then(|text| text.parse().ok()).unwrap_or_default();
    let usual = |name: &str| match name {
        "keep" => Keep::usual(trials).to_string(),
        name => Values::usual(table).text(name).to_owned(),
    };
    let told = table.iter().filter_map(|setting| Some((setting.name, text(setting.name)?)));
    let unusual = told.filter(|(name, text)| *text != usual(name));
    unusual.flat_map(|(name, text)| [format!("--{name}"), text.to_owned()]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_typed_is_the_missions() {
        let mission = Mission::shipped("x500_drop").unwrap();
        let trials = mission.study.monte_carlo.trials as u64;
        let (settings, values) = CampaignSettings::of_mission(&Values::usual(OWN), &mission).unwrap();
        assert_eq!((settings.trials, settings.keep, settings.bound), (trials, Keep::All, 1.0));
        assert_eq!(values.in_order(DROPS), [("trials", trials.to_string()), ("keep", "all".to_owned())]);
        let mut many = Values::usual(OWN);
        many.put(OWN, "trials", "1e8").unwrap();
        many.put(OWN, "bound", "0.5").unwrap();
        let (settings, _) = CampaignSettings::of_mission(&many, &mission).unwrap();
        assert_eq!((settings.trials, settings.keep, settings.bound), (100_000_000, Keep::Summary, 0.5));
    }

    #[test]
    fn options_are_how_many_trials_and_what_is_unusual() {
        let mission = Mission::shipped("x500_drop").unwrap();
        let words = |more: &[(&str, &str)]| {
            let mut values = Values::usual(OWN);
            more.iter().for_each(|(name, text)| values.put(OWN, name, text).unwrap());
            let (_, values) = CampaignSettings::of_mission(&values, &mission).unwrap();
            options(OWN, &Asked::of("own", OWN, &values, &mission)).join(" ")
        };
        assert_eq!(words(&[("trials", "40"), ("keep", "all"), ("bound", "1.0")]), "--trials 40");
        let unusual = [("trials", "1e8"), ("keep", "all"), ("bound", "0.5")];
        assert_eq!(words(&unusual), "--trials 100000000 --keep all --bound 0.5");
    }

    /// Each kind's settings are those of one table.
    #[test]
    fn tables_of_the_kinds_are_parts_of_one() {
        let names = |table: &[Setting]| table.iter().map(|setting| setting.name).collect::<Vec<_>>();
        assert_eq!(names(PAPER), ["trials", "bound"]);
        assert_eq!(names(DROPS), ["trials", "keep"]);
    }
}
