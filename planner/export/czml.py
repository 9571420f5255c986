"""A plan for Cesium (CZML): orbit, boresight, footprint, targets on the globe.

Positions are Earth-fixed (ITRF, taken as WGS84): Cesium turns inertial ones only with tables
it loads from the network.
"""

import html
import json
from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.export.description import carrier_name, notes
from planner.export.exporter import FlightPlan
from planner.export.ground import BORESIGHT_PAYLOAD, FRAME_CORNERS, frame_corner_rays, sights
from planner.export.table_states import TableStates, continuous, table_states
from planner.frames.earth_orientation import c_itrf_from_eci
from planner.frames.time_scales import Instants, elapsed_s, utc_text
from planner.orbits import OrbitStates
from planner.platforms import TwoAxisPlatform
from planner.scenario import Session
from planner.targets import EarthFixedTarget, SkyTarget

Json = dict[str, Any]

SKY_DISTANCE_M = 1e7  # where a star's or planet's mark is drawn: well outside, still in view
_KIND_RGBA = {
    "wait": [160, 160, 160, 255],
    "slew": [255, 160, 0, 255],
    "track": [0, 220, 90, 255],
    "brake": [255, 160, 0, 255],
}
_ORBIT_RGBA, _FRAME_RGBA, _TARGET_RGBA = [90, 170, 255, 255], [0, 220, 90, 110], [255, 60, 60, 255]


def write_czml(plan: FlightPlan, created_utc: datetime) -> bytes:
    """A CZML 1.0 document; what isn't known at an instant isn't available then.

    `carrier` and `payload` carry orientations: unit quaternions x, y, z, w that turn vectors
    from body or payload axes to Earth-fixed axes.
    """
    rows = table_states(plan)
    c_itrf = c_itrf_from_eci(rows.instants)
    boresight = sights(rows, BORESIGHT_PAYLOAD)
    packets = [
        _document(plan, rows, created_utc),
        *_spacecraft(plan, rows, c_itrf),
        *_boresight(plan, rows, boresight.end_itrf_m[:, 0]),
        *_footprint(rows, plan.scenario.platform),
        *(
            packet
            for number, session in enumerate(plan.scenario.sessions)
            for packet in _target(number, session, rows, c_itrf)
        ),
    ]
    return json.dumps(packets, allow_nan=False, separators=(",", ":")).encode()


def _document(plan: FlightPlan, rows: TableStates, created_utc: datetime) -> Json:
    span = _span(rows, 0, -1)
    platform = plan.scenario.platform
    along, across = 2.0 * np.degrees(platform.frame_half_rad)
    turn_deg = np.degrees(platform.frame_turn_rad)
    return {
        "id": "document",
        "name": plan.scenario.name or "slewtrack plan",
        "version": "1.0",
        "description": _html(
            [
                *notes(plan, created_utc),
                "positions Earth-fixed (ITRF), m; orientations x y z w from body or payload axes "
                f"to Earth-fixed axes; footprint on the WGS84 ellipsoid, {along:.4g} x "
                f"{across:.4g} deg, the first along payload +X"
                + (f" turned by {turn_deg:.4g} deg about +Z" if turn_deg else ""),
            ]
        ),
        "clock": {
            "interval": span,
            "currentTime": span.split("/")[0],
            "multiplier": 1,
            "range": "LOOP_STOP",
            "step": "SYSTEM_CLOCK_MULTIPLIER",
        },
    }


def _spacecraft(plan: FlightPlan, rows: TableStates, c_itrf: Array) -> list[Json]:
    r_sat_itrf_m = np.einsum("nij,nj->ni", c_itrf, rows.states.r_sat_eci_m)
    spacecraft = carrier_name(plan.scenario.orbit)
    availability = _span(rows, 0, -1)
    duration_s = float(rows.instants.t_s[-1] - rows.instants.t_s[0])
    return [
        {
            "id": "carrier",
            "name": f"{spacecraft.name} ({spacecraft.designator})",
            "availability": availability,
            "position": _sample("cartesian", rows, r_sat_itrf_m, 3, degree=5),
            "orientation": _orientation(rows, rows.q_body_from_eci_xyzw, c_itrf),
            "point": {"pixelSize": 8, "color": {"rgba": _ORBIT_RGBA}},
            "path": {
                "material": _solid(_ORBIT_RGBA),
                "width": 1.5,
                "leadTime": duration_s,
                "trailTime": duration_s,
                "resolution": 5,
            },
        },
        {
            "id": "payload",
            "name": f"payload on {plan.scenario.platform.name}",
            "availability": availability,
            "position": {"reference": "carrier#position"},
            "orientation": _orientation(rows, rows.q_payload_from_eci_xyzw, c_itrf),
        },
    ]


def _boresight(plan: FlightPlan, rows: TableStates, end_itrf_m: Array) -> list[Json]:
    availability = _span(rows, 0, -1)
    colours = [
        {
            "interval": _interval(segment.start_utc, segment.stop_utc),
            "rgba": _KIND_RGBA[segment.kind],
        }
        for segment in plan.segments
    ]
    return [
        {
            "id": "boresight-end",
            "name": "end of the boresight",
            "availability": availability,
            "position": _sample("cartesian", rows, end_itrf_m, 2),
        },
        {
            "id": "boresight",
            "name": "boresight",
            "description": _html(["grey: at rest; orange: slew; green: tracking"]),
            "availability": availability,
            "polyline": {
                "positions": {"references": ["carrier#position", "boresight-end#position"]},
                "arcType": "NONE",
                "width": 2,
                "material": {"solidColor": {"color": colours}},
            },
        },
    ]


def _footprint(rows: TableStates, platform: TwoAxisPlatform) -> list[Json]:
    """The frame's outline while all four corners are on the ground."""
    corners = sights(rows, frame_corner_rays(platform))
    runs = list(_runs(np.asarray(corners.on_ground.all(axis=1))))
    if not runs:
        return []
    spans = [_span(rows, first, last) for first, last in runs]
    names = [f"footprint-{number}" for number in range(len(FRAME_CORNERS))]
    on_ground = np.concatenate([np.arange(first, last + 1) for first, last in runs])
    return [
        *(
            {
                "id": name,
                "availability": spans,
                "position": _sample(
                    "cartesian", rows, corners.end_itrf_m[:, number], 2, which=on_ground
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
                "material": _solid(_FRAME_RGBA),
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
    yield {
        "id": f"target-{number}",
        "name": f"target of session {number} ({target.mode})",
        "description": _html([where]),
        "availability": _interval(session.start, session.stop),
        "position": _place(rows, place_itrf_m, which),
        "point": {"pixelSize": 9, "color": {"rgba": _TARGET_RGBA}},
        "label": {"text": f"session {number}", "font": "12pt sans-serif", "showBackground": True},
    }


def _place(rows: TableStates, place_itrf_m: Array, which: NDArray[np.int_]) -> Json:
    if np.ptp(place_itrf_m, axis=0).max() == 0.0:
        return {"cartesian": np.round(place_itrf_m[0], 3).tolist()}
    positions = np.zeros((len(rows.instants), 3))
    positions[which] = place_itrf_m
    return _sample("cartesian", rows, positions, 3, degree=5, which=which)


def _orientation(rows: TableStates, q_from_eci_xyzw: Array, c_itrf: Array) -> Json:
    q_itrf = Rotation.from_matrix(c_itrf) * Rotation.from_quat(q_from_eci_xyzw).inv()
    return _sample("unitQuaternion", rows, continuous(q_itrf), 13, degree=3)


def _sample(
    key: str,
    rows: TableStates,
    value_by_row: Array,
    decimals: int,
    *,
    degree: int = 1,
    which: NDArray[np.int_] | None = None,
) -> Json:
    """Time-tagged samples, seconds from the first row; value_by_row has a line for every row."""
    t_s = rows.instants.t_s - rows.instants.t_s[0]
    samples = np.column_stack([np.round(t_s, 1), np.round(value_by_row, decimals) + 0.0])
    samples = samples if which is None else samples[which]
    return {
        "epoch": utc_text(rows.instants.utc(0), 1),
        "interpolationAlgorithm": "LINEAR" if degree == 1 else "LAGRANGE",
        "interpolationDegree": degree,
        key: samples.ravel().tolist(),
    }


def _runs(flags: NDArray[np.bool_]) -> Iterable[tuple[int, int]]:
    """First and last index of every stretch of at least two true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    for first, after in edges.reshape(-1, 2).tolist():
        if after - first > 1:
            yield first, after - 1


def _row_at(rows: TableStates, moment_utc: datetime) -> int:
    since_s = elapsed_s(moment_utc, rows.instants.epoch_utc)
    return int(np.argmin(np.abs(rows.instants.t_s - since_s)))


def _span(rows: TableStates, first: int, last: int) -> str:
    return _interval(rows.instants.utc(first), rows.instants.utc(last))


def _interval(start_utc: datetime, stop_utc: datetime) -> str:
    return f"{utc_text(start_utc, 6)}/{utc_text(stop_utc, 6)}"


def _solid(rgba: Sequence[int]) -> Json:
    return {"solidColor": {"color": {"rgba": list(rgba)}}}


def _html(lines: Iterable[str]) -> str:
    return "".join(f"<p>{html.escape(line)}</p>" for line in lines)
