"""Gives each field of the schema its text, unit and example.

A field is told beside it, in its class's docstring: `name: text.`, at the start of a line or
after two spaces, up to the next such entry or an empty line; `one, other: text.` for several.
A unit that the name doesn't end in stands at the end, in brackets.
A field that is told under another name (`planner/base/answer_members.py`) has its own name there.
Its example is its value in the worked requests and answers; one that none of them holds stands
beside it as "E.g. `JSON`.".
Fields that many classes share say it in their type (`About`); a field that is a whole object
needs no text where the object's class says what it is.
"""

import inspect
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from typing import Any, get_args, get_type_hints

from pydantic import BaseModel

from planner.base.answer_members import member_names
from planner.base.spec import About

Schema = dict[str, Any]

_ENTRY = re.compile(r"(?:^|(?<=  ))(\w+(?:, \w+)*):\s", re.MULTILINE)
# At a name's end, the longest that fits, and how it is written.
_UNITS = {
    "arcmin_s": "arcmin/s",
    "arcsec": "arcsec",
    "arcsec_s": "arcsec/s",
    "deg": "deg",
    "deg2": "deg^2",
    "deg2_s5": "deg^2/s^5",
    "deg_s": "deg/s",
    "deg_s2": "deg/s^2",
    "deg_s3": "deg/s^3",
    "e": "electrons",
    "gbit": "Gbit",
    "gbit_s": "Gbit/s",
    "hz": "Hz",
    "jyear": "Julian year",
    "kg": "kg",
    "kg_m2": "kg m^2",
    "km": "km",
    "km_s": "km/s",
    "m": "m",
    "m2": "m^2",
    "m_s": "m/s",
    "mas": "mas",
    "mas_yr": "mas/yr",
    "n_m": "N m",
    "n_m_s": "N m s",
    "per_s": "1/s",
    "per_s2": "1/s^2",
    "px": "pixels",
    "s": "s",
    "w": "W",
    "wh": "Wh",
}
_TORQUE_RATE = re.compile(r"torque_rate_\w*n_m_s$")  # N m/s, where momentum is in N m s
_UNIT_SAID = re.compile(r"\s*\[([^\[\]]+)\]\.?$")
_EXAMPLE_SAID = re.compile(r"\s*E\.g\. `([^`]+)`\.?")
_PURE = "1"
_ENTRIES_SHOWN = 5  # no list of fixed length has more
_CHARACTERS_SHOWN = 300  # of a text; whole messages are in the worked examples


def describe(schemas: Mapping[str, Schema], kinds: Iterable[object]) -> None:
    """Tell every field of the classes that `kinds` hold, in the schemas of their names."""
    for kind in dict.fromkeys(_classes(kinds, set())):
        schema = schemas.get(kind.__name__)
        if schema is None:  # read in another form, as a platform is
            continue
        names = _names(kind)
        texts = {names[ours]: text for ours, text in field_texts(kind).items()}
        schema["title"] = kind.__name__
        schema["description"] = class_text(kind)
        for name, field in schema.get("properties", {}).items():
            _describe(field, name, texts.get(name, ""), schemas)


def field_texts(kind: type) -> dict[str, str]:
    """What the docstrings of a class and its bases, or their types, say of its fields."""
    hints = get_type_hints(kind, include_extras=True)
    texts = {name: text for name, hint in hints.items() if (text := _about(hint))}
    for owner in reversed(kind.__mro__):
        for names, text in entries(owner, _names(kind)):
            texts |= dict.fromkeys(names, text)
    return texts


def entries(owner: type, names: Iterable[str]) -> Iterator[tuple[list[str], str]]:
    """Of a class's docstring: the fields among these that each is about, and its text."""
    doc = _doc(owner)
    for match, end in _matches(doc, names):
        text = " ".join(doc[match.end() : end].split())
        yield match[1].split(", "), text[:1].upper() + text[1:].rstrip(".") + "."


def class_text(kind: type) -> str:
    """Its docstring but for what that says of the fields."""
    doc = _doc(kind)
    for match, end in reversed([*_matches(doc, _names(kind))]):
        doc = doc[: match.start()].rstrip(" ") + doc[end:]
    return re.sub(r"\n{3,}", "\n\n", doc).strip()


def _names(kind: type) -> dict[str, str]:
    """Of its members, by those of its fields and of properties that are told."""
    return {name: name for name in get_type_hints(kind)} | member_names(kind)


def unit_of(name: str) -> str:
    """By the end of a field's name; 1 for a pure number."""
    if _TORQUE_RATE.search(name):
        return "N m/s"
    words = name.split("_")
    for first in range(len(words)):
        if unit := _UNITS.get("_".join(words[first:])):
            return unit
    return _PURE


def is_number(schema: object) -> bool:
    """Whether it, or each of the values it holds, is or may be a number."""
    if isinstance(schema, list):
        return any(map(is_number, schema))
    if not isinstance(schema, dict):
        return False
    inner = ("items", "prefixItems", "anyOf", "oneOf", "additionalProperties")
    return schema.get("type") in ("number", "integer") or any(
        is_number(schema[part]) for part in inner if part in schema
    )


def _describe(field: Schema, name: str, text: str, schemas: Mapping[str, Schema]) -> None:
    field.pop("title", None)  # repeats the name
    unit = unit_of(name)
    if said := _UNIT_SAID.search(text):
        unit, text = said[1], text[: said.start()].rstrip(".") + "."
    if said := _EXAMPLE_SAID.search(text):
        field["examples"] = [json.loads(said[1])]
        text = text[: said.start()] + text[said.end() :]
    text = text or _of_the_object(field, schemas)
    if "const" in field:
        text = text or f"Says which kind this is: `{field['const']}`."
    if is_number(field):
        field["x-unit"] = unit
        text += f" Unit: {unit}." if text and unit != _PURE else ""
    for choice in (field, field.get("items", {}), field.get("additionalProperties", {})):
        if kinds := isinstance(choice, dict) and choice.get("discriminator"):
            choice["type"] = "object"  # which pages name
            text += f" `{kinds['propertyName']}` is one of `{'`, `'.join(kinds['mapping'])}`."
    default = field.get("default")
    if default and ("$ref" in field or "oneOf" in field or isinstance(default, dict)):
        # Generators of clients know no defaults that are objects.
        left_out = {k: v for k, v in field.pop("default").items() if v not in (None, [], {})}
        text += f" Left out: `{json.dumps(left_out)}`."
    if text:
        field["description"] = text


def _of_the_object(field: Schema, schemas: Mapping[str, Schema]) -> str:
    """What its class says of itself first, where a field holds an object or several."""
    for part in (field, field.get("items", {}), *field.get("anyOf", ())):
        if "$ref" in part:
            about: str = schemas[part["$ref"].rsplit("/", 1)[1]].get("description", "")
            return about.partition("\n\n")[0].replace("\n", " ")
    return ""


def _classes(parts: Iterable[object], known: set[object]) -> Iterator[type]:
    for part in parts:
        if isinstance(part, type) and (is_dataclass(part) or issubclass(part, BaseModel)):
            if part not in known:
                known.add(part)
                yield part
                yield from _classes(get_type_hints(part, include_extras=True).values(), known)
        else:
            yield from _classes(get_args(part), known)


def _about(hint: object) -> str:
    for part in get_args(hint):
        if text := part.text if isinstance(part, About) else _about(part):
            return text
    return ""


def _matches(doc: str, names: Iterable[str]) -> Iterator[tuple[re.Match[str], int]]:
    """Entries about these fields, and where each ends."""
    entries = [match for match in _ENTRY.finditer(doc) if {*match[1].split(", ")} <= {*names}]
    for match, after in zip(entries, (*entries, None)[1:], strict=True):
        blank = doc.find("\n\n", match.end())
        ends = (after.start() if after else len(doc), blank if blank >= 0 else len(doc))
        yield match, min(ends)


def _doc(kind: type) -> str:
    """As written; not what dataclasses make up."""
    doc = kind.__dict__.get("__doc__") or ""
    return "" if doc.startswith(f"{kind.__name__}(") else inspect.cleandoc(doc)


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
