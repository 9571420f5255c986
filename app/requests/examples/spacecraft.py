"""Example requests for imaging sessions, for the API's pages."""

from typing import Any

# Sun-synchronous, 650 km; at this epoch over the Atlantic, going north.
_ORBIT = {
    "source": "state",
    "frame": "GCRF",
    "epoch": "2024-06-01T10:00:00Z",
    "position_km": [5996.355484, 3172.007203, 1798.982536],
    "velocity_km_s": [-1.185983242, -1.84689081, 7.209590871],
}
_STRIP = [[-12.390357, 20.486982], [-12.506716, 21.017679]]
_STEREO = [[-15.742638, 28.772611], [-15.876398, 29.301017]]
_CORRIDOR = [[-17.691829, 36.793831], [-17.3336, 37.251861]]
_AREA = [
    [-19.974441, 43.975448],
    [-20.155328, 44.499518],
    [-19.568684, 44.602514],
    [-19.392685, 44.077541],
    [-19.974441, 43.975448],
]


def _line(longitude_latitude_deg: list[list[float]]) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": longitude_latitude_deg}


FOUR_MODES: dict[str, Any] = {
    "name": "Four modes in one pass",
    "orbit": _ORBIT,
    "spacecraft": "agile-cmg",
    "start": "2024-06-01T10:00:00Z",
    "stop": "2024-06-01T10:10:40Z",
    "requests": [
        {"mode": "strip", "name": "strip", "priority": 2.0, "geometry": _line(_STRIP)},
        {"mode": "stereo", "name": "stereo", "priority": 4.0, "geometry": _line(_STEREO)},
        {"mode": "corridor", "name": "corridor", "priority": 2.0, "geometry": _line(_CORRIDOR)},
        {
            "mode": "area",
            "name": "area",
            "priority": 1.0,
            "geometry": {"type": "Polygon", "coordinates": [_AREA]},
        },
    ],
    "objective": "smooth",
    "simulation_runs": 4,
}

SPACECRAFT_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "four modes": ("A strip, a stereo pair, a corridor and an area in ten minutes", FOUR_MODES),
    "geojson": (
        "The requests as a GeoJSON FeatureCollection, slews as quick as found",
        {
            "name": "One strip",
            "orbit": _ORBIT,
            "start": "2024-06-01T10:00:00Z",
            "stop": "2024-06-01T10:05:00Z",
            "requests": {
                "type": "FeatureCollection",
                "features": [
                    {
                        "type": "Feature",
                        "properties": {"mode": "strip", "name": "strip"},
                        "geometry": _line(_STRIP),
                    }
                ],
            },
            "settings": {"reversible_scan": True},
            "objective": "minimum_time",
            "simulation_runs": 1,
        },
    ),
}

IMAGING_OPPORTUNITY_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "four modes": (
        "A strip, a stereo pair, a corridor and an area over a day, by day",
        {
            "name": "Atlantic, by day",
            "orbit": _ORBIT,
            "start": "2024-06-01T10:00:00Z",
            "stop": "2024-06-02T10:00:00Z",
            "requests": FOUR_MODES["requests"],
            "conditions": {"sun_elevation_min_deg": 10.0},
        },
    ),
}
