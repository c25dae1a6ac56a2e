//! The host of studies, on jobs whose rows are known.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use super::kept::{KeptRows, read};
use super::shards::{Ended, ShardFiles, Shards};
use super::{Host, Silent, Threads};
use samara_study::cut::Cut;
use samara_study::jobs::{Fly, HereAndNow, Jobs, Round, Stop, Stopped};

/// A file in memory, which may be full.
#[derive(Clone, Default)]
struct Memory(Arc<Mutex<Vec<u8>>>, Option<usize>);

impl Memory {
    fn text(&self) -> String {
        String::from_utf8(self.0.lock().unwrap().clone()).unwrap()
    }
}

impl Write for Memory {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut memory = self.0.lock().unwrap();
        if self.1.is_some_and(|most| memory.len() + bytes.len() > most) {
            return Err(io::ErrorKind::StorageFull.into());
        }
        memory.extend(bytes);
        Ok(bytes.len())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Two rounds, the second as long as the first says: what a study of several rounds is like.
fn study(jobs: &mut dyn Jobs, flown: &AtomicU64) -> Result<Vec<Vec<f64>>, Stopped> {
    let fly = |some: Range<u64>, stop: Stop<'_>| {
        flown.fetch_add(some.end - some.start, Ordering::Relaxed);
        (!stop()).then(|| some.map(|job| vec![(job as f64).sqrt(); (job % 3) as usize]).collect())
    };
    let fly: Fly<'_, Vec<f64>> = &fly;
    let mut rows = jobs.fly("first", Round::of(50, 4), fly)?;
    rows.extend(jobs.fly("second", Round::of(rows.len() as u64 + 7, 8), fly)?);
    Ok(rows)
}

fn hosted(
    threads: usize,
    stop: Stop<'_>,
    kept: KeptRows,
    flown: &AtomicU64,
) -> (Result<Vec<Vec<f64>>, Stopped>, Option<io::Error>) {
    let pool = Threads::new(Some(threads)).unwrap();
    let mut host = Host::new(&pool, stop, &Silent, kept);
    let found = study(&mut host, flown);
    (found, host.failure())
}

/// On any number of threads rows are those of one thread, in their order, and so is the file.
#[test]
fn prop_rows_come_in_order_on_any_number_of_threads() {
    let flown = AtomicU64::new(0);
    let expected = study(&mut HereAndNow, &flown).unwrap();
    let mut files = Vec::new();
    for threads in [1, 2, 7] {
        let file = Memory::default();
        let kept = KeptRows::going_on(Vec::new(), Box::new(file.clone()));
        assert_eq!(hosted(threads, &|| false, kept, &flown).0.unwrap(), expected);
        files.push(file.text());
    }
    assert!(files.iter().all(|text| *text == files[0]) && files[0].lines().count() == expected.len());
}

/// From wherever a file ends, within a line too, the study ends in the same rows and the same file, and flies
/// no whole row again.
#[test]
fn prop_a_study_goes_on_from_every_end_of_its_file() {
    let (flown, file) = (AtomicU64::new(0), Memory::default());
    let kept = KeptRows::going_on(Vec::new(), Box::new(file.clone()));
    let expected = hosted(2, &|| false, kept, &flown).0.unwrap();
    let text = file.text();
    for cut in (0..=text.len()).step_by(11).chain([text.len()]) {
        let (rows, whole) = read(&text[..cut]);
        assert!(whole <= cut && rows.len() == text[..whole].lines().count());
        let (left, rest) = ((expected.len() - rows.len()) as u64, Memory::default());
        let flown = AtomicU64::new(0);
        let kept = KeptRows::going_on(rows, Box::new(rest.clone()));
        assert_eq!(hosted(2, &|| false, kept, &flown).0.unwrap(), expected);
        assert_eq!(text[..whole].to_owned() + &rest.text(), text);
        assert_eq!(flown.into_inner(), left);
    }
}

/// What was stopped has kept the rows of the first jobs without a gap.
#[test]
fn a_stopped_study_has_kept_its_first_rows() {
    for after in [0, 1, 9, 40, 60] {
        let (flown, file) = (AtomicU64::new(0), Memory::default());
        let kept = KeptRows::going_on(Vec::new(), Box::new(file.clone()));
        let stop = || flown.load(Ordering::Relaxed) >= after;
        assert!(matches!(hosted(3, &stop, kept, &flown), (Err(Stopped), None)));
        let (text, expected) = (file.text(), study(&mut HereAndNow, &AtomicU64::new(0)).unwrap());
        let kept = KeptRows::going_on(read(&text).0, Box::new(Memory::default()));
        assert_eq!(hosted(3, &|| false, kept, &flown).0.unwrap(), expected);
    }
}

/// A full disk ends the study with the reason, whatever the threads are at.
#[test]
fn rows_that_cannot_be_kept_end_the_study() {
    let kept = KeptRows::going_on(Vec::new(), Box::new(Memory(Arc::default(), Some(40))));
    let (found, failure) = hosted(2, &|| false, kept, &AtomicU64::new(0));
    assert!(found.is_err() && failure.unwrap().kind() == io::ErrorKind::StorageFull);
}

/// A row of another length was kept by no run of this study: it is no row to go on from.
#[test]
fn a_row_of_other_numbers_is_refused() {
    for row in [vec![1.0], vec![0.0, 5.0], vec![]] {
        let kept = KeptRows::going_on(vec![vec![0.0], row], Box::new(Memory::default()));
        let (found, failure) = hosted(2, &|| false, kept, &AtomicU64::new(0));
        assert!(found.is_err() && failure.unwrap().kind() == io::ErrorKind::InvalidData);
    }
}

#[test]
fn what_is_no_whole_row_ends_what_is_read() {
    assert_eq!(read("1.0,2.5\n-0.0\ninf,NaN"), (vec![vec![1.0, 2.5], vec![-0.0]], 13));
    assert_eq!(read("1.0\n\0\0\0\n2.0\n"), (vec![vec![1.0]], 4));
    assert_eq!(read(""), (Vec::new(), 0));
}

/// Files of shards in memory.
type Folder = Mutex<BTreeMap<String, String>>;

/// How a study in shards ended, or why it failed.
type NotWhole = (Option<Ended>, Option<io::Error>);

/// Flies a shard, or puts all together: the rows, or how it ended.
fn in_shards(
    folder: &Folder,
    head: &str,
    cut: Option<Cut>,
    flown: &AtomicU64,
) -> Result<Vec<Vec<f64>>, NotWhole> {
    let pool = Threads::new(Some(2)).unwrap();
    let mut host = Host::in_shards(&pool, &|| false, &Silent, Shards::new(folder, head, cut));
    study(&mut host, flown).map_err(|Stopped| {
        let failure = host.failure();
        (host.ended(), failure)
    })
}

/// Any number of parts, flown in any order, each by itself, come to the rows of one thread; each job is flown
/// once, and what a part lacks is said.
#[test]
fn prop_shards_of_any_cut_are_the_study() {
    let expected = study(&mut HereAndNow, &AtomicU64::new(0)).unwrap();
    for of in [1, 2, 3, 70] {
        let (folder, flown) = (Folder::default(), AtomicU64::new(0));
        for (after, jobs) in [(0, 50), (50, 57)] {
            for part in (0..of).rev() {
                let ended = in_shards(&folder, "# a\n", None, &flown).unwrap_err().0;
                let is_first = after == 0 && part + 1 == of;
                let (there, missing) = if is_first { (None, 0) } else { (Some(of), part + 1) };
                let expected = Ended::Missing { after, jobs, of: there, parts: (0..missing).collect() };
                assert_eq!(ended, Some(expected));
                let cut = Some(Cut { part, of });
                let ended = in_shards(&folder, "# a\n", cut, &flown).unwrap_err().0;
                assert!(matches!(ended, Some(Ended::Part { flown: true, .. })));
                // Twice is once.
                if part > 0 {
                    let ended = in_shards(&folder, "# a\n", cut, &flown).unwrap_err().0;
                    assert!(matches!(ended, Some(Ended::Part { flown: false, .. })));
                }
            }
        }
        assert_eq!(in_shards(&folder, "# a\n", None, &flown).unwrap(), expected);
        assert_eq!(flown.into_inner(), expected.len() as u64);
    }
}

/// A part that is cut short, or of which a bit has changed, is flown again; one of another study and one of
/// another cut are refused by name.
#[test]
fn a_damaged_shard_is_flown_again_and_a_foreign_one_refused() {
    let (folder, flown) = (Folder::default(), AtomicU64::new(0));
    let cut = Some(Cut { part: 1, of: 2 });
    in_shards(&folder, "# a\n", cut, &flown).unwrap_err();
    let name = "000000000-00001-of-00002.rows";
    let whole = folder.lock().unwrap()[name].clone();
    for damaged in [whole.replacen("5", "6", 1), whole[..whole.len() - 3].to_owned(), String::new()] {
        folder.write(name, &damaged).unwrap();
        let (ended, failure) = in_shards(&folder, "# a\n", cut, &flown).unwrap_err();
        assert!(matches!(ended, Some(Ended::Part { flown: true, .. })) && failure.is_none());
        assert_eq!(folder.lock().unwrap()[name], whole);
    }
    let (_, failure) = in_shards(&folder, "# b\n", cut, &flown).unwrap_err();
    assert!(failure.unwrap().to_string().contains("expected `# b`, found `# a`"));
    let (_, failure) = in_shards(&folder, "# a\n", Some(Cut { part: 0, of: 3 }), &flown).unwrap_err();
    assert!(failure.unwrap().to_string().contains("there are shards of 2"));
}
