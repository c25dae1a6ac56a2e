//! PX4's own parameters as a study: a search by the evolution strategy, on the model of PX4's control law,
//! then what was found and PX4's defaults on drops that the search did not have.

use std::fmt::{self, Display, Formatter};
use std::ops::Range;
use std::sync::Arc;

use nalgebra::Vector3;
use samara_core::assess::Quantity;
use samara_core::control::Gains;
use samara_core::control::px4::versions::Version;
use samara_core::control::px4::{Law, Parameters, is_quad_x};
use samara_core::hints::No;
use samara_core::params::{
    ParameterFile, Purpose, Subject, believed_speed_noise_m_s, px4_model_export, px4_model_parameters,
};
use samara_core::trajectory::Trajectory;
use samara_core::tune::cma_es::CmaSettings;
use samara_core::tune::px4::space::{Candidate, range_ends};
use samara_core::tune::px4::{
    MEASURED, Measures, Px4Drop, Px4Judge, Px4Search, Px4SearchSettings, Px4Setting, Sensing, drops,
    drops_from, latency_s,
};
use samara_mission::{Mission, check_for_px4, px4_receiver, truth_remark};
use samara_report::document::Figure;
use samara_report::figure::{Distribution, FigureError};
use samara_report::params::params_file;

use super::gain_ends;
use super::report::px4::{PX4S_DEFAULTS, Px4Gains, document, gains_json};
use super::search::{left_out, no_gains};
use crate::distributions::distribution_of;
use crate::jobs::{HereAndNow, Jobs, Stage, Stopped};
use crate::kind::{About, Flies, Given, Kind, Refused, Results, Study, Unfinished};
use crate::range_ends::wall;
use crate::searching;
use crate::settings;
use crate::settings::{Maybe, Values, maybe, plain_name, whole};

/// Random drops that a candidate is judged by, besides the mission's release cases.
const DROPS: u64 = 24;
/// The number of the first unseen drop.
const UNSEEN_FROM: u64 = 1_000_000;
/// Drops that are flown without a look at whether to stop.
const PORTION: u64 = 4;

settings! {
    /// How PX4's parameters are searched, and tried.
    pub TunePx4Asked {
        /// The version of PX4 whose law is flown: the newest, if not given.
        px4_version("VERSION"): Modelled = "v1.18", modelled, rare;
        /// Candidates of an iteration [default: 16].
        particles("N"): Maybe<usize> = "default", maybe(whole(4..=10_000));
        /// Most iterations.
        iterations("N"): usize = "200", whole(1..=100_000);
        /// Random drops that the result is tried on afterwards.
        unseen("N"): u64 = "1000", whole(1..=1_000_000);
        /// Name of the gains found.
        name("NAME"): String = "tuned", plain_name;
    }
}

/// A version of PX4 whose law the model has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Modelled(pub Law);

impl Display for Modelled {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.since.fmt(f)
    }
}

fn modelled(text: &str) -> Result<Modelled, String> {
    Version::law_of(text).map(Modelled).map_err(|error| error.to_string())
}

/// PX4's own parameters for a mission, by search.
pub struct TunePx4;

/// Settings that only end a search, or come behind it.
const BEHIND: [&str; 3] = ["iterations", "unseen", "name"];

impl Kind for TunePx4 {
    fn about(&self) -> About {
        About {
            name: "tune_px4",
            manifest: "tune",
            title: "Search PX4's own parameters, on the model of its control law",
            help: include_str!("px4_help.txt"),
            unit: "candidates",
            flies: Flies::FromT0,
            settings: TunePx4Asked::TABLE,
            judges: Ok("the parameters are better than PX4's defaults"),
            alone: Err(
                "parameters are judged by all their drops: `samara drop --params` flies what was found",
            ),
            refuses: &[],
        }
    }

    fn suits(&self, mission: &Mission) -> Result<(), Refused> {
        check_for_px4(mission).map_err(Refused::by)
    }

    fn remarks(&self, mission: &Mission) -> Vec<String> {
        left_out(mission)
    }

    fn hangs_on(&self, _: &Mission, values: &Values) -> Result<Vec<(&'static str, String)>, Refused> {
        let mut settings = values.in_order(TunePx4Asked::TABLE);
        settings.retain(|(name, _)| !BEHIND.contains(name));
        Ok(settings)
    }

    fn flies_only(&self) -> Option<&'static str> {
        Some("it searches PX4's parameters")
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let asked = TunePx4Asked::of(values).map_err(Refused)?;
        Ok(Box::new(TunedPx4::new(given.mission, &given.plan()?.trajectory, asked)?))
    }
}

/// A search that was begun.
struct TunedPx4<'a> {
    mission: &'a Mission,
    asked: TunePx4Asked,
    purpose: Purpose,
    setting: Px4Setting<'a>,
    latency_s: f64,
    /// PX4's parameters as they come, given only the vehicle, and with the mission's gains.
    defaults: Parameters,
    missions: Parameters,
    settings: Px4SearchSettings,
    judge: Px4Judge<'a>,
}

impl<'a> TunedPx4<'a> {
    fn new(mission: &'a Mission, plan: &'a Trajectory, asked: TunePx4Asked) -> Result<Self, Refused> {
        let law = asked.px4_version.0;
        if !law.allocates {
            let hint = |why| Refused(format!("{why}: v1.14 and later take any rotors, --px4-version v1.14"));
            is_quad_x(&mission.vehicle).map_err(hint)?;
        }
        let purpose = mission.px4_purpose();
        let untouched = ParameterFile::default();
        let subject = mission.parameter_subject();
        let of = |given| px4_model_parameters(&subject, purpose, &law, given).map_err(Refused::by);
        let (defaults, mut missions) = (of(Some(&untouched))?, of(None)?);
        let receiver = px4_receiver(mission, &law);
        if receiver.is_some() {
            missions.gps_v_noise = believed_speed_noise_m_s(&mission.sensors.satellite);
        }
        let similarity = purpose.factors(mission.site.environment.gravity_m_s2).k;
        // With the latency of a PX4 that flies.
        let mut late = mission.clone();
        let vehicle = Arc::make_mut(&mut late.vehicle);
        vehicle.latency_s = latency_s(vehicle.latency_s, similarity);
        let setting = Px4Setting {
            law,
            scenario: late.scenario(),
            air: mission.site.wind_number,
            similarity,
            plan,
            feed_forward: mission.control.feed_forward,
            settle_s: mission.settle_s(plan),
            start: mission.release.start,
            sensing: receiver.map(|receiver| Sensing {
                sensors: mission.sensors,
                seed: mission.seed,
                receiver,
                hang_s: mission.release.hang_s,
            }),
            v_error_ned: Vector3::zeros(),
        };
        let [least, most] = gain_ends(&late).map(|gains| {
            let gains = Gains::longitudinal(gains);
            let subject = Subject { gains: &gains, ..late.parameter_subject() };
            px4_model_parameters(&subject, purpose, &law, None).map_err(Refused::by)
        });
        let settings = Px4SearchSettings {
            samples: asked.particles.0,
            iterations: asked.iterations,
            tilt_limit_rad: late.limits.safety.pitch_rad,
            gain_ends: Some([least?, most?]),
            seed: late.seed,
        };
        let mut seen = drops_of(mission, &setting, 0..DROPS);
        seen.extend(drops_from(&setting, mission.case_parachutes()));
        let judge = Px4Judge::new(seen, &[(PX4S_DEFAULTS, &defaults), ("the mission's gains", &missions)]);
        let latency_s = late.vehicle.latency_s;
        Ok(Self { mission, asked, purpose, setting, latency_s, defaults, missions, settings, judge })
    }

    /// The defaults and what was found on unseen drops.
    fn on_unseen(&self, jobs: &mut dyn Jobs, found: &Parameters) -> Result<[Vec<Measures>; 2], Stopped> {
        let unseen = self.asked.unseen;
        jobs.stage(&Stage {
            unit: "drops",
            jobs: 2 * unseen,
            hangs_on: &serde_json::json!({ "unseen": unseen, "found": format!("{found:?}") }).to_string(),
        })?;
        let sets = [&self.defaults, found];
        let flown = jobs.fly_sets("unseen drops", (sets.len(), unseen), PORTION, &|set, some, stop| {
            let parameters = sets.get(set).filter(|_| !stop())?;
            let drops =
                drops_of(self.mission, &self.setting, UNSEEN_FROM + some.start..UNSEEN_FROM + some.end);
            Some(drops.iter().map(|drop| drop.fly(parameters)).collect())
        })?;
        let mut sets = flown.into_iter();
        Ok(std::array::from_fn(|_| sets.next().unwrap_or_default()))
    }

    /// How the unseen drops are distributed.
    fn figure(&self, unseen: &[Vec<Measures>; 2]) -> Result<Option<Figure>, FigureError> {
        let controllers = [self.asked.name.as_str(), PX4S_DEFAULTS].into_iter().zip(unseen.iter().rev());
        let of = |(place, quantity): (usize, &Quantity)| Distribution {
            name: quantity.head(),
            limit: (quantity.limit)(&self.mission.limits),
            controllers: controllers
                .clone()
                .map(|(label, drops)| {
                    let values = drops.iter().map(|drop| drop.measured[place]).collect();
                    (label.to_owned(), values, drops.len())
                })
                .collect(),
        };
        let measures: Vec<Distribution> = MEASURED.iter().enumerate().map(of).collect();
        let remark =
            "Share of the unseen drops at or below a value; never steady counts as the whole flight.";
        distribution_of(self.mission, ("tune_px4.svg", remark), &measures)
    }
}

/// The random drops of these numbers.
fn drops_of<'a>(mission: &Mission, setting: &Px4Setting<'a>, numbers: Range<u64>) -> Vec<Px4Drop<'a>> {
    let wind_sigma_m_s = mission.study.monte_carlo.wind_sigma_m_s;
    drops(setting, &mission.releases(), wind_sigma_m_s, mission.seed, numbers)
}

impl Study for TunedPx4<'_> {
    fn jobs(&self) -> u64 {
        let search = Px4Search::new(&self.defaults, &self.missions, self.settings.clone());
        let most = self.settings.samples.unwrap_or(CmaSettings::default().samples);
        searching::candidates(&search) + most as u64 * self.asked.iterations as u64
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let (mission, asked) = (self.mission, &self.asked);
        let mut search = Px4Search::new(&self.defaults, &self.missions, self.settings.clone());
        let judge = |search: &Px4Search, _: usize, candidate: &Candidate| {
            Some(self.judge.cost(&search.parameters(candidate)))
        };
        let how = |search: &Px4Search| {
            let measured_by = self.judge.measured_by;
            let best = |(cost, _)| format!("best cost {cost:.4} (1: {measured_by})");
            search.best().map_or_else(String::new, best)
        };
        let stopped = searching::search(jobs, &mut search, how, judge).is_err();
        if stopped && !jobs.wants_so_far() {
            return Err(Unfinished::Stopped);
        }
        let Some((_, best)) = search.best().filter(|(cost, _)| cost.is_finite()) else {
            return Err(Unfinished::Nothing { of: "gains", why: no_gains(stopped).to_owned() });
        };
        let found = search.parameters(&best);
        // A host that was stopped flies nothing any more.
        let jobs: &mut dyn Jobs = if stopped { &mut HereAndNow } else { jobs };
        let unseen = self.on_unseen(jobs, &found)?;
        let [defaults, on_unseen] = unseen.each_ref().map(|drops| Measures::mean(drops));
        let result = Px4Gains {
            law: asked.px4_version.0,
            name: asked.name.clone(),
            purpose: self.purpose,
            defaults,
            measured_by: self.judge.measured_by,
            found: on_unseen,
            parameters: found,
            range_ends: range_ends(&best, search.bounds()),
            truth: truth_remark(mission, &asked.px4_version.0),
            latency_s: self.latency_s,
            drops: self.judge.count() as u64,
            unseen: asked.unseen,
            evaluations: search.evaluations(),
            stopped,
        };
        let mut named = mission.clone();
        named.control.gains_name.clone_from(&result.name);
        let export = px4_model_export(
            &result.parameters,
            &result.law,
            result.purpose,
            mission.site.environment.gravity_m_s2,
            result.remarks(),
        );
        let document = document(mission, &result);
        let files = [("gains.params", params_file(&named, &export)), ("px4_gains.txt", document.text())];
        let better = result.found.beats(&result.defaults);
        Ok(Results {
            document,
            json: gains_json(mission, &result),
            figures: self.figure(&unseen)?.into_iter().collect(),
            files: files.map(|(name, text)| (name.to_owned(), text)).to_vec(),
            holds: better && !stopped,
            noes: (!better).then_some(No::NotBetter).into_iter().chain(wall(&result.range_ends)).collect(),
            noted: vec![("for", "px4".to_owned())],
            stopped,
            ..Results::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_law_is_flown_where_no_version_is_named() {
        let usual = TunePx4Asked::of(&Values::usual(TunePx4Asked::TABLE)).unwrap();
        assert_eq!(Some(&usual.px4_version.0), Law::ALL.last());
    }
}
