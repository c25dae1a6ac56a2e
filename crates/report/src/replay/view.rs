//! What `samara view` shows of a drop: the parts of the page of a drop that change with it, and the files of
//! the page that shows them one after the other.

use super::{PLOT_STYLE, data, served_page, words};
use crate::json::object;
use crate::shown_drop::ShownDrop;

const PAGE: &str = include_str!("view.html");
const STYLE: &str = include_str!("view.css");
const SCRIPT: &str = include_str!("bundle/view.js");
const KEYS_OF_VIEW: &str = "<dt>ctrl z, ctrl shift z</dt><dd>undo, redo</dd>\n<dt>k</dt><dd>keep this variant</dd>\n\
                            <dt>/</dt><dd>another key of the mission</dd>\n";

/// The page, which asks the program that serves it for all that it shows; its style and script are asked for
/// as `view.css` and `view.js`.
pub fn page() -> String {
    served_page(PAGE, KEYS_OF_VIEW)
}

/// The page's script: that of a drop's page, with three.js and uPlot, and what is beyond it.
pub fn script() -> String {
    [super::SCRIPT, SCRIPT].concat()
}

/// The page's style: that of a drop's page, and what is beyond it.
pub fn style() -> String {
    [PLOT_STYLE, super::STYLE, STYLE].concat()
}

/// The data of a drop's page, as JSON.
pub fn drop_data(drop: &ShownDrop<'_>) -> String {
    data::object(drop, data::Shown::All)
}

/// Verdict, numbers, circumstances and table of a drop, each as HTML.
pub fn drop_words(drop: &ShownDrop<'_>) -> impl serde::Serialize {
    object! {
        verdict: words::verdict(drop).text.into_string(),
        numbers: words::numbers(drop).into_string(),
        facts: words::facts(drop).into_string(),
        table: words::table(drop).into_string(),
    }
}
