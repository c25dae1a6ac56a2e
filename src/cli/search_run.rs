//! A search, run to its end: candidates judged side by side, kept in a checkpoint after each iteration,
//! continued from there.

use rayon::prelude::*;

use super::answer::{BadInput as _, Failure};
use super::progress::Progress;
use super::results::OutputFolder;
use samara::config::{Evaluated, Mission, SearchIdentity, checkpoint_json, load_checkpoint};
use samara::tune::CandidateSearch;

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
    /// Whether it goes on from the checkpoint.
    pub resume: bool,
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

/// Runs a search to its end. One that is resumed is first given what the checkpoint holds. `judge` gives the
/// judgement on a candidate, by its place among those asked about; `None` when there is nothing to judge it
/// by. `progress` gives the iterations made, the most there are, and how well the search goes.
pub fn run_search<S>(
    session: &SearchSession<'_>,
    search: &mut S,
    judge: impl Fn(&S, usize, &S::Candidate) -> Option<S::Judgement> + Sync,
    progress: impl Fn(&S) -> (usize, usize, String),
) -> Result<SearchRun, Failure>
where
    S: CandidateSearch + Sync,
    S::Candidate: Sync,
    S::Judgement: Evaluated + Send,
{
    let SearchSession { folder, identity, .. } = *session;
    let mut judged: Vec<S::Judgement> = if session.resume {
        load_checkpoint(&folder.path().join(session.checkpoint), identity).bad_input()?
    } else {
        Vec::new()
    };
    let mut used = 0;
    while let Some(n) = search.candidates().map(<[_]>::len).filter(|n| judged.len() - used >= *n) {
        search.update(&judged[used..used + n]);
        used += n;
    }
    let keep = |judged: &[S::Judgement]| {
        let text = checkpoint_json(identity, judged);
        folder.write_text(session.checkpoint, &text).map(|_| ())
    };
    // What is left over is of a search of more iterations: that checkpoint is the better one.
    if used > 0 && used == judged.len() {
        keep(&judged)?;
    }
    judged.truncate(used);
    let (mut evaluated, bar) = (0, Progress::new(session.verb, "evaluations", 0));
    while let Some(candidates) = search.candidates() {
        let (made, most, message) = progress(search);
        // At most: a search may come to its end before.
        bar.set_whole(evaluated + (candidates.len() * most.saturating_sub(made)) as u64);
        evaluated += candidates.len() as u64;
        bar.set_message(&message);
        let judge_one = |(place, candidate): (usize, &S::Candidate)| {
            let going = !(session.stop)();
            bar.inc(u64::from(going));
            going.then(|| judge(search, place, candidate)).flatten()
        };
        let fresh: Option<Vec<S::Judgement>> =
            candidates.par_iter().enumerate().with_max_len(1).map(judge_one).collect();
        let Some(fresh) = fresh else { break };
        search.update(&fresh);
        judged.extend(fresh);
        keep(&judged)?;
    }
    bar.finish();
    Ok(SearchRun { fresh: judged.len() - used, stopped: search.candidates().is_some() })
}
