"""The verbs of a drop test in simulated time: `hang`, `arm`, `stream`, `release`, `wait_until_steady`, `assert_limits`.

Copy this file beside your own script; it needs pymavlink and nothing else. With `samara plan` done once, and `samara sim
--wait-for companion` and `samara autopilot` running, at any `--speed`:

```python
import json
from drop import Plan, Vehicle

mission = json.load(open("mission/titan_drop.json"))
plan = Plan("out/titan_drop/trajectory.csv", mission["target_v_ned_m_s"])
vehicle = Vehicle("udpin:127.0.0.1:14540", system=1)
vehicle.hang()
vehicle.arm()
free_s = vehicle.release(at_s=10) + mission["parachute"]["delay_s"]
vehicle.stream(vehicle.flies(plan, free_s))
vehicle.until(free_s + plan.end_s)
print("steady at", vehicle.wait_until_steady(plan.target_v_ned, mission["limits"]["steady_within_m_s"]), "s")
print("J_TPF", vehicle.assert_limits(mission["limits"], since_s=free_s))
vehicle.until_the_end()
```

Time is simulated time, `time_boot_ms` of ATTITUDE. Nothing here sleeps: a wait is a wait for a message, and the setpoints go on
while one waits, in answer to ATTITUDE. Wall time only bounds a wait that has failed. What goes wrong is a `DropError`.
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
VELOCITY_AND_ACCELERATION = 0x0C07
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

    def acceleration_ned(self, t_s):
        """Acceleration [m/s^2] at `t_s`, that of the velocity; none before the plan and after it."""
        for (ta, *a), (tb, *b) in zip(self.nodes, self.nodes[1:]):
            if ta <= t_s < tb:
                h = tb - ta
                s = (t_s - ta) / h
                r = 1 - s
                return [
                    6 * s * r * (b[i] - a[i]) / h + a[i + 3] * r * (1 - 3 * s) + b[i + 3] * s * (3 * s - 2)
                    for i in range(3)
                ]
        return [0, 0, 0]


@dataclass
class Telemetry:
    """What the vehicle has sent of its state: rows that begin with simulated time [s]."""

    attitude: list = field(default_factory=list)  # t, roll and pitch [rad], roll rate and pitch rate [rad/s]
    velocity: list = field(default_factory=list)  # t, north, east, down [m/s]

    def peaks(self, limits, since_s):
        """The greatest of each part of J_state, (47)-(51) of the paper, from `since_s` on: name, value, share of its limit, time."""
        speeds = [(math.hypot(*v), t) for t, *v in self.velocity]
        tilts = [(math.degrees(max(abs(roll), abs(pitch))), t) for t, roll, pitch, _, _ in self.attitude]
        rates = [(math.degrees(max(abs(p), abs(q))), t) for t, _, _, p, q in self.attitude]
        found = []
        for name, values in {"speed_m_s": speeds, "pitch_deg": tilts, "pitch_rate_deg_s": rates}.items():
            value, time_s = max(((value, t) for value, t in values if t >= since_s), default=(math.inf, since_s))
            found.append((name, value, value / limits[name], time_s))
        return found


class Vehicle:
    """The vehicle as a script meets it: autopilot and parachute on one UDP socket."""

    def __init__(self, address, system=1):
        self.link = mavutil.mavlink_connection(address, source_system=245, source_component=190)
        self.system = system
        self.now_s = 0.0
        self._greeted = False
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
        if not self._greeted:
            # `samara sim --wait-for companion` stands still until it hears somebody.
            self._greeted = True
            self._send_heartbeat()
        kind = m.get_type()
        if kind == "ATTITUDE":
            self.now_s = m.time_boot_ms * 1e-3
            self.telemetry.attitude.append((self.now_s, m.roll, m.pitch, m.rollspeed, m.pitchspeed))
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
            # Who joins late begins to wait at the first time that it hears.
            start_s = start_s or self.now_s
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
            self._send_heartbeat()
        if self._setpoint and self.now_s - self._sent_s >= SETPOINT_PERIOD_S - 1e-6:
            self._sent_s = self.now_s
            self._setpoint(self.now_s)

    def _send_heartbeat(self):
        self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)

    def stream(self, setpoint):
        """From now on `setpoint(simulated time)` at 50 Hz; `None`: nothing."""
        self._setpoint = setpoint

    def level(self, now_s):
        """The setpoint under the canopy: level, no thrust."""
        self.link.mav.set_attitude_target_send(
            round(now_s * 1e3), self.system, AUTOPILOT, ATTITUDE_AND_THRUST, [1, 0, 0, 0], 0, 0, 0, 0
        )

    def velocity(self, now_s, v_ned, a_ned=None):
        """A setpoint of velocity [m/s], and of the acceleration [m/s^2] that goes with it."""
        frame, mask = mavlink.MAV_FRAME_LOCAL_NED, VELOCITY_ONLY if a_ned is None else VELOCITY_AND_ACCELERATION
        self.link.mav.set_position_target_local_ned_send(
            round(now_s * 1e3), self.system, AUTOPILOT, frame, mask, 0, 0, 0, *v_ned, *(a_ned or (0, 0, 0)), 0, 0
        )

    def flies(self, plan, start_s):
        """The setpoints of a plan that begins at `start_s`."""
        return lambda now_s: self.velocity(
            now_s, plan.velocity_ned(now_s - start_s), a_ned=plan.acceleration_ned(now_s - start_s)
        )

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

    def hang(self):
        """Hangs under the canopy as it should before a drop: heard, level attitude and no thrust streamed, in OFFBOARD."""
        self.connect()
        self.stream(self.level)
        self.offboard()

    def offboard(self):
        """Goes to OFFBOARD with what is streamed."""
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

    def release(self, at_s=0.0):
        """Commands the release, not before `at_s`; simulated time of the cut [s], as the parachute tells it."""
        self.until(at_s)
        self.command(PARACHUTE, mavlink.MAV_CMD_DO_GRIPPER, 1, mavlink.GRIPPER_ACTION_RELEASE)
        return self.sees_the_release()

    def sees_the_release(self):
        """Simulated time of the cut [s], as the parachute tells it."""
        told = self.wait(
            "NAMED_VALUE_INT", lambda m: m.name == "t_release" and m.get_srcComponent() == PARACHUTE
        )
        return told.value * 1e-3

    def until_the_end(self):
        """Streams on until the simulation is over, as the parachute tells it; simulated time of that [s]."""
        told = self.wait(
            "NAMED_VALUE_INT", lambda m: m.name == "t_end" and m.get_srcComponent() == PARACHUTE, math.inf
        )
        return told.value * 1e-3

    def wait_until_steady(self, v_ned, within_m_s=None, for_s=2.0, patience_s=60.0):
        """Streams on until the velocity has been near `v_ned` [m/s] for so long; simulated time at which that began [s].

        Near is `within_m_s`, or the verdict's 1 % of the speed where there is one to take a hundredth of (0.05 m/s at hover)."""
        within_m_s = within_m_s or 0.01 * math.hypot(*v_ned) or 0.05
        begun_s, end_s = None, self.now_s + patience_s
        while self.now_s < end_s:
            m = self.hear()
            if m.get_type() == "LOCAL_POSITION_NED":
                near = math.dist((m.vx, m.vy, m.vz), v_ned) <= within_m_s
                begun_s = (m.time_boot_ms * 1e-3 if begun_s is None else begun_s) if near else None
            if begun_s is not None and self.now_s >= begun_s + for_s:
                return begun_s
        last = self.telemetry.velocity[-1:] or "no velocity heard"
        raise DropError(f"not within {within_m_s} m/s of {list(v_ned)} for {for_s} s (at {self.now_s} s): {last}")

    def assert_limits(self, limits, since_s):
        """Demands that no limit of a mission was passed from `since_s` on, as far as telemetry tells; J_TPF."""
        peaks = self.telemetry.peaks(limits, since_s)
        passed = [f"{name} {value:.4g} at {t:.3f} s, limit {limits[name]}" for name, value, share, t in peaks if share > 1]
        if passed:
            raise DropError("limits passed: " + "; ".join(passed))
        return max(share for _, _, share, _ in peaks)
