//! `junit.xml`: release cases, campaigns and failed trials as test cases, for the pages of continuous
//! integration (the format that Jenkins and GitLab read, <https://github.com/testmoapp/junitxml>).

use std::fmt::Write as _;

use super::CampaignReport;
use crate::html::escape;

/// A test case and why it failed, if it did.
struct Case {
    class: String,
    name: String,
    failure: Option<String>,
}

/// The XML document. It holds no durations: the same campaigns give the same bytes.
pub fn junit(report: &CampaignReport<'_>) -> String {
    let mut cases = Vec::new();
    for case in &report.cases {
        let name = case.case.replace('_', "-");
        cases.push(Case { class: "release case".to_owned(), name, failure: case.flight.failure.clone() });
    }
    // What stands beside the judged campaign is no test.
    if let Some(campaign) = report.judged() {
        let s = &campaign.summary;
        let failed = s.failed();
        cases.push(Case {
            class: campaign.name.clone(),
            name: format!("{} trials", s.flown()),
            failure: (failed > 0).then(|| format!("{failed} of {} trials failed", s.flown())),
        });
        for trial in s.worst.iter().filter(|trial| trial.failure.is_some()) {
            let name = format!("trial {}: {} --only {}", trial.trial, report.alone, trial.trial);
            cases.push(Case { class: campaign.name.clone(), name, failure: trial.failure.clone() });
        }
    }
    let failures = cases.iter().filter(|case| case.failure.is_some()).count();
    let suite = format!(
        "name=\"{}\" tests=\"{}\" failures=\"{failures}\"",
        escape(&report.mission.name),
        cases.len()
    );
    let mut xml =
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {suite}>\n<testsuite {suite}>\n");
    for Case { class, name, failure } in &cases {
        let head = format!("<testcase classname=\"{}\" name=\"{}\"", escape(class), escape(name));
        // Writing to a String cannot fail.
        let _ = match failure {
            None => writeln!(xml, "{head}/>"),
            Some(why) => writeln!(xml, "{head}><failure message=\"{}\"/></testcase>", escape(why)),
        };
    }
    xml + "</testsuite>\n</testsuites>\n"
}
