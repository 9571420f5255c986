"""The next pass over the one target of a plan: the search for it, and the request moved there."""

from datetime import UTC, datetime, timedelta
from typing import Any

from slewtrack.client.answers import Include, Opportunities, Window
from slewtrack.client.problems import Problem, Refused, problem_of
from slewtrack.client.reading import Members, object_of

TOLD: Include = ("view", "reasons")
SEARCH = timedelta(days=7)
LEAD = timedelta(seconds=120)  # iss-hrc turns half a circle in 63 s: 3 deg/s, 1 deg/s2
ELEVATION_MIN_DEG = 10.0  # unless the target says otherwise


def search_of(request: Members, start: datetime | str | None) -> dict[str, Any]:
    """For windows of its session's target that leave time for the slew; raises Refused."""
    sessions = request.get("sessions")
    if not isinstance(sessions, list) or len(sessions) != 1 or not isinstance(sessions[0], dict):
        detail = "a next pass has one session; `slewtrack campaign` chooses among many targets"
        raise _refused("invalid-request", "sessions", detail)
    target = sessions[0].get("target")
    told = target if isinstance(target, dict) else {}
    is_bounded = told.get("mode") not in ("ground", "place") or "min_elevation_deg" in told
    first = _moment(start) + LEAD
    return {
        **{k: request[k] for k in ("platform", "orbit", "attitude", "terrain") if k in request},
        "targets": [{"id": "next", "target": target}],
        "start": _text(first),
        "stop": _text(first + SEARCH),
        "conditions": {"min_elevation_deg": 0.0 if is_bounded else ELEVATION_MIN_DEG},
        "samples": 2,
    }


def as_in_plan(problem: Problem) -> Refused:
    """What a search refuses, with its fields named as the request for a plan has them."""
    text, errors = _renamed(problem.detail), problem.members.get("errors") or ()
    faults = [{**fault, "field": _renamed(fault["field"])} for fault in errors]
    named = {"field": _renamed(problem.field)} if problem.field else {}
    return Refused(problem_of({**problem.members, "detail": text, "errors": faults, **named}))


def _renamed(text: str) -> str:
    return text.replace("targets.0.", "sessions.0.", 1) if text.startswith("targets.0.") else text


def first_window(found: Opportunities) -> Window:
    """The first that a session fits into; raises Refused."""
    for window in found.windows:
        if window.session is not None:
            return window
    since = str(found.get("start", ""))
    why = "".join(f": {one.because}" for one in found.reasons)
    detail = f"the target isn't in sight within {SEARCH.days} days after {since}{why}"
    raise _refused("not-visible", "sessions.0.target", detail)


def moved_to(window: Window, request: Members) -> dict[str, Any]:
    """The request with its session in the window.

    The platform rests until `LEAD` before it where the request has it, or where it does unless
    told; or the plan it goes on from says where it is.
    """
    times = window.session or {}
    moved: dict[str, Any] = {**request, "sessions": [{**request["sessions"][0], **times}]}
    asked = request.get("initial_state", {})
    if isinstance(asked, dict) and "after" not in asked:
        epoch = _text(datetime.fromisoformat(times["start"]) - LEAD)
        moved["initial_state"] = {**asked, "epoch": epoch}
    return moved


def _moment(start: datetime | str | None) -> datetime:
    try:
        moment = datetime.fromisoformat(start) if isinstance(start, str) else start
    except ValueError:
        raise ValueError(f"start must be UTC as 2015-02-27T12:00:00Z, not {start!r}") from None
    if moment is not None and moment.utcoffset() is None:
        raise ValueError(f"start has no UTC offset: {start!r}; append Z if it is UTC")
    return moment or datetime.now(UTC)


def _text(moment: datetime) -> str:
    return moment.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def _refused(kind: str, field: str, detail: str) -> Refused:
    told = {"type": f"urn:slewtrack:problem:{kind}", "status": 422, "detail": detail}
    return Refused(problem_of(object_of({**told, "field": field})))
