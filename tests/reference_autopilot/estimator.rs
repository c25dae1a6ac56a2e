//! The autopilot on its own estimator: what it tells while it aligns, flies and loses its satellites. The
//! vehicle stands; its truth is told from elsewhere, so that whoever looks at it is found out.

use mavlink::dialects::common::*;
use samara::autopilot::estimator::EstimatorSettings;
use samara::link::{Link, LogEntry};
use samara::model::magnetic_field::dipole_ned_gauss;
use samara::params::Value;
use samara::sim::sensors::barometer::pressure_hpa;

use super::bench::{Bench, Sent, acks, command, last, site, texts};
use super::parameters::set;

const ACCEPTED: u8 = 0;
const TEMPORARILY_REJECTED: u8 = 1;
const AT_REST: HIL_GPS_DATA = HIL_GPS_DATA {
    time_usec: 0,
    lat: 125_000_000,
    lon: -342_500_000,
    alt: 1_510_000,
    eph: 90,
    epv: 120,
    vel: 0,
    vn: 0,
    ve: 0,
    vd: 0,
    cog: u16::MAX,
    fix_type: 3,
    satellites_visible: 12,
    id: 0,
    yaw: 0,
};

/// 10 m above the anchor, nose north; the truth says 100 m further north.
struct Stand {
    bench: Bench,
    gps: Option<HIL_GPS_DATA>,
}

impl Stand {
    fn new() -> Self {
        let field = dipole_ned_gauss(site().anchor.latitude_deg);
        let mut bench = Bench::on(Some(EstimatorSettings::at_site(site().gravity_m_s2, field)));
        (bench.state.x, bench.state.z) = (100.0, -10.0);
        Self { bench, gps: Some(AT_REST) }
    }

    fn run(&mut self, seconds: f64) -> Vec<Sent> {
        let field = dipole_ned_gauss(site().anchor.latitude_deg).map(|x| x as f32);
        let mut sent = Vec::new();
        for _ in 0..(seconds * 250.0).round() as usize {
            self.bench.now += 4_000;
            let time_usec = self.bench.now;
            sent.extend(self.bench.wait());
            let odometry = ODOMETRY_DATA { time_usec, ..self.bench.state.clone() };
            sent.extend(self.bench.send(Link::Simulator, &MavMessage::ODOMETRY(odometry)));
            if let Some(gps) = self.gps.clone().filter(|_| time_usec.is_multiple_of(100_000)) {
                let gps = HIL_GPS_DATA { time_usec, ..gps };
                sent.extend(self.bench.send(Link::Simulator, &MavMessage::HIL_GPS(gps)));
            }
            let sensor = HIL_SENSOR_DATA {
                time_usec,
                zacc: -1.35,
                xmag: field.x,
                ymag: field.y,
                zmag: field.z,
                abs_pressure: pressure_hpa(1510.0) as f32,
                fields_updated: HilSensorUpdatedFlags::from_bits_retain(0x1BFF),
                ..HIL_SENSOR_DATA::default()
            };
            sent.extend(self.bench.send(Link::Simulator, &MavMessage::HIL_SENSOR(sensor)));
        }
        sent
    }

    /// The answer to a wish to arm, and what was said.
    fn arm(&mut self) -> (u8, Vec<String>) {
        let sent = self.bench.send(Link::Api, &command(MavCmd::MAV_CMD_COMPONENT_ARM_DISARM, &[1.0]));
        (acks(&sent)[0].result, texts(&sent, Link::Api))
    }

    fn status(sent: &[Sent]) -> ESTIMATOR_STATUS_DATA {
        match last(sent, Link::GroundStation, 230) {
            Some(MavMessage::ESTIMATOR_STATUS(m)) => m,
            other => panic!("{other:?}"),
        }
    }

    /// Bits of SYS_STATUS that are not healthy.
    fn ailing(sent: &[Sent]) -> u32 {
        match last(sent, Link::GroundStation, 1) {
            Some(MavMessage::SYS_STATUS(m)) => 0x1000_002F & !m.onboard_control_sensors_health.bits(),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn without_satellites_it_never_aligns_and_says_why() {
    let mut stand = Stand::new();
    stand.gps = None;
    let sent = stand.run(20.0);
    let said = texts(&sent, Link::GroundStation);
    assert_eq!(said, ["15 s not aligned: estimator waits for a GPS fix"]);
    assert_eq!(Stand::ailing(&sent), 0x1000_0020);
    assert!(last(&sent, Link::Api, 30).is_none(), "no attitude is told that is not known");
    let (result, said) = stand.arm();
    assert_eq!(result, TEMPORARILY_REJECTED);
    assert_eq!(said, ["Arming denied: estimator waits for a GPS fix"]);
    // A fix that is none, or of the future, is none.
    for gps in [HIL_GPS_DATA { fix_type: 2, ..AT_REST }, AT_REST] {
        stand.gps = None;
        let early = HIL_GPS_DATA { time_usec: stand.bench.now + 9_000_000, ..gps };
        stand.bench.send(Link::Simulator, &MavMessage::HIL_GPS(early));
        stand.run(1.0);
        assert_eq!(stand.arm().0, TEMPORARILY_REJECTED);
    }
}

#[test]
fn it_aligns_and_what_is_sent_is_the_estimate() {
    let mut stand = Stand::new();
    let sent = stand.run(0.2);
    assert!(last(&sent, Link::Api, 230).is_none());
    assert_eq!(stand.arm().1, ["Arming denied: estimator is starting"]);
    stand.run(0.3);
    assert_eq!(stand.arm().1, ["Arming denied: estimator: tilt uncertain"], "of the swing's 10 deg");
    let sent = stand.run(14.0);
    assert_eq!(texts(&sent, Link::GroundStation), ["estimator aligned"]);
    assert_eq!((stand.arm().0, Stand::ailing(&sent)), (ACCEPTED, 0));
    let status = Stand::status(&sent);
    assert_eq!(status.flags.bits(), 0x033F);
    assert!(status.pos_horiz_accuracy > 0.0 && status.pos_horiz_accuracy < 0.9, "{status:?}");
    assert!(
        [status.vel_ratio, status.pos_horiz_ratio, status.pos_vert_ratio, status.mag_ratio]
            .iter()
            .all(|r| *r < 1.0)
    );
    // Where the fixes are, and not where the truth is.
    let sent = stand.run(2.0);
    let Some(MavMessage::LOCAL_POSITION_NED(local)) = last(&sent, Link::Api, 32) else { panic!() };
    assert!(local.x.abs() < 0.5 && (local.z + 10.0).abs() < 0.5, "{local:?}");
    let Some(MavMessage::GLOBAL_POSITION_INT(global)) = last(&sent, Link::Api, 33) else { panic!() };
    // 1e-7 deg is 1.1 cm.
    assert!(global.lat.abs_diff(AT_REST.lat) < 45 && global.alt.abs_diff(AT_REST.alt) < 500, "{global:?}");
    let Some(MavMessage::HOME_POSITION(home)) = last(&sent, Link::Api, 242) else { panic!() };
    assert!(home.x.abs() < 0.5 && home.latitude.abs_diff(AT_REST.lat) < 45, "{home:?}");
    let Some(MavMessage::ODOMETRY(odometry)) = last(&sent, Link::Api, 331) else { panic!() };
    assert!(odometry.x.abs() < 0.5 && odometry.q[0] > 0.999, "{odometry:?}");
    // The log has both.
    let step = std::iter::from_fn(|| stand.bench.session.poll_log()).filter_map(|entry| match entry {
        LogEntry::Step(record) => Some(record),
        _ => None,
    });
    let record = step.last().unwrap();
    assert!(record.estimate.p_ned.x.abs() < 0.5 && record.truth.p_ned.x == 100.0);
    assert!(record.accuracy.is_some());
}

#[test]
fn lost_satellites_are_reported_and_found_again() {
    let mut stand = Stand::new();
    stand.run(15.0);
    stand.gps = None;
    let sent = stand.run(4.0);
    assert_eq!(texts(&sent, Link::GroundStation), Vec::<String>::new());
    let sent = stand.run(4.0);
    assert_eq!(texts(&sent, Link::GroundStation), ["estimator: no GPS fix it believes"]);
    assert_eq!(Stand::ailing(&sent), 0x1000_0020);
    assert_eq!(Stand::status(&sent).flags.bits() & 0x0338, 0, "the position is not known any more");
    assert_eq!(stand.arm().1, ["Arming denied: estimator: no GPS fix it believes"]);
    stand.gps = Some(AT_REST);
    assert_eq!(texts(&stand.run(2.0), Link::GroundStation), ["estimator aligned"]);
    assert_eq!(stand.arm().0, ACCEPTED);
}

#[test]
fn a_simulator_that_starts_over_begins_a_new_filter() {
    let mut stand = Stand::new();
    stand.run(15.0);
    let late = set("EKF2_GPS_DELAY", 120.0, MavParamType::MAV_PARAM_TYPE_REAL32);
    stand.bench.send(Link::GroundStation, &late);
    let settings = |stand: &Stand| *stand.bench.session.estimator().unwrap().settings();
    assert_eq!(settings(&stand).gps_delay_us, 0, "not in flight");
    stand.bench.now = 0;
    let sent = stand.run(0.1);
    assert!(last(&sent, Link::Api, 30).is_none(), "the attitude before is no attitude now");
    assert_eq!(settings(&stand).gps_delay_us, 120_000);
    assert_eq!(stand.arm().0, TEMPORARILY_REJECTED);
    stand.run(15.0);
    assert_eq!(stand.arm().0, ACCEPTED);
}

#[test]
fn the_choice_is_a_parameter_that_cannot_be_changed_in_flight() {
    let choice = |bench: &Bench| bench.session.parameters().get("EKF2_EN").unwrap();
    let mut stand = Stand::new();
    assert_eq!((choice(&stand.bench), choice(&Bench::new())), (Value::Int(1), Value::Int(0)));
    stand.run(0.1);
    let truth = set("EKF2_EN", f32::from_bits(0), MavParamType::MAV_PARAM_TYPE_INT32);
    let said = stand.bench.send(Link::GroundStation, &truth);
    assert_eq!(texts(&said, Link::GroundStation), ["EKF2_EN refused: read-only: from --estimator"]);
    assert_eq!(choice(&stand.bench), Value::Int(1));
}
