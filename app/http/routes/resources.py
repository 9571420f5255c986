"""The resources that jobs make, and the differences between those that hold plans."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from app.answers.job import list_class
from app.answers.members import ProvenanceOut
from app.http.routes.parameters import ListQuery
from app.requests.examples import Examples
from app.requests.json_reader import JsonReader
from app.store.database import Database
from app.store.job import Listing

PLAN_LIST = list_class("PlanList", "plans", "Plans")


@dataclass(frozen=True, kw_only=True)
class JobResource:
    """What is at `path` and kept as jobs of one kind, by its name.

    singular, plural: what they are called.  requests: reads those for one.
    listing: what lists tell of a request, as it was read.  response: of one; list_response: of
    several.  list_query: which of them to list, about_list: in what order.
    also: kinds of jobs that are found here by their id, too.
    """

    kind: str
    also: frozenset[str] = frozenset()
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
    as the answer holds it.  document: the name of what a stored plan holds of the answer beside it.
    file_stem: of files whose plan has no name.
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
    table_json: Callable[[bytes], bytes]
    document: str = "document"
    file_stem: str
    lacks: Callable[[bytes], bool] = lambda _: False
    fill_in: Callable[[Database, bytes], bytes] = lambda _, body: body
