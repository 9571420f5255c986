"""Reasons why a target can't be observed.

The elevation that the carrier reaches, and what closes every window.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from planner.base.arrays import Array, Indices
from planner.planning.campaigns.chosen import Unseen
from planner.planning.campaigns.passes import Looks
from planner.planning.campaigns.request import CampaignRequest, Closing
from planner.planning.opportunities import (
    OpportunityConditions,
    Windows,
    opportunities_however_many,
)
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.search import highest
from planner.planning.opportunities.sights import in_sights
from planner.world.frames.time_scales import shifted_utc
from planner.world.targets.earth_fixed import EarthFixedTarget

SAMPLES = 5  # of a window, at which separations are reported
# The order in which opportunities are narrowed, and the fields of each condition.
_NARROWING: tuple[tuple[Closing, tuple[str, ...]], ...] = (
    ("reach", ()),
    ("mask", ()),
    ("sun_elevation", ("sun_elevation_min_deg", "sun_elevation_max_deg")),
    ("off_nadir", ("max_off_nadir_deg",)),
    ("sun_keep_out", ("sun_keep_out_deg",)),
    ("moon_keep_out", ("moon_keep_out_deg",)),
    ("duration", ("min_duration_s",)),
)


def unseen_because(
    request: CampaignRequest,
    carrier: Carrier,
    unseen: Sequence[int],
    windows: Windows,
    looks: Looks,
) -> tuple[Unseen, ...]:
    """windows: all that were found.  looks: what was left of them between rests."""
    if not unseen:
        return ()
    best_rad, best_s = _highest(request, carrier, np.array(unseen))
    closed = _closed_conditions(request, unseen, windows, looks, best_rad)
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


def _highest(request: CampaignRequest, carrier: Carrier, target: Indices) -> tuple[Array, Array]:
    """The greatest elevation of each target and when, (n,) each."""
    targets = [wanted.target for wanted in request.targets]
    best_rad, best_s = np.empty(len(target)), np.empty(len(target))
    for rows, sight, which in in_sights(target, targets, carrier):
        best_s[rows], best_rad[rows] = highest(sight, request.platform, which).T
    return best_rad, best_s


def _closed_conditions(
    request: CampaignRequest,
    unseen: Sequence[int],
    windows: Windows,
    looks: Looks,
    best_rad: Array,
) -> dict[int, tuple[Closing, str]]:
    """The cause and the reason of each target."""
    closed: dict[int, tuple[Closing, str]] = {}
    for row, highest_rad in zip(unseen, best_rad.tolist(), strict=True):
        least_deg = _least_elevation_deg(request, row)
        if math.degrees(highest_rad) < least_deg:
            closed[row] = "elevation", _too_low(request, row, least_deg)
        elif (windows.target == row).any():
            closed[row] = _closed_later(request, row, windows, looks)
    left = [row for row in unseen if row not in closed]
    conditions = OpportunityConditions(min_elevation_deg=request.conditions.min_elevation_deg)
    before: dict[int, Windows] = {}
    for cause, names in _NARROWING:
        if not left:
            break
        asked = {name: getattr(request.conditions, name) for name in names}
        conditions = replace(conditions, **asked)
        now = _windows_of(request, left, conditions, masked=cause != "reach")
        for row in left:
            if row not in now:
                closed[row] = cause, _reason(cause, asked, before.get(row))
        left, before = list(now), now
    for row in left:  # an edge by a millisecond
        closed[row] = "duration", "its windows are shorter than the least session"
    return closed


def _windows_of(
    request: CampaignRequest,
    rows: Sequence[int],
    conditions: OpportunityConditions,
    *,
    masked: bool,
) -> dict[int, Windows]:
    """Windows of each target that has any; masked: by what stands in the platform's view too."""
    wanted = request.opportunities()
    platform = wanted.platform if masked else replace(wanted.platform, masks=())
    found = opportunities_however_many(
        replace(
            wanted,
            platform=platform,
            targets=tuple(wanted.targets[row] for row in rows),
            conditions=conditions,
            samples=SAMPLES,
        )
    ).windows
    return {rows[n]: found.select(found.target == n) for n in np.unique(found.target).tolist()}


def _least_elevation_deg(request: CampaignRequest, row: int) -> float:
    target, asked_deg = request.targets[row].target, request.conditions.min_elevation_deg
    if not isinstance(target, EarthFixedTarget):
        return asked_deg
    return max(target.min_elevation_deg, asked_deg)


def _too_low(request: CampaignRequest, row: int, least_deg: float) -> str:
    if isinstance(request.targets[row].target, EarthFixedTarget):
        return f"the carrier stays below {least_deg:g} deg in its sky"
    return f"it stays below {least_deg:g} deg above the limb"


def _closed_later(
    request: CampaignRequest, row: int, windows: Windows, looks: Looks
) -> tuple[Closing, str]:
    """Why no observation of a target with windows that hold all conditions."""
    own = windows.select(windows.target == row)
    least_s = request.targets[row].lengths_s[0]
    longest_s = float((own.set_s - own.rise_s).max())
    several = f"the longest of its {len(own)} windows" if len(own) > 1 else "its only window"
    if longest_s < least_s:
        return (
            "duration",
            f"{several} lasts {longest_s:.1f} s, less than the {least_s:g} s of a look",
        )
    if not (looks.target == row).any():
        return "rest", (
            f"no {least_s:g} s of its windows are left beside the time the axes need to leave "
            "their rest and to come back to it"
        )
    return "motion", (
        f"the axes can't follow it for {least_s:g} s within their stops, rates and accelerations"
    )


def _reason(cause: Closing, asked: Mapping[str, float | None], before: Windows | None) -> str:
    """before: the windows without this condition."""
    said = ", ".join(f"{name} {value:g}" for name, value in asked.items() if value is not None)
    if cause == "reach" or before is None:
        return "no angles of the axes within their stops point there while it is in sight"
    if cause == "mask":
        return "what stands in the platform's view hides it whenever the axes can point there"
    if cause == "duration":
        longest_s = float((before.set_s - before.rise_s).max())
        return f"its longest window lasts {longest_s:.1f} s: {said}"
    seen = before.through
    best_deg = np.degrees(
        {
            "sun_elevation": _angle_range(seen.sun_elevation_rad),
            "off_nadir": _angle_range(before.closest.off_nadir_rad),
            "sun_keep_out": _angle_range(seen.sun_separation_rad),
            "moon_keep_out": _angle_range(seen.moon_separation_rad),
        }[cause]
    )
    what = {
        "sun_elevation": "the Sun stands at",
        "off_nadir": "off the nadir it is, at its closest,",
        "sun_keep_out": "from the Sun it is",
        "moon_keep_out": "from the Moon it is",
    }[cause]
    low, high = (f"{one:.1f}" for one in best_deg)
    reached = low if low == high else f"{low} to {high}"
    return f"whenever it is in sight {what} {reached} deg: {said}"


def _angle_range(angle_rad: Array) -> tuple[float, float]:
    return float(angle_rad.min()), float(angle_rad.max())
