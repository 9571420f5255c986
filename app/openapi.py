"""What must the OpenAPI document say beyond what FastAPI finds by itself?"""

from http import HTTPStatus
from typing import Any

from pydantic import TypeAdapter

from app.api.horizon_request import horizon_request_json_schemas
from app.api.opportunity_request import opportunity_request_json_schema
from app.api.plan_request import plan_request_json_schema
from app.api.spacecraft_request import spacecraft_request_json_schema
from app.errors import PROBLEM_JSON, Problem

REF = "#/components/schemas/{model}"

_REFUSALS_OF_BODIES = {
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE: "The request is too long",
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: "The request is of another media type than we read",
    HTTPStatus.UNPROCESSABLE_ENTITY: "The request is refused: what is at fault, and the way out",
}
_REFUSALS_OF_ALL = {
    HTTPStatus.NOT_ACCEPTABLE: "The Accept header admits nothing we answer with",
    HTTPStatus.INTERNAL_SERVER_ERROR: "The service failed; the request is not at fault",
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
    for operations in document["paths"].values():
        for operation in operations.values():
            refusals = dict(_REFUSALS_OF_ALL)
            if "requestBody" in operation:
                refusals |= _REFUSALS_OF_BODIES
            operation["responses"] |= {
                str(status.value): _problem(description)
                for status, description in sorted(refusals.items())
            }
    for stock in ("HTTPValidationError", "ValidationError"):
        schemas.pop(stock, None)
    return document


def _problem(description: str) -> dict[str, Any]:
    return {
        "description": description,
        "content": {PROBLEM_JSON: {"schema": {"$ref": REF.format(model="Problem")}}},
    }
