"""The other modes of pointing: Sumarokov 2016, pp. 86 and 96."""

from datetime import timedelta
from typing import Any

import numpy as np

from planner.world.frames.time_scales import utc_from_text, utc_text
from reproduction.example_plans import LAS_VEGAS, level_request
from reproduction.statements import Numbers
from slewtrack import opportunities, plan, read_request

DAY = ("2015-02-27T17:00:00Z", "2015-02-28T17:00:00Z")
SESSION_S, LEAD_S = 60.0, 120.0
MODES: dict[str, dict[str, Any]] = {
    "star": {"mode": "star", "ra_deg": 213.915, "dec_deg": 19.182},
    "moon": {"mode": "body", "name": "moon"},
    "sun": {"mode": "body", "name": "sun"},
    "test motion": {
        "mode": "test_motion",
        "axes": {
            "alpha": {"kind": "sine", "amplitude_deg": 5.0, "frequency_hz": 0.02},
            "beta": {"kind": "triangle", "amplitude_deg": 5.0, "period_s": 60.0, "turn_s": 6.0},
        },
    },
}


def session_start(target: dict[str, Any]) -> str:
    """The first of the day at which a minute of the target can be had."""
    base = level_request(LAS_VEGAS)
    if target["mode"] == "test_motion":
        return str(base["sessions"][0]["start"])
    found = opportunities(
        {
            **{name: base[name] for name in ("platform", "orbit", "attitude")},
            "targets": [{"id": "it", "target": target}],
            "start": DAY[0],
            "stop": DAY[1],
            "conditions": {"min_duration_s": SESSION_S + 10.0},
            "samples": 2,
        }
    )
    after_start = found.windows.rise_s > 0.0
    first_s = float(np.ceil(found.windows.rise_s[after_start][0]))
    return utc_text(found.start_utc + timedelta(seconds=first_s), 0)


def worst_arcsec(target: dict[str, Any]) -> float:
    """Of a planned session of the mode, by the independent judge, who must pass it."""
    request = level_request(LAS_VEGAS)
    start = session_start(target)
    begins_utc = utc_from_text(start)
    request["initial_state"]["epoch"] = utc_text(begins_utc - timedelta(seconds=LEAD_S), 0)
    stop = utc_text(begins_utc + timedelta(seconds=SESSION_S), 0)
    request["sessions"] = [{"target": target, "start": start, "stop": stop}]
    made = plan(read_request(request))
    assert made.verification.passed
    return float(np.degrees(made.verification.sessions[0].overall.max_rad)) * 3600.0


def numbers() -> Numbers:
    return {f"mode, {name}": worst_arcsec(target) for name, target in MODES.items()}
