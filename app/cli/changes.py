"""A request changed on the command line: single fields, or its session moved to the next pass."""

import json
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from app.answers.opportunities import windows_out
from app.requests.opportunities import read_opportunity_request
from planner.base.errors import FieldError, InvalidInput, InvalidRequest
from planner.planning.opportunities import OpportunityRequest, find_opportunities
from planner.world.frames.time_scales import DAY_S, shifted_utc, utc_from_text, utc_text

SEARCH_DAYS = 7
LEAD_S = 120.0  # iss-hrc turns half a circle in 63 s: 3 deg/s, 1 deg/s2
ELEVATION_MIN_DEG = 10.0  # unless the target says otherwise


def with_settings(body: bytes, settings: Sequence[str] | None) -> bytes:
    """The request with each FIELD=VALUE set; FIELD as refusals name it, VALUE as JSON or text."""
    if not settings:
        return body
    document = _object(body)
    for setting in settings:
        field, equals, text = setting.partition("=")
        if not equals or not field:
            raise InvalidInput(f"{setting[:80]!r} is no FIELD=VALUE", field="--set")
        _set(document, field.split("."), _value(text), field)
    return json.dumps(document).encode()


def _object(body: bytes) -> dict[str, Any]:
    try:
        document = json.loads(body)
    except ValueError as error:
        raise InvalidInput(f"the request is no JSON: {error}") from None
    if not isinstance(document, dict):
        raise InvalidInput("the request must be a JSON object")
    return document


def _value(text: str) -> object:
    try:
        return json.loads(text)
    except ValueError:
        return text


def _set(document: dict[str, Any], path: list[str], value: object, field: str) -> None:
    inside: Any = document
    for name in path[:-1]:
        inside = _entry(inside, name, field)
    last = path[-1]
    if isinstance(inside, dict):
        inside[last] = value
    elif isinstance(inside, list) and last.isdecimal() and int(last) < len(inside):
        inside[int(last)] = value
    else:
        raise InvalidInput(f"the request has nothing at {field[:80]!r}", field="--set")


def _entry(inside: object, name: str, field: str) -> object:
    if isinstance(inside, dict):
        return inside.setdefault(name, {})
    if isinstance(inside, list) and name.isdecimal() and int(name) < len(inside):
        return inside[int(name)]
    raise InvalidInput(f"the request has nothing at {field[:80]!r}", field="--set")


def search_start(text: str | None) -> datetime:
    """`now`, or RFC 3339."""
    if text in (None, "now"):
        return datetime.now(UTC)
    try:
        return utc_from_text(str(text))
    except ValueError as error:
        raise InvalidInput(str(error), field="--start") from None


def at_next_pass(body: bytes, start_utc: datetime) -> tuple[bytes, str]:
    """The request with its one session in the first window of its target, and what to say of it.

    The axes rest until `LEAD_S` before the window, where the request has them, or at zero; or the
    plan it goes on from says where they are.
    """
    document = _object(body)
    sessions = document.get("sessions")
    if not isinstance(sessions, list) or len(sessions) != 1 or not isinstance(sessions[0], dict):
        raise InvalidInput(
            "--next-pass moves one session; choose passes of many targets by `slewtrack campaign`",
            field="sessions",
        )
    [session] = sessions
    found = find_opportunities(_search(document, session, start_utc))
    window = next((one for one in windows_out(found) if one.session is not None), None)
    if window is None or window.session is None:
        raise InvalidInput(
            f"the target isn't in sight within {SEARCH_DAYS} days after {utc_text(start_utc, 1)}",
            field="sessions.0.target",
        )
    first_utc = utc_from_text(window.session.start)
    sessions[0] = session | {"start": window.session.start, "stop": window.session.stop}
    asked = document.get("initial_state", {})
    if isinstance(asked, dict) and "after" not in asked:
        epoch = utc_text(shifted_utc(first_utc, -LEAD_S), 1)
        document["initial_state"] = _at_rest(found.axis_names) | asked | {"epoch": epoch}
    told = (
        f"next pass: {window.session.start} to {window.session.stop}, "
        f"up to {window.highest_deg:.1f} deg high"
    )
    return json.dumps(document).encode(), told


def _search(
    document: dict[str, Any], session: dict[str, Any], start_utc: datetime
) -> OpportunityRequest:
    """For windows of the session's target that leave time for the slew."""
    target = session.get("target")
    asked = isinstance(target, dict) and "min_elevation_deg" in target
    on_ground = isinstance(target, dict) and target.get("mode") in ("ground", "place")
    elevation_deg = ELEVATION_MIN_DEG if on_ground and not asked else 0.0
    first_utc = shifted_utc(start_utc, LEAD_S)
    request = {
        **{name: document[name] for name in _CARRIED_OVER if name in document},
        "targets": [{"id": "next", "target": target}],
        "start": utc_text(first_utc, 3),
        "stop": utc_text(shifted_utc(first_utc, SEARCH_DAYS * DAY_S), 3),
        "conditions": {"min_elevation_deg": elevation_deg},
        "samples": 2,
    }
    try:
        return read_opportunity_request(json.dumps(request).encode())
    except InvalidRequest as refused:
        raise InvalidRequest(*map(_as_in_plan, refused.errors)) from None


def _as_in_plan(error: FieldError) -> FieldError:
    """Named as the request for a plan has it."""
    inside = error.field.removeprefix("targets.0.")
    return error if inside == error.field else replace(error, field=f"sessions.0.{inside}")


_CARRIED_OVER = ("platform", "orbit", "attitude")


def _at_rest(axis_names: Sequence[str]) -> dict[str, Any]:
    still = dict.fromkeys(axis_names, 0.0)
    return {"angles_deg": still, "rates_deg_s": still}
