"""The verbs of a drop test: start the programs, arm, offboard, stream, release, and what came of it.

Time is simulated time, `time_boot_ms` of ATTITUDE. Nothing here sleeps: a wait is a wait for a message (or for a line that a
program prints), and the setpoints go on while one waits, in answer to ATTITUDE. Wall time only bounds a wait that has failed.
"""

import csv
import math
import os
from dataclasses import dataclass, field

os.environ["MAVLINK20"] = "1"  # pymavlink reads it when it is imported

from pymavlink import mavutil  # noqa: E402

mavlink = mavutil.mavlink

AUTOPILOT = mavlink.MAV_COMP_ID_AUTOPILOT1
PARACHUTE = mavlink.MAV_COMP_ID_PARACHUTE
PX4_OFFBOARD = 6
ATTITUDE_AND_THRUST = 0x07
VELOCITY_ONLY = 0x0DC7
SETPOINT_PERIOD_S = 0.02
HEARTBEAT_PERIOD_S = 1.0
# A wait that lasts longer than this in wall time has failed.
PATIENCE_S = 30.0
# A message that has not come after this simulated time will not come.
PATIENCE_SIMULATED_S = 5.0


class DropError(AssertionError):
    """The drop does not go as it should."""


class Plan:
    """A planned trajectory; velocity by cubic Hermite between the nodes, its ends held, then the target."""

    def __init__(self, path, target_v_ned):
        with open(path, newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
        columns = ("t_s", "vn_m_s", "ve_m_s", "vd_m_s", "an_m_s2", "ae_m_s2", "ad_m_s2")
        self.nodes = [[float(row[column]) for column in columns] for row in rows]
        self.end_s = self.nodes[-1][0]
        self.target_v_ned = target_v_ned

    def velocity_ned(self, t_s):
        """Velocity [m/s] at `t_s` from the moment the rotors are free."""
        if t_s <= self.nodes[0][0]:
            return self.nodes[0][1:4]
        for (ta, *a), (tb, *b) in zip(self.nodes, self.nodes[1:]):
            if t_s < tb:
                h = tb - ta
                s = (t_s - ta) / h
                r = 1 - s
                return [
                    a[i] * r * r * (1 + 2 * s) + a[i + 3] * h * s * r * r
                    + b[i] * s * s * (3 - 2 * s) - b[i + 3] * h * s * s * r
                    for i in range(3)
                ]
        return self.target_v_ned


@dataclass
class Telemetry:
    """What the vehicle has sent of its state: rows that begin with simulated time [s]."""

    attitude: list = field(default_factory=list)  # t, pitch [rad], pitch rate [rad/s]
    velocity: list = field(default_factory=list)  # t, north, east, down [m/s]

    def j_tpf(self, limits, since_s):
        """Peak of J_state, (47)-(51) of the paper, from `since_s` on."""
        costs = [math.hypot(*v) / limits["speed_m_s"] for t, *v in self.velocity if t >= since_s]
        for t, pitch, rate in self.attitude:
            if t >= since_s:
                costs.append(abs(math.degrees(pitch)) / limits["pitch_deg"])
                costs.append(abs(math.degrees(rate)) / limits["pitch_rate_deg_s"])
        return max(costs)


class Vehicle:
    """The vehicle as a script meets it: autopilot and parachute on one UDP socket."""

    def __init__(self, address, system):
        self.link = mavutil.mavlink_connection(address, source_system=245, source_component=190)
        self.system = system
        self.now_s = 0.0
        self.telemetry = Telemetry()
        self.texts = []
        self._setpoint = None
        self._sent_s = self._heartbeat_s = -math.inf

    def close(self):
        self.link.close()

    # Hearing.

    def hear(self):
        """The next message of this vehicle; what is due to be sent is sent."""
        while True:
            m = self.link.recv_match(blocking=True, timeout=PATIENCE_S)
            if m is None:
                raise DropError(f"nothing heard for {PATIENCE_S} s (after {self.now_s} s of simulated time)")
            if m.get_type() != "BAD_DATA" and m.get_srcSystem() == self.system:
                self._take(m)
                return m

    def _take(self, m):
        kind = m.get_type()
        if kind == "ATTITUDE":
            self.now_s = m.time_boot_ms * 1e-3
            self.telemetry.attitude.append((self.now_s, m.pitch, m.pitchspeed))
            self._send_what_is_due()
        elif kind == "LOCAL_POSITION_NED":
            self.telemetry.velocity.append((m.time_boot_ms * 1e-3, m.vx, m.vy, m.vz))
        elif kind == "STATUSTEXT":
            self.texts.append(m.text)

    def wait(self, kind, condition=lambda m: True, within_s=PATIENCE_SIMULATED_S):
        """The next message of a kind that meets a condition, within so much simulated time."""
        start_s = self.now_s
        while self.now_s <= start_s + within_s:
            m = self.hear()
            if m.get_type() == kind and condition(m):
                return m
        raise DropError(f"no such {kind} within {within_s} s (at {self.now_s} s); said: {self.texts}")

    def connect(self):
        """Waits for autopilot and parachute; asks for the state at the rate of the setpoints, and for less of the rest."""
        for component in (AUTOPILOT, PARACHUTE):
            self.wait("HEARTBEAT", lambda m, c=component: m.get_srcComponent() == c)
        for message in (mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED):
            self.command(AUTOPILOT, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message, SETPOINT_PERIOD_S * 1e6)
        for message in (mavlink.MAVLINK_MSG_ID_HIGHRES_IMU, mavlink.MAVLINK_MSG_ID_ODOMETRY):
            self.command(AUTOPILOT, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message, -1)

    def until(self, time_s):
        """Streams on until simulated time has come to `time_s`."""
        while self.now_s < time_s:
            self.hear()

    # Sending.

    def _send_what_is_due(self):
        if self.now_s - self._heartbeat_s >= HEARTBEAT_PERIOD_S:
            self._heartbeat_s = self.now_s
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
        if self._setpoint and self.now_s - self._sent_s >= SETPOINT_PERIOD_S - 1e-6:
            self._sent_s = self.now_s
            self._setpoint(self.now_s)

    def stream(self, setpoint):
        """From now on `setpoint(simulated time)` at 50 Hz; `None`: nothing."""
        self._setpoint = setpoint

    def level(self, now_s):
        """The setpoint under the canopy: level, no thrust."""
        self.link.mav.set_attitude_target_send(
            round(now_s * 1e3), self.system, AUTOPILOT, ATTITUDE_AND_THRUST, [1, 0, 0, 0], 0, 0, 0, 0
        )

    def velocity(self, now_s, v_ned):
        """A setpoint of velocity [m/s]."""
        frame = mavlink.MAV_FRAME_LOCAL_NED
        self.link.mav.set_position_target_local_ned_send(
            round(now_s * 1e3), self.system, AUTOPILOT, frame, VELOCITY_ONLY, 0, 0, 0, *v_ned, 0, 0, 0, 0, 0
        )

    def flies(self, plan, start_s):
        """The setpoints of a plan that begins at `start_s`."""
        return lambda now_s: self.velocity(now_s, plan.velocity_ned(now_s - start_s))

    def command(self, component, command, *params):
        """Sends a command and demands that it is accepted."""
        params = [*params, *[0] * (7 - len(params))]
        self.link.mav.command_long_send(self.system, component, command, 0, *params)
        ack = self.wait(
            "COMMAND_ACK", lambda m: m.command == command and m.get_srcComponent() == component
        )
        if ack.result != mavlink.MAV_RESULT_ACCEPTED:
            raise DropError(f"command {command} refused ({ack.result}) at {self.now_s} s; said: {self.texts}")

    # What a drop consists of.

    def offboard(self):
        """Streams the level attitude and goes to OFFBOARD."""
        self.stream(self.level)
        self.until(self.now_s + 0.5)
        mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        self.command(AUTOPILOT, mavlink.MAV_CMD_DO_SET_MODE, mode, PX4_OFFBOARD)
        self.wait("HEARTBEAT", self.is_offboard)

    def is_offboard(self, heartbeat):
        """Whether a heartbeat is the autopilot's and shows OFFBOARD."""
        from_autopilot = heartbeat.get_srcComponent() == AUTOPILOT
        return from_autopilot and heartbeat.custom_mode >> 16 & 0xFF == PX4_OFFBOARD

    def arm(self):
        """Arms."""
        self.command(AUTOPILOT, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)

    def release(self):
        """Commands the release; simulated time of the cut [s], as the parachute tells it."""
        self.command(PARACHUTE, mavlink.MAV_CMD_DO_GRIPPER, 1, mavlink.GRIPPER_ACTION_RELEASE)
        return self.sees_the_release()

    def sees_the_release(self):
        """Simulated time of the cut [s], as the parachute tells it."""
        told = self.wait(
            "NAMED_VALUE_INT", lambda m: m.name == "t_release" and m.get_srcComponent() == PARACHUTE
        )
        return told.value * 1e-3
