"""What the OpenAPI document says beyond what FastAPI finds by itself."""

import json
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from app.answers.problem import Problem
from app.http.door.access import PROBES, scope_needed
from app.http.openapi.refusals import document_refusals
from app.requests.campaign import campaign_request_json_schema
from app.requests.horizon import horizon_request_json_schemas
from app.requests.opportunities import opportunity_request_json_schema
from app.requests.plan import plan_request_json_schema
from app.requests.spacecraft import spacecraft_request_json_schema

ANSWERS = Path(__file__).parent / "data" / "answers.json"
REF = "#/components/schemas/{model}"

KEY_SCHEME = "key"
_REQUESTS = {
    "PlanRequest": plan_request_json_schema,
    "CampaignRequest": campaign_request_json_schema,
    "OpportunityRequest": opportunity_request_json_schema,
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
    """FastAPI's document with our requests, which we read ourselves, and all that is answered."""
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    described = {name: json_schema(REF) for name, json_schema in _REQUESTS.items()}
    described |= horizon_request_json_schemas(REF)
    described["Problem"] = TypeAdapter(Problem).json_schema(ref_template=REF)
    for name, schema in described.items():
        schemas |= schema.pop("$defs", {})
        schemas[name] = schema
    document_refusals(document, REF)
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
    return document


def _document_answers(document: dict[str, Any]) -> None:
    """Add the worked answers, as they were really given and as the document nests them."""
    shown = json.loads(ANSWERS.read_text())
    for path, methods in shown.items():
        for method, statuses in methods.items():
            for status, media_types in statuses.items():
                content = document["paths"][path][method]["responses"][status]["content"]
                for media_type, examples in media_types.items():
                    content[media_type]["examples"] = examples
