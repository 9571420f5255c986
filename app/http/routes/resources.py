"""The resources that jobs make, and the differences between those that hold plans."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from app.answers.job import list_class
from app.answers.members import ProvenanceOut
from app.http.negotiation import JSON
from app.http.routes.parameters import ListQuery
from app.requests.examples import Examples
from app.requests.json_reader import JsonReader
from app.store.database import Database
from app.store.job import Listing
from app.work.view import AskedView
from planner.output.export.exporter import Exporter

PLAN_LIST = list_class("PlanList", "plans", "Plans")


@dataclass(frozen=True, kw_only=True)
class JobResource:
    """What is at `path` and kept as jobs of one kind, by its name.

    singular, plural: what they are called.  requests: reads those for one.
    listing: what lists tell of a request, as it was read.  response: of one; list_response: of
    several.  list_query: which of them to list, about_list: in what order.
    """

    kind: str
    path: str
    tag: str
    requests: JsonReader[Any]
    examples: Examples
    listing: Callable[[Any], Listing]
    singular: str
    plural: str
    response: type
    list_response: type
    list_query: type[ListQuery] = ListQuery
    about_list: str = "The latest come first."


@dataclass(frozen=True, kw_only=True)
class PlanResource(JobResource):
    """One that holds plans.

    dry_run: the answer that says whether it flies; done in a child.  table_json: a stored table
    as the answer holds it.  table_file: of (request, stored table, format, date the file states)
    the file's bytes; done in a child.  view_response: what there is to see of a plan, as JSON.
    view_exporters: its other formats.  view_file: of (request, stored table, what is asked) the
    view's bytes, in a child.  file_stem: of files whose plan has no name.
    takes_pixel: its views are told what a pixel sees, as no camera is defined.
    lacks: whether a request, in bytes, may lack what only the store can tell; fill_in: with that.
    """

    singular: str = "plan"
    plural: str = "plans"
    list_response: type = PLAN_LIST
    about_list: str = (
        "The latest come first; plans that wait or run, were refused or cancelled are included."
    )
    what: str
    about: str
    dry_run: Callable[[Any, ProvenanceOut], bytes]
    dry_run_response: type
    exporters: Mapping[str, Exporter[Any]]
    table_json: Callable[[bytes], bytes]
    table_file: Callable[[bytes, bytes, str, datetime], bytes]
    view_response: type
    view_exporters: Mapping[str, Exporter[Any]]
    view_file: Callable[[bytes, bytes, AskedView], bytes]
    file_stem: str
    takes_pixel: bool = False
    lacks: Callable[[bytes], bool] = lambda _: False
    fill_in: Callable[[Database, bytes], bytes] = lambda _, body: body

    @property
    def format_by_media_type(self) -> dict[str, str]:
        """Formats an Accept header can ask for beside JSON."""
        return {
            exporter.media_type: name
            for name, exporter in self.exporters.items()
            if exporter.media_type != JSON
        }
