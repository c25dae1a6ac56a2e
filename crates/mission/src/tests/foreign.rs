//! Airframes, parameter files and Gazebo's models: what they say of a vehicle, and what is refused of them.

use nalgebra::{Matrix3, Vector3};

use super::spoil::shipped;
use crate::foreign::{Key, KnownVehicle, known_vehicle};
use samara_core::model::RotationSense;

const QUAD: &str = "sdf/quad";
const POSES: &str = "sdf/poses";
const DIRECTIONS: &str = "airframe/directions";
const METRES: &str = "airframe/metres";
const PAIRS: &str = "airframe/pairs";

/// A kept input of the fuzz targets.
fn kept(name: &str) -> String {
    std::fs::read_to_string(shipped("fuzz/corpus").join(name)).unwrap()
}

/// What files say together; each is a path in one folder, and its text.
fn known(files: &[(&str, &str)], of: &[&str]) -> Result<KnownVehicle, String> {
    let folder = tempfile::tempdir().unwrap();
    for (path, text) in files {
        let path = folder.path().join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let of: Vec<_> = of.iter().map(|file| folder.path().join(file)).collect();
    let here = format!("{}/", folder.path().display());
    known_vehicle(&of).map_err(|error| error.to_string().replace(&here, ""))
}

fn one(path: &str, text: &str) -> Result<KnownVehicle, String> {
    known(&[(path, text)], &[path])
}

/// What the kept file says once it is changed.
fn spoilt(name: &str, from: &str, to: &str) -> Result<KnownVehicle, String> {
    let text = kept(name);
    assert!(text.contains(from), "{name} has no {from}");
    one("it", &text.replacen(from, to, 1))
}

/// Inertia of point masses and of what turns with them about their common centre of mass.
fn together(parts: &[(f64, [f64; 3], [f64; 3])]) -> (f64, Matrix3<f64>) {
    let mass: f64 = parts.iter().map(|(mass, ..)| mass).sum();
    let at = parts.iter().map(|(mass, at, _)| Vector3::from(*at) * *mass).sum::<Vector3<f64>>() / mass;
    let of = |(mass, place, own): &(f64, [f64; 3], [f64; 3])| {
        let [x, y, z]: [f64; 3] = (Vector3::from(*place) - at).into();
        let [xx, yy, zz] = *own;
        Matrix3::new(
            xx + mass * (y * y + z * z),
            -mass * x * y,
            -mass * x * z,
            -mass * x * y,
            yy + mass * (x * x + z * z),
            -mass * y * z,
            -mass * x * z,
            -mass * y * z,
            zz + mass * (x * x + y * y),
        )
    };
    (mass, parts.iter().map(of).sum())
}

/// By hand: 1.4 kg with Jxz 0.0004 in forward, left, up, and four rotors of 20 g 5 cm above.
#[test]
fn closed_form_a_model_is_one_body_with_its_rotors() {
    let all = one("quad/model.sdf", &kept(QUAD)).unwrap();
    let up = 4.0 * 0.02 * 0.05 / 1.48;
    assert!((all.number(Key::Mass).unwrap() - 1.48).abs() < 1e-12);
    let level = 4.0 * 0.02 * 0.18 * 0.18;
    let high = 1.4 * up * up + 4.0 * 0.02 * (0.05 - up) * (0.05 - up);
    let inertia = all.inertia_kg_m2.clone().unwrap();
    let by_hand = [
        0.015 + 4.0 * 2e-6 + level + high,
        0.016 + 4.0 * 3.2e-5 + level + high,
        0.028 + 4.0 * 3.3e-5 + 2.0 * level,
        0.0,
        -0.0004,
        0.0,
    ];
    for (found, expected) in inertia.value.iter().zip(by_hand) {
        assert!((found - expected).abs() < 1e-12, "{:?}", inertia.value);
    }
    assert_eq!(
        (inertia.file.as_str(), inertia.words.as_str()),
        ("quad/model.sdf", "inertia of link base and 4 others, about their centre of mass")
    );
    let rotors = &all.rotors.as_ref().unwrap().value;
    assert!(rotors.in_metres);
    let signs = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];
    for (i, (rotor, (x, y))) in rotors.rotors.iter().zip(signs).enumerate() {
        let expected = Vector3::new(0.18 * x, 0.18 * y, up - 0.05);
        assert!((rotor.position_body_m - expected).norm() < 1e-11, "{i}: {}", rotor.position_body_m);
        assert_eq!(rotor.axis_body, -Vector3::z());
        assert_eq!(rotor.spin, if i < 2 { RotationSense::Ccw } else { RotationSense::Cw });
    }
    for (key, value) in [
        (Key::Thrust, 8e-6),
        (Key::Torque, 0.016),
        (Key::Drag, 8e-5),
        (Key::OmegaMax, 950.0),
        (Key::TauUp, 0.0125),
        (Key::TauDown, 0.025),
        (Key::RotorInertia, 3.3e-5),
        (Key::Radius, 0.12),
    ] {
        assert_eq!(all.number(key), Some(value), "{key:?}");
    }
    assert_eq!(all.remarks, Vec::<String>::new());
}

/// By hand, forward, left, up: poses in degrees, as quaternions, relative to frames, joints and models, and
/// the pose of an inclusion in place of the included model's own.
#[test]
fn closed_form_links_are_where_their_poses_say() {
    let elsewhere = "<sdf version='1.9'><model name='elsewhere'><pose>9 9 9 1 1 1</pose><link name='far'><inertial>\
                     <mass>4</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia></inertial></link>\
                     </model></sdf>";
    let files = [("poses/model.sdf", &*kept(POSES)), ("elsewhere/elsewhere.sdf", elsewhere)];
    let all = known(&files, &["poses/model.sdf"]).unwrap();
    let (own, turned) = ([0.01, 0.02, 0.025], [0.02, 0.01, 0.025]);
    let (mass, matrix) = together(&[
        (1.0, [0.0, 1.0, 0.3], turned),
        (1.0, [0.0, 1.0, 1.0], own),
        (2.0, [-0.5, 1.2, 0.1], turned),
        (4.0, [0.0, 0.0, 1.0], [0.1; 3]),
    ]);
    assert_eq!(all.number(Key::Mass), Some(mass));
    let [xx, yy, zz, xy, xz, yz] = all.inertia_kg_m2.unwrap().value;
    let found = Matrix3::new(xx, -xy, -xz, -xy, yy, yz, -xz, yz, zz);
    assert!((found - matrix).amax() < 1e-10, "{found} {matrix}");
}

/// PX4's forms: scripts with and without a number of rotors, pairs above one another, KM of PX4's own.
#[test]
fn airframes_say_where_the_rotors_are() {
    let all =
        one("4901_ours", &kept(DIRECTIONS).replace("param set-default CA_ROTOR_COUNT 4\n", "")).unwrap();
    let rotors = all.rotors.clone().unwrap();
    assert!(!rotors.value.in_metres && all.numbers.is_empty());
    assert_eq!(rotors.value.rotors[2].spin, RotationSense::Cw);
    let arm = rotors.value.with_arm(0.25);
    assert!((arm.rotors[0].position_body_m - Vector3::new(0.125, 0.125, 0.0) * 2f64.sqrt()).norm() < 1e-12);
    let all = one("4601_ours", &kept(METRES)).unwrap();
    let rotors = all.rotors.clone().unwrap();
    assert_eq!(rotors.value.rotors[0].position_body_m, Vector3::new(0.0762, 0.09525, 0.0));
    assert_eq!((all.number(Key::Hover), all.number(Key::Torque)), (Some(0.22), Some(0.016)));
    assert_eq!(
        (rotors.file.split('/').next_back(), &*rotors.words),
        (Some("4601_ours"), "CA_ROTOR0 to CA_ROTOR3")
    );
    let all = one("11001_ours", &kept(PAIRS)).unwrap();
    assert_eq!(all.number(Key::Torque), None);
    assert!(
        all.remarks[0].contains("arms of 0.5 m, which PX4's generic airframes have"),
        "{:?}",
        all.remarks
    );
    // An airframe runs the one beside it, and stands before it.
    let runs =
        "PX4_SIM_MODEL=x\n. ${R}etc/init.d-posix/airframes/4001_ours\nparam set-default CA_ROTOR1_PX -0.5\n";
    let all = known(&[("4002_more", runs), ("4001_ours", &kept(METRES))], &["4002_more"]).unwrap();
    let rotors = all.rotors.unwrap().value.rotors;
    assert_eq!([0, 1].map(|i| rotors[i].position_body_m.x), [0.0762, -0.5]);
    let remarks = one("4002_more", runs).unwrap().remarks.join("; ");
    assert!(remarks.contains("runs 4001_ours, which is not beside it: passed over"), "{remarks}");
}

/// The later file stands, but metres stand before directions.
#[test]
fn files_that_disagree_are_told() {
    let (quad, directions, metres) = (kept(QUAD), kept(DIRECTIONS), kept(METRES));
    let heavier = quad.replace("<mass>1.4<", "<mass>2.4<").replace("0.016</moment", "0.02</moment");
    let all: [(&str, &str); 4] =
        [("a/model.sdf", &quad), ("b/model.sdf", &heavier), ("4001_x", &directions), ("4601_x", &metres)];
    for of in [["a/model.sdf", "4001_x"], ["4001_x", "a/model.sdf"]] {
        let found = known(&all, &of).unwrap();
        assert!(found.rotors.unwrap().value.in_metres && found.remarks.is_empty());
    }
    let found = known(&all, &["a/model.sdf", "b/model.sdf"]).unwrap();
    assert_eq!(found.number(Key::Torque), Some(0.02));
    assert_eq!(found.remarks.len(), 3, "{:?}", found.remarks);
    assert!(
        found.remarks.contains(&"mass_kg: 2.48 of b/model.sdf stands, not 1.48 of a/model.sdf".to_owned())
    );
    let found = known(&all, &["a/model.sdf", "4601_x"]).unwrap();
    assert_eq!(found.rotors.unwrap().value.rotors[0].position_body_m.x, 0.0762);
    let said = found.remarks.join("; ");
    assert!(said.contains("4601_x stands, not a/model.sdf, where they are elsewhere"), "{said}");
}

/// What is wrong is refused with its place.
#[test]
fn what_is_no_multirotor_is_refused_with_its_place() {
    let base = "<inertia><ixx>0.015</ixx><ixy>0</ixy><ixz>0.0004</ixz><iyy>0.016</iyy>";
    for (name, from, to, place, words) in [
        (QUAD, "<mass>1.4", "<mass>NaN", "it:7:9: mass: ", "expected a finite number, found `NaN`"),
        (QUAD, "<mass>1.4", "<mass>1e9", "it:7:9: mass: ", "greater than 0 and at most 100000"),
        (QUAD, "<mass>1.4</mass>", "", "it:6:7: inertial: ", "expected `<mass>`"),
        (QUAD, "<ixx>0.015", "<ixx>0", "it:8:18: ixx: ", "greater than 0"),
        (QUAD, base, &base.replace("0.015", "0.2"), "it:5:5: link base: ", "triangle inequality"),
        (QUAD, "<pose>-0.18 0.18", "<pose>0.18 -0.18", "it:19:5: link rotor_1: ", "at the place of rotor 0"),
        (QUAD, "0.05 0 0 0", "0.05 3.14 0 0", "it:11:5: link rotor_0: ", "expected a rotor that pushes up"),
        (QUAD, "0.05 0 0 0", "0.05 0 0", "it:12:7: pose: ", "expected 6 finite numbers"),
        (
            QUAD,
            "<pose>0.18",
            "<pose relative_to='x'>0.18",
            "it:12:7: pose: ",
            "a link included before, found `x`",
        ),
        (QUAD, "maxRotVelocity>950", "maxRotVelocity>-1", "it:48:7: maxRotVelocity: ", "greater than 0"),
        (QUAD, "8e-06", "9e-06", "it:61:7: motorConstant: ", "expected 0.000009, as motor 0 has it"),
        (QUAD, "<motorNumber>0", "<motorNumber>1", "it:43:5: plugin", "expected the motors 0 to 3"),
        (QUAD, "<linkName>rotor_0", "<linkName>x", "it:43:5: plugin", "the name of a link, found `x`"),
        (QUAD, "Direction>ccw", "Direction>up", "it:45:7: turningDirection: ", "`cw` or `ccw`"),
        (QUAD, "name=\"gz::sim::systems::Mul", "name=\"gz::sim::systems::LiftDrag", "it:43:5: ", "wings"),
        (QUAD, "<sdf version", "<!DOCTYPE a [<!ENTITY b \"c\">]><sdf version", "it:1:1: ", "DTD"),
        (QUAD, "<mass>1.4", "<mass>{{ mass }}", "it:1:1: ", "scripts/jinja_gen.py"),
        (
            POSES,
            "attached_to=\"body\"",
            "",
            "it:1:1: sdf: ",
            "model://elsewhere on line 18 of it (looked for ",
        ),
        (POSES, "model://elsewhere", "https://fuel/x", "it:18:27: uri: ", "expected model://NAME"),
        (DIRECTIONS, "COUNT 4", "COUNT 12", "it:10:1: CA_ROTOR_COUNT: ", "expected 3 to 8 rotors, found 12"),
        (
            DIRECTIONS,
            "COUNT 4",
            "COUNT 5",
            "it:10:1: CA_ROTOR_COUNT: ",
            "CA_ROTOR4_PX and CA_ROTOR4_PY are not",
        ),
        (DIRECTIONS, "1_PX -1\n", "1_PX 1\n", "it:15:1: CA_ROTOR2_PX: ", "rotor 2 is at the place"),
        (
            DIRECTIONS,
            "param set-default MC_ROLLRATE_P 0.14",
            "param set CA_AIRFRAME 2",
            "it:9:1: CA_AIRFRAME: ",
            "VTOL",
        ),
        (DIRECTIONS, "rc.mc_", "rc.heli_", "it:7:1: rc.heli_defaults: ", "multirotors alone"),
        (DIRECTIONS, "3_KM -0.05", "3_AZ 1", "it:18:1: ", "pushes up"),
        (METRES, "0_PX 0.0762", "0_PX 762", "it:13:1: CA_ROTOR0_PX: ", "at most 100 m away"),
        (METRES, "0_PX 0.0762", "0_PX nan", "it:13: value: ", "a finite number"),
        (METRES, "HOVER 0.22", "HOVER 22", "it:10:1: MPC_THR_HOVER: ", "between 0 and 1, found 22"),
    ] {
        let error = spoilt(name, from, to).expect_err(to);
        assert!(error.starts_with(place) && error.contains(words), "{to}: {error}");
    }
    for (path, text, words) in [
        ("a.sdf.jinja", "", "a template"),
        ("a.urdf", "<robot name='a'/>", "found URDF"),
        ("a.json", "{}", "a vehicle file of samara"),
        ("a.sdf", "<sdf version='1.6'><world name='a'/></sdf>", "found a world"),
        ("a.sdf", "<sdf version='1.6'>", "no XML"),
        ("a", "", "says nothing"),
    ] {
        match one(path, text) {
            Ok(found) => assert!(found.remarks[0].contains(words), "{path}: {:?}", found.remarks),
            Err(error) => assert!(error.contains(words), "{path}: {error}"),
        }
    }
}

/// Models that stand in one another or include one another for ever, and airframes that run one another, end.
#[test]
fn what_never_ends_is_refused() {
    let nested =
        format!("<sdf version='1.6'>{}{}</sdf>", "<model name='a'>".repeat(20), "</model>".repeat(20));
    assert!(one("a.sdf", &nested).unwrap_err().contains("more than 16 deep"));
    let deep = format!("<sdf version='1.6'>{}", "<a>".repeat(200_001));
    assert!(one("a.sdf", &deep).unwrap_err().contains("nodes limit"));
    let itself = "<sdf version='1.6'><model name='a'><include><uri>model://a</uri></include></model></sdf>";
    assert!(one("a/model.sdf", itself).unwrap_err().contains("or in a circle"));
    assert!(one("1_a", ". 1_a\n").unwrap_err().contains("more than 8 airframes run one another"));
    let circle = kept(POSES).replace("name=\"deck\"", "name=\"deck\" attached_to=\"body\"");
    assert!(one("a.sdf", &circle).unwrap_err().contains("its pose is relative to itself"));
}
