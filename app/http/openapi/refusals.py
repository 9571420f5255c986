"""Refusals in the OpenAPI document, each once, with an example as it was really given."""

from dataclasses import dataclass, field, replace
from http import HTTPStatus
from typing import Any

from app.answers.problem import TYPE_PREFIX
from app.http.door.access import PROBES
from app.http.door.request_form import HEADERS_MAX, PATH_BYTES_MAX, QUERY_BYTES_MAX
from app.http.problems import PROBLEM_JSON

_INSTANCE = "urn:uuid:7d3f2c1e-5b1a-4a52-9a7e-0c2f6f1d8b34"
_RETRY = {"Retry-After": "Seconds to wait"}


@dataclass(frozen=True, kw_only=True)
class Shown:
    """A status: when it comes, an example of its detail, further members and headers."""

    when: str
    detail: str
    members: dict[str, Any] = field(default_factory=dict)
    headers: dict[str, str] = field(default_factory=dict)


_SHOWN = {
    400: Shown(
        when="The request can't be read as HTTP, or in two ways",
        detail="the address holds a null byte; remove %00",
    ),
    401: Shown(
        when="An API key is needed, and none or an unknown one was sent",
        detail="send an API key: Authorization: Bearer ...; `slewtrack keys create` makes one",
        headers={"WWW-Authenticate": "How to send a key (RFC 6750)"},
    ),
    403: Shown(
        when="The key lacks the scope, or a web page of another site asks",
        detail="web pages of other sites may not use this service",
    ),
    406: Shown(
        when="The Accept header admits nothing we answer with",
        detail="the answer is application/json, which the Accept header excludes",
    ),
    408: Shown(when="The body comes too slowly", detail="the whole body must come within 60 s"),
    413: Shown(when="The request is too long", detail="a request may have 8388608 bytes at most"),
    414: Shown(
        when="The address is too long",
        detail=f"an address may have {PATH_BYTES_MAX} bytes of path and {QUERY_BYTES_MAX} of "
        "query; send large things in the body",
    ),
    415: Shown(
        when="The request is of another media type than we read, or compressed",
        detail="send the request with Content-Type: application/json, not text/plain",
    ),
    421: Shown(
        when="Without a key: the Host header names none of our hosts",
        detail="without a key this service answers to 127.0.0.1, [::1], localhost only, which the "
        "Host header doesn't name; SLEWTRACK_ALLOWED_HOSTS adds names",
    ),
    422: Shown(
        when="The request is refused: what is at fault, and the way out",
        detail="alpha needs 2.500 s to slew but 1.000 s are available; ...",
        members={
            "type": TYPE_PREFIX + "infeasible-slew",
            "title": "The slew doesn't fit in the time available",
            "field": "sessions.0.start",
            "axis": "alpha",
            "limit": "duration",
            "earliest_feasible_start": "2015-02-27T17:36:21.600Z",
            "feasible_stop": "2015-02-27T17:37:50.000Z",
        },
    ),
    429: Shown(
        when="Too many requests a minute, or at a time",
        detail="6000 requests a minute are answered; ask again in 1 s",
        headers=_RETRY,
    ),
    431: Shown(
        when="The head of the request is too long",
        detail=f"a request may have {HEADERS_MAX} header fields; send fewer",
    ),
    500: Shown(
        when="The service failed; the request is not at fault",
        detail="the service failed; its log gives the reason under this `instance`",
        members={"type": TYPE_PREFIX + "internal-error"},
    ),
    503: Shown(
        when="The service has too much to do, or isn't ready",
        detail="the bodies of all requests at work may have 536870912 bytes together; ask again "
        "when others are done",
        headers=_RETRY,
    ),
}
_OF_BODIES = {408, 413, 415}
_OF_ACCESS = {401, 403, 421, 429}


def document_refusals(document: dict[str, Any], ref: str) -> None:
    """Add what each operation may refuse; what it says itself of a status stays.

    ref: how the document refers to a schema.
    """
    problem = {"$ref": ref.format(model="Problem")}
    document["components"]["responses"] = {
        str(code): _response(code, shown, problem) for code, shown in _SHOWN.items()
    }
    for path, operations in document["paths"].items():
        for operation in operations.values():
            codes = _SHOWN.keys() - (_OF_ACCESS if path in PROBES else ())
            if "requestBody" not in operation:
                codes -= _OF_BODIES
            operation["responses"] = _responses(operation["responses"], codes, problem)


def _responses(own: dict[str, Any], codes: set[int], problem: dict[str, Any]) -> dict[str, Any]:
    refused = {str(code): {"$ref": f"#/components/responses/{code}"} for code in codes}
    answers = refused | {code: answer for code, answer in own.items() if int(code) < 400}
    for code, answer in own.items():
        if int(code) >= 400 and "content" not in answer:  # FastAPI's own 422 has content
            told = answer["description"]  # by that alone where we show no example
            shown = _SHOWN.get(int(code), Shown(when=told, detail=told))
            answers[code] = _response(int(code), replace(shown, when=told), problem)
    return dict(sorted(answers.items()))


def _response(code: int, shown: Shown, problem: dict[str, Any]) -> dict[str, Any]:
    example = {
        "type": "about:blank",
        "title": HTTPStatus(code).phrase,
        "status": code,
        "detail": shown.detail,
        "instance": _INSTANCE,
    }
    response: dict[str, Any] = {
        "description": shown.when,
        "content": {PROBLEM_JSON: {"schema": problem, "example": example | shown.members}},
    }
    if shown.headers:
        response["headers"] = {
            name: {"description": meaning, "schema": {"type": "string"}}
            for name, meaning in shown.headers.items()
        }
    return response
