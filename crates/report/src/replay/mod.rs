//! `drop.html`: a drop to be seen again, on one page that loads nothing from anywhere; and by the same script
//! the page of `samara view`, whose drop is flown anew at every change, and that of a flight while it flies.
//!
//! | file | holds |
//! |---|---|
//! | `data` | the flight, the plan and what is known about them, as the page's script takes them |
//! | `channel`, `base64` | columns of numbers as compact text |
//! | `words` | verdict, numbers and circumstances in words, as HTML |
//! | [`view`] | what `samara view` shows of a drop, and the files of its page |
//! | [`live`] | what is shown of a flight while it flies, and the files of that page |
//! | [`folder`] | the files of the page of a run's folder |
//! | `page.html`, `page.css` | the page of a drop and its style |
//! | `view.html`, `view.css` | the page of `samara view`, and what its style has beyond that |
//! | `live.html`, `live.css` | the page of a flight while it flies, and what its style has beyond a drop's |
//! | `folder.html`, `folder.css` | the page of a run's folder, and what its style has beyond a drop's |
//! | `player.html`, `seen.html` | what both have: the view in space with its panels and keys, what is seen |
//! | `page/` | the pages' scripts in their sources; `npm ci && npm run build` there makes the bundle |
//! | `beside.js` | hands a drop's page the run that it holds beside its own |
//! | `bundle/` | generated: script of a drop's page with three.js and uPlot, what the others have beyond it |
//!
//! What comes from files reaches a page as escaped text or as JSON without `<`. The policy of `drop.html`
//! lets the scripts of this module and no others run, by their hashes, and forbids every request.

mod base64;
mod channel;
mod data;
pub mod folder;
pub mod live;
pub mod view;
mod words;

use sha2::{Digest, Sha256};

use super::html::{Html, el, escape};
use super::json::VERSION;
use super::shown_drop::ShownDrop;

const TEMPLATE: &str = include_str!("page.html");
const PLAYER: &str = include_str!("player.html");
const SEEN: &str = include_str!("seen.html");
const STYLE: &str = include_str!("page.css");
const PLOT_STYLE: &str = include_str!("bundle/uplot.css");
// Once in a program, as no constant would be.
static SCRIPT: &str = include_str!("bundle/replay.js");
const TOOLS: &str = r#"<button id="theme" title="dark or light (d)" aria-label="dark" aria-pressed="false">&#9681;</button>
<button id="help-open" title="keys and explanations (?)" aria-label="help">?</button>
"#;
const KEY_OF_COMPARISON: &str = "<dt>c</dt><dd>compare with another run</dd>\n";
const BESIDE: &str = include_str!("beside.js");

/// Renders the page: the same drop gives the same bytes.
pub fn drop_page(drop: &ShownDrop<'_>) -> String {
    page(drop, None)
}

/// Renders the page with the motion of another flight laid over it as a ghost; its title is the name that
/// it bears there. What acted on it is not shown.
pub fn drop_page_beside(drop: &ShownDrop<'_>, ghost: &ShownDrop<'_>) -> String {
    page(drop, Some(ghost))
}

fn page(drop: &ShownDrop<'_>, ghost: Option<&ShownDrop<'_>>) -> String {
    let style = format!("{PLOT_STYLE}{STYLE}");
    let verdict = words::verdict(drop);
    let plan = drop.plan.is_some();
    filled(TEMPLATE, |name| match name {
        "title" => escape(drop.title),
        "version" => VERSION.to_owned(),
        "style_hash" => policy_hash(&style),
        "script_hash" => policy_hash(SCRIPT),
        "style" => style.clone(),
        "script" => SCRIPT.to_owned(),
        "verdict" => verdict.text.as_str().to_owned(),
        "verdict_class" => verdict.class.to_owned(),
        "numbers" => words::numbers(drop).into_string(),
        "facts" => words::facts(drop).into_string(),
        "table" => words::table(drop).into_string(),
        "origin" => words::origin(drop, data::rows(drop.samples).len()).into_string(),
        "tools" => TOOLS.to_owned(),
        "player" => player(plan, KEY_OF_COMPARISON),
        "seen" => seen(plan),
        "data" => data::object(drop, data::Shown::All),
        "beside_hash" if ghost.is_some() => format!(" {}", policy_hash(BESIDE)),
        "beside" => ghost.map_or(String::new(), |ghost| {
            let (name, data) = (escape(ghost.title), data::object(ghost, data::Shown::Motion));
            format!(
                "<script id=\"beside\" type=\"application/json\" data-name=\"{name}\">{data}</script>\n\
                 <script>{BESIDE}</script>\n"
            )
        }),
        _ => String::new(),
    })
}

/// The view in space, the panels and the keys, of a page whose drops have a plan or not.
fn player(plan: bool, keys: &str) -> String {
    filled(PLAYER, |name| match name {
        "key_plan" if plan => (el("i").class("plan").text("") + Html::text("plan")).into_string(),
        "keys" => keys.to_owned(),
        _ => String::new(),
    })
}

/// What is seen on the page, in words.
fn seen(plan: bool) -> String {
    let planned = " The pale vehicle and the dashed line are the plan at the same instant.";
    filled(SEEN.trim_end(), |_| if plan { planned.to_owned() } else { String::new() })
}

/// The template with each `{{name}}` replaced by its value. A value is not searched for names.
fn filled(template: &str, value: impl Fn(&str) -> String) -> String {
    let mut page = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        page += before;
        page += &value(name);
        rest = after;
    }
    page + rest
}

/// A page with the player, for the program that serves it: a template, and what keys do beyond a drop's page.
fn served_page(template: &str, keys: &str) -> String {
    filled(template, |name| match name {
        "version" => VERSION.to_owned(),
        "tools" => TOOLS.to_owned(),
        "player" => player(true, keys),
        "seen" => seen(true),
        _ => String::new(),
    })
}

/// A text's hash as a content security policy names it.
fn policy_hash(text: &str) -> String {
    format!("'sha256-{}'", base64::encode(&Sha256::digest(text.as_bytes())))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A block ends at the first `</script`, wherever it stands.
    #[test]
    fn nothing_in_script_or_style_ends_its_block() {
        let script = SCRIPT.to_lowercase();
        assert!(!script.contains("</script") && !script.contains("<!--"));
        assert!(!PLOT_STYLE.contains('<') && !STYLE.contains('<'));
        assert!(SCRIPT.contains("Generated by scripts/regenerate"));
        assert!(!BESIDE.contains("</script") && !BESIDE.contains("<!--"));
    }

    #[test]
    fn values_are_not_searched_for_names() {
        assert_eq!(
            filled("a {{x}} b {{y}}", |name| format!("<{name} {{{{y}}}}>")),
            "a <x {{y}}> b <y {{y}}>"
        );
    }

    /// The hash of nothing, FIPS 180-4: e3b0c442 98fc1c14 .. in base64.
    #[test]
    fn reference_the_policys_hash() {
        assert_eq!(policy_hash(""), "'sha256-47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU='");
    }
}
