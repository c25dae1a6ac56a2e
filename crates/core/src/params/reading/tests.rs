//! Files of parameters: bytes, other programs' files, refusals, no panic.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::params::file::{Value, write};
use crate::params::reading::reader::MOST_ROWS;
use crate::params::{Against, Purpose, check};

fn two() -> BTreeMap<String, Value> {
    BTreeMap::from([("SYS_AUTOSTART".into(), Value::Int(4001)), ("MC_PITCH_P".into(), Value::Real(0.1))])
}

#[test]
fn closed_form_the_bytes_of_a_file() {
    let text = write("samara 1.2.3", &["For: samara".to_owned()], &two());
    let expected = "# Onboard parameters for Vehicle 1\n#\n# Stack: PX4 Pro\n# Vehicle: Multi-Rotor\n\
        # Version: samara 1.2.3\n# Git Revision: none\n#\n# For: samara\n#\n\
        # Vehicle-Id Component-Id Name Value Type\n\
        1\t1\tMC_PITCH_P\t0.100000001490116119\t9\n1\t1\tSYS_AUTOSTART\t4001\t6\n";
    assert_eq!(text, expected);
}

/// Whole numbers up to 2^24 are exact in single precision, and beyond only even ones are; a real number goes
/// to a whole one a hundredth away at the most.
#[test]
fn closed_form_a_value_in_another_type_is_the_same_or_none() {
    let int = |value: Value| value.in_type_of(Value::Int(0));
    let real = |value: Value| value.in_type_of(Value::Real(0.0));
    assert_eq!((int(Value::Int(7)), real(Value::Real(0.3))), (Some(Value::Int(7)), Some(Value::Real(0.3))));
    assert_eq!(real(Value::Int(1 << 24)), Some(Value::Real(16_777_216.0)));
    assert_eq!((real(Value::Int((1 << 24) + 1)), real(Value::Int(i32::MAX))), (None, None));
    for (x, i) in [
        (110.0, Some(110)),
        (112.4, Some(112)),
        (-1.0, Some(-1)),
        (0.0, Some(0)),
        (0.15, None),
        (1.5, None),
        (3e9, None),
        (f32::NAN, None),
        (f32::INFINITY, None),
    ] {
        assert_eq!(int(Value::Real(x)), i.map(Value::Int), "{x}");
    }
}

#[test]
fn files_of_any_origin_are_read() {
    let lf = write("1.15.0", &[], &two());
    let good = ParameterFile::parse(&lf).unwrap();
    assert_eq!(good.get("MC_PITCH_P"), Some(Value::Real(0.1)));
    assert_eq!((good.purpose(), good.remarks().len()), (None, 0));
    assert_eq!(good.header("Stack"), Some("PX4 Pro"));
    for other in [
        lf.replace('\n', "\r\n"),
        lf.lines().filter(|l| !l.starts_with('#')).collect::<Vec<_>>().join("\n"),
        lf.replace("0.100000001490116119", "0.1"),
        lf.replace("0.100000001490116119", "1e-01").replace("4001", "4.001e3"),
        format!("\u{feff}{lf}"),
    ] {
        let read = ParameterFile::parse(&other).unwrap();
        assert_eq!(read.get("MC_PITCH_P"), Some(Value::Real(0.1)), "{other}");
        assert_eq!(read.get("SYS_AUTOSTART"), Some(Value::Int(4001)));
        assert!(read.remarks().is_empty(), "{:?}", read.remarks());
    }
    assert!(remarks("7\t1\tMC_PITCH_P\t4\t9").contains("vehicle id 7"));
    assert!(remarks("1 1 MC_PITCH_P 4 9").contains("tabs"));
    assert!(remarks("1\t154\tMC_PITCH_P\t4\t9").contains("154"));
    assert_eq!(ParameterFile::parse("1\t154\tMC_PITCH_P\t4\t9").unwrap().get("MC_PITCH_P"), None);
}

fn remarks(text: &str) -> String {
    ParameterFile::parse(text).unwrap().remarks().join("; ")
}

#[test]
fn what_is_wrong_is_refused_with_its_line() {
    for (text, expected) in [
        ("1\t1\tMC_PITCH_P\t4.0", "1: expected five columns"),
        ("\n# x\n1\t1\tMC_PITCH_P\t4,0\t9", "3: value: expected a finite number"),
        ("1\t1\tFOO_BAR\t4,0\t9", "1: value: expected a finite number"),
        ("1\t1\tFOO_BAR\t0x10\t6", "1: value: expected a 32-bit whole number"),
        ("1\t1\tMC_PITCH_P\tnan\t9", "1: value: expected a finite number"),
        ("1\t1\tMC_PITCH_P\t1e39\t9", "1: value: expected a finite number"),
        ("1\t1\tCOM_DISARM_PRFLT\tinf\t9", "1: value: expected a finite number"),
        ("1\t1\tCA_ROTOR0_PX\tinf\t9", "1: value: expected a finite number"),
        ("1\t1\tSYS_AUTOSTART\t4001.5\t6", "1: value: expected a 32-bit whole number"),
        ("1\t1\tSYS_AUTOSTART\t2147483648\t6", "1: value: expected a 32-bit whole number"),
        ("1\t1\tMC_PITCH_P\t4\t11", "1: type: expected 6"),
        ("1\t1\tMC_PITCH_PROPORTIONAL\t4\t9", "1: name: expected"),
        ("256\t1\tMC_PITCH_P\t4\t9", "1: vehicle id: expected"),
        ("1\t1\tB\t1\t9\n1\tx\tMC_PITCH_P\t4\t9", "2: component id: expected"),
        ("1\t1\tA\t4\t9\r\n1\t1\tA\t5\t9", "2: A stands on line 1 already"),
        ("{\"json\": true}", "1: expected five columns"),
        ("MC_PITCH_P 4\nMC_ROLL_P", "2: expected a name and a value"),
        ("MC_PITCH_P 4\nMC_ROLL_P 4 5", "2: expected a name and a value"),
        ("MC_PITCH_P 4,0", "1: value: expected a finite number"),
        ("MC_PITCH_P 4\nMC_PITCH_P 5", "2: MC_PITCH_P stands on line 1 already"),
        ("MC_PITCH_P 4\nSYS_AUTOSTART 4001.5", "2: value: expected a 32-bit whole number"),
    ] {
        let error = ParameterFile::parse(text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{text:?}: {error}");
    }
    let many: String = (0..=MOST_ROWS).map(|i| format!("P{i} 1\n")).collect();
    let error = ParameterFile::parse(&many).unwrap_err().to_string();
    assert_eq!(error, format!("{}: more than {MOST_ROWS} parameters", MOST_ROWS + 1));
}

/// An odd row beside a good one: what does not matter is passed over, with its line.
#[test]
fn an_odd_row_is_passed_over_with_a_remark() {
    const GOOD: &str = "1\t1\tMC_PITCH_P\t4\t9\n";
    for (row, words) in [
        ("1\t1\tFOO_BAR\tnan\t9", "line 2: no finite number"),
        ("1\t1\tCAL_ACC0_XOFF\tinf\t9", "line 2: no finite number"),
        ("1\t154\tGMB_AXIS\t2\t2", "line 2: type 2, of component 154"),
        ("1\t154\tGMB_AXIS\tx\t9", "line 2: no value, of component 154"),
        ("1\t1\tFOO_BAR\t2\t4", "line 2: type 4, a type that PX4 does not have"),
        ("1\t1\tFOO_BAR\t2\t5", "line 2: type 5, a type that PX4 does not have"),
        ("1\t1\tMC_ROLL_P\t4\t9 # mine", "line 2: a comment behind a row"),
        ("1\t1\tMC_PITCH_P\t4.0\t9", "line 2: a parameter that stands above with the same value"),
        ("2\t1\tMC_PITCH_P\t9\t9", "line 2: of vehicle 2, the file is vehicle 1's"),
        ("# For: the green X500", ""),
    ] {
        let file = ParameterFile::parse(&format!("{GOOD}{row}\n")).unwrap();
        assert_eq!((file.get("MC_PITCH_P"), file.own().count()), (Some(Value::Real(4.0)), 1), "{row}");
        let said = file.remarks().join("; ");
        assert!(said.contains(words) && said.is_empty() == words.is_empty(), "{row}: {said}");
    }
    for comment in ["# For: the green X500", "# For: ardupilot", "# for: px4"] {
        let file = ParameterFile::parse(&format!("{comment}\n{GOOD}")).unwrap();
        assert_eq!(file.purpose(), None, "{comment}");
        assert_eq!(file.remarks().len(), usize::from(comment.starts_with("# For")), "{comment}");
    }
    let file = ParameterFile::parse(&format!("# For: px4\n{GOOD}")).unwrap();
    assert_eq!((file.purpose(), file.remarks().len()), (Some(Purpose::Px4), 0));
}

/// As MAVProxy, comma-separated values, `param show`, an airframe's script and PX4's environment have them.
#[test]
fn other_formats_say_the_same() {
    let shown = "Symbols: x = used, + = saved, * = unsaved\nx + MC_PITCH_P [406,683] : 6.5000\n\
                 x   SYS_AUTOSTART [2,3] : 4001\n    A_B [1,2] : <unknown type 7>\n\n 723 / 1071 parameters used.\n";
    let script = "#!/bin/sh\n# @name X500\n. ${R}etc/init.d/rc.mc_defaults\nset MIXER quad_x\n\
                  param set-default MC_PITCH_P 6.5 # pitch\nparam set SYS_AUTOSTART 4001\n";
    for (text, remark) in [
        ("MC_PITCH_P       6.500000\nSYS_AUTOSTART    4001.000000\n", None),
        ("# mine\nMC_PITCH_P,6.5\r\nSYS_AUTOSTART,4001\r\n", None),
        ("name,value\nMC_PITCH_P, 6.5\nSYS_AUTOSTART, 4001\n", None),
        (shown, Some("line 2: `param show` prints four decimals only")),
        (script, Some("lines 3, 4: sets no parameter: passed over")),
        ("pxh> param set MC_PITCH_P 6.5\npxh> param set SYS_AUTOSTART 4001\n", None),
        ("export PX4_PARAM_MC_PITCH_P=6.5\nPX4_PARAM_SYS_AUTOSTART=4001\n", None),
    ] {
        let file = ParameterFile::parse(text).unwrap();
        assert_eq!(file.get("MC_PITCH_P"), Some(Value::Real(6.5)), "{text}");
        assert_eq!((file.get("SYS_AUTOSTART"), file.len()), (Some(Value::Int(4001)), 2), "{text}");
        assert_eq!(file.remarks().first().map(String::as_str), remark, "{text}");
        assert!(check(Against::newest(), None, file.own().map(|(n, e)| (n, e.value))).passes(), "{text}");
    }
    for px4s in [shown, script] {
        assert!(ParameterFile::parse(px4s).unwrap().is_of_px4());
    }
    let runs = ParameterFile::parse(script).unwrap();
    assert_eq!(runs.scripts(), [(3, "${R}etc/init.d/rc.mc_defaults".to_owned())]);
    let alone = ParameterFile::parse("#!/bin/sh\nPX4_SIM_MODEL=x\n. ${R}etc/4001_x\n").unwrap();
    assert_eq!((alone.len(), alone.scripts()), (0, &[(3, "${R}etc/4001_x".to_owned())][..]));
    let later = "param set-default MC_PITCH_P 4\nparam set MC_PITCH_P 5\nparam set CAL_ACC0_ID ${ID}\n\
                 if [ $A = yes ]\nthen\nparam set MC_ROLL_P 3\nfi\n";
    let file = ParameterFile::parse(later).unwrap();
    assert_eq!(
        (file.get("MC_PITCH_P"), file.get("MC_ROLL_P")),
        (Some(Value::Real(5.0)), Some(Value::Real(3.0)))
    );
    let said = file.remarks().join("; ");
    for words in ["line 2: a parameter that stands above", "line 3: a variable", "line 6: under an `if`"] {
        assert!(said.contains(words), "{said}");
    }
}

/// What is not read is named.
#[test]
fn a_format_that_is_not_read_is_named() {
    let mut bson = vec![40, 0, 0, 0, 0x10];
    bson.extend(b"SYS_AUTOSTART\0\xa1\x0f\0\0\x01MC_PITCH_P\0");
    let ardupilot = "# Stack: ArduPilot\n1\t1\tATC_RAT_PIT_P\t0.1\t9\n1\t1\tFRAME_CLASS\t1\t2\n";
    let mission_planner = "#NOTE: x\nAHRS_EKF_TYPE,3\nATC_RAT_PIT_P,0.135\nRC1_MIN,1000\n";
    for (bytes, words) in [
        (&b"ULog\x01\x12\x35\x01\0\0"[..], "no ULog: it begins with"),
        (&bson[..], "BSON"),
        (b"\xff\xfe1\0", "UTF-16"),
        (b"1\t1\tA\t\xff", "byte 7 is not UTF-8"),
        (ardupilot.as_bytes(), "ArduPilot's parameters, by the line `# Stack: ArduPilot`"),
        (mission_planner.as_bytes(), "ArduPilot's parameters, by their names (AHRS_EKF_TYPE"),
    ] {
        let error = ParameterFile::read(bytes).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // PX4's log of a PX4 has such names, too.
    assert!(ParameterFile::parse("RC1_MIN,1000\nMC_PITCH_P,4\nFS_X,1\n").is_ok());
}

proptest! {
    #[test]
    fn prop_the_reader_never_panics(text in "\\PC*") {
        let _ = ParameterFile::parse(&text);
    }

    #[test]
    fn prop_nor_on_what_looks_like_rows(
        rows in prop::collection::vec(("[0-9#x ]{0,3}", "[0-9]{0,4}", "\\PC{0,18}", "[-+.0-9eEnaif]{0,25}", "[0-9]{0,2}"), 0..6),
        end in prop::sample::select(vec!["\n", "\r\n", "\r"]),
    ) {
        let text: Vec<String> = rows.iter().map(|(a, b, c, d, e)| format!("{a}\t{b}\t{c}\t{d}\t{e}")).collect();
        let _ = ParameterFile::parse(&text.join(end));
    }

    /// Every float down to 1e-10 comes back to the bit.
    #[test]
    fn prop_what_is_written_is_read(
        values in prop::collection::btree_map("[A-Z][A-Z0-9_]{0,15}", prop_oneof![
            any::<i32>().prop_map(Value::Int),
            any::<f32>().prop_filter("18 decimals", |x| x.abs() > 1e-10 && x.is_finite() || *x == 0.0).prop_map(Value::Real),
        ], 0..20),
    ) {
        let file = ParameterFile::parse(&write("x", &[], &values)).unwrap();
        prop_assert_eq!(file.len(), values.len());
        for (name, value) in &values {
            prop_assert_eq!(file.get(name), Some(*value));
        }
    }
}
