//! The files in which a search asks others about candidates, and in which their judgements come back.
//!
//! A search is its settings and the judgements that it was given. So `candidates.json` holds no candidates:
//! it holds all judgements so far and the command line that began the search, and whoever has these comes to
//! the same candidates, to the bit. The judgements on part I of N go to `judged/<so far>-<I>-of-<N>.json`.

use std::collections::BTreeMap;
use std::fs;
use std::ops::Range;
use std::path::PathBuf;

use anyhow::Context as _;

use crate::cli::answer::{BadInput as _, Failure};
use crate::cli::results::{OutputFolder, gone};
use samara::config::{
    Asked, Evaluated, SearchIdentity, candidates_json, checkpoint_json, load_asked, load_checkpoint,
};
use samara::study::cut::Cut;

/// What is asked about, in the folder of the search.
pub const CANDIDATES: &str = "candidates.json";
/// Folder of the judgements, below it.
const JUDGED: &str = "judged";

/// A part of the candidates that are asked about, to be judged by this process.
#[derive(Clone, Debug)]
pub struct Part {
    /// The file that asks.
    pub candidates: PathBuf,
    /// Number of candidates that the file asks about.
    pub asked: usize,
    /// Which part.
    pub cut: Cut,
    /// Whether it is only checked that the search would be the same here.
    pub check: bool,
}

impl Part {
    /// The places of the part's candidates. `used` of the `judged` judgements have led to `candidates`.
    pub fn places(&self, used: usize, judged: usize, candidates: usize) -> Result<Range<usize>, Failure> {
        if used != judged || candidates != self.asked {
            return Err(Failure::input(format!(
                "{}: its {judged} judgements lead to {candidates} candidates, it asks about {}",
                self.candidates.display(),
                self.asked
            )));
        }
        let places = self.cut.range(candidates as u64);
        Ok(places.start as usize..places.end as usize)
    }

    /// The file of the judgements on the part, which follow `so_far`.
    pub fn path(&self, folder: &OutputFolder, so_far: usize) -> PathBuf {
        folder.path().join(name(so_far, self.cut))
    }

    /// Whether the judgements on the part's `count` candidates are there, and whole.
    pub fn is_answered<T: Evaluated>(
        &self,
        folder: &OutputFolder,
        identity: &SearchIdentity,
        so_far: usize,
        count: usize,
    ) -> bool {
        load_checkpoint::<T>(&self.path(folder, so_far), identity).is_ok_and(|judged| judged.len() == count)
    }

    /// Writes the judgements on the part, which follow `so_far`.
    pub fn answer<T: Evaluated>(
        &self,
        folder: &OutputFolder,
        identity: &SearchIdentity,
        so_far: usize,
        judged: &[T],
    ) -> Result<(), Failure> {
        let at = folder.path().join(JUDGED);
        fs::create_dir_all(&at)
            .with_context(|| format!("cannot make the folder {}", at.display()))
            .bad_input()?;
        folder.write_safely(&name(so_far, self.cut), &checkpoint_json(identity, judged)).map(|_| ())
    }
}

/// Name of a part's judgements.
fn name(so_far: usize, cut: Cut) -> String {
    format!("{JUDGED}/{so_far:07}-{}.json", cut.name())
}

/// Which part a file's name says, and how many judgements it follows.
fn part(name: &str) -> Option<(usize, Cut)> {
    let (so_far, cut) =
        name.strip_suffix(".json")?.split_once('-').filter(|(so_far, _)| so_far.len() >= 7)?;
    Some((so_far.parse().ok()?, Cut::of_name(cut)?))
}

/// Which part a file's name says, of the judgements that follow `so_far`.
fn part_of(name: &str, so_far: usize) -> Option<Cut> {
    part(name).filter(|(follows, _)| *follows == so_far).map(|(_, cut)| cut)
}

/// The judgements on all `candidates` that follow `so_far`; `None` while one is not there.
pub fn collected<T: Evaluated>(
    folder: &OutputFolder,
    identity: &SearchIdentity,
    so_far: usize,
    candidates: usize,
) -> Result<Option<Vec<T>>, Failure> {
    let at = folder.path().join(JUDGED);
    let Ok(entries) = fs::read_dir(&at) else { return Ok(None) };
    let names: Vec<String> = entries.flatten().filter_map(|e| e.file_name().into_string().ok()).collect();
    let mut parts_of = BTreeMap::<u64, u64>::new();
    for cut in names.iter().filter_map(|name| part_of(name, so_far)) {
        *parts_of.entry(cut.of).or_default() += 1;
    }
    let whole = parts_of.into_iter().find(|(of, there)| of == there);
    let Some((of, _)) = whole else { return Ok(None) };
    let mut judged = Vec::with_capacity(candidates);
    for cut in (0..of).map(|part| Cut { part, of }) {
        let judged_part = load_checkpoint::<T>(&folder.path().join(name(so_far, cut)), identity);
        let again = || {
            let asked = folder.path().join(CANDIDATES);
            format!("to judge part {cut} again: samara evaluate {} --shard {cut}", asked.display())
        };
        judged.extend(judged_part.with_context(again).bad_input()?);
    }
    if judged.len() != candidates {
        return Err(Failure::input(format!(
            "{}: its parts of {of} after {so_far} judgements have {} more, {candidates} are expected; remove them",
            at.display(),
            judged.len()
        )));
    }
    Ok(Some(judged))
}

/// Asks about the `candidates` that follow from what was judged; the file that does.
pub fn ask<T: Evaluated>(
    folder: &OutputFolder,
    identity: &SearchIdentity,
    judged: &[T],
    candidates: usize,
) -> Result<PathBuf, Failure> {
    let words = std::env::args_os().skip(1).map(std::ffi::OsString::into_string);
    let arguments: Result<Vec<String>, _> = words.collect();
    let mut arguments = arguments
        .map_err(|word| Failure::input(format!("--ask: {} is not UTF-8", word.to_string_lossy())))?;
    // Whose end this process's is, is its own affair.
    arguments.retain(|word| word != "--with-parent" && !word.starts_with("--with-parent="));
    let here = std::env::current_dir().context("the folder that this runs in").bad_input()?;
    let asked = Asked { arguments, folder: here.to_string_lossy().into_owned(), candidates };
    folder.write_safely(CANDIDATES, &candidates_json(identity, &asked, judged))
}

/// Removes the judgements that follow `so_far`: the checkpoint has them.
pub fn forget(folder: &OutputFolder, so_far: usize) -> Result<(), Failure> {
    let at = folder.path().join(JUDGED);
    for entry in fs::read_dir(&at).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(|name| part_of(name, so_far).is_some()) {
            gone(fs::remove_file(entry.path()))
                .with_context(|| format!("cannot remove {}", entry.path().display()))
                .bad_input()?;
        }
    }
    Ok(())
}

/// Whether what a search asks about lies in a folder: a file of that name may be somebody's own.
pub fn is_asked(folder: &OutputFolder) -> bool {
    load_asked(&folder.path().join(CANDIDATES)).is_ok()
}

/// Removes what was asked and answered: the search is over. What is none of it stays.
pub fn clear(folder: &OutputFolder) -> Result<(), Failure> {
    let at = folder.path().join(JUDGED);
    let cannot = || format!("cannot tidy up {}", folder.path().display());
    if is_asked(folder) {
        gone(fs::remove_file(folder.path().join(CANDIDATES))).with_context(cannot).bad_input()?;
    }
    for entry in fs::read_dir(&at).into_iter().flatten().flatten() {
        if entry.file_name().to_str().and_then(part).is_some() {
            gone(fs::remove_file(entry.path())).with_context(cannot).bad_input()?;
        }
    }
    // Where somebody's own files are, it stays.
    let _ = fs::remove_dir(&at);
    Ok(())
}
