//! The door, the files of the page, and who answers what else is asked.

use std::io;
use std::sync::Arc;

use hyper::body::Incoming;
use hyper::header::{HeaderValue, SET_COOKIE};
use hyper::{Method, Request, StatusCode};
use serde_json::{Map, Value};
use tokio::time::{Duration, timeout};

use super::body::{Answer, Answered, JSON, TEXT, answered, lines_of, page_of_a_run, read, refused};
use super::guard::{BODY_MOST, Closed, Guard, Token};
use super::mission::Desk;
use crate::live::Feed;
use crate::run::Run;
use crate::viewed::Viewed;
use samara_report::replay::{folder, live, view};

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

/// What a server shows.
#[derive(Debug)]
pub enum Shown {
    /// A mission, to be changed and flown anew.
    Mission(Viewed),
    /// A flight while it flies.
    Flight(Feed),
    /// A run's folder.
    Run(Arc<dyn Run>),
}

/// What the server knows: who may ask, and of what.
#[derive(Debug)]
pub struct Answers {
    guard: Guard,
    subject: Subject,
}

/// What is asked about.
#[derive(Debug)]
enum Subject {
    Mission(Arc<Desk>),
    Flight(Feed),
    Run(Arc<dyn Run>),
}

impl Answers {
    /// The answers about what is shown on a port, for who has the token.
    pub fn new(shown: Shown, port: u16, token: Token) -> io::Result<Self> {
        let subject = match shown {
            Shown::Mission(viewed) => Subject::Mission(Arc::new(Desk::new(viewed)?)),
            Shown::Flight(feed) => Subject::Flight(feed),
            Shown::Run(run) => Subject::Run(run),
        };
        Ok(Self { guard: Guard::new(port, token), subject })
    }

    /// The flight that is looked at, if it is one.
    pub fn flight(&self) -> Option<&Feed> {
        match &self.subject {
            Subject::Mission(_) | Subject::Run(_) => None,
            Subject::Flight(feed) => Some(feed),
        }
    }

    /// Has everything end that is being computed.
    pub fn end(&self) {
        if let Subject::Mission(desk) = &self.subject {
            desk.end();
        }
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
            return match self.file(path) {
                Some((kind, text)) => answered(StatusCode::OK, kind, text),
                None if !self.guard.knows(&head) => refused(StatusCode::FORBIDDEN),
                None => self.get(path).await,
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
        match &self.subject {
            _ if path == "/enter" => self.enter(&object),
            Subject::Mission(desk) => desk.clone().post(path, &object).await,
            Subject::Flight(_) | Subject::Run(_) => refused(StatusCode::NOT_FOUND),
        }
    }

    /// A file of the page, which holds nothing of what is shown.
    fn file(&self, path: &str) -> Option<(&'static str, String)> {
        match (&self.subject, path) {
            (Subject::Mission(_), "/") => Some((HTML, view::page())),
            (Subject::Mission(_), "/view.js") => Some((SCRIPT, view::script())),
            (Subject::Mission(_), "/view.css") => Some((STYLE, view::style())),
            (Subject::Flight(_), "/") => Some((HTML, live::page())),
            (Subject::Flight(_), "/live.js") => Some((SCRIPT, live::script())),
            (Subject::Flight(_), "/live.css") => Some((STYLE, live::style())),
            (Subject::Run(_), "/") => Some((HTML, folder::page())),
            (Subject::Run(_), "/folder.js") => Some((SCRIPT, folder::script())),
            (Subject::Run(_), "/folder.css") => Some((STYLE, folder::style())),
            _ => None,
        }
    }

    async fn get(&self, path: &str) -> Answer {
        match &self.subject {
            Subject::Mission(desk) => desk.clone().get(path).await,
            Subject::Flight(feed) if path == "/flight" => lines_of(Answered::flight(feed.reader())),
            Subject::Flight(_) => refused(StatusCode::NOT_FOUND),
            Subject::Run(run) => of_run(run.clone(), path.to_owned()).await,
        }
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
}

/// What is asked of a run, found or flown beside the thread of the sockets: pages and campaigns by their
/// places in what is told, `/page/0`, `/trial/0/16`.
async fn of_run(run: Arc<dyn Run>, path: String) -> Answer {
    let computed = tokio::task::spawn_blocking(move || of_a_run(&*run, &path));
    computed.await.unwrap_or_else(|_| refused(StatusCode::INTERNAL_SERVER_ERROR))
}

fn of_a_run(run: &dyn Run, path: &str) -> Answer {
    let told = run.told();
    let place = |text: &str| text.parse::<usize>().ok();
    match path.split('/').skip(1).collect::<Vec<_>>()[..] {
        // Numbers, texts and lists of them always serialise.
        ["run"] => answered(StatusCode::OK, JSON, serde_json::to_string(told).unwrap_or_default()),
        ["page", at] => {
            let name = place(at).and_then(|at| told.pages.get(at));
            let page = name.and_then(|name| run.page(name));
            page.map_or_else(|| refused(StatusCode::NOT_FOUND), page_of_a_run)
        }
        ["trial", at, trial] => {
            let campaign = place(at).and_then(|at| told.campaigns.get(at));
            match campaign.zip(trial.parse().ok()).map(|(campaign, trial)| run.trial(&campaign.name, trial)) {
                Some(Ok(page)) => page_of_a_run(page),
                Some(Err(why)) => answered(StatusCode::UNPROCESSABLE_ENTITY, TEXT, why),
                None => refused(StatusCode::NOT_FOUND),
            }
        }
        _ => refused(StatusCode::NOT_FOUND),
    }
}
