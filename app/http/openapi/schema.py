"""Additions to the OpenAPI document that FastAPI makes: requests, refusals, keys, answers."""

import json
from collections.abc import Iterable, Mapping
from http import HTTPStatus
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from app.answers.problem import Problem
from app.http.admission.access import PROBES, scope_needed
from app.http.negotiation import EVENT_STREAM, JSON, MULTIPART
from app.http.openapi.fields import Schema, describe, show_examples
from app.http.problems import PROBLEM_JSON
from app.requests.examples import Examples
from app.requests.json_reader import JsonReader
from app.work.searches import FeatureCollection

_DATA = Path(__file__).parent / "data"
DESCRIPTION = (_DATA / "description.md").read_text().rstrip()
TAGS: list[Schema] = json.loads((_DATA / "tags.json").read_text())
ANSWERS = _DATA / "answers.json"
# By status: when it comes, an example of its detail, further members and headers.
_REFUSALS: dict[str, Schema] = json.loads((_DATA / "refusals.json").read_text())
_OF_BODIES = {"408", "413", "415"}
_OF_ACCESS = {"401", "403", "421", "429"}
REF = "#/components/schemas/{model}"

KEY_SCHEME = "key"
# By the name of their class, each as soon as a route tells of it.
_readers: dict[str, JsonReader[Any]] = {}


def schema_of(reader: JsonReader[Any]) -> Schema:
    """What a request is, as bodies refer to it; the document will say what it is."""
    _readers[reader.kind.__name__] = reader
    return {"$ref": REF.format(model=reader.kind.__name__)}


def json_body_of(reader: JsonReader[Any], examples: Examples) -> Schema:
    """An operation's JSON body with its worked examples, by name: (summary, request)."""
    shown = {
        name: {"summary": summary, "value": value} for name, (summary, value) in examples.items()
    }
    schemas = [schema_of(one) for one in (reader, *getattr(reader, "others", ()))]
    schema = schemas[0] if len(schemas) == 1 else {"anyOf": schemas}
    return _body({JSON: {"schema": schema, "examples": shown}})


def form_body_of(request: Schema, files: Mapping[str, Schema]) -> Schema:
    """An operation's multipart body: the part `request` holds JSON, the others are files."""
    form = {
        "type": "object",
        "required": ["request", *files],
        "properties": {"request": request, **files},
    }
    return _body({MULTIPART: {"schema": form, "encoding": {"request": {"contentType": JSON}}}})


def _body(content: Schema) -> Schema:
    return {"requestBody": {"required": True, "content": content}}


def complete(document: Schema, answers: Iterable[object]) -> Schema:
    """FastAPI's document with our requests, which we read ourselves, and all that is answered.

    answers: the classes of what the operations answer.
    """
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    described = {name: reader.json_schema(REF) for name, reader in _readers.items()}
    for kind in (Problem, FeatureCollection):
        described[kind.__name__] = TypeAdapter(kind).json_schema(ref_template=REF)
    for name, schema in described.items():
        schemas |= schema.pop("$defs", {})
        schemas[name] = schema
    describe(
        schemas,
        (*(reader.kind for reader in _readers.values()), Problem, FeatureCollection, *answers),
    )
    document["components"]["responses"] = {code: _refusal(code) for code in _REFUSALS}
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            if path not in PROBES:
                # OpenAPI 3.1 lists a key's roles here; the empty way is that of loopback.
                operation["security"] = [{KEY_SCHEME: [scope_needed(method.upper(), path)]}, {}]
            _add_by_rule(document["paths"], path, method)
            _add_refusals(path, operation)
            _tidy_parameters(operation)
    _add_worked_answers(document)
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
    show_examples(document)
    return document


def _add_by_rule(paths: Mapping[str, Schema], path: str, method: str) -> None:
    """Add the 404 of an id, the 304 of what has an ETag and the Location of what a POST makes.

    What is at an address of its own has an ETag: no list, to which one could POST, and no stream.
    """
    answers = paths[path][method]["responses"]
    owner, has_id, _ = path.partition("/{id}")
    if has_id:
        answers["404"] = {"description": f"There is no such {_singular(owner)}"}
    is_one = has_id and method == "get" and "post" not in paths[path]
    if is_one and EVENT_STREAM not in answers["200"]["content"]:
        answers["304"] = {"description": "Unchanged since the ETag that If-None-Match names"}
    if method == "post":
        is_searched = path + "/{id}" in paths and "201" not in answers
        for code in answers.keys() & ({"200"} if is_searched else {"201", "202"}):
            meaning = f"Address of the {_singular(path).split()[0]}"
            answers[code]["headers"] = {
                "Location": {"description": meaning, "schema": {"type": "string"}}
            }


def _singular(path: str) -> str:
    """One of what is at a path, in words."""
    word = path.rsplit("/", 1)[1]
    return "search for opportunities" if word == "opportunities" else word.removesuffix("s")


def _tidy_parameters(operation: Schema) -> None:
    """A parameter is left out, never null, and needs no title that repeats its name."""
    for parameter in operation.get("parameters", ()):
        schema = parameter["schema"]
        schema.pop("title", None)
        if "anyOf" in schema:
            [given] = [one for one in schema.pop("anyOf") if one != {"type": "null"}]
            schema |= given


def _add_worked_answers(document: Schema) -> None:
    """As they were really given and as the document nests them."""
    for path, methods in json.loads(ANSWERS.read_text()).items():
        for method, statuses in methods.items():
            for status, media_types in statuses.items():
                content = document["paths"][path][method]["responses"][status]["content"]
                for media_type, examples in media_types.items():
                    content[media_type]["examples"] = examples


def _add_refusals(path: str, operation: Schema) -> None:
    """What each operation may refuse; what it says itself of a status stays."""
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


def _refusal(code: str, description: str | None = None) -> Schema:
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
    response: Schema = {
        "description": description or refusal["when"],
        "content": {PROBLEM_JSON: {"schema": schema, "example": example}},
    }
    if "headers" in refusal:
        response["headers"] = {
            name: {"description": meaning, "schema": {"type": "string"}}
            for name, meaning in refusal["headers"].items()
        }
    return response
