"""The longest stretch of a refused session over which its target can be held."""

import math

import numpy as np

from planner.base import effort
from planner.base.arrays import Mask
from planner.base.commands import ROWS_PER_S
from planner.base.errors import Refusal
from planner.motion.pointing.keep_out import keep_out_view
from planner.motion.pointing.line_of_sight import STENCIL
from planner.motion.pointing.track import held_cells
from planner.planning.sessions.sequence import RefusedSession
from planner.planning.sessions.track_branches import OPTIONS as HOLDING_OPTIONS
from planner.planning.sessions.track_branches import RowSpan, sight
from planner.world.orbits import Ephemeris
from planner.world.targets import BenchMotionTarget

AWAY_ROWS = ROWS_PER_S  # from a cone or mask, out of which no slew comes at once
LOOKS_MAX = 20_000  # of more than an hour not every row is looked at


def longest_hold(refused: RefusedSession, ephemeris: Ephemeris) -> RowSpan | None:
    """Rows of the session as asked; None where nothing of it can be held, or that isn't known.

    On one branch throughout: one pair of axis angles, seen, within stops and limits and out of all
    cones and masks.  Whether it can be slewed onto is not looked at.
    """
    scenario, wanted, target = refused.scenario, refused.wanted, refused.session.target
    start = max(wanted.start, refused.from_row + 1)
    if isinstance(target, BenchMotionTarget) or wanted.stop - start < 2 * STENCIL:
        return None
    stride = math.ceil((wanted.stop - start) / LOOKS_MAX)
    count = (wanted.stop - start) // stride + 1
    rows = RowSpan(start=start, stop=start + (count - 1) * stride)
    effort.charge(HOLDING_OPTIONS.hold + HOLDING_OPTIONS.hold_row * count)
    try:
        los = sight(scenario, ephemeris, target, rows, count)
        view = keep_out_view(scenario, ephemeris, rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S)
    except Refusal:  # nothing is known of the orbit or attitude then
        return None
    platform = scenario.platform.with_limits(scenario.axis_limits)
    longest: RowSpan | None = None
    for angle_rad, held in held_cells(platform, los):
        held &= (los.clearance_rad[1:] >= 0.0) & (los.clearance_rad[:-1] >= 0.0)
        if view is not None:
            effort.charge(HOLDING_OPTIONS.cone_row * count * len(view.regions))
            t_s = los.instants.t_s - los.instants.t_s[0]
            inside = view.depths_rad(t_s, angle_rad).max(axis=0) > 0.0
            near = np.convolve(inside, np.ones(2 * AWAY_ROWS + 1), "same") > 0.0
            held &= ~(near[1:] | near[:-1])
        cells = _longest_run(held)
        if longest is None or (cells.stop - cells.start) * stride > longest.stop - longest.start:
            longest = RowSpan(start=start + cells.start * stride, stop=start + cells.stop * stride)
    return longest if longest is not None and longest.stop > longest.start else None


def _longest_run(held: Mask) -> RowSpan:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]))).reshape(-1, 2)
    if not len(edges):
        return RowSpan(start=0, stop=0)
    start, stop = edges[np.argmax(edges[:, 1] - edges[:, 0])].tolist()
    return RowSpan(start=start, stop=stop)
