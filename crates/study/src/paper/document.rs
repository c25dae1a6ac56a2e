//! The answer of the paper's study: verdict, tables, figures, what is reproduced and what is not, and how to
//! make it again.

use std::fmt::Write as _;

use super::findings::{Finding, findings};
use super::readings::{OTHER_READINGS, SLIPS, choices};
use super::tables::{campaigns, reproduction, table_4, table_5, verdict};
use super::{Assessment, CaseResult, OURS};
use crate::campaign::campaign_csv;
use crate::campaign::document::origin;
use crate::campaign::tables::{INTERVALS, tracking_note};
use samara_core::assess::paper;
use samara_core::control::ControlLimits;
use samara_report::document::{Check, Document, Figure, Passage, Section};
use samara_report::html::{Html, el, paragraph};

/// The document of a study with its figures.
pub fn document(a: &Assessment<'_>, figures: &[Figure]) -> Document {
    let m = a.mission;
    let before = format!(
        "Vehicle {}, released from its parachute; the study of section V of T. I. Opazo and J. W. Langelaan, ",
        m.vehicle_name
    );
    let title = "Longitudinal control of transition to powered flight for a parachute-dropped multirotor";
    let about = paragraph("soft", Html::text(&before) + el("i").text(title) + Html::text("."));
    let plan = format!(
        "optimal trajectory: objective {:.6}, J_TPF {:.4}, at its nodes {:.4}{}\n",
        a.plan_objective,
        a.plan.j_tpf,
        a.plan.j_tpf_at_nodes,
        if a.is_the_papers { format!(" (the paper: {})", paper::PLAN_J_TPF) } else { String::new() }
    );
    let cases = vec![
        Passage::Table(table_5(a)),
        Passage::Remark(tracking_note(a.mission, a.tracking_period_s)),
        Passage::Table(table_4(a)),
    ];
    let mut sections = vec![
        Section { id: "campaigns", title: "Campaigns", passages: of_campaigns(a) },
        Section { id: "cases", title: "Release cases and gains", passages: cases },
        Section { id: "paper", title: "What of the paper is reproduced", passages: reproduced(&findings(a)) },
    ];
    if a.is_the_papers {
        sections.extend(readings(&a.mission.control.limits));
    }
    let figures = figures.iter().cloned().map(Passage::Figure).collect();
    sections.push(Section { id: "figures", title: "Figures", passages: figures });
    sections.push(Section { id: "origin", title: "How this was made", passages: made_by(a) });
    Document {
        title: format!("Safety of the transition to powered flight: {}", m.name),
        tab: format!("Safety of {}", m.name),
        verdict: Some((a.safe(), verdict(a))),
        lead: vec![Passage::OnPage(about), Passage::OnTerminal(plan)],
        sections,
        checks: checks(a),
    }
}

/// The flights that decide, as test cases: release cases and trials of the chosen gains.
fn checks(a: &Assessment<'_>) -> Vec<Check> {
    let ours = a.ours();
    let case = |case: &CaseResult| Check {
        group: "release case".to_owned(),
        name: case.case.clone(),
        failure: (!(case.j_tpf < a.bound)).then(|| format!("J_TPF {:.4}", case.j_tpf)),
    };
    let (trials, unsafe_trials) = (ours.tally.safe.trials(), ours.tally.safe.misses());
    let campaign = Check {
        group: OURS.to_owned(),
        name: format!("{trials} trials"),
        failure: (unsafe_trials > 0).then(|| format!("{unsafe_trials} of {trials} trials failed")),
    };
    ours.cases.iter().map(case).chain([campaign]).collect()
}

fn of_campaigns(a: &Assessment<'_>) -> Vec<Passage> {
    let what_counts = format!(
        "J_state is the largest share of a safety limit - speed, pitch or pitch rate, and out of the plane roll or roll rate - at an instant (47)-(50), \
         J_TPF its maximum over a flight (51); at 1 a limit is reached. Flights start at the end of the release delay with \
         the rotors at rest, on the plant with speed controllers, motors and rotors, controlled at 100 Hz, for {} s.",
        a.mission.plan.horizon_s
    );
    let explained = Passage::OnPage(paragraph("", Html::rich(&what_counts)));
    vec![explained, Passage::Table(campaigns(a)), Passage::Remark(INTERVALS.to_owned())]
}

fn reproduced(found: &[Finding]) -> Vec<Passage> {
    if found.is_empty() {
        let nothing =
            "This is not the paper's vehicle or mission: there is nothing of the paper's to stand beside it.";
        return vec![Passage::OnPage(paragraph("", Html::text(nothing)))];
    }
    let why_not = found.iter().filter(|f| !f.reproduced).map(|f| {
        let claim = el("strong").of(Html::text("Not reproduced: ") + Html::rich(&f.claim) + Html::text("."));
        paragraph("", claim + Html::text(" ") + Html::rich(f.why.as_deref().unwrap_or_default()))
    });
    let mut lines = "The paper's findings\n".to_owned();
    for f in found {
        let why = f.why.as_ref().map_or(String::new(), |why| format!(". {why}"));
        let Finding { claim, here, paper, bar, .. } = f;
        let line = format!("{}: {claim}: {here} here, {paper} in the paper ({bar}){why}", f.verdict());
        lines += &wrapped(&line, 118);
    }
    let more = "What the paper leaves open and is chosen here, other readings of its law, and its slips of print: assess.html";
    // Writing to a String cannot fail.
    let _ = writeln!(lines, "{more}");
    let on_page = reproduction(found).html() + why_not.sum();
    vec![Passage::OnPage(on_page), Passage::OnTerminal(lines)]
}

/// What the paper leaves open, other readings of its law, and its slips of print.
fn readings(law: &ControlLimits) -> [Section; 3] {
    let choices =
        choices(law).into_iter().map(|(what, chosen)| (el("dt").rich(what) + el("dd").rich(chosen)).line());
    let others = OTHER_READINGS.iter().map(|text| paragraph("", Html::rich(text)));
    let slips = SLIPS.iter().map(|slip| el("li").rich(slip).line());
    let section = |id, title, html| Section { id, title, passages: vec![Passage::OnPage(html)] };
    [
        section("open", "What the paper leaves open", el("dl").around(choices.sum()).line()),
        section("reading", "Other readings of the control law", others.sum()),
        section("slips", "Slips of print in the paper", el("ul").around(slips.sum()).line()),
    ]
}

fn made_by(a: &Assessment<'_>) -> Vec<Passage> {
    let m = a.mission;
    let plan = format!(
        "objective {:.6}, J_TPF {:.4}, at its nodes {:.4}, {} nodes over {} s",
        a.plan_objective, a.plan.j_tpf, a.plan.j_tpf_at_nodes, m.plan.nodes, m.plan.horizon_s
    );
    let files: Vec<String> = a.assessed.iter().map(|x| campaign_csv::file_name(&x.entry)).collect();
    let commands =
        format!("{}\n{} --only 0     # trial 0 alone, with its flight log and figure", a.command, a.alone);
    let again = format!(
        "The same command gives the same bytes, on any number of threads. Campaign \u{201c}{OURS}\u{201d} is flown with the gains named above."
    );
    let files = Html::rich(&files.join(", "));
    origin(m, ("optimal trajectory", plan), ("every trial", files), &commands, &again)
}

/// A paragraph wrapped to lines of at most `width`, the first flush, the others indented.
fn wrapped(paragraph: &str, width: usize) -> String {
    let (mut text, mut length) = (String::new(), 0);
    for word in paragraph.split_whitespace() {
        let n = word.chars().count();
        // A unit stays with its number.
        if length > 0 && length + 1 + n > width && !word.starts_with('%') {
            text += "\n  ";
            length = 2;
        } else if length > 0 {
            text.push(' ');
            length += 1;
        }
        text += word;
        length += n;
    }
    text + "\n"
}
