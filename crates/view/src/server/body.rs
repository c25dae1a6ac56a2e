//! Answers and their bodies, and bodies that come.

use std::convert::Infallible;
use std::future::poll_fn;
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use hyper::body::{Body, Bytes, Frame, Incoming, SizeHint};
use hyper::header::{CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::{Response, StatusCode};
use serde_json::Value;
use tokio::sync::mpsc::UnboundedReceiver;
use tokio::time::{Duration, Interval, MissedTickBehavior, interval};

use super::guard::HEADERS;
use crate::live::Reader;

pub const JSON: &str = "application/json";
const LINES: &str = "application/x-ndjson";
pub const TEXT: &str = "text/plain; charset=utf-8";

/// So often those who look on get what is new of a flight.
const LIVE_EVERY: Duration = Duration::from_millis(33);

pub type Answer = Response<Answered>;

/// The body of an answer.
pub enum Answered {
    /// All of it.
    Whole(Option<Bytes>),
    /// Lines, as they come.
    Lines(UnboundedReceiver<String>),
    /// What is new of a flight, as long as it flies: looked for when there is room for it on the way to the
    /// browser, and every now and then.
    Flight(Reader, Interval),
}

impl Answered {
    /// A flight as it flies.
    pub fn flight(reader: Reader) -> Self {
        let mut ticks = interval(LIVE_EVERY);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        Self::Flight(reader, ticks)
    }
}

/// What is new of a flight, once there is something.
fn poll_flight(reader: &mut Reader, ticks: &mut Interval, context: &mut Context<'_>) -> Poll<Option<Bytes>> {
    while !reader.has_ended() {
        ready!(ticks.poll_tick(context));
        let lines = reader.take();
        if !lines.is_empty() {
            return Poll::Ready(Some(Bytes::from(lines)));
        }
    }
    Poll::Ready(None)
}

impl Body for Answered {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        let next = match self.get_mut() {
            Self::Whole(bytes) => Poll::Ready(bytes.take()),
            Self::Flight(reader, ticks) => poll_flight(reader, ticks, context),
            Self::Lines(lines) => lines.poll_recv(context).map(|line| Some(Bytes::from(line? + "\n"))),
        };
        next.map(|bytes| bytes.map(|bytes| Ok(Frame::data(bytes))))
    }

    fn is_end_stream(&self) -> bool {
        matches!(self, Self::Whole(None))
    }

    fn size_hint(&self) -> SizeHint {
        match self {
            Self::Whole(bytes) => SizeHint::with_exact(bytes.as_ref().map_or(0, Bytes::len) as u64),
            Self::Lines(_) | Self::Flight(..) => SizeHint::default(),
        }
    }
}

/// A body of at most so many bytes; `None`: it is longer, or broke off.
pub async fn read(mut body: Incoming, most: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    if body.size_hint().lower() > most as u64 {
        return None;
    }
    while let Some(frame) = poll_fn(|context| Pin::new(&mut body).poll_frame(context)).await {
        // Trailers are nothing here.
        let Ok(data) = frame.ok()?.into_data() else { continue };
        bytes.extend_from_slice(&data);
        if bytes.len() > most {
            return None;
        }
    }
    Some(bytes)
}

/// An answer without more than its status.
pub fn refused(status: StatusCode) -> Answer {
    answered(status, TEXT, status.canonical_reason().unwrap_or_default())
}

/// An object as the answer.
pub fn told(status: StatusCode, object: &Value) -> Answer {
    answered(status, JSON, object.to_string())
}

pub fn answered(status: StatusCode, kind: &'static str, body: impl Into<Bytes>) -> Answer {
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

/// Lines as the answer, which come as they are there.
pub fn lines_of(lines: Answered) -> Answer {
    let mut answer = answered(StatusCode::OK, LINES, "");
    *answer.body_mut() = lines;
    answer
}

/// What a page of a run may do: run its own script and style and nothing else, apart from this server's.
const OF_A_RUN: &str = "sandbox allow-scripts allow-downloads allow-popups; default-src 'none'; \
    script-src 'unsafe-inline' blob:; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; \
    worker-src blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// A page that a run has written, which stands alone.
pub fn page_of_a_run(page: String) -> Answer {
    let mut answer = answered(StatusCode::OK, "text/html; charset=utf-8", page);
    answer.headers_mut().insert(CONTENT_SECURITY_POLICY, HeaderValue::from_static(OF_A_RUN));
    answer
}
