"""A drop flown by DroneKit: hears the vehicle, arms, releases, flies a plan; what happened, as JSON.

    python dronekit_drop.py udp:127.0.0.1:14540 TRAJECTORY.csv MISSION.json

DroneKit 2.9.2 names `collections.MutableMapping`, which Python has had in `collections.abc` alone since 3.10; the two lines below are
the shim that it needs. It takes every HEARTBEAT of a vehicle's components for the vehicle's, the parachute's too, and has no names
for PX4's modes; so mode and arming are read here from the autopilot's own.
"""

import collections
import collections.abc

collections.MutableMapping = collections.abc.MutableMapping

import json
import logging
import sys
import threading
from pathlib import Path

import dronekit

sys.path.append(str(Path(__file__).resolve().parents[1]))

from drop import ATTITUDE_AND_THRUST, AUTOPILOT, PARACHUTE, PX4_OFFBOARD, SETPOINT_PERIOD_S, VELOCITY_ONLY, Plan, mavlink

PATIENCE_S = 30.0
# Longer than what a client of a busy machine takes to answer, shorter than a wait that has failed.
REPEAT_S = 1.0


class Drop:
    """A vehicle of DroneKit's, the setpoints that it is sent, and what it has told."""

    def __init__(self, url, plan, delay_s):
        self.plan, self.delay_s = plan, delay_s
        self.now_s, self.sent_s, self.free_s, self.end_s = 0.0, 0.0, None, None
        self.acks, self.is_armed, self.is_offboard = {}, False, False
        self.news = threading.Condition()
        self.vehicle = dronekit.connect(url, wait_ready=False)
        self.vehicle.add_message_listener("ATTITUDE", self.attitude)
        self.vehicle.add_message_listener("HEARTBEAT", self.heartbeat)
        self.vehicle.add_message_listener("COMMAND_ACK", self.ack)
        self.vehicle.add_message_listener("NAMED_VALUE_INT", self.named)

    def attitude(self, _vehicle, _name, m):
        self.now_s = m.time_boot_ms * 1e-3
        if self.now_s - self.sent_s < SETPOINT_PERIOD_S - 1e-6:
            return
        self.sent_s = self.now_s
        factory = self.vehicle.message_factory
        if self.free_s is None:
            setpoint = factory.set_attitude_target_encode(
                m.time_boot_ms, 0, AUTOPILOT, ATTITUDE_AND_THRUST, [1, 0, 0, 0], 0, 0, 0, 0
            )
        else:
            v_ned = self.plan.velocity_ned(self.now_s - self.free_s)
            setpoint = factory.set_position_target_local_ned_encode(
                m.time_boot_ms, 0, AUTOPILOT, mavlink.MAV_FRAME_LOCAL_NED, VELOCITY_ONLY, 0, 0, 0, *v_ned, 0, 0, 0, 0, 0
            )
        self.vehicle.send_mavlink(setpoint)

    def heartbeat(self, _vehicle, _name, m):
        if m.get_srcComponent() == AUTOPILOT:
            with self.news:
                self.is_armed = bool(m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
                self.is_offboard = m.custom_mode >> 16 & 0xFF == PX4_OFFBOARD
                self.news.notify_all()

    def ack(self, _vehicle, _name, m):
        with self.news:
            self.acks[m.get_srcComponent(), m.command] = m.result
            self.news.notify_all()

    def named(self, _vehicle, _name, m):
        with self.news:
            if m.name == "t_release":
                self.free_s = m.value * 1e-3 + self.delay_s
            elif m.name == "t_end":
                self.end_s = m.value * 1e-3
            self.news.notify_all()

    def wait(self, what, condition, within_s=PATIENCE_S):
        """Waits until something is so."""
        with self.news:
            if not self.news.wait_for(condition, within_s):
                raise SystemExit(f"{what}: not within {within_s} s (at {self.now_s} s); acknowledged: {self.acks}")

    def command(self, component, command, *params):
        """Sends a command until it is accepted."""
        params = [*params, *[0] * (7 - len(params))]
        for _ in range(round(PATIENCE_S / REPEAT_S)):
            self.vehicle.send_mavlink(
                self.vehicle.message_factory.command_long_encode(0, component, command, 0, *params)
            )
            with self.news:
                accepted = mavlink.MAV_RESULT_ACCEPTED
                if self.news.wait_for(lambda: self.acks.get((component, command)) == accepted, REPEAT_S):
                    return
        raise SystemExit(f"command {command}: not accepted (at {self.now_s} s); acknowledged: {self.acks}")

    def fly(self):
        """Hang, arm, release, plan, until the parachute says that the simulation is over."""
        mode = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        self.wait("setpoints", lambda: self.sent_s > 0.0 or self.news.wait(0.1) and self.sent_s > 0.0)
        self.command(AUTOPILOT, mavlink.MAV_CMD_DO_SET_MODE, mode, PX4_OFFBOARD)
        self.command(AUTOPILOT, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
        self.wait("armed, in OFFBOARD", lambda: self.is_armed and self.is_offboard)
        self.command(PARACHUTE, mavlink.MAV_CMD_DO_GRIPPER, 1, mavlink.GRIPPER_ACTION_RELEASE)
        self.wait("released", lambda: self.free_s is not None)
        self.wait("the end", lambda: self.end_s is not None, 10 * PATIENCE_S)
        return {"released_s": self.free_s - self.delay_s, "end_s": self.end_s, "was_offboard": self.is_offboard}


def main():
    url, trajectory, mission = sys.argv[1:]
    # It complains once a second that the parachute's HEARTBEAT has no mode.
    logging.getLogger("dronekit").setLevel(logging.CRITICAL)
    with open(mission, encoding="utf-8") as file:
        mission = json.load(file)
    drop = Drop(url, Plan(trajectory, mission["target_v_ned_m_s"]), mission["parachute"]["delay_s"])
    print(json.dumps(drop.fly()), flush=True)
    drop.vehicle.close()


main()
