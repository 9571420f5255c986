"""Gives each field of the schema an example: its value in the worked requests and answers."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from app.http.openapi.fields import Schema

_ENTRIES_SHOWN = 5  # no list of fixed length has more
_CHARACTERS_SHOWN = 300  # of a text; whole messages are in the worked examples


def show_examples(document: Schema) -> None:
    """Add `examples` to the fields of the document's schemas, from its operations' examples.

    Fields whose values are objects have theirs field by field.  What no example holds is shown
    by its first choice or its default.
    """
    schemas = document["components"]["schemas"]
    for schema, value in _worked(document):
        _show(schema, value, schemas)
    for schema in schemas.values():
        for field in schema.get("properties", {}).values():
            if "examples" not in field and (shown := _by_itself(field)) is not None:
                field["examples"] = [shown]


def _worked(document: Schema) -> Iterator[tuple[Schema, Any]]:
    """Schemas with the values shown for them."""
    for operations in document["paths"].values():
        for operation in operations.values():
            bodies = [operation.get("requestBody", {}), *operation["responses"].values()]
            for content in (body.get("content", {}) for body in bodies):
                yield from _of_content(content)
    for response in document["components"]["responses"].values():
        yield from _of_content(response["content"])


def _of_content(content: Mapping[str, Schema]) -> Iterator[tuple[Schema, Any]]:
    for media in content.values():
        if "schema" in media:
            values = [example["value"] for example in media.get("examples", {}).values()]
            values += [media["example"]] if "example" in media else []
            yield from ((media["schema"], value) for value in values)
            for part in media["schema"].get("properties", {}).values():  # of a form
                yield from ((part, value) for value in part.get("examples", ()))


def _show(schema: Schema, value: Any, schemas: Mapping[str, Schema]) -> None:  # noqa: ANN401
    """Go down both together, and leave the value at each field that has none yet."""
    schema = _meant(schema, value, schemas)
    if isinstance(value, dict):
        fields, others = schema.get("properties", {}), schema.get("additionalProperties")
        for name, part in value.items():
            field = fields.get(name, others)
            if isinstance(field, dict):
                _show(field, part, schemas)
                if name in fields and part not in (None, [], {}) and not _has_fields(field):
                    field.setdefault("examples", [_short(part)])
    elif isinstance(value, list) and isinstance(schema.get("items"), dict):
        for part in value:
            _show(schema["items"], part, schemas)


def _meant(schema: Schema, value: Any, schemas: Mapping[str, Schema]) -> Schema:  # noqa: ANN401
    """What a value is, where the schema refers to another or leaves a choice."""
    if "$ref" in schema:
        return schemas[schema["$ref"].rsplit("/", 1)[1]]
    choices = [
        _meant(one, value, schemas) for part in ("oneOf", "anyOf") for one in schema.get(part, ())
    ]
    return next((one for one in choices if _fits(one, value)), schema)


def _fits(schema: Schema, value: Any) -> bool:  # noqa: ANN401
    if isinstance(value, list):
        return schema.get("type") == "array"
    if not isinstance(value, dict):
        return False
    fields = schema.get("properties", {})
    is_known = value.keys() <= fields.keys() or "additionalProperties" in schema
    kinds = ((name, field["const"]) for name, field in fields.items() if "const" in field)
    return (
        schema.get("type") == "object"
        and is_known
        and {*schema.get("required", ())} <= value.keys()
        and all(value.get(name, kind) == kind for name, kind in kinds)
    )


def _has_fields(field: Schema) -> bool:
    """Whether it holds objects, which have fields with examples of their own."""
    return "$ref" in json.dumps(field)


def _short(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, str):
        return value[:_CHARACTERS_SHOWN]
    if isinstance(value, dict):
        return {name: _short(part) for name, part in value.items()}
    return value[:_ENTRIES_SHOWN] if isinstance(value, list) else value


def _by_itself(field: Schema) -> object:
    """Its first choice or default; None where it holds objects or says neither."""
    if _has_fields(field):
        return None
    for part in (field, *field.get("anyOf", ())):
        if "const" in part or "enum" in part:
            return part.get("const") or part["enum"][0]
    return field.get("default")
