//! What a figure of a drop or of a plan shows.

use super::canvas::sub;
use super::heading::Heading;
use super::track::Track;
use samara_mission::Mission;

/// A point of the path with a name.
pub(crate) struct Event {
    pub(crate) t_s: f64,
    pub(crate) text: String,
    pub(crate) strong: bool,
}

/// A figure in the making.
pub(crate) struct Sheet<'a> {
    pub(crate) mission: &'a Mission,
    pub(crate) track: &'a Track,
    pub(crate) plan: Option<&'a Track>,
    /// Time at which the plan ends [s], where one is shown.
    pub(crate) plan_end_s: Option<f64>,
    /// The vertical plane that the path is seen in.
    pub(crate) heading: Heading,
    pub(crate) headline: String,
    /// What flew, under which circumstances: the line below the headline.
    pub(crate) circumstances: String,
    pub(crate) events: Vec<Event>,
    /// Highest J_state; `None` for a flight that is not judged.
    pub(crate) j_tpf: Option<f64>,
}

impl<'a> Sheet<'a> {
    pub(crate) fn new(mission: &'a Mission, track: &'a Track, plan: Option<&'a Track>) -> Self {
        Self {
            mission,
            track,
            plan,
            plan_end_s: None,
            heading: Heading::of(track),
            headline: String::new(),
            circumstances: String::new(),
            events: Vec::new(),
            j_tpf: None,
        }
    }

    pub(crate) fn event(&mut self, t_s: f64, text: &str, strong: bool) {
        self.events.push(Event { t_s, text: text.to_owned(), strong });
    }

    /// Writes J_TPF and marks its place.
    pub(crate) fn peak(&mut self, j_tpf: f64) {
        self.headline += &format!(": {} {j_tpf:.3}", sub("J", "TPF"));
        self.j_tpf = Some(j_tpf);
        if let Some(worst) = self.track.riskiest() {
            let decided_by = worst.decided_by.replace('_', " ");
            self.event(worst.t_s, &format!("highest {} {j_tpf:.3}: {decided_by}", sub("J", "state")), true);
        }
    }

    /// Whether the flight begins under a parachute.
    pub(crate) fn parachute(&self) -> bool {
        self.track.release_s.map_or(!self.track.since_free, |t| t < 0.0)
    }
}
