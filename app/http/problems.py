"""The HTTP answers to refusals, to errors of HTTP itself and to bugs.

Every answer above 399 is `application/problem+json` (RFC 9457) and says no more of an
internal error than that there was one.
"""

import json
import re
from collections.abc import Mapping
from difflib import get_close_matches
from http import HTTPStatus
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException

from app.answers.problem import TYPE_PREFIX, Problem, problem_of
from app.http.headers import instance
from app.requests.json_reader import field_errors
from app.store.unavailable import StoreDamaged
from planner.base.errors import InvalidRequest, Refusal

PROBLEM_JSON = "application/problem+json"
RETRY_AFTER_S = 5  # said with every 503 that may pass
PROBLEM_TYPE = "problem_type"  # of the problem a request was answered with, in its state


def install(app: FastAPI) -> None:
    """Answer every refusal, HTTP error and bug of `app` with a problem."""
    app.add_exception_handler(Refusal, refusal_answer)
    app.add_exception_handler(HTTPException, http_error)
    app.add_exception_handler(RequestValidationError, _bad_parameter)


def refusal_answer(request: Request, refusal: Exception) -> Response:
    assert isinstance(refusal, Refusal)
    return problem_answer(request, problem_of(refusal))


def _bad_parameter(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)
    document = {"query": dict(request.query_params)}
    return refusal_answer(request, InvalidRequest(*field_errors(error.errors(), document)))


def http_error(request: Request, error: Exception) -> Response:
    """The answer to an error of HTTP itself; its headers are kept."""
    assert isinstance(error, HTTPException)
    status = HTTPStatus(error.status_code)
    if status == HTTPStatus.NOT_MODIFIED:
        return Response(status_code=status, headers=error.headers)
    detail = error.detail
    if detail == status.phrase:  # Starlette's own: say what would have worked
        detail = status.description
        if status == HTTPStatus.NOT_FOUND:
            detail = f"there is nothing at this address; {_near(request)}"
        elif status == HTTPStatus.METHOD_NOT_ALLOWED:
            detail = "this address has other methods: see the Allow header"
    return problem_answer(
        request,
        {"type": "about:blank", "title": status.phrase, "status": status.value, "detail": detail},
        _allowed_methods(request) if status == HTTPStatus.METHOD_NOT_ALLOWED else error.headers,
    )


def service_stops() -> HTTPException:
    """For work that is not kept; what is kept is told by its address instead."""
    return HTTPException(
        HTTPStatus.SERVICE_UNAVAILABLE,
        "the service is being stopped and gives this up; ask again when it is back",
        {"Connection": "close"},
    )


def _allowed_methods(request: Request) -> dict[str, str]:
    """All methods of the address; Starlette names those of its first route only."""
    path = getattr(request.scope.get("route"), "path", "")
    methods: set[str] = request.app.state.methods.get(path, {"GET"})  # else one of our pages
    return {"Allow": ", ".join(sorted(methods | ({"HEAD"} if "GET" in methods else set())))}


def _near(request: Request) -> str:
    """The address of ours that was perhaps meant: it names the last word, or else looks alike."""
    asked = _AN_ID.sub("/{id}", request.scope["path"][:200])
    last = asked.rstrip("/").rpartition("/")[2]
    ours = sorted(request.app.state.methods, key=len)
    same_word = [path for path in ours if last.isalpha() and last in path.split("/")]
    near = same_word or get_close_matches(asked, ours, 1)
    return (f"did you mean {near[0]}? " if near else "") + "/docs lists what there is"


def problem_answer(
    request: Request, problem: Mapping[str, Any], headers: Mapping[str, str] | None = None
) -> Response:
    members = {**problem, "instance": instance(request.scope)}
    request.scope["state"][PROBLEM_TYPE] = members["type"]
    status = HTTPStatus(members["status"])
    if status is HTTPStatus.SERVICE_UNAVAILABLE and members["type"] != _FOR_GOOD:
        headers = {"Retry-After": str(RETRY_AFTER_S), **(headers or {})}
    kept = {name: members[name] for name in _ORDER if name in members}
    # ASCII, so that no text of the request can break the encoding of the answer.
    body = json.dumps(kept, allow_nan=False).encode("ascii")
    return Response(body, status, headers, media_type=PROBLEM_JSON)


_AN_ID = re.compile(r"/[0-9a-f-]{8,}(?=/|$)")
_ORDER = tuple(Problem.__dataclass_fields__)
_FOR_GOOD = TYPE_PREFIX + StoreDamaged.slug
