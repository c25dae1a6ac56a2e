//! The parameter file: bytes, other programs' files, refusals, no panic.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::file::write;
use super::*;

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
    let remark = |text: &str| ParameterFile::parse(text).unwrap().remarks().join("; ");
    assert!(remark("7\t1\tMC_PITCH_P\t4\t9").contains("vehicle id 7"));
    assert!(remark("1 1 MC_PITCH_P 4 9").contains("tabs"));
    assert!(remark("1\t154\tMC_PITCH_P\t4\t9").contains("154"));
    assert_eq!(ParameterFile::parse("1\t154\tMC_PITCH_P\t4\t9").unwrap().get("MC_PITCH_P"), None);
}

#[test]
fn what_is_wrong_is_refused_with_its_line() {
    for (text, expected) in [
        ("1\t1\tMC_PITCH_P\t4.0", "1: expected five columns"),
        ("\n# x\n1\t1\tMC_PITCH_P\t4,0\t9", "3: value: expected a finite number"),
        ("1\t1\tMC_PITCH_P\tnan\t9", "1: value: expected a finite number"),
        ("1\t1\tMC_PITCH_P\t1e39\t9", "1: value: expected a finite number"),
        ("1\t1\tSYS_AUTOSTART\t4001.5\t6", "1: value: expected a 32-bit whole number"),
        ("1\t1\tSYS_AUTOSTART\t2147483648\t6", "1: value: expected a 32-bit whole number"),
        ("1\t1\tMC_PITCH_P\t4\t10", "1: type: expected 6"),
        ("1\t1\tMC_PITCH_PROPORTIONAL\t4\t9", "1: name: expected"),
        ("256\t1\tMC_PITCH_P\t4\t9", "1: vehicle id: expected"),
        ("1\tx\tMC_PITCH_P\t4\t9", "1: component id: expected"),
        ("1\t1\tA\t4\t9\r\n1\t1\tA\t4\t9", "2: A stands on line 1 already"),
        ("# For: ardupilot", "1: `For:` must be"),
        ("{\"json\": true}", "1: expected five columns"),
    ] {
        let error = ParameterFile::parse(text).unwrap_err().to_string();
        assert!(error.starts_with(expected), "{text:?}: {error}");
    }
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
