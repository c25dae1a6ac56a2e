//! What a drop leaves: log, verdict, JSON and figures, of the nominal drop and of flights that went wrong.
#![cfg(feature = "files")]

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::LazyLock;

use nalgebra::Vector3;
use samara::assess::{Course, Outcome, Peaks, StateCost, Verdict, VerdictBuilder};
use samara::config::{Mission, Stamp, load_mission};
use samara::control::{Airframe, Cascade};
use samara::frames::rotate_ned_from_body;
use samara::model::MAX_ROTORS;
use samara::plan::{Guess, InputReference, Plan, PlanProblem, SolverOptions, plan};
use samara::report::{Attachment, DropEvent, DropRun, FigureError, FlightCsv, FlownBy, ShownDrop, drop_page};
use samara::report::{drop_figure, drop_json, drop_mcap, plan_figure, plan_json, plan_text, verdict_text};
use samara::sim::{DropSimulation, FlightPlan, Phase, Reference, Sample, fly};

struct Drop {
    mission: Mission,
    plan: Plan,
    samples: Vec<Sample>,
    verdict: Verdict,
}

static DROP: LazyLock<Drop> = LazyLock::new(|| dropped("mission/titan_paper.json"));

fn planned(mission: &Mission) -> Plan {
    let (body, _) = mission.release.parachute.hanging(0.0, &mission.site.environment);
    let v = body.v_ned + mission.site.environment.gravity_ned() * mission.release.parachute.delay_s;
    let q = body.q_ned_from_body;
    let w = body.omega_body;
    let problem = PlanProblem {
        vehicle: &mission.vehicle,
        environment: &mission.site.environment,
        initial: [q[0], q[1], q[2], q[3], v.x, v.y, v.z, w.x, w.y, w.z],
        initial_thrust_n: [0.0; MAX_ROTORS],
        target_v_ned: mission.target_v_ned,
        x_ss: mission.plan.x_ss,
        horizon_s: mission.plan.horizon_s,
        nodes: mission.plan.nodes,
        thrust_max_n: mission.plan.thrust_max_n,
        thrust_rate_n_s: mission.plan.thrust_slew_n_s,
        cost_state: mission.plan.cost_state,
        cost_input: mission.plan.cost_input,
        input_reference: InputReference::Zero,
        terminal_velocity_tolerance_m_s: None,
        demands: mission.plan.demands,
    };
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    plan(&problem, &Guess::StraightLine, &SolverOptions::default(), go_on).unwrap()
}

fn dropped(path: &str) -> Drop {
    let mission = load_mission(Path::new(path)).unwrap();
    let plan = planned(&mission);
    let (vehicle, environment) = (mission.vehicle.clone(), mission.site.environment.clone());
    let airframe = Airframe::new(&vehicle, &environment).unwrap();
    let mut cascade = Cascade::new(airframe, mission.control.gains, mission.control.limits);
    let mut sim = DropSimulation::new(
        vehicle,
        environment,
        mission.release.parachute,
        mission.release.hang_s,
        mission.release.start,
    );
    sim.schedule_release(mission.release.hang_s);
    let flight = FlightPlan {
        setpoint_period_s: Some(0.02),
        ..FlightPlan::new(
            Reference::Plan {
                trajectory: &plan.trajectory,
                then_v_ned: Some(mission.target_v_ned),
                feed_forward: false,
            },
            0.004,
            mission.duration_s,
        )
    };
    let mut samples = Vec::new();
    let mut builder = VerdictBuilder::new(mission.limits.safety, mission.target_v_ned);
    let _ = fly(&mut sim, &mut cascade, &flight, &mut |s| {
        builder.observe(s);
        samples.push(*s);
        ControlFlow::Continue(())
    });
    Drop { mission, plan, samples, verdict: builder.finish().unwrap() }
}

fn stamp(mission: &Mission) -> Stamp {
    mission.stamp()
}

impl Drop {
    fn figure(&self) -> String {
        drop_figure(&self.shown(&self.samples, &DropRun::default())).unwrap()
    }

    fn plan_figure(&self) -> String {
        plan_figure(&self.mission, &self.plan.trajectory).unwrap()
    }

    fn shown<'a>(&'a self, samples: &'a [Sample], run: &'a DropRun) -> ShownDrop<'a> {
        ShownDrop {
            mission: &self.mission,
            title: &self.mission.name,
            gains: &self.mission.control.gains_name,
            samples,
            plan: Some(&self.plan.trajectory),
            verdict: Some(&self.verdict),
            run,
        }
    }

    fn page(&self, mission: &Mission, run: &DropRun) -> String {
        let gains = &mission.control.gains_name;
        drop_page(&ShownDrop { mission, title: &mission.name, gains, ..self.shown(&self.samples, run) })
    }

    fn csv(&self) -> Vec<u8> {
        let mut csv = FlightCsv::new(Vec::new(), &self.mission, false).unwrap();
        for sample in &self.samples {
            csv.write(sample).unwrap();
        }
        csv.finish().unwrap()
    }
}

/// Opening and closing tags pair up, nothing stands outside the root, and every ampersand begins an entity.
fn assert_well_formed(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = svg.trim();
    while let Some(start) = rest.find('<') {
        assert!(start == 0 || !open.is_empty(), "text outside the root");
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        assert_eq!(tag.matches('"').count() % 2, 0, "{tag}");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().unwrap());
        }
        rest = &rest[end + 1..];
        assert!(!open.is_empty() || rest.is_empty(), "a second root");
    }
    assert!(open.is_empty() && rest.is_empty());
    for (i, _) in svg.match_indices('&') {
        assert!(["&lt;", "&gt;", "&amp;", "&quot;", "&apos;"].iter().any(|e| svg[i..].starts_with(e)));
    }
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

/// Every point of every line lies on the sheet.
fn assert_on_the_sheet(svg: &str) {
    let size = svg.split("viewBox=\"0 0 ").nth(1).unwrap().split('"').next().unwrap();
    let (width, height) = size.split_once(' ').unwrap();
    let (width, height): (f64, f64) = (width.parse().unwrap(), height.parse().unwrap());
    for points in svg.split("points=\"").skip(1) {
        for point in points.split('"').next().unwrap().split_whitespace() {
            let (x, y) = point.split_once(',').unwrap();
            let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
            assert!((0.0..=width).contains(&x) && (0.0..=height).contains(&y), "{point}");
        }
    }
}

#[test]
fn the_figures_are_small_well_formed_and_the_same_each_time() {
    for svg in [DROP.figure(), DROP.plan_figure()] {
        assert_well_formed(&svg);
        assert_on_the_sheet(&svg);
        assert!(svg.len() < 300_000, "{}", svg.len());
        assert!(svg.contains(&DROP.mission.inputs.hash) && svg.contains("seed 1"));
    }
    assert_eq!(DROP.figure(), DROP.figure());
    let figure = DROP.figure();
    for text in
        ["released", "rotors free, t = 0", "steady from 31.2 s", "planned path", "north [m]", "[deg/s]"]
    {
        assert!(figure.contains(text), "{text}");
    }
    // The same flight, planned and flown anew.
    assert!(dropped("mission/titan_paper.json").figure() == figure);
}

#[test]
fn a_figure_of_an_awkward_flight_is_drawn_or_refused() {
    let run = DropRun::default();
    let draw = |samples: &[Sample]| drop_figure(&DROP.shown(samples, &run));
    assert_eq!(draw(&[]), Err(FigureError::Empty));
    let mut samples: Vec<Sample> = DROP.samples.iter().step_by(50).copied().collect();
    let powered = samples.iter().position(|s| s.phase == Phase::Powered).unwrap();
    // Not released; an instant only.
    assert_well_formed(
        &drop_figure(&ShownDrop { plan: None, verdict: None, ..DROP.shown(&samples[..20], &run) }).unwrap(),
    );
    assert_well_formed(&draw(&samples[powered..powered + 1]).unwrap());
    // Broken off: the plan goes on, within the sheet.
    assert_on_the_sheet(&draw(&samples[..powered + 20]).unwrap());
    // Diverged: beyond every limit, then out of bounds, then no numbers.
    for (k, sample) in samples[powered + 20..].iter_mut().enumerate() {
        let x = [40.0, 1e200, f64::INFINITY, f64::NAN][k.min(3)];
        sample.state.body.v_ned.x = x;
        sample.state.body.p_ned.z = x;
        sample.balance.thrust_n[0] = x;
    }
    assert_well_formed(&draw(&samples[..powered + 21]).unwrap());
    assert_well_formed(&draw(&samples).unwrap());
    for sample in &mut samples {
        sample.state.body.p_ned.z = f64::NAN;
    }
    assert_eq!(draw(&samples), Err(FigureError::Empty));
}

/// The data of a page, as its script reads them.
fn data_of(page: &str) -> serde_json::Value {
    let block = page.split("<script id=\"drop\" type=\"application/json\">").nth(1).unwrap();
    serde_json::from_str(block.split("</script>").next().unwrap()).unwrap()
}

#[test]
fn the_page_holds_the_whole_flight_and_is_the_same_each_time() {
    let run = DropRun { course: Course::WHOLE, ..DropRun::default() };
    let page = DROP.page(&DROP.mission, &run);
    assert!(page == DROP.page(&DROP.mission, &run));
    assert!(page.len() < 3_000_000, "{}", page.len());
    assert!(page.contains("Safe: at most 55 % of a safety limit is used, that of speed."));
    assert!(page.contains("default-src 'none'; script-src 'sha256-") && !page.contains("unsafe-"));
    assert!(!page.split("<script").next().unwrap().contains("{{"), "every name of the template is filled in");
    let data = data_of(&page);
    assert_eq!(data["flight"]["count"], DROP.samples.len());
    let names = |motion: &str| -> Vec<String> {
        let channels = data[motion]["channels"].as_array().unwrap();
        channels.iter().map(|c| c["name"].as_str().unwrap().to_owned()).collect()
    };
    // As the columns of the log.
    let log = String::from_utf8(DROP.csv()).unwrap();
    let header: Vec<&str> = log.lines().find(|l| l.starts_with("t_s")).unwrap().split(',').collect();
    assert!(names("flight").iter().all(|name| header.contains(&name.as_str())), "{:?}", names("flight"));
    assert!(names("plan").contains(&"thrust_4_n".to_owned()));
    let times = &data["times"];
    assert_eq!((times["released_s"].as_f64(), times["free_s"].as_f64()), (Some(10.0), Some(10.5)));
    let marks: Vec<&str> =
        data["marks"].as_array().unwrap().iter().map(|m| m["short"].as_str().unwrap()).collect();
    assert_eq!(marks, ["released", "rotors free", "highest J 0.555: speed", "plan ends", "steady"]);
}

/// Names and events come from files and from others on the wire.
#[test]
fn what_comes_from_files_cannot_become_markup() {
    let evil = "</script><script>alert(1)</script><!--<img src=x onerror='alert(2)'>&";
    let mut mission = DROP.mission.clone();
    for name in [&mut mission.name, &mut mission.vehicle_name, &mut mission.control.gains_name] {
        *name = evil.to_owned();
    }
    let events = vec![DropEvent { t_s: 1.0, text: evil.to_owned(), warning: false }];
    let trouble = Some(evil.to_owned());
    let page = DROP.page(
        &mission,
        &DropRun { course: Course { trouble, ..Course::WHOLE }, events, ..DropRun::default() },
    );
    let harmless = DROP.page(&DROP.mission, &DropRun { course: Course::WHOLE, ..DropRun::default() });
    for part in ["<script", "</script", "<!--", "<img"] {
        assert_eq!(page.matches(part).count(), harmless.matches(part).count(), "{part}");
    }
    let data = data_of(&page);
    assert_eq!(
        (&data["mission"], &data["vehicle"], &data["gains"]),
        (&evil.into(), &evil.into(), &evil.into())
    );
    assert!(data["marks"].as_array().unwrap().iter().any(|m| m["text"] == evil));
}

/// Flights that broke off, diverged or were never released have a page, too.
#[test]
fn a_page_of_an_awkward_flight_is_rendered() {
    let render = |samples: &[Sample], verdict: Option<&Verdict>| {
        let run = DropRun::default();
        let mission = &DROP.mission;
        let drop = ShownDrop { mission, title: "x", gains: "y", samples, plan: None, verdict, run: &run };
        data_of(&drop_page(&drop))
    };
    assert_eq!(render(&[], None)["flight"]["count"], 0);
    let mut samples: Vec<Sample> = DROP.samples.iter().step_by(50).copied().collect();
    assert_eq!(render(&samples[..2], None)["flight"]["count"], 2);
    for (k, sample) in samples.iter_mut().enumerate().skip(20) {
        sample.state.body.p_ned.z = [40.0, 1e200, f64::INFINITY, f64::NAN][k % 4];
    }
    let data = render(&samples, Some(&DROP.verdict));
    let down = data["flight"]["channels"].as_array().unwrap().iter().find(|c| c["name"] == "down_m").unwrap();
    assert_eq!(down["gaps"][0], serde_json::json!([21, 24]), "1e200, infinity, no number");
}

fn mcap(drop: &ShownDrop<'_>) -> Vec<u8> {
    let attached = [Attachment { name: "a.json".to_owned(), text: "{}".to_owned() }];
    drop_mcap(Vec::new(), drop, false, &attached).unwrap()
}

/// What readers make of it is in tests/e2e/test_mcap.py.
#[test]
fn the_log_for_other_tools_is_the_same_each_time() {
    let run = DropRun::default();
    let file = mcap(&DROP.shown(&DROP.samples, &run));
    assert_eq!(file, mcap(&DROP.shown(&DROP.samples, &run)));
    let has = |text: &str| file.windows(text.len()).any(|bytes| bytes == text.as_bytes());
    assert!(
        ["/tf", "/plan/state", "samara.State", "ground_fn_n", "a.json"].map(has)
            == [true, true, true, false, true]
    );
}

/// Flights that broke off, diverged or were never released have such a log, too, whole to its end.
#[test]
fn an_awkward_flight_has_a_log_for_other_tools() {
    let run = DropRun::default();
    let whole = |samples: &[Sample], plan| {
        let file = mcap(&ShownDrop { plan, verdict: None, ..DROP.shown(samples, &run) });
        assert!(file.ends_with(b"\x89MCAP0\r\n"));
    };
    whole(&[], None);
    let mut samples: Vec<Sample> = DROP.samples.iter().step_by(50).copied().collect();
    whole(&samples[..2], Some(&DROP.plan.trajectory));
    for (k, sample) in samples.iter_mut().enumerate().skip(20) {
        sample.t_s = [1.0, -1e30, f64::INFINITY, f64::NAN][k % 4];
        sample.state.body.p_ned.z = [40.0, 1e200, f64::INFINITY, f64::NAN][k % 4];
        sample.balance.thrust_n[0] = f64::NAN;
    }
    whole(&samples, Some(&DROP.plan.trajectory));
}

/// The samples of the drop with their positions moved.
fn moved(position: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<Sample> {
    let mut samples = DROP.samples.clone();
    for sample in &mut samples {
        sample.state.body.p_ned = position(sample.state.body.p_ned);
    }
    samples
}

/// Texts of a figure with an estimate of where they are [px]: left, top, right, bottom.
fn texts(svg: &str) -> Vec<(String, [f64; 4])> {
    let attribute = |tag: &str, name: &str| -> String {
        let value = tag.split(&format!(" {name}=\"")).nth(1).unwrap_or_default();
        value.split('"').next().unwrap().to_owned()
    };
    let mut found = Vec::new();
    for element in svg.split("<text").skip(1) {
        let (tag, rest) = element.split_once('>').unwrap();
        let mut text = String::new();
        let mut inside = false;
        for c in rest.split("</text>").next().unwrap().trim().chars() {
            match c {
                '<' => inside = true,
                '>' => inside = false,
                c if !inside => text.push(c),
                _ => {}
            }
        }
        let number = |name: &str| attribute(tag, name).parse::<f64>().unwrap() / 10.0;
        let (x, y, size) = (number("x"), number("y"), number("font-size"));
        let width = 0.5 * size * text.chars().count() as f64;
        let left = match attribute(tag, "text-anchor").as_str() {
            "middle" => x - 0.5 * width,
            "end" => x - width,
            _ => x,
        };
        found.push((text, [left, y - 0.4 * size, left + width, y + 0.4 * size]));
    }
    found
}

/// A drop that falls straight down and hovers: all that happens, happens on one upright line.
#[test]
fn labels_of_a_hover_drop_do_not_overlap() {
    let run = DropRun::default();
    let hover_m = DROP.samples[0].state.body.p_ned.z + 20.0;
    let samples = moved(|p| Vector3::new(0.0, 0.0, p.z.min(hover_m)));
    let verdict = Verdict {
        outcome: Outcome { steady_after_s: Some(6.0), ..DROP.verdict.outcome },
        ..DROP.verdict.clone()
    };
    let svg = drop_figure(&ShownDrop { verdict: Some(&verdict), ..DROP.shown(&samples, &run) }).unwrap();
    let path: Vec<_> = texts(&svg).into_iter().filter(|(_, p)| p[2] < 450.0 && p[1] > 112.0).collect();
    assert!(path.iter().any(|(text, _)| text == "released"), "{path:?}");
    for (i, (a, p)) in path.iter().enumerate() {
        for (b, q) in &path[i + 1..] {
            let apart = p[2] <= q[0] || q[2] <= p[0] || p[3] <= q[1] || q[3] <= p[1];
            assert!(apart, "`{a}` and `{b}`: {p:?}, {q:?}");
        }
    }
    // A fifth on after steady: the last number below the panels.
    let numbers = texts(&svg).into_iter().filter(|(_, p)| p[0] > 500.0 && p[1] > 715.0);
    let last = numbers.filter_map(|(text, _)| text.parse::<f64>().ok()).fold(0.0, f64::max);
    assert!((6.0..15.0).contains(&last), "{last}");
}

#[test]
fn the_path_is_seen_in_its_plane_and_from_above_where_it_leaves_it() {
    let run = DropRun::default();
    let draw = |samples: &[Sample]| drop_figure(&DROP.shown(samples, &run)).unwrap();
    let has = |svg: &str, wanted: &str| texts(svg).iter().any(|(text, _)| text == wanted);
    let east = draw(&moved(|p| Vector3::new(p.y, p.x, p.z)));
    assert!(has(&east, "east [m]") && !has(&east, "from above: north [m]"));
    let aside = draw(&moved(|p| Vector3::new(p.x, p.x, p.z)));
    assert!(has(&aside, "distance towards 45 deg [m]") && !has(&aside, "from above: north [m]"));
    let bent = draw(&moved(|p| Vector3::new(p.x, p.x * p.x / 100.0, p.z)));
    assert!(has(&bent, "from above: north [m]") && has(&bent, "east [m]"));
    assert_on_the_sheet(&bent);
}

#[test]
fn the_figure_names_gains_and_wind() {
    let figure = DROP.figure();
    assert!(figure.contains("Vehicle titan, gains ours, no wind."));
    assert!(figure.contains("1, the limit"));
}

#[test]
fn the_log_reads_back_to_the_bit_and_its_balance_closes() {
    let bytes = DROP.csv();
    let text = std::str::from_utf8(&bytes).unwrap();
    assert!(text.starts_with(&stamp(&DROP.mission).csv_comment()));
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(&bytes[..]);
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let column = |name: &str| header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no {name}"));
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 11_251);
    assert_eq!(rows.len(), DROP.samples.len());
    let columns: Vec<[usize; 3]> =
        [["rotor_fx_n", "rotor_fy_n", "rotor_fz_n"], ["aero_fx_n", "aero_fy_n", "aero_fz_n"]]
            .iter()
            .chain(&[
                ["gravity_fn_n", "gravity_fe_n", "gravity_fd_n"],
                ["canopy_fn_n", "canopy_fe_n", "canopy_fd_n"],
            ])
            .chain(&[["an_m_s2", "ae_m_s2", "ad_m_s2"], ["vn_m_s", "ve_m_s", "vd_m_s"]])
            .map(|names| names.map(column))
            .collect();
    for (row, sample) in rows.iter().zip(&DROP.samples) {
        let number = |i: usize| row[i].parse::<f64>().unwrap();
        let vector = |k: usize| Vector3::from(columns[k].map(number));
        assert_eq!(number(column("t_s")), sample.t_s);
        assert_eq!(row[column("t_powered_s")].parse().ok(), sample.t_powered_s);
        assert_eq!(row[column("vd_sp_m_s")].parse().ok(), sample.v_sp_ned.map(|v| v.z));
        assert_eq!(number(column("q2")), sample.state.body.q_ned_from_body[2]);
        assert_eq!(number(column("rotor_speed_4_rad_s")), sample.state.rotor_speed[3]);
        assert_eq!(number(column("thrust_2_n")), sample.balance.thrust_n[1]);
        assert_eq!(number(column("gyro_mz_nm")), sample.balance.gyro_moment_body.z);
        assert_eq!(vector(5), sample.state.body.v_ned);
        let q = sample.state.body.q_ned_from_body;
        let force_ned = rotate_ned_from_body(q, vector(0) + vector(1)) + vector(2) + vector(3);
        let mass = DROP.mission.vehicle.mass.mass_kg;
        assert!((force_ned - vector(4) * mass).norm() < 1e-9 * mass, "at {} s", sample.t_s);
    }
    assert_eq!(&rows[0][column("phase")], "hanging");
    let highest = rows.iter().filter(|r| &r[column("phase")] != "hanging");
    let highest = highest.map(|r| r[column("j_state")].parse().unwrap()).fold(0.0, f64::max);
    assert_eq!(highest, DROP.verdict.outcome.j_tpf);
}

#[test]
fn reference_j_tpf_of_the_plan() {
    let reference: serde_json::Value =
        serde_json::from_str(include_str!("data/reference_plans.json")).unwrap();
    let expected = reference["titan_nominal_j_tpf"].as_f64().unwrap();
    let found = DROP.mission.integrated(&DROP.plan.trajectory).j_tpf_at_nodes;
    assert!((found - expected).abs() < 1e-9, "{found} against {expected}");
}

fn bad_verdict() -> Verdict {
    Verdict {
        outcome: Outcome {
            j_tpf: 1.25,
            peak_speed_m_s: 15.0,
            peak_pitch_deg: 0.5f64.to_degrees(),
            peak_pitch_rate_deg_s: 1f64.to_degrees(),
            altitude_lost_m: 1234.56,
            ..Outcome::default().with_final_v(Vector3::new(4.001, -0.0001, 12.0))
        },
        decided_by: "speed",
        peaks: Peaks { pitch_rad: -0.5, pitch_rate_rad_s: 1.0, ..Peaks::default() },
        peak_vertical_acceleration_m_s2: -4.0,
        limits_passed: vec!["speed"],
        plan_cut: false,
        on_the_ground: None,
        limits: DROP.mission.limits,
        peak_cost: StateCost::default(),
        vortex_ring_s: Vec::new(),
        power: None,
    }
}

#[test]
fn regress_the_verdict_in_words() {
    let expected = "\
                                value         limit
J_TPF                          1.2500             1  EXCEEDED, decided by speed
peak speed                      15.00 m/s        12  EXCEEDED
peak pitch                     -28.65 deg      +-45  ok
peak pitch rate                 57.30 deg/s    +-90  ok
peak vertical acceleration      -4.00 m/s^2     +-3  not judged
altitude lost                  1234.6 m
steady after                    never                NOT STEADY
final velocity, NED  4.00 0.00 12.00 m/s
";
    let found = verdict_text(&bad_verdict(), &DROP.mission.limits, true);
    let squeezed = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(squeezed(&found), squeezed(expected), "{found}");
    let bad = bad_verdict();
    let peaks = Peaks { roll_rad: -0.9, ..bad.peaks };
    let rolled = Verdict { peaks, decided_by: "roll", limits_passed: vec!["roll"], ..bad };
    let rolled = squeezed(&verdict_text(&rolled, &DROP.mission.limits, false));
    assert!(rolled.contains("EXCEEDED, decided by roll") && rolled.contains("after never final"), "{rolled}");
    assert!(
        rolled.contains("peak roll -51.57 deg +-45 EXCEEDED peak roll rate 0.00 deg/s +-90 ok"),
        "{rolled}"
    );
    let ends: Vec<usize> = found.lines().take(6).filter_map(|l| l.find("  ok").or(l.find("  EXC"))).collect();
    assert!(ends.windows(2).all(|e| e[0] == e[1]), "{found}");
}

#[test]
fn json_objects_have_their_keys_and_files_hold_no_durations() {
    let parse = |text: String| serde_json::from_str::<serde_json::Value>(&text).unwrap();
    let mission = &DROP.mission;
    let run = DropRun {
        plan_j_tpf: Some(0.5),
        plan_shortfall: None,
        plan_solve_ms: Some(4.0),
        real_time_factor: Some(120.0),
        ended_at_s: 45.0,
        course: Course { failsafe: true, ..Course::WHOLE },
        trajectory: None,
        events: vec![DropEvent { t_s: 10.5, text: "rotors free".to_owned(), warning: false }],
        autopilot: Some(FlownBy { name: "px4", version: Some("v1.12.0".to_owned()) }),
        faults: Vec::new(),
        hint: None,
        commanded: Vec::new(),
        rotor_starts: Vec::new(),
        replans: Vec::new(),
        free_fall: None,
    };
    let drop = parse(drop_json(mission, Some(&bad_verdict()), &run));
    assert_eq!((&drop["completed"], &drop["ended_at_s"]), (&true.into(), &45.0.into()));
    let reason = "a failsafe flew; never steady within 0.0566 m/s of the target";
    assert_eq!((&drop["reason"], &drop["decided_by"]), (&reason.into(), &"speed".into()));
    assert_eq!(
        (&drop["safe"], &drop["objections"]),
        (
            &false.into(),
            &serde_json::json!([
                "a failsafe flew",
                "J_TPF 1.250, not below 1",
                "never steady within 0.0566 m/s of the target"
            ])
        )
    );
    let went = |course: Course| DropRun { course, ..run.clone() };
    let run = went(Course::WHOLE);
    let bad = bad_verdict();
    let steady = Verdict { outcome: Outcome { steady_after_s: Some(7.0), ..bad.outcome }, ..bad };
    assert!(parse(drop_json(mission, Some(&steady), &run))["reason"].is_null());
    let by_script = went(Course { must_be_steady: false, ..Course::WHOLE });
    assert!(parse(drop_json(mission, Some(&bad_verdict()), &by_script))["reason"].is_null());
    let fell = went(Course { motors_never_started: true, ..Course::WHOLE });
    let fell = parse(drop_json(mission, Some(&bad_verdict()), &fell));
    assert_eq!(fell["reason"], "the motors were never started");
    let cut_short = Verdict { plan_cut: true, ..bad_verdict() };
    let short = parse(drop_json(mission, Some(&cut_short), &run));
    assert_eq!(
        (&short["completed"], &short["reason"]),
        (&false.into(), &"the mission's duration_s ended before the plan".into())
    );
    let stopped = went(Course { completed: false, ..Course::WHOLE });
    let cut = parse(drop_json(mission, Some(&bad_verdict()), &stopped));
    assert_eq!(
        (&cut["completed"], &cut["reason"]),
        (&false.into(), &"stopped before the mission's end".into())
    );
    assert_eq!((&drop["autopilot"], &drop["autopilot_version"]), (&"px4".into(), &"v1.12.0".into()));
    let refused = went(Course { trouble: Some("arming refused".to_owned()), ..stopped.course });
    let refused = parse(drop_json(mission, None, &refused));
    assert_eq!(refused["reason"], "stopped before the release: arming refused");
    let late = went(Course { trouble: Some("PX4 has ended".to_owned()), ..Course::WHOLE });
    let late = parse(drop_json(mission, Some(&bad_verdict()), &late));
    assert_eq!((&late["completed"], &late["reason"]), (&false.into(), &"PX4 has ended".into()));
    let never = parse(drop_json(mission, None, &run));
    assert_eq!(never["reason"], "the vehicle was never released");
    assert!(never["j_tpf"].is_null() && never["limits_passed"].is_null());
    assert_eq!(drop["j_tpf"], 1.25);
    assert_eq!(drop["peak_speed_m_s"], 15.0);
    assert!((drop["peak_pitch_deg"].as_f64().unwrap() - 28.6478897565).abs() < 1e-9);
    assert!((drop["peak_pitch_rate_deg_s"].as_f64().unwrap() - 57.295779513).abs() < 1e-9);
    assert_eq!(drop["altitude_lost_m"], 1234.56);
    assert!(drop["steady_after_s"].is_null());
    assert_eq!(drop["limits_passed"], serde_json::json!(["speed"]));
    assert_eq!(drop["real_time_factor"], 120.0);
    assert_eq!(drop["failsafe"], true);
    assert_eq!(drop["events"], serde_json::json!([{ "t_s": 10.5, "text": "rotors free" }]));
    let bad = bad_verdict();
    let diverged = Verdict { outcome: Outcome { j_tpf: f64::INFINITY, ..bad.outcome }, ..bad };
    let file = parse(drop_json(mission, Some(&diverged), &DropRun::default()));
    assert!(file["j_tpf"].is_null() && file.get("real_time_factor").is_none());

    let plan = parse(plan_json(mission, &DROP.plan, Some(4.5), None));
    assert_eq!((&plan["status"], &plan["solve_ms"]), (&"converged".into(), &4.5.into()));
    assert_eq!(plan["iterations"], DROP.plan.counts.iterations);
    assert_eq!(plan["objective"], DROP.plan.objective);
    assert_eq!(plan["input_hash"], mission.inputs.hash.as_str());
    assert!(parse(plan_json(mission, &DROP.plan, None, None)).get("solve_ms").is_none());
    assert!(plan_text(mission, &DROP.plan, None).starts_with("converged, "));
}
