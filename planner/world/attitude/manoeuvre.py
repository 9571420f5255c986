"""Since when an attitude goes on as it does, a manoeuvre having begun or ended; how it may turn."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation


@dataclass(frozen=True, kw_only=True)
class ManoeuvreOptions:
    """When a turn of the carrier is taken for a manoeuvre."""

    step_s: float = 300.0  # over which a turn is measured
    present_s: float = 900.0  # before it: what turns usually were, to which it is compared
    # About its turning point a swing moves in a quarter of an hour by 0.29 (rms) of what it does
    # where it is fastest, which is 3.5 times as much.
    manoeuvre_ratio: float = 6.0
    noise_rad: float = np.deg2rad(0.02)  # below, turns say nothing


OPTIONS = ManoeuvreOptions()

# About each axis of a rotation that may be any: the mean square of its angle is pi^2 / 3 + 2.
RANDOM_RMS_RAD = np.sqrt((np.pi**2 / 3.0 + 2.0) / 3.0)


class Change(NamedTuple):
    """A manoeuvre's begin or end, and the first row after it."""

    row: int
    is_begin: bool


def last_change(t_s: Array, q_body_from_lvlh: Rotation) -> Change | None:
    """None where the history holds no manoeuvre.

    t_s: shape (n,), increasing.
    A manoeuvre turns the body against LVLH in five minutes by six times what it did, or does, in a
    quarter of an hour without.  One that began or ended minutes ago isn't told from a motion that
    was always there.
    """
    after = np.searchsorted(t_s, t_s + OPTIONS.step_s)
    first = np.flatnonzero(after < len(t_s))
    after = after[first]
    if not len(first):
        return None
    turn_rad = (q_body_from_lvlh[after] * q_body_from_lvlh[first].inv()).magnitude()
    turn_rad *= OPTIONS.step_s / (t_s[after] - t_s[first])
    turn_rad = np.maximum(turn_rad, OPTIONS.noise_rad)
    oldest = np.searchsorted(t_s[after], t_s[after] - OPTIONS.present_s, side="right")
    sums = np.concatenate([[0.0], np.cumsum(turn_rad**2)])
    rows = np.arange(len(after)) + 1
    usual_rad = np.sqrt((sums[rows] - sums[oldest]) / (rows - oldest))
    faster = turn_rad > OPTIONS.manoeuvre_ratio * usual_rad[-1]
    slower = usual_rad * OPTIONS.manoeuvre_ratio < usual_rad[-1]
    other = np.flatnonzero(faster | slower)
    if not len(other):
        return None
    return Change(int(after[other[-1]]), bool(slower[other[-1]]))


def turn_rms_rad(lead_s: Array, period_s: float) -> Array:
    """Errors of a manoeuvre under way, about each axis, shape (n,): nothing predicts where it ends.

    It is as likely as not the greatest there is, half a turn from rest to rest, in an orbit.  Flown
    by optimised commands, the ISS takes one to two orbits for a half or quarter turn.
    Source: Bhatt et al., AAS 15, Thermally-constrained fuel-optimal ISS maneuvers.
    """
    share = np.clip(lead_s / period_s, 0.0, 1.0)
    return np.asarray(np.pi * share**2 * (3.0 - 2.0 * share) / np.sqrt(2.0 * 3.0))
