"""What must the OpenAPI document say beyond what FastAPI finds by itself?"""

from http import HTTPStatus
from typing import Any

from pydantic import TypeAdapter

from app.api.horizon_request import horizon_request_json_schemas
from app.api.opportunity_request import opportunity_request_json_schema
from app.api.plan_request import plan_request_json_schema
from app.api.spacecraft_request import spacecraft_request_json_schema
from app.errors import PROBLEM_JSON, Problem
from app.security.access import PROBES, scope_needed

REF = "#/components/schemas/{model}"

KEY_SCHEME = "key"

_REFUSALS_OF_BODIES = {
    HTTPStatus.REQUEST_TIMEOUT: "The body comes too slowly",
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE: "The request is too long",
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: "The request is of another media type than we read",
}
_REFUSALS_OF_WORDS = {
    HTTPStatus.UNPROCESSABLE_ENTITY: "The request is refused: what is at fault, and the way out",
}
_REFUSALS_OF_ALL = {
    HTTPStatus.BAD_REQUEST: "The request can't be read as HTTP",
    HTTPStatus.NOT_ACCEPTABLE: "The Accept header admits nothing we answer with",
    HTTPStatus.REQUEST_URI_TOO_LONG: "The address is too long",
    HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: "The head of the request is too long",
    HTTPStatus.INTERNAL_SERVER_ERROR: "The service failed; the request is not at fault",
    HTTPStatus.SERVICE_UNAVAILABLE: "The service has too much to do, or isn't ready",
}
_REFUSALS_OF_ACCESS = {
    HTTPStatus.UNAUTHORIZED: "An API key is needed, and none or an unknown one was sent",
    HTTPStatus.FORBIDDEN: "The key lacks the scope, or a web page of another site asks",
    HTTPStatus.MISDIRECTED_REQUEST: "Without a key: the Host header names none of our hosts",
    HTTPStatus.TOO_MANY_REQUESTS: "Too many requests a minute, or at a time; see Retry-After",
}
_HEADERS_OF_REFUSALS = {
    HTTPStatus.UNAUTHORIZED: {"WWW-Authenticate": "How to send a key (RFC 6750)"},
    HTTPStatus.TOO_MANY_REQUESTS: {"Retry-After": "Seconds to wait"},
    HTTPStatus.SERVICE_UNAVAILABLE: {"Retry-After": "Seconds to wait"},
}


_REQUESTS = {
    "PlanRequest": plan_request_json_schema,
    "OpportunityQuery": opportunity_request_json_schema,
    "ImagingPlanRequest": spacecraft_request_json_schema,
}


def request_body(schema: str, examples: dict[str, tuple[str, dict[str, Any]]]) -> dict[str, Any]:
    """An operation's JSON body with its worked examples, by name: (summary, request)."""
    return {
        "requestBody": {
            "required": True,
            "content": {
                "application/json": {
                    "schema": {"$ref": REF.format(model=schema)},
                    "examples": {
                        name: {"summary": summary, "value": value}
                        for name, (summary, value) in examples.items()
                    },
                }
            },
        }
    }


def complete(document: dict[str, Any]) -> dict[str, Any]:
    """FastAPI's document with our requests, which we read ourselves, and every refusal."""
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    described = {name: json_schema(REF) for name, json_schema in _REQUESTS.items()}
    described |= horizon_request_json_schemas(REF)
    described["Problem"] = TypeAdapter(Problem).json_schema(ref_template=REF)
    for name, schema in described.items():
        schemas |= schema.pop("$defs", {})
        schemas[name] = schema
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            _complete_operation(operation, method.upper(), path)
    document["components"]["securitySchemes"] = {
        KEY_SCHEME: {
            "type": "http",
            "scheme": "bearer",
            "description": "`Authorization: Bearer slewtrack_...`, a key of `slewtrack keys "
            "create`. Scopes: read (GET), write (also POST and DELETE), admin (also the audit "
            "log). On loopback without a proxy none is needed unless the operator says so.",
        }
    }
    for stock in ("HTTPValidationError", "ValidationError"):
        schemas.pop(stock, None)
    return document


def _complete_operation(operation: dict[str, Any], method: str, path: str) -> None:
    refusals = dict(_REFUSALS_OF_ALL)
    if "requestBody" in operation:
        refusals |= _REFUSALS_OF_BODIES
    if "requestBody" in operation or "parameters" in operation:
        refusals |= _REFUSALS_OF_WORDS
    if path not in PROBES:
        refusals |= _REFUSALS_OF_ACCESS
        # OpenAPI 3.1 lists a key's roles here; the empty way is that of loopback.
        operation["security"] = [{KEY_SCHEME: [scope_needed(method, path)]}, {}]
    answers = operation["responses"]
    for status, general in refusals.items():
        found = answers.get(str(status.value), {})
        told = general if "content" in found else found.get("description", general)
        answers[str(status.value)] = _problem(told, _HEADERS_OF_REFUSALS.get(status))
    for code, answer in answers.items():
        if int(code) >= 400 and "content" not in answer:
            answers[code] = _problem(answer["description"], None)
    operation["responses"] = dict(sorted(answers.items()))


def _problem(description: str, headers: dict[str, str] | None) -> dict[str, Any]:
    told: dict[str, Any] = {
        "description": description,
        "content": {PROBLEM_JSON: {"schema": {"$ref": REF.format(model="Problem")}}},
    }
    if headers:
        told["headers"] = {
            name: {"description": meaning, "schema": {"type": "string"}}
            for name, meaning in headers.items()
        }
    return told
