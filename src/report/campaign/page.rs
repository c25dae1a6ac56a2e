//! `assess.html` of a mission's own campaigns: verdict, what tells the trials apart, the worst trials with
//! their commands, figures, footprint, and how to make it again. The page is self-contained: no script, no
//! font, no image from elsewhere.

use super::CampaignReport;
use super::tables::{campaigns, cases, measures, verdict, worst};
use crate::report::json::VERSION;
use crate::report::study::grid::{Grid, escape, rich};
use crate::report::study::page::{Figure, STYLE};
use crate::report::study::tables::{INTERVALS, tracking_note};
use crate::units::DEG_PER_RAD;

/// The HTML document of a mission's campaigns; `footprint`: names of its two files, `files`: what else lies
/// beside it, linked at the end.
pub fn page(
    report: &CampaignReport<'_>,
    figures: &[Figure],
    footprint: &[String; 2],
    files: &[String],
) -> String {
    let m = report.mission;
    let name = escape(&m.name);
    let class = if report.safe() { "verdict" } else { "verdict no" };
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>Safety of {name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <h1>Safety of the transition to powered flight: {name}</h1>\n\
         <p class=\"soft\">Vehicle {}, gains {}, released from its parachute; flown by {}.</p>\n\
         <p class=\"{class}\">{}.</p>\n",
        escape(&m.vehicle_name),
        escape(&m.control.gains_name),
        escape(&report.flown_by),
        rich(&verdict(report)),
    );
    let mut sections: Vec<(&str, &str, String)> = Vec::new();
    // What the page is about comes first, the other figures last.
    let (first, others) = figures.split_at(figures.len().min(1));
    let mut campaign_tables: String = first.iter().map(figure).collect();
    campaign_tables += &tables_of(report);
    campaign_tables += &format!("{}<p class=\"soft\">{INTERVALS}</p>\n", campaigns(report).html());
    sections.push(("campaigns", "Campaigns", campaign_tables));
    sections.push(("worst", "The worst trials", worst_trials(report)));
    if !report.cases.is_empty() {
        let note = tracking_note(report.mission, report.tracking_period_s);
        let body = format!("{}<p class=\"soft\">{note}</p>\n", cases(report).html());
        sections.push(("cases", "Release cases", body));
    }
    if !others.is_empty() {
        sections.push(("figures", "Figures", others.iter().map(figure).collect()));
    }
    sections.push(("footprint", "Footprint", footprint_links(footprint)));
    sections.push(("origin", "How this was made", origin(report, files)));
    html += "<nav aria-label=\"Contents\"><ol>";
    for (id, title, _) in &sections {
        html += &format!("<li><a href=\"#{id}\">{title}</a></li>");
    }
    html += "</ol></nav>\n";
    for (id, title, body) in &sections {
        html += &format!("<section id=\"{id}\">\n<h2>{title}</h2>\n{body}</section>\n");
    }
    html + "</body>\n</html>\n"
}

fn footprint_links([geojson, kml]: &[String; 2]) -> String {
    let link = |file: &str| format!("<a href=\"{0}\">{0}</a>", escape(file));
    format!(
        "<p>Where each vehicle was when its plan ended, seen from the point of release: {} and {}, for maps.</p>\n",
        link(geojson),
        link(kml)
    )
}

fn tables_of(report: &CampaignReport<'_>) -> String {
    let mut html = "<p>J<sub>state</sub> is the largest share of a safety limit - speed, pitch or pitch rate, and out of the plane roll or roll rate - \
         at an instant, J<sub>TPF</sub> its maximum over a flight; at 1 a limit is reached. The quantity that tells the trials apart best stands first. \
         Altitude is counted from the release to the plan's end, time from the start of the rotors, t = 0.</p>\n"
        .to_owned();
    for campaign in &report.campaigns {
        html += &measures(report, campaign).html();
    }
    html
}

fn worst_trials(report: &CampaignReport<'_>) -> String {
    let grid: Grid = worst(report);
    let mut html = grid.html() + "<p>Each alone, with its flight log, figure and replay:</p>\n<pre>";
    for t in report.judged().into_iter().flat_map(|campaign| &campaign.summary.worst).take(3) {
        html += &format!("{} --only {}\n", escape(&report.alone), t.trial);
    }
    html + "</pre>\n"
}

fn figure(figure: &Figure) -> String {
    format!(
        "<figure>\n<div class=\"drawing\">{}</div>\n<figcaption>{} <a class=\"soft\" href=\"{file}\">{file}</a></figcaption>\n</figure>\n",
        figure.svg.trim_start(),
        rich(&figure.caption),
        file = escape(&figure.file)
    )
}

fn origin(report: &CampaignReport<'_>, files: &[String]) -> String {
    let m = report.mission;
    let monte_carlo = &m.study.monte_carlo;
    let facts = [
        ("program", format!("samara {VERSION}")),
        ("inputs, SHA-256", m.inputs.hash.clone()),
        ("seed", m.seed.to_string()),
        ("gains", m.control.gains_name.clone()),
        (
            "plan",
            format!("J_TPF {:.4}, {} nodes over {} s", report.plan_j_tpf, m.plan.nodes, m.plan.horizon_s),
        ),
        (
            "releases",
            format!(
                "amplitude theta_0 normal with {:.1} deg, phase uniform, omega {} rad/s, pendulum {} m; ChaCha8, stream k for trial k",
                monte_carlo.amplitude_sigma_rad * DEG_PER_RAD,
                monte_carlo.omega_rad_s,
                monte_carlo.length_m
            ),
        ),
    ];
    let mut html = "<dl>\n".to_owned();
    for (name, value) in facts {
        html += &format!("<dt>{}</dt><dd>{}</dd>\n", escape(name), rich(&value));
    }
    let links: Vec<String> =
        files.iter().map(|file| format!("<a href=\"{0}\">{0}</a>", escape(file))).collect();
    html + &format!(
        "<dt>files</dt><dd>{}</dd>\n</dl>\n<pre>{}</pre>\n\
         <p class=\"soft\">The same command gives the same bytes, on any number of threads.</p>\n",
        links.join(", "),
        escape(&report.command)
    )
}
