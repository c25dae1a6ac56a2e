//! The checks of a document as `junit.xml`, for the pages of continuous integration (the format that Jenkins
//! and GitLab read, <https://github.com/testmoapp/junitxml>).

use std::fmt::Write as _;

use super::{Check, Document};
use crate::html::escape;

impl Document {
    /// The XML document of a suite of this name. It holds no durations: the same checks give the same bytes.
    pub fn junit(&self, suite: &str) -> String {
        let failures = self.checks.iter().filter(|check| check.failure.is_some()).count();
        let suite =
            format!("name=\"{}\" tests=\"{}\" failures=\"{failures}\"", escape(suite), self.checks.len());
        let mut xml = format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {suite}>\n<testsuite {suite}>\n"
        );
        for Check { group, name, failure } in &self.checks {
            let head = format!("<testcase classname=\"{}\" name=\"{}\"", escape(group), escape(name));
            // Writing to a String cannot fail.
            let _ = match failure {
                None => writeln!(xml, "{head}/>"),
                Some(why) => writeln!(xml, "{head}><failure message=\"{}\"/></testcase>", escape(why)),
            };
        }
        xml + "</testsuite>\n</testsuites>\n"
    }
}
