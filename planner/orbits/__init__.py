"""The orbit sources."""

from typing import Annotated

from pydantic import Field

from planner.orbits.ephemeris import Ephemeris, OrbitStates
from planner.orbits.oem import OemOrbit
from planner.orbits.omm import OmmOrbit
from planner.orbits.opm import OpmOrbit
from planner.orbits.state_vector import StateVectorOrbit
from planner.orbits.tle import TleOrbit

Orbit = Annotated[
    TleOrbit | OmmOrbit | OemOrbit | OpmOrbit | StateVectorOrbit, Field(discriminator="source")
]

ORBITS = {
    "tle": TleOrbit,
    "omm": OmmOrbit,
    "oem": OemOrbit,
    "opm": OpmOrbit,
    "state": StateVectorOrbit,
}

__all__ = [
    "ORBITS",
    "Ephemeris",
    "OemOrbit",
    "OmmOrbit",
    "OpmOrbit",
    "Orbit",
    "OrbitStates",
    "StateVectorOrbit",
    "TleOrbit",
]
