"""Parts of CZML documents that plans of every kind share.

Positions are Earth-fixed (ITRF, taken as WGS84): Cesium turns inertial ones only with tables
it loads from the network.
"""

import html
import json
from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import Any

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.rotation import Rotation, continuous
from planner.output.export.map_features import thinned
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants, utc_text

Json = dict[str, Any]

ORBIT_RGBA, AREA_RGBA, TARGET_RGBA = [90, 170, 255, 255], [0, 220, 90, 110], [255, 60, 60, 255]
TRACK_RGBA = [90, 170, 255, 140]


def czml_of(packets: Iterable[Json]) -> bytes:
    """The whole document."""
    return json.dumps([*packets], allow_nan=False, separators=(",", ":")).encode()


def document_packet(name: str, lines: Iterable[str], instants: Instants) -> Json:
    """The first packet: what the document is, and the clock over its time."""
    span = span_text(instants, 0, -1)
    return {
        "id": "document",
        "name": name,
        "version": "1.0",
        "description": html_text(lines),
        "clock": {
            "interval": span,
            "currentTime": span.split("/")[0],
            "multiplier": 1,
            "range": "LOOP_STOP",
            "step": "SYSTEM_CLOCK_MULTIPLIER",
        },
    }


def carrier_packets(
    name: str, instants: Instants, r_sat_itrf_m: Array, orientation: Json
) -> Iterable[Json]:
    """The carrier on its orbit, and the line below it on the ground."""
    availability = span_text(instants, 0, -1)
    duration_s = float(instants.t_s[-1] - instants.t_s[0])
    yield {
        "id": "carrier",
        "name": name,
        "availability": availability,
        "position": samples("cartesian", instants, r_sat_itrf_m, 3, degree=5),
        "orientation": orientation,
        "point": {"pixelSize": 8, "color": {"rgba": ORBIT_RGBA}},
        "path": {
            "material": solid(ORBIT_RGBA),
            "width": 1.5,
            "leadTime": duration_s,
            "trailTime": duration_s,
            "resolution": 5,
        },
    }
    below_rad = geodetic_from_itrf(r_sat_itrf_m[thinned(len(instants))])
    yield {
        "id": "ground-track",
        "name": "below the carrier",
        "availability": availability,
        "polyline": {
            "positions": {"cartographicDegrees": ground_degrees(*below_rad[:2])},
            "clampToGround": True,
            "width": 2,
            "material": solid(TRACK_RGBA),
        },
    }


def label(text: str) -> Json:
    """Beside a point."""
    beside = {"horizontalOrigin": "LEFT", "pixelOffset": {"cartesian2": [12, 0]}}
    return {"text": text, "font": "12pt sans-serif", "showBackground": True, **beside}


def ground_degrees(latitude_rad: Array, longitude_rad: Array) -> list[float]:
    """Longitude, latitude, height 0 of places on the ground, (n,) each, one after the other."""
    places = np.stack([np.degrees(longitude_rad), np.degrees(latitude_rad), 0.0 * latitude_rad], 1)
    return list((np.round(places, 6) + 0.0).ravel().tolist())


def orientation(instants: Instants, q_from_eci_xyzw: Array, c_itrf: Array) -> Json:
    """Unit quaternions that turn vectors from axes of a body to Earth-fixed ones."""
    q_itrf = Rotation.from_matrix(c_itrf) * Rotation.from_quat(q_from_eci_xyzw).inv()
    return samples("unitQuaternion", instants, continuous(q_itrf), 13, degree=3)


def samples(
    key: str,
    instants: Instants,
    value_by_row: Array,
    decimals: int,
    *,
    degree: int = 1,
    which: Indices | None = None,
) -> Json:
    """Time-tagged samples, seconds from the first instant; value_by_row has a line for each."""
    t_s = instants.t_s - instants.t_s[0]
    tagged = np.column_stack([np.round(t_s, 1), np.round(value_by_row, decimals) + 0.0])
    tagged = tagged if which is None else tagged[which]
    return {
        "epoch": utc_text(instants.utc(0), 1),
        "interpolationAlgorithm": "LINEAR" if degree == 1 else "LAGRANGE",
        "interpolationDegree": degree,
        key: tagged.ravel().tolist(),
    }


def span_text(instants: Instants, first: int, last: int) -> str:
    """The interval between two of them."""
    return interval_text(instants.utc(first), instants.utc(last))


def interval_text(start_utc: datetime, stop_utc: datetime) -> str:
    """As ISO 8601 has it."""
    return f"{utc_text(start_utc, 6)}/{utc_text(stop_utc, 6)}"


def solid(rgba: Sequence[int]) -> Json:
    """A material of one colour."""
    return {"solidColor": {"color": {"rgba": list(rgba)}}}


def html_text(lines: Iterable[str]) -> str:
    """A paragraph a line."""
    return "".join(f"<p>{html.escape(line)}</p>" for line in lines)
