"""Additions to the OpenAPI document that FastAPI makes: requests, refusals, keys, answers."""

import json
from collections.abc import Iterable
from http import HTTPStatus
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from app.answers.opportunities_geojson import FeatureCollection
from app.answers.problem import Problem
from app.http.admission.access import PROBES, scope_needed
from app.http.openapi.examples import show_examples
from app.http.openapi.fields import describe
from app.http.problems import PROBLEM_JSON
from app.requests.campaign import campaign_request_json_schema
from app.requests.flights import FlightsRequest, flights_request_json_schema
from app.requests.horizon import (
    PictureRequest,
    PredictionRequest,
    horizon_request_json_schemas,
)
from app.requests.opportunities import opportunity_request_json_schema
from app.requests.plan import PlanRequest, plan_request_json_schema
from app.requests.spacecraft import (
    imaging_opportunity_json_schema,
    spacecraft_request_json_schema,
)
from app.requests.telemetry import ComparisonRequest, comparison_request_json_schema
from estimator.request import HorizonRequest
from planner.planning.campaigns import CampaignRequest
from planner.planning.opportunities import OpportunityRequest
from planner.spacecraft.opportunity_request import ImagingOpportunityRequest
from planner.spacecraft.requests import ImagingPlanRequest

_DATA = Path(__file__).parent / "data"
ANSWERS = _DATA / "answers.json"
# By status: when it comes, an example of its detail, further members and headers.
_REFUSALS: dict[str, dict[str, Any]] = json.loads((_DATA / "refusals.json").read_text())
_OF_BODIES = {"408", "413", "415"}
_OF_ACCESS = {"401", "403", "421", "429"}
REF = "#/components/schemas/{model}"

KEY_SCHEME = "key"
_REQUESTS = {
    "PlanRequest": plan_request_json_schema,
    "CampaignRequest": campaign_request_json_schema,
    "FlightsRequest": flights_request_json_schema,
    "OpportunityRequest": opportunity_request_json_schema,
    "ImagingPlanRequest": spacecraft_request_json_schema,
    "ImagingOpportunityRequest": imaging_opportunity_json_schema,
    "ComparisonRequest": comparison_request_json_schema,
}

_REQUEST_KINDS = (
    PlanRequest,
    CampaignRequest,
    FlightsRequest,
    OpportunityRequest,
    ImagingPlanRequest,
    ImagingOpportunityRequest,
    HorizonRequest,
    PredictionRequest,
    PictureRequest,
    ComparisonRequest,
)


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


def complete(document: dict[str, Any], answers: Iterable[object]) -> dict[str, Any]:
    """FastAPI's document with our requests, which we read ourselves, and all that is answered.

    answers: the classes of what the operations answer.
    """
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    described = {name: json_schema(REF) for name, json_schema in _REQUESTS.items()}
    described |= horizon_request_json_schemas(REF)
    for kind in (Problem, FeatureCollection):
        described[kind.__name__] = TypeAdapter(kind).json_schema(ref_template=REF)
    for name, schema in described.items():
        schemas |= schema.pop("$defs", {})
        schemas[name] = schema
    describe(schemas, (*_REQUEST_KINDS, Problem, FeatureCollection, *answers))
    _document_refusals(document)
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            if path not in PROBES:
                # OpenAPI 3.1 lists a key's roles here; the empty way is that of loopback.
                operation["security"] = [{KEY_SCHEME: [scope_needed(method.upper(), path)]}, {}]
    _document_answers(document)
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
    _document_parameters(document)
    show_examples(document)
    return document


def _document_parameters(document: dict[str, Any]) -> None:
    """A parameter is left out, never null, and needs no title that repeats its name."""
    for operations in document["paths"].values():
        for operation in operations.values():
            for parameter in operation.get("parameters", ()):
                schema = parameter["schema"]
                schema.pop("title", None)
                if "anyOf" in schema:
                    [given] = [one for one in schema.pop("anyOf") if one != {"type": "null"}]
                    schema |= given


def _document_answers(document: dict[str, Any]) -> None:
    """Add the worked answers, as they were really given and as the document nests them."""
    shown = json.loads(ANSWERS.read_text())
    for path, methods in shown.items():
        for method, statuses in methods.items():
            for status, media_types in statuses.items():
                content = document["paths"][path][method]["responses"][status]["content"]
                for media_type, examples in media_types.items():
                    content[media_type]["examples"] = examples


def _document_refusals(document: dict[str, Any]) -> None:
    """Add what each operation may refuse; what it says itself of a status stays."""
    document["components"]["responses"] = {code: _refusal(code) for code in _REFUSALS}
    for path, operations in document["paths"].items():
        for operation in operations.values():
            codes = _REFUSALS.keys() - (_OF_ACCESS if path in PROBES else ())
            if "requestBody" not in operation:
                codes -= _OF_BODIES
            answers = {code: {"$ref": f"#/components/responses/{code}"} for code in codes}
            for code, answer in operation["responses"].items():
                if int(code) < 400:
                    answers[code] = answer
                elif "content" not in answer:  # FastAPI's own 422 has content
                    answers[code] = _refusal(code, answer["description"])
            operation["responses"] = dict(sorted(answers.items()))


def _refusal(code: str, description: str | None = None) -> dict[str, Any]:
    """Shown by its example, or by the description alone where there is none."""
    refusal = _REFUSALS.get(code) or {"detail": description}
    example = {
        "type": "about:blank",
        "title": HTTPStatus(int(code)).phrase,
        "status": int(code),
        "detail": refusal["detail"],
        "instance": "urn:uuid:7d3f2c1e-5b1a-4a52-9a7e-0c2f6f1d8b34",
    } | refusal.get("members", {})
    schema = {"$ref": REF.format(model="Problem")}
    response: dict[str, Any] = {
        "description": description or refusal["when"],
        "content": {PROBLEM_JSON: {"schema": schema, "example": example}},
    }
    if "headers" in refusal:
        response["headers"] = {
            name: {"description": meaning, "schema": {"type": "string"}}
            for name, meaning in refusal["headers"].items()
        }
    return response
