"""The orbit sources."""

from typing import Annotated, get_args

from pydantic import Field

from planner.orbits.ephemeris import Ephemeris, OrbitStates
from planner.orbits.oem import OemOrbit
from planner.orbits.omm import OmmOrbit
from planner.orbits.opm import OpmOrbit
from planner.orbits.state_vector import StateVectorOrbit
from planner.orbits.tle import TleOrbit
from planner.spec import About

Orbit = Annotated[
    TleOrbit | OmmOrbit | OemOrbit | OpmOrbit | StateVectorOrbit,
    Field(discriminator="source"),
    About("Where the carrier is, from any of these sources."),
]

ORBITS = {orbit.source: orbit for orbit in get_args(get_args(Orbit)[0])}

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
