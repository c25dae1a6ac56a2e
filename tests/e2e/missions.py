"""Variants of the repository's missions, for the fixture `mission`."""

from programs import REPOSITORY


def over_ground(mission):
    """40 m below the point of release there is ground to land on, and there is time for it."""
    mission["gains"] = str(REPOSITORY / "params" / "gains" / "x500_hover.json")
    mission["site"]["ground_altitude_m"] = mission["site"]["altitude_m"] - 40
    mission["duration_s"] = 75
