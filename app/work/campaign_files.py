"""A campaign's looks as CSV, GeoJSON and KML, and the plans of its passes as one archive."""

import io
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from app.requests.plan import read_plan_request
from app.work.plan import stored_table_file
from planner.base.answer_members import member_names
from planner.base.csv_cells import csv_lines
from planner.output.export.geojson import geojson_of
from planner.output.export.kml import kml_of
from planner.output.export.map_features import MapFeature, PlanMap
from planner.output.export.plan_map import target_features
from planner.planning.campaigns.chosen import ChosenLook
from planner.world.frames.time_scales import utc_from_text

CSV = "text/csv"
_ARCHIVE = "application/zip"
_MAPS = {"application/geo+json": geojson_of, "application/vnd.google-earth.kml+xml": kml_of}
SUFFIXES = dict(zip((CSV, *_MAPS, _ARCHIVE), (".csv", ".geojson", ".kml", ".zip"), strict=True))


@dataclass(frozen=True)
class MadePass:
    """A pass whose plan is made.

    facts: what its campaign says of it.
    """

    facts: Mapping[str, Any]
    plan: str
    request: bytes
    table_columns: bytes
    planned_utc: datetime

    @property
    def number(self) -> int:
        """From 1."""
        return int(self.facts["pass"]) + 1

    @property
    def looks(self) -> Sequence[Mapping[str, Any]]:
        """Those that are planned."""
        looks: Sequence[Mapping[str, Any]] = self.facts["looks"]
        return looks


def campaign_file(media_type: str, body: bytes, passes: Sequence[MadePass]) -> bytes:
    """In one of `SUFFIXES`; body: the campaign's request."""
    from app.requests.campaign import read_campaign_request

    if media_type == CSV:
        return _looks_csv(passes)
    if media_type == _ARCHIVE:
        return _archive(passes)
    request = read_campaign_request(body)
    notes = ("looks at targets in the sky have no place on a map",)
    features = tuple(_map_features(passes))
    return _MAPS[media_type](PlanMap(name=request.name, notes=notes, features=features))


def _looks_csv(passes: Sequence[MadePass]) -> bytes:
    return looks_csv((one.number, look) for one in passes for look in one.looks).encode()


def looks_csv(looks: Iterable[tuple[int, Mapping[str, Any]]]) -> str:
    """One line per look, with the number of its pass."""
    names = [*member_names(ChosenLook).values()]
    rows = ([number, *(look[name] for name in names)] for number, look in looks)
    return csv_lines([["pass", *names], *rows])


def _map_features(passes: Sequence[MadePass]) -> Iterator[MapFeature]:
    for one in passes:
        sessions = read_plan_request(one.request).sessions
        for look, session in zip(one.looks, sessions, strict=False):  # then a rest
            members = dict(look)
            label, *times = (members.pop(name) for name in ("target", "start", "stop"))
            start_utc, stop_utc = map(utc_from_text, times)
            facts = {"pass": one.number, "plan": one.plan, **members}
            yield from target_features(session.target, (start_utc, stop_utc), label, facts)


def _archive(passes: Sequence[MadePass]) -> bytes:
    """Of each pass its command table and its request, and the table of looks."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:

        def add(name: str, made_utc: datetime, file: bytes) -> None:
            entry = zipfile.ZipInfo(name, made_utc.timetuple()[:6])
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, file)

        for one in passes:
            table = stored_table_file(one.request, one.table_columns, "csv", one.planned_utc)
            add(f"pass-{one.number}.csv", one.planned_utc, table)
            add(f"pass-{one.number}-request.json", one.planned_utc, one.request)
        add("looks.csv", max(one.planned_utc for one in passes), _looks_csv(passes))
    return content.getvalue()
