//! A kind of study from outside the crate, by the recipe of CONTRIBUTING.md: two files, and all that hosts
//! offer is there for it.
#![cfg(all(feature = "files", feature = "host"))]

use std::collections::BTreeMap;
use std::io;
use std::sync::Mutex;

use samara::config::Mission;
use samara::host::kept::{Earlier, KeptRows, RowsFile, going_on};
use samara::host::shards::{Ended, Shards};
use samara::host::{Host, Silent, Threads};
use samara::plan::{Plan, SolverOptions};
use samara::study::cut::Cut;
use samara::study::jobs::HereAndNow;
use samara::study::kind::{Given, Kind, Results, Unfinished};
use samara::study::settings::Values;

#[path = "../examples/own_study.rs"]
#[expect(dead_code, reason = "the example's main")]
mod example;
use example::Swing;

fn planned() -> (Mission, Plan) {
    let mission = Mission::shipped("x500_drop").unwrap();
    let plan = mission.solve(&SolverOptions::default(), &mut |_| std::ops::ControlFlow::Continue(()));
    (mission, plan.unwrap())
}

fn files(results: &Results) -> (String, String, Vec<(String, String)>) {
    (results.document.text(), results.json.clone(), results.files.clone())
}

/// More swing, no better J_TPF than without; a page, a table and an object by one and the same answer.
#[test]
fn a_kind_of_one_s_own_has_what_kinds_have() {
    let (mission, plan) = planned();
    let given = Given { mission: &mission, own: None, plan: Some(&plan), folder: None };
    let about = Swing.about();
    let mut values = Values::usual(about.settings);
    values.put(about.settings, "steps", "5").unwrap();
    assert!(values.put(about.settings, "most", "-1").unwrap_err().contains("above 0"));
    let study = Swing.begin(given, &values).unwrap();
    let results = study.run(&mut HereAndNow).unwrap();
    let costs: Vec<f64> = results.files[0]
        .1
        .lines()
        .skip(1)
        .map(|row| row.split_once(',').unwrap().1.parse().unwrap())
        .collect();
    assert!(costs.len() == 5 && costs[4] >= costs[0], "{costs:?}");
    let page = results.page(&about, &mission, &values);
    assert!(page.contains("by swing: x500_drop</h1>") && page.contains("every swing stays below"));
    assert!(results.junit(&about, &mission).unwrap().contains("every swing stays below J_TPF 1"));
    let object: serde_json::Value = serde_json::from_str(&results.json).unwrap();
    assert_eq!(object["j_tpf"].as_array().unwrap().len(), 5);
}

/// Stopped after two rows it goes on, and in two shards it is put together: to the same bytes.
#[test]
fn prop_a_kind_of_one_s_own_goes_on_and_flies_in_shards() {
    let (mission, plan) = planned();
    let given = Given { mission: &mission, own: None, plan: Some(&plan), folder: None };
    let values = Values::usual(Swing.about().settings);
    let study = Swing.begin(given, &values).unwrap();
    let whole = study.run(&mut HereAndNow).unwrap();
    let kind: &dyn Kind = &Swing;
    let (pool, head) = (Threads::new(Some(2)).unwrap(), kind.head(&mission, &values).unwrap());
    let kept = Memory::default();
    let rows = KeptRows::going_on(&head, Earlier::default(), Box::new(kept.clone())).unwrap();
    study.run(&mut Host::new(&pool, &|| false, &Silent, rows)).unwrap();
    let text = kept.0.lock().unwrap().clone();
    let cut = text.match_indices('\n').nth(2).unwrap().0 + 5;
    let earlier = going_on(&text[..cut], &head).unwrap();
    assert_eq!(earlier.whole() as usize, cut - 4);
    let rows = KeptRows::going_on(&head, earlier, Box::new(Memory::default())).unwrap();
    let again = study.run(&mut Host::new(&pool, &|| false, &Silent, rows)).unwrap();
    assert_eq!(files(&again), files(&whole));

    let folder = Folder::default();
    for part in 0..2 {
        let shards = Shards::new(&folder, &head, Some(Cut { part, of: 2 }));
        let mut host = Host::in_shards(&pool, &|| false, &Silent, shards);
        assert!(matches!(study.run(&mut host), Err(Unfinished::Stopped)) && host.failure().is_none());
        assert!(matches!(host.ended(), Some(Ended::Part { flown: true, .. })));
    }
    let merged = Host::in_shards(&pool, &|| false, &Silent, Shards::new(&folder, &head, None));
    let mut merged = merged;
    assert_eq!(files(&study.run(&mut merged).unwrap()), files(&whole));
}

#[derive(Clone, Default)]
struct Memory(std::sync::Arc<Mutex<String>>);

impl io::Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        *self.0.lock().unwrap() += std::str::from_utf8(bytes).unwrap();
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl RowsFile for Memory {
    fn cut(&mut self, bytes: u64) -> io::Result<()> {
        self.0.lock().unwrap().truncate(bytes as usize);
        Ok(())
    }
}

/// Files of shards in memory.
type Folder = Mutex<BTreeMap<String, String>>;
