"""The search for opportunities, from the request to its windows."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from planner.base import effort
from planner.base.arrays import Array, Indices
from planner.base.effort import at_most
from planner.base.errors import SearchEnded
from planner.planning.opportunities.carrier import Carrier, carrier_over
from planner.planning.opportunities.margins import (
    CAUSES,
    NOTHING,
    OF_SUN_AND_MOON,
    asked_of,
    scene_of,
)
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.request import OpportunityConditions, OpportunityRequest
from planner.planning.opportunities.sights import Sight, in_sights, resting_sight, sights_of
from planner.planning.opportunities.sweep import OPTIONS as SWEEP
from planner.planning.opportunities.sweep import Found, sweep
from planner.planning.opportunities.telling import sky_each, tell
from planner.planning.opportunities.windows import (
    Opportunities,
    Sightings,
    TargetSky,
    WindowEdges,
    Windows,
    in_order,
)
from planner.world.frames.earth_orientation import earth_orientation_warnings
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants
from planner.world.targets.ground_sample import sample_along_m


@dataclass(frozen=True, kw_only=True)
class WindowSearchOptions:
    """How many targets are searched together, and the work it takes, in rows of `effort`."""

    targets_at_once: int = 5000
    look_rows: float = 0.05  # to look once whether a target can be seen
    window_rows: float = 0.5  # to find a window's extremes
    sample_rows: float = 0.15  # to tell of an instant


OPTIONS = WindowSearchOptions()


class WindowSearch:
    """One carrier with all its targets: what is found follows from the request alone.

    So it can be done anywhere, and again; windows that were found are told of at any time.
    Raises OutsideCoverage where orbit, attitude or Earth orientation are not known.
    """

    def __init__(self, request: OpportunityRequest) -> None:
        self._request = request
        ephemeris = request.orbit.ephemeris(request.start, request.stop)
        lookout = lookout_of(request.platform, request.attitude)
        self.carrier = carrier_over(ephemeris, lookout, request.start, request.stop)
        ends = Instants(request.start, np.array([0.0, self.carrier.span_s]))
        self.warnings = (
            *ephemeris.warnings,
            *lookout.warnings_at(ends),
            *earth_orientation_warnings(ends),
        )

    def find(self) -> WindowEdges:
        """All windows, by no more work than one request may make; raises SearchEnded."""
        with at_most(effort.PLAN):
            plain = [edges for _, _, edges in found_edges(self._request, self.carrier)]
            return in_order([*plain, *self.scans()])
        raise _ended(self._request)

    def scans(self) -> tuple[WindowEdges, ...]:
        """Windows of imaging modes, if there are any of these."""
        from planner.planning.opportunities.scan_windows import scan_edges

        return (scan_edges(self._request, self.carrier),) if self._request.modes else ()

    def tell_scans(self, edges: WindowEdges) -> Windows:
        """What is told of windows of scans, as of the middles of their lines."""
        from planner.planning.opportunities.scan_windows import middles_of

        middles = middles_of(self._request, edges)
        sight = resting_sight(self.carrier, middles, np.zeros(len(edges)))
        return describe_windows(self._request, sight, np.arange(len(edges)), edges)

    def tell(self, edges: WindowEdges) -> Windows:
        """What is told of windows that were found, at least one; raises SearchEnded."""
        targets = self._request.targets
        parts = []
        with at_most(effort.PLAN):
            plain = np.flatnonzero(~edges.are_scans)
            for rows, sight, which in in_sights(edges.target[plain], targets, self.carrier):
                part = edges.select(plain[rows])
                parts.append(describe_windows(self._request, sight, which, part))
            if edges.are_scans.any():
                parts.append(self.tell_scans(edges.select(edges.are_scans)))
            return in_order(parts)
        raise SearchEnded(
            f"to tell of these {len(edges)} windows takes more work than one request may make; ask "
            "for fewer windows or samples at a time",
            field="limit",
        )


def find_opportunities(request: OpportunityRequest) -> Opportunities:
    """All windows of all targets, and what is told of them, by no more work than one request may
    make.

    The orbit is evaluated once, on rows 0.066 rad of its motion apart (60 s for the ISS), and all
    else on polynomials through the rows.  Edges are those of the exact orbit and frames to 0.1 ms,
    where the margin changes by its ordinary rate; windows or gaps shorter than a millisecond may be
    missed.
    Raises OutsideCoverage where orbit, attitude or Earth orientation are not known, SearchEnded.
    """
    with at_most(effort.PLAN):
        return opportunities_however_many(request)
    raise _ended(request)


def _ended(request: OpportunityRequest) -> SearchEnded:
    return SearchEnded(
        f"the windows of these {len(request.targets)} targets take more work than one request may "
        "make; ask for fewer targets, days, samples or conditions at a time",
        field="targets",
    )


def opportunities_however_many(request: OpportunityRequest) -> Opportunities:
    """Search with whatever work that takes."""
    search, lookout = WindowSearch(request), lookout_of(request.platform, request.attitude)
    found = [
        describe_windows(request, sight, which, edges)
        for sight, which, edges in found_edges(request, search.carrier)
    ]
    return Opportunities(
        start_utc=request.start,
        stop_utc=request.stop,
        ids=request.ids,
        angle_names=lookout.angle_names,
        has_branches=lookout.has_branches,
        assumed=request.assumed,
        warnings=search.warnings,
        windows=in_order([*found, *map(search.tell_scans, search.scans())]),
    )


def found_edges(
    request: OpportunityRequest, carrier: Carrier, across_rad: float = math.nan
) -> Iterator[tuple[Sight, Indices, WindowEdges]]:
    """Windows in which all conditions hold, of targets that are treated alike: how these are seen,
    and each window's number among them.

    across_rad: of a line of sight from the plane of its track at most; sessions are then left out.
    """
    lookout = lookout_of(request.platform, request.attitude)
    least_rad = np.deg2rad(
        [request.least_elevation_deg(wanted.target) for wanted in request.targets]
    )
    for numbers, sight in sights_of(carrier, request.targets, least_rad, OPTIONS.targets_at_once):
        conditions = OpportunityConditions()
        if sight.images:
            conditions = lookout.conditions(request.conditions)
        asked = asked_of(
            conditions, lookout.causes, not sight.on_earth, across_rad, request.pixel_rad
        )
        sees_bodies = lookout.sees_bodies or OF_SUN_AND_MOON.intersection(asked.kinds.tolist())
        tables = carrier.tables if sees_bodies else carrier.tables_but_bodies
        scene = scene_of(tables, lookout.reach, asked, sight.places)
        shortest_s = max(request.conditions.min_duration_s, SWEEP.shortest_s)
        found = sweep(scene, carrier.rows, shortest_s, effort.remaining() / OPTIONS.look_rows)
        _count(found.looks)
        held_s = found.edge_s
        if math.isnan(across_rad):
            most = effort.remaining() / OPTIONS.look_rows
            found, held_s, looks = lookout.hold(sight, scene, found, shortest_s, most)
            _count(looks)
            if (duty := request.conditions.duty_cycle) is not None:
                stop_s = np.minimum(held_s[:, 1], held_s[:, 0] + duty.imaging_max_s)
                held_s = np.stack([held_s[:, 0], stop_s], axis=1)
        kept_names = lookout.kept_names(sight.images)
        yield sight, found.target, _edges_of(numbers, found, held_s, kept_names)


def _count(looks: int) -> None:
    """Raises WorkLimitReached where they were ended by it."""
    effort.count(OPTIONS.look_rows * looks)
    effort.charge(0.0)


def _edges_of(
    numbers: Indices, found: Found, held_s: Array, kept_names: tuple[str, ...]
) -> WindowEdges:
    """numbers: the rows of its targets in the request.  held_s: (m, 2)."""
    opened_by, closed_by = np.array([*CAUSES, *kept_names])[found.cause.T]
    return WindowEdges(
        target=numbers[found.target],
        rise_s=found.edge_s[:, 0],
        set_s=found.edge_s[:, 1],
        held_from_s=held_s[:, 0],
        held_to_s=held_s[:, 1],
        opened_by=opened_by,
        closed_by=closed_by,
        scan_parameters=np.full((len(found.target), 7), math.nan),
    )


def describe_windows(
    request: OpportunityRequest, sight: Sight, which: Indices, edges: WindowEdges
) -> Windows:
    """The windows of one sight; which: (m,), the number of each one's target in it."""
    count = len(edges)
    effort.charge((OPTIONS.window_rows + OPTIONS.sample_rows * request.samples) * count)
    edge_s = np.stack([edges.rise_s, edges.set_s], axis=1)
    reach = lookout_of(request.platform, request.attitude).reach
    scene = scene_of(sight.carrier.tables, reach, NOTHING, sight.places)
    told = tell(scene, which, edge_s, request.samples)
    seen = _sightings(told.seen_parameters, request.pixel_rad, sight.on_earth)
    at_s = np.insert(edge_s, 1, told.highest_parameters[:, 0], axis=1)
    return Windows(
        **vars(edges),
        highest_s=told.highest_parameters[:, 0],
        highest_rad=told.highest_parameters[:, 1],
        closest=seen.select_samples(0),
        through=seen.select_samples(slice(1, None)),
        sky=_target_sky(sight, which, at_s),
        branch=told.branch,
        branches=told.usable,
        clear_share=_clear(request, sight, which, edges),
    )


def _clear(request: OpportunityRequest, sight: Sight, which: Indices, edges: WindowEdges) -> Array:
    if request.clouds is None or not (sight.on_earth and sight.images):
        return np.full(len(edges), math.nan)
    middle_s = 0.5 * (edges.rise_s + edges.set_s)
    r_itrf_m = sight.r_target_itrf_m(which, middle_s)
    return request.clouds.clear_over(r_itrf_m, Instants(request.start, middle_s))


def _sightings(seen_parameters: Array, pixel_rad: float, on_earth: bool) -> Sightings:
    """seen_parameters: as of `Told`."""
    columns = np.ascontiguousarray(np.moveaxis(seen_parameters, 2, 0))
    t_s, elevation_rad, range_m, off_nadir_rad, sun_rad, sun_away_rad, moon_away_rad = columns[:7]
    sine = np.sin(elevation_rad) if on_earth else np.ones(elevation_rad.shape)
    return Sightings(
        t_s=t_s,
        elevation_rad=elevation_rad,
        range_m=range_m,
        off_nadir_rad=off_nadir_rad,
        ground_sample_across_m=range_m * pixel_rad,
        ground_sample_along_m=sample_along_m(sine, range_m, pixel_rad),
        sun_elevation_rad=sun_rad,
        sun_separation_rad=sun_away_rad,
        moon_separation_rad=moon_away_rad,
        angle_rad=seen_parameters[..., 7:9],
        rate_rad_s=seen_parameters[..., 9:11],
    )


def _target_sky(sight: Sight, target: Indices, at_s: Array) -> TargetSky:
    """target: (m,); at_s: (m, 3)."""
    if not sight.on_earth:
        nothing = np.full(at_s.shape, math.nan)
        return TargetSky(**{f.name: nothing for f in fields(TargetSky)} | {"t_s": at_s})
    t_s, which = at_s.ravel(), np.repeat(target, at_s.shape[1])
    place = geodetic_from_itrf(sight.r_target_itrf_m(which, t_s))
    seen = sky_each(sight.carrier.tables, sight.places, which, t_s, place[1])
    columns = (t_s, *seen.T, *place)
    return TargetSky(
        **{
            field.name: column.reshape(at_s.shape)
            for field, column in zip(fields(TargetSky), columns, strict=True)
        }
    )
