//! Cards of evidence that is made up: what the verdict rests on, and what it says.

use std::collections::BTreeMap;

use super::decision::Decision;
use super::finding::Finding;
use super::manifest::{Kind, RunManifest};
use super::page::page;
use super::sections::{probabilities, worst};
use super::{Card, Evidence};
use crate::campaign::json::{AssessObject, CampaignObject, TrialObject};
use crate::designing::report::{DesignObject, FreshNumbers, FreshObject};
use crate::envelope::report::{
    AxisObject, EdgeObject, EnvelopeObject, EnvelopeReach, LimitObject, PairObject, ReachEnd,
};
use crate::rare::report::{MostLikely, RareObject};
use samara_core::assess::envelope::{AxisRange, EnvelopeAxis};
use samara_core::assess::outcome::J_TPF;
use samara_core::assess::{ChosenAmong, Outcome};
use samara_mission::{Effect, Estimated, Mission, Origin, OriginKind};
use samara_report::json::DropObject;
use samara_report::outcome::OutcomeObject;

fn mission(wind_sigma_m_s: f64) -> Mission {
    let mut mission = Mission::shipped("x500_drop").unwrap().with_effects(&[Effect::RotorInflow]);
    mission.study.monte_carlo.wind_sigma_m_s = wind_sigma_m_s;
    mission.estimated =
        Estimated { vehicle: Some(Vec::new()), mission: Some(Vec::new()), ..Estimated::default() };
    mission
}

fn card<'a>(mission: &'a Mission, evidence: &[Evidence], accepted: Option<f64>) -> Card<'a> {
    Card {
        mission,
        mission_word: "x500_drop".to_owned(),
        inputs: Vec::new(),
        evidence: evidence.to_vec(),
        accepted,
        accepts_estimates: true,
        among: ChosenAmong::ONE,
        chosen: Vec::new(),
        command: "samara card x500_drop".to_owned(),
    }
}

/// A piece of evidence of a run with these choices.
fn piece(kind: Kind, choices: &[(&str, &str)], found: Finding) -> Evidence {
    let words = |pairs: &[(&str, &str)]| -> BTreeMap<String, String> {
        pairs.iter().map(|(name, value)| ((*name).to_owned(), (*value).to_owned())).collect()
    };
    let by = match kind {
        Kind::DropCampaign => words(&[("autopilot", "reference")]),
        _ => BTreeMap::new(),
    };
    let run = RunManifest {
        verb: String::new(),
        version: String::new(),
        mission: String::new(),
        vehicle: String::new(),
        gains: String::new(),
        seed: 1,
        input_hash: String::new(),
        choices: words(choices),
        circumstances: by,
        files: BTreeMap::new(),
    };
    Evidence {
        kind,
        file: "out/results.json".to_owned(),
        link: "results.json".to_owned(),
        sha256: None,
        run: Some(run),
        found: Ok(found),
        command: None,
    }
}

fn drop(choices: &[(&str, &str)]) -> Evidence {
    let found = DropObject {
        autopilot: Some("reference".to_owned()),
        safe: true,
        outcome: OutcomeObject(Outcome { j_tpf: 0.4, ..Outcome::lost() }),
        ..DropObject::default()
    };
    piece(Kind::Drop, choices, Finding::Drop(found))
}

/// Results of a campaign, of which these trials are the worst.
fn assessed(trials: u64, unsafe_trials: u64, max: f64, worst: Vec<TrialObject>) -> Finding {
    let campaign = CampaignObject { trials, unsafe_trials, max: Some(max), worst, ..Default::default() };
    Finding::Campaign(AssessObject {
        flown_by: "the cascade".to_owned(),
        bound: 1.0,
        plan_j_tpf: 0.4,
        campaigns: vec![campaign],
        ..AssessObject::default()
    })
}

fn campaign(kind: Kind, trials: u64, failed: u64, choices: &[(&str, &str)]) -> Evidence {
    piece(kind, choices, assessed(trials, failed, 0.5, Vec::new()))
}

fn envelope(pairs: &[[EnvelopeAxis; 2]], confirmed: bool, choices: &[(&str, &str)]) -> Evidence {
    let confirmed = confirmed.then_some([1.0, 1.0]);
    let edge = EdgeObject { safe: [1.0, 1.0], confirmed, ..EdgeObject::default() };
    let pair = |axes: &[EnvelopeAxis; 2]| {
        let edges = vec![edge.clone(); 8];
        let limit = LimitObject { limit: 1.0, nominal_is_safe: true, edges, ..LimitObject::default() };
        PairObject { axes: axes.map(|axis| axis.name().to_owned()), limits: vec![limit] }
    };
    let range = AxisRange { low: -2.0, nominal: 0.0, high: 2.0 };
    let found = EnvelopeObject {
        probability: 0.99,
        confidence: 0.95,
        fresh_flights: 459,
        axes: EnvelopeAxis::ALL.map(|axis| AxisObject::of(axis, &range)).into(),
        pairs: pairs.iter().map(pair).collect(),
        ..EnvelopeObject::default()
    };
    piece(Kind::Envelope, choices, Finding::Envelope(found))
}

fn rare(bound: f64, probability: f64, high: f64) -> Evidence {
    let most_likely = MostLikely { j_tpf: Some(bound), distance: 1.55, quantities: Vec::new() };
    let found = RareObject {
        bound,
        least: 0.01,
        per_level: 800,
        flights: 1234,
        probability,
        low: 0.5 * probability,
        high,
        most_likely: Some(most_likely),
        ..RareObject::default()
    };
    piece(Kind::Rare, &[], Finding::Rare(found))
}

fn design(steady_flights: u64) -> Evidence {
    let results = FreshNumbers {
        flights: 300,
        unsafe_flights: 300 - steady_flights,
        steady_flights,
        chosen_among: 1,
        ..FreshNumbers::default()
    };
    let found = DesignObject {
        name: "design".to_owned(),
        objective: "quantile".to_owned(),
        allowed: true,
        fresh: vec![FreshObject { design: "design".to_owned(), air: "turbulence".to_owned(), results }],
        ..DesignObject::default()
    };
    piece(Kind::Design, &[], Finding::Design(found))
}

/// A drop, a campaign and an envelope that are enough.
fn enough() -> Vec<Evidence> {
    vec![drop(&[]), campaign(Kind::DropCampaign, 299, 0, &[]), envelope(&EnvelopeAxis::pairs(), true, &[])]
}

/// That evidence with another in the place of a piece, or behind it.
fn enough_but(place: usize, other: Evidence) -> Vec<Evidence> {
    let mut evidence = enough();
    match evidence.get_mut(place) {
        Some(piece) => *piece = other,
        None => evidence.push(other),
    }
    evidence
}

fn reasons(card: &Card<'_>) -> String {
    card.reasons().iter().map(|reason| format!("{}\n", reason.text)).collect()
}

/// The verdict says which probability is asked for or accepted and what failed, and calls nothing safe that
/// failed.
#[test]
fn regress_the_verdict_says_the_probability_and_the_failures() {
    let mission = mission(0.0);
    let go = "Go, within the envelope below: every piece of evidence that is asked for is there and belongs to these inputs; ";
    assert_eq!(
        card(&mission, &enough(), None).conclusion(),
        format!(
            "{go}no trial failed. A probability of failure of at most 0.01 is asked for; E2 leaves no more possible, at 95 % \
             confidence."
        )
    );
    let lax = enough_but(1, campaign(Kind::Campaign, 600, 42, &[]));
    let accepted = card(&mission, &lax, Some(0.4));
    assert!(accepted.reasons().is_empty(), "{}", reasons(&accepted));
    assert_eq!(
        accepted.conclusion(),
        format!(
            "{go}42 of 600 trials failed (E2). A probability of failure of up to 0.4 is accepted; E2 leaves no more possible, at \
             95 % confidence."
        )
    );
    let strict = card(&mission, &lax, None);
    assert!(reasons(&strict).contains("42 of 600 trials failed"), "{}", reasons(&strict));
    let said = strict.conclusion();
    assert!(
        said.starts_with("No go: ")
            && said.ends_with("a probability of failure of at most 0.01 is asked for."),
        "{said}"
    );
}

/// An envelope of these confirmed ranges of the wind below J_state 1.
fn wind_envelope(low: Option<f64>, high: Option<f64>) -> Evidence {
    let mut evidence = envelope(&EnvelopeAxis::pairs(), true, &[]);
    let end = |confirmed| Some(ReachEnd { confirmed, is_the_end: false });
    let axis = || "wind_m_s".to_owned();
    let reaches =
        [0.7, 1.0].map(|limit| EnvelopeReach { axis: axis(), limit, low: end(low), high: end(high) });
    if let Ok(Finding::Envelope(found)) = &mut evidence.found {
        found.one_at_a_time = reaches.into();
    }
    evidence
}

/// Three sigma of 1.5 m/s are 4.5: within what is confirmed it is a go; with two of three draws within, a go
/// for that range; with less, or nothing, none, and the sheet says so in words.
#[test]
fn regress_a_card_restricts_or_refuses_what_the_envelope_does_not_confirm() {
    let mission = mission(1.5);
    let of = |low, high| enough_but(2, wind_envelope(low, high));
    let decided = |evidence: &[Evidence]| {
        let card = card(&mission, evidence, None);
        (card.decision(), card.conclusion() + &reasons(&card), page(&card).unwrap())
    };
    let (decision, said, sheet) = decided(&of(Some(-5.6), Some(9.5)));
    assert!(decision == Decision::Go && said.starts_with("Go, within the envelope below"), "{said}");
    assert!(sheet.contains(">GO</p>") && sheet.contains("-4.5 .. 4.5"), "{sheet}");
    let (decision, said, sheet) = decided(&of(Some(-5.6), Some(3.0)));
    let restricted =
        "Go, restricted to tail wind from -5.6 to 3 m/s (the mission draws -4.5 to 4.5): every piece";
    assert!(decision == Decision::Restricted && said.starts_with(restricted), "{said}");
    assert!(sheet.contains("class=\"verdict go\">GO, restricted</p>"), "{sheet}");
    let (decision, said, sheet) = decided(&of(None, Some(0.06)));
    assert_eq!(decision, Decision::NoGo);
    let why = "envelope: tail wind is confirmed from 0 to 0.06 m/s alone, and the mission draws -4.5 to 4.5";
    assert!(said.starts_with("No go: the evidence speaks against it") && said.contains(why), "{said}");
    assert!(sheet.contains(">NO GO</p>") && sheet.contains("nothing confirmed .. 0.06"), "{sheet}");
    let (decision, said, sheet) = decided(&of(None, None));
    assert!(
        decision == Decision::NoGo && said.contains("envelope: nothing confirmed of tail wind"),
        "{said}"
    );
    assert!(sheet.contains("<td>nothing confirmed</td>"), "{sheet}");
    // By two envelopes, what both confirm.
    let mut both = of(Some(-5.6), Some(3.0));
    both.push(wind_envelope(Some(-2.0), Some(9.0)));
    let (_, said, _) = decided(&both);
    assert!(said.starts_with("Go, restricted to tail wind from -2 to 3 m/s"), "{said}");
    // A mission that draws no wind needs none confirmed, but for something.
    let calm = self::mission(0.0);
    assert_eq!(card(&calm, &of(Some(-0.1), None), None).decision(), Decision::Go);
    assert_eq!(card(&calm, &of(None, None), None).decision(), Decision::NoGo);
}

/// What vehicle and mission estimate, or do not say, must be accepted, and stands above the signatures.
#[test]
fn regress_estimates_are_accepted_or_it_is_no_go() {
    let mut mission = mission(0.0);
    mission.estimated = Estimated {
        vehicle: Some(vec!["inertia_kg_m2".to_owned()]),
        mission: None,
        origins: vec![Origin {
            keys: vec!["inertia_kg_m2".to_owned()],
            kind: OriginKind::Guessed,
            file: None,
            formula: Some("like a brick".to_owned()),
        }],
    };
    let accepted = card(&mission, &enough(), None);
    let refused = Card { accepts_estimates: false, ..accepted.clone() };
    assert_eq!((accepted.decision(), refused.decision()), (Decision::Go, Decision::NoGo));
    let why = "estimated, not measured, in vehicle: inertia_kg_m2; in mission: its file does not say which of its numbers are";
    assert!(reasons(&refused).contains(why), "{}", reasons(&refused));
    assert!(refused.conclusion().starts_with("No go: what is estimated is not accepted. "));
    assert!(accepted.conclusion().ends_with("Estimates of the inputs are accepted."));
    for (card, standing) in [(&accepted, "Accepted with these signatures"), (&refused, "NOT accepted")] {
        let sheet = page(card).unwrap();
        let above = sheet.split("<section class=\"sign\">").next().unwrap();
        assert!(
            above.contains("vehicle: inertia_kg_m2 (guessed: like a brick)") && above.contains(standing),
            "{above}"
        );
    }
    mission.estimated =
        Estimated { vehicle: Some(Vec::new()), mission: Some(Vec::new()), ..Estimated::default() };
    let measured = Card { accepts_estimates: false, ..card(&mission, &enough(), None) };
    assert_eq!(measured.decision(), Decision::Go);
    assert!(!page(&measured).unwrap().contains("Estimated or guessed"));
}

/// What failed comes first, then the greatest J_TPF first, whichever campaign it is of.
#[test]
fn regress_the_worst_ways_to_fail_are_sorted() {
    let mission = mission(0.0);
    let with = |worst| piece(Kind::Campaign, &[], assessed(299, 0, 0.9, worst));
    let trial = |trial: u64, j_tpf: f64| {
        let outcome = Outcome { j_tpf, altitude_lost_m: 20.0, ..Outcome::lost() };
        TrialObject { trial, outcome: OutcomeObject(outcome), failure: None }
    };
    let mut evidence = enough_but(1, with(vec![trial(7, 0.553), trial(8, 0.552)]));
    evidence.push(with(vec![trial(1, 0.917), trial(2, 0.6)]));
    let card = card(&mission, &evidence, None);
    let numbers: Vec<f64> = worst(&card).iter().filter_map(|row| J_TPF.of(&row.outcome.0)).collect();
    assert_eq!(numbers, [0.917, 0.6, 0.553, 0.552]);
    let sheet = page(&card).unwrap();
    assert!(sheet.contains("<td>never</td>") && sheet.contains("never steady"), "{sheet}");
}

/// A design's flights that are never steady have failed: 36 of 300 are a reason not to go, unless so many are
/// accepted.
#[test]
fn regress_flights_of_a_design_that_are_never_steady_speak_against_it() {
    let mission = mission(0.0);
    let evidence = enough_but(3, design(264));
    let strict = card(&mission, &evidence, None);
    let why = "design: in turbulence, of 300 flights that chose nothing 36 were not safe, 36 never steady";
    assert!(reasons(&strict).starts_with(why), "{}", reasons(&strict));
    let accepted = card(&mission, &evidence, Some(0.2));
    assert!(accepted.reasons().is_empty() && accepted.conclusion().contains("36 never steady (E4)"));
    assert!(card(&mission, &enough_but(3, design(300)), None).reasons().is_empty());
}

/// Evidence of another release, or along a trajectory that was given, is none of the mission's; what is flown
/// otherwise is named.
#[test]
fn regress_evidence_by_other_choices_does_not_count_or_is_named() {
    let mission = mission(0.0);
    let case = [("release case", "case_3")];
    let given = [("trajectory sha256", "0123")];
    for (place, other, expected) in [
        (
            0,
            drop(&given),
            "no drop from the nominal release is enough (E1: it is of a trajectory that was given)",
        ),
        (
            1,
            campaign(Kind::Campaign, 299, 0, &case),
            "no campaign is enough (E2: it is of release case case-3)",
        ),
        (2, envelope(&EnvelopeAxis::pairs(), true, &case), "(E3: it is of release case case-3)"),
    ] {
        let evidence = enough_but(place, other);
        let card = card(&mission, &evidence, None);
        assert!(reasons(&card).contains(expected), "{}", reasons(&card));
        assert!(page(&card).unwrap().contains("accepted, not counted: of "), "{expected}");
    }
    // What does not count may say no all the same.
    let failed = enough_but(3, campaign(Kind::Campaign, 299, 5, &case));
    let failed = reasons(&card(&mission, &failed, None));
    assert!(failed.contains("campaign of flights from t = 0 (release case case-3): 5 of 299"), "{failed}");
    let evidence = enough_but(1, campaign(Kind::DropCampaign, 299, 0, &[("feed forward", "yes")]));
    let card = card(&mission, &evidence, None);
    assert!(card.reasons().is_empty());
    assert!(
        card.conclusion().ends_with("Not as the mission says: E2 (feed forward)."),
        "{}",
        card.conclusion()
    );
    assert!(page(&card).unwrap().contains("accepted, with feed forward"));
}

/// A fragment of an envelope is not enough, and the sheet names what it has not looked at.
#[test]
fn regress_a_fragment_of_an_envelope_is_not_enough() {
    let mission = mission(0.0);
    let pair = [EnvelopeAxis::Delay, EnvelopeAxis::Turbulence];
    let evidence = enough_but(2, envelope(&[pair], true, &[]));
    let card = card(&mission, &evidence, None);
    let what = "pitch at release, pitch rate at release, descent at release, tail wind";
    let expected = format!(
        "no safe-release envelope is enough (E3: it has not looked at {what}): samara study envelope x500_drop"
    );
    assert!(reasons(&card).contains(&expected), "{}", reasons(&card));
    assert!(page(&card).unwrap().contains(&format!("E3 has NOT looked at: {what}")));
}

/// Random wind is drawn in whole drops alone: without a campaign of them nothing is known of it.
#[test]
fn regress_random_wind_asks_for_whole_drops() {
    let mission = mission(1.5);
    let from_t0 = enough_but(1, campaign(Kind::Campaign, 1000, 0, &[]));
    let short = card(&mission, &from_t0, None);
    let expected = "no campaign of whole drops is enough (E2: from t = 0, without what the mission names: random wind): \
                    samara assess x500_drop --autopilot reference --trials 299";
    assert!(reasons(&short).contains(expected), "{}", reasons(&short));
    let page = page(&short).unwrap();
    assert!(page.contains("No random drop here has what the mission names: random wind."), "{page}");
    assert!(page.contains("Flights from t = 0 (E2, E3) leave out what the mission names: random wind."));
    assert!(card(&mission, &enough(), None).reasons().is_empty());
}

/// Reaching a J_TPF below 1 is no failure, and no search's event is called one of a drop.
#[test]
fn regress_a_search_for_another_bound_shows_no_failures() {
    let mission = mission(0.0);
    let evidence = enough_but(3, rare(0.485, 0.0402, 0.0591));
    let low = card(&mission, &evidence, None);
    assert!(low.reasons().is_empty() && low.conclusion().contains("; no trial failed."));
    let row = probabilities(&low).pop().unwrap();
    assert_eq!(row.words(), "P(J_TPF >= 0.485) 0.040, 0.020 to 0.060 at 95 %");
    assert_eq!((row.of.as_str(), row.trials, row.flights), ("J_TPF >= 0.485", None, Some(1234)));
    let way = worst(&low).pop().unwrap();
    assert!(way.failure.is_none() && way.likely.is_some_and(|words| words.starts_with("1.55 standard")));
    let sheet = page(&low).unwrap();
    assert!(!sheet.contains("<b>failed</b>") && !sheet.contains(">J_TPF"), "{sheet}");
    assert!(sheet.contains("P(J<sub>TPF</sub> &gt;= 0.485) 0.040"), "{sheet}");
    // Of failures it is the probability, which the conclusion has.
    let evidence = enough_but(3, rare(1.0, 0.0042, 0.009));
    let card = card(&mission, &evidence, None);
    assert!(
        card.conclusion().contains("J_TPF >= 1 has a probability of 0.0042 (E4)"),
        "{}",
        card.conclusion()
    );
    assert!(page(&card).unwrap().contains("<b>failed</b>"));
}

/// Where no edge held nothing is said to be safe there.
#[test]
fn regress_an_envelope_of_which_nothing_is_confirmed_says_so() {
    let mission = mission(0.0);
    let evidence = enough_but(2, envelope(&EnvelopeAxis::pairs(), false, &[]));
    let sheet = page(&card(&mission, &evidence, None)).unwrap();
    assert!(sheet.contains("Nothing is confirmed: no edge held on 459 fresh flights."), "{sheet}");
    assert!(!sheet.contains("all of 459"), "{sheet}");
    let sheet = page(&card(&mission, &enough(), None)).unwrap();
    assert!(sheet.contains("whether they become steady is not judged"), "{sheet}");
}

/// Every piece of evidence that the sheet names is in its list, however many there are.
#[test]
fn regress_the_sheet_lists_all_that_it_names() {
    let mission = mission(0.0);
    let mut evidence = vec![drop(&[("release case", "case_1")]); 9];
    evidence.extend(enough());
    evidence.extend(vec![campaign(Kind::Campaign, 20, 0, &[]); 2]);
    evidence.sort_by_key(|piece| piece.kind);
    let card = card(&mission, &evidence, None);
    let sheet = page(&card).unwrap();
    let (above, list) = sheet.split_once("<h2>Evidence</h2>").unwrap();
    let named = (1..=evidence.len()).filter(|n| super::page::names(above, &format!("E{n}")));
    let named: Vec<usize> = named.collect();
    assert!(named.len() > 6 && named.len() < evidence.len(), "{named:?}");
    for n in named {
        assert!(list.contains(&format!("<span id=\"E{n}\">")), "E{n}");
    }
    assert!(super::page::names("by E1, E12", "E12") && !super::page::names("by E12", "E1"));
}

/// Of several campaigns the one is named that is nearest to being enough.
#[test]
fn regress_the_nearest_piece_of_evidence_is_named() {
    let mission = mission(0.0);
    let mut evidence = vec![drop(&[])];
    evidence.extend([
        campaign(Kind::Campaign, 4, 0, &[]),
        campaign(Kind::Campaign, 2000, 0, &[("release case", "case_1")]),
        campaign(Kind::Campaign, 250, 0, &[]),
        campaign(Kind::Campaign, 20, 0, &[]),
    ]);
    let why = reasons(&card(&mission, &evidence, None));
    assert!(why.contains("no campaign is enough (E4: 0 of 250 trials failed"), "{why}");
}

/// By hand: 299 trials show 0.01 at 95 %, and for one chosen among ten `ln(0.05/10)/ln(0.99)` = 527.2 are
/// needed.
#[test]
fn closed_form_a_choice_among_many_takes_more_trials() {
    assert_eq!([1, 10].map(|n| super::fewest_trials(0.01, ChosenAmong::new(n))), [299, 528]);
}
