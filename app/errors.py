"""Which HTTP answer does each refusal get?

Every answer above 399 is `application/problem+json` (RFC 9457) and says no more of an
internal error than that there was one.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import datetime
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException

from app.api.json_reader import FieldError, InvalidRequest, field_errors
from app.jobs.child import TooDemanding
from app.jobs.refusals import Conflict, Interrupted, KeyReused, QueueFull
from app.observability import request_id
from app.store.failures import StoreUnavailable
from estimator.errors import InvalidCamera, InvalidImage
from planner import errors
from planner.errors import GiveUp
from planner.frames.time_scales import utc_text

PROBLEM_JSON = "application/problem+json"
TYPE_PREFIX = "urn:slewtrack:problem:"
RETRY_AFTER_S = 5  # said with every 503
_TEXT_MAX = 2000

STATUS_OF_REFUSAL: dict[type[errors.Refusal], HTTPStatus] = {
    errors.Refusal: HTTPStatus.UNPROCESSABLE_ENTITY,
    InvalidRequest: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.InvalidInput: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.InvalidMessage: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.OutsideCoverage: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.NotVisible: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.Unreachable: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.TrackBreaksLimit: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.InfeasibleSlew: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.SearchEnded: HTTPStatus.UNPROCESSABLE_ENTITY,
    errors.Unverified: HTTPStatus.UNPROCESSABLE_ENTITY,
    InvalidCamera: HTTPStatus.UNPROCESSABLE_ENTITY,
    InvalidImage: HTTPStatus.UNPROCESSABLE_ENTITY,
    TooDemanding: HTTPStatus.UNPROCESSABLE_ENTITY,
    KeyReused: HTTPStatus.UNPROCESSABLE_ENTITY,
    Conflict: HTTPStatus.CONFLICT,
    QueueFull: HTTPStatus.SERVICE_UNAVAILABLE,
    StoreUnavailable: HTTPStatus.SERVICE_UNAVAILABLE,
    # The request was sound: these are our failures.
    errors.SolverFailed: HTTPStatus.INTERNAL_SERVER_ERROR,
    errors.VerificationFailed: HTTPStatus.INTERNAL_SERVER_ERROR,
    Interrupted: HTTPStatus.INTERNAL_SERVER_ERROR,
}


@dataclass(frozen=True, kw_only=True)
class Problem:
    """RFC 9457 problem details.

    `type` names the kind of refusal; `instance` this request, by the id that the log and the
    header X-Request-ID name too.
    `field` is the request field at fault, dotted; `axis`, `limit` and `at` say what breaks
    and when; `earliest_feasible_start` is the nearest session start that works, for a session
    that stops at `feasible_stop`, when the sessions in `costs_sessions` are left
    out; `give_up` says what sessions would lose under each
    `on_conflict`; `errors` lists every field at fault of a request that can't be read.
    """

    type: str
    title: str
    status: int
    detail: str
    instance: str
    field: str | None = None
    axis: str | None = None
    limit: str | None = None
    at: str | None = None
    earliest_feasible_start: str | None = None
    feasible_stop: str | None = None
    costs_sessions: tuple[int, ...] = ()
    give_up: tuple[GiveUp, ...] = ()
    errors: tuple[FieldError, ...] = ()


def install(app: FastAPI) -> None:
    """Answer every refusal, HTTP error and bug of `app` with a problem."""
    app.add_exception_handler(errors.Refusal, refusal_answer)
    app.add_exception_handler(HTTPException, http_error)
    app.add_exception_handler(RequestValidationError, _bad_parameter)


def problem_type(scope: Mapping[str, Any]) -> str | None:
    """The type of the problem a request was answered with, None for a good answer."""
    kind: str | None = scope["state"].get(_PROBLEM_TYPE)
    return kind


def refusal_answer(request: Request, refusal: Exception) -> Response:
    """The answer to what was refused."""
    assert isinstance(refusal, errors.Refusal)
    return problem_answer(request, problem_of(refusal))


def _status(refusal: errors.Refusal) -> HTTPStatus:
    """Of its kind, or of the kind it is a special case of."""
    return next(
        STATUS_OF_REFUSAL[kind] for kind in type(refusal).__mro__ if kind in STATUS_OF_REFUSAL
    )


def problem_of(refusal: errors.Refusal) -> dict[str, Any]:
    """A problem's members, but for the instance."""
    members = {
        "type": TYPE_PREFIX + refusal.slug,
        "title": refusal.title,
        "status": _status(refusal).value,
        "detail": refusal.detail,
        "field": refusal.field,
        "axis": refusal.axis,
        "limit": refusal.limit,
        "at": _text(refusal.at_utc),
        "earliest_feasible_start": _text(refusal.earliest_feasible_start_utc),
        "feasible_stop": _text(refusal.feasible_stop_utc),
        "costs_sessions": list(refusal.costs_sessions),
        "give_up": [asdict(offer) for offer in getattr(refusal, "give_up", ())],
        "errors": [
            {"field": error.field, "detail": error.detail, "value": error.value}
            for error in getattr(refusal, "errors", ())
        ],
    }
    return {name: _short(value) for name, value in members.items() if value not in (None, [])}


def _short(value: object) -> object:
    """Cut to what a person reads, wherever it came from."""
    if isinstance(value, str):
        return value if len(value) <= _TEXT_MAX else value[:_TEXT_MAX] + "..."
    if isinstance(value, list):
        return [_short(item) for item in value]
    if isinstance(value, dict):
        return {name: _short(item) for name, item in value.items()}
    return value


def _text(utc: datetime | None) -> str | None:
    return None if utc is None else utc_text(utc)


def _bad_parameter(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    document = {"query": dict(request.query_params)}
    return refusal_answer(request, InvalidRequest(*field_errors(error.errors(), document)))


def http_error(request: Request, error: Exception) -> Response:
    """The answer to an error of HTTP itself; its headers are kept."""
    assert isinstance(error, HTTPException)
    status = HTTPStatus(error.status_code)
    detail = error.detail
    if detail == status.phrase:  # Starlette's own: say what would have worked
        detail = _WAY_OUT.get(status, status.description)
    return problem_answer(
        request,
        {"type": "about:blank", "title": status.phrase, "status": status.value, "detail": detail},
        _allowed(request) if status == HTTPStatus.METHOD_NOT_ALLOWED else error.headers,
    )


def _allowed(request: Request) -> dict[str, str]:
    """All methods of the address; Starlette names those of its first route only."""
    path = getattr(request.scope.get("route"), "path", "")
    methods = {*request.app.openapi()["paths"].get(path, {"get": {}})}  # else one of our pages
    methods |= {"head"} if "get" in methods else set()
    return {"Allow": ", ".join(sorted(method.upper() for method in methods))}


_WAY_OUT = {
    HTTPStatus.NOT_FOUND: "there is nothing at this address; /docs lists what there is",
    HTTPStatus.METHOD_NOT_ALLOWED: "this address has other methods: see the Allow header",
}


def bug_response(request: Request) -> Response:
    """The answer when the service is at fault; why is in its log only."""
    return problem_answer(request, bug())


def bug() -> dict[str, Any]:
    """A problem's members that tell no more of our failure than that there was one."""
    status = HTTPStatus.INTERNAL_SERVER_ERROR
    return {
        "type": TYPE_PREFIX + "internal-error",
        "title": status.phrase,
        "status": status.value,
        "detail": "the service failed; its log says why under this instance",
    }


def problem_answer(
    request: Request, problem: Mapping[str, Any], headers: Mapping[str, str] | None = None
) -> Response:
    """The answer to this request that tells a problem."""
    members = {**problem, "instance": request_id.instance(request.scope)}
    request.scope["state"][_PROBLEM_TYPE] = members["type"]
    status = HTTPStatus(members["status"])
    if status is HTTPStatus.SERVICE_UNAVAILABLE:
        headers = {"Retry-After": str(RETRY_AFTER_S), **(headers or {})}
    kept = {name: members[name] for name in _ORDER if name in members}
    # ASCII, so that no text of the request can break the encoding of the answer.
    body = json.dumps(kept, allow_nan=False).encode("ascii")
    return Response(body, status, headers, media_type=PROBLEM_JSON)


_ORDER = tuple(Problem.__dataclass_fields__)
_PROBLEM_TYPE = "problem_type"
