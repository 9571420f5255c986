"""Targets without a window, and why.

The elevation that the carrier reaches, and what closes every window.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from operator import attrgetter

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.effort import at_most
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.closing import Closing, Unseen
from planner.planning.opportunities.margins import NOTHING, scene_of
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.request import OpportunityConditions, OpportunityRequest
from planner.planning.opportunities.scans import scans_by_pass
from planner.planning.opportunities.search import opportunities_however_many
from planner.planning.opportunities.sights import in_sights
from planner.planning.opportunities.telling import highest_over
from planner.planning.opportunities.windows import Windows
from planner.world.frames.time_scales import shifted_utc
from planner.world.targets.earth_fixed import EarthFixedTarget


@dataclass(frozen=True, kw_only=True)
class UnseenOptions:
    """How reasons are looked for."""

    samples: int = 5  # of a window, at which separations are reported
    # so that most have a reason where there is work for some only; each search takes some 0.1 s
    # however few they are
    targets_at_once: int = 500
    most: float = 400_000.0  # of `effort`: some four seconds beside the search


OPTIONS = UnseenOptions()
_NO_WHOLE_LINE = (
    "in no pass is one of its lines within the conditions, and held by the platform, to its end"
)
Reasons = Mapping[int, tuple[Closing, str]]
# The order in which opportunities are narrowed, and the fields of each condition.
_NARROWING: tuple[tuple[Closing, tuple[str, ...]], ...] = (
    ("sun_elevation", ("sun_elevation_min_deg", "sun_elevation_max_deg")),
    ("off_nadir", ("max_off_nadir_deg",)),
    ("sun_keep_out", ("sun_keep_out_deg",)),
    ("moon_keep_out", ("moon_keep_out_deg",)),
    ("ground_sample", ("max_ground_sample_m",)),
    ("glint", ("glint_keep_out_deg",)),
    ("carrier_light", ("carrier_light",)),
    ("duration", ("min_duration_s",)),
)


def unseen_of(request: OpportunityRequest, carrier: Carrier, seen: Indices) -> tuple[Unseen, ...]:
    """Those of the request without a window, and why; seen: rows of those that have one."""
    unseen = np.setdiff1d(np.arange(len(request.targets)), seen).tolist()
    modes = {row: mode for row, mode in request.modes.items() if row in unseen}
    at_middles = request.with_middles()
    known: dict[int, tuple[Closing, str]] = {}
    with at_most(OPTIONS.most):
        because = scans_by_pass(request, modes, carrier, 0.0).because if modes else {}
        for row in _windows_of(at_middles, list(modes)) if modes else ():
            known[row] = "scan", because.get(row, _NO_WHOLE_LINE)
    return unseen_because(at_middles, carrier, unseen, known)


def unseen_because(
    request: OpportunityRequest, carrier: Carrier, unseen: Sequence[int], known: Reasons
) -> tuple[Unseen, ...]:
    """known: reasons of those that have windows, by row of the request's targets."""
    if not unseen:
        return ()
    best_rad, best_s = highest_of(request, carrier, np.array(unseen))
    closed = _closed_conditions(request, unseen, known, best_rad)
    return tuple(
        Unseen(
            row=row,
            target=request.targets[row].id,
            closed_by=closed[row][0],
            because=closed[row][1],
            best_elevation_rad=float(best_rad[n]),
            best_time_utc=shifted_utc(request.start, float(best_s[n])),
        )
        for n, row in enumerate(unseen)
    )


def highest_of(
    request: OpportunityRequest, carrier: Carrier, target: Indices
) -> tuple[Array, Array]:
    """The greatest elevation of each target and when, (n,) each."""
    best_rad, best_s = np.empty(len(target)), np.empty(len(target))
    reach = lookout_of(request.platform, request.attitude).reach
    for rows, sight, which in in_sights(target, request.targets, carrier):
        scene = scene_of(sight.carrier.tables, reach, NOTHING, sight.places)
        best_s[rows], best_rad[rows] = highest_over(scene, which).T
    return best_rad, best_s


def _closed_conditions(
    request: OpportunityRequest, unseen: Sequence[int], known: Reasons, best_rad: Array
) -> dict[int, tuple[Closing, str]]:
    """The cause and the reason of each target."""
    closed = dict(known)
    for row, highest_rad in zip(unseen, best_rad.tolist(), strict=True):
        least_deg = request.least_elevation_deg(request.targets[row].target)
        if math.degrees(highest_rad) < least_deg:
            closed[row] = "elevation", _too_low(request, row, least_deg)
    left = [row for row in unseen if row not in closed]
    with at_most(OPTIONS.most):
        for first in range(0, len(left), OPTIONS.targets_at_once):
            rows = left[first : first + OPTIONS.targets_at_once]
            # Each narrowed request reads its targets anew: of these few only.
            few = replace(request, targets=tuple(request.targets[row] for row in rows))
            found = _narrowed(few, range(len(rows)))
            closed |= {rows[number]: reason for number, reason in found.items()}
    for row in left:
        if row not in closed:
            closed[row] = "work", "to find out takes more work than one request may make"
    return closed


def _narrowed(request: OpportunityRequest, rows: Iterable[int]) -> dict[int, tuple[Closing, str]]:
    """The condition that takes the last window of each, where they are applied one by one."""
    closed: dict[int, tuple[Closing, str]] = {}
    left = list(rows)
    now = replace(
        request,
        conditions=OpportunityConditions(min_elevation_deg=request.conditions.min_elevation_deg),
        samples=OPTIONS.samples,
    )
    narrowing = lookout_of(request.platform, request.attitude).narrowing()
    for _, group in groupby(narrowing, attrgetter("cause")):
        *first, last = group
        wider, now = now, replace(now, platform=last.platform)
        found = _windows_of(now, left) if left else {}
        gone, left = [row for row in left if row not in found], list(found)
        for one in first:  # which of the same kind it is, only where one of them is the cause
            one_by_one = replace(wider, platform=one.platform)
            kept = _windows_of(one_by_one, gone) if gone else {}
            closed |= {row: (one.cause, one.because) for row in gone if row not in kept}
            gone = list(kept)
        closed |= dict.fromkeys(gone, (last.cause, last.because))
    for cause, names in _NARROWING:
        asked = {name: getattr(request.conditions, name) for name in names}
        wider = now
        now = replace(now, conditions=replace(now.conditions, **asked))
        if not left or now == wider:
            continue
        before, found = found, _windows_of(now, left)
        for row in left:
            if row not in found:
                closed[row] = cause, _reason(cause, asked, before[row])
        left = list(found)
    for row in left:  # an edge by a millisecond
        closed[row] = "duration", "its windows are shorter than the least session"
    return closed


def _windows_of(request: OpportunityRequest, rows: Sequence[int]) -> dict[int, Windows]:
    """Windows of each target that has any."""
    targets = tuple(request.targets[row] for row in rows)
    found = opportunities_however_many(replace(request, targets=targets)).windows
    return {rows[n]: found.select(found.target == n) for n in np.unique(found.target).tolist()}


def _too_low(request: OpportunityRequest, row: int, least_deg: float) -> str:
    if isinstance(request.targets[row].target, EarthFixedTarget):
        return f"the carrier stays below {least_deg:g} deg in its sky"
    return f"it stays below {least_deg:g} deg above the limb"


def _reason(cause: Closing, asked: Mapping[str, float | str | None], before: Windows) -> str:
    """before: the windows without this condition."""
    said = ", ".join(
        f"{name} {value:g}" if isinstance(value, float | int) else f"{name} {value}"
        for name, value in asked.items()
        if value is not None
    )
    if cause == "duration":
        longest_s = float((before.set_s - before.rise_s).max())
        return f"its longest window lasts {longest_s:.1f} s: {said}"
    if cause in ("glint", "carrier_light"):
        what = "it lies in sunglint" if cause == "glint" else "the carrier is in the other light"
        return f"whenever it is in sight {what}: {said}"
    seen = before.through
    if cause == "ground_sample":
        least_m = np.nanmin(before.closest.ground_sample_along_m)
        return f"whenever it is in sight a pixel covers, at its closest, {least_m:.1f} m: {said}"
    what, angle_rad = {
        "sun_elevation": ("the Sun stands at", seen.sun_elevation_rad),
        "off_nadir": ("off the nadir it is, at its closest,", before.closest.off_nadir_rad),
        "sun_keep_out": ("from the Sun it is", seen.sun_separation_rad),
        "moon_keep_out": ("from the Moon it is", seen.moon_separation_rad),
    }[cause]
    low, high = (f"{math.degrees(one):.1f}" for one in (angle_rad.min(), angle_rad.max()))
    reached = low if low == high else f"{low} to {high}"
    return f"whenever it is in sight {what} {reached} deg: {said}"
