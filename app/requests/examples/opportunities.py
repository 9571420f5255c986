"""Example requests for opportunities, for the API's pages."""

from typing import Any

from app.requests.examples.plan import LAS_VEGAS, ground, ship

_CARRIER = {name: LAS_VEGAS[name] for name in ("platform", "orbit", "attitude")}

OPPORTUNITY_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "cities": (
        "Cities in daylight over two days, at 30 deg elevation or more",
        {
            **_CARRIER,
            "targets": [
                {"id": "Las Vegas", "priority": 2.0, "target": LAS_VEGAS["sessions"][0]["target"]},
                {"id": "London", "target": ground(51.5074, -0.1278, 60.0)},
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
            "targets": [{"id": "ship", "target": ship("2015-02-27T12:00:00Z")}],
            "start": "2015-02-27T12:00:00Z",
            "stop": "2015-03-01T12:00:00Z",
            "conditions": {"sun_elevation_min_deg": 0.0, "max_off_nadir_deg": 60.0},
            "samples": 2,
        },
    ),
}
