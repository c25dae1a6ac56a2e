//! A search, run to its end: candidates judged side by side, kept in a checkpoint after each iteration,
//! continued from there; here, or by others, who are asked for each iteration.
//!
//! | file | holds |
//! |---|---|
//! | `ask` | the files in which candidates are asked about, and judgements come back |
//! | `evaluate` | `samara evaluate`: judges what is asked about |

mod ask;
pub mod evaluate;

use std::ops::{ControlFlow, Range};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;

use super::answer::{Answer, BadInput as _, Failure};
use super::args::ParentArgs;
use super::progress::ProgressLine;
use super::results::{OutputFolder, place_of};
use super::system;
use super::terminal::{print, print_err};
use ask::Part;
use samara::config::{Evaluated, Mission, SearchIdentity, checkpoint_json, load_checkpoint};
use samara::host::Threads;
use samara::tune::CandidateSearch;

/// What can be typed of any search: how it goes on, and who judges.
#[derive(Args, Debug, Default)]
pub struct SearchArgs {
    /// Go on from the checkpoint in the folder of --out.
    #[arg(long)]
    pub resume: bool,
    /// Have others judge the candidates (`samara evaluate`), step by step: exit code 4 while any are left.
    ///
    /// Goes on from the checkpoint in the folder of --out and from the judgements that have come, writes
    /// candidates.json and ends; once the search is over, it ends as it does otherwise. docs/clusters.md.
    #[arg(long, requires = "out", hide_short_help = true)]
    pub ask: bool,
    /// Whose end is this process's end.
    #[command(flatten)]
    pub parent: ParentArgs,
    /// What `samara evaluate` is to judge, instead of the search.
    #[arg(skip)]
    pub part: Option<Part>,
}

impl SearchArgs {
    /// Whether this process searches and judges, from the beginning to the end.
    pub fn is_whole(&self) -> bool {
        !self.ask && self.part.is_none()
    }

    /// The folder of the search, whose checkpoint has this name. Parts are judged by many at once, each of
    /// which writes a file of its own there.
    pub fn folder(
        &self,
        verb: &str,
        checkpoint: &str,
        (out, mission_name): (Option<&Path>, &str),
    ) -> Result<OutputFolder, Failure> {
        if self.part.is_some() {
            return OutputFolder::plain(&place_of(out, mission_name));
        }
        let folder = OutputFolder::create(verb, out, mission_name)?;
        if self.resume || (self.ask && folder.path().join(checkpoint).exists()) {
            folder.resume([checkpoint.to_owned()]);
        }
        if self.ask {
            folder.take_over(ask::is_asked(&folder).then(|| ask::CANDIDATES.to_owned()));
        }
        Ok(folder)
    }

    /// As [`system::interrupt_flag`]; also raised when the process ends whose end is this one's.
    pub fn interrupt_flag(&self) -> Result<Arc<AtomicBool>, Failure> {
        let flag = system::interrupt_flag()?;
        self.parent.watch(&flag)?;
        Ok(flag)
    }
}

/// How a search is run, whatever it searches.
pub struct SearchSession<'a> {
    /// Verb of the search, for the progress shown.
    pub verb: &'static str,
    /// Where the checkpoint is kept.
    pub folder: &'a OutputFolder,
    /// Name of the checkpoint's file.
    pub checkpoint: &'static str,
    /// Everything that the search depends on.
    pub identity: &'a SearchIdentity,
    /// How it goes on, and who judges.
    pub how: &'a SearchArgs,
    /// Threads that judge.
    pub threads: &'a Threads,
    /// Whether to stop now, asked between candidates.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

/// What a search came to, besides its candidates.
#[derive(Clone, Copy, Debug)]
pub struct SearchRun {
    /// Candidates that were judged now, not read from a checkpoint.
    pub fresh: usize,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

/// What every search depends on: a checkpoint of other inputs is refused.
pub fn identity_of(mission: &Mission) -> Vec<(&'static str, String)> {
    vec![
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("mission", mission.name.clone()),
        ("inputs_sha256", mission.hash_without_gains()),
        ("seed", mission.seed.to_string()),
    ]
}

/// Runs a search to its end, or, where others judge, to what they are to judge next; breaks where nothing
/// more is to be done now. A search that is resumed is first given what the checkpoint holds. `judge` gives
/// the judgement on a candidate, by its place among those asked about; `None` when there is nothing to judge
/// it by. `progress` gives the iterations made, the most there are, and how well the search goes.
pub fn run_search<S>(
    session: &SearchSession<'_>,
    search: &mut S,
    judge: impl Fn(&S, usize, &S::Candidate) -> Option<S::Judgement> + Sync,
    progress: impl Fn(&S) -> (usize, usize, String),
) -> Result<ControlFlow<Answer, SearchRun>, Failure>
where
    S: CandidateSearch + Sync,
    S::Candidate: Sync,
    S::Judgement: Evaluated + Send,
{
    let mut judged = session.earlier()?;
    let mut used = 0;
    while let Some(n) = search.candidates().map(<[_]>::len).filter(|n| judged.len() - used >= *n) {
        search.update(&judged[used..used + n]);
        used += n;
    }
    let judge_some = |search: &S, bar: &ProgressLine, places: Range<usize>| {
        let judge_one = |(place, candidate): (usize, &S::Candidate)| {
            let going = !(session.stop)();
            bar.inc(u64::from(going));
            going.then(|| judge(search, place, candidate)).flatten()
        };
        let candidates = search.candidates().unwrap_or_default().get(places.clone()).unwrap_or_default();
        let placed: Vec<_> = (places.start..).zip(candidates).collect();
        let judged = session.threads.each(&placed, |placed| judge_one(*placed));
        judged.into_iter().collect::<Option<Vec<S::Judgement>>>()
    };
    if let Some(part) = &session.how.part {
        let candidates = search.candidates().map_or(0, <[_]>::len);
        let places = part.places(used, judged.len(), candidates)?;
        let answer = session.judge_part(part, used, places, |bar, places| judge_some(search, bar, places))?;
        return Ok(ControlFlow::Break(answer));
    }
    // What is left over is of a search of more iterations: that checkpoint is the better one.
    if used > 0 && used == judged.len() {
        session.keep(&judged)?;
    }
    judged.truncate(used);
    let (mut evaluated, bar) = (0, ProgressLine::new(session.verb, "evaluations", 0));
    while let Some(candidates) = search.candidates() {
        let (so_far, places) = (judged.len(), 0..candidates.len());
        let fresh = if session.how.ask {
            let come = session.come_or_ask(&judged, places.len())?;
            if come.is_none() {
                return Ok(ControlFlow::Break(Answer::Asks));
            }
            come
        } else {
            let (made, most, message) = progress(search);
            // At most: a search may come to its end before.
            bar.set_whole(evaluated + (places.len() * most.saturating_sub(made)) as u64);
            evaluated += places.len() as u64;
            bar.set_message(&message);
            judge_some(search, &bar, places)
        };
        let Some(fresh) = fresh else { break };
        search.update(&fresh);
        judged.extend(fresh);
        session.keep(&judged)?;
        if session.how.ask {
            ask::forget(session.folder, so_far)?;
        }
    }
    bar.finish();
    if session.how.ask {
        ask::clear(session.folder)?;
    }
    Ok(ControlFlow::Continue(SearchRun {
        fresh: judged.len() - used,
        stopped: search.candidates().is_some(),
    }))
}

impl SearchSession<'_> {
    /// The judgements that the search begins with.
    fn earlier<T: Evaluated>(&self) -> Result<Vec<T>, Failure> {
        let path = self.folder.path().join(self.checkpoint);
        match &self.how.part {
            Some(part) => load_checkpoint(&part.candidates, self.identity).bad_input(),
            None if self.how.resume || (self.how.ask && path.exists()) => {
                load_checkpoint(&path, self.identity).bad_input()
            }
            None => Ok(Vec::new()),
        }
    }

    /// Judges the candidates of a part, unless they are judged or it is only to be checked; no where it is
    /// stopped: half a part is of no use to anybody.
    fn judge_part<T: Evaluated>(
        &self,
        part: &Part,
        so_far: usize,
        places: Range<usize>,
        judge: impl FnOnce(&ProgressLine, Range<usize>) -> Option<Vec<T>>,
    ) -> Result<Answer, Failure> {
        let count = counted(places.len());
        if part.check {
            print(&format!("the search is the same here: {count}\n"))?;
            return Ok(Answer::Yes);
        }
        let path = part.path(self.folder, so_far);
        if part.is_answered::<T>(self.folder, self.identity, so_far, places.len()) {
            print(&format!("part {}, {count}: there already, {}\n", part.cut, path.display()))?;
            return Ok(Answer::Yes);
        }
        let bar = ProgressLine::new("evaluate", "evaluations", places.len() as u64);
        let fresh = judge(&bar, places);
        bar.finish();
        let Some(fresh) = fresh else { return Ok(Answer::No) };
        part.answer(self.folder, self.identity, so_far, &fresh)?;
        print(&format!("part {}, {count}: judged, {}\n", part.cut, path.display()))?;
        Ok(Answer::Yes)
    }

    /// The judgements of others on the `candidates` that follow from what was judged; `None` while some are
    /// missing, for which they are asked.
    fn come_or_ask<T: Evaluated>(&self, judged: &[T], candidates: usize) -> Result<Option<Vec<T>>, Failure> {
        let come = ask::collected(self.folder, self.identity, judged.len(), candidates)?;
        if come.is_none() {
            let path = ask::ask(self.folder, self.identity, judged, candidates)?;
            let path = path.display();
            print_err(&format!(
                "samara {}: to be judged: {}, samara evaluate {path}\n",
                self.verb,
                counted(candidates)
            ));
        }
        Ok(come)
    }

    fn keep<T: Evaluated>(&self, judged: &[T]) -> Result<(), Failure> {
        let text = checkpoint_json(self.identity, judged);
        self.folder.write_safely(self.checkpoint, &text).map(|_| ())
    }
}

/// So many candidates, in words.
fn counted(candidates: usize) -> String {
    format!("{candidates} candidate{}", if candidates == 1 { "" } else { "s" })
}
