"""The resources that jobs make, and what differs between those that hold plans."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from app.answers.members import ProvenanceOut
from app.http.negotiation import JSON
from app.jobs.kinds import JobKind
from app.store.database import Database
from planner.export.exporter import Exporter


@dataclass(frozen=True, kw_only=True)
class JobResource:
    """What is at `path` and made by jobs of one kind; singular: what one of them is called."""

    kind: JobKind
    path: str
    singular: str = "plan"


@dataclass(frozen=True, kw_only=True)
class PlanResource(JobResource):
    """One that holds plans.

    read: the request, which has a `name`, or InvalidRequest.  dry_run: what to say of it when
    nothing is planned.  table_json: a stored table as the answer holds it.
    table_file: of (request, stored table, format, date the file states) the file's bytes; done
    in a child.  file_stem: of files whose plan has no name.  in_campaigns: campaigns make some.
    fill_in: a request with what only the store can tell.
    """

    tag: str
    what: str
    about: str
    request_schema: str
    examples: dict[str, tuple[str, dict[str, Any]]]
    response: type
    read: Callable[[bytes], Any]
    dry_run: Callable[[Any, ProvenanceOut], object]
    dry_run_response: type
    exporters: Mapping[str, Exporter[Any]]
    table_json: Callable[[bytes], bytes]
    table_file: Callable[[bytes, bytes, str, datetime], bytes]
    file_stem: str
    in_campaigns: bool = False
    fill_in: Callable[[Database, bytes], bytes] = lambda _, body: body

    @property
    def format_by_media_type(self) -> dict[str, str]:
        """Formats an Accept header can ask for beside JSON."""
        return {
            exporter.media_type: name
            for name, exporter in self.exporters.items()
            if exporter.media_type != JSON
        }
