//! `assess.html` of a mission's own campaigns: verdict, what tells the trials apart, the worst trials with
//! their commands, figures, footprint, and how to make it again. The page is self-contained: no script, no
//! font, no image from elsewhere.

use super::CampaignReport;
use super::tables::{campaigns, cases, measures, verdict, worst};
use crate::html::{Html, descriptions, document, el, link, paragraph};
use crate::json::VERSION;
use crate::study::page::{Figure, STYLE};
use crate::study::tables::{INTERVALS, tracking_note};
use samara_core::units::DEG_PER_RAD;

/// The HTML document of a mission's campaigns; `footprint`: names of its two files, `files`: what else lies
/// beside it, linked at the end.
pub fn page(
    report: &CampaignReport<'_>,
    figures: &[Figure],
    footprint: &[String; 2],
    files: &[String],
) -> String {
    let m = report.mission;
    let about = format!(
        "Vehicle {}, gains {}, released from its parachute; flown by {}.",
        m.vehicle_name, m.control.gains_name, report.flown_by
    );
    let class = if report.safe() { "verdict" } else { "verdict no" };
    let mut body = el("h1").text(&format!("Safety of the transition to powered flight: {}", m.name)).line()
        + paragraph("soft", Html::text(&about))
        + paragraph(class, Html::rich(&verdict(report)) + Html::text("."));
    let mut sections: Vec<(&str, &str, Html)> = Vec::new();
    // What the page is about comes first, the other figures last.
    let (first, others) = figures.split_at(figures.len().min(1));
    let note = paragraph("soft", Html::text(INTERVALS));
    let tables = tables_of(report) + campaigns(report).html("table") + note;
    sections.push(("campaigns", "Campaigns", first.iter().map(figure).sum::<Html>() + tables));
    sections.push(("worst", "The worst trials", worst_trials(report)));
    if !report.cases.is_empty() {
        let note = tracking_note(report.mission, report.tracking_period_s);
        let note = paragraph("soft", Html::text(&note));
        sections.push(("cases", "Release cases", cases(report).html("table") + note));
    }
    if !others.is_empty() {
        sections.push(("figures", "Figures", others.iter().map(figure).sum()));
    }
    sections.push(("footprint", "Footprint", footprint_links(footprint)));
    sections.push(("origin", "How this was made", origin(report, files)));
    let entry = |(id, title, _): &(&str, &str, Html)| el("li").of(link(&format!("#{id}"), title));
    let contents = el("ol").of(sections.iter().map(entry).sum());
    body += el("nav").attribute("aria-label", "Contents").of(contents).line();
    for (id, title, content) in sections {
        let content = el("h2").text(title).line() + content;
        body += el("section").attribute("id", id).around(content).line();
    }
    document(&format!("Safety of {}", m.name), STYLE, "", &body)
}

fn footprint_links([geojson, kml]: &[String; 2]) -> Html {
    let links = [geojson, kml].map(|file| link(file, file));
    let about = "Where each vehicle was when its plan ended, seen from the point of release: ";
    paragraph("", Html::text(about) + Html::joined(links, " and ") + Html::text(", for maps."))
}

fn tables_of(report: &CampaignReport<'_>) -> Html {
    let about = "J_state is the largest share of a safety limit - speed, pitch or pitch rate, and out of the plane roll or roll rate - \
         at an instant, J_TPF its maximum over a flight; at 1 a limit is reached. The quantity that tells the trials apart best stands first. \
         Altitude is counted from the release to the plan's end, time from the start of the rotors, t = 0.";
    let tables = report.campaigns.iter().map(|campaign| measures(report, campaign).html("table"));
    paragraph("", Html::rich(about)) + tables.sum()
}

fn worst_trials(report: &CampaignReport<'_>) -> Html {
    let worst_of = report.judged().into_iter().flat_map(|campaign| &campaign.summary.worst).take(3);
    let commands: String = worst_of.map(|t| format!("{} --only {}\n", report.alone, t.trial)).collect();
    let about = Html::text("Each alone, with its flight log, figure and replay:");
    worst(report).html("table") + paragraph("", about) + el("pre").text(&commands).line()
}

fn figure(figure: &Figure) -> Html {
    let file = el("a").class("soft").attribute("href", &figure.file).text(&figure.file);
    figure.html(file)
}

fn origin(report: &CampaignReport<'_>, files: &[String]) -> Html {
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
                "amplitude theta_0 normal with {:.1} deg, phase uniform, omega {} rad/s, pendulum {} m; ChaCha8, streams of its own for each trial",
                monte_carlo.amplitude_sigma_rad * DEG_PER_RAD,
                monte_carlo.omega_rad_s,
                monte_carlo.length_m
            ),
        ),
    ];
    let files = Html::joined(files.iter().map(|file| link(file, file)), ", ");
    let facts = facts.iter().map(|(name, value)| (*name, Html::rich(value)));
    let again = "The same command gives the same bytes, on any number of threads.";
    descriptions(facts.chain([("files", files)]))
        + el("pre").text(&report.command).line()
        + paragraph("soft", Html::text(again))
}
