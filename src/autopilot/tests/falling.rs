//! The release found by the fall.

use super::*;
use crate::control::FreeFallSettings;

/// Without being asked it looks for nothing; asked, it says the fall once, and again after a restart.
#[test]
fn a_fall_is_said_once_in_each_flight() {
    let mut bench = Bench::engaged(level(0.0));
    bench.said();
    let fly = |bench: &mut Bench| {
        let force = |ms: u64| Vector3::new(0.0, 0.0, if ms < 2_000 { -9.81 } else { -0.2 });
        let found: Vec<_> = (0..750).filter_map(|i| bench.autopilot.feel(i * 4_000, &force(4 * i))).collect();
        found
    };
    assert_eq!(fly(&mut bench), []);
    bench.autopilot.look_for_a_fall(FreeFallSettings::of(9.81, 0.3, 0.2, 0.1).unwrap());
    assert_eq!(fly(&mut bench).iter().map(|fall| fall.began_at).collect::<Vec<_>>(), [1_998_000]);
    assert_eq!(bench.said(), ["Falls since 1.998 s, found at 2.096 s"]);
    bench.autopilot.restart();
    bench.said();
    assert_eq!(fly(&mut bench).len(), 1);
}
