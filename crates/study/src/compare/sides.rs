//! Words on A and on B, for terminal and page.

use samara_report::document::Passage;
use samara_report::html::Html;

/// Words on A and on B, a line each.
pub fn sides([a, b]: [String; 2]) -> [Passage; 2] {
    let lines = format!("A  {a}\nB  {b}\n");
    [Passage::OnTerminal(lines), Passage::Facts(vec![("A", Html::text(&a)), ("B", Html::text(&b))])]
}
