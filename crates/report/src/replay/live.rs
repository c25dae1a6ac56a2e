//! What `samara view` shows of a drop: the parts of the page of a drop that change with it, and the files of
//! the page that shows them one after the other.

use super::{data, words};
use crate::json::object;
use crate::shown_drop::ShownDrop;

/// The page, its script and its style.
pub const PAGE: &str = include_str!("bundle/view.html");
/// The page's script, with three.js and uPlot.
pub const SCRIPT: &str = include_str!("bundle/view.js");
/// The page's style.
pub const STYLE: &str = include_str!("bundle/view.css");

/// The data of a drop's page, as JSON.
pub fn drop_data(drop: &ShownDrop<'_>) -> String {
    data::object(drop)
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
