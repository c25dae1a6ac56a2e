//! What is asked of a mission that is looked at: its keys, flights with other values, campaigns, files.

use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use hyper::StatusCode;
use serde_json::{Map, Value, json};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::time::Instant;

use super::body::{Answer, Answered, JSON, answered, lines_of, refused, told};
use crate::campaign::{DROPS_MOST, fly_drops};
use crate::controls::mission_shown;
use crate::flown::{Planned, answer};
use crate::viewed::{Changes, Refused, Viewed, changes_of, key_of, with_causes};
use crate::written::{Unwritten, write};
use samara_host::Threads;

/// The mission as it was opened, and the newest number that was asked by.
#[derive(Debug)]
pub struct Desk {
    viewed: Viewed,
    threads: Threads,
    /// The newest number that was asked by: what is older is stopped.
    newest: AtomicU64,
    /// The last plan, with what was changed for it: a campaign follows its flight.
    last: Mutex<Option<(Changes, Arc<Planned>)>>,
}

/// What is asked of a changed mission.
struct Asked {
    number: u64,
    changes: Changes,
    drops: u64,
    name: String,
}

impl Asked {
    /// What an object asks for, or the answer that says what is wrong with it.
    fn of(object: &Map<String, Value>) -> Result<Self, Box<Answer>> {
        let none = Map::new();
        let whole = |key: &str, absent: u64| object.get(key).map_or(Some(absent), Value::as_u64);
        let changes = object.get("changes").map_or(Some(&none), Value::as_object);
        let name = object.get("name").map_or(Some(""), Value::as_str);
        let (Some(number), Some(drops), Some(changes), Some(name)) =
            (whole("number", 0), whole("drops", DROPS_MOST), changes, name)
        else {
            return Err(Box::new(refused(StatusCode::BAD_REQUEST)));
        };
        let changes = changes_of(changes).map_err(|(key, error)| {
            let object = json!({ "number": number, "error": error, "key": key });
            Box::new(told(StatusCode::UNPROCESSABLE_ENTITY, &object))
        })?;
        Ok(Self { number, changes, drops, name: name.to_owned() })
    }
}

impl Desk {
    /// A mission of which nothing was asked yet.
    pub fn new(viewed: Viewed) -> io::Result<Self> {
        let threads = Threads::new(None)?;
        Ok(Self { viewed, threads, newest: AtomicU64::new(0), last: Mutex::new(None) })
    }

    /// Has everything end that is being computed.
    pub fn end(&self) {
        self.newest.store(u64::MAX, Ordering::Relaxed);
    }

    /// What is at a path.
    pub async fn get(self: Arc<Self>, path: &str) -> Answer {
        match path {
            "/mission" => self.computed(|all| all.mission()).await,
            _ => refused(StatusCode::NOT_FOUND),
        }
    }

    /// The answer to an object that is brought to a path.
    pub async fn post(self: Arc<Self>, path: &str, object: &Map<String, Value>) -> Answer {
        let asked = match Asked::of(object) {
            Ok(asked) => asked,
            Err(answer) => return *answer,
        };
        match path {
            "/fly" => self.computed(move |all| all.fly(&asked)).await,
            "/campaign" => self.computed(move |all| all.campaign(asked)).await,
            "/write" => self.computed(move |all| all.write(&asked)).await,
            _ => refused(StatusCode::NOT_FOUND),
        }
    }

    /// What is computed for an answer, beside the thread of the sockets.
    async fn computed(
        self: Arc<Self>,
        compute: impl FnOnce(&Arc<Self>) -> Answer + Send + 'static,
    ) -> Answer {
        let computed = tokio::task::spawn_blocking(move || compute(&self)).await;
        computed.unwrap_or_else(|_| refused(StatusCode::INTERNAL_SERVER_ERROR))
    }

    fn mission(&self) -> Answer {
        match self.viewed.with(&[]).and_then(|mission| mission_shown(&self.viewed, &mission)) {
            Ok(object) => answered(StatusCode::OK, JSON, object),
            Err(why) => told(StatusCode::UNPROCESSABLE_ENTITY, &json!({ "error": with_causes(&why) })),
        }
    }

    /// Whether a newer number was asked by than this one.
    fn is_overtaken(&self, number: u64) -> bool {
        self.newest.load(Ordering::Relaxed) > number
    }

    /// Plans what is asked for, unless that was done last.
    fn planned(&self, asked: &Asked) -> Result<Arc<Planned>, Refused> {
        self.newest.fetch_max(asked.number, Ordering::Relaxed);
        let stop = || self.is_overtaken(asked.number);
        // One at a time: what waits here is overtaken by the time that it goes on, or the newest.
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if stop() {
            return Err(Refused::Overtaken);
        }
        if let Some((_, planned)) = last.as_ref().filter(|(changes, _)| *changes == asked.changes) {
            return Ok(planned.clone());
        }
        let planned = Arc::new(Planned::new(&self.viewed, &asked.changes, &stop)?);
        *last = Some((asked.changes.clone(), planned.clone()));
        Ok(planned)
    }

    fn fly(&self, asked: &Asked) -> Answer {
        let (began, stop) = (Instant::now(), || self.is_overtaken(asked.number));
        let flown = || {
            let planned = self.planned(asked)?;
            let flown = planned.fly(&self.threads, &stop)?;
            let (command, took) = (self.viewed.command(&asked.changes), began.elapsed());
            Ok(answer(&flown, &command, asked.number, 1e3 * took.as_secs_f64()))
        };
        match flown() {
            Ok(object) => answered(StatusCode::OK, JSON, object),
            Err(why) => unflown(asked, &why),
        }
    }

    /// Begins a campaign, whose lines come as they are flown.
    fn campaign(self: &Arc<Self>, asked: Asked) -> Answer {
        let planned = match self.planned(&asked) {
            Ok(planned) => planned,
            Err(why) => return unflown(&asked, &why),
        };
        let (sender, lines) = unbounded_channel();
        let all = self.clone();
        tokio::task::spawn_blocking(move || all.fly_drops(&asked, &planned, &sender));
        lines_of(Answered::Lines(lines))
    }

    fn fly_drops(&self, asked: &Asked, planned: &Planned, lines: &UnboundedSender<String>) {
        let stop = || lines.is_closed() || self.is_overtaken(asked.number);
        let flown =
            fly_drops(planned, asked.drops, &self.threads, &stop, &mut |line| lines.send(line).is_ok());
        if let Err(why) = flown {
            let last = match why {
                Refused::Overtaken => json!({ "overtaken": true }),
                why => json!({ "error": with_causes(&why) }),
            };
            // Who has gone away does not hear it.
            let _ = lines.send(last.to_string());
        }
    }

    fn write(&self, asked: &Asked) -> Answer {
        match write(&self.viewed, &asked.changes, &asked.name) {
            Ok(written) => told(StatusCode::OK, &json!({ "written": written })),
            Err(why) => {
                let exists = matches!(why, Unwritten::Exists(_));
                let status = if exists { StatusCode::CONFLICT } else { StatusCode::UNPROCESSABLE_ENTITY };
                told(status, &json!({ "error": with_causes(&why) }))
            }
        }
    }
}

/// Why there is no flight.
fn unflown(asked: &Asked, why: &Refused) -> Answer {
    let number = asked.number;
    match why {
        Refused::Overtaken => told(StatusCode::CONFLICT, &json!({ "number": number, "overtaken": true })),
        why => {
            let error = with_causes(why);
            let key = key_of(&error, &asked.changes);
            let object = json!({ "number": number, "error": error, "key": key });
            told(StatusCode::UNPROCESSABLE_ENTITY, &object)
        }
    }
}
