"""Classes of the domain are told in answers by one rule: units, names, ranges, what isn't told."""

import math
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Annotated

import numpy as np
import pytest
from pydantic import TypeAdapter

from app.answers.members import to_json
from planner.base.answer_members import (
    Arcsec,
    Count,
    HalfTurn,
    Internal,
    Km,
    Member,
    Signed,
    Text,
    answer,
    member_names,
)
from planner.base.arrays import Array, Mask
from planner.inflight.telemetry.estimates import Estimate
from planner.world.frames.time_scales import RowUtc, Utc


@answer
class Sight:
    turn_rad: HalfTurn | None
    errors_rad: tuple[Arcsec, ...]
    range_min_m: Km
    at_utc: Utc
    row_at_utc: RowUtc
    number: Count = 0
    part: Annotated[float, Member(decimals=2)] = -1e-9
    t_s: Internal[float] = 0.0
    azimuth_rad: Annotated[Array, Member("deg", 0.0, 360.0, decimals=6, gaps=True)]
    edges_rad: Annotated[Array, Member("deg", decimals=3, axes=2)]
    whole_rad: Annotated[Array, Member("deg")]
    holds: Annotated[Mask, Member()]

    @property
    def away_rad(self) -> HalfTurn:
        return 0.5

    @property
    def unit(self) -> Text:
        return "deg"

    @property
    def not_told(self) -> float:
        return 1.0


@answer
class Beginning:
    start_m: Internal[float]

    @property
    def begin_m(self) -> Km:
        return self.start_m


@answer
class Measured(Beginning):
    bias_rad: Annotated[Estimate, Member("arcsec", decimals=3)] | None


@dataclass
class Answer:
    sights: dict[str, list[Sight]]
    level: Signed


SIGHT = Sight(
    turn_rad=1.0,
    errors_rad=(math.radians(1.0), 0.0),
    range_min_m=1234.5,
    at_utc=datetime(2016, 12, 31, 23, 59, 59, 500_000, UTC, fold=1),
    row_at_utc=datetime(2015, 2, 27, 17, 36, 10, 200_000, UTC),
    azimuth_rad=np.array([math.nan, 2.0 * math.pi - 1e-12, -0.0]),
    edges_rad=np.array([[math.pi, -1e-9]]),
    whole_rad=np.array([0.25 * math.pi]),
    holds=np.array([True, False]),
)


def test_a_value_is_told_by_the_types_of_its_fields():
    assert to_json(Answer({"a": [SIGHT]}, -1.0)).decode() == (
        '{"sights":{"a":[{"turn_deg":57.295779513,"errors_arcsec":[3600.0,0.0],'
        '"range_min_km":1.2345,"at":"2016-12-31T23:59:60.500Z",'
        '"row_at":"2015-02-27T17:36:10.2Z","number":0,"part":0.0,"azimuth_deg":[null,0.0,0.0],'
        '"edges_deg":[[180.0,0.0]],"whole_deg":[45.0],"holds":[true,false],"away_deg":28.647889757,'
        '"unit":"deg"}]},"level":-1.0}'
    )


def test_a_number_is_told_with_its_error_in_the_unit_of_its_member():
    """After the members of its base, properties among them."""
    bias_rad = Estimate(value=-math.radians(1.0 / 3600.0), sigma=math.radians(0.5 / 3600.0))
    assert to_json(Measured(start_m=2e3, bias_rad=bias_rad)).decode() == (
        '{"begin_km":2.0,"bias_arcsec":{"value":-1.0,"sigma":0.5}}'
    )


@pytest.mark.parametrize("mode", ["validation", "serialization"])  # FastAPI asks for either
def test_the_schema_is_of_what_is_told(mode):
    schema = TypeAdapter(Answer).json_schema(mode=mode)
    sight = schema["$defs"]["Sight"]
    told_as = sight["properties"]
    either = {"type": "number", "x-range": "any, of either sign"}
    size = {"type": "number", "minimum": 0.0}
    half_turn = size | {"maximum": 180.0}
    null = {"type": "null"}
    azimuth = {"anyOf": [size | {"maximum": 360.0}, null]}
    assert [*told_as] == sight["required"] == [*member_names(Sight).values()]
    assert {
        name: {k: v for k, v in one.items() if k != "title"} for name, one in told_as.items()
    } == {
        "turn_deg": {"anyOf": [half_turn, null]},
        "errors_arcsec": {"type": "array", "items": size},
        "range_min_km": size,
        "at": {"type": "string"},
        "row_at": {"type": "string"},
        "number": {"type": "integer", "minimum": 0},
        "part": either,
        "azimuth_deg": {"type": "array", "items": azimuth},
        "edges_deg": {"type": "array", "items": {"type": "array", "items": either}},
        "whole_deg": {"type": "array", "items": either},
        "holds": {"type": "array", "items": {"type": "boolean"}},
        "away_deg": half_turn,
        "unit": {"type": "string"},
    }
    assert schema["properties"]["level"] == either | {"title": "Level"}
