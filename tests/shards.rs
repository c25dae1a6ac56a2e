//! `samara assess --shard` and `samara merge` as a user meets them: the bytes of the campaign in one go
//! whatever the cuts, and nothing lost and nothing counted twice whatever goes wrong.
#![cfg(feature = "shards")]

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use samara::assess::{BLOCK_TRIALS, BlockNode, BlockSummary, Histogram, Outcome, Share, Summary};
use samara::config::Mission;
use samara::study::asked::Asked;
use samara::study::campaign::campaign_csv::write_row;
use samara::study::campaign::settings::{CampaignSettings, OWN};
use samara::study::campaign::{CampaignSummary, SHOWN, TrialRecord};
use samara::study::cut::Cut;
use samara::study::settings::Values;
use samara::study::shard::rows::study_table;
use samara::study::shard::summary::{StudyPart, SummaryRecord};
use samara::study::shard::{ShardHead, ShardWriter};

/// Flights of 5 s: the quickest mission that there is.
const QUICK: &str = "mission/x500_drop.json";
/// Trials of two whole blocks and a part of one; every third part of them is cut inside a block.
const TRIALS: &str = "530";

fn samara(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_samara"));
    command.args(args);
    command
}

fn run(args: &[&str]) -> Output {
    samara(args).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// Flies a part of a campaign of few trials.
fn fly(shard: &str, out: &Path, more: &[&str]) -> Output {
    let args = ["assess", QUICK, "--trials", "40", "--shard", shard, "--out", text(out)];
    run(&[&args[..], more].concat())
}

fn whole(shard: &str, out: &Path) -> Output {
    let output = fly(shard, out, &[]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    output
}

fn file(out: &Path, shard: u64, of: u64) -> PathBuf {
    out.join(format!("shards/{shard:05}-of-{of:05}.parquet"))
}

/// The refusal of a merge.
fn refused(out: &Path) -> String {
    let output = run(&["merge", text(out)]);
    assert_eq!(code(&output), 2, "{}", stdout(&output));
    assert!(!out.join("assess.html").exists(), "nothing is written");
    stderr(&output)
}

fn missing(out: &Path) -> String {
    let output = run(&["merge", text(out), "--missing"]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    stdout(&output)
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(|e| e.unwrap()).filter(|e| e.path().is_file());
    entries.map(|e| (e.file_name().to_str().unwrap().to_owned(), fs::read(e.path()).unwrap())).collect()
}

fn assert_same(a: &Path, b: &Path) {
    let (a, b) = (files(a), files(b));
    assert_eq!(a.keys().collect::<Vec<_>>(), b.keys().collect::<Vec<_>>());
    for (name, bytes) in &a {
        assert!(*bytes == b[name], "{name} differs");
    }
}

/// Names in the folder of parts.
fn there(out: &Path) -> Vec<String> {
    let names = fs::read_dir(out.join("shards")).unwrap();
    let mut names: Vec<String> = names.map(|e| e.unwrap().file_name().to_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

/// One, three and seven parts, with cuts inside blocks and among the trials that are shown, come to every
/// byte of the campaign in one go - also its manifest, which has the SHA-256 of each file - whatever is kept.
#[test]
fn prop_merged_shards_are_the_campaign_in_one_go() {
    let folder = tempfile::tempdir().unwrap();
    for (keep, cuts) in [("all", &[1, 3, 7][..]), ("failures", &[3]), ("summary", &[3])] {
        let campaign = ["assess", QUICK, "--trials", TRIALS, "--bound", "0.4997", "--keep", keep];
        let one = folder.path().join(keep);
        let output = run(&[&campaign[..], &["--out", text(&one)]].concat());
        assert_eq!(code(&output), 1, "some fail: {}", stderr(&output));
        for cut in cuts {
            let out = folder.path().join(format!("{keep}_{cut}"));
            for shard in (0..*cut).rev() {
                let shard = format!("{shard}/{cut}");
                let output = run(&[&campaign[..], &["--shard", &shard, "--out", text(&out)]].concat());
                assert_eq!(code(&output), 0, "{}", stderr(&output));
            }
            assert_eq!(missing(&out), "\n");
            assert!(files(&out).is_empty(), "a shard makes no figures: {:?}", files(&out).keys());
            let output = run(&["merge", text(&out)]);
            assert_eq!(code(&output), 1, "{}", stderr(&output));
            assert_same(&one, &out);
        }
    }
    let lines = |keep: &str| {
        let name = folder.path().join(keep).join("campaign_optimal.csv");
        fs::read_to_string(name).map_or(0, |text| text.lines().filter(|l| !l.starts_with(['#', 't'])).count())
    };
    let failed: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path().join("summary/assess.json")).unwrap()).unwrap();
    let failed = failed["campaigns"][0]["unsafe_trials"].as_u64().unwrap();
    assert_eq!([lines("all"), lines("failures"), lines("summary")], [530, failed as usize, 0]);
    assert!(failed > 0);
}

/// Quantiles from histograms lie within half a bin of the exact ones, as the files say.
#[test]
fn prop_quantiles_from_bins_are_within_what_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let measures = |keep: &str| {
        let out = folder.path().join(keep);
        run(&["assess", QUICK, "--trials", "200", "--keep", keep, "--out", text(&out)]);
        let json: serde_json::Value =
            serde_json::from_slice(&fs::read(out.join("assess.json")).unwrap()).unwrap();
        json["campaigns"][0]["measures"].as_array().unwrap().clone()
    };
    for (exact, binned) in measures("all").iter().zip(&measures("summary")) {
        let within = binned["quantiles_within"].as_f64().unwrap();
        assert!(exact["quantiles_within"] == 0.0 && within > 0.0);
        for key in ["p50", "p99"] {
            let apart = exact[key].as_f64().unwrap() - binned[key].as_f64().unwrap();
            assert!(apart.abs() <= within * (1.0 + 1e-9), "{exact} {binned}");
        }
    }
}

/// Whole drops by the model of PX4's law: the same bytes, lines and page.
#[test]
fn prop_merged_drops_are_the_campaign_in_one_go() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = ["assess", QUICK, "--trials", "5", "--autopilot", "px4-model"];
    let one = folder.path().join("one");
    let output = run(&[&campaign[..], &["--out", text(&one)]].concat());
    let answer = code(&output);
    assert!(answer <= 1, "{}", stderr(&output));
    let out = folder.path().join("parts");
    for shard in ["1/2", "0/2"] {
        let output = run(&[&campaign[..], &["--shard", shard, "--out", text(&out)]].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
    }
    assert_eq!(there(&out), ["00000-of-00002.parquet", "00001-of-00002.parquet"]);
    assert_eq!(code(&run(&["merge", text(&out)])), answer);
    assert_same(&one, &out);
}

/// A part that is there is not flown again, and its file is not touched; one that was cut short, or of which
/// a bit has changed, is missing and is flown again, to the same bytes.
#[test]
fn a_part_that_is_whole_is_not_flown_again() {
    let out = tempfile::tempdir().unwrap();
    let out = out.path();
    assert!(stdout(&whole("1/3", out)).contains("13 trials from 13 on: flown"));
    let path = file(out, 1, 3);
    let (bytes, made) = (fs::read(&path).unwrap(), fs::metadata(&path).unwrap().modified().unwrap());
    assert!(stdout(&whole("1/3", out)).contains("there already"));
    assert_eq!(fs::metadata(&path).unwrap().modified().unwrap(), made);
    let short = [0, 3, bytes.len() / 2, bytes.len() - 1].map(|length| bytes[..length].to_vec());
    let flipped = (1..40).step_by(3).map(|k| {
        let mut bytes = bytes.clone();
        let place = k * (bytes.len() - 1) / 39;
        bytes[place] ^= 1;
        bytes
    });
    for damaged in short.into_iter().chain(flipped) {
        fs::write(&path, &damaged).unwrap();
        assert!(refused(out).contains("fly it again"));
        assert_eq!(missing(out), "0-2\n");
        let output = whole("1/3", out);
        assert!(stderr(&output).contains("not whole, flown again") && stdout(&output).contains(": flown"));
        assert_eq!(fs::read(&path).unwrap(), bytes);
    }
    assert_eq!(there(out), ["00001-of-00003.parquet"]);
}

/// A merge that is refused leaves all results as they were.
#[test]
fn a_refused_merge_takes_no_result_away() {
    let out = tempfile::tempdir().unwrap();
    let out = out.path();
    ["0/2", "1/2"].into_iter().for_each(|shard| drop(whole(shard, out)));
    assert!(code(&run(&["merge", text(out)])) <= 1);
    let before = files(out);
    let path = file(out, 1, 2);
    let mut bytes = fs::read(&path).unwrap();
    bytes[3000] ^= 0x10;
    fs::write(&path, bytes).unwrap();
    let output = run(&["merge", text(out)]);
    assert!(code(&output) == 2 && stderr(&output).contains("bytes of the file have changed"));
    assert_eq!(files(out), before);
}

/// Gaps, overlaps and parts of other campaigns are refused by name; what is left is named as an array.
#[test]
fn what_is_not_one_campaign_is_refused() {
    let out = tempfile::tempdir().unwrap();
    let out = out.path();
    assert!(refused(out).contains("shards are expected"));
    for shard in ["0/5", "3/5"] {
        whole(shard, out);
    }
    assert!(refused(out).contains("trials 8 to 23 are in no shard"), "{}", refused(out));
    assert_eq!(missing(out), "1-2,4\n");
    for shard in ["1/5", "2/5"] {
        whole(shard, out);
    }
    assert!(refused(out).contains("trials 32 to 39 are in no shard"));
    // A campaign is cut one way.
    let output = fly("1/2", out, &[]);
    assert!(code(&output) == 2 && stderr(&output).contains("has shards of 5"), "{}", stderr(&output));
    let other = tempfile::tempdir().unwrap();
    whole("1/2", other.path());
    fs::copy(file(other.path(), 1, 2), file(out, 1, 2)).unwrap();
    let why = refused(out);
    assert!(why.contains("00001-of-00002.parquet: its trials, 20 to 39, are in"), "{why}");
    let output = run(&["merge", text(out), "--missing"]);
    assert!(code(&output) == 2 && stderr(&output).contains("found one of 2"), "{}", stderr(&output));
    fs::remove_file(file(out, 1, 2)).unwrap();
    // The same name, another campaign: not flown over, not merged.
    for (more, what) in [
        (&["--seed", "7"][..], "seed 1, expected 7"),
        (&["--gains", "x500_hover"], "hash of the inputs"),
        (&["--bound", "0.9"], "bound 1, expected 0.9"),
        (&["--keep", "summary"], "keep all, expected summary"),
        (&["--trials", "41"], "trials 40, expected 41"),
    ] {
        let before = fs::read(file(out, 3, 5)).unwrap();
        let args = ["assess", QUICK, "--shard", "3/5", "--out", text(out)];
        let trials: &[&str] = if more[0] == "--trials" { &[] } else { &["--trials", "40"] };
        let output = run(&[&args[..], trials, more].concat());
        assert!(code(&output) == 2 && stderr(&output).contains(what), "{more:?}: {}", stderr(&output));
        assert_eq!(fs::read(file(out, 3, 5)).unwrap(), before);
    }
    let other = tempfile::tempdir().unwrap();
    assert_eq!(code(&fly("4/5", other.path(), &["--seed", "7"])), 0);
    fs::copy(file(other.path(), 4, 5), file(out, 4, 5)).unwrap();
    assert!(refused(out).contains("seed 7, expected 1"), "{}", refused(out));
    fs::remove_file(file(out, 4, 5)).unwrap();
    whole("4/5", out);
    assert_eq!(missing(out), "\n");
    // A part under two names.
    fs::copy(file(out, 4, 5), out.join("shards/copy.parquet")).unwrap();
    assert!(refused(out).contains("are in"), "{}", refused(out));
    fs::remove_file(out.join("shards/copy.parquet")).unwrap();
    assert!(code(&run(&["merge", text(out)])) <= 1);
    for bad in ["5/5", "0/0", "-1/2", "1", "0/100001"] {
        assert_eq!(code(&fly(bad, out, &[])), 2, "{bad}");
    }
}

/// The ID is of what the merge compares: another trial number, seed or bound is another campaign, the folder
/// and the number of parts are not; a part of another campaign than the one asked for is not flown.
#[test]
fn a_campaign_is_known_by_its_id() {
    let described = |more: &[&str]| -> serde_json::Value {
        let output = run(&[&["assess", QUICK, "--describe"], more].concat());
        assert_eq!(code(&output), 0, "{}", stderr(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let of = described(&["--trials", "40"]);
    let mission = Mission::shipped("x500_drop").unwrap();
    for (key, expected) in [
        ("mission", mission.name.as_str()),
        ("version", env!("CARGO_PKG_VERSION")),
        ("input_hash", mission.inputs.hash.as_str()),
        ("keep", "all"),
    ] {
        assert_eq!(of[key], expected, "{key}");
    }
    assert_eq!((&of["seed"], &of["trials"], &of["autopilot"]), (&1.into(), &40.into(), &().into()));
    let id = of["campaign"].as_str().unwrap();
    assert_eq!(
        described(&["--trials", "40", "--seed", "1", "--keep", "all", "--threads", "1"])["campaign"],
        id
    );
    let others: [&[&str]; 5] = [
        &["--trials", "41"],
        &["--trials", "40", "--seed", "7"],
        &["--trials", "40", "--bound", "0.9"],
        &["--trials", "40", "--keep", "summary"],
        &["--trials", "40", "--autopilot", "px4-model"],
    ];
    let out = tempfile::tempdir().unwrap();
    for other in others.map(described) {
        let other = other["campaign"].as_str().unwrap();
        assert_ne!(other, id);
        let output = fly("0/40", out.path(), &["--campaign", other]);
        assert_eq!(code(&output), 2);
        assert!(stderr(&output).contains(id) && stderr(&output).contains(other), "{}", stderr(&output));
    }
    assert_eq!(fs::read_dir(out.path()).unwrap().count(), 0, "not even the folder of parts");
    let output = fly("39/40", out.path(), &["--campaign", id]);
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    assert_eq!(code(&fly("0/40", out.path(), &["--campaign", "x"])), 2);
}

/// Killed in the middle, flown by two at once, a disk that is full: no file, or the file; nothing else
/// remains.
#[cfg(unix)]
#[test]
fn whatever_ends_a_part_leaves_it_whole_or_not_there() {
    let out = tempfile::tempdir().unwrap();
    let out = out.path();
    let args = |trials| ["assess", QUICK, "--trials", trials, "--shard", "0/2", "--out", text(out)];
    let begun = || there(out).iter().any(|name| name.ends_with(".partial"));
    let mut child = samara(&args("100000")).stderr(Stdio::null()).spawn().unwrap();
    while !out.join("shards").exists() || !begun() {
        assert!(child.try_wait().unwrap().is_none(), "over before it was killed");
        std::thread::yield_now();
    }
    std::thread::sleep(std::time::Duration::from_millis(300));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!file(out, 0, 2).exists() && begun());
    // The first bytes are written when the part begins; what a process that was killed left is removed.
    let both: Vec<_> = (0..2).map(|_| samara(&args("40")).stdout(Stdio::piped()).spawn().unwrap()).collect();
    for child in both {
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(0));
    }
    assert_eq!(there(out), ["00000-of-00002.parquet"]);
    let bytes = fs::read(file(out, 0, 2)).unwrap();
    fs::remove_file(file(out, 0, 2)).unwrap();
    // A file that may not grow is a disk that is full.
    let full = Command::new("sh")
        .args(["-c", "ulimit -f 1; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_samara")])
        .args(args("40"))
        .output()
        .unwrap();
    assert_eq!(code(&full), 2, "{}", stderr(&full));
    assert!(
        stderr(&full).contains("cannot write") && stderr(&full).contains("00000-of-00002"),
        "{}",
        stderr(&full)
    );
    assert!(there(out).is_empty(), "{:?}", there(out));
    assert_eq!(code(&run(&args("40"))), 0);
    assert_eq!(fs::read(file(out, 0, 2)).unwrap(), bytes);
}

/// A part whose parent is killed ends by itself and leaves nothing.
#[cfg(target_os = "linux")]
#[test]
fn a_part_ends_with_its_parent() {
    use std::io::Read as _;
    let out = tempfile::tempdir().unwrap();
    let mut parent = Command::new("sh")
        .args(["-c", "\"$@\" 2> /dev/null & echo $!; wait", "sh", env!("CARGO_BIN_EXE_samara")])
        .args(["assess", QUICK, "--trials", "100000000", "--shard", "0/1", "--with-parent"])
        .args(["--out", text(out.path())])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = Vec::new();
    let mut pipe = parent.stdout.take().unwrap();
    while said.last() != Some(&b'\n') {
        let mut byte = [0];
        assert_eq!(pipe.read(&mut byte).unwrap(), 1);
        said.push(byte[0]);
    }
    let pid = String::from_utf8(said).unwrap();
    // One that nobody waits for stays as a zombie where there is no init.
    let status = Path::new("/proc").join(pid.trim()).join("status");
    let flies = || fs::read_to_string(&status).is_ok_and(|status| !status.contains("State:\tZ"));
    while !out.path().join("shards").exists() || there(out.path()).is_empty() {
        std::thread::yield_now();
    }
    parent.kill().unwrap();
    parent.wait().unwrap();
    let mut waited_ms = 0;
    while flies() {
        assert!(waited_ms < 60_000, "it flies on without its parent");
        std::thread::sleep(std::time::Duration::from_millis(20));
        waited_ms += 20;
    }
    assert!(there(out.path()).is_empty(), "{:?}", there(out.path()));
}

/// A parent that ended before its child looked is noticed by its number: here one that never was the parent.
#[cfg(unix)]
#[test]
fn a_part_whose_parent_was_gone_before_is_not_flown() {
    let out = tempfile::tempdir().unwrap();
    let args = ["assess", QUICK, "--trials", "100000000", "--shard", "0/1", "--with-parent=1"];
    let output = run(&[&args[..], &["--out", text(out.path())]].concat());
    assert_eq!(code(&output), 1, "{}", stderr(&output));
    assert!(stderr(&output).contains("stopped, not written") && there(out.path()).is_empty());
}

/// The statistics of trials `first` to `end`, each quantity of which is 0.5, with a tenth of the trials
/// spread over 500 bins: made of whole blocks, without flying any.
fn made(first: u64, end: u64) -> CampaignSummary {
    const VALUE: f64 = 0.5;
    let values = |from: u64, to: u64| vec![Some(VALUE); (to - from) as usize];
    let (from, to) = (first.next_multiple_of(BLOCK_TRIALS).min(end), end / BLOCK_TRIALS * BLOCK_TRIALS);
    let (mut nodes, mut next) = (Vec::new(), from);
    while next < to {
        let mut level = 0;
        while next.is_multiple_of(BLOCK_TRIALS << (level + 1)) && next + (BLOCK_TRIALS << (level + 1)) <= to {
            level += 1;
        }
        let count = BLOCK_TRIALS << level;
        nodes.push(BlockNode { level, summary: Summary::from_parts(count, [VALUE, 0.0, 0.0, VALUE, VALUE]) });
        next += count;
    }
    let sums =
        BlockSummary::from_parts(first, &values(first, from), &nodes, &values(to.max(from), end)).unwrap();
    let trials = end - first;
    let bins =
        (1..=500).map(|bin| (50_000 + bin, trials / 5_000)).chain([(50_000, trials - trials / 5_000 * 500)]);
    let histogram = Histogram::of(bins);
    CampaignSummary {
        passed: Share::of(trials, trials),
        measures: std::array::from_fn(|_| sums.clone()),
        histograms: std::array::from_fn(|_| histogram.clone()),
        ..CampaignSummary::default()
    }
}

/// A hundred million trials in a thousand shards of summaries: every trial is counted once, the mean is the
/// one value that there is, and the median lies in the bin that holds nine tenths.
#[test]
fn closed_form_a_thousand_summaries_of_a_hundred_million_trials() {
    let (trials, of) = (100_000_000, 1000);
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    fs::create_dir_all(out.join("shards")).unwrap();
    let mission = Mission::shipped("x500_drop").unwrap();
    let releases = mission.releases();
    let outcome = Outcome { j_tpf: 0.5, steady_after_s: Some(1.0), ..Outcome::default() };
    let mut values = Values::usual(OWN);
    values.put(OWN, "trials", &trials.to_string()).unwrap();
    let (_, values) = CampaignSettings::of_mission(&values, &mission).unwrap();
    for cut in (0..of).map(|part| Cut { part, of }) {
        let range = cut.range(trials);
        let mut summary = made(range.start, range.end);
        let shown: Vec<u64> = range.clone().take_while(|trial| *trial < SHOWN as u64).collect();
        summary.shown =
            shown.iter().map(|trial| TrialRecord::of_flight(*trial, &outcome, &mission.limits)).collect();
        let line = |trial: &u64| {
            let mut line = String::new();
            write_row(&mut line, &releases.draw(mission.seed, *trial), &outcome);
            line.trim_end().to_owned()
        };
        let shown: Vec<String> = shown.iter().map(line).collect();
        let head = ShardHead {
            asked: Asked { mission: "x500_drop".into(), ..Asked::of("own", OWN, &values, &mission) },
            mission: mission.name.clone(),
            autopilot: None,
            autopilot_version: None,
            first: range.start,
            end: range.end,
        };
        let part = |name: &str| StudyPart {
            name: name.to_owned(),
            summary: SummaryRecord::of(&summary),
            shown: shown.clone(),
        };
        let path = file(&out, cut.part, cut.of);
        let file = fs::File::options().create_new(true).read(true).write(true).open(path).unwrap();
        let writer = ShardWriter::new(file, &study_table("", &[])).unwrap();
        writer.finish(&head, &[part("optimal"), part("step")]).unwrap();
    }
    let output = samara(&["merge", text(&out), "--json"]).current_dir(folder.path()).output().unwrap();
    assert_eq!(code(&output), 0, "{}", stderr(&output));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    for campaign in json["campaigns"].as_array().unwrap() {
        assert_eq!(campaign["trials"], trials);
        assert_eq!((&campaign["mean"], &campaign["std"]), (&0.5.into(), &0.0.into()));
        let measure = &campaign["measures"][0];
        assert!((measure["p50"].as_f64().unwrap() - 0.5).abs() < 1e-9, "{measure}");
        // 90 % in the first bin, 0.02 % in each of the others: 99 % are reached after 450 of them.
        assert!((measure["p99"].as_f64().unwrap() - 0.5045).abs() < 2e-5, "{measure}");
        // None in 1e8: 0.025^(1e-8).
        let low = campaign["p_safe_low"].as_f64().unwrap();
        assert!((1.0 - low - 3.6889e-8).abs() < 1e-11, "{low}");
    }
}
