#!/usr/bin/env python3
"""Flies manoeuvres that tell what @VEHICLE@ is, by setpoints in OFFBOARD. Written by `samara identify --manoeuvre`.

    pip install pymavlink
    python THIS_FILE [CONNECTION]        # udpin:127.0.0.1:14540 unless another is given, as pymavlink writes them

Take off, with room of @AWAY_M@ m all around and @BELOW_M@ m below, and let the vehicle hold. The script then takes over, nose north,
and gives back to HOLD at the end, on Ctrl-C, when messages stay out for a second, and when the flight leaves the limits below. Sticks
take over at any time where bit 1 of COM_RC_OVERRIDE is set; the script then stops. Should it die, COM_OF_LOSS_T brings the failsafe.

Exit codes: 0 flown, 1 ended early, 2 not begun.
"""

import math
import os
import struct
import sys

os.environ["MAVLINK20"] = "1"  # pymavlink reads it when it is imported

from pymavlink import mavutil  # noqa: E402

mavlink = mavutil.mavlink
AUTOPILOT = mavlink.MAV_COMP_ID_AUTOPILOT1
# Where the flight is ended early: tilt [deg], distances from the beginning over ground, below and above [m], battery left [%].
TILT_DEG, AWAY_M, BELOW_M, ABOVE_M, BATTERY_PERCENT = @TILT_DEG@, @AWAY_M@, @BELOW_M@, @ABOVE_M@, 25
# Without a message for so long it is ended [s].
SILENCE_S = 1.0
# Messages that are flown by, and how often they are asked for [Hz].
RATES_HZ = {"ATTITUDE": 50, "LOCAL_POSITION_NED": 20, "ATTITUDE_TARGET": 20, "SYS_STATUS": 2}
OFFBOARD, HOLD = (6, 0), (4, 3)
# First hold, in which thrust is learned [s].
FIRST_S = 4.0
# Parameters to log by; the script says which are others.
LOGGING = {
    # @LOGGING@
}


def hold(fly, t_ms):
    """To the place where the flight began."""
    fly.link.mav.set_position_target_local_ned_send(
        t_ms, fly.system, AUTOPILOT, mavlink.MAV_FRAME_LOCAL_NED, 0x9F8, *fly.place, 0, 0, 0, 0, 0, 0, 0, 0
    )


def velocity(north, east, down):
    """A velocity [m/s]."""

    def send(fly, t_ms):
        fly.link.mav.set_position_target_local_ned_send(
            t_ms, fly.system, AUTOPILOT, mavlink.MAV_FRAME_LOCAL_NED, 0x9C7, 0, 0, 0, north, east, down, 0, 0, 0, 0, 0
        )

    return send


def attitude(roll_deg, pitch_deg, yaw_deg, thrust):
    """Angles beside level and north [deg], thrust as a share of the one that hovers."""
    a, b, c = (math.radians(angle) / 2 for angle in (roll_deg, pitch_deg, yaw_deg))
    q = [
        math.cos(a) * math.cos(b) * math.cos(c) + math.sin(a) * math.sin(b) * math.sin(c),
        math.sin(a) * math.cos(b) * math.cos(c) - math.cos(a) * math.sin(b) * math.sin(c),
        math.cos(a) * math.sin(b) * math.cos(c) + math.sin(a) * math.cos(b) * math.sin(c),
        math.cos(a) * math.cos(b) * math.sin(c) - math.sin(a) * math.sin(b) * math.cos(c),
    ]

    def send(fly, t_ms):
        fly.link.mav.set_attitude_target_send(
            t_ms, fly.system, AUTOPILOT, 0x07, q, 0, 0, 0, min(1.0, thrust * fly.hover)
        )

    return send


# What is asked, and for how long [s].
STEPS = [
    # @STEPS@
]


class Ended(Exception):
    """The flight is not to go on."""


class Fly:
    """A vehicle that holds a place, and what was heard of it."""

    def __init__(self, connection):
        self.link = mavutil.mavlink_connection(connection, source_system=245, source_component=191)
        self.heard, self.place, self.hover, self.hovers, self.engaged = {}, None, None, [], False
        self.system = None

    def hear(self):
        """The next message of the autopilot; 1 Hz of heartbeats go out on the way."""
        while True:
            message = self.link.recv_match(blocking=True, timeout=SILENCE_S)
            if message is None:
                raise Ended("no message for a second")
            if message.get_srcComponent() != AUTOPILOT or self.system not in (None, message.get_srcSystem()):
                continue
            self.heard[message.get_type()] = message
            if message.get_type() == "HEARTBEAT":
                self.link.mav.heartbeat_send(mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
            return message

    def wait(self, name, messages=2000):
        """A message by its name."""
        for _ in range(messages):
            message = self.hear()
            if message.get_type() == name:
                return message
        raise Ended(f"{name} does not come")

    def command(self, command, *params):
        """A command, until it is answered; whether it is accepted."""
        params = list(params) + [0.0] * (7 - len(params))
        self.link.mav.command_long_send(self.system, AUTOPILOT, command, 0, *params)
        return self.wait("COMMAND_ACK").result == mavlink.MAV_RESULT_ACCEPTED

    def mode(self):
        """Main and sub mode."""
        custom = self.heard["HEARTBEAT"].custom_mode
        return custom >> 16 & 0xFF, custom >> 24

    def begin(self):
        """Looks whether it may begin, and asks for messages."""
        self.system = self.link.wait_heartbeat(timeout=30).get_srcSystem()
        for name, hz in RATES_HZ.items():
            self.command(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, getattr(mavlink, f"MAVLINK_MSG_ID_{name}"), 1e6 / hz)
        for name, value in LOGGING.items():
            self.link.mav.param_request_read_send(self.system, AUTOPILOT, name.encode(), -1)
            try:
                found = struct.unpack("<i", struct.pack("<f", self.wait("PARAM_VALUE", 200).param_value))[0]
            except Ended:
                found = "not known"
            if found != value:
                print(f"{name} is {found}: with {value} all that is needed is logged", file=sys.stderr)
        if not self.wait("HEARTBEAT").base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED:
            raise Ended("it is not armed: take off first")
        at = self.wait("LOCAL_POSITION_NED")
        self.place = (at.x, at.y, at.z)

    def check(self):
        """Ends the flight where it leaves its limits."""
        attitude, at = self.heard["ATTITUDE"], self.heard["LOCAL_POSITION_NED"]
        tilt = math.degrees(math.acos(max(-1.0, min(1.0, math.cos(attitude.roll) * math.cos(attitude.pitch)))))
        north, east, down = (a - b for a, b in zip((at.x, at.y, at.z), self.place))
        for what, value, most in (
            ("tilt [deg]", tilt, TILT_DEG),
            ("distance [m]", math.hypot(north, east), AWAY_M),
            ("height lost [m]", down, BELOW_M),
            ("height gained [m]", -down, ABOVE_M),
        ):
            if not value <= most:
                raise Ended(f"{what} {value:.1f}, at most {most}")
        status = self.heard.get("SYS_STATUS")
        if status is not None and 0 <= status.battery_remaining < BATTERY_PERCENT:
            raise Ended(f"battery at {status.battery_remaining} %")
        if self.engaged and self.mode() != OFFBOARD:
            raise Ended("OFFBOARD was left by others")

    def stream(self, length_s, send):
        """Asks for something, in answer to ATTITUDE, for a time by the autopilot's clock."""
        begun = self.heard["ATTITUDE"].time_boot_ms
        while True:
            message = self.hear()
            if message.get_type() == "ATTITUDE_TARGET" and send is hold:
                self.hovers = self.hovers[-30:] + [message.thrust]
            if message.get_type() != "ATTITUDE":
                continue
            self.check()
            send(self, message.time_boot_ms)
            if message.time_boot_ms - begun >= 1000 * length_s - 10:
                return

    def fly(self):
        """All steps."""
        self.wait("ATTITUDE")
        self.stream(0.5, hold)
        self.link.mav.command_long_send(
            self.system, AUTOPILOT, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, OFFBOARD[0], 0, 0, 0, 0, 0
        )
        self.stream(FIRST_S, hold)
        if self.mode() != OFFBOARD:
            raise Ended("OFFBOARD was not taken up")
        self.engaged = True
        for length_s, send in STEPS:
            if self.hovers:
                self.hover = sum(self.hovers) / len(self.hovers)
            if self.hover is None:
                raise Ended("ATTITUDE_TARGET does not come: the thrust that hovers is not known")
            self.stream(length_s, send)
            if send is not hold:
                self.hovers = []
        self.stream(FIRST_S, hold)


def main(connection="udpin:127.0.0.1:14540"):
    """Flies."""
    fly = Fly(connection)
    try:
        fly.begin()
    except (Ended, AttributeError) as why:
        print(f"not begun: {why}", file=sys.stderr)
        return 2
    code = 0
    try:
        fly.fly()
        print(f"flown: {sum(length_s for length_s, _ in STEPS):.0f} s of manoeuvres")
    except (Ended, KeyboardInterrupt) as why:
        print(f"ended early: {why or 'by Ctrl-C'}", file=sys.stderr)
        code = 1
    if fly.mode() == OFFBOARD:
        fly.link.mav.command_long_send(
            fly.system, AUTOPILOT, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, HOLD[0], HOLD[1], 0, 0, 0, 0
        )
    return code


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
