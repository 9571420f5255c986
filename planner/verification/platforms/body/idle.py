"""The attitude between sessions, by the judge's own Sun and its own triads."""

from datetime import datetime

import numpy as np

from planner.base.arrays import Array, cross
from planner.verification.sky import sky_sight
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.platforms.body import IdleLaw, InertialIdle, NadirIdle
from planner.world.targets import BodyTarget

DIFFERENCE_S = (
    1.0  # a low orbit's idle rate errs by (step / 54 s)^2 / 6 of 0.06 deg/s: 0.01 arcsec/s
)


def idle_motion(
    law: IdleLaw, epoch_utc: datetime, t_s: float, ephemeris: Ephemeris
) -> tuple[Array, Array]:
    """At one instant: rows of the body's axes in ECI, (3, 3), and the rates in them, rad/s, (3,).

    Rates are central differences of the axes.
    """
    around_s = t_s + DIFFERENCE_S * np.array([-1.0, 0.0, 1.0])
    sooner, axes, later = _axes_eci(law, Instants(epoch_utc, around_s), ephemeris)
    # An axis moves by w x axis: so w is the sum of axis x its velocity, halved.
    velocity = (later - sooner) / (2.0 * DIFFERENCE_S)
    return axes, np.asarray(axes @ (0.5 * np.sum(cross(axes, velocity), axis=0)))


def _axes_eci(law: IdleLaw, instants: Instants, ephemeris: Ephemeris) -> Array:
    if isinstance(law, InertialIdle):
        x, y, z, w = np.asarray(law.q_body_from_eci_xyzw) / np.linalg.norm(law.q_body_from_eci_xyzw)
        matrix = [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
        return np.tile(matrix, (len(instants), 1, 1))
    states = ephemeris.states(instants)
    if isinstance(law, NadirIdle):
        toward_eci, aside_eci = -states.r_sat_eci_m, states.v_sat_eci_m_s
        aside_body = law.forward_body
    else:
        sun = BodyTarget(name="sun", grazing_altitude_km=0.0)
        toward_eci = sky_sight(sun, instants, states).apparent_eci
        aside_eci, aside_body = np.tile([0.0, 0.0, 1.0], (len(instants), 1)), law.north
    here = _triad(toward_eci, aside_eci)
    in_body = _triad(np.array([law.direction_body]), np.array([aside_body]))[0]
    # Both triads' vectors are the same three: body axis k in ECI is the sum of their parts.
    return np.asarray(np.einsum("ak,naj->nkj", in_body, here))


def _triad(toward: Array, aside: Array) -> Array:
    """Rows: along the first, along the part of the second across it, and their product."""
    first = toward / np.linalg.norm(toward, axis=1, keepdims=True)
    third = cross(first, aside)
    third = third / np.linalg.norm(third, axis=1, keepdims=True)
    return np.stack([first, cross(third, first), third], axis=1)
