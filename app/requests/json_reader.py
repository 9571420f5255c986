"""Reads a JSON text as a `@spec` value, and names each field at fault; writes such a value.

The HTTP service and the command line read requests here and nowhere else.
"""

import dataclasses
import functools
import json
import math
import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from functools import cached_property
from typing import Any, ClassVar, Generic, Literal, TypeVar, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter, ValidationError
from pydantic.json_schema import GenerateJsonSchema
from pydantic_core import CoreSchema, SchemaValidator, core_schema

from app.requests.plain_text import CHARACTERS_MAX, require_message, require_plain, visible
from planner.base.errors import Blame, FieldError, InvalidRequest, Refusal, with_short_values
from planner.base.spec import as_kept
from planner.world.frames.time_scales import utc_from_text, utc_text
from planner.world.targets.names import suggest_at_most

ERRORS_SHOWN = 50
FIELDS_MAX = 1000  # of one object, and
OBJECTS_MAX = 50_000  # of one request, ten thousand targets have four each: against hostile ones
VALUE_SHOWN_CHARACTERS = 80
DIGITS_MAX = VALUE_SHOWN_CHARACTERS  # of one number
VALUES_MAX = 500_000  # eight megabytes of `[],[],` would become 2.8 million lists, and
DEPTH_MAX = 50  # of `[[[[` a stack overflow
_TOO_MANY = f"it has more than {VALUES_MAX} values"
# A string that never ends runs to the end, so that the search stays linear.
_STRING = re.compile(rb'"[^"\\]*+(?:\\.[^"\\]*+)*+"?', re.DOTALL)
_BRACKET = re.compile(rb"[][{}]")
_BOUNDS = frozenset({"min_length", "max_length", "ge", "gt", "le", "lt"})  # in a core schema
_MESSAGE = "content"  # the field of orbits and attitudes that holds a whole CCSDS message

T = TypeVar("T")


class JsonReader(Generic[T]):
    """Reads JSON as one `@spec` class, strictly.

    Beyond what `@spec` makes pydantic refuse (unknown fields, NaN, `true` for a number):
    times go through `utc_from_text`, so they carry an offset and may be leap seconds; the
    member of a union is chosen by its kind alone, which must be given; no object holds a
    field twice; all text but CCSDS messages is short and plain.
    plain: of a request that may be written in another way, the document as the class reads it;
    the very same where nothing is to be changed.  add_to_schema: what else may be sent.
    """

    def __init__(
        self,
        cls: type[T],
        plain: Callable[[object], object] = lambda document: document,
        add_to_schema: Callable[[dict[str, Any]], None] = lambda schema: None,
    ) -> None:
        self._class, self._plain, self._add_to_schema = cls, plain, add_to_schema
        self.kind: type[T] = getattr(cls, "__origin__", cls)  # of an Annotated one

    @cached_property
    def _schema(self) -> CoreSchema:
        return TypeAdapter(self._class).core_schema

    @cached_property
    def _validator(self) -> SchemaValidator:
        """When it is first needed: it takes 10 ms and more."""
        return SchemaValidator(_with_our_text(self._schema, require_plain))

    @cached_property
    def _kept_validator(self) -> SchemaValidator:
        return SchemaValidator(_with_our_text(self._schema, visible, without=_BOUNDS))

    def read(self, body: bytes) -> T:
        """The value; raises InvalidRequest with the fields at fault."""
        sent = json_document(body)
        document = self._plain(sent)
        if document is not sent:
            body = json.dumps(document).encode()
        try:
            with suggest_at_most(ERRORS_SHOWN):
                value: T = self._validator.validate_json(body)
        except ValidationError as error:
            found = error.errors(include_url=False)
        else:
            return value
        raise InvalidRequest(*field_errors(found, document))

    def read_kept(self, body: bytes) -> T:
        """What was accepted before, by whatever bounds held then; hidden characters are left out.

        Raises KeptUnreadable where the fields have changed since.
        """
        try:
            with as_kept():
                document = json.dumps(self._plain(json.loads(body)))
                value: T = self._kept_validator.validate_json(document)
        except ValidationError as error:
            [first, *_] = field_errors(error.errors(include_url=False), json.loads(body))
            raise KeptUnreadable(str(first)) from None
        except Refusal as refusal:
            raise KeptUnreadable(refusal.detail) from None
        return value

    def json_schema(self, ref_template: str) -> dict[str, Any]:
        """JSON Schema 2020-12; its `$defs` hold what it refers to by `ref_template`."""
        schema = _JsonSchema(ref_template=ref_template).generate(self._schema)
        definitions = schema.get("$defs", {})
        for definition in definitions.values():
            # A kind has a default for Python's sake; in a request it must be given.
            kinds = {n: field for n, field in definition["properties"].items() if "const" in field}
            definition["required"] = [*kinds, *definition.get("required", [])]
            for field in kinds.values():
                field.pop("default", None)
        self._add_to_schema(schema)
        return schema


class KeptUnreadable(Refusal):
    """What is kept was asked for in words that this version doesn't know."""

    slug: ClassVar[str] = "kept-unreadable"
    title: ClassVar[str] = "The request of what is kept can't be read by this version"
    blame: ClassVar[Blame] = "conflict"

    def __init__(self, detail: str) -> None:
        super().__init__(
            "what is kept and its table stay as they were answered, in JSON; but this version of "
            f"slewtrack can't read the request they were made for ({detail}): have this made by "
            "the version that `provenance` names, or send the request anew"
        )


class _JsonSchema(GenerateJsonSchema):
    """Without titles, which only repeat the names of the fields; kinds as they are registered."""

    def field_title_should_be_set(self, schema: Any) -> bool:  # noqa: ANN401 (pydantic's)
        return False

    def sort(self, value: dict[str, Any], *_: object, **__: object) -> dict[str, Any]:
        return value


def field_errors(errors: Sequence[Mapping[str, Any]], document: object) -> list[FieldError]:
    """Pydantic's findings in our words, by the fields of the document as it was sent."""
    return [_field_error(error, document) for error in errors[:ERRORS_SHOWN]]


def beyond_bounds(body: bytes) -> str | None:
    """What is too much, with the cap, before anything is built; None when nothing is."""
    # Each value has two strings at most, its name and itself: cheaper to count than to find.
    if body.count(b'"') - body.count(b'\\"') > 4 * VALUES_MAX:
        return _TOO_MANY
    outside_strings = _STRING.sub(b"", body)
    # A value follows each comma and each opening bracket, if not the bracket's end.
    values = sum(outside_strings.count(mark) for mark in (b",", b"[", b"{"))
    if values > VALUES_MAX:
        return _TOO_MANY
    depth = 0
    for bracket in _BRACKET.findall(outside_strings):
        depth += 1 if bracket in b"[{" else -1
        if depth > DEPTH_MAX:
            return f"it is nested more than {DEPTH_MAX} deep"
    return None


def json_document(body: bytes) -> object:
    """The JSON value, to look field names up in; refuses what isn't JSON."""
    objects = 0

    def members(pairs: list[tuple[str, object]]) -> dict[str, object]:
        nonlocal objects
        objects += 1
        if objects > OBJECTS_MAX:
            raise ValueError(f"it has more than {OBJECTS_MAX} objects")
        return _members(pairs)

    try:
        text = body.decode("utf-8")
        if too_much := beyond_bounds(body):
            raise ValueError(too_much)
        return json.loads(
            text,
            object_pairs_hook=members,
            parse_int=lambda digits: int(_require_few(digits)),
            parse_float=lambda digits: float(_require_few(digits)),
        )
    except UnicodeDecodeError as error:
        fault = f"the request must be UTF-8 text; byte {error.start} is not"
    except ValueError as error:  # also a field twice, a number of 5000 digits
        fault = f"the request can't be read as JSON: {error}"
    raise InvalidRequest(FieldError(field="", detail=fault))


def _require_few(digits: str) -> str:
    if len(digits) > DIGITS_MAX:
        raise ValueError(f"a number has {len(digits)} digits, more than {DIGITS_MAX}")
    return digits


def _members(pairs: list[tuple[str, object]]) -> dict[str, object]:
    members = dict(pairs)
    if len(pairs) > FIELDS_MAX:
        raise ValueError(f"an object has {len(pairs)} fields, more than {FIELDS_MAX}")
    if len(members) < len(pairs):
        [(field, times)] = Counter(field for field, _ in pairs).most_common(1)
        raise ValueError(f"{_shorten(field)!r} is given {times} times in one object; keep one")
    return members


def _with_our_text(
    node: Any,  # noqa: ANN401 (a core schema is nested plain data)
    text: Callable[[str], str],
    field: str = "",
    without: frozenset[str] = frozenset(),
) -> Any:  # noqa: ANN401 (as above)
    """The core schema with `text` applied to text, and times read as we do: with leap seconds.

    A union's kind, when it is unknown or missing, is answered with those there are.
    """
    if isinstance(node, list | tuple):
        return type(node)(_with_our_text(item, text, field, without) for item in node)
    if not isinstance(node, dict):
        return node
    node = {key: value for key, value in node.items() if key not in without}
    match node.get("type"):
        case "datetime":
            return core_schema.no_info_after_validator_function(
                _utc, core_schema.str_schema(strict=True)
            )
        case "str":
            if field != _MESSAGE:
                return core_schema.no_info_after_validator_function(text, node)
            return core_schema.no_info_after_validator_function(require_message, node)
        case "tagged-union" if isinstance(node["discriminator"], str):
            node = node | {
                "custom_error_type": "unknown_kind",
                "custom_error_message": f"must be one of {', '.join(node['choices'])}",
                "custom_error_context": {"member": node["discriminator"]},
            }
        case "dataclass-field":
            field = node["name"]
    return {key: _with_our_text(value, text, field, without) for key, value in node.items()}


def _utc(text: str) -> datetime:
    return utc_from_text(text if len(text) <= CHARACTERS_MAX else require_plain(text))


def _field_error(error: Mapping[str, Any], document: object) -> FieldError:
    kind, given = error["type"], error["input"]
    path, node = _path_in(document, error["loc"], keep_absent_end=kind == "missing")
    detail = _detail(error)
    if kind == "unknown_kind":
        path.append(error["ctx"]["member"])
        given = node.get(path[-1]) if isinstance(node, dict) else node
    if kind == "value_error":
        # Our own ValueErrors begin with the field at fault.
        name, _, rest = detail.partition(" ")
        name = name.removesuffix(":")
        is_missing = rest.startswith("is required")
        named_path, named = _path_in(node, name.split("."), keep_absent_end=is_missing)
        if ".".join(named_path) == name:
            path, detail, given = path + named_path, rest, named
    value = _short_value(given)
    if kind not in ("value_error", "missing", "unexpected_keyword_argument") and value is not None:
        detail += f", not {json.dumps(value)}"
    return FieldError(
        field=with_short_values(".".join(path)),
        detail=with_short_values(detail),
        value=value,
        candidates=getattr(error.get("ctx", {}).get("error"), "candidates", ()),
    )


def _path_in(
    document: object, location: Sequence[int | str], keep_absent_end: bool = False
) -> tuple[list[str], object]:
    """The part of a location that exists in the document, and the value there.

    Pydantic's locations also hold the kinds of tagged unions, which the document doesn't.
    """
    path, node = [], document
    for depth, key in enumerate(location):
        if isinstance(node, dict) and key in node:
            node = node[key]
        elif isinstance(node, list) and str(key).isdecimal() and int(key) < len(node):
            node = node[int(key)]
        elif not (keep_absent_end and depth == len(location) - 1):
            continue
        path.append(_shorten(str(key)))
    return path, node


_DETAILS = {
    "missing": "is required",
    "unexpected_keyword_argument": "is not a field of this object; remove it or correct its name",
    "extra_forbidden": "is not known here; remove it or correct its name",
    "bool_parsing": "must be true or false",
    "bool_type": "must be true or false",
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_parsing_size": "must be a whole number of fewer digits",
    "string_type": "must be a string",
    "string_too_short": "must have at least {min_length} character",
    "none_required": "must be null",
    "dataclass_type": "must be an object",
    "dict_type": "must be an object",
    "tuple_type": "must be a list",
    "too_long": "must hold at most {max_length} entries",
    "too_short": "must hold at least {min_length} entries",
    "literal_error": "must be {expected}",
    "greater_than": "must be more than {gt:g}",
    "greater_than_equal": "must be at least {ge}",
    "less_than_equal": "must be at most {le}",
    "json_invalid": "the request can't be read as JSON: {error}",
}


def _detail(error: Mapping[str, Any]) -> str:
    context = error.get("ctx", {})
    match error["type"]:
        case "value_error":
            return str(context["error"])
        case "finite_number":
            return f"must be a finite number, not {error['input']}"
        case "unknown_kind":
            return str(error["msg"])
        case kind:
            return _DETAILS.get(kind, "can't be read as what belongs here").format_map(context)


def _short_value(value: object) -> str | float | int | bool | None:
    """A value fit to be repeated: scalars, cut short; never NaN, which is no JSON."""
    if isinstance(value, str):
        return _shorten(value)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, bool | int | float) else None


def _shorten(text: str) -> str:
    return text if len(text) <= VALUE_SHOWN_CHARACTERS else text[:VALUE_SHOWN_CHARACTERS] + "..."


def json_fields(value: object, words: Mapping[str, Any] = {}) -> dict[str, Any]:
    """Its fields by name: those that aren't as by default, and the kind by which it is told apart.

    words: of fields that are to stay as they were sent, since they may be said in several ways:
    a platform by its name, an orbit as a file's content.
    """
    kinds = _kinds_of(type(value))  # type: ignore[arg-type]  # a class has a hash
    written = {}
    assert dataclasses.is_dataclass(value)
    for field in dataclasses.fields(value):
        given = getattr(value, field.name)
        if field.name in words:
            written[field.name] = words[field.name]
        elif field.name in kinds or given != _default(field):
            written[field.name] = _plain(given)
    return written


@functools.cache
def _kinds_of(kind: type) -> frozenset[str]:
    """Fields that have one value by which a kind is told apart."""
    hints = get_type_hints(kind).items()
    return frozenset(
        name for name, hint in hints if get_origin(hint) is Literal and len(get_args(hint)) == 1
    )


def _default(field: "dataclasses.Field[Any]") -> object:
    made = field.default_factory
    return field.default if made is dataclasses.MISSING else made()


def _plain(value: object) -> object:
    if dataclasses.is_dataclass(value):
        return json_fields(value)
    if isinstance(value, Mapping):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, tuple):
        return [_plain(part) for part in value]
    return utc_text(value, 6) if isinstance(value, datetime) else value
