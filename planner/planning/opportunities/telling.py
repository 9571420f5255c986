"""The description of windows: extremes, samples, the sky; compiled."""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.compiled import compiled, lean
from planner.base.vectors import (
    TURN_RAD,
    angle_between,
    cross,
    dot,
    plus,
    scaled,
    vector_at,
    vector_of,
    wrapped,
)
from planner.motion.pointing.reach import Reach, axes_at, axis_rates, off_stops
from planner.planning.opportunities.looks import (
    CarrierTables,
    Places,
    elevation,
    in_platform,
    look,
    place_at,
    sun_elevation,
    to_body,
    to_sun,
    up_at,
)
from planner.planning.opportunities.margins import CLOSENESS, ELEVATION, WindowScene, margin
from planner.planning.opportunities.sweep import OPTIONS as SWEEP
from planner.planning.opportunities.sweep import root_of
from planner.world.frames.time_scales import DAY_S


class TellingOptions(NamedTuple):
    """How closely a window is looked at for its extremes, and how it is told."""

    turning_s: float = 300.0  # in which a rate turns once at most
    cells_min: int = 2
    edge_rad: float = 1e-6  # a window that ends at a stop ends within a microsecond's motion of it


OPTIONS = TellingOptions()


class Told(NamedTuple):
    """Of windows (n,) and k instants each, the closest approach first.

    highest_parameters: (n, 2), when and how high.  seen_parameters: (n, k, 11), time, elevation,
    range, off nadir, Sun's elevation, separations from Sun and Moon, angles, rates.  branch: (n,),
    the pair reported; usable: (n, 2).
    """

    highest_parameters: Array
    seen_parameters: Array
    branch: Indices
    usable: Mask


@lean
def greatest(
    s: WindowScene, kind: int, n: int, start_s: float, stop_s: float
) -> tuple[float, float]:
    """When a margin is greatest from start_s to stop_s, and how great: at an end, or where its
    rate turns."""
    cells = max(math.ceil((stop_s - start_s) / OPTIONS.turning_s), OPTIONS.cells_min)
    at_s, most, low_s, low = start_s, -math.inf, start_s, 1.0
    for k in range(cells + 1):
        high_s = start_s + k / cells * (stop_s - start_s)
        high = margin(s, kind, n, high_s, SWEEP.rate_s)
        turns_s = high_s
        if k > 0 and low > 0.0 > high:
            turns_s = root_of(
                s, kind, n, (low_s, low), (high_s, high), SWEEP.turning_s, SWEEP.rate_s
            )
        if low > 0.0:
            value = margin(s, kind, n, turns_s, 0.0)
            if value > most:
                at_s, most = turns_s, value
        low_s, low = high_s, high
    return at_s, most


@compiled
def highest_over(s: WindowScene, which: Indices) -> Array:
    """When targets stand highest over all the time there is, and how high, (n, 2)."""
    out = np.empty((len(which), 2))
    for w in range(len(which)):
        out[w, 0], most = greatest(s, ELEVATION, which[w], 0.0, s.c.span_s)
        out[w, 1] = most + s.p.resting_parameters[which[w], 6]
    return out


@lean
def _nearer_pair(g: Reach, both_rad: Array, usable: Mask) -> int:
    """Which of two pairs of angles, (2, k, 2), turns the inner axis less; one within the stops all
    along, as it tells of both_rad, before one that isn't."""
    least, branch = math.inf, 0
    for m in range(2):
        inner, usable[m] = 0.0, True
        for k in range(both_rad.shape[1]):
            turn = abs(both_rad[m, k, 1])
            inner = max(inner, turn if turn == turn else math.pi)
            if off_stops(g, (both_rad[m, k, 0], both_rad[m, k, 1])) < -OPTIONS.edge_rad:
                usable[m] = False
        inner += 0.0 if usable[m] else TURN_RAD
        if inner < least:
            least, branch = inner, m
    return branch


@compiled
def tell(s: WindowScene, target: Indices, edge_s: Array, samples: int) -> Told:
    """edge_s: (n, 2).  samples: instants evenly from rise to set."""
    count = len(target)
    highest, seen = np.empty((count, 2)), np.empty((count, samples + 1, 11))
    branch, usable = np.zeros(count, np.intp), np.zeros((count, 2), np.bool_)
    both, sight = np.empty((2, samples + 1, 2)), np.empty((samples + 1, 6))
    for w in range(count):
        n, rise_s, set_s = target[w], edge_s[w, 0], edge_s[w, 1]
        highest[w, 0] = greatest(s, ELEVATION, n, rise_s, set_s)[0]
        highest[w, 1] = elevation(s.c, s.p, n, highest[w, 0])
        for k in range(samples + 1):
            share = (k - 1) / (samples - 1)
            t_s = (1.0 - share) * rise_s + share * set_s
            if k == 0:
                t_s = greatest(s, CLOSENESS, n, rise_s, set_s)[0]
            before = los = after = (0.0, 0.0, 0.0)
            for place in (-1, 1, 0):  # a loop, as code is compiled for each look
                at_s = t_s + place * SWEEP.rate_s
                d, range_m, r_sat, v = look(s.c, s.p, n, at_s)
                before, after, los = after, los, in_platform(s.c, d, at_s)
            rate = scaled(0.5 / SWEEP.rate_s, plus(after, -1.0, before))
            sun, moon = to_body(s.c, 0, r_sat, v, t_s), to_body(s.c, 1, r_sat, v, t_s)
            high_rad, sun_high_rad = elevation(s.c, s.p, n, t_s), sun_elevation(s.c, s.p, n, t_s)
            row = seen[w, k]  # is written only here: after a write all tables are read anew
            row[0], row[1], row[2], row[4] = t_s, high_rad, range_m, sun_high_rad
            row[3] = angle_between(d, scaled(-1.0, r_sat))
            row[5], row[6] = angle_between(d, sun), angle_between(d, moon)
            sight[k, 0], sight[k, 1], sight[k, 2] = los
            sight[k, 3], sight[k, 4], sight[k, 5] = rate
            one, two = axes_at(s.g, los)
            both[0, k, 0], both[0, k, 1] = one
            both[1, k, 0], both[1, k, 1] = two
        branch[w] = _nearer_pair(s.g, both, usable[w])
        for k in range(samples + 1):
            row = seen[w, k]
            for axis in range(2):
                middle = 0.5 * (s.g.low[axis] + s.g.high[axis])
                row[7 + axis] = middle + wrapped(both[branch[w], k, axis] - middle)
            los, rate = vector_of(sight, k, 0), vector_of(sight, k, 3)
            row[9], row[10] = axis_rates(s.g, row[7], los, rate)
    return Told(highest, seen, branch, usable)


@compiled
def look_each(c: CarrierTables, p: Places, which: Indices, t_s: Array) -> tuple[Array, Array]:
    """Directions in ITRF and in the platform's axes side by side, (n, 6); range, elevation, and the
    Sun's elevation, (n, 3)."""
    directions, values = np.empty((len(t_s), 6)), np.empty((len(t_s), 3))
    for k in range(len(t_s)):
        n = which[k]
        d, range_m, _, _ = look(c, p, n, t_s[k])
        directions[k, 0], directions[k, 1], directions[k, 2] = d
        los = in_platform(c, d, t_s[k])
        directions[k, 3], directions[k, 4], directions[k, 5] = los
        values[k, 0] = range_m
        values[k, 1] = elevation(c, p, n, t_s[k])
        values[k, 2] = sun_elevation(c, p, n, t_s[k])
    return directions, values


@compiled
def places_each(p: Places, which: Indices, t_s: Array) -> Array:
    """Positions of targets on the Earth, (n, 3)."""
    r_m = np.empty((len(t_s), 3))
    for k in range(len(t_s)):
        r_m[k, 0], r_m[k, 1], r_m[k, 2] = place_at(p, which[k], t_s[k])
    return r_m


@compiled
def sky_each(
    c: CarrierTables, p: Places, which: Indices, t_s: Array, longitude_rad: Array
) -> Array:
    """Azimuth and elevation of the carrier and of the Sun, and solar time, (n, 5)."""
    out = np.empty((len(t_s), 5))
    for k in range(len(t_s)):
        n, east_rad = which[k], longitude_rad[k]
        r, up = place_at(p, n, t_s[k]), up_at(p, n, t_s[k])
        east = (-math.sin(east_rad), math.cos(east_rad), 0.0)
        north = cross(up, east)
        sun = to_sun(c, r, t_s[k])
        apart = plus(vector_at(c.orbit, c.step_s, t_s[k], 0), -1.0, r)
        for m in range(2):
            v = apart if m == 0 else sun
            e, h = dot(v, east), dot(v, north)
            azimuth_rad = math.atan2(e, h)
            out[k, 2 * m] = azimuth_rad if azimuth_rad >= 0.0 else azimuth_rad + TURN_RAD
            out[k, 2 * m + 1] = math.atan2(dot(v, up), math.sqrt(e * e + h * h))
        days = (east_rad - math.atan2(sun[1], sun[0])) / TURN_RAD + 0.5
        out[k, 4] = (days - math.floor(days)) * DAY_S
    return out
