//! `card.html`: the card on one sheet of A4. The page is self-contained: no script, no font, no image from
//! elsewhere; black on white.

use super::assumptions::{assumed, not_modelled};
use super::decision::Decision;
use super::estimates::EstimatedInput;
use super::sections::{
    Line, Probability, Reach, Worst, air_and_release, autopilot, drops, probabilities, reaches,
    vehicle_and_design, worst,
};
use super::{Card, Evidence};
use crate::envelope::report::confirmed_words;
use crate::envelope::{STRIP_PANELS, envelope_strip};
use samara_core::assess::outcome::{ALTITUDE_LOST, J_TPF, PEAK_TILT, STEADY_AFTER};
use samara_report::columns::short;
use samara_report::figure::FigureError;
use samara_report::html::{Html, descriptions, document, el, link, paragraph};
use samara_report::json::VERSION;

const STYLE: &str = include_str!("card.css");

/// Most rows of each part, for one sheet: what is beyond stands in `card.json`, and the page says so.
const REASONS: usize = 4;
const LINES: usize = 6;
const DROPS: usize = 3;
const PX4S: usize = 2;
const CAMPAIGNS: usize = 3;
const WORST: usize = 3;
const SENTENCES: usize = 7;
const EVIDENCE: usize = 6;
/// Rows of the table of evidence.
const TABLE: usize = 8;
/// Most pieces of evidence that a line or a sentence names.
const NAMED: usize = 3;
/// Sizes of type, and how many rows of tables and lists a sheet has room for in each: what has more is set in
/// the next. A browser's test holds it.
const SIZES: [(&str, usize); 3] = [("airy", 16), ("plain", 22), ("dense", usize::MAX)];
/// Items of lists and rows of tables beyond which a sheet has room in the smallest type alone.
const CROWD: usize = 47;
/// Longest paths, in the table and behind it, and longest command on the sheet [characters]; the whole stands
/// in `card.json`.
const PATH: usize = 52;
const PATH_BEHIND: usize = 34;
const COMMAND: usize = 260;
/// Digits of a hash on the sheet.
const HASH_DIGITS: usize = 16;

/// The HTML document.
///
/// # Errors
/// [`FigureError`] when the figure of the envelope cannot be drawn.
pub fn page(card: &Card<'_>) -> Result<String, FigureError> {
    let reasons = card.reasons();
    let mut body = paragraph("conclusion", Html::rich(&card.conclusion()));
    if !reasons.is_empty() {
        let texts = reasons.iter().map(|reason| Html::rich(&reason.text) + links(card, &reason.from));
        body += list(texts.collect(), REASONS);
    }
    let vehicle = section("Vehicle and design", lines(card, &vehicle_and_design(card), LINES));
    let air = section("Air and release", lines(card, &air_and_release(card), LINES));
    body += el("div").class("two").around(vehicle + air).line();
    let flown = lines(card, &drops(card), DROPS) + lines(card, &autopilot(card), PX4S);
    body += section("Drops and autopilot", flown);
    body += section("Go/no-go envelope of the release", envelope(card)?);
    body += section("Probability of failure", probability_table(card));
    body += section("Worst ways to fail", worst_table(card, WORST));
    let sentences =
        |sentences: Vec<String>| list(sentences.iter().map(|text| Html::rich(text)).collect(), SENTENCES);
    let assumed = section("What is assumed", sentences(assumed(card, NAMED)));
    let left_out = section("What was not looked at or modelled", sentences(not_modelled(card, NAMED)));
    body += el("div").class("two long").around(assumed + left_out).line();
    let shown = shown_evidence(card, body.as_str());
    body += section("Evidence", evidence_table(card, &shown));
    let rows = rows(card, reasons.len()) + shown.len();
    let count = |tag: &str| body.as_str().matches(tag).count();
    let crowd = ["<li>", "<tr>", "<dt>"].map(count).iter().sum::<usize>();
    let type_size = match SIZES.iter().find(|(_, most)| rows <= *most) {
        Some((size, _)) if crowd <= CROWD => size,
        _ => "tight",
    };
    let sheet = head(card, card.decision()) + body + estimates(card) + signatures(card);
    Ok(document(&format!("Release card: {}", card.mission.name), STYLE, type_size, &sheet))
}

/// The name and the verdict.
fn head(card: &Card<'_>, decision: Decision) -> Html {
    let m = card.mission;
    let (class, verdict) = (if decision.is_go() { "verdict go" } else { "verdict no" }, decision.words());
    let about =
        format!("Vehicle {}, gains {}. samara {VERSION}; inputs ", m.vehicle_name, m.control.gains_name);
    let name = el("p").class("over").text("Release card").line()
        + el("h1").text(&m.name).line()
        + el("p").of(Html::text(&about) + hash(&m.inputs.hash));
    el("header").of(el("div").of(name).line() + el("p").class(class).text(verdict)).line()
}

/// What is estimated, above the signatures, and whether that is accepted.
fn estimates(card: &Card<'_>) -> Html {
    let estimates = card.estimates();
    if estimates.is_empty() {
        return Html::default();
    }
    let words = |input: &EstimatedInput| {
        Html::rich(&input.words_with_origins()) + links(card, &[input.from.to_owned()])
    };
    let words = Html::joined(estimates.iter().map(words), "; ");
    let standing = if card.accepts_estimates {
        Html::text("Accepted with these signatures")
    } else {
        el("b").text("NOT accepted")
    };
    let text = words + Html::text(". ") + standing + Html::text(".");
    section("Estimated or guessed, not measured", paragraph("", text))
}

/// Where the card is signed.
fn signatures(card: &Card<'_>) -> Html {
    let row = |cells: [&str; 4]| el("tr").of(cells.iter().map(|cell| el("td").text(cell)).sum());
    let rows = [["Name", "Role", "Date", "Signature"], [""; 4], [""; 4]].map(row);
    let command = el("code").text(&shortened(&card.command, COMMAND));
    let again = Html::text("Made again by ")
        + command
        + Html::text(". Hashes find what has changed; they are no signatures.");
    let table = el("table").of(rows.into_iter().sum()).line();
    el("section").class("sign").of(table + el("p").of(again)).line()
}

/// Rows of the sheet that differ from card to card, but for the evidence.
fn rows(card: &Card<'_>, reasons: usize) -> usize {
    let parts = [
        (reasons, REASONS),
        (vehicle_and_design(card).len(), LINES),
        (drops(card).len(), DROPS),
        (autopilot(card).len(), PX4S),
        (probabilities(card).len(), CAMPAIGNS),
        (worst(card).len(), WORST),
    ];
    let parts = parts.into_iter().map(|(count, most)| count.min(most)).sum::<usize>();
    parts + reaches(card).len() + 2 * card.estimates().len()
}

fn section(title: &str, body: Html) -> Html {
    el("section").around(el("h2").text(title).line() + body).line()
}

/// The beginning of a hash, the whole as a title.
fn hash(sha256: &str) -> Html {
    let short: String = sha256.chars().take(HASH_DIGITS).collect();
    el("code").attribute("title", &format!("SHA-256 {sha256}")).text(&short)
}

/// Links to what something rests on, as many as are named: evidence leads to its file, an input to its place
/// below.
fn links(card: &Card<'_>, from: &[String]) -> Html {
    let to = |id: &String| {
        let place = id.strip_prefix('E').and_then(|number| number.parse::<usize>().ok());
        let evidence = place.and_then(|place| card.evidence.get(place.checked_sub(1)?));
        let to = evidence.map_or_else(|| format!("#{id}"), |evidence| url(&evidence.link));
        link(&to, id)
    };
    if from.is_empty() {
        return Html::default();
    }
    let more = from.len().checked_sub(NAMED).filter(|more| *more > 0);
    let more = more.map(|more| Html::text(&format!("+ {more}")));
    let links = Html::joined(from.iter().take(NAMED).map(to).chain(more), " ");
    Html::text(" ") + el("span").class("from").of(links)
}

/// A text without its middle, where it is too long.
fn shortened(text: &str, most: usize) -> String {
    let count = text.chars().count();
    if count <= most {
        return text.to_owned();
    }
    let (head, tail) = (most / 3, most - most / 3 - 3);
    let begin: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(count - tail).collect();
    format!("{begin}...{end}")
}

/// How many of something are not shown, in words; empty where all are.
fn rest(count: usize, shown: usize) -> String {
    match count.saturating_sub(shown) {
        0 => String::new(),
        more => format!("{more} more in card.json"),
    }
}

fn list(items: Vec<Html>, most: usize) -> Html {
    let more = rest(items.len(), most);
    let more = (!more.is_empty()).then(|| Html::text(&more));
    let items = items.into_iter().take(most).chain(more);
    el("ul").around(items.map(|item| el("li").of(item).line()).sum()).line()
}

fn lines(card: &Card<'_>, lines: &[Line], most: usize) -> Html {
    let more = rest(lines.len(), most);
    let more = (!more.is_empty()).then(|| ("", Html::text(&more)));
    let rows = lines.iter().take(most);
    let rows = rows.map(|line| (&*line.about, Html::rich(&line.text) + links(card, &line.from)));
    descriptions(rows.chain(more))
}

/// A table: heads, then rows of cells.
fn table(class: &str, heads: &[&str], rows: Vec<Vec<Html>>) -> Html {
    let heads = heads.iter().map(|head| el("th").attribute("scope", "col").rich(head));
    let row = |cells: Vec<Html>| el("tr").of(cells.into_iter().map(|cell| el("td").of(cell)).sum()).line();
    let head = el("thead").of(el("tr").of(heads.sum())).line();
    let body = el("tbody").around(rows.into_iter().map(row).sum());
    el("table").class(class).of(head + body).line()
}

fn envelope(card: &Card<'_>) -> Result<Html, FigureError> {
    let reaches = reaches(card);
    let Some((_, first)) = card.envelopes().next() else {
        let none = "No evidence of the mission's release: samara study envelope searches it.";
        return Ok(paragraph("", Html::text(none)));
    };
    let row = |(row, reach): (usize, &Reach)| {
        let nominal = reach.nominal.map_or_else(|| "not known".to_owned(), |x| short(x, 2));
        let [narrow, wide] = reach.confirmed.each_ref().map(|reach| Html::text(&reach.words()));
        let drawn = Html::text(&reach.drawn_words());
        // The evidence is named at the first of its rows.
        let is_first = row == 0 || reaches[row - 1].from != reach.from;
        let from = if is_first { links(card, std::slice::from_ref(&reach.from)) } else { Html::default() };
        vec![Html::text(reach.words), Html::text(&nominal), drawn, narrow, wide + from]
    };
    let rows = reaches.iter().enumerate().map(row).collect();
    let head = ["one at a time", "nominal", "drawn", "J_state < 0.7", "J_state < 1: go"];
    let panels: Vec<_> =
        card.envelopes().flat_map(|(_, envelope)| envelope.panels()).take(STRIP_PANELS).collect();
    let title = format!("Safe-release envelope: {}", card.mission.name);
    let figure = match envelope_strip((&title, &card.mission.stamp().csv_comment()), &panels) {
        Ok(svg) => el("figure").of(Html::drawing(&svg)).line(),
        Err(FigureError::Empty) => Html::default(),
        Err(e) => return Err(e),
    };
    let any = card.envelopes().any(|(_, envelope)| envelope.any_confirmed());
    let confirmed = confirmed_words(any, first.fresh_flights, first.probability, first.confidence);
    let unseen = card.envelopes().filter_map(|(id, envelope)| Some((id, envelope.not_looked_at()?)));
    let unseen: String =
        unseen.take(NAMED).map(|(id, what)| format!(" {id} has NOT looked at: {what}.")).collect();
    let key = " Green and blue: J_state below 0.7 and 1; cross: nominal release; drawn: three standard deviations either way, and the mission's own turbulence.";
    let note = Html::rich(&confirmed) + Html::text(".") + Html::text(&unseen) + Html::rich(key);
    let table = table("reaches", &head, rows);
    Ok(el("div").class("envelope").of(table + figure).line() + paragraph("note", note))
}

fn probability_table(card: &Card<'_>) -> Html {
    let found = probabilities(card);
    if found.is_empty() {
        return paragraph("", Html::text("No evidence: samara assess flies campaigns."));
    }
    let row = |p: &Probability| {
        let words = Html::rich(&p.words()) + links(card, std::slice::from_ref(&p.from));
        let [trials, failed] =
            [p.trials, p.failed].map(|n| n.map_or_else(|| Html::text("-"), |n| Html::text(&n.to_string())));
        vec![Html::rich(&p.flown_by), trials, failed, words, Html::rich(&p.found_by)]
    };
    let rows = with_rest(found.iter().take(CAMPAIGNS).map(row), found.len(), CAMPAIGNS);
    table("campaigns", &["flown", "trials", "failed", "P(failure)", "found by"], rows)
}

/// Rows of a table, and one that says how many are not shown.
fn with_rest(rows: impl Iterator<Item = Vec<Html>>, count: usize, shown: usize) -> Vec<Vec<Html>> {
    let more = rest(count, shown);
    rows.chain((!more.is_empty()).then(|| vec![Html::text(&more)])).collect()
}

fn worst_table(card: &Card<'_>, most: usize) -> Html {
    let found = worst(card);
    if found.is_empty() {
        return paragraph("", Html::text("No evidence."));
    }
    let number = |x: Option<f64>, digits: usize| x.map_or_else(|| "-".to_owned(), |x| short(x, digits));
    // What was measured to its end and has no such time was never steady.
    let steady = |row: &Worst| match (STEADY_AFTER.of(&row.outcome.0), ALTITUDE_LOST.of(&row.outcome.0)) {
        (None, Some(_)) => STEADY_AFTER.without.to_owned(),
        (steady_after_s, _) => number(steady_after_s, 1),
    };
    let row = |row: &Worst| {
        let outcome = match (&row.failure, &row.likely) {
            (Some(failure), _) => el("b").text("failed") + Html::text(": ") + Html::rich(failure),
            (None, Some(likely)) => Html::rich(likely),
            (None, None) => Html::text("did not fail, closest"),
        };
        vec![
            Html::rich(&row.which) + links(card, std::slice::from_ref(&row.from)),
            outcome,
            Html::text(&number(J_TPF.of(&row.outcome.0), 3)),
            Html::text(&steady(row)),
            Html::text(&number(ALTITUDE_LOST.of(&row.outcome.0), 1)),
            Html::text(&number(PEAK_TILT.of(&row.outcome.0), 1)),
        ]
    };
    let heads = ["", "outcome", "J_TPF", "steady after [s]", "altitude lost [m]", "tilt [deg]"];
    table("worst", &heads, with_rest(found.iter().take(most).map(row), found.len(), most))
}

/// The inputs, and the evidence at these places: the first in a table, the others one behind another.
fn evidence_table(card: &Card<'_>, places: &[usize]) -> Html {
    let anchor = |id: &str| el("span").attribute("id", id).text(id);
    let inputs = card.inputs.iter().enumerate().map(|(place, input)| {
        let file = format!(" {} {} ", input.role, shortened(&input.file, PATH));
        anchor(&format!("I{}", place + 1)) + Html::text(&file) + hash(&input.sha256)
    });
    let inputs = Html::text("Inputs: ") + Html::joined(inputs, "; ") + Html::text(".");
    let row = |place: &usize, most: usize| {
        let evidence = &card.evidence[*place];
        let sha256 = evidence.sha256.as_deref().map_or_else(|| Html::text("-"), hash);
        let file = el("a").attribute("href", &url(&evidence.link)).attribute("title", &evidence.file);
        let file = file.text(&shortened(&evidence.file, most));
        let kind = Html::text(evidence.kind.words());
        vec![anchor(&Card::id(*place)), kind, file, sha256, standing(evidence)]
    };
    let (above, below) = places.split_at(places.len().min(TABLE));
    let rows = above.iter().map(|place| row(place, PATH)).collect();
    let table = table("evidence", &["", "what", "file", "SHA-256", "standing"], rows);
    let more = rest(card.evidence.len(), places.len());
    let more = (!more.is_empty()).then(|| Html::text(&more));
    let behind: Vec<Html> =
        below.iter().map(|place| Html::joined(row(place, PATH_BEHIND), " ")).chain(more).collect();
    let behind = match behind.is_empty() {
        true => Html::default(),
        false => paragraph("inputs", Html::joined(behind, "; ") + Html::text(".")),
    };
    paragraph("inputs", inputs) + table + behind
}

/// Whether evidence is accepted and counts, or why it does not.
fn standing(evidence: &Evidence) -> Html {
    match &evidence.found {
        Ok(_) => {
            let counts = evidence.elsewhere().map(|of| format!(", not counted: of {of}"));
            let with = Some(evidence.otherwise()).filter(|with| !with.is_empty());
            let with = with.map(|with| format!(", with {with}"));
            let all = ["accepted".to_owned()].into_iter().chain(counts).chain(with).collect::<String>();
            Html::text(&all)
        }
        Err(why) => el("b").text("refused") + Html::text(": ") + Html::text(why),
    }
}

/// Places of the evidence that is shown: all that the sheet above names, then up to [`EVIDENCE`] what is
/// refused and the rest; in order.
fn shown_evidence(card: &Card<'_>, above: &str) -> Vec<usize> {
    let all = &card.evidence;
    let named = |place: usize| names(above, &Card::id(place));
    let rank = |place: &usize| match (named(*place), &all[*place].found) {
        (true, _) => 0,
        (false, Err(_)) => 1,
        (false, Ok(_)) => 2,
    };
    let mut ranked: Vec<(i32, usize)> = (0..all.len()).map(|place| (rank(&place), place)).collect();
    ranked.sort_unstable();
    let named = ranked.iter().take_while(|(rank, _)| *rank == 0).count();
    let shown = ranked.into_iter().take(named.max(EVIDENCE));
    let mut places: Vec<usize> = shown.map(|(_, place)| place).collect();
    places.sort_unstable();
    places
}

/// Whether a text names a piece of evidence: E1, not E12.
pub(super) fn names(text: &str, id: &str) -> bool {
    let of_word = |c: Option<char>| c.is_some_and(char::is_alphanumeric);
    text.match_indices(id).any(|(at, _)| {
        !of_word(text[..at].chars().next_back()) && !of_word(text[at + id.len()..].chars().next())
    })
}

/// A relative path as a link: what means something in a URL is escaped.
fn url(path: &str) -> String {
    let byte = |b: u8| match b {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' | b'~' => {
            char::from(b).to_string()
        }
        _ => format!("%{b:02X}"),
    };
    path.bytes().map(byte).collect()
}
