"""Drag in an ephemeris, from the decay of its orbit from one day to the next."""

import numpy as np

from planner.base.arrays import Array
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.time_scales import DAY_S
from planner.world.messages.oem import OemSegment
from planner.world.orbits.gravity import RADIUS_M

UNKNOWN_DRAG_IN_A_DAY_M = 12000.0  # of an arc too short to tell: the ISS's in February 2024
_J2 = 1.0826e-3
_MEANS_AN_ORBIT = 4


def drag_in_a_day_m(segments: tuple[OemSegment, ...]) -> float:
    """How far along the track drag takes the satellite in a day.

    From the semi-major axis averaged over an orbit, as the median of what it loses from one day to
    the next, when the Earth has turned back beneath it: a burn is in few of such pairs.  Of the
    last segment that is long enough.
    """
    for segment in reversed(segments):
        axis_m, t_s = _semi_major_axis_m(segment), segment.t_s
        if (axis_m <= 0.0).any():
            continue
        mean_m = float(np.mean(axis_m))
        rate_rad_s = float(np.sqrt(MU_EARTH_M3_S2 / mean_m**3))
        orbit_s = 2.0 * np.pi / rate_rad_s
        begin_s = np.arange(t_s[0], t_s[-1] - orbit_s - DAY_S, orbit_s / _MEANS_AN_ORBIT)
        if not len(begin_s):
            continue
        steps_m_s = 0.5 * (axis_m[1:] + axis_m[:-1]) * np.diff(t_s)
        sum_m_s = np.concatenate([[0.0], np.cumsum(steps_m_s)])
        of_orbits_m_s = [
            np.interp(at_s + orbit_s, t_s, sum_m_s) - np.interp(at_s, t_s, sum_m_s)
            for at_s in (begin_s, begin_s + DAY_S)
        ]
        lost_m = float(np.median(of_orbits_m_s[0] - of_orbits_m_s[1])) / orbit_s
        return float(0.75 * rate_rad_s * DAY_S * abs(lost_m))
    return UNKNOWN_DRAG_IN_A_DAY_M


def _semi_major_axis_m(segment: OemSegment) -> Array:
    """By the energy, the Earth's flattening included, (n,); negative where nothing holds it."""
    r_m, v_m_s = segment.r_m, segment.v_m_s
    if segment.frame == "ITRF":
        v_m_s = v_m_s + np.cross([0.0, 0.0, OMEGA_EARTH_RAD_S], r_m)
    radius_m = np.linalg.norm(r_m, axis=1)
    flat = 0.5 * _J2 * (RADIUS_M / radius_m) ** 2 * (1.0 - 3.0 * (r_m[:, 2] / radius_m) ** 2)
    energy = 0.5 * np.sum(v_m_s**2, axis=1) - MU_EARTH_M3_S2 / radius_m * (1.0 + flat)
    return np.asarray(-MU_EARTH_M3_S2 / (2.0 * energy))
