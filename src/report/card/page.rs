//! `card.html`: the card on one sheet of A4. The page is self-contained: no script, no font, no image from
//! elsewhere; black on white.

use super::assumptions::{assumed, not_modelled};
use super::decision::Decision;
use super::estimates::EstimatedInput;
use super::sections::{
    Line, Worst, air_and_release, autopilot, drops, probabilities, reaches, vehicle_and_design, worst,
};
use super::{Card, Evidence};
use crate::assess::outcome::{ALTITUDE_LOST, J_TPF, PEAK_TILT, STEADY_AFTER};
use crate::report::columns::short;
use crate::report::envelope::confirmed_words;
use crate::report::figure::{FigureError, STRIP_PANELS, envelope_strip};
use crate::report::json::VERSION;
use crate::report::study::grid::{escape, rich};

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
    let mut body = format!("<p class=\"conclusion\">{}</p>\n", rich(&card.conclusion()));
    if !reasons.is_empty() {
        let texts =
            reasons.iter().map(|reason| format!("{}{}", rich(&reason.text), links(card, &reason.from)));
        body += &list(texts.collect(), REASONS);
    }
    body += "<div class=\"two\">\n";
    body += &section("Vehicle and design", &lines(card, &vehicle_and_design(card), LINES));
    body += &section("Air and release", &lines(card, &air_and_release(card), LINES));
    body += "</div>\n";
    let flown = lines(card, &drops(card), DROPS) + &lines(card, &autopilot(card), PX4S);
    body += &section("Drops and autopilot", &flown);
    body += &section("Go/no-go envelope of the release", &envelope(card)?);
    body += &section("Probability of failure", &probability_table(card));
    body += &section("Worst ways to fail", &worst_table(card, WORST));
    body += "<div class=\"two long\">\n";
    let sentences =
        |sentences: Vec<String>| list(sentences.iter().map(|text| rich(text)).collect(), SENTENCES);
    body += &section("What is assumed", &sentences(assumed(card, NAMED)));
    body += &section("What was not looked at or modelled", &sentences(not_modelled(card, NAMED)));
    body += "</div>\n";
    let shown = shown_evidence(card, &body);
    body += &section("Evidence", &evidence_table(card, &shown));
    let rows = rows(card, reasons.len()) + shown.len();
    let crowd = ["<li>", "<tr>", "<dt>"].map(|tag| body.matches(tag).count()).iter().sum::<usize>();
    let type_size = match SIZES.iter().find(|(_, most)| rows <= *most) {
        Some((size, _)) if crowd <= CROWD => size,
        _ => "tight",
    };
    Ok(head(card, type_size, card.decision()) + &body + &estimates(card) + &signatures(card))
}

/// The page to the verdict.
fn head(card: &Card<'_>, type_size: &str, decision: Decision) -> String {
    let m = card.mission;
    let (class, verdict) = (if decision.is_go() { "go" } else { "no" }, decision.words());
    let name = escape(&m.name);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>Release card: {name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body class=\"{type_size}\">\n\
         <header><div><p class=\"over\">Release card</p>\n<h1>{name}</h1>\n\
         <p>Vehicle {}, gains {}. samara {VERSION}; inputs {}</p></div>\n\
         <p class=\"verdict {class}\">{verdict}</p></header>\n",
        escape(&m.vehicle_name),
        escape(&m.control.gains_name),
        hash(&m.inputs.hash)
    )
}

/// What is estimated, above the signatures, and whether that is accepted.
fn estimates(card: &Card<'_>) -> String {
    let estimates = card.estimates();
    if estimates.is_empty() {
        return String::new();
    }
    let words = |input: &EstimatedInput| rich(&input.words()) + &links(card, &[input.from.to_owned()]);
    let words: Vec<String> = estimates.iter().map(words).collect();
    let standing =
        if card.accepts_estimates { "Accepted with these signatures" } else { "<b>NOT accepted</b>" };
    let text = format!("<p>{}. {standing}.</p>\n", words.join("; "));
    section("Estimated or guessed, not measured", &text)
}

/// Where the card is signed, and the page's end.
fn signatures(card: &Card<'_>) -> String {
    format!(
        "<section class=\"sign\"><table><tr><td>Name</td><td>Role</td><td>Date</td><td>Signature</td></tr>{}</table>\n\
         <p>Made again by <code>{}</code>. Hashes find what has changed; they are no signatures.</p></section>\n</body>\n</html>\n",
        "<tr><td></td><td></td><td></td><td></td></tr>".repeat(2),
        escape(&shortened(&card.command, COMMAND))
    )
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

fn section(title: &str, body: &str) -> String {
    format!("<section>\n<h2>{title}</h2>\n{body}</section>\n")
}

/// The beginning of a hash, the whole as a title.
fn hash(sha256: &str) -> String {
    let short: String = sha256.chars().take(HASH_DIGITS).collect();
    format!("<code title=\"SHA-256 {}\">{}</code>", escape(sha256), escape(&short))
}

/// Links to what something rests on, as many as are named: evidence leads to its file, an input to its place
/// below.
fn links(card: &Card<'_>, from: &[String]) -> String {
    let link = |id: &String| {
        let place = id.strip_prefix('E').and_then(|number| number.parse::<usize>().ok());
        let evidence = place.and_then(|place| card.evidence.get(place.checked_sub(1)?));
        let to = evidence.map_or_else(|| format!("#{id}"), |evidence| url(&evidence.link));
        format!("<a href=\"{}\">{}</a>", escape(&to), escape(id))
    };
    let mut links: Vec<String> = from.iter().take(NAMED).map(link).collect();
    links.extend((from.len() > NAMED).then(|| format!("+ {}", from.len() - NAMED)));
    if links.is_empty() { String::new() } else { format!(" <span class=\"from\">{}</span>", links.join(" ")) }
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

fn list(items: Vec<String>, most: usize) -> String {
    let more = rest(items.len(), most);
    let more = (!more.is_empty()).then_some(more);
    let items = items.into_iter().take(most).chain(more);
    let items: String = items.map(|item| format!("<li>{item}</li>\n")).collect();
    format!("<ul>\n{items}</ul>\n")
}

fn lines(card: &Card<'_>, lines: &[Line], most: usize) -> String {
    let row = |line: &Line| {
        format!("<dt>{}</dt><dd>{}{}</dd>\n", escape(&line.about), rich(&line.text), links(card, &line.from))
    };
    let more = rest(lines.len(), most);
    let more = if more.is_empty() { more } else { format!("<dt></dt><dd>{more}</dd>\n") };
    let rows: String = lines.iter().take(most).map(row).collect();
    format!("<dl>\n{rows}{more}</dl>\n")
}

/// A table: heads, then rows of cells that are HTML already.
fn table(class: &str, heads: &[&str], rows: &[Vec<String>]) -> String {
    let heads: String = heads.iter().map(|head| format!("<th scope=\"col\">{}</th>", rich(head))).collect();
    let row = |cells: &Vec<String>| {
        let cells: String = cells.iter().map(|cell| format!("<td>{cell}</td>")).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: String = rows.iter().map(row).collect();
    format!("<table class=\"{class}\"><thead><tr>{heads}</tr></thead>\n<tbody>\n{rows}</tbody></table>\n")
}

fn envelope(card: &Card<'_>) -> Result<String, FigureError> {
    let reaches = reaches(card);
    let Some((_, first)) = card.envelopes().next() else {
        return Ok(
            "<p>No evidence of the mission's release: samara assess --envelope searches it.</p>\n".to_owned()
        );
    };
    let rows: Vec<Vec<String>> = reaches
        .iter()
        .enumerate()
        .map(|(row, reach)| {
            let nominal = reach.nominal.map_or_else(|| "not known".to_owned(), |x| short(x, 2));
            let [narrow, wide] = reach.confirmed.each_ref().map(|reach| escape(&reach.words()));
            let drawn = escape(&reach.drawn_words());
            // The evidence is named at the first of its rows.
            let is_first = row == 0 || reaches[row - 1].from != reach.from;
            let from = if is_first { links(card, std::slice::from_ref(&reach.from)) } else { String::new() };
            vec![escape(reach.words), nominal, drawn, narrow, wide + &from]
        })
        .collect();
    let head = ["one at a time", "nominal", "drawn", "J_state < 0.7", "J_state < 1: go"];
    let panels: Vec<_> =
        card.envelopes().flat_map(|(_, envelope)| envelope.panels()).take(STRIP_PANELS).collect();
    let title = format!("Safe-release envelope: {}", card.mission.name);
    let figure = match envelope_strip((&title, &card.mission.stamp().csv_comment()), &panels) {
        Ok(svg) => format!("<figure>{}</figure>\n", svg.trim_start()),
        Err(FigureError::Empty) => String::new(),
        Err(e) => return Err(e),
    };
    let any = card.envelopes().any(|(_, envelope)| envelope.any_confirmed());
    let confirmed = confirmed_words(any, first.fresh_flights, first.probability, first.confidence);
    let unseen = card.envelopes().filter_map(|(id, envelope)| Some((id, envelope.not_looked_at()?)));
    let unseen: String =
        unseen.take(NAMED).map(|(id, what)| format!(" {id} has NOT looked at: {}.", escape(&what))).collect();
    let note = format!(
        "<p class=\"note\">{}.{unseen} Green and blue: J<sub>state</sub> below 0.7 and 1; cross: nominal release; drawn: three standard deviations either way, and the mission's own turbulence.</p>\n",
        rich(&confirmed)
    );
    Ok(format!("<div class=\"envelope\">{}{figure}</div>\n{note}", table("reaches", &head, &rows)))
}

fn probability_table(card: &Card<'_>) -> String {
    let found = probabilities(card);
    if found.is_empty() {
        return "<p>No evidence: samara assess flies campaigns.</p>\n".to_owned();
    }
    let mut rows: Vec<Vec<String>> = found
        .iter()
        .take(CAMPAIGNS)
        .map(|p| {
            let words = rich(&p.words()) + &links(card, std::slice::from_ref(&p.from));
            let [trials, failed] =
                [p.trials, p.failed].map(|n| n.map_or_else(|| "-".to_owned(), |n| n.to_string()));
            vec![rich(&p.flown_by), trials, failed, words, rich(&p.found_by)]
        })
        .collect();
    let more = rest(found.len(), CAMPAIGNS);
    if !more.is_empty() {
        rows.push(vec![more]);
    }
    table("campaigns", &["flown", "trials", "failed", "P(failure)", "found by"], &rows)
}

fn worst_table(card: &Card<'_>, most: usize) -> String {
    let found = worst(card);
    if found.is_empty() {
        return "<p>No evidence.</p>\n".to_owned();
    }
    let number = |x: Option<f64>, digits: usize| x.map_or_else(|| "-".to_owned(), |x| short(x, digits));
    // What was measured to its end and has no such time was never steady.
    let steady = |row: &Worst| match (STEADY_AFTER.of(&row.outcome.0), ALTITUDE_LOST.of(&row.outcome.0)) {
        (None, Some(_)) => STEADY_AFTER.without.to_owned(),
        (steady_after_s, _) => number(steady_after_s, 1),
    };
    let mut rows: Vec<Vec<String>> = found
        .iter()
        .take(most)
        .map(|row| {
            let outcome = match (&row.failure, &row.likely) {
                (Some(failure), _) => format!("<b>failed</b>: {}", rich(failure)),
                (None, Some(likely)) => rich(likely),
                (None, None) => "did not fail, closest".to_owned(),
            };
            vec![
                rich(&row.which) + &links(card, std::slice::from_ref(&row.from)),
                outcome,
                number(J_TPF.of(&row.outcome.0), 3),
                steady(row),
                number(ALTITUDE_LOST.of(&row.outcome.0), 1),
                number(PEAK_TILT.of(&row.outcome.0), 1),
            ]
        })
        .collect();
    let more = rest(found.len(), most);
    if !more.is_empty() {
        rows.push(vec![more]);
    }
    let heads = ["", "outcome", "J_TPF", "steady after [s]", "altitude lost [m]", "tilt [deg]"];
    table("worst", &heads, &rows)
}

/// The inputs, and the evidence at these places: the first in a table, the others one behind another.
fn evidence_table(card: &Card<'_>, places: &[usize]) -> String {
    let anchor = |id: &str| format!("<span id=\"{0}\">{0}</span>", escape(id));
    let inputs = card.inputs.iter().enumerate().map(|(place, input)| {
        let id = format!("I{}", place + 1);
        let (file, hash) = (shortened(&input.file, PATH), hash(&input.sha256));
        format!("{} {} {} {hash}", anchor(&id), input.role, escape(&file))
    });
    let inputs: Vec<String> = inputs.collect();
    let row = |place: &usize, most: usize| {
        let evidence = &card.evidence[*place];
        let sha256 = evidence.sha256.as_deref().map_or_else(|| "-".to_owned(), hash);
        let (link, file) = (url(&evidence.link), &evidence.file);
        let shown = escape(&shortened(file, most));
        let file = format!("<a href=\"{link}\" title=\"{}\">{shown}</a>", escape(file));
        vec![anchor(&Card::id(*place)), evidence.kind.words().to_owned(), file, sha256, standing(evidence)]
    };
    let (above, below) = places.split_at(places.len().min(TABLE));
    let rows: Vec<Vec<String>> = above.iter().map(|place| row(place, PATH)).collect();
    let table = table("evidence", &["", "what", "file", "SHA-256", "standing"], &rows);
    let mut behind: Vec<String> = below.iter().map(|place| row(place, PATH_BEHIND).join(" ")).collect();
    behind.push(rest(card.evidence.len(), places.len()));
    behind.retain(|piece| !piece.is_empty());
    let behind = match behind.is_empty() {
        true => String::new(),
        false => format!("<p class=\"inputs\">{}.</p>\n", behind.join("; ")),
    };
    format!("<p class=\"inputs\">Inputs: {}.</p>\n{table}{behind}", inputs.join("; "))
}

/// Whether evidence is accepted and counts, or why it does not.
fn standing(evidence: &Evidence) -> String {
    match &evidence.found {
        Ok(_) => {
            let counts = evidence.elsewhere().map(|of| format!(", not counted: of {of}"));
            let with = Some(evidence.otherwise()).filter(|with| !with.is_empty());
            let with = with.map(|with| format!(", with {with}"));
            escape(&["accepted".to_owned()].into_iter().chain(counts).chain(with).collect::<String>())
        }
        Err(why) => format!("<b>refused</b>: {}", escape(why)),
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
