"""An imaging session for Cesium (CZML): orbit, attitude, optical axis, swaths, requests."""

from collections.abc import Iterator
from datetime import datetime

import numpy as np

from planner.base.rotation import continuous
from planner.output.export.czml_packets import (
    AREA_RGBA,
    TARGET_RGBA,
    Json,
    carrier_packets,
    czml_of,
    document_packet,
    ground_degrees,
    interval_text,
    label,
    orientation,
    samples,
    solid,
    span_text,
)
from planner.output.export.description import carrier_name
from planner.spacecraft.export.ground import AXIS, SessionGround
from planner.spacecraft.export.map import asked_rad
from planner.spacecraft.export.session_table import SessionTable
from planner.spacecraft.export.tables import session_notes
from planner.spacecraft.requests import AreaRequest
from planner.spacecraft.table import TICK_S
from planner.world.frames.time_scales import shifted_utc

_IMAGING_RGBA, _TURNING_RGBA = [0, 220, 90, 255], [255, 160, 0, 255]


def write_czml(plan: SessionTable, created_utc: datetime) -> bytes:
    """A CZML 1.0 document; a swath appears when it is imaged."""
    return czml_of(_packets_of(plan, created_utc))


def _packets_of(plan: SessionTable, created_utc: datetime) -> Iterator[Json]:
    ground = SessionGround(plan)
    instants = ground.instants
    lines = [
        *session_notes(plan, created_utc),
        "positions Earth-fixed (ITRF), m; orientation x y z w from body to Earth-fixed axes",
    ]
    yield document_packet(plan.request.name or "slewtrack imaging session", lines, instants)
    spacecraft = carrier_name(plan.request.orbit)
    q_body_from_eci_xyzw = continuous(ground.q_eci_from_body.inv())
    yield from carrier_packets(
        f"{plan.spacecraft.name} on {spacecraft.name} ({spacecraft.designator})",
        instants,
        ground.r_sat_itrf_m,
        orientation(instants, q_body_from_eci_xyzw, ground.c_itrf_from_eci),
    )
    yield from _axis_packets(ground)
    yield from _swath_packets(ground)
    yield from _asked_packets(plan)


def _axis_packets(ground: SessionGround) -> Iterator[Json]:
    """Green while the camera runs."""
    instants, table = ground.instants, ground.plan.table
    availability = span_text(instants, 0, -1)
    colours: list[Json] = [{"interval": availability, "rgba": _TURNING_RGBA}]
    for window in table.windows:
        span = span_text(instants, window.first_row, window.last_row)
        colours.append({"interval": span, "rgba": _IMAGING_RGBA})
    yield {
        "id": "boresight-end",
        "name": "end of the optical axis",
        "availability": availability,
        "position": samples("cartesian", instants, ground.line.end_itrf_m[:, AXIS], 2),
    }
    yield {
        "id": "boresight",
        "name": "optical axis",
        "availability": availability,
        "polyline": {
            "positions": {"references": ["carrier#position", "boresight-end#position"]},
            "arcType": "NONE",
            "width": 2,
            "material": {"solidColor": {"color": colours}},
        },
    }


def _swath_packets(ground: SessionGround) -> Iterator[Json]:
    table = ground.plan.table
    last_utc = ground.instants.utc(-1)
    for number, window in enumerate(table.windows):
        ring_rad = ground.ring_rad(window)
        if ring_rad is None:
            continue
        start_utc = shifted_utc(table.epoch_utc, window.first_row * TICK_S)
        yield {
            "id": f"swath-{number}",
            "name": f"{window.request}, look {window.look}",
            "availability": interval_text(start_utc, last_utc),
            "polygon": {
                "positions": {"cartographicDegrees": ground_degrees(*ring_rad)},
                "material": solid(AREA_RGBA),
                "height": 0,
            },
        }


def _asked_packets(plan: SessionTable) -> Iterator[Json]:
    """What was asked for, imaged or not, with its name."""
    for number, request in enumerate(plan.request.requests):
        latitude_rad, longitude_rad = asked_rad(request)
        if isinstance(request, AreaRequest):
            latitude_rad, longitude_rad = (
                np.append(angle, angle[0]) for angle in (latitude_rad, longitude_rad)
            )
        positions = ground_degrees(latitude_rad, longitude_rad)
        yield {
            "id": f"target-{number}",
            "name": f"{request.name} ({request.mode})",
            "position": {"cartographicDegrees": positions[:3]},
            "point": {"pixelSize": 6, "color": {"rgba": TARGET_RGBA}},
            "label": label(request.name),
            "polyline": {
                "positions": {"cartographicDegrees": positions},
                "clampToGround": True,
                "width": 2,
                "material": solid(TARGET_RGBA),
            },
        }
