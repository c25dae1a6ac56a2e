//! Campaigns as they were asked for.

use super::args::AssessArgs;
use crate::cli::answer::Failure;
use crate::cli::args::{AutopilotArg, PageArgs};
use crate::cli::pilot::PilotRequest;
use crate::cli::study::args::{StudyArgs, WireArgs};
#[cfg(feature = "shards")]
use crate::cli::study::merge::{Merge, typed};
use crate::cli::study::noted;
use samara::config::Mission;
use samara::study::asked::Asked;
use samara::study::campaign::Keep;
use samara::study::campaign::settings::{CampaignSettings, OWN};
use samara::study::feature::Feature;
use samara::study::kind::About;
use samara::study::settings::Values;
use samara::study::{drops, own, paper};

/// Campaigns with all that was typed of them.
#[derive(Clone, Debug)]
pub struct CampaignOf {
    /// The kind: a mission's own, the paper's, or whole drops.
    pub about: &'static About,
    /// Options of every study.
    pub args: StudyArgs,
    /// Values of the settings, where any were typed.
    pub values: Values,
    /// The trial that is flown alone.
    pub only: Option<u64>,
    /// How often that is flown.
    pub repeat: Option<u64>,
    /// Pages of flights.
    pub page: PageArgs,
    /// The autopilot that flies whole drops.
    pub wire: WireArgs,
}

/// The kind of campaigns: by an autopilot, the paper's, or a mission's own.
pub fn about(by_autopilot: bool, paper: bool) -> &'static About {
    match (by_autopilot, paper) {
        (true, _) => &drops::ABOUT,
        (_, true) => &paper::ABOUT,
        _ => &own::ABOUT,
    }
}

impl CampaignOf {
    /// What was typed.
    pub fn typed(args: AssessArgs, only: Option<u64>) -> Self {
        let about = about(args.wire.autopilot.is_some(), args.paper);
        let AssessArgs { study, settings, repeat, page, wire, feed_forward, .. } = args;
        let wire = WireArgs { feed_forward, ..wire };
        Self { about, args: study, values: settings.values, only, repeat, page, wire }
    }

    /// What shards hold.
    #[cfg(feature = "shards")]
    pub fn noted(asked: &Asked, merge: &Merge) -> Result<Self, String> {
        let (args, wire) = typed(asked, merge)?;
        let about = about(wire.autopilot.is_some(), asked.study == paper::ABOUT.name);
        let values = asked.values(OWN)?;
        Ok(Self { about, args, values, only: None, repeat: None, page: PageArgs::NONE, wire })
    }

    /// Whether it is the paper's study.
    pub fn is_paper(&self) -> bool {
        self.about.name == paper::ABOUT.name
    }

    /// The settings of a mission's campaigns, and their texts.
    pub fn settings(&self, mission: &Mission) -> Result<(CampaignSettings, Values), Failure> {
        let mut values = self.values.clone();
        if self.about.refusal(Feature::Keep).is_some() {
            values.put(OWN, "keep", &Keep::All.to_string()).map_err(Failure::input)?;
        }
        CampaignSettings::of_mission(&values, mission).map_err(Failure::input)
    }

    /// What was asked, of the mission that it is about.
    pub fn asked(&self, mission: &Mission) -> Result<Asked, Failure> {
        let (_, values) = self.settings(mission)?;
        Ok(noted::asked((self.about.name, OWN), &values, (&self.args, Some(&self.wire)), mission))
    }

    /// What is asked of the autopilot of whole drops.
    pub fn pilot<'a>(&'a self, autopilot: &'a AutopilotArg) -> PilotRequest<'a> {
        self.wire.pilot(autopilot, &self.args, (false, self.only.is_none()))
    }

    /// The circumstances of a manifest: the settings.
    pub fn circumstances(&self, mission: &Mission) -> Result<Vec<(&'static str, String)>, Failure> {
        Ok(self.settings(mission)?.1.in_order(self.about.settings))
    }
}
