"""What a ground station asks of a vehicle: parameters read and set, plans uploaded and downloaded."""

import struct

from drop import AUTOPILOT, mavlink

REAL32, INT32 = mavlink.MAV_PARAM_TYPE_REAL32, mavlink.MAV_PARAM_TYPE_INT32
HASH = "_HASH_CHECK"


def bits(value):
    """The four bytes of a PARAM_VALUE, as a number."""
    return struct.unpack("<I", struct.pack("<f", value))[0]


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


def read_parameter(vehicle, name):
    """A parameter's value."""
    vehicle.link.mav.param_request_read_send(vehicle.system, AUTOPILOT, name.encode(), -1)
    return vehicle.wait("PARAM_VALUE", lambda m: m.param_id == name).param_value


def set_parameter(vehicle, name, value, kind=REAL32):
    """Sets a parameter; the value that the vehicle tells then."""
    vehicle.link.mav.param_set_send(vehicle.system, AUTOPILOT, name.encode(), value, kind)
    return vehicle.wait("PARAM_VALUE", lambda m: m.param_id == name).param_value


def set_integer(vehicle, name, value):
    """Sets a whole parameter, by its bytes as PX4 has it; the value that the vehicle tells then."""
    return bits(set_parameter(vehicle, name, struct.unpack("<f", struct.pack("<i", value))[0], INT32))


def items(n, kind):
    """A plan of `n` items of a type."""
    command = {0: mavlink.MAV_CMD_NAV_WAYPOINT, 1: mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
               2: mavlink.MAV_CMD_NAV_RALLY_POINT}[kind]
    return [(command, n if kind == 1 else 0, 470_000_000 + 1000 * i, 80_000_000 - 1000 * i, 20.0 + i) for i in range(n)]


def upload(vehicle, plan, kind):
    """Uploads a plan; the result (MAV_MISSION_RESULT)."""
    mav = vehicle.link.mav
    mav.mission_count_send(vehicle.system, AUTOPILOT, len(plan), kind)
    while True:
        m = vehicle.hear()
        if m.get_type() == "MISSION_ACK" and m.mission_type == kind:
            return m.type
        # PX4 up to v1.16 asks with the old message first, and takes the new item for an answer.
        if m.get_type() in ("MISSION_REQUEST", "MISSION_REQUEST_INT") and m.mission_type == kind:
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
