"""The autopilot's flight log in the eyes of pyulog, PX4's own reader; the truth beside it is the simulator's CSV."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pyulog import ULog

from programs import MISSION, REPOSITORY, SAMARA


REVIEW = os.environ.get("SAMARA_FLIGHT_REVIEW")
# Topics and fields that Flight Review reads of a multirotor's log (PX4/flight_review 26c87079, app/plot_app: configured_plots.py,
# pid_analysis_plots.py, plotted_tables.py, helper.py) and that a vehicle without sticks, rangefinder or ESC telemetry has; and those
# that the report of PyPI's ulogr 0.1.0 reads beside (cli.py).
READ = {
    "actuator_motors": ["control[0]", "control[3]"],
    "actuator_outputs": ["output[0]", "output[3]"],
    "battery_status": ["voltage_v", "current_a", "discharged_mah", "remaining"],
    "estimator_status": ["health_flags", "timeout_flags", "innovation_check_flags", "time_slip", "mag_test_ratio", "hgt_test_ratio",
                         "gps_check_fail_flags", "filter_fault_flags"],
    "sensor_combined": ["accelerometer_m_s2[0]", "gyro_rad[2]"],
    "vehicle_air_data": ["baro_alt_meter"],
    "vehicle_angular_velocity": ["xyz[0]", "xyz[1]", "xyz[2]"],
    "vehicle_attitude": ["q[0]", "q[3]"],
    "vehicle_attitude_groundtruth": ["q[0]"],
    "vehicle_attitude_setpoint": ["q_d[0]", "q_d[3]"],
    "vehicle_global_position": ["lat", "lon", "alt"],
    "vehicle_gps_position": ["altitude_msl_m", "latitude_deg", "longitude_deg", "eph", "epv", "fix_type", "satellites_used",
                             "vel_m_s", "time_utc_usec"],
    "vehicle_imu_status": ["accel_vibration_metric"],
    "vehicle_local_position": ["x", "y", "z", "vx", "vy", "vz"],
    "vehicle_local_position_groundtruth": ["x", "y"],
    "vehicle_local_position_setpoint": ["x", "y", "z", "vx", "vy", "vz"],
    "vehicle_magnetometer": ["magnetometer_ga[0]", "magnetometer_ga[2]"],
    "vehicle_rates_setpoint": ["roll", "pitch", "yaw"],
    "vehicle_status": ["arming_state", "nav_state", "vehicle_type", "failsafe", "failsafe_and_user_took_over"],
    "vehicle_thrust_setpoint": ["xyz[0]", "xyz[1]", "xyz[2]"],
    "vehicle_torque_setpoint": ["xyz[0]", "xyz[1]", "xyz[2]"],
}


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
    mission = REPOSITORY / "mission" / "x500_drop.json"
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
    battery = log.get_dataset("battery_status").data
    assert battery["connected"].all() and battery["remaining"][-1] < battery["remaining"][0] <= 1.0
    loaded = battery["current_a"] > 5.0
    assert loaded.any() and battery["voltage_v"][loaded].mean() < battery["voltage_v"][0]


def test_the_log_has_what_flight_review_reads(log):
    topics = {topic.name: topic.data for topic in log.data_list}
    missing = [(topic, field) for topic, fields in READ.items() for field in fields if field not in topics.get(topic, {})]
    assert not missing
    # By which it knows the names of today's fields, and how long the vehicle has flown before.
    assert log.msg_info_dict["ver_data_format"] == 2
    assert [log.initial_parameters[f"LND_FLIGHT_T_{half}"] for half in ("HI", "LO")] == [0, 0]


def test_what_identification_tools_read_is_of_every_control_step(log):
    """sysid.tools and data-driven-dynamics: specific force, angular acceleration and outputs, beside the motors."""
    force, rates, outputs = (log.get_dataset(name).data for name in ("vehicle_acceleration", "vehicle_angular_velocity", "actuator_outputs"))
    for data in (force, rates, outputs):
        assert set(np.diff(data["timestamp"].astype(np.int64))) == {4000}
    imu, motors = log.get_dataset("sensor_combined").data, log.get_dataset("actuator_motors").data
    assert np.array_equal(force["xyz[2]"], imu["accelerometer_m_s2[2]"])
    assert np.array_equal(outputs["output[1]"], motors["control[1]"]) and set(outputs["noutputs"]) == {4}
    # The rates are the sum of their slopes, but for the low pass.
    turned = np.cumsum(rates["xyz_derivative[1]"]) * 0.004
    assert np.abs(turned - (rates["xyz[1]"] - rates["xyz[1]"][0])).max() < 0.1 * np.abs(rates["xyz[1]"]).max()
    battery = log.get_dataset("battery_status").data
    assert set(np.diff(battery["timestamp"].astype(np.int64))) == {200_000}
    assert not battery["connected"].any() and set(battery["remaining"]) == {-1.0}, "titan_drop has none"


def test_thrust_and_moments_are_those_of_the_rotors(log):
    thrust, torque = (log.get_dataset(f"vehicle_{name}_setpoint").data for name in ("thrust", "torque"))
    motors = log.get_dataset("actuator_motors").data
    throttles = np.array([motors[f"control[{i}]"] for i in range(4)])
    flying = throttles.min(axis=0) > 0.01
    # Thrust goes with the square of the throttle; four equal rotors, none of them hindered.
    parts = throttles**2
    assert -thrust["xyz[2]"][flying] == pytest.approx(parts.mean(axis=0)[flying], abs=0.02)
    # Rotors 1 and 3 are ahead: they pitch the nose up.
    up = (parts[0] + parts[2] - parts[1] - parts[3]) / 2
    assert torque["xyz[1]"] == pytest.approx(up, abs=1e-5)
    assert np.abs(torque["xyz[1]"]).max() > 0.01


@pytest.mark.skipif(not REVIEW, reason="SAMARA_FLIGHT_REVIEW does not name a checkout of PX4/flight_review")
@pytest.mark.parametrize("estimator", [[], ["--estimator", "ekf"]])
def test_flight_review_draws_the_log(tmp_path, estimator):
    mission = REPOSITORY / "mission" / "x500_drop.json"
    subprocess.run([SAMARA, "drop", mission, *estimator, "--out", tmp_path], check=True, capture_output=True)
    python = os.environ.get("SAMARA_FLIGHT_REVIEW_PYTHON", sys.executable)
    script = Path(__file__).parent / "flight_review.py"
    review = subprocess.run([python, script, REVIEW, tmp_path / "flight.ulg"], check=True, capture_output=True, text=True)
    assert "Error" not in review.stderr, review.stderr
    found = json.loads(review.stdout)
    assert {"Altitude Estimate", "Thrust and Magnetic Field", "Estimator Flags", "Vibration Metrics"} <= set(found["plots"])
    assert len(found["plots"]) >= 24 and len(found["pid_analysis"]) == 8
    assert "Vehicle Life Flight Time: 0 seconds" in found["table"]
