"""Requests for telemetry beside a plan: JSON with its columns, or the same columns as CSV."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from app.requests.json_reader import JsonReader, json_document
from planner.base.arrays import Array
from planner.base.errors import FieldError, InvalidRequest
from planner.base.spec import Within, spec
from planner.inflight.telemetry.samples import OPTIONS, ImageOffset
from planner.world.attitude.corrections import Corrections

_Second = Annotated[float, Within(-1e10, 1e10)] | None
_COLUMNS_MAX = 20
_TIMES = ("t_s", "utc")
_COLUMN_SCHEMA: dict[str, Any] = {
    "type": "array",
    "items": {"anyOf": [{"type": "number"}, {"type": "null"}]},
    "description": "A measured column, a number or null per time tag: NAME_deg and NAME_rate_deg_s "
    "for each axis NAME of the platform, or a body's q_1 to q_4 and omega_body_deg_s_x, _y, _z; "
    "angles also in rad, mrad, arcmin, arcsec.",
}


@spec
class TelemetrySamples:
    """Time tags by the telemetry's own clock, and per axis NAME of the platform a column of angles
    (`NAME_deg`), of rates (`NAME_rate_deg_s`) or both; of a body its attitude's quaternion (`q_1`
    to `q_4`), its rates (`omega_body_deg_s_x`, `_y`, `_z`) or both.

    Rows may be in any order, doubled, damaged or missing; null is no value. What was done with
    them is told.

    epoch: from which t_s counts; unless given, the plan's; UTC. E.g. `"2015-02-27T17:34:00Z"`.
    t_s: time tags, at most 400,000, which take 20 s of a processor; where JSON of so many is too
    long for a request, send CSV by multipart. E.g. `[100.0, 100.2, 100.4]`.
    utc: time tags instead of t_s; UTC. E.g. `["2015-02-27T17:35:40.000Z"]`.
    """

    epoch: datetime | None = None
    t_s: tuple[_Second, ...] = ()
    utc: tuple[str, ...] = ()


@spec
class ComparisonRequest:
    """Telemetry of the axes while a plan was flown, with corrections and image offsets of the same
    time.

    plan: id of the plan that was flown. E.g. `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    columns: names of columns that the samples call otherwise, by what they hold: t_s, utc, unix_s,
    an axis's NAME_deg, NAME_rate_deg_s or the like in its own unit, or a body's q_1. E.g.
    `{"t_s": "Time", "alpha_arcsec": "AZ encoder"}`.
    corrections: measured rotations of the carrier of two axes during the plan, each as a horizon
    estimate answers its `correction`. E.g. `[{"epoch": "2015-02-27T17:37:00Z", "turn_body_deg":
    [0.25, 0.05, 0.0], "covariance_deg2": [[4e-4, 0.0, 0.0], [0.0, 4e-4, 0.0],
    [0.0, 0.0, 32400.0]]}]`.
    image_offsets: positions of the target in frames of the session of two axes. E.g.
    `[{"epoch": "2015-02-27T17:37:00Z", "offset_deg": [0.12, -0.05], "sigma_deg": 0.001}]`.
    identify: parameters of the platform's drives to find, each `axis.field`, of plans up to 600 s;
    it takes 15 to 30 s of a processor. E.g. `["alpha.coulomb_deg_s2", "beta.coulomb_deg_s2"]`.
    """

    plan: str
    samples: TelemetrySamples | None = None
    columns: Annotated[Mapping[str, str], Field(max_length=_COLUMNS_MAX)] = field(
        default_factory=dict
    )
    corrections: Corrections = ()
    image_offsets: Annotated[
        tuple[ImageOffset, ...], Field(max_length=OPTIONS.image_offsets_max)
    ] = ()
    identify: Annotated[tuple[str, ...], Field(max_length=OPTIONS.parameters_max)] = ()

    def __post_init__(self) -> None:
        if not self.plan:
            raise ValueError("plan is required: the id of the plan that was flown")


@dataclass(frozen=True, kw_only=True, eq=False)
class SentSamples:
    """Of JSON.  t_s: (n,), NaN for null; None where utc tells the time.  columns: (n,) each."""

    t_s: Array | None
    utc: tuple[str, ...]
    columns: Mapping[str, Array]


def _add_columns(schema: dict[str, Any]) -> None:
    schema["$defs"]["TelemetrySamples"]["additionalProperties"] = _COLUMN_SCHEMA


COMPARISON_READER = JsonReader(ComparisonRequest, add_to_schema=_add_columns)


def read_comparison_request(body: bytes) -> tuple[ComparisonRequest, SentSamples]:
    """JSON with its samples; raises InvalidRequest."""
    document = json_document(body)
    samples = document.get("samples") if isinstance(document, dict) else None
    if not isinstance(document, dict) or not isinstance(samples, dict):
        COMPARISON_READER.read(body)
        detail = "is required: t_s and columns; or send CSV by multipart, as the part samples"
        raise InvalidRequest(FieldError(field="samples", detail=detail))
    sent = {name: samples[name] for name in samples if name != "epoch"}
    rest = {name: samples[name] for name in samples if name == "epoch"}
    request = COMPARISON_READER.read(json.dumps(document | {"samples": rest}).encode())
    for name, own in request.columns.items():
        if own not in sent:
            raise _fault(f"columns.{name}"[:80], f"names {own[:60]!r}, which samples doesn't hold")
    name_by_own = {own: name for name, own in request.columns.items()}
    return request, _sent({name_by_own.get(name, name): sent[name] for name in sent})


def read_comparison_head(body: bytes) -> ComparisonRequest:
    """What goes with CSV: all but the columns; raises InvalidRequest."""
    request = COMPARISON_READER.read(body)
    if request.samples is not None and (request.samples.t_s or request.samples.utc):
        detail = "stands in the CSV file; leave it out here"
        raise InvalidRequest(FieldError(field="samples.t_s", detail=detail))
    return request


def _sent(members: dict[str, Any]) -> SentSamples:
    if len(members) > _COLUMNS_MAX:
        raise _fault("samples", f"has {len(members)} columns; at most {_COLUMNS_MAX} are read")
    times = [name for name in _TIMES if members.get(name)]
    if len(times) != 1:
        raise _fault("samples.t_s", "is required, or utc instead: a time tag for each sample")
    utc = members.pop("utc", None) or []
    if not (isinstance(utc, list) and all(isinstance(text, str) for text in utc)):
        raise _fault("samples.utc", "must be a list of texts such as 2015-02-27T17:36:20.000Z")
    t_s = members.pop("t_s", None)
    count = len(utc or t_s) if isinstance(utc or t_s, list) else 0
    if count > OPTIONS.rows_max:
        raise _fault(
            f"samples.{times[0]}", f"has {count} tags; at most {OPTIONS.rows_max} are read"
        )
    columns = {name: _column(name, value) for name, value in members.items()}
    for name, column in columns.items():
        if len(column) != count:
            raise _fault(
                f"samples.{name}"[:80],
                f"must have a value for each of the {count} time tags, null where there is none; "
                f"it has {len(column)}",
            )
    return SentSamples(t_s=None if utc else _column("t_s", t_s), utc=tuple(utc), columns=columns)


def _column(name: str, value: object) -> Array:
    field = f"samples.{name}"[:80]
    if not isinstance(value, list):
        raise _fault(field, "must be a list of numbers, null where there is none")
    kinds = {*map(type, value)}
    if not kinds <= {int, float, type(None)}:
        number = next(k for k, one in enumerate(value) if type(one) not in (int, float, type(None)))
        raise _fault(f"{field}.{number}", "must be a number, or null where there is none")
    try:
        return np.array(value, dtype=np.float64)
    except OverflowError:
        raise _fault(field, "holds a whole number too large to be measured") from None


def _fault(field: str, detail: str) -> InvalidRequest:
    return InvalidRequest(FieldError(field=field, detail=detail))
