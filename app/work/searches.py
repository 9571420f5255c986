"""Searches for windows: the request, the windows found once, and their telling by page."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from app.answers.members import BUILT_ON_FIRST_USE, ProvenanceOut, to_json
from app.requests.json_reader import JsonReader
from app.store.job import Listing
from app.store.packed import PackedColumns, pack, unpack
from planner.base.answer_members import Count
from planner.base.assumed import Assumed
from planner.base.csv_cells import csv_lines
from planner.output.windows.forms import PASS_COLUMNS, features_json, pass_table_csv
from planner.output.windows.members import WindowOut, not_included
from planner.output.windows.rows import Column, rows_json, scan_column, window_columns
from planner.planning.opportunities import OpportunityRequest, WindowEdges
from planner.planning.opportunities.closing import Unseen
from planner.world.frames.time_scales import utc_text

if TYPE_CHECKING:
    from planner.planning.campaigns import CampaignRequest, FleetRequest
    from planner.planning.opportunities import WindowSearch

OPPORTUNITY_READER = JsonReader(OpportunityRequest)

read_opportunity_request = OPPORTUNITY_READER.read


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


JSON, GEOJSON, CSV = "application/json", "application/geo+json", "text/csv"
VIEW, PROBABILITY, REASONS = INCLUDED = ("view", "probability", "reasons")
_FORMS: dict[str, Callable[[Sequence[str]], str]] = {
    JSON: ",".join,
    GEOJSON: features_json,
    CSV: pass_table_csv,
}


@dataclass(frozen=True, kw_only=True)
class WindowsAsked:
    """Which windows, and what is told of them beyond edges and session.

    cursor: the first, by its number.  target: id of the only one.
    """

    media_type: str = JSON
    cursor: int = 0
    limit: int
    target: str | None = None
    include: frozenset[str] = frozenset()


class FoundSearch(NamedTuple):
    """What is kept. head: an `OpportunitiesHead`; edges: packed columns."""

    head: bytes
    edges: bytes


class Page(NamedTuple):
    """windows: in the form asked for, as they stand in a list.  next: the cursor after them.
    reasons: why targets are unseen, as JSON, where that was asked for."""

    windows: bytes
    next: int | None
    reasons: bytes | None


def listing_of_search(request: "CampaignRequest | FleetRequest | OpportunityRequest") -> Listing:
    return Listing(
        platform=request.platform_names,
        start_utc=request.start,
        stop_utc=request.stop,
        targets=tuple(one.id for one in request.targets),
    )


def find_windows(
    request: OpportunityRequest, provenance: ProvenanceOut, asked: WindowsAsked
) -> tuple[FoundSearch, Page]:
    """What is found is kept, the page is told of at once; raises a Refusal."""
    from planner.planning.opportunities import WindowSearch

    search = WindowSearch(request)
    edges = search.find()
    seen = {*edges.target.tolist()}
    head = OpportunitiesHead(
        name=request.name,
        start=utc_text(request.start),
        stop=utc_text(request.stop),
        count=len(edges),
        unseen=[one for row, one in enumerate(request.ids) if row not in seen],
        assumed=[*request.assumed],
        warnings=[*search.warnings],
        provenance=provenance,
    )
    return FoundSearch(to_json(head), _packed(edges)), _page(request, lambda: search, edges, asked)


def read_windows(body: bytes, edges: bytes, asked: WindowsAsked) -> Page:
    """A page of what was found; body: the search's request; raises a Refusal."""
    from planner.planning.opportunities import WindowSearch

    request = OPPORTUNITY_READER.read_kept(body)
    return _page(request, cache(lambda: WindowSearch(request)), _unpacked(edges), asked)


def opened(media_type: str, search_id: str, head: bytes, reasons: bytes | None) -> bytes:
    if media_type == CSV:
        return csv_lines([PASS_COLUMNS]).encode()
    told = [b'"id":' + to_json(search_id), head[1:-1]]
    told += [] if reasons is None else [b'"reasons":' + reasons]
    if media_type == GEOJSON:
        return b"{" + b",".join([b'"type":"FeatureCollection"', *told, b'"features":['])
    return b"{" + b",".join([*told, b'"windows":['])


def closed(media_type: str, after: int | None) -> bytes:
    return b"" if media_type == CSV else b'],"next":' + to_json(after) + b"}"


def search_json(search_id: str, head: bytes, page: Page) -> bytes:
    """What is known of a search, with a page of its windows."""
    return opened(JSON, search_id, head, page.reasons) + page.windows + closed(JSON, page.next)


def _page(
    request: OpportunityRequest,
    search: "Callable[[], WindowSearch]",
    edges: WindowEdges,
    asked: WindowsAsked,
) -> Page:
    rows = np.arange(len(edges))
    if asked.target is not None:
        rows = rows[np.array(request.ids)[edges.target] == asked.target]
    after = asked.cursor + asked.limit
    shown = edges.select(rows[asked.cursor : after])
    texts = rows_json(_columns(request, search, shown, asked.include)) if len(shown) else []
    reasons = None
    if REASONS in asked.include:
        from planner.planning.opportunities.unseen import unseen_of

        unseen = unseen_of(request, search().carrier, edges.target)
        reasons = b"[" + b",".join(map(to_json, unseen)) + b"]"
    told = _FORMS[asked.media_type](texts).encode()
    return Page(told, after if after < len(rows) else None, reasons)


def _columns(
    request: OpportunityRequest,
    search: "Callable[[], WindowSearch]",
    edges: WindowEdges,
    include: frozenset[str],
) -> Mapping[str, Column]:
    told = search().tell(edges) if include & {VIEW, PROBABILITY} else None
    shown = edges if told is None or VIEW not in include else told
    probability = None
    if told is not None and PROBABILITY in include:
        from planner.planning.sessions.window_probability import probabilities_in_frame

        probability = probabilities_in_frame(request, told)
    from planner.planning.opportunities.platforms.registry import lookout_of

    axes = lookout_of(request.platform, request.attitude)
    columns = window_columns(request.start, request.ids, axes, shown, probability)
    if request.modes:
        from planner.planning.opportunities.scan_windows import scanned_path

        paths = {
            row: (scanned_path(request, edges, row), request.roll_on_scans(int(edges.target[row])))
            for row in np.flatnonzero(edges.are_scans).tolist()
        }
        columns["scan"] = scan_column(request.start, edges, paths)
    return columns


def _packed(edges: WindowEdges) -> bytes:
    facts, columns = {}, {}
    for name, values in vars(edges).items():
        columns[name] = values
        if values.dtype.kind == "U":
            known, columns[name] = np.unique(values, return_inverse=True)
            facts[name] = known.tolist()
    return pack(PackedColumns(columns=columns, facts=facts))


def _unpacked(packed: bytes) -> WindowEdges:
    stored = unpack(packed)
    columns: dict[str, Any] = dict(stored.columns)
    for name, known in stored.facts.items():
        columns[name] = np.array(known, dtype=np.str_)[columns[name].astype(np.intp)]
    columns["target"] = columns["target"].astype(np.intp)
    return WindowEdges(**columns)
