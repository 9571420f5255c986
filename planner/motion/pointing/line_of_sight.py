"""The direction the payload must point in, and how fast it turns."""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.rotation import Rotation
from planner.world.attitude import AttitudeLaw
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.targets import VisibleTarget

STENCIL = 7


@dataclass(frozen=True, kw_only=True)
class LineOfSight:
    """The apparent direction of one target over n uniformly spaced instants.

    los_base: unit vectors, shape (n, 3); los_rate_base_per_s and
    los_acceleration_base_per_s2 their first and second derivatives in the frame of the base.
    range_m, clearance_rad: shape (n,), as in `ApparentDirection`.  states: of the orbit.
    """

    instants: Instants
    states: OrbitStates
    los_base: Array
    los_rate_base_per_s: Array
    los_acceleration_base_per_s2: Array
    range_m: Array
    clearance_rad: Array

    def cut_between(self, start_s: float, stop_s: float) -> "LineOfSight":
        """Its instants from one time to another, both included, on the clock of its instants."""
        half_step_s = 0.5 * (self.instants.t_s[1] - self.instants.t_s[0])
        ends_s = [start_s - half_step_s, stop_s + half_step_s]
        first, last = np.searchsorted(self.instants.t_s, ends_s)
        rows = slice(first, last)
        states = OrbitStates(self.states.r_sat_eci_m[rows], self.states.v_sat_eci_m_s[rows])
        return LineOfSight(
            instants=Instants(self.instants.epoch_utc, self.instants.t_s[rows]),
            states=states,
            los_base=self.los_base[rows],
            los_rate_base_per_s=self.los_rate_base_per_s[rows],
            los_acceleration_base_per_s2=self.los_acceleration_base_per_s2[rows],
            range_m=self.range_m[rows],
            clearance_rad=self.clearance_rad[rows],
        )


def line_of_sight(
    instants: Instants,
    ephemeris: Ephemeris,
    attitude: AttitudeLaw | None,
    q_base_from_body: Rotation,
    target: VisibleTarget,
) -> LineOfSight:
    """Apparent line of sight in the frame of the platform's base.

    attitude: of the body, None where the base is GCRF.
    instants: at least 7, uniformly spaced.  The derivatives are 7-point differences of the
    apparent direction itself, so that angles, rates and accelerations belong together for
    every orbit source; their error is (step / 54 s)^5 of the value on a 400 km pass.
    Source: Sumarokov 2016, eq. 10.
    """
    states = ephemeris.states(instants)
    seen = target.apparent(instants, states)
    q_base_from_eci = q_base_from_body
    if attitude is not None:
        q_base_from_eci = q_base_from_eci * attitude.q_body_from_eci(instants, states)
    los_base = q_base_from_eci.apply(seen.direction_eci)
    step_s = (instants.t_s[-1] - instants.t_s[0]) / (len(instants.t_s) - 1)
    return LineOfSight(
        instants=instants,
        states=states,
        los_base=los_base,
        los_rate_base_per_s=_differentiate_samples(los_base, step_s, 1),
        los_acceleration_base_per_s2=_differentiate_samples(los_base, step_s, 2),
        range_m=seen.range_m,
        clearance_rad=seen.clearance_rad,
    )


def _differentiate_samples(los_base: Array, step_s: float, order: int) -> Array:
    """Differences on the seven nearest samples, one-sided towards the ends, (n, 3)."""
    first, weights = difference_stencils(len(los_base), order)
    nodes = los_base[first[:, None] + np.arange(STENCIL)]
    return np.asarray(np.einsum("nk,nkj->nj", weights, nodes) / step_s**order)


def difference_stencils(rows: int, order: int) -> tuple[Indices, Array]:
    """For the derivative at each row: the first of its seven nodes, (rows,), and their weights,
    (rows, 7), for a step of 1."""
    first = np.clip(np.arange(rows) - STENCIL // 2, 0, rows - STENCIL)
    return first, _stencil_weights(order)[np.arange(rows) - first]


@cache
def _stencil_weights(order: int) -> Array:
    """Weights on nodes 0..6 exact for polynomials of degree 6, a row for each node."""
    wanted = np.zeros(STENCIL)
    wanted[order] = float(math.factorial(order))
    nodes = np.arange(STENCIL)
    return np.array(
        [np.linalg.solve(np.vander(nodes - float(at), increasing=True).T, wanted) for at in nodes]
    )
