"""The map of an imaging session as GeoJSON and KML."""

from collections.abc import Iterator
from datetime import datetime

import numpy as np

from planner.base.arrays import Array
from planner.output.export.geojson import geojson_of
from planner.output.export.kml import kml_of
from planner.output.export.map_features import Facts, MapFeature, PlanMap, path_feature
from planner.output.export.map_shapes import Shape, areas, line
from planner.spacecraft.export.ground import AXIS, SessionGround
from planner.spacecraft.export.session_table import SessionTable
from planner.spacecraft.export.tables import session_notes
from planner.spacecraft.requests import AreaRequest, Request
from planner.spacecraft.table import TICK_S
from planner.world.frames.time_scales import shifted_utc


def write_geojson(plan: SessionTable, created_utc: datetime) -> bytes:
    """The ground track, what each window images, and what was asked for."""
    return geojson_of(map_of(plan, created_utc))


def write_kml(plan: SessionTable, created_utc: datetime) -> bytes:
    """The ground track, what each window images, and what was asked for."""
    return kml_of(map_of(plan, created_utc))


def map_of(plan: SessionTable, created_utc: datetime) -> PlanMap:
    """Requests are told of whether they are imaged or not."""
    return PlanMap(
        name=plan.request.name or "slewtrack imaging session",
        notes=session_notes(plan, created_utc),
        features=tuple(_map_features(plan)),
    )


def _map_features(plan: SessionTable) -> Iterator[MapFeature]:
    ground = SessionGround(plan)
    span_utc = ground.instants.utc(0), ground.instants.utc(-1)
    yield path_feature("track", "below the spacecraft", ground.r_sat_itrf_m, span_utc)
    for window in plan.table.windows:
        start_utc, stop_utc = (
            shifted_utc(plan.table.epoch_utc, row * TICK_S)
            for row in (window.first_row, window.last_row)
        )
        facts: Facts = {"request": window.request, "look": window.look}
        rows = slice(window.first_row, window.last_row + 1)
        yield path_feature(
            "boresight",
            f"line of {window.request}, look {window.look}",
            ground.line.end_itrf_m[rows, AXIS],
            (start_utc, stop_utc),
            facts,
        )
        ring_rad = ground.ring_rad(window)
        if ring_rad is not None:
            yield MapFeature(
                kind="swath",
                name=f"swath of {window.request}, look {window.look}",
                shape=areas([ring_rad]),
                start_utc=start_utc,
                stop_utc=stop_utc,
                facts=facts,
            )
    imaged = {window.request for window in plan.table.windows}
    for request in plan.request.requests:
        yield MapFeature(
            kind="target",
            name=request.name,
            shape=asked_shape(request),
            facts={
                "mode": request.mode,
                "priority": request.priority,
                "imaged": "yes" if request.name in imaged else "no",
            },
        )


def asked_shape(request: Request) -> Shape:
    """The line or the polygon, between its positions straight on the map."""
    latitude_rad, longitude_rad = asked_rad(request)
    if isinstance(request, AreaRequest):
        return areas([(latitude_rad, longitude_rad)])
    return line(latitude_rad, longitude_rad)


def asked_rad(request: Request) -> tuple[Array, Array]:
    """Latitudes and longitudes of the positions asked for; a ring's first only once."""
    if isinstance(request, AreaRequest):
        positions = request.geometry.coordinates[0][:-1]
    else:
        positions = request.geometry.coordinates
    longitude_rad, latitude_rad = np.radians([position[:2] for position in positions]).T
    return latitude_rad, longitude_rad
