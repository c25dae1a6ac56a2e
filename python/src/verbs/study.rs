//! Studies of a mission: any kind that the library has.

use std::fs::OpenOptions;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

use pyo3::prelude::*;
use samara::config::Mission;
use samara::host::kept::{KeptRows, RowsFile as _, going_on};
use samara::host::{Host, Progress};
use samara::study::kind::{About, Flies, Given as GivenStudy, Study, Unfinished};
use samara::study::kinds::{KINDS, kind};
use samara::study::settings::Values;

use super::plan::converged;
use crate::fault::{Fault, OrGiven as _};
use crate::given::Given;
use crate::own_controller::{Own, OwnController};
use crate::pool::pool;
use crate::work::{Stop, work_watched};

/// What came of a study.
#[pyclass(frozen, get_all, module = "samara_tpf._samara")]
#[derive(Debug)]
pub struct Studied {
    /// Name of the kind.
    kind: String,
    /// The object of `<kind>.json`.
    json: String,
    /// The text of `<kind>.txt`.
    text: String,
    /// The page `<kind>.html`.
    page: String,
    /// The texts of all other files, by name: tables, drawings, what can be flown again.
    files: Vec<(String, String)>,
    /// Whether the answer is yes.
    holds: bool,
}

/// Names of the kinds, each with what it asks, and its settings: name, what stands for a value, the usual
/// value, sentences about it.
#[pyfunction]
#[allow(clippy::type_complexity, reason = "a table for Python")]
pub fn studies() -> Vec<(&'static str, &'static str, Vec<[&'static str; 4]>)> {
    let of = |kind: &&dyn samara::study::kind::Kind| {
        let about = kind.about();
        let settings = about.settings.iter().map(|s| [s.name, s.value, s.usual, s.about]).collect();
        (about.name, about.title, settings)
    };
    KINDS.iter().map(of).collect()
}

/// Flies a study of this kind with these settings, names and texts. `progress` is called with what is flown,
/// how many jobs are done and how many there may be; `rows` is a file that keeps rows, from which an earlier
/// call with the same arguments goes on. A controller is asked in one thread, for one flight after the other.
#[pyfunction]
#[pyo3(signature = (given, name, settings, *, threads=None, rows=None, progress=None, controller=None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn study(
    py: Python<'_>,
    given: Given,
    name: String,
    settings: Vec<(String, String)>,
    threads: Option<usize>,
    rows: Option<PathBuf>,
    progress: Option<Py<PyAny>>,
    controller: Option<Own>,
) -> PyResult<Studied> {
    let asked = Arc::new(OnceLock::new());
    let (flown, told) = (asked.clone(), Told::default());
    let (seen, mut last) = (told.clone(), None);
    let watch = move |py: Python<'_>| match &progress {
        None => Ok(()),
        Some(progress) => {
            let now = seen.now();
            // Nothing is flown while the mission is planned.
            let begun = !now.0.is_empty();
            if begun && last.as_ref() != Some(&now) {
                progress.call1(py, now.clone())?;
                last = Some(now);
            }
            Ok(())
        }
    };
    let found = work_watched(py, watch, move |stop| {
        let by = (controller, &*flown);
        fly(&given, &name, &settings, (threads, rows.as_deref()), by, (&told, stop))
    });
    asked
        .get()
        .map_or(Ok(()), |own: &OwnController| own.check(py, || "in a flight of the study".to_owned()))?;
    found
}

fn fly(
    given: &Given,
    name: &str,
    settings: &[(String, String)],
    (threads, rows): (Option<usize>, Option<&Path>),
    (controller, flown): (Option<Own>, &OnceLock<OwnController>),
    (told, stop): (&Told, &Stop),
) -> Result<Studied, Fault> {
    let kind = kind(name).map_err(|e| Fault::in_words(format!("kind: {e}")))?;
    let about = kind.about();
    let mut values = Values::usual(about.settings);
    for (name, text) in settings {
        values.put(about.settings, name, text).map_err(|e| Fault::in_words(format!("{name}: {e}")))?;
    }
    let mut mission = given.mission()?;
    kind.suits(&mission).map_err(|e| Fault::in_words(format!("{}: {e}", mission.file.display())))?;
    if let Some(own) = controller {
        if let Some(why) = kind.flies_only() {
            return Err(Fault::in_words(format!("controller: {why}")));
        }
        let (name, own) =
            (own.name.clone(), OwnController::new(own, &mission.vehicle, &mission.site.environment));
        mission.note_choice("controller", &name);
        mission.control.fly_by(&name, Box::new(own.clone()));
        let _ = flown.set(own);
    }
    let own = given.has_gains().then(|| given.without_choices().mission()).transpose()?;
    let plan = match about.flies {
        Flies::WithoutAPlan => None,
        _ => Some(converged(&mission, stop)?),
    };
    let of = GivenStudy { mission: &mission, own: own.as_ref(), plan: plan.as_ref(), folder: None };
    let refused = |why| Fault::in_words(format!("{}: {why}", mission.file.display()));
    let head = kind.head(&mission, &values).map_err(refused)?;
    let study = kind.begin(of, &values).map_err(refused)?;
    told.tell(|now| now.2 = study.jobs());
    let kept = match rows {
        None => KeptRows::nowhere(),
        Some(path) => kept(path, &head)?,
    };
    let is_stopped = || stop.raised() || flown.get().is_some_and(OwnController::is_broken);
    run((&*study, &about, &values), &mission, (threads, kept), (told, stop, &is_stopped))
}

fn run(
    (study, about, values): (&dyn Study, &About, &Values),
    mission: &Mission,
    (threads, kept): (Option<usize>, KeptRows),
    (told, stop, is_stopped): (&Told, &Stop, &(dyn Fn() -> bool + Sync)),
) -> Result<Studied, Fault> {
    let pool = pool(threads)?;
    let mut host = Host::new(&pool, is_stopped, told, kept);
    let found = match (study.run(&mut host), host.failure()) {
        (Ok(found), _) if found.stopped && stop.raised() => return Err(Fault::stopped()),
        (Ok(found), _) => found,
        (Err(Unfinished::Figure(error)), _) => return Err(error).or_given(),
        (Err(error @ Unfinished::File(_)), _) => return Err(error).or_given(),
        (Err(Unfinished::Nothing { .. }), _) if stop.raised() => return Err(Fault::stopped()),
        (Err(Unfinished::Nothing { why, .. }), _) => return Err(Fault::NoGains(why)),
        (Err(Unfinished::Stopped), Some(error)) => return Err(Fault::in_words(format!("rows: {error}"))),
        (Err(Unfinished::Stopped), None) => return Err(Fault::stopped()),
    };
    let page = found.page(about, mission, values);
    let junit = found.junit(about, mission);
    let (json, text) = (found.json.clone(), found.text());
    let mut files = found.files;
    files.extend(found.figures.into_iter().map(|figure| (figure.file, figure.svg)));
    files.extend(junit.map(|text| (format!("{}_junit.xml", about.name), text)));
    Ok(Studied { kind: about.name.to_owned(), json, text, page, files, holds: found.holds })
}

/// The rows that an earlier call has left in a file, which takes those to come. Another call that writes to
/// it is waited for.
fn kept(path: &Path, head: &str) -> Result<KeptRows, Fault> {
    let named = |error: &dyn std::fmt::Display| Fault::in_words(format!("rows: {}: {error}", path.display()));
    let mut open = OpenOptions::new();
    let file = open.read(true).write(true).create(true).truncate(false).open(path);
    let mut file = file.map_err(|e| named(&e))?;
    // A call that was broken off flies on for a moment, and writes; where a file system has no locks there is
    // nothing to wait for.
    let _ = file.lock();
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|e| named(&e))?;
    let earlier = going_on(&String::from_utf8_lossy(&bytes), head).map_err(|e| named(&e))?;
    file.cut(earlier.whole()).map_err(|e| named(&e))?;
    KeptRows::going_on(head, earlier, Box::new(file)).map_err(|e| named(&e))
}

/// How far a study is: what is flown, jobs done, jobs in all.
#[derive(Clone, Debug, Default)]
struct Told(Arc<Mutex<(String, u64, u64)>>);

impl Told {
    fn tell(&self, tell: impl FnOnce(&mut (String, u64, u64))) {
        if let Ok(mut now) = self.0.lock() {
            tell(&mut now);
        }
    }

    fn now(&self) -> (String, u64, u64) {
        self.0.lock().map(|now| now.clone()).unwrap_or_default()
    }
}

impl Progress for Told {
    fn begins(&self, what: &str) {
        self.tell(|now| what.clone_into(&mut now.0));
    }

    fn done(&self, jobs: u64, _: bool) {
        self.tell(|now| now.1 += jobs);
    }

    fn stage(&self, _: &'static str, jobs: u64) {
        self.tell(|now| now.2 = now.1 + jobs);
    }
}
