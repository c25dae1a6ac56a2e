//! The files of the page that `samara view` shows of a run's folder: pages, campaigns, worst trials.

use super::filled;
use crate::json::VERSION;

const PAGE: &str = include_str!("folder.html");
const STYLE: &str = include_str!("folder.css");
const SCRIPT: &str = include_str!("bundle/folder.js");

/// The page, which asks the program that serves it for all that it shows; its style and script are asked for
/// as `folder.css` and `folder.js`.
pub fn page() -> String {
    filled(PAGE, |name| if name == "version" { VERSION.to_owned() } else { String::new() })
}

/// The page's script.
pub fn script() -> String {
    SCRIPT.to_owned()
}

/// The page's style.
pub fn style() -> String {
    [super::STYLE, STYLE].concat()
}
