"""Searches for windows: found once by one carrier with all its targets, and told of by page."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from app.answers.imaging_opportunities import imaging_columns
from app.answers.members import ProvenanceOut, to_json
from app.answers.opportunities import Column, OpportunitiesHead, rows_json, window_columns
from app.answers.opportunities_geojson import feature
from app.answers.target_sky import PASS_COLUMNS, pass_cells
from app.requests.json_reader import JsonReader
from app.requests.opportunities import OPPORTUNITY_READER
from app.requests.spacecraft import IMAGING_OPPORTUNITY_READER
from app.store.packed import PackedColumns, pack, unpack
from planner.base.csv_cells import csv_lines
from planner.planning.opportunities import WindowEdges
from planner.world.frames.time_scales import utc_text

if TYPE_CHECKING:
    from planner.planning.opportunities import OpportunityRequest, WindowSearch
    from planner.spacecraft.opportunities import ImagingSearch, PassEdges
    from planner.spacecraft.opportunity_request import ImagingOpportunityRequest

JSON, GEOJSON, CSV = "application/json", "application/geo+json", "text/csv"
VIEW, PROBABILITY, REASONS = INCLUDED = ("view", "probability", "reasons")
PAGE_WINDOWS = 100  # unless asked for otherwise


@dataclass(frozen=True, kw_only=True)
class WindowsAsked:
    """Which windows, and what is told of them beyond edges and session.

    cursor: the first, by its number.  target: id of the only one.
    """

    media_type: str = JSON
    cursor: int = 0
    limit: int = PAGE_WINDOWS
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


def find_windows(
    kind: str,
    request: Any,  # noqa: ANN401 (of its kind)
    provenance: ProvenanceOut,
    asked: WindowsAsked,
) -> tuple[FoundSearch, Page]:
    """What is found is kept, the page is told of at once; raises a Refusal."""
    how = _KINDS[kind]
    search = how.begin(request)
    edges = search.find()
    ids, seen = how.ids(request), {*edges.target.tolist()}
    head = OpportunitiesHead(
        name=request.name,
        start=utc_text(request.start),
        stop=utc_text(request.stop),
        count=len(edges),
        unseen=[one for row, one in enumerate(ids) if row not in seen],
        assumed=[*how.assumed(request)],
        warnings=[*search.warnings],
        provenance=provenance,
    )
    page = _page(how, request, lambda: search, edges, asked)
    return FoundSearch(to_json(head), _packed(edges)), page


def read_windows(kind: str, body: bytes, edges: bytes, asked: WindowsAsked) -> Page:
    """A page of what was found; body: the search's request; raises a Refusal."""
    how = _KINDS[kind]
    request = how.reader.read_kept(body)
    return _page(how, request, lambda: how.begin(request), how.unpacked(edges), asked)


def opened(media_type: str, members: Sequence[bytes], reasons: bytes | None) -> bytes:
    """What comes before the windows; members: of the answer, as JSON without braces."""
    if media_type == CSV:
        return csv_lines([PASS_COLUMNS]).encode()
    told = [*members, *([] if reasons is None else [b'"reasons":' + reasons])]
    if media_type == GEOJSON:
        return b"{" + b",".join([b'"type":"FeatureCollection"', *told, b'"features":['])
    return b"{" + b",".join([*told, b'"windows":['])


def closed(media_type: str, after: int | None) -> bytes:
    """What comes after the windows."""
    return b"" if media_type == CSV else b'],"next":' + to_json(after) + b"}"


def search_json(search_id: str, found: FoundSearch, page: Page) -> bytes:
    """As JSON: what is known of the search, with its first windows."""
    begin = opened(JSON, members_of(search_id, found.head), page.reasons)
    return begin + page.windows + closed(JSON, page.next)


def members_of(search_id: str, head: bytes) -> list[bytes]:
    """Of the whole answer, beside its windows."""
    return [b'"id":' + to_json(search_id), head[1:-1]]


def page_json(page: Page) -> bytes:
    """Of windows alone."""
    return opened(JSON, [], page.reasons) + page.windows + closed(JSON, page.next)


class _Kind(NamedTuple):
    """columns: of (request, search, edges, included) by the names of an answer's window.
    because: why targets without windows have none."""

    reader: JsonReader[Any]
    begin: Callable[[Any], Any]
    ids: Callable[[Any], Sequence[str]]
    assumed: Callable[[Any], Sequence[Any]]
    unpacked: Callable[[bytes], WindowEdges]
    columns: Callable[[Any, Callable[[], Any], Any, frozenset[str]], Mapping[str, Column]]


def _page(
    how: _Kind,
    request: Any,  # noqa: ANN401 (of its kind)
    search: Callable[[], Any],
    edges: WindowEdges,
    asked: WindowsAsked,
) -> Page:
    rows = np.arange(len(edges))
    if asked.target is not None:
        ids = [*how.ids(request)]
        rows = rows[edges.target == (ids.index(asked.target) if asked.target in ids else -1)]
    after = asked.cursor + asked.limit
    shown = edges.select(rows[asked.cursor : after])
    texts = rows_json(how.columns(request, search, shown, asked.include)) if len(shown) else []
    reasons = None
    if REASONS in asked.include:
        from planner.planning.opportunities.unseen import unseen_of

        unseen = unseen_of(request, search().carrier, edges.target)
        reasons = b"[" + b",".join(map(to_json, unseen)) + b"]"
    told = _FORMS[asked.media_type](texts).encode()
    return Page(told, after if after < len(rows) else None, reasons)


def pass_table_csv(texts: Sequence[str]) -> str:
    """A line per window, of the JSON of each with its view."""
    return csv_lines(pass_cells(json.loads(text)) for text in texts)


def _geojson(texts: Sequence[str]) -> str:
    features = (feature(json.loads(text)) for text in texts)
    return ",".join(json.dumps(one, separators=(",", ":"), ensure_ascii=False) for one in features)


_FORMS: dict[str, Callable[[Sequence[str]], str]] = {
    JSON: ",".join,
    GEOJSON: _geojson,
    CSV: pass_table_csv,
}


def _packed(edges: WindowEdges) -> bytes:
    facts, columns = {}, {}
    for name, values in vars(edges).items():
        columns[name] = values
        if values.dtype.kind == "U":
            known, columns[name] = np.unique(values, return_inverse=True)
            facts[name] = known.tolist()
    return pack(PackedColumns(columns=columns, facts=facts))


def _edges(kind: type[WindowEdges], packed: bytes) -> WindowEdges:
    stored = unpack(packed)
    columns: dict[str, Any] = dict(stored.columns)
    for name, known in stored.facts.items():
        columns[name] = np.array(known, dtype=np.str_)[columns[name].astype(np.intp)]
    return kind(**columns | {"target": columns["target"].astype(np.intp)})


def _begin(request: "OpportunityRequest") -> "WindowSearch":
    from planner.planning.opportunities import WindowSearch

    return WindowSearch(request)


def _columns(
    request: "OpportunityRequest",
    search: "Callable[[], WindowSearch]",
    edges: WindowEdges,
    include: frozenset[str],
) -> Mapping[str, Column]:
    told = search().tell(edges) if include & {VIEW, PROBABILITY} else None
    probability = None
    if told is not None and PROBABILITY in include:
        from planner.planning.sessions.window_probability import probabilities_in_frame

        probability = probabilities_in_frame(request, told)
    shown = edges if told is None or VIEW not in include else told
    ids, axis_names = [one.id for one in request.targets], request.platform.axis_names
    return window_columns(request.start, ids, axis_names, shown, probability)


def _begin_imaging(request: "ImagingOpportunityRequest") -> "ImagingSearch":
    from planner.spacecraft.opportunities import ImagingSearch

    return ImagingSearch(request)


def _imaging_columns(
    request: "ImagingOpportunityRequest",
    search: "Callable[[], ImagingSearch]",
    edges: "PassEdges",
    include: frozenset[str],
) -> Mapping[str, Column]:
    return imaging_columns(request, edges, search().tell(edges) if VIEW in include else edges)


def _imaging_edges(packed: bytes) -> WindowEdges:
    from planner.spacecraft.opportunities import PassEdges

    return _edges(PassEdges, packed)


_KINDS = {
    "opportunities": _Kind(
        reader=OPPORTUNITY_READER,
        begin=_begin,
        ids=lambda request: [one.id for one in request.targets],
        assumed=lambda request: request.assumed,
        unpacked=lambda packed: _edges(WindowEdges, packed),
        columns=_columns,
    ),
    "imaging_opportunities": _Kind(
        reader=IMAGING_OPPORTUNITY_READER,
        begin=_begin_imaging,
        ids=lambda request: [one.name for one in request.requests],
        assumed=lambda _: (),
        unpacked=_imaging_edges,
        columns=_imaging_columns,
    ),
}
