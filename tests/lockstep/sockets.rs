//! A drop with every party behind its sockets, as in three terminals, is the drop in memory.

use std::time::Duration;

use samara::link::shell::{
    AfterSimulator, Attendance, Notice, Ports, Speed, Wiring, run_autopilot, run_simulator, run_streamer,
};

use super::bench::{autopilot, drop_on_the_wire, simulator, streamer};
use super::verdict;

/// Ports that nobody has.
fn free_ports() -> Ports {
    let sockets = [(); 7].map(|()| std::net::UdpSocket::bind("127.0.0.1:0").unwrap());
    let [simulator, autopilot_ground, ground_station, autopilot_api, api, parachute, viewer] =
        sockets.each_ref().map(|s| s.local_addr().unwrap().port());
    Ports { simulator, autopilot_ground, ground_station, autopilot_api, api, parachute, viewer }
}

/// UDP is outside the lockstep: what the streamer sends may come a step or two later.
#[test]
fn closed_form_three_terminals_fly_the_drop_of_the_wire_in_memory() {
    let ports = free_ports();
    let viewer = std::net::UdpSocket::bind(("127.0.0.1", ports.viewer)).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let quiet = || |_: Notice| ();
    let (mut a, mut b, mut c) = (quiet(), quiet(), quiet());
    let wiring = Wiring::default();
    let never = std::future::pending;
    let flown = runtime.block_on(async {
        let drop = async {
            let (flown, _, _) = tokio::join!(
                run_simulator(
                    simulator(),
                    &ports,
                    (Speed::Factor(10.0), Attendance::default()),
                    None,
                    &mut a,
                    never()
                ),
                run_autopilot(autopilot(), &ports, &wiring, AfterSimulator::Return, &mut b, never()),
                async {
                    let patience = tokio::time::sleep(Duration::from_secs(6));
                    run_streamer(streamer(), &ports, None, &mut c, patience).await
                },
            );
            flown.unwrap()
        };
        tokio::time::timeout(Duration::from_secs(60), drop).await.unwrap()
    });
    let (sockets, memory) = (verdict(flown.run().log()), verdict(&drop_on_the_wire(|_, _, _| {}).log));
    assert!(
        (sockets.outcome.j_tpf / memory.outcome.j_tpf - 1.0).abs() < 0.02,
        "{} {}",
        sockets.outcome.j_tpf,
        memory.outcome.j_tpf
    );
    assert!((sockets.outcome.final_v_ned() - memory.outcome.final_v_ned()).norm() < 0.01);
    watched(&viewer);
}

/// A viewer (PX4's Hawkeye) wants to know what flies, and then its state, as often as the autopilot asks for
/// it: every second step, once it has.
fn watched(viewer: &std::net::UdpSocket) {
    viewer.set_nonblocking(true).unwrap();
    let (mut decoder, mut ids, mut times_us) = (samara::link::Decoder::new(), Vec::new(), Vec::new());
    let mut datagram = [0; 512];
    for _ in 0..60 {
        let length = viewer.recv(&mut datagram).unwrap();
        decoder.datagram(&datagram[..length], |frame| {
            ids.push(frame.message_id);
            if frame.message_id == 115 {
                times_us.push(frame.payload().u64(0));
            }
        });
    }
    assert!(ids[0] == 0 && ids[1..].iter().all(|id| *id == 115), "{ids:?}");
    let steady = times_us.iter().skip_while(|t| **t < 100_000).collect::<Vec<_>>();
    assert!(steady.len() > 2 && steady.windows(2).all(|pair| *pair[1] == pair[0] + 8_000), "{times_us:?}");
}
