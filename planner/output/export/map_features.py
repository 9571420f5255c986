"""Map features, whatever format they are written in and whatever kind of plan they are of."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

import numpy as np

from planner.base.arrays import Array, Indices
from planner.output.export.map_shapes import Shape, line
from planner.world.frames.geodesy import geodetic_from_itrf

FeatureKind = Literal["track", "boresight", "swath", "footprint", "target"]
Facts = Mapping[str, str | int | float | None]
LINE_PLACES_MAX = 600  # a pass's orbit then bends by metres between them


@dataclass(frozen=True, kw_only=True, eq=False)
class MapFeature:
    """One thing on the map, from start to stop where it has a time.

    facts: more of it, in plain JSON.
    """

    kind: FeatureKind
    name: str
    shape: Shape
    start_utc: datetime | None = None
    stop_utc: datetime | None = None
    facts: Facts = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanMap:
    """name: of the plan.  notes: what a reader of the file must know, a line each."""

    name: str
    notes: tuple[str, ...]
    features: tuple[MapFeature, ...]


def thinned(count: int, most: int = LINE_PLACES_MAX) -> Indices:
    """At most so many of `count` rows, evenly, the first and last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.intp))


def path_feature(
    kind: FeatureKind,
    name: str,
    r_itrf_m: Array,
    span_utc: tuple[datetime, datetime],
    facts: Facts | None = None,
) -> MapFeature:
    """A line through the places below or at points (n, 3)."""
    latitude_rad, longitude_rad, _ = geodetic_from_itrf(r_itrf_m[thinned(len(r_itrf_m))])
    return MapFeature(
        kind=kind,
        name=name,
        shape=line(latitude_rad, longitude_rad),
        start_utc=span_utc[0],
        stop_utc=span_utc[1],
        facts=facts or {},
    )
