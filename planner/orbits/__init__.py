"""Which orbit sources are there?"""

from planner.orbits.ephemeris import Ephemeris, OrbitStates
from planner.orbits.oem import OemOrbit
from planner.orbits.state_vector import StateVectorOrbit
from planner.orbits.tle import TleOrbit

Orbit = TleOrbit | OemOrbit | StateVectorOrbit

ORBITS = {"tle": TleOrbit, "oem": OemOrbit, "state": StateVectorOrbit}

__all__ = [
    "ORBITS",
    "Ephemeris",
    "OemOrbit",
    "Orbit",
    "OrbitStates",
    "StateVectorOrbit",
    "TleOrbit",
]
