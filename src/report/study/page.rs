//! `assess.html`: the study on one page - verdict, tables, figures, what is reproduced and what is not, and
//! how to reproduce it. The page is self-contained: no script, no font, no image from elsewhere.

use super::findings::findings;
use super::grid::{escape, rich};
use super::readings::{ANOTHER_READING, CHOICES, SLIPS};
use super::tables::{INTERVALS, campaigns, reproduction, table_4, table_5, tracking_note, verdict};
use super::{Assessment, OURS, campaign_csv};
use crate::report::json::VERSION;

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

/// The style sheet of the pages.
pub(crate) const STYLE: &str = include_str!("page.css");

/// The HTML document of a study.
pub fn page(a: &Assessment<'_>, figures: &[Figure]) -> String {
    let m = a.mission;
    let name = escape(&m.name);
    let class = if a.safe() { "verdict" } else { "verdict no" };
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>Safety of {name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>Safety of the transition to powered flight: {name}</h1>\n\
         <p class=\"soft\">Vehicle {}, released from its parachute; the study of section V of T. I. Opazo and J. W. Langelaan, \
         <i>Longitudinal control of transition to powered flight for a parachute-dropped multirotor</i>.</p>\n\
         <p class=\"{class}\">{}.</p>\n",
        escape(&m.vehicle_name),
        rich(&verdict(a)),
    );
    html += &format!(
        "<p>J<sub>state</sub> is the largest share of a safety limit - speed, pitch or pitch rate, and out of the plane roll or roll rate - at an instant (47)-(50), \
         J<sub>TPF</sub> its maximum over a flight (51); at 1 a limit is reached. Flights start at the end of the release delay with \
         the rotors at rest, on the plant with speed controllers, motors and rotors, controlled at 100 Hz, for {} s.</p>\n",
        a.mission.plan.horizon_s
    );
    html += &format!("<h2>Campaigns</h2>\n{}<p class=\"soft\">{INTERVALS}</p>\n", campaigns(a).html());
    html += &format!(
        "<h2>Release cases and gains</h2>\n{}<p class=\"soft\">{}</p>\n{}",
        table_5(a).html(),
        tracking_note(a.mission, a.tracking_period_s),
        table_4(a).html()
    );
    html += &reproduced(a);
    if a.is_the_papers {
        html += &readings();
    }
    html += "<h2>Figures</h2>\n";
    for figure in figures {
        html += &format!(
            "<figure>\n<div class=\"drawing\">{}</div>\n<figcaption>{} <span class=\"soft\">({})</span></figcaption>\n</figure>\n",
            figure.svg.trim_start(),
            rich(&figure.caption),
            escape(&figure.file)
        );
    }
    html + &origin(a) + "</body>\n</html>\n"
}

fn reproduced(a: &Assessment<'_>) -> String {
    let found = findings(a);
    let mut html = "<h2>What of the paper is reproduced</h2>\n".to_owned();
    if found.is_empty() {
        return html
            + "<p>This is not the paper's vehicle or mission: there is nothing of the paper's to stand beside it.</p>\n";
    }
    html +=
        &reproduction(&found).html().replace("<figure class=\"table\">", "<figure class=\"table words\">");
    for f in found.iter().filter(|f| !f.reproduced) {
        html += &format!(
            "<p><strong>Not reproduced: {}.</strong> {}</p>\n",
            rich(&f.claim),
            rich(f.why.unwrap_or_default())
        );
    }
    html
}

/// What the paper leaves open, another reading of its law, and its slips of print.
fn readings() -> String {
    let mut html = "<h2>What the paper leaves open</h2>\n<dl>\n".to_owned();
    for (what, chosen) in CHOICES {
        html += &format!("<dt>{}</dt><dd>{}</dd>\n", rich(what), rich(chosen));
    }
    html += "</dl>\n<h2>Another reading of the control law</h2>\n";
    for paragraph in ANOTHER_READING {
        html += &format!("<p>{}</p>\n", rich(paragraph));
    }
    html += "<h2>Slips of print in the paper</h2>\n<ul>\n";
    for slip in SLIPS {
        html += &format!("<li>{}</li>\n", rich(slip));
    }
    html + "</ul>\n"
}

fn origin(a: &Assessment<'_>) -> String {
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
                "theta_0 normal with {:.1} deg, phase uniform, omega {} rad/s, pendulum {} m; ChaCha8, stream k for trial k",
                m.study.monte_carlo.amplitude_sigma_rad * crate::units::DEG_PER_RAD,
                m.study.monte_carlo.omega_rad_s,
                m.study.monte_carlo.length_m
            ),
        ),
        (
            "every trial",
            a.assessed.iter().map(|x| campaign_csv::file_name(&x.entry)).collect::<Vec<_>>().join(", "),
        ),
    ];
    let mut html = "<h2>How this was made</h2>\n<dl>\n".to_owned();
    for (name, value) in facts {
        html += &format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), rich(&value));
    }
    let command = escape(&a.command);
    html + &format!(
        "</dl>\n<pre>{command}\n{} --only 0     # trial 0 alone, with its flight log and figure</pre>\n\
         <p class=\"soft\">The same command gives the same bytes, on any number of threads. Campaign \u{201c}{OURS}\u{201d} is flown with the gains named above.</p>\n",
        escape(&a.alone)
    )
}
