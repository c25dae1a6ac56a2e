//! A study of your own, as the house has its own: how J_TPF goes with the swing that a drop is released from.
//!
//! ```sh
//! cargo run --release --example own_study
//! ```

#![expect(clippy::print_stdout, reason = "an example shows what came out")]

use samara::assess::coordinates::TrialSpace;
use samara::assess::outcome::J_TPF;
use samara::config::{Mission, load_mission};
use samara::plan::SolverOptions;
use samara::report::document::{Document, Grid, Passage};
use samara::study::feature::Feature;
use samara::study::jobs::{HereAndNow, Jobs};
use samara::study::kind::{About, Flies, Given, Kind, Refused, Results, Study, Unfinished};
use samara::study::own::{fly_points, trial_space};
use samara::study::settings;
use samara::study::settings::{Values, number, whole};

type Failure = Box<dyn std::error::Error>;

settings! {
    /// Which swings are flown.
    pub SwingSettings {
        /// How many swings, evenly spread.
        steps("N"): u64 = "9", whole(2..=1000);
        /// The largest swing, in standard deviations of what is drawn.
        most("SIGMA"): f64 = "4", sigmas;
    }
}

fn sigmas(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0 && x <= 8.0, "a number above 0, up to 8, is expected")
}

/// How J_TPF goes with the swing, all else nominal.
pub struct Swing;

impl Kind for Swing {
    fn about(&self) -> About {
        About {
            name: "swing",
            manifest: "swing",
            title: "How J_TPF goes with the swing",
            help: "Examples:\n  samara study swing x500_drop\n",
            unit: "flights",
            flies: Flies::FromT0,
            settings: SwingSettings::TABLE,
            judges: Ok("every swing stays below J_TPF 1"),
            alone: Err("a swing flown alone is `samara drop --set`"),
            refuses: &[(Feature::Card, "a card is of what is drawn, and this is of one quantity")],
        }
    }

    fn begin<'a>(&self, given: Given<'a>, values: &Values) -> Result<Box<dyn Study + 'a>, Refused> {
        let settings = SwingSettings::of(values).map_err(Refused)?;
        let space = trial_space(given.mission, &given.plan()?.trajectory, false).map_err(Refused::by)?;
        Ok(Box::new(Swings { mission: given.mission, space, settings }))
    }
}

struct Swings<'a> {
    mission: &'a Mission,
    space: TrialSpace,
    settings: SwingSettings,
}

impl Study for Swings<'_> {
    fn jobs(&self) -> u64 {
        self.settings.steps
    }

    fn run(&self, jobs: &mut dyn Jobs) -> Result<Results, Unfinished> {
        let SwingSettings { steps, most } = self.settings;
        let sigma = |step: u64| most * step as f64 / (steps - 1) as f64;
        // The first coordinate of a trial is its swing's amplitude; the others stay where they are likeliest.
        let point = |step: u64| {
            let mut point = vec![0.0; self.space.dimensions()];
            point[0] = sigma(step);
            point
        };
        let points: Vec<Vec<f64>> = (0..steps).map(point).collect();
        let flown = fly_points(jobs, &self.space, &points)?;
        let name = &self.mission.name;
        let mut grid = Grid::new("J_TPF by swing", ["swing [sigma]", "J_TPF"]);
        let mut csv = "swing_sigma,j_tpf\n".to_owned();
        for (step, outcome) in (0..).zip(&flown) {
            let j_tpf = J_TPF.of(outcome).unwrap_or(f64::INFINITY);
            grid.row(&format!("{:.2}", sigma(step)), [format!("{j_tpf:.4}")]);
            csv += &format!("{},{j_tpf}\n", sigma(step));
        }
        let holds = flown.iter().all(|outcome| outcome.j_tpf < 1.0);
        let done = format!("{name}: {steps} swings");
        Ok(Results {
            document: Document::of_one(format!("J_TPF by swing: {name}"), done, vec![Passage::Table(grid)]),
            json: format!("{}\n", json_of(&flown.iter().map(|o| o.j_tpf).collect::<Vec<_>>())),
            files: vec![("swing.csv".to_owned(), csv)],
            holds,
            ..Results::default()
        })
    }
}

/// Numbers as a JSON list; what is not finite is null.
fn json_of(numbers: &[f64]) -> String {
    let words = |x: &f64| if x.is_finite() { x.to_string() } else { "null".to_owned() };
    format!("{{\"j_tpf\": [{}]}}", numbers.iter().map(words).collect::<Vec<_>>().join(", "))
}

/// Flies the study in the thread that asks.
pub fn swings(mission: &str) -> Result<Results, Failure> {
    let mission = load_mission(mission.as_ref())?;
    let plan = mission.solve(&SolverOptions::default(), &mut |_| std::ops::ControlFlow::Continue(()))?;
    let given = Given { mission: &mission, own: None, plan: Some(&plan), folder: None };
    let study = Swing.begin(given, &Values::usual(SwingSettings::TABLE))?;
    Ok(study.run(&mut HereAndNow)?)
}

fn main() -> Result<(), Failure> {
    println!("{}", swings("mission/x500_drop.json")?.document.text());
    Ok(())
}
