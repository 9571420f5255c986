"""The map of a plan."""

import math
from collections.abc import Iterator
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S
from planner.output.export.description import notes, session_label
from planner.output.export.ground import BORESIGHT_PAYLOAD, Sights, frame_corner_rays, sights
from planner.output.export.map_features import Facts, MapFeature, PlanMap, path_feature, thinned
from planner.output.export.map_shapes import Point, areas, hull
from planner.output.export.runs import runs
from planner.output.export.table_states import TableStates, table_states
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.plan import FlightPlan, Segment
from planner.world.scenario import Session
from planner.world.targets import EarthFixedTarget, Target

FOOTPRINT_EVERY_S = 10.0
FOOTPRINTS_MAX = 30  # of a session
PATH_PLACES = 50  # of a target that moves


def map_of(plan: FlightPlan, created_utc: datetime) -> PlanMap:
    """Footprints every 10 s of a session and at its ends, 30 at most; a swath is their hull."""
    rows = table_states(plan)
    return PlanMap(
        name=plan.scenario.name or "slewtrack plan",
        notes=notes(plan, created_utc),
        features=tuple(_features(plan, rows)),
    )


def _features(plan: FlightPlan, rows: TableStates) -> Iterator[MapFeature]:
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf_from_eci(rows.instants), rows.states.r_sat_eci_m)
    span_utc = rows.instants.utc(0), rows.instants.utc(-1)
    yield path_feature("track", "below the carrier", r_sat_itrf_m, span_utc)
    boresight = sights(rows, BORESIGHT_PAYLOAD)
    for segment in plan.segments:
        yield from _boresight(rows, boresight, segment)
    corners = sights(rows, frame_corner_rays(plan.scenario.platform))
    for number, session in enumerate(plan.scenario.sessions):
        label = session_label(session, number)
        facts: Facts = {"session": number, "mode": session.target.mode}
        if session.target.images:
            yield from _frames(rows, corners, session, label, facts)
        span_utc = session.start, session.stop
        yield from target_features(session.target, span_utc, label, facts)


def _between(rows: TableStates, start_utc: datetime, stop_utc: datetime) -> Indices:
    """Rows from one instant to another, both included."""
    first, last = (
        round(elapsed_s(moment, rows.instants.epoch_utc) * ROWS_PER_S)
        for moment in (start_utc, stop_utc)
    )
    return np.flatnonzero((rows.row >= first) & (rows.row <= last))


def _boresight(rows: TableStates, boresight: Sights, segment: Segment) -> Iterator[MapFeature]:
    """Its stretches on the ground."""
    which = _between(rows, segment.start_utc, segment.stop_utc)
    for first, last in runs(boresight.on_ground[which, 0]):
        stretch = which[first : last + 1]
        yield path_feature(
            "boresight",
            f"boresight: {segment.kind}",
            boresight.end_itrf_m[stretch, 0],
            (rows.instants.utc(stretch[0]), rows.instants.utc(stretch[-1])),
            {"activity": segment.kind, "session": segment.session},
        )


def _frames(
    rows: TableStates, corners: Sights, session: Session, label: str, facts: Facts
) -> Iterator[MapFeature]:
    """Footprints and their swath, while all corners are on the ground."""
    which = _between(rows, session.start, session.stop)
    which = which[corners.on_ground[which].all(axis=1)]
    if not len(which):
        return
    wanted = math.ceil((len(which) - 1) / (FOOTPRINT_EVERY_S * ROWS_PER_S)) + 1
    shown = which[thinned(len(which), min(max(wanted, 2), FOOTPRINTS_MAX))]
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(corners.end_itrf_m[shown])
    for k, row in enumerate(shown):
        yield MapFeature(
            kind="footprint",
            name=f"frame of {label}",
            shape=areas([(latitude_rad[k], longitude_rad[k])]),
            start_utc=rows.instants.utc(row),
            stop_utc=rows.instants.utc(row),
            facts=facts,
        )
    yield MapFeature(
        kind="swath",
        name=f"swath of {label}",
        shape=areas(_swath(latitude_rad, longitude_rad, session.target.rests_on_earth)),
        start_utc=session.start,
        stop_utc=session.stop,
        facts=facts,
    )


def _swath(latitude_rad: Array, longitude_rad: Array, stays: bool) -> list[tuple[Array, Array]]:
    """Hull of all frames about a place at rest; else of each with the next, which overlap."""
    count = len(latitude_rad)
    groups = [range(count)] if stays or count == 1 else [range(k, k + 2) for k in range(count - 1)]
    return [
        hull(latitude_rad[list(group)].ravel(), longitude_rad[list(group)].ravel())
        for group in groups
    ]


def target_features(
    target: Target, span_utc: tuple[datetime, datetime], label: str, facts: Facts
) -> Iterator[MapFeature]:
    """A place, or the path of one that moves; nothing for a target in the sky."""
    if not isinstance(target, EarthFixedTarget):
        return
    start_utc, stop_utc = span_utc
    t_s = np.linspace(0.0, elapsed_s(stop_utc, start_utc), PATH_PLACES)
    r_itrf_m = target.r_target_itrf_m(Instants(start_utc, t_s))
    if not target.rests_on_earth:
        yield path_feature("target", label, r_itrf_m, span_utc, facts)
        return
    latitude_rad, longitude_rad, height_m = geodetic_from_itrf(r_itrf_m[0])
    yield MapFeature(
        kind="target",
        name=label,
        shape=Point(
            round(math.degrees(longitude_rad), 6),
            round(math.degrees(latitude_rad), 6),
            round(float(height_m), 3),
        ),
        start_utc=start_utc,
        stop_utc=stop_utc,
        facts=facts,
    )
