"""When the last manoeuvre in an attitude history ended."""

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array

STEP_S = 300.0
PRESENT_S = 900.0
# About its turning point a swing moves in a quarter of an hour by 0.29 (rms) of what it does where
# it is fastest, which is 3.5 times as much.
MANOEUVRE_RATIO = 6.0
NOISE_RAD = np.deg2rad(0.02)  # below, turns say nothing


def last_manoeuvre_end(t_s: Array, q_body_from_lvlh: Rotation) -> int:
    """The first row of the history after its last manoeuvre; 0 where it holds none.

    t_s: shape (n,), increasing.
    A manoeuvre turns the body against LVLH in five minutes by six times what it does in the last
    quarter of an hour.  One that still goes on, or ended minutes ago, isn't told from a motion
    that was always there.
    """
    after = np.searchsorted(t_s, t_s + STEP_S)
    first = np.flatnonzero(after < len(t_s))
    after = after[first]
    if not len(first):
        return 0
    turn_rad = (q_body_from_lvlh[after] * q_body_from_lvlh[first].inv()).magnitude()
    turn_rad *= STEP_S / (t_s[after] - t_s[first])
    turn_rad = np.maximum(turn_rad, NOISE_RAD)
    present = t_s[after] > t_s[-1] - PRESENT_S
    if not present.any():
        return 0
    usual_rad = np.sqrt(np.mean(turn_rad[present] ** 2))
    manoeuvring = np.flatnonzero(turn_rad > MANOEUVRE_RATIO * usual_rad)
    return int(after[manoeuvring[-1]]) if len(manoeuvring) else 0
