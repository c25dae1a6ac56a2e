//! Documents that are read after every change of theirs, to say what is wrong with it.

use std::path::Path;

use super::error::ConfigError;
use super::gains_file::gains_of;
use super::mission::{MissionText, read_mission};
use super::source::{InputHash, Source};
use super::vehicle_file::{KnownRotor, vehicle_of};

/// Reads documents as their loaders do, again and again, and keeps none. The table of a rotor is read only
/// when the rotor is another one than before, so that a mission takes a fraction of a millisecond.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    rotor: KnownRotor,
}

impl Reader {
    /// Reads a mission.
    ///
    /// # Errors
    /// [`ConfigError`] with the place in the text, or in a file that it names, that is refused.
    pub fn mission(&mut self, text: &MissionText<'_>) -> Result<(), ConfigError> {
        read_mission(text, Some(&mut self.rotor)).map(drop)
    }

    /// Reads the text of a vehicle file; tables are relative to `file`.
    ///
    /// # Errors
    /// [`ConfigError`] with the place in the text, or in a table, that is refused.
    pub fn vehicle(&mut self, text: &str, file: &Path) -> Result<(), ConfigError> {
        let source = Source::of_text(text, file);
        vehicle_of(&source, &mut InputHash::default(), Some(&mut self.rotor)).map(drop)
    }

    /// Reads the text of a gains file.
    ///
    /// # Errors
    /// [`ConfigError`] with the place in the text that is refused.
    pub fn gains(&self, text: &str, file: &Path) -> Result<(), ConfigError> {
        gains_of(&Source::of_text(text, file), &mut InputHash::default()).map(drop)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped::{MISSIONS, VEHICLES, built_in, names_in};
    use crate::{input_text, load_mission, mission_text, parse_mission};

    /// What the loader says of a mission with a rotor that is known, in any order, is what it says without.
    #[test]
    fn a_rotor_that_is_known_changes_no_answer() {
        let mut reader = Reader::default();
        let spoilt: [(&str, &str); 4] = [
            ("\"duration_s\": ", "\"duration_s\": -"),
            ("\"hang_s\": ", "\"hang_s\": 8"),
            ("\"thrust_max_n\": ", "\"thrust_max_n\": 1e4, \"thrust_max\": "),
            ("params/vehicles/", "params/vehicle/"),
        ];
        for name in names_in(MISSIONS) {
            let file = built_in(MISSIONS, name);
            let whole = mission_text(&file).unwrap();
            for (before, after) in spoilt.into_iter().chain([("{", "{")]) {
                let mission = &whole.replacen(before, after, 1);
                let text = MissionText { mission, file: &file, vehicle: None, gains: None };
                let [known, read] = [reader.mission(&text), parse_mission(&text).map(drop)];
                assert_eq!(known.map_err(|e| e.to_string()), read.map_err(|e| e.to_string()), "{name}");
            }
            assert!(load_mission(&file).is_ok());
        }
    }

    /// Another table, and another density for the same one, are another rotor.
    #[test]
    fn another_rotor_is_read() {
        let mut reader = Reader::default();
        for name in names_in(VEHICLES) {
            let file = built_in(VEHICLES, name);
            let text = input_text(&file, "vehicle file").unwrap();
            for _ in 0..2 {
                reader.vehicle(&text, &file).unwrap();
                let lost = text.replace("_rotor.csv", "_lost.csv");
                let refused = reader.vehicle(&lost, &file);
                assert_eq!(refused.is_err(), lost != text, "{name}");
                let other_blades = text.replace("\"blades\": 2", "\"blades\": 3");
                assert_eq!(reader.vehicle(&other_blades, &file).is_err(), other_blades != text, "{name}");
            }
        }
    }
}
