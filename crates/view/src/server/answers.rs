//! What can be asked, and what is answered.

use std::io;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use hyper::body::{Bytes, Incoming};
use hyper::header::{CONTENT_TYPE, HeaderName, HeaderValue, SET_COOKIE};
use hyper::{Method, Request, Response, StatusCode};
use serde_json::{Map, Value, json};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};
use tokio::time::{Duration, Instant, timeout};

use super::body::{Answered, read};
use super::guard::{BODY_MOST, Closed, Guard, HEADERS, Token};
use crate::campaign::{DROPS_MOST, fly_drops};
use crate::controls::mission_shown;
use crate::flown::{Planned, answer};
use crate::viewed::{Changes, Refused, Viewed, changes_of, key_of, with_causes};
use crate::written::{Unwritten, write};
use samara_host::Threads;
use samara_report::replay::live::{page, script, style};

const JSON: &str = "application/json";
const LINES: &str = "application/x-ndjson";
const TEXT: &str = "text/plain; charset=utf-8";

type Answer = Response<Answered>;

/// What the server knows: the mission as it was opened, who may ask, and the newest number.
#[derive(Debug)]
pub struct Answers {
    viewed: Viewed,
    guard: Guard,
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

impl Answers {
    /// The answers about a mission on a port, for who has the token.
    pub fn new(viewed: Viewed, port: u16, token: Token) -> io::Result<Self> {
        let (guard, threads) = (Guard::new(port, token), Threads::new(None)?);
        Ok(Self { viewed, guard, threads, newest: AtomicU64::new(0), last: Mutex::new(None) })
    }

    /// Has everything end that is being computed.
    pub fn end(&self) {
        self.newest.store(u64::MAX, Ordering::Relaxed);
    }

    /// Answers a request, whose body is to be there within a time.
    pub async fn answer(self: Arc<Self>, request: Request<Incoming>, patience: Duration) -> Answer {
        let (head, body) = request.into_parts();
        match self.guard.admits(&head) {
            Err(Closed::Forbidden) => return refused(StatusCode::FORBIDDEN),
            Err(Closed::NoJson) => return refused(StatusCode::UNSUPPORTED_MEDIA_TYPE),
            Ok(()) => {}
        }
        let path = head.uri.path();
        if head.method == Method::GET {
            return match path {
                "/" => answered(StatusCode::OK, "text/html; charset=utf-8", page()),
                "/view.js" => answered(StatusCode::OK, "text/javascript; charset=utf-8", script()),
                "/view.css" => answered(StatusCode::OK, "text/css; charset=utf-8", style()),
                _ if !self.guard.knows(&head) => refused(StatusCode::FORBIDDEN),
                "/mission" => self.computed(|all| all.mission()).await,
                _ => refused(StatusCode::NOT_FOUND),
            };
        }
        if head.method != Method::POST {
            return refused(StatusCode::METHOD_NOT_ALLOWED);
        }
        if path != "/enter" && !self.guard.knows(&head) {
            return refused(StatusCode::FORBIDDEN);
        }
        let body = match timeout(patience, read(body, BODY_MOST)).await {
            Ok(Some(body)) => body,
            Ok(None) => return refused(StatusCode::PAYLOAD_TOO_LARGE),
            Err(_) => return refused(StatusCode::REQUEST_TIMEOUT),
        };
        let Ok(object) = serde_json::from_slice::<Map<String, Value>>(&body) else {
            return refused(StatusCode::BAD_REQUEST);
        };
        if path == "/enter" {
            return self.enter(&object);
        }
        let asked = match Asked::of(&object) {
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

    fn enter(&self, object: &Map<String, Value>) -> Answer {
        let token = object.get("token").and_then(Value::as_str).unwrap_or_default();
        let Some(cookie) = self.guard.lets_in(token).and_then(|text| HeaderValue::from_str(&text).ok())
        else {
            return refused(StatusCode::FORBIDDEN);
        };
        let mut answer = answered(StatusCode::NO_CONTENT, TEXT, "");
        answer.headers_mut().insert(SET_COOKIE, cookie);
        answer
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
        let mut answer = answered(StatusCode::OK, LINES, "");
        *answer.body_mut() = Answered::Lines(lines);
        answer
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

/// An answer without more than its status.
fn refused(status: StatusCode) -> Answer {
    answered(status, TEXT, status.canonical_reason().unwrap_or_default())
}

/// An object as the answer.
fn told(status: StatusCode, object: &Value) -> Answer {
    answered(status, JSON, object.to_string())
}

fn answered(status: StatusCode, kind: &'static str, body: impl Into<Bytes>) -> Answer {
    let body: Bytes = body.into();
    let mut answer = Response::new(Answered::Whole((!body.is_empty()).then_some(body)));
    *answer.status_mut() = status;
    let headers = answer.headers_mut();
    headers.insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    answer
}
