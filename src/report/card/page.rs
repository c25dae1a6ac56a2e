//! `card.html`: the card on one sheet of A4. The page is self-contained: no script, no font, no image from
//! elsewhere; black on white.

use super::Card;
use super::assumptions::{assumed, not_modelled};
use super::sections::{
    Line, air_and_release, autopilot, drops, probabilities, reaches, vehicle_and_design, worst,
};
use crate::report::columns::short;
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
/// Sizes of type, and how many rows of tables and lists a sheet has room for in each: what has more is set in
/// the next. A browser's test holds it.
const SIZES: [(&str, usize); 3] = [("airy", 16), ("plain", 22), ("dense", usize::MAX)];
/// Longest path and longest command on the sheet [characters]; the whole stands in `card.json`.
const PATH: usize = 52;
const COMMAND: usize = 260;
/// Digits of a hash on the sheet.
const HASH_DIGITS: usize = 16;

/// The HTML document.
///
/// # Errors
/// [`FigureError`] when the figure of the envelope cannot be drawn.
pub fn page(card: &Card<'_>) -> Result<String, FigureError> {
    let m = card.mission;
    let reasons = card.reasons();
    let (class, verdict) = if reasons.is_empty() { ("go", "GO") } else { ("no", "NO GO") };
    let rows = rows(card, reasons.len());
    let type_size = SIZES.iter().find(|(_, most)| rows <= *most).map_or("dense", |(size, _)| size);
    let name = escape(&m.name);
    let mut html = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>Release card: {name}</title>\n<style>\n{STYLE}</style>\n</head>\n<body class=\"{type_size}\">\n\
         <header><div><p class=\"over\">Release card</p>\n<h1>{name}</h1>\n\
         <p>Vehicle {}, gains {}. samara {VERSION}; inputs {}</p></div>\n\
         <p class=\"verdict {class}\">{verdict}</p></header>\n<p class=\"conclusion\">{}</p>\n",
        escape(&m.vehicle_name),
        escape(&m.control.gains_name),
        hash(&m.inputs.hash),
        escape(&card.conclusion())
    );
    if !reasons.is_empty() {
        let texts =
            reasons.iter().map(|reason| format!("{}{}", rich(&reason.text), links(card, &reason.from)));
        html += &list(texts.collect(), REASONS);
    }
    html += "<div class=\"two\">\n";
    html += &section("Vehicle and design", &lines(card, &vehicle_and_design(card), LINES));
    html += &section("Air and release", &lines(card, &air_and_release(card), LINES));
    html += "</div>\n";
    let flown = lines(card, &drops(card), DROPS) + &lines(card, &autopilot(card), PX4S);
    html += &section("Drops and autopilot", &flown);
    html += &section("Go/no-go envelope of the release", &envelope(card)?);
    html += &section("Probability of failure", &probability_table(card));
    html += &section("Worst ways to fail", &worst_table(card, WORST));
    html += "<div class=\"two\">\n";
    let sentences =
        |sentences: Vec<String>| list(sentences.iter().map(|text| rich(text)).collect(), SENTENCES);
    html += &section("What is assumed", &sentences(assumed(card)));
    html += &section("What was never modelled", &sentences(not_modelled(card)));
    html += "</div>\n";
    html += &section("Evidence", &evidence_table(card, EVIDENCE));
    html += &format!(
        "<section class=\"sign\"><table><tr><td>Name</td><td>Role</td><td>Date</td><td>Signature</td></tr>{}</table>\n\
         <p>Made again by <code>{}</code>. Hashes find what has changed; they are no signatures.</p></section>\n",
        "<tr><td></td><td></td><td></td><td></td></tr>".repeat(2),
        escape(&shortened(&card.command, COMMAND))
    );
    Ok(html + "</body>\n</html>\n")
}

/// Rows of the sheet that differ from card to card.
fn rows(card: &Card<'_>, reasons: usize) -> usize {
    let parts = [
        (reasons, REASONS),
        (vehicle_and_design(card).len(), LINES),
        (drops(card).len(), DROPS),
        (autopilot(card).len(), PX4S),
        (probabilities(card).len(), CAMPAIGNS),
        (worst(card).len(), WORST),
        (card.evidence.len(), EVIDENCE),
    ];
    parts.into_iter().map(|(count, most)| count.min(most)).sum::<usize>() + reaches(card).len()
}

fn section(title: &str, body: &str) -> String {
    format!("<section>\n<h2>{title}</h2>\n{body}</section>\n")
}

/// The beginning of a hash, the whole as a title.
fn hash(sha256: &str) -> String {
    let short: String = sha256.chars().take(HASH_DIGITS).collect();
    format!("<code title=\"SHA-256 {}\">{}</code>", escape(sha256), escape(&short))
}

/// Links to the evidence that something rests on: each leads to its file, an input to its place below.
fn links(card: &Card<'_>, from: &[String]) -> String {
    let link = |id: &String| {
        let place = id.strip_prefix('E').and_then(|number| number.parse::<usize>().ok());
        let evidence = place.and_then(|place| card.evidence.get(place.checked_sub(1)?));
        let to = evidence.map_or_else(|| format!("#{id}"), |evidence| url(&evidence.link));
        format!("<a href=\"{}\">{}</a>", escape(&to), escape(id))
    };
    let links: Vec<String> = from.iter().map(link).collect();
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
        return Ok("<p>No evidence: samara assess --envelope searches it.</p>\n".to_owned());
    };
    let rows: Vec<Vec<String>> = reaches
        .iter()
        .map(|reach| {
            let nominal = reach.nominal.map_or_else(|| "-".to_owned(), |x| short(x, 2));
            let [narrow, wide] = reach.confirmed.each_ref().map(|reach| escape(&reach.words()));
            vec![escape(reach.words), nominal, narrow, wide + &links(card, std::slice::from_ref(&reach.from))]
        })
        .collect();
    let head = ["one at a time", "nominal", "J_state < 0.7", "J_state < 1: go"];
    let panels: Vec<_> =
        card.envelopes().flat_map(|(_, envelope)| envelope.panels()).take(STRIP_PANELS).collect();
    let title = format!("Safe-release envelope: {}", card.mission.name);
    let figure = match envelope_strip((&title, &card.mission.stamp().csv_comment()), &panels) {
        Ok(svg) => format!("<figure>{}</figure>\n", svg.trim_start()),
        Err(FigureError::Empty) => String::new(),
        Err(e) => return Err(e),
    };
    let note = format!(
        "<p class=\"note\">Confirmed edges: all of {} fresh flights were safe there, so that {} % are with {} % confidence; + the end of what was \
         looked at, - nothing confirmed. Green and blue: J<sub>state</sub> below 0.7 and 1; cross: nominal release.</p>\n",
        first.fresh_flights,
        short(100.0 * first.probability, 2),
        short(100.0 * first.confidence, 2)
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
            let words = escape(&p.words()) + &links(card, std::slice::from_ref(&p.from));
            let failed = p.failed.map_or_else(|| "-".to_owned(), |failed| failed.to_string());
            vec![escape(&p.flown_by), p.trials.to_string(), failed, words, escape(&p.found_by)]
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
    let mut rows: Vec<Vec<String>> = found
        .iter()
        .take(most)
        .map(|row| {
            let outcome = match &row.failure {
                Some(failure) => format!("<b>failed</b>: {}", rich(failure)),
                None => "did not fail, closest".to_owned(),
            };
            vec![
                escape(&row.which) + &links(card, std::slice::from_ref(&row.from)),
                outcome,
                number(row.j_tpf, 3),
                number(row.steady_after_s, 1),
                number(row.altitude_lost_m, 1),
                number(row.peak_tilt_deg, 1),
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

fn evidence_table(card: &Card<'_>, most: usize) -> String {
    let anchor = |id: &str| format!("<span id=\"{0}\">{0}</span>", escape(id));
    let inputs = card.inputs.iter().enumerate().map(|(place, input)| {
        let id = format!("I{}", place + 1);
        let (file, hash) = (shortened(&input.file, PATH), hash(&input.sha256));
        format!("{} {} {} {hash}", anchor(&id), input.role, escape(&file))
    });
    let inputs: Vec<String> = inputs.collect();
    let mut rows: Vec<Vec<String>> = Vec::new();
    let chosen = shown_evidence(card, most);
    for place in &chosen {
        let evidence = &card.evidence[*place];
        let standing = match &evidence.found {
            Ok(_) => "accepted".to_owned(),
            Err(why) => format!("<b>refused</b>: {}", escape(why)),
        };
        let sha256 = evidence.sha256.as_deref().map_or_else(|| "-".to_owned(), hash);
        let (link, file) = (url(&evidence.link), &evidence.file);
        let shown = escape(&shortened(file, PATH));
        let file = format!("<a href=\"{link}\" title=\"{}\">{shown}</a>", escape(file));
        rows.push(vec![anchor(&Card::id(*place)), evidence.kind.words().to_owned(), file, sha256, standing]);
    }
    let more = rest(card.evidence.len(), chosen.len());
    if !more.is_empty() {
        rows.push(vec![String::new(), more]);
    }
    let table = table("evidence", &["", "what", "file", "SHA-256", "standing"], &rows);
    format!("<p class=\"inputs\">Inputs: {}.</p>\n{table}", inputs.join("; "))
}

/// Places of the evidence that is shown, at most so many: the first of each kind, then what is refused, then
/// the rest; in order.
fn shown_evidence(card: &Card<'_>, most: usize) -> Vec<usize> {
    let all = &card.evidence;
    let before = |place: usize| all[..place].iter().filter(|other| other.found.is_ok());
    let is_first = |place: usize| before(place).all(|other| other.kind != all[place].kind);
    let rank = |place: &usize| match &all[*place].found {
        Ok(_) if is_first(*place) => 0,
        Err(_) => 1,
        Ok(_) => 2,
    };
    let mut places: Vec<usize> = (0..all.len()).collect();
    places.sort_by_key(rank);
    places.truncate(most);
    places.sort_unstable();
    places
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
