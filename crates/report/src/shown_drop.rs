//! A drop that was flown, as its figure and its page show it.

use super::json::{DropRun, FlownBy};
use crate::columns::{fixed, short};
use samara_core::assess::Verdict;
use samara_core::math;
use samara_core::sim::Sample;
use samara_core::trajectory::Trajectory;
use samara_core::units::DEG_PER_RAD;
use samara_mission::{Mission, Site};

/// A drop that was flown, with what is known about it.
#[derive(Clone, Copy, Debug)]
pub struct ShownDrop<'a> {
    /// What was to be flown, and the limits.
    pub mission: &'a Mission,
    /// Title: the mission's name, or that of a trial.
    pub title: &'a str,
    /// Name of the gains that flew.
    pub gains: &'a str,
    /// The flight log.
    pub samples: &'a [Sample],
    /// The plan that was flown, where there was one.
    pub plan: Option<&'a Trajectory>,
    /// The verdict; `None` when the vehicle was never released.
    pub verdict: Option<&'a Verdict>,
    /// What else is known of the flight.
    pub run: &'a DropRun,
}

impl ShownDrop<'_> {
    /// Vehicle, gains, autopilot where it is not the reference one, and wind, as a sentence.
    pub(super) fn circumstances(&self) -> String {
        let by = self.run.autopilot.as_ref().and_then(FlownBy::words);
        let by = by.map_or(String::new(), |by| format!(", flown by {by}"));
        let wind = air_words(&self.mission.site);
        format!("Vehicle {}, gains {}{by}, {wind}.", self.mission.vehicle_name, self.gains)
    }
}

/// The air of a site in words: the mean wind at its altitude, and what else blows.
pub fn air_words(site: &Site) -> String {
    let wind = &site.wind;
    let mut words = wind_words(site.environment.wind_ned_m_s.into());
    if wind.profile.is_some() {
        words += " at the release, by altitude";
    }
    match wind.gusts.len() {
        0 => {}
        1 => words += ", a gust",
        n => words += &format!(", {n} gusts"),
    }
    if let Some(turbulence) = &wind.turbulence {
        let sigma_m_s = turbulence.sigma_m_s.into_iter().fold(0.0, f64::max);
        words += &format!(", turbulence {} m/s", short(sigma_m_s, 2));
    }
    if let Some(ring) = &wind.ring {
        words += &format!(", thrust in the vortex ring +-{} %", short(100.0 * ring.rms_share, 2));
    }
    words
}

/// Wind in words: from where it comes, as is usual.
fn wind_words([north, east, down]: [f64; 3]) -> String {
    let along = math::hypot(north, east);
    let points = ["north", "north-east", "east", "south-east", "south", "south-west", "west", "north-west"];
    let from_deg = (math::atan2(-east, -north) * DEG_PER_RAD).rem_euclid(360.0);
    let name = points[(from_deg / 45.0).round() as usize % 8];
    let level = format!("wind {} m/s from the {name} ({} deg)", short(along, 2), fixed(from_deg, 0));
    let upright = format!("{} m/s {}", short(down.abs(), 2), if down < 0.0 { "up" } else { "down" });
    match (along > 0.0, down != 0.0) {
        (false, false) => "no wind".to_owned(),
        (true, false) => level,
        (false, true) => format!("wind {upright}"),
        (true, true) => format!("{level} and {upright}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where wind comes from is opposite to where it goes.
    #[test]
    fn closed_form_wind_is_named_by_where_it_comes_from() {
        assert_eq!(wind_words([0.0, 0.0, 0.0]), "no wind");
        assert_eq!(wind_words([0.0, 6.0, 0.0]), "wind 6 m/s from the west (270 deg)");
        let north_east = "wind 2.83 m/s from the north-east (45 deg) and 1.5 m/s up";
        assert_eq!(wind_words([-2.0, -2.0, -1.5]), north_east);
        assert_eq!(wind_words([3.0, 1e-17, 0.0]), "wind 3 m/s from the south (180 deg)");
    }
}
