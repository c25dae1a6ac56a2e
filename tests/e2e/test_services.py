"""Parameters, missions, files: what a ground station does with a vehicle in flight."""

import math
import struct
import zlib

from drop import AUTOPILOT, mavlink
from ground_station import INT32, REAL32, bits, download, items, read_parameters, set_parameter, upload


def px4_crc(data):
    """PX4's CRC-32: zlib's without its inversions."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def test_a_ground_station_at_work_on_a_vehicle_in_flight(samara, vehicle, reference):
    samara.sim("--speed", 10)
    autopilot = samara.autopilot()
    free_s = reference.is_flown_by(vehicle)
    vehicle.until(free_s + 3.5)

    # All parameters, and their checksum by zlib.
    values, told = read_parameters(vehicle)
    data = b"".join(m.param_id.encode() + struct.pack("<f", m.param_value) for m in values)
    assert told == px4_crc(data)
    names = [m.param_id for m in values]
    assert names == sorted(names) and len(names) == len(set(names))
    assert {m.param_type for m in values} == {REAL32, INT32}
    by_name = {m.param_id: m for m in values}
    assert bits(by_name["MAV_SYS_ID"].param_value) == vehicle.system

    # A gain, in flight.
    gain = by_name["MPC_Z_VEL_P_ACC"].param_value
    changed = struct.unpack("<f", struct.pack("<f", 0.8 * gain))[0]
    assert set_parameter(vehicle, "MPC_Z_VEL_P_ACC", changed) == changed
    assert set_parameter(vehicle, "MPC_Z_VEL_P_ACC", float("nan")) == changed
    assert set_parameter(vehicle, "MPC_Z_VEL_P_ACC", 1e9) == changed
    assert "MPC_Z_VEL_P_ACC refused: NaN where 0 to 100 is expected" in "".join(vehicle.texts)
    assert read_parameters(vehicle)[1] != told
    vehicle.until(vehicle.now_s + 2)
    speed_m_s = math.hypot(*vehicle.telemetry.velocity[-1][1:])
    assert speed_m_s < reference.mission["limits"]["speed_m_s"], "still flying the plan"

    # Missions, fences, rally points.
    for kind, n in ((0, 40), (1, 4), (2, 3)):
        plan = items(n, kind)
        assert upload(vehicle, plan, kind) == mavlink.MAV_MISSION_ACCEPTED
        assert download(vehicle, kind) == plan
    assert upload(vehicle, items(2001, 0), 0) == mavlink.MAV_MISSION_NO_SPACE
    assert len(download(vehicle, 0)) == 40
    vehicle.link.mav.mission_clear_all_send(vehicle.system, AUTOPILOT, mavlink.MAV_MISSION_TYPE_ALL)
    assert vehicle.wait("MISSION_ACK").type == mavlink.MAV_MISSION_ACCEPTED
    assert [download(vehicle, kind) for kind in range(3)] == [[], [], []]

    autopilot.interrupt()
    assert autopilot.ends() == 0


def test_parameters_are_kept_and_loaded_again(samara, vehicle):
    samara.sim("--speed", 10)
    autopilot = samara.autopilot()
    vehicle.connect()
    assert set_parameter(vehicle, "COM_OF_LOSS_T", 2.5) == 2.5
    told = read_parameters(vehicle)[1]
    vehicle.command(AUTOPILOT, mavlink.MAV_CMD_PREFLIGHT_STORAGE, 1)
    autopilot.says("parameters kept in", "vehicle.params")
    autopilot.interrupt()
    assert autopilot.ends() == 0

    again = samara.autopilot("--params", autopilot.out / "vehicle.params")
    again.says("connected to simulator")
    assert read_parameters(vehicle)[1] == told
    assert not again.has_said("vehicle.params:"), "nothing to remark on"
