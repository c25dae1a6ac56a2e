//! `samara assess`: campaigns of flights with the mission's own gains, the paper's safety study, or a
//! campaign of whole drops. Studies of other kinds had their options here: `samara study`.
//!
//! | file | holds |
//! |---|---|
//! | `args` | what can be typed |
//! | `asked` | campaigns as they were asked for |
//! | `study` | the plan, and what flies the trials |
//! | `command` | the command that makes campaigns again |
//! | `own` | campaigns of the mission's own gains: tables, figures, footprint, one page |
//! | `paper` | `--paper`: release cases, campaigns of four controllers, the paper's results beside them |
//! | `campaign` | a campaign's trials, flown, written and continued |
//! | `figures` | the figures of flights |
//! | `only` | one trial again |
//! | `shards` | `--shard` and `samara merge`: parts of a campaign, flown apart and put together |
//! | `drops` | `--autopilot`: a campaign of whole drops |

mod args;
mod asked;
mod campaign;
mod command;
mod drops;
mod figures;
mod only;
mod own;
mod paper;
#[cfg(feature = "shards")]
pub mod shards;
mod study;

use super::answer::{Answer, Failure};
use std::sync::atomic::AtomicBool;

use super::study::args::now_spelt;
use super::study::asked::StudyOf;
use super::system::interrupt_flag;
pub use args::AssessArgs;
use args::Only;
use asked::CampaignOf;
use samara::study::feature::Feature;
use samara::study::kind::About;
use samara::study::kinds::kind;
use samara::study::settings::Values;

/// Flies the study, or drops by an autopilot.
pub fn run(args: AssessArgs) -> Result<Answer, Failure> {
    args.refuse_idle()?;
    let stop = interrupt_flag()?;
    args.study.parent.watch(&stop)?;
    if let Some(old) = old_spelling(&args, &stop)? {
        return Ok(old);
    }
    let only = match &args.only {
        None => None,
        Some(Only::Trial(trial)) => Some(*trial),
        Some(Only::Failure(file)) => {
            let why =
                "a failure of --rare flies without --autopilot; the number of a trial is expected with it";
            return Err(Failure::input(format!("--only {}: {why}", file.display())));
        }
    };
    let typed = args.settings.typed.clone();
    let campaign = &CampaignOf::typed(args, only);
    refuse_settings(campaign.about, &typed)?;
    #[cfg(feature = "shards")]
    if campaign.args.part.asks() {
        return shards::run(campaign, &stop);
    }
    match &campaign.wire.autopilot {
        Some(autopilot) => drops::run(campaign, autopilot, &stop),
        None => study::run(campaign, &stop),
    }
}

/// Refuses settings that were typed of campaigns that have them not.
fn refuse_settings(about: &About, typed: &[&str]) -> Result<(), Failure> {
    let names: Vec<&str> = about.settings.iter().map(|setting| setting.name).collect();
    match typed.iter().find(|name| !names.contains(name)) {
        None => Ok(()),
        Some(name) => {
            let feature = Feature::ALL.into_iter().find(|feature| feature.name() == **name);
            let usual =
                format!("{} has no such setting; expected one of --{}", about.name, names.join(", --"));
            let why = feature.and_then(|feature| about.refusal(feature)).map_or(usual, str::to_owned);
            Err(Failure::input(format!("--{name}: {why}")))
        }
    }
}

/// Flies the study that an old spelling asks for, and says the new one.
fn old_spelling(args: &AssessArgs, stop: &AtomicBool) -> Result<Option<Answer>, Failure> {
    let Some(old) = Old::of(args)? else { return Ok(None) };
    now_spelt(&format!("assess {}", old.option), &format!("samara study {}", old.now));
    let kind = kind(old.kind).map_err(Failure::input)?;
    let table = kind.about().settings;
    let mut values = Values::usual(table);
    let has_trials = table.iter().any(|setting| setting.name == "trials");
    let trials = Some(args.settings.values.text("trials")).filter(|text| has_trials && !text.is_empty());
    let given = old.settings.into_iter().chain(trials.map(|text| ("trials", text.to_owned())));
    for (name, text) in given {
        values.put(table, name, &text).map_err(|e| Failure::input(format!("--{name}: {e}")))?;
    }
    let study = StudyOf {
        kind,
        args: args.study.clone(),
        values,
        only: old.only,
        keep: false,
        page: args.page.clone(),
        wire: args.replan.is_some().then(|| args.wire.clone()),
    };
    super::study::fly(&study, stop).map(Some)
}

/// A study as it was asked for in old times.
struct Old {
    option: &'static str,
    now: String,
    kind: &'static str,
    settings: Vec<(&'static str, String)>,
    only: Option<String>,
}

impl Old {
    fn of(args: &AssessArgs) -> Result<Option<Self>, Failure> {
        let old = |option, kind: &'static str, setting: &'static str, settings| {
            let now = format!("{} {setting}", kind.replace('_', "-")).trim_end().to_owned();
            Some(Self { option, now, kind, settings, only: None })
        };
        let of = |name, text: &Option<String>| text.clone().map(|text| (name, text));
        if let Some(when) = &args.replan {
            return Ok(old("--replan", "replan", "--when", vec![("when", when.clone())]));
        }
        if args.effects {
            return Ok(old("--effects", "effects", "", Vec::new()));
        }
        if let Some(pairs) = &args.envelope {
            let rays = of("rays", &args.rays);
            let settings = [("pairs", pairs.clone())].into_iter().chain(rays).collect();
            return Ok(old("--envelope", "envelope", "--pairs", settings));
        }
        if let Some(hours) = &args.free_fall {
            return Ok(old("--free-fall", "free_fall", "--hours", vec![("hours", hours.clone())]));
        }
        if let Some(points) = &args.sobol {
            return Ok(old("--sobol", "sobol", "--points", vec![("points", points.clone())]));
        }
        let file = match &args.only {
            Some(Only::Failure(_)) if args.paper => {
                let why = "--only FILE: a failure of --rare is expected without --paper";
                return Err(Failure::input(why.to_owned()));
            }
            Some(Only::Failure(file)) if args.wire.autopilot.is_none() => Some(file.display().to_string()),
            _ => None,
        };
        if args.rare.is_none() && file.is_none() {
            return Ok(None);
        }
        let settings = [
            ("bound", args.settings.values.text("bound").to_owned()),
            ("unknowns", args.unknowns.to_string()),
        ];
        let more = of("least", &args.rare).into_iter().chain(of("per_level", &args.per_level));
        let spelt = if file.is_some() { "--only" } else { "--least" };
        let rare = old("--rare", "rare", spelt, settings.into_iter().chain(more).collect());
        Ok(rare.map(|rare| Self { only: file, ..rare }))
    }
}
