"""The autopilot's flight log in the eyes of pyulog, PX4's own reader; the truth beside it is the simulator's CSV."""

import csv
import json
import subprocess

import numpy as np
import pytest
from pyulog import ULog

from programs import MISSION, SAMARA


@pytest.fixture(scope="module")
def log(reference):
    return ULog(str(reference.out / "flight.ulg"))


@pytest.fixture(scope="module")
def truth(reference):
    with open(reference.out / "flight.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return lambda name: np.array([float(row[name]) for row in rows])


def test_the_file_is_whole_and_says_what_it_is(log, reference):
    assert not log.file_corruption and not log.dropouts
    assert log.msg_info_dict["sys_name"] == "samara" and log.msg_info_dict["ver_hw"] == "titan"
    gains = json.loads((MISSION.parent / reference.mission["gains"]).read_text(encoding="utf-8"))
    assert log.initial_parameters["MC_PITCH_P"] == pytest.approx(gains["k_ptheta_per_s"], rel=1e-6)
    said = [entry.message for entry in log.logged_messages]
    assert "armed" in said and "mode OFFBOARD" in said


def test_the_flown_states_are_the_simulators(log, truth):
    attitude = log.get_dataset("vehicle_attitude").data
    position = log.get_dataset("vehicle_local_position").data
    for data, columns in [
        (attitude, {"q[0]": "q0", "q[2]": "q2"}),
        (position, {"z": "down_m", "vx": "vn_m_s", "vz": "vd_m_s"}),
    ]:
        for field, column in columns.items():
            expected = np.interp(data["timestamp"] * 1e-6, truth("t_s"), truth(column))
            assert data[field] == pytest.approx(expected, abs=1e-4, rel=1e-5), field
    times = attitude["timestamp"]
    assert set(np.diff(times.astype(np.int64))) == {4000}


def test_commands_and_conditions_tell_the_drop(log, reference):
    motors = log.get_dataset("actuator_motors").data
    t = motors["timestamp"] * 1e-6
    assert np.all(motors["control[0]"][t < 10.4] == 0) and motors["control[0]"][t > 20].min() > 0.3
    status = log.get_dataset("vehicle_status").data
    assert (status["arming_state"][-1], status["nav_state"][-1]) == (2, 14)
    fall = log.get_dataset("vehicle_land_detected").data
    t = fall["timestamp"] * 1e-6
    assert fall["freefall"][(t > 10.1) & (t < 10.4)].all() and not fall["freefall"][t < 9.9].any()
    gps = log.get_dataset("vehicle_gps_position").data
    assert gps["time_utc_usec"][0] == reference.mission["epoch_unix_us"] + gps["timestamp"][0]


def test_on_the_estimator_the_truth_is_logged_beside_it(tmp_path):
    mission = MISSION.parent / "x500_drop.json"
    subprocess.run([SAMARA, "drop", mission, "--estimator", "ekf", "--out", tmp_path], check=True, capture_output=True)
    log = ULog(str(tmp_path / "flight.ulg"))
    assert log.initial_parameters["EKF2_EN"] == 1 and log.initial_parameters["EKF2_GPS_DELAY"] == 110
    assert "estimator aligned" in [entry.message for entry in log.logged_messages]
    estimate = log.get_dataset("vehicle_local_position").data
    truth = log.get_dataset("vehicle_local_position_groundtruth").data
    assert np.array_equal(estimate["timestamp"], truth["timestamp"])
    aligned = estimate["timestamp"] > 5e6
    for field, within in [("x", 1.5), ("z", 2.5), ("vx", 0.3), ("vz", 0.3), ("heading", 0.1)]:
        error = (estimate[field] - truth[field])[aligned]
        assert 0 < np.abs(error).max() < within, field
    assert (estimate["eph"][aligned] > 0).all() and not truth["eph"].any()
