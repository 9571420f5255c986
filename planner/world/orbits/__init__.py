"""The orbit sources."""

from typing import Annotated, get_args

from pydantic import Field

from planner.base.spec import About
from planner.world.orbits.ephemeris import CarrierName, Ephemeris, OrbitSource, OrbitStates
from planner.world.orbits.oem import OemOrbit
from planner.world.orbits.omm import OmmOrbit
from planner.world.orbits.opm import OpmOrbit
from planner.world.orbits.state_vector import StateVectorOrbit
from planner.world.orbits.tle import TleOrbit

Orbit = Annotated[
    TleOrbit | OmmOrbit | OemOrbit | OpmOrbit | StateVectorOrbit,
    Field(discriminator="source"),
    About("Orbit of the carrier, from one of these sources."),
]

ORBITS = {orbit.source: orbit for orbit in get_args(get_args(Orbit)[0])}

__all__ = [
    "ORBITS",
    "CarrierName",
    "Ephemeris",
    "OemOrbit",
    "OmmOrbit",
    "OpmOrbit",
    "Orbit",
    "OrbitSource",
    "OrbitStates",
    "StateVectorOrbit",
    "TleOrbit",
]
