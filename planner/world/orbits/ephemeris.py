"""The ephemeris that every orbit source gives: positions and velocities over a plan's time span."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from datetime import datetime
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage
from planner.base.interpolation import hermite
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, utc_text
from planner.world.orbits.accuracy import OrbitSigma

EDGE_S = 1e-6  # the resolution of a datetime


def turned(rotation: Array, states: Array) -> Array:
    """Positions or velocities (n, 3) by matrices (n, 3, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", rotation, states))


@dataclass(frozen=True, eq=False)
class OrbitStates:
    """r_sat_eci_m, v_sat_eci_m_s: shape (n, 3), geocentric, GCRF axes."""

    r_sat_eci_m: Array
    v_sat_eci_m_s: Array


@dataclass(frozen=True, eq=False, kw_only=True)
class Ephemeris(ABC):
    """An orbit made ready for the time from start_utc to stop_utc.

    epoch_utc: of the data it rests on.  warnings: cautions about its quality.
    """

    epoch_utc: datetime
    start_utc: datetime
    stop_utc: datetime
    warnings: tuple[str, ...]

    @abstractmethod
    def interpolate(self, instants: Instants) -> OrbitStates:
        """`states` for instants that are known to lie within the span."""

    @abstractmethod
    def sigma(self, instants: Instants) -> OrbitSigma:
        """1-sigma errors of the prediction at n instants."""

    def states(self, instants: Instants) -> OrbitStates:
        """States at the n instants; raises OutsideCoverage unless all lie within the span."""
        self._require_within(instants)
        return self.interpolate(instants)

    def states_in_itrf_axes(self, instants: Instants) -> tuple[Array, Array]:
        """The same position and inertial velocity in ITRF axes, each (n, 3); raises the same."""
        states, c_itrf = self.states(instants), c_itrf_from_eci(instants)
        return turned(c_itrf, states.r_sat_eci_m), turned(c_itrf, states.v_sat_eci_m_s)

    def _require_within(self, instants: Instants) -> None:
        t_s = instants.since_s(self.start_utc)
        span_s = elapsed_s(self.stop_utc, self.start_utc)
        outside = np.flatnonzero((t_s < -EDGE_S) | (t_s > span_s + EDGE_S))
        if len(outside):
            at_utc = instants.utc(outside[0])
            raise OutsideCoverage(
                f"the orbit was asked for {utc_text(at_utc)}, but prepared only from "
                f"{utc_text(self.start_utc)} to {utc_text(self.stop_utc)}",
                field="orbit",
                at_utc=at_utc,
            )

    def dense_states(self, instants: Instants, step_s: float = 10.0) -> OrbitStates:
        """`states` at many instants in order of time, by the cubic through some.

        Off by r (w step_s)^4 / 384, 0.3 mm in low orbits.
        """
        first_s, last_s = (float(instants.t_s[k]) for k in (0, -1))
        node_s = np.linspace(first_s, last_s, math.ceil((last_s - first_s) / step_s) + 1)
        if len(node_s) >= len(instants):
            return self.states(instants)
        nodes = self.states(Instants(instants.epoch_utc, node_s))
        return OrbitStates(
            *hermite(node_s, nodes.r_sat_eci_m, nodes.v_sat_eci_m_s, instants.t_s, 2)
        )

    def age_s(self, instants: Instants) -> Array:
        """Time since (or until) the data the orbit rests on, shape (n,), never negative."""
        return np.abs(instants.since_s(self.epoch_utc))


class CarrierName(NamedTuple):
    """Name and international designator of the satellite; empty where the source has none."""

    name: str
    designator: str = ""


class OrbitSource(ABC):
    """A request's orbit in one of the forms it may be sent in.

    source: the form's name in a request.
    """

    source: str

    @property
    @abstractmethod
    def search_horizon_s(self) -> float:
        """How far around a refused session another start is sought: as the orbit is cheap."""

    @property
    @abstractmethod
    def carrier_name(self) -> CarrierName:
        """The satellite as this source names it."""

    @abstractmethod
    def ephemeris(self, start_utc: datetime, stop_utc: datetime) -> Ephemeris:
        """The orbit from start to stop; raises OutsideCoverage where it isn't known."""
