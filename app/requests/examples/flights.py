"""Worked requests for flights of a plan."""

from typing import Any

FLIGHTS_EXAMPLES: dict[str, tuple[str, dict[str, Any]]] = {
    "errors": (
        "How often would the camera hold the target?",
        {"name": "Las Vegas, before uplink", "runs": 100, "seed": 1},
    ),
    "series": (
        "A car at 75 km/h in a series of frames 10 s apart (Boston, May 2015)",
        {
            "runs": 20,
            "moving_object": {"speed_m_s": 20.833, "course_deg": 90.0, "interval_s": 10.0},
        },
    ),
}
