//! A flight while it flies: what its own thread hands over, and what those get who look on.
//!
//! The thread that flies has the [`Source`]. It never waits: what is kept for others is behind a lock that it
//! only tries, and what it cannot hand over at once goes with what comes next. Nobody is woken by it; each
//! [`Reader`] comes by itself, as often as it can take something. So whoever looks on, and does not read,
//! changes nothing of the flight.
//!
//! Rows - an instant of the flight each - are kept for [`ROWS_MOST`], events for [`EVENTS_MOST`]: a reader
//! that comes late or is slow gets all that is kept, and is told how many it has missed.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};

use serde_json::{Value, json};

/// Most rows that are kept: at 30 a second a quarter of an hour, the longest flight of a simulator.
pub const ROWS_MOST: usize = 30_000;
/// Most events that are kept.
pub const EVENTS_MOST: usize = 4_000;
/// Most rows that a reader gets at a time.
const ROWS_AT_A_TIME: usize = 1_000;
/// Most that waits to be handed over. A reader copies what it takes and is gone: far less waits ever.
const WAITING_MOST: usize = 10_000;

/// The numbers of an instant, in the order that the flight's description has.
type Row = Arc<[f64]>;

/// The newest of a kind, in their order, and how many there were in all.
#[derive(Debug)]
struct Newest<T> {
    all: VecDeque<T>,
    most: usize,
    /// How many there were before the first that is kept.
    gone: u64,
}

impl<T: Clone> Newest<T> {
    fn new(most: usize) -> Self {
        Self { all: VecDeque::new(), most, gone: 0 }
    }

    fn push(&mut self, one: T) {
        if self.all.len() == self.most {
            self.all.pop_front();
            self.gone += 1;
        }
        self.all.push_back(one);
    }

    /// What follows the first `next`, so many at most, and how many of those are not kept any more; `next` is
    /// then behind them.
    fn after(&self, next: &mut u64, most: usize) -> (Vec<T>, u64) {
        let missed = self.gone.saturating_sub(*next);
        let from = (*next + missed).saturating_sub(self.gone) as usize;
        let some: Vec<T> = self.all.iter().skip(from).take(most).cloned().collect();
        *next += missed + some.len() as u64;
        (some, missed)
    }
}

/// What is kept of a flight.
#[derive(Debug)]
struct Kept {
    /// How many flights have begun.
    flights: u64,
    /// What this one is, as an object.
    about: Arc<Value>,
    rows: Newest<Row>,
    /// With the number of the flight that each is of.
    events: Newest<(u64, Arc<Value>)>,
    /// What is known now, as an object, and how often it has changed.
    state: (u64, Arc<Value>),
    /// How it has ended, as an object.
    end: Option<Arc<Value>>,
    readers: usize,
}

/// Something that the flight's thread hands over.
#[derive(Debug)]
enum Entry {
    Flight(Value),
    Row(Row),
    Event(Value),
    State(Value),
    End(Value),
}

impl Kept {
    fn take(&mut self, entry: Entry) {
        match entry {
            Entry::Flight(about) => {
                self.flights += 1;
                self.about = Arc::new(about);
                self.rows = Newest::new(ROWS_MOST);
            }
            Entry::Row(row) => self.rows.push(row),
            Entry::Event(event) => self.events.push((self.flights, Arc::new(event))),
            Entry::State(state) => self.state = (self.state.0 + 1, Arc::new(state)),
            Entry::End(end) => self.end = Some(Arc::new(end)),
        }
    }
}

/// What is kept, for readers.
#[derive(Clone, Debug)]
pub struct Feed(Arc<Mutex<Kept>>);

/// The flight's own end, which never waits.
#[derive(Debug)]
pub struct Source {
    feed: Feed,
    /// What could not be handed over yet.
    waiting: VecDeque<Entry>,
}

/// A flight that nobody has begun, and what readers get of it.
pub fn feed() -> (Source, Feed) {
    let kept = Kept {
        flights: 0,
        about: Arc::default(),
        rows: Newest::new(ROWS_MOST),
        events: Newest::new(EVENTS_MOST),
        state: (0, Arc::default()),
        end: None,
        readers: 0,
    };
    let feed = Feed(Arc::new(Mutex::new(kept)));
    (Source { feed: feed.clone(), waiting: VecDeque::new() }, feed)
}

impl Source {
    /// A flight begins, which is this: its rows follow, and those of an earlier one are no more.
    pub fn flight(&mut self, about: Value) {
        self.hand_over(Entry::Flight(about));
    }

    /// An instant of the flight.
    pub fn row(&mut self, numbers: &[f64]) {
        self.hand_over(Entry::Row(numbers.into()));
    }

    /// Something has happened.
    pub fn event(&mut self, event: Value) {
        self.hand_over(Entry::Event(event));
    }

    /// What is known now, in place of what was.
    pub fn state(&mut self, state: Value) {
        self.hand_over(Entry::State(state));
    }

    /// The flight is over: nothing follows.
    pub fn end(mut self, end: Value) {
        self.waiting.push_back(Entry::End(end));
    }

    /// Hands over what waits, and this, unless a reader is at it: then both wait for what comes next.
    fn hand_over(&mut self, entry: Entry) {
        let Self { feed, waiting } = self;
        waiting.push_back(entry);
        let mut kept = match feed.0.try_lock() {
            Ok(kept) => kept,
            Err(TryLockError::Poisoned(kept)) => kept.into_inner(),
            Err(TryLockError::WouldBlock) => return bound(waiting),
        };
        waiting.drain(..).for_each(|entry| kept.take(entry));
    }
}

/// Lets the oldest row go where too much waits.
fn bound(waiting: &mut VecDeque<Entry>) {
    if waiting.len() > WAITING_MOST {
        let oldest = waiting.iter().position(|entry| matches!(entry, Entry::Row(_)));
        waiting.remove(oldest.unwrap_or(0));
    }
}

/// A flight that ends without a word has ended, too. It has nothing to be late for any more, and waits.
impl Drop for Source {
    fn drop(&mut self) {
        let mut kept = self.feed.kept();
        self.waiting.drain(..).for_each(|entry| kept.take(entry));
        kept.end.get_or_insert_with(|| Arc::new(json!({})));
    }
}

impl Feed {
    /// A reader that has had nothing yet.
    pub fn reader(&self) -> Reader {
        self.kept().readers += 1;
        Reader { feed: self.clone(), flights: 0, row: 0, event: 0, state: 0, has_ended: false }
    }

    /// Whether the flight is over.
    pub fn has_ended(&self) -> bool {
        self.kept().end.is_some()
    }

    /// How many readers there are.
    pub fn readers(&self) -> usize {
        self.kept().readers
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Somebody who looks on.
#[derive(Debug)]
pub struct Reader {
    feed: Feed,
    flights: u64,
    row: u64,
    event: u64,
    state: u64,
    has_ended: bool,
}

impl Reader {
    /// What is new since the last call, an object a line; nothing where nothing is new.
    ///
    /// An object has one of `flight` (one has begun, which is this; its `number` beside it), `rows` (lists of
    /// numbers), `event` (beside it the number of the flight that it is `of`), `state`, `end`, and `missed`:
    /// how many rows and events were not kept for this reader.
    pub fn take(&mut self) -> String {
        let begun;
        let (rows, missed_rows, events, missed_events, state, end);
        {
            let kept = self.feed.kept();
            begun = (self.flights != kept.flights).then(|| kept.about.clone());
            if begun.is_some() {
                (self.flights, self.row) = (kept.flights, 0);
            }
            (rows, missed_rows) = kept.rows.after(&mut self.row, ROWS_AT_A_TIME);
            (events, missed_events) = kept.events.after(&mut self.event, usize::MAX);
            let (changes, newest) = &kept.state;
            state = (self.state != *changes).then(|| newest.clone());
            self.state = *changes;
            // What was flown before comes before.
            let has_all = self.row == kept.rows.gone + kept.rows.all.len() as u64;
            end = kept.end.clone().filter(|_| has_all && !self.has_ended);
        }
        let mut lines = Vec::new();
        lines.extend(begun.map(|about| json!({ "number": self.flights, "flight": *about }).to_string()));
        if missed_rows + missed_events > 0 {
            lines.push(json!({ "missed": { "rows": missed_rows, "events": missed_events } }).to_string());
        }
        if !rows.is_empty() {
            // Lists of numbers always serialise; what is not finite is null.
            let rows = serde_json::to_string(&rows.iter().map(|row| &**row).collect::<Vec<_>>());
            lines.push(format!("{{\"rows\":{}}}", rows.unwrap_or_default()));
        }
        lines.extend(events.iter().map(|(of, event)| json!({ "of": of, "event": **event }).to_string()));
        lines.extend(state.map(|state| json!({ "state": *state }).to_string()));
        if let Some(end) = end {
            self.has_ended = true;
            lines.push(json!({ "end": *end }).to_string());
        }
        lines.iter().map(|line| format!("{line}\n")).collect()
    }

    /// Whether it has had all that there is, to the end.
    pub fn has_ended(&self) -> bool {
        self.has_ended
    }
}

impl Drop for Reader {
    fn drop(&mut self) {
        self.feed.kept().readers -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(reader: &mut Reader) -> Vec<Value> {
        reader.take().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    /// All lines until nothing is new, those of one key.
    fn all(reader: &mut Reader, key: &str) -> Vec<Value> {
        let each = std::iter::from_fn(|| Some(lines(reader)).filter(|lines| !lines.is_empty()));
        each.flatten().filter_map(|line| line.get(key).cloned()).collect()
    }

    /// A reader that has slept gets what is kept, in order, all events, and is told what it has missed.
    #[test]
    fn a_slow_reader_misses_instants_and_no_event() {
        let (mut source, feed) = feed();
        source.flight(json!({ "mission": "x" }));
        let (mut quick, mut slow) = (feed.reader(), feed.reader());
        assert_eq!(lines(&mut slow), [json!({ "number": 1, "flight": { "mission": "x" } })]);
        for i in 0..ROWS_MOST + 10 {
            source.row(&[i as f64, f64::NAN]);
            if i % 100 == 0 {
                source.event(json!(i));
                quick.take();
            }
        }
        let got = lines(&mut slow);
        assert_eq!(got[0], json!({ "missed": { "rows": 10, "events": 0 } }));
        assert_eq!((&got[1]["rows"][0], got.len()), (&json!([10.0, null]), 2 + ROWS_MOST / 100 + 1));
        let rows: Vec<Value> =
            all(&mut slow, "rows").into_iter().flat_map(|rows| rows.as_array().cloned()).flatten().collect();
        assert_eq!(rows.len(), ROWS_MOST - ROWS_AT_A_TIME);
        assert_eq!(rows.last().unwrap()[0], (ROWS_MOST + 9) as f64);
        assert!(all(&mut quick, "missed").is_empty());
        for i in 0..EVENTS_MOST + 1 {
            source.event(json!(i));
        }
        assert_eq!(lines(&mut slow)[0], json!({ "missed": { "rows": 0, "events": 1 } }));
    }

    /// While a reader holds what is kept, the flight goes on - one that waited would wait here for ever - and
    /// nothing of it is lost.
    #[test]
    fn the_flight_waits_for_no_reader() {
        let (mut source, feed) = feed();
        source.flight(json!({}));
        let held = feed.kept();
        (0..50).for_each(|i| source.row(&[f64::from(i)]));
        source.event(json!("while it was held"));
        drop(held);
        let mut reader = feed.reader();
        assert_eq!(all(&mut reader, "rows"), [] as [Value; 0]);
        source.row(&[50.0]);
        let got = lines(&mut reader);
        assert_eq!(got[0]["rows"].as_array().unwrap().len(), 51);
        assert_eq!(got[1], json!({ "of": 1, "event": "while it was held" }));

        let held = feed.kept();
        source.event(json!("kept"));
        (0..2 * WAITING_MOST).for_each(|i| source.row(&[i as f64]));
        drop(held);
        source.row(&[-1.0]);
        let got = lines(&mut reader);
        assert_eq!((&got[1], got.len()), (&json!({ "of": 1, "event": "kept" }), 2), "rows go first");
    }

    /// A flight that begins anew has rows of its own; its end comes once and last, also without a word.
    #[test]
    fn a_flight_that_begins_anew_and_its_end() {
        let (mut source, feed) = feed();
        source.flight(json!("first"));
        source.event(json!("of the first"));
        source.row(&[1.0]);
        source.flight(json!("second"));
        source.event(json!("of the second"));
        source.state(json!(["a"]));
        source.state(json!(["b"]));
        source.row(&[2.0]);
        let mut reader = feed.reader();
        assert_eq!((feed.readers(), feed.has_ended()), (1, false));
        source.end(json!({ "text": "over" }));
        assert_eq!(
            lines(&mut reader),
            [
                json!({ "number": 2, "flight": "second" }),
                json!({ "rows": [[2.0]] }),
                json!({ "of": 1, "event": "of the first" }),
                json!({ "of": 2, "event": "of the second" }),
                json!({ "state": ["b"] }),
                json!({ "end": { "text": "over" } }),
            ]
        );
        assert_eq!((lines(&mut reader), reader.has_ended()), (vec![], true));
        drop(reader);
        assert_eq!((feed.readers(), feed.has_ended()), (0, true));

        let (mut source, feed) = super::feed();
        source.row(&[0.0]);
        drop(source);
        assert_eq!(all(&mut feed.reader(), "end"), [json!({})]);
    }
}
