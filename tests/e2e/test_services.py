"""Parameters, missions, files: what a ground station does with a vehicle in flight."""

import math
import struct
import zlib

from drop import AUTOPILOT, mavlink

REAL32, INT32 = mavlink.MAV_PARAM_TYPE_REAL32, mavlink.MAV_PARAM_TYPE_INT32
HASH = "_HASH_CHECK"


def bits(value):
    """The four bytes of a PARAM_VALUE, as a number."""
    return struct.unpack("<I", struct.pack("<f", value))[0]


def px4_crc(data):
    """PX4's CRC-32: zlib's without its inversions."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def read_parameters(vehicle):
    """Every parameter by name, in the order of their indices, and the checksum that came with them."""
    vehicle.link.mav.param_request_list_send(vehicle.system, 0)
    values, checksum, count = {}, None, None
    while count is None or len(values) < count:
        m = vehicle.wait("PARAM_VALUE")
        if m.param_id == HASH:
            checksum = bits(m.param_value)
        else:
            values[m.param_index] = m
            count = m.param_count
    return [values[i] for i in range(count)], checksum


def set_parameter(vehicle, name, value, kind=REAL32):
    """Sets a parameter; the value that the vehicle tells then."""
    vehicle.link.mav.param_set_send(vehicle.system, AUTOPILOT, name.encode(), value, kind)
    return vehicle.wait("PARAM_VALUE", lambda m: m.param_id == name).param_value


def items(n, kind):
    """A plan of `n` items of a type."""
    command = {0: mavlink.MAV_CMD_NAV_WAYPOINT, 1: mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
               2: mavlink.MAV_CMD_NAV_RALLY_POINT}[kind]
    return [(command, n if kind == 1 else 0, 470_000_000 + 1000 * i, 80_000_000 - 1000 * i, 20.0 + i) for i in range(n)]


def upload(vehicle, plan, kind):
    """Uploads a plan; the result, and the id by which the vehicle knows it."""
    mav = vehicle.link.mav
    mav.mission_count_send(vehicle.system, AUTOPILOT, len(plan), kind)
    while True:
        m = vehicle.hear()
        if m.get_type() == "MISSION_ACK" and m.mission_type == kind:
            return m.type
        if m.get_type() == "MISSION_REQUEST_INT" and m.mission_type == kind:
            command, param1, x, y, z = plan[m.seq]
            mav.mission_item_int_send(
                vehicle.system, AUTOPILOT, m.seq, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, command, 0, 1,
                param1, 0, 0, 0, x, y, z, kind,
            )


def download(vehicle, kind):
    """The plan that the vehicle has."""
    mav = vehicle.link.mav
    mav.mission_request_list_send(vehicle.system, AUTOPILOT, kind)
    count = vehicle.wait("MISSION_COUNT", lambda m: m.mission_type == kind).count
    plan = []
    for seq in range(count):
        mav.mission_request_int_send(vehicle.system, AUTOPILOT, seq, kind)
        m = vehicle.wait("MISSION_ITEM_INT", lambda m, s=seq: m.seq == s and m.mission_type == kind)
        plan.append((m.command, m.param1, m.x, m.y, m.z))
    mav.mission_ack_send(vehicle.system, AUTOPILOT, mavlink.MAV_MISSION_ACCEPTED, kind)
    return plan


def test_a_ground_station_at_work_on_a_vehicle_in_flight(samara, vehicle, reference):
    samara.sim("--speed", 10)
    autopilot = samara.autopilot()
    vehicle.hang()
    vehicle.arm()
    released_s = vehicle.release()
    vehicle.stream(vehicle.flies(reference.plan, released_s + reference.mission["parachute"]["delay_s"]))
    vehicle.until(released_s + 4)

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
