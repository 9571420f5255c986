"""Example requests of the API's pages, README and tests, as JSON: `data/plans.json` and others.

Each file holds the examples of one route, as OpenAPI has them: a summary and a value.  A message's
content is the name of its file, all of the pass of `LAS_VEGAS`: the OEM, OMM and OPM hold the orbit
of its TLE, by SGP4 in EME2000 and GCRF; in the AEMs the carrier swings about LVLH once an orbit, as
the ISS does.  The samples of `comparisons.json` are of a clock that is 0.37 s ahead, with 2 arcsec
of noise, and of a plan whose id the tests put in.
"""

import json
from pathlib import Path
from typing import Any

Examples = dict[str, tuple[str, dict[str, Any]]]
FOLDER = Path(__file__).parent / "data"


def message(name: str) -> str:
    """Return the text of one of the orbit or attitude messages, by its file's name."""
    return (FOLDER / name).read_text("utf-8")


def _with_messages(members: dict[str, Any]) -> dict[str, Any]:
    if "content" in members:
        return {**members, "content": message(members["content"])}
    return members


def _examples(route: str) -> Examples:
    text = (FOLDER / f"{route}.json").read_text("utf-8")
    found = json.loads(text, object_hook=_with_messages)
    return {name: (example["summary"], example["value"]) for name, example in found.items()}


PLAN_EXAMPLES = _examples("plans")
OPPORTUNITY_EXAMPLES = _examples("opportunities")
ORBIT_TRACK_EXAMPLES = _examples("orbit_tracks")
CAMPAIGN_EXAMPLES = _examples("campaigns")
FLIGHTS_EXAMPLES = _examples("flights")
COMPARISON_EXAMPLES = _examples("comparisons")
PREDICTION_EXAMPLES = _examples("horizon_predictions")
PICTURE_EXAMPLES = _examples("horizon_pictures")
SPACECRAFT_EXAMPLES = _examples("spacecraft_plans")

LAS_VEGAS = PLAN_EXAMPLES["tle"][1]  # Sumarokov 2016, Fig. 3, with the elements of that day
FOUR_MODES = SPACECRAFT_EXAMPLES["four modes"][1]
ESTIMATE_EXAMPLE = _examples("horizon_estimates")["ahead and right"][1]
SESSION_EXAMPLE = _examples("horizon_series")["ahead"][1]
