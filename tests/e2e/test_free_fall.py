"""The release found by the fall, in three processes over sockets: the streamer asks for HIGHRES_IMU and looks by itself."""

import re

FALL = re.compile(r"falls since ([0-9.]+) s by its accelerometer, found at ([0-9.]+) s")


def test_a_drop_without_a_wire(samara, mission):
    """Released by the parachute's own clock; the plan begins half a second after the fall that was found, on telemetry."""

    def nearer(keys):
        keys.pop("px4_params")
        keys["release"]["hang_s"] = 6
        keys["duration_s"] = 20

    path = mission("x500_no_wire", nearer)
    stream = samara.stream(path)
    samara.autopilot(path, "--once")
    sim = samara.sim(path, "--speed", 2, "--json")
    stream.says("plan at its end")
    code = sim.ends()
    stream.ends()
    [(began, found)] = [match.groups() for match in map(FALL.search, stream.lines) if match]
    assert abs(float(began) - 6.0) <= 0.02 and 6.08 <= float(found) <= 6.2, (began, found)
    assert not any("released at" in line and ">" not in line for line in stream.lines), stream.lines
    verdict = sim.json()
    assert code == 0 and verdict["limits_passed"] == [] and verdict["steady_after_s"], verdict
