"""Variants of the repository's missions, for the fixture `mission`."""

from programs import REPOSITORY


def over_ground(mission, height_m, duration_s):
    """So far below the point of release there is ground to land on, and there is time for it."""
    mission["site"]["ground_altitude_m"] = mission["site"]["altitude_m"] - height_m
    mission["duration_s"] = duration_s


def x500_over_ground(mission):
    over_ground(mission, 40, 75)
    mission["gains"] = str(REPOSITORY / "params" / "gains" / "x500_hover.json")


def titan_over_ground(mission):
    over_ground(mission, 150, 300)
