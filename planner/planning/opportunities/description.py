"""The description of each window: closest approach, elevation, axis angles, light."""

import math

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Indices
from planner.motion.pointing.angles import axis_angles, axis_motion
from planner.planning.opportunities.conditions import (
    off_nadir_rad,
    reach_margin_rad,
    separation_rad,
    within_stops,
)
from planner.planning.opportunities.ground_sample import sample_along_m
from planner.planning.opportunities.request import OpportunityRequest
from planner.planning.opportunities.sights import EarthSight, Sight
from planner.planning.opportunities.spans import Margin, Spans, nodes_over, turning_point
from planner.planning.opportunities.target_sky import target_sky
from planner.planning.opportunities.windows import Sightings, Windows
from planner.world.platforms import TwoAxisPlatform

_DELTA_S = 0.05  # rates are differences over twice this: 1e-7 of the rate on a 400 km pass
_EDGE_RAD = 1e-6  # a window that ends at a stop ends within a microsecond's motion of it
_STEP_S = 600.0  # windows shorter than three of these hold one approach


def describe_windows(
    request: OpportunityRequest,
    sight: Sight,
    numbers: Indices,
    spans: Spans,
    held_s: tuple[Array, Array],
) -> Windows:
    """The windows of one sight; numbers: its targets' rows in the request.

    held_s: the parts that a session can hold.
    """
    highest_s = _greatest_at(sight.clearance_rad, sight, spans)
    share = np.linspace(0.0, 1.0, request.samples)
    t_s = np.concatenate(
        [
            _greatest_at(sight.closeness, sight, spans)[:, None],
            (1.0 - share) * spans.start_s[:, None] + share * spans.stop_s[:, None],
        ],
        axis=1,
    )
    which = np.repeat(spans.target, request.samples + 1)
    sightings, branch, branches = _sightings_at(request, sight, which, t_s)
    return Windows(
        target=numbers[spans.target],
        rise_s=spans.start_s,
        set_s=spans.stop_s,
        held_from_s=held_s[0],
        held_to_s=held_s[1],
        opened_by=spans.opened_by,
        closed_by=spans.closed_by,
        highest_s=highest_s,
        highest_rad=sight.sighting(spans.target, highest_s).elevation_rad,
        closest=sightings.select_samples(0),
        through=sightings.select_samples(slice(1, None)),
        sky=target_sky(
            sight, spans.target, np.stack([spans.start_s, highest_s, spans.stop_s], axis=1)
        ),
        branch=branch,
        branches=branches,
    )


def _greatest_at(function: Margin, sight: Sight, spans: Spans) -> Array:
    """When a function is greatest in each span, (m,)."""
    nodes = nodes_over(spans, sight, _STEP_S, math.inf)
    values = function(nodes.target[nodes.group], nodes.t_s)
    ascending = np.lexsort((values, nodes.group))
    last = np.append(nodes.group[1:] != nodes.group[:-1], True)[: len(values)]
    best = ascending[last]
    inside = np.roll(~last, 1)[best], ~last[best]
    return turning_point(
        function, spans.target, nodes.t_s[best - inside[0]], nodes.t_s[best + inside[1]]
    )


def _sightings_at(
    request: OpportunityRequest, sight: Sight, which: Indices, at_s: Array
) -> tuple[Sightings, Indices, NDArray[np.bool_]]:
    """Sightings at at_s (m, k); the branch reported, (m,), and the usable ones, (m, 2)."""
    t_s, shape, carrier = at_s.ravel(), at_s.shape, sight.carrier
    seen = sight.sighting(which, t_s)
    direction_itrf, range_m = seen.direction_itrf, seen.range_m
    pixel_rad = request.pixel_rad
    sine = np.sin(seen.elevation_rad) if isinstance(sight, EarthSight) else np.ones(len(t_s))
    los_platform = carrier.in_platform(direction_itrf, t_s)
    angle_rad, branch, branches = _pointing_at(request.platform, los_platform, shape)
    columns = {
        "t_s": t_s,
        "elevation_rad": seen.elevation_rad,
        "range_m": range_m,
        "off_nadir_rad": off_nadir_rad(direction_itrf, carrier, t_s),
        "ground_sample_across_m": range_m * pixel_rad,
        "ground_sample_along_m": sample_along_m(sine, range_m, pixel_rad),
        "sun_elevation_rad": sight.sun_elevation_rad(which, t_s),
        "sun_separation_rad": separation_rad(direction_itrf, carrier.r_sun_itrf_m, carrier, t_s),
        "moon_separation_rad": separation_rad(direction_itrf, carrier.r_moon_itrf_m, carrier, t_s),
        "angle_rad": angle_rad,
        "rate_rad_s": _axis_rates(request.platform, sight, which, t_s, angle_rad, los_platform),
    }
    shaped = {name: values.reshape(*shape, *values.shape[1:]) for name, values in columns.items()}
    return Sightings(**shaped), branch, branches


def _pointing_at(
    platform: TwoAxisPlatform, los_platform: Array, shape: tuple[int, ...]
) -> tuple[Array, Indices, NDArray[np.bool_]]:
    """Angles on the chosen branch, (m k, 2), that branch, (m,), and the usable ones, (m, 2)."""
    both_rad = axis_angles(platform, los_platform).angle_rad
    margin_rad = reach_margin_rad(platform, both_rad).reshape(2, *shape)
    usable = np.asarray((margin_rad >= -_EDGE_RAD).all(axis=2))
    inner_rad = np.abs(np.nan_to_num(both_rad[:, :, 1], nan=math.pi)).reshape(2, *shape)
    branch = np.argmin(inner_rad.max(axis=2) + np.where(usable, 0.0, 2.0 * math.pi), axis=0)
    chosen_rad = both_rad[np.repeat(branch, shape[1]), np.arange(len(los_platform))]
    return within_stops(platform, chosen_rad), branch, usable.T


def _axis_rates(
    platform: TwoAxisPlatform,
    sight: Sight,
    which: Indices,
    t_s: Array,
    angle_rad: Array,
    los_platform: Array,
) -> Array:
    """Axis rates, (n, 2), at angles (n, 2)."""
    before, after = (
        sight.carrier.in_platform(sight.sighting(which, t).direction_itrf, t)
        for t in (t_s - _DELTA_S, t_s + _DELTA_S)
    )
    los_rate_s = (after - before) / (2.0 * _DELTA_S)
    still = np.zeros_like(los_rate_s)
    return axis_motion(platform, angle_rad, los_platform, los_rate_s, still)[0]
