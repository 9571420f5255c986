"""Example requests for opportunities, for the API's pages."""

from typing import Any

from app.requests.examples.plan import LAS_VEGAS

_CARRIER = {name: LAS_VEGAS[name] for name in ("platform", "orbit", "attitude")}

OPPORTUNITY_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "cities": (
        "Cities in daylight over two days, at 30 deg elevation or more",
        {
            **_CARRIER,
            "targets": [
                {"id": "Las Vegas", "priority": 2.0, "target": LAS_VEGAS["sessions"][0]["target"]},
                {
                    "id": "London",
                    "target": {
                        "mode": "ground",
                        "latitude_deg": 51.5074,
                        "longitude_deg": -0.1278,
                        "height_m": 60.0,
                    },
                },
            ],
            "start": "2015-02-27T12:00:00Z",
            "stop": "2015-03-01T12:00:00Z",
            "conditions": {"min_elevation_deg": 30.0, "sun_elevation_min_deg": 10.0},
        },
    ),
    "sky": (
        "A star, the Moon and a planet, away from the Sun, through one evening",
        {
            **_CARRIER,
            "targets": [
                {"id": "Vega", "target": {"mode": "star", "hip": 91262}},
                {"id": "Moon", "target": {"mode": "body", "name": "moon"}},
                {"id": "Saturn", "target": {"mode": "body", "name": "saturn"}},
            ],
            "start": "2015-02-27T15:00:00Z",
            "stop": "2015-02-27T18:00:00Z",
            "conditions": {"sun_keep_out_deg": 60.0, "min_duration_s": 120.0},
        },
    ),
    "ship": (
        "A ship under way, by day and away from the limb",
        {
            **_CARRIER,
            "targets": [
                {
                    "id": "ship",
                    "target": {
                        "mode": "ground_moving",
                        "epoch": "2015-02-27T12:00:00Z",
                        "latitude_deg": 32.5,
                        "longitude_deg": -118.0,
                        "course_deg": 315.0,
                        "speed_m_s": 8.0,
                    },
                }
            ],
            "start": "2015-02-27T12:00:00Z",
            "stop": "2015-03-01T12:00:00Z",
            "conditions": {"sun_elevation_min_deg": 0.0, "max_off_nadir_deg": 60.0},
            "samples": 2,
        },
    ),
}
