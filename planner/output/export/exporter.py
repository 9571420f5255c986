"""An export format."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Generic, TypeVar

P = TypeVar("P")


@dataclass(frozen=True)
class Exporter(Generic[P]):
    """One format of one kind of plan.

    title: what the file holds.  write(plan, created_utc): the file's bytes; created_utc is
    the date the file states.  Raises OutsideCoverage when orbit or attitude is unknown while
    a target is tracked.  shows: whether it draws the plan on a map, a globe or a plot, so that it
    is also offered where a plan is looked at.
    """

    title: str
    media_type: str
    suffix: str
    write: Callable[[P, datetime], bytes]
    shows: bool = False
