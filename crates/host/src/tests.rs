//! The host of studies, on jobs whose rows are known.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use super::kept::{KeptRows, RowsFile, going_on, rows};
use super::shards::{Ended, ShardFiles, Shards};
use super::{FirstStage, Host, Silent, Threads};
use samara_study::cut::Cut;
use samara_study::jobs::{Fly, HereAndNow, Jobs, Round, Stage, Stop, Stopped};

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

impl RowsFile for Memory {
    fn cut(&mut self, bytes: u64) -> io::Result<()> {
        self.0.lock().unwrap().truncate(bytes as usize);
        Ok(())
    }
}

/// The first line of files of rows.
const HEAD: &str = "# {}\n";

/// What goes on from a file of this text, and the file.
fn from(text: &str) -> (KeptRows, Memory) {
    let earlier = going_on(text, HEAD).unwrap();
    let file = Memory::default();
    file.0.lock().unwrap().extend(text[..earlier.whole() as usize].bytes());
    (KeptRows::going_on(HEAD, earlier, Box::new(file.clone())).unwrap(), file)
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
        let (kept, file) = from("");
        assert_eq!(hosted(threads, &|| false, kept, &flown).0.unwrap(), expected);
        files.push(file.text());
    }
    assert!(files.iter().all(|text| *text == files[0]) && files[0].lines().count() == 1 + expected.len());
}

/// From wherever a file ends, within a line too, the study ends in the same rows and the same file, and flies
/// no whole row again.
#[test]
fn prop_a_study_goes_on_from_every_end_of_its_file() {
    let (flown, (kept, file)) = (AtomicU64::new(0), from(""));
    let expected = hosted(2, &|| false, kept, &flown).0.unwrap();
    let text = file.text();
    for cut in (0..=text.len()).step_by(11).chain([text.len()]) {
        let there = text[..cut].matches('\n').count().saturating_sub(1);
        let (flown, (kept, file)) = (AtomicU64::new(0), from(&text[..cut]));
        assert_eq!(hosted(2, &|| false, kept, &flown).0.unwrap(), expected);
        assert_eq!(file.text(), text);
        assert_eq!(flown.into_inner(), (expected.len() - there) as u64);
    }
}

/// What was stopped has kept the rows of the first jobs without a gap.
#[test]
fn a_stopped_study_has_kept_its_first_rows() {
    for after in [0, 1, 9, 40, 60] {
        let (flown, (kept, file)) = (AtomicU64::new(0), from(""));
        let stop = || flown.load(Ordering::Relaxed) >= after;
        assert!(matches!(hosted(3, &stop, kept, &flown), (Err(Stopped), None)));
        let (text, expected) = (file.text(), study(&mut HereAndNow, &AtomicU64::new(0)).unwrap());
        let (kept, _) = from(&text);
        assert_eq!(hosted(3, &|| false, kept, &flown).0.unwrap(), expected);
    }
}

/// A full disk ends the study with the reason, whatever the threads are at.
#[test]
fn rows_that_cannot_be_kept_end_the_study() {
    let full = Memory(Arc::default(), Some(40));
    let kept = KeptRows::going_on(HEAD, going_on("", HEAD).unwrap(), Box::new(full)).unwrap();
    let (found, failure) = hosted(2, &|| false, kept, &AtomicU64::new(0));
    assert!(found.is_err() && failure.unwrap().kind() == io::ErrorKind::StorageFull);
}

/// A row of another length was kept by no run of this study: it is no row to go on from.
#[test]
fn a_row_of_other_numbers_is_refused() {
    for row in ["1.0", "0.0,5.0"] {
        let (kept, _) = from(&format!("{HEAD}0.0\n{row}\n"));
        let (found, failure) = hosted(2, &|| false, kept, &AtomicU64::new(0));
        assert!(found.is_err() && failure.unwrap().kind() == io::ErrorKind::InvalidData);
    }
}

#[test]
fn what_is_no_whole_row_ends_what_is_read() {
    assert_eq!(rows("1.0,2.5\n-0.0\ninf,NaN"), [vec![1.0, 2.5], vec![-0.0]]);
    assert_eq!(rows("1.0\n\0\0\0\n2.0\n"), [vec![1.0]]);
    assert!(rows("").is_empty());
    let whole = |text: &str| going_on(text, HEAD).unwrap().whole();
    assert_eq!([whole("# {"), whole("# {}\n1.0\n2."), whole("# {}\n# a\n1.0\n")], [0, 9, 13]);
}

/// Rows of another study are refused with what is other about it; the hash follows what has a name.
#[test]
fn rows_of_another_study_are_refused_by_what_differs() {
    let head = |seed: u64, hash: &str, trials: u64| {
        format!("# {{\"seed\":{seed},\"input_hash\":\"{hash}\",\"settings\":{{\"trials\":\"{trials}\"}}}}\n")
    };
    let refused = |found: &str| going_on(found, &head(2, "b", 9)).unwrap_err();
    assert_eq!(refused(&head(1, "a", 9)), "these rows are of another study: seed was 1, is 2");
    assert_eq!(refused(&head(2, "a", 9)), "these rows are of another study: input_hash was a, is b");
    assert_eq!(refused(&head(2, "b", 8)), "these rows are of another study: trials was 8, is 9");
    assert!(refused("# {\"study\":\"x\"}\n").ends_with("trials was nothing, is 9; study was x, is unknown"));
    assert!(refused("1,2\n").contains("found `1,2`"));
}

/// A search of so many rounds, then what hangs on where it ended.
fn search(jobs: &mut dyn Jobs, rounds: u64, flown: &AtomicU64) -> Result<Vec<f64>, Stopped> {
    let fly = |some: Range<u64>, stop: Stop<'_>| {
        flown.fetch_add(some.end - some.start, Ordering::Relaxed);
        (!stop()).then(|| some.map(|job| job as f64 + 0.5).collect())
    };
    let fly: Fly<'_, f64> = &fly;
    let mut rows = Vec::new();
    for round in 0..rounds {
        rows.extend(jobs.fly("search", Round::of(3 + round, 2), fly)?);
    }
    jobs.stage(&Stage { unit: "flights", jobs: 5, hangs_on: &format!("{} rows", rows.len()) })?;
    rows.extend(jobs.fly("flights", Round::of(5, 2), fly)?);
    Ok(rows)
}

/// From wherever its file ends, and wherever the search ended before, sooner or later, it ends in the same
/// rows and flies no row of the search again; the rows of the longer search stay.
#[test]
fn prop_a_search_goes_on_for_longer_and_ends_as_if_it_had_at_once() {
    let pool = Threads::new(Some(2)).unwrap();
    let at_once = |rounds: u64, text: &str| {
        let (flown, (kept, file)) = (AtomicU64::new(0), from(text));
        let mut host = Host::new(&pool, &|| false, &Silent, kept);
        let found = search(&mut host, rounds, &flown).unwrap();
        let Some(FirstStage::Kept(first_stage)) = host.first_stage().unwrap() else { panic!("no stage") };
        assert_eq!(Jobs::flown(&host), flown.into_inner());
        let here = Jobs::flown(&host);
        drop(host);
        (found, file.text(), first_stage as usize, here)
    };
    let whole: Vec<_> = (1..5).map(|rounds| at_once(rounds, "")).collect();
    for (before, (_, text, stage, _)) in whole.iter().enumerate() {
        for (then, (rows, ended, stage_then, _)) in whole.iter().enumerate() {
            for cut in 0..=text.len() {
                let (found, file, first_stage, flown) = at_once(then as u64 + 1, &text[..cut]);
                assert_eq!(&found, rows, "longer by {before}, then by {then}, from {cut}");
                let there = text[..cut.min(*stage)].matches('\n').count().saturating_sub(1);
                let longer = there > rows.len() - 5;
                if longer {
                    let kept = text[..cut].rfind('\n').unwrap() + 1;
                    assert_eq!((file.as_str(), first_stage), (&text[..kept], kept.min(*stage)));
                } else {
                    assert_eq!((&file, first_stage), (ended, *stage_then));
                    let again = if before == then && cut > *stage { 5 } else { 0 };
                    assert!(
                        flown <= (rows.len() - there) as u64 && flown + again >= (rows.len() - there) as u64
                    );
                }
            }
        }
    }
}

/// In shards, each stage has files of its own: another end of the search leaves those of the search.
#[test]
fn prop_shards_of_a_search_go_on_for_longer() {
    let (pool, folder) = (Threads::new(Some(2)).unwrap(), Folder::default());
    let flown = AtomicU64::new(0);
    for rounds in [2, 1, 3] {
        let expected = search(&mut HereAndNow, rounds, &AtomicU64::new(0)).unwrap();
        let found = loop {
            let mut host = Host::in_shards(&pool, &|| false, &Silent, Shards::new(&folder, HEAD, None));
            if let Ok(found) = search(&mut host, rounds, &flown) {
                // What is kept of it is what one process keeps.
                let (kept, file) = from("");
                let mut whole = Host::new(&pool, &|| false, &Silent, kept);
                search(&mut whole, rounds, &AtomicU64::new(0)).unwrap();
                let Some(FirstStage::Kept(bytes)) = whole.first_stage().unwrap() else { panic!("no stage") };
                let text = file.text()[..bytes as usize].to_owned();
                assert_eq!(host.first_stage().unwrap(), Some(FirstStage::Text(text)));
                break found;
            }
            for part in 0..2 {
                let shards = Shards::new(&folder, HEAD, Some(Cut { part, of: 2 }));
                let mut host = Host::in_shards(&pool, &|| false, &Silent, shards);
                assert!(search(&mut host, rounds, &flown).is_err() && !host.wants_so_far());
            }
        };
        assert_eq!(found, expected);
    }
    // Three rounds of a search, and three ends of it.
    assert_eq!(flown.into_inner(), 3 + 4 + 5 + 3 * 5);
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
                let (stem, parts) = (format!("{after:09}-"), (0..missing).collect());
                let expected = Ended::Missing { after, jobs, stem, of: there, parts };
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
