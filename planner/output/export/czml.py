"""A plan for Cesium (CZML): orbit, ground track, boresight, footprint, targets on the globe."""

import math
from collections.abc import Iterable
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S
from planner.output.export.czml_packets import (
    AREA_RGBA,
    TARGET_RGBA,
    Json,
    carrier_packets,
    czml_of,
    document_packet,
    html_text,
    interval_text,
    label,
    orientation,
    samples,
    solid,
    span_text,
)
from planner.output.export.description import carrier_name, notes, session_label
from planner.output.export.ground import BORESIGHT_PAYLOAD, FRAME_CORNERS, frame_corner_rays, sights
from planner.output.export.runs import runs
from planner.output.export.table_states import TableStates, table_states
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.orbits import OrbitStates
from planner.world.plan import FlightPlan
from planner.world.platforms import AnyPlatform
from planner.world.scenario import Session
from planner.world.targets import EarthFixedTarget, SkyTarget

ROWS_MAX = 20_000  # as the view has at most; all rows of a day are 129 MB
SKY_DISTANCE_M = 1e7  # where a star's or planet's mark is drawn: well outside, still in view
_KIND_RGBA = {
    "wait": [160, 160, 160, 255],
    "slew": [255, 160, 0, 255],
    "track": [0, 220, 90, 255],
    "brake": [255, 160, 0, 255],
}


def write_czml(plan: FlightPlan, created_utc: datetime) -> bytes:
    """A CZML 1.0 document; what isn't known at an instant isn't available then.

    Of a table longer than ROWS_MAX every so many rows and the last one, as its text says.
    `carrier` and `payload` carry orientations: unit quaternions x, y, z, w that turn vectors
    from body or payload axes to Earth-fixed axes.
    """
    count = len(plan.table.t_s)
    every = math.ceil(count / ROWS_MAX)
    rows = table_states(plan, np.unique(np.append(np.arange(0, count, every), count - 1)))
    c_itrf = c_itrf_from_eci(rows.instants)
    boresight = sights(rows, BORESIGHT_PAYLOAD)
    packets = [
        _document(plan, rows, created_utc, every),
        *_spacecraft(plan, rows, c_itrf),
        *_boresight(plan, rows, boresight.end_itrf_m[:, 0]),
        *_footprint(rows, plan.scenario.platform),
        *(
            packet
            for number, session in enumerate(plan.scenario.sessions)
            for packet in _target(number, session, rows, c_itrf)
        ),
    ]
    return czml_of(packets)


def _document(plan: FlightPlan, rows: TableStates, created_utc: datetime, every: int) -> Json:
    platform = plan.scenario.platform
    along, across = 2.0 * np.degrees(platform.frame_half_rad)
    turn_deg = np.degrees(platform.frame_turn_rad)
    lines = [
        *notes(plan, created_utc),
        "positions Earth-fixed (ITRF), m; orientations x y z w from body or payload axes "
        f"to Earth-fixed axes; footprint on the WGS84 ellipsoid, {along:.4g} x "
        f"{across:.4g} deg, the first along payload +X"
        + (f" turned by {turn_deg:.4g} deg about +Z" if turn_deg else ""),
    ]
    if every > 1:
        lines.append(
            f"a sample every {every * COMMAND_STEP_S:g} s, of each {every} rows one, interpolated "
            "between: to look at; other formats have all rows"
        )
    return document_packet(plan.scenario.name or "slewtrack plan", lines, rows.instants)


def _spacecraft(plan: FlightPlan, rows: TableStates, c_itrf: Array) -> Iterable[Json]:
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, rows.states.r_sat_eci_m)
    spacecraft = carrier_name(plan.scenario.orbit)
    yield from carrier_packets(
        f"{spacecraft.name} ({spacecraft.designator})",
        rows.instants,
        r_sat_itrf_m,
        orientation(rows.instants, rows.q_body_from_eci_xyzw, c_itrf),
    )
    yield {
        "id": "payload",
        "name": f"payload on {plan.scenario.platform.name}",
        "availability": span_text(rows.instants, 0, -1),
        "position": {"reference": "carrier#position"},
        "orientation": orientation(rows.instants, rows.q_payload_from_eci_xyzw, c_itrf),
    }


def _boresight(plan: FlightPlan, rows: TableStates, end_itrf_m: Array) -> list[Json]:
    availability = span_text(rows.instants, 0, -1)
    colours = [
        {
            "interval": interval_text(segment.start_utc, segment.stop_utc),
            "rgba": _KIND_RGBA[segment.kind],
        }
        for segment in plan.segments
    ]
    return [
        {
            "id": "boresight-end",
            "name": "end of the boresight",
            "availability": availability,
            "position": samples("cartesian", rows.instants, end_itrf_m, 2),
        },
        {
            "id": "boresight",
            "name": "boresight",
            "description": html_text(["grey: at rest; orange: slew; green: tracking"]),
            "availability": availability,
            "polyline": {
                "positions": {"references": ["carrier#position", "boresight-end#position"]},
                "arcType": "NONE",
                "width": 2,
                "material": {"solidColor": {"color": colours}},
            },
        },
    ]


def _footprint(rows: TableStates, platform: AnyPlatform) -> list[Json]:
    """The frame's outline while all four corners are on the ground."""
    corners = sights(rows, frame_corner_rays(platform))
    stretches = list(runs(np.asarray(corners.on_ground.all(axis=1))))
    if not stretches:
        return []
    spans = [span_text(rows.instants, first, last) for first, last in stretches]
    names = [f"footprint-{number}" for number in range(len(FRAME_CORNERS))]
    on_ground = np.concatenate([np.arange(first, last + 1) for first, last in stretches])
    return [
        *(
            {
                "id": name,
                "availability": spans,
                "position": samples(
                    "cartesian", rows.instants, corners.end_itrf_m[:, number], 2, which=on_ground
                ),
            }
            for number, name in enumerate(names)
        ),
        {
            "id": "footprint",
            "name": "frame of the camera",
            "availability": spans,
            "polygon": {
                "positions": {"references": [f"{name}#position" for name in names]},
                "material": solid(AREA_RGBA),
                "height": 0,
            },
        },
    ]


def _target(number: int, session: Session, rows: TableStates, c_itrf: Array) -> Iterable[Json]:
    """A mark available during the session; nothing for a test motion, which has no target."""
    target = session.target
    first = _row_at(rows, session.start)
    last = _row_at(rows, session.stop)
    which = np.arange(max(first - 1, 0), min(last + 2, len(rows.instants)))
    instants = Instants(rows.instants.epoch_utc, rows.instants.t_s[which])
    if isinstance(target, EarthFixedTarget):
        place_itrf_m = target.r_target_itrf_m(instants)
        where = "on the Earth"
    elif isinstance(target, SkyTarget):
        states = OrbitStates(rows.states.r_sat_eci_m[which], rows.states.v_sat_eci_m_s[which])
        direction_eci = target.apparent(instants, states).direction_eci
        end_eci_m = states.r_sat_eci_m + SKY_DISTANCE_M * direction_eci
        place_itrf_m = np.einsum("nij,nj->ni", c_itrf[which], end_eci_m)
        where = "the direction counts, not the distance"
    else:
        return
    name = session_label(session, number)
    yield {
        "id": f"target-{number}",
        "name": f"target of {name} ({target.mode})",
        "description": html_text([where]),
        "availability": interval_text(session.start, session.stop),
        "position": _place(rows, place_itrf_m, which),
        "point": {"pixelSize": 9, "color": {"rgba": TARGET_RGBA}},
        "label": label(name),
    }


def _place(rows: TableStates, place_itrf_m: Array, which: Indices) -> Json:
    if np.ptp(place_itrf_m, axis=0).max() == 0.0:
        return {"cartesian": np.round(place_itrf_m[0], 3).tolist()}
    positions = np.zeros((len(rows.instants), 3))
    positions[which] = place_itrf_m
    return samples("cartesian", rows.instants, positions, 3, degree=5, which=which)


def _row_at(rows: TableStates, moment_utc: datetime) -> int:
    since_s = elapsed_s(moment_utc, rows.instants.epoch_utc)
    return int(np.argmin(np.abs(rows.instants.t_s - since_s)))
