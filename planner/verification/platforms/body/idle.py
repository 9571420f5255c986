"""The attitude between sessions and at first, by the judge's own Sun and its own triads."""

from datetime import datetime

import numpy as np

from planner.base.arrays import Array, cross
from planner.verification.directions import rotation_matrix
from planner.verification.platforms.body.options import OPTIONS
from planner.verification.sky import sky_sight
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.platforms.body import IdleLaw, InertialIdle, NadirIdle
from planner.world.targets import BodyTarget


def idle_motion(
    law: IdleLaw, epoch_utc: datetime, t_s: float, ephemeris: Ephemeris
) -> tuple[Array, Array]:
    """At one instant: rows of the body's axes in ECI, (3, 3), and the rates in them, rad/s, (3,).

    Rates are central differences of the axes.
    """
    around_s = t_s + OPTIONS.idle_difference_s * np.array([-1.0, 0.0, 1.0])
    sooner, axes, later = idle_axes_eci(law, Instants(epoch_utc, around_s), ephemeris)
    # An axis moves by w x axis: so w is the sum of axis x its velocity, halved.
    velocity = (later - sooner) / (2.0 * OPTIONS.idle_difference_s)
    return axes, np.asarray(axes @ (0.5 * np.sum(cross(axes, velocity), axis=0)))


def idle_axes_eci(law: IdleLaw, instants: Instants, ephemeris: Ephemeris) -> Array:
    """Rows of the body's axes in ECI at n instants, (n, 3, 3)."""
    if isinstance(law, InertialIdle):
        return np.tile(rotation_matrix(law.q_body_from_eci_xyzw), (len(instants), 1, 1))
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


def _triad(toward_direction: Array, aside_direction: Array) -> Array:
    """Rows: along the first, along the part of the second across it, and their product."""
    first = toward_direction / np.linalg.norm(toward_direction, axis=1, keepdims=True)
    third = cross(first, aside_direction)
    third = third / np.linalg.norm(third, axis=1, keepdims=True)
    return np.stack([first, cross(third, first), third], axis=1)
