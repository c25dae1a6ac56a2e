//! The hash that a run has whose inputs are the mission's present files and the choices that its manifest
//! names: evidence of another hash is of other inputs.

use std::collections::BTreeMap;

use super::args::CardArgs;
use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::args::PX4_DEFAULT;
use crate::cli::mission::{open_mission, px4_parameters};
use samara::config::Mission;
use samara::study::card::command::{CHOICES, sets};

/// The mission as it is now.
pub struct Present<'a> {
    args: &'a CardArgs,
    /// With the chosen gains, as far as they are the cascade's, without chosen parameters.
    without_parameters: Mission,
    /// With chosen parameters, where they are the cascade's, too.
    mission: Mission,
}

/// Why a run cannot be of the present inputs, in words.
type Refusal = String;

impl<'a> Present<'a> {
    /// The mission of the command line.
    pub fn of(args: &'a CardArgs) -> Result<Self, Failure> {
        let mut mission = open_mission(&args.mission.mission, &args.set)?;
        if let Some(gains) = args.gains.as_ref().filter(|_| !args.px4s_own_gains()) {
            mission.use_gains(gains).bad_input()?;
        }
        let without_parameters = mission.clone();
        if let Some(path) = &args.params {
            // A file that is another autopilot's leaves the gains as they are.
            if mission.use_parameters(path).is_err() {
                mission.clone().note_parameters(path).bad_input()?;
            }
        }
        Ok(Self { args, without_parameters, mission })
    }

    /// The mission with the chosen gains.
    pub fn mission(&self) -> &Mission {
        &self.mission
    }

    /// The hash of the inputs of a run with these choices.
    pub fn hash_with(&self, choices: &BTreeMap<String, String>) -> Result<String, Refusal> {
        let own: BTreeMap<_, _> = self.mission.inputs.choices.iter().cloned().collect();
        let [of_run, of_card] = [choices, &own].map(|choices| sets(choices).collect::<Vec<_>>());
        if of_run != of_card {
            let words = |sets: &[String]| match sets {
                [] => "nothing".to_owned(),
                sets => sets.join(", "),
            };
            let (run, card) = (words(&of_run), words(&of_card));
            return Err(format!(
                "it was made with {run} set (--set), the card is of the mission with {card} set"
            ));
        }
        let of_set = |name: &str| own.contains_key(name);
        let known =
            |name: &str| name == GAINS || of_set(name) || CHOICES.iter().any(|(choice, _)| *choice == name);
        if let Some(name) = choices.keys().find(|name| !known(name)) {
            return Err(format!("it was made with a choice that this version does not know: {name}"));
        }
        let by_px4 = choices.get(AUTOPILOT).is_some_and(|autopilot| autopilot.starts_with("px4"));
        let mut mission = if by_px4 { &self.without_parameters } else { &self.mission }.clone();
        for (choice, _) in CHOICES {
            if choice == AUTOPILOT && by_px4 {
                self.take_px4s_parameters(&mut mission, choices)?;
            }
            if let Some(value) = choices.get(choice) {
                mission.note_choice(choice, value);
            }
        }
        Ok(mission.inputs.hash)
    }

    /// What PX4 flies by stands before the autopilot among the choices.
    fn take_px4s_parameters(
        &self,
        mission: &mut Mission,
        choices: &BTreeMap<String, String>,
    ) -> Result<(), Refusal> {
        let own = choices.get(GAINS).is_some_and(|gains| gains == PX4_DEFAULT);
        match (own, self.args.px4s_own_gains()) {
            (true, false) => {
                return Err(format!("PX4 flew its own gains, which --gains {PX4_DEFAULT} makes a card of"));
            }
            (true, true) => mission.note_choice(GAINS, PX4_DEFAULT),
            (false, true) => return Err("PX4 flew other gains than its own".to_owned()),
            (false, false) => {
                if let Some(path) = px4_parameters(mission, self.args.chosen()) {
                    mission.note_parameters(&path).map_err(|error| error.to_string())?;
                }
            }
        }
        Ok(())
    }
}

/// The choices that name PX4's gains and the autopilot.
const GAINS: &str = "gains";
const AUTOPILOT: &str = "autopilot";
