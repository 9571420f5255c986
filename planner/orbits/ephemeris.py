"""What every orbit source gives: positions and velocities over a plan's time span."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal, Protocol

import numpy as np

from planner.arrays import Array
from planner.errors import OutsideCoverage
from planner.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text

Kind = Literal["tle", "oem", "state"]
_EDGE_S = 1e-6  # the resolution of a datetime


@dataclass(frozen=True, eq=False)
class OrbitStates:
    """r_sat_eci_m, v_sat_eci_m_s: shape (n, 3), geocentric, GCRF axes."""

    r_sat_eci_m: Array
    v_sat_eci_m_s: Array


class Ephemeris(Protocol):
    """An orbit made ready for one time span.

    kind: where it comes from.  warnings: what the user should know about its quality.
    """

    @property
    def kind(self) -> Kind: ...

    @property
    def warnings(self) -> tuple[str, ...]: ...

    def states(self, instants: Instants) -> OrbitStates:
        """Raises OutsideCoverage for instants outside the span it was made for."""
        ...

    def age_s(self, instants: Instants) -> Array:
        """Time since (or until) the data the orbit rests on, shape (n,), never negative."""
        ...


def refuse_outside(instants: Instants, start_utc: datetime, stop_utc: datetime) -> None:
    """Raise OutsideCoverage unless every instant lies from start to stop."""
    since_s = elapsed_s(instants.epoch_utc, start_utc)
    span_s = elapsed_s(stop_utc, start_utc)
    t_s = since_s + instants.t_s
    outside = np.flatnonzero((t_s < -_EDGE_S) | (t_s > span_s + _EDGE_S))
    if len(outside):
        at_utc = shifted_utc(instants.epoch_utc, float(instants.t_s[outside[0]]))
        raise OutsideCoverage(
            f"the orbit was asked for {utc_text(at_utc)}, but prepared only from "
            f"{utc_text(start_utc)} to {utc_text(stop_utc)}",
            field="orbit",
            at_utc=at_utc,
        )
