"""What must the OpenAPI document say beyond what FastAPI finds by itself?"""

from http import HTTPStatus
from typing import Any

from pydantic import TypeAdapter

from app.api.plan_request import plan_request_json_schema
from app.errors import PROBLEM_JSON, Problem

REF = "#/components/schemas/{model}"

_REFUSALS_OF_BODIES = {
    HTTPStatus.REQUEST_ENTITY_TOO_LARGE: "The request is too long",
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: "The request is no JSON",
    HTTPStatus.UNPROCESSABLE_ENTITY: "The request is refused: what is at fault, and the way out",
}
_REFUSALS_OF_ALL = {
    HTTPStatus.NOT_ACCEPTABLE: "The Accept header admits no JSON",
    HTTPStatus.INTERNAL_SERVER_ERROR: "The service failed; the request is not at fault",
}


def complete(document: dict[str, Any]) -> dict[str, Any]:
    """FastAPI's document with our request, which we read ourselves, and every refusal."""
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    request = plan_request_json_schema(REF)
    problem = TypeAdapter(Problem).json_schema(ref_template=REF)
    for name, schema in (("PlanRequest", request), ("Problem", problem)):
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
