"""A mission uploaded and downloaded by DroneKit, which knows MISSION_REQUEST and MISSION_ITEM alone; what came back, as JSON.

    python dronekit_mission.py udp:127.0.0.1:14540
"""

import collections
import collections.abc

# As in dronekit_drop.py.
collections.MutableMapping = collections.abc.MutableMapping

import json
import logging
import sys

import dronekit
from pymavlink import mavutil

PATIENCE_S = 30.0
# Command, latitude, longitude, height above home [m].
ITEMS = [(22, 47.397742, 8.545594, 10.0), (16, 47.397942, 8.545594, 12.0), (21, 47.397942, 8.545594, 0.0)]


def main(url):
    # It says each time that it has no name for PX4's modes.
    logging.getLogger("dronekit").setLevel(logging.CRITICAL)
    vehicle = dronekit.connect(url, wait_ready=False)
    commands = vehicle.commands
    commands.clear()
    for command, latitude, longitude, height_m in ITEMS:
        frame = mavutil.mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
        commands.add(dronekit.Command(0, 0, 0, frame, command, 0, 1, 0, 0, 0, 0, latitude, longitude, height_m))
    commands.upload(timeout=PATIENCE_S)
    commands.download()
    commands.wait_ready(timeout=PATIENCE_S)
    # DroneKit takes the first item for home, as ArduPilot has it.
    print(json.dumps([[item.command, item.z] for item in commands]))
    vehicle.close()


main(*sys.argv[1:])
