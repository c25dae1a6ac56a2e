//! `assess.html`: the study on one page - verdict, tables, figures, what is reproduced and what is not, and
//! how to reproduce it. The page is self-contained: no script, no font, no image from elsewhere.

use super::findings::findings;
use super::readings::{ANOTHER_READING, CHOICES, SLIPS};
use super::tables::{INTERVALS, campaigns, reproduction, table_4, table_5, tracking_note, verdict};
use super::{Assessment, OURS, campaign_csv};
use crate::html::{Html, descriptions, document, el, paragraph};
use crate::json::VERSION;

/// A figure of the page.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of the file with the drawing.
    pub file: String,
    /// Caption below the drawing.
    pub caption: String,
    /// The drawing as an SVG document.
    pub svg: String,
}

impl Figure {
    /// The drawing with its caption, and what is said of its file.
    pub(crate) fn html(&self, file: Html) -> Html {
        let drawing = el("div").class("drawing").of(Html::drawing(&self.svg)).line();
        let caption = Html::rich(&self.caption) + Html::text(" ") + file;
        el("figure").around(drawing + el("figcaption").of(caption).line()).line()
    }
}

/// The style sheet of the pages.
pub(crate) const STYLE: &str = include_str!("page.css");

/// The HTML document of a study.
pub fn page(a: &Assessment<'_>, figures: &[Figure]) -> String {
    let m = a.mission;
    let class = if a.safe() { "verdict" } else { "verdict no" };
    let before = format!(
        "Vehicle {}, released from its parachute; the study of section V of T. I. Opazo and J. W. Langelaan, ",
        m.vehicle_name
    );
    let paper = "Longitudinal control of transition to powered flight for a parachute-dropped multirotor";
    let what_counts = format!(
        "J_state is the largest share of a safety limit - speed, pitch or pitch rate, and out of the plane roll or roll rate - at an instant (47)-(50), \
         J_TPF its maximum over a flight (51); at 1 a limit is reached. Flights start at the end of the release delay with \
         the rotors at rest, on the plant with speed controllers, motors and rotors, controlled at 100 Hz, for {} s.",
        m.plan.horizon_s
    );
    let mut body = el("h1").text(&format!("Safety of the transition to powered flight: {}", m.name)).line()
        + paragraph("soft", Html::text(&before) + el("i").text(paper) + Html::text("."))
        + paragraph(class, Html::rich(&verdict(a)) + Html::text("."))
        + paragraph("", Html::rich(&what_counts))
        + heading("Campaigns")
        + campaigns(a).html("table")
        + paragraph("soft", Html::text(INTERVALS))
        + heading("Release cases and gains")
        + table_5(a).html("table")
        + paragraph("soft", Html::text(&tracking_note(a.mission, a.tracking_period_s)))
        + table_4(a).html("table")
        + reproduced(a);
    if a.is_the_papers {
        body += readings();
    }
    let file = |figure: &Figure| el("span").class("soft").text(&format!("({})", figure.file));
    body += heading("Figures") + figures.iter().map(|figure| figure.html(file(figure))).sum() + origin(a);
    document(&format!("Safety of {}", m.name), STYLE, "", &body)
}

fn heading(title: &str) -> Html {
    el("h2").text(title).line()
}

fn reproduced(a: &Assessment<'_>) -> Html {
    let found = findings(a);
    let head = heading("What of the paper is reproduced");
    if found.is_empty() {
        let nothing =
            "This is not the paper's vehicle or mission: there is nothing of the paper's to stand beside it.";
        return head + paragraph("", Html::text(nothing));
    }
    let why_not = found.iter().filter(|f| !f.reproduced).map(|f| {
        let claim = el("strong").of(Html::text("Not reproduced: ") + Html::rich(&f.claim) + Html::text("."));
        paragraph("", claim + Html::text(" ") + Html::rich(f.why.as_deref().unwrap_or_default()))
    });
    head + reproduction(&found).html("table words") + why_not.sum()
}

/// What the paper leaves open, another reading of its law, and its slips of print.
fn readings() -> Html {
    let choices = CHOICES.iter().map(|(what, chosen)| (el("dt").rich(what) + el("dd").rich(chosen)).line());
    let another = ANOTHER_READING.iter().map(|text| paragraph("", Html::rich(text)));
    let slips = SLIPS.iter().map(|slip| el("li").rich(slip).line());
    heading("What the paper leaves open")
        + el("dl").around(choices.sum()).line()
        + heading("Another reading of the control law")
        + another.sum()
        + heading("Slips of print in the paper")
        + el("ul").around(slips.sum()).line()
}

fn origin(a: &Assessment<'_>) -> Html {
    let m = a.mission;
    let facts = [
        ("program", format!("samara {VERSION}")),
        ("inputs, SHA-256", m.inputs.hash.clone()),
        ("seed", m.seed.to_string()),
        ("gains", m.control.gains_name.clone()),
        (
            "optimal trajectory",
            format!(
                "objective {:.6}, J_TPF {:.4}, at its nodes {:.4}, {} nodes over {} s",
                a.plan_objective, a.plan.j_tpf, a.plan.j_tpf_at_nodes, m.plan.nodes, m.plan.horizon_s
            ),
        ),
        (
            "releases",
            format!(
                "theta_0 normal with {:.1} deg, phase uniform, omega {} rad/s, pendulum {} m; ChaCha8, streams of its own for each trial",
                m.study.monte_carlo.amplitude_sigma_rad * samara_core::units::DEG_PER_RAD,
                m.study.monte_carlo.omega_rad_s,
                m.study.monte_carlo.length_m
            ),
        ),
        (
            "every trial",
            a.assessed.iter().map(|x| campaign_csv::file_name(&x.entry)).collect::<Vec<_>>().join(", "),
        ),
    ];
    let facts = facts.iter().map(|(name, value)| (*name, Html::rich(value)));
    let commands =
        format!("{}\n{} --only 0     # trial 0 alone, with its flight log and figure", a.command, a.alone);
    let again = format!(
        "The same command gives the same bytes, on any number of threads. Campaign \u{201c}{OURS}\u{201d} is flown with the gains named above."
    );
    heading("How this was made")
        + descriptions(facts)
        + el("pre").text(&commands).line()
        + paragraph("soft", Html::text(&again))
}
