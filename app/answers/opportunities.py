"""The answer to a search for windows, in JSON or as GeoJSON (RFC 7946), a Feature each."""

from dataclasses import dataclass, field
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut
from planner.base.answer_members import Count
from planner.base.assumed import Assumed
from planner.output.windows.members import WindowOut, not_included
from planner.planning.opportunities.closing import Unseen


@dataclass(frozen=True, kw_only=True)
class OpportunitiesHead:
    """What is known of a search beside its windows.

    name: as the request gives it. E.g. `"cities in daylight"`.
    start: of the time searched; UTC.
    stop: of the time searched; UTC.
    count: of all windows found. E.g. `8590`.
    unseen: ids of targets without any window. E.g. `["Reykjavik"]`.
    assumed: places of the targets that the request gives by name only.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    """

    __pydantic_config__ = BUILT_ON_FIRST_USE

    name: str
    start: str
    stop: str
    count: Count
    unseen: list[str]
    assumed: list[Assumed]
    warnings: list[str]
    provenance: ProvenanceOut


@dataclass(frozen=True, kw_only=True)
class OpportunitiesResponse(OpportunitiesHead):
    """Windows in the order of the request's targets, each target's in order of time.

    id: of what was found, as its address names it.
    reasons: the causes that leave targets unseen; with `reasons`.
    windows: the first of them.
    next: `cursor` of those that come after; null at the end. E.g. `100`.
    """

    id: str
    reasons: list[Unseen] = field(default_factory=not_included)
    windows: list[WindowOut]
    next: Count | None


class FeatureCollection(BaseModel):
    """GeoJSON: a Feature a window, a point or the request's own geometry, null in space.

    features: `properties` hold `target`, `datetime` (rise and set with a slash between, as STAC
    and STAPI have it), rise, set, session, the view at the closest approach, azimuths, local solar
    time and the Sun.
    """

    model_config = ConfigDict(extra="allow")

    type: str = Field(json_schema_extra={"const": "FeatureCollection"})
    features: list[dict[str, Any]]
