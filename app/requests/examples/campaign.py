"""Example requests for campaigns, for the API's pages."""

from typing import Any

from app.requests.examples.plan import LAS_VEGAS

_CITIES = {
    "Las Vegas": (36.1147, -115.1728, 3.0),
    "Los Angeles": (34.0522, -118.2437, 2.0),
    "San Francisco": (37.7749, -122.4194, 1.0),
    "Phoenix": (33.4484, -112.0740, 1.0),
    "Boston": (42.3601, -71.0589, 1.0),
}

CAMPAIGN_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "cities": (
        "Five cities within half a day, each looked at once for 20 to 40 s",
        {
            "name": "Cities",
            **{name: LAS_VEGAS[name] for name in ("platform", "orbit", "attitude")},
            "targets": [
                {
                    "id": name,
                    "priority": priority,
                    "session_s": 40.0,
                    "min_session_s": 20.0,
                    "target": {
                        "mode": "ground",
                        "latitude_deg": latitude_deg,
                        "longitude_deg": longitude_deg,
                    },
                }
                for name, (latitude_deg, longitude_deg, priority) in _CITIES.items()
            ],
            "start": "2015-02-27T12:00:00Z",
            "stop": "2015-02-28T00:00:00Z",
            "conditions": {"min_elevation_deg": 30.0, "sun_elevation_min_deg": 10.0},
        },
    ),
}
