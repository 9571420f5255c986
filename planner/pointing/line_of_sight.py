"""The direction the payload must look in, and how fast it turns."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.attitude import AttitudeLaw
from planner.frames.time_scales import Instants
from planner.orbits import Ephemeris
from planner.targets import VisibleTarget

STENCIL = 7


@dataclass(frozen=True, kw_only=True)
class LineOfSight:
    """The apparent direction of one target over n uniformly spaced instants.

    los_platform: unit vectors, shape (n, 3); los_rate_platform_s and
    los_acceleration_platform_s2 their first and second derivatives in the platform frame.
    range_m, clearance_rad: shape (n,), as in `ApparentDirection`.
    """

    instants: Instants
    los_platform: NDArray[np.float64]
    los_rate_platform_s: NDArray[np.float64]
    los_acceleration_platform_s2: NDArray[np.float64]
    range_m: NDArray[np.float64]
    clearance_rad: NDArray[np.float64]


def line_of_sight(
    instants: Instants,
    ephemeris: Ephemeris,
    attitude: AttitudeLaw,
    q_platform_from_body: Rotation,
    target: VisibleTarget,
) -> LineOfSight:
    """Apparent line of sight in the platform frame.

    instants: at least 7, uniformly spaced.  The derivatives are 7-point differences of the
    apparent direction itself, so that angles, rates and accelerations belong together for
    every orbit source; their error is (step / 54 s)^5 of the value on a 400 km pass.
    Source: Sumarokov 2016, eq. 10.
    """
    states = ephemeris.states(instants)
    seen = target.apparent(instants, states)
    q_platform_from_eci = q_platform_from_body * attitude.q_body_from_eci(instants, states)
    los_platform = q_platform_from_eci.apply(seen.direction_eci)
    step_s = (instants.t_s[-1] - instants.t_s[0]) / (len(instants.t_s) - 1)
    return LineOfSight(
        instants=instants,
        los_platform=los_platform,
        los_rate_platform_s=_derivative(los_platform, step_s, 1),
        los_acceleration_platform_s2=_derivative(los_platform, step_s, 2),
        range_m=seen.range_m,
        clearance_rad=seen.clearance_rad,
    )


def _derivative(values: NDArray[np.float64], step_s: float, order: int) -> NDArray[np.float64]:
    """Differences on the seven nearest samples, one-sided towards the ends, shape as `values`."""
    n = len(values)
    first = np.clip(np.arange(n) - STENCIL // 2, 0, n - STENCIL)
    weights = np.array([_stencil_weights(here, order) for here in range(STENCIL)])
    nodes = values[first[:, None] + np.arange(STENCIL)]
    differences = np.einsum("nk,nkj->nj", weights[np.arange(n) - first], nodes)
    return np.asarray(differences / step_s**order)


def _stencil_weights(here: int, order: int) -> NDArray[np.float64]:
    """Weights on nodes 0..6 exact for polynomials of degree 6, at node `here`."""
    powers = np.vander(np.arange(STENCIL) - float(here), increasing=True).T
    wanted = np.zeros(STENCIL)
    wanted[order] = float(order)  # order! for order 1 and 2
    return np.linalg.solve(powers, wanted)
