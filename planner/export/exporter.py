"""An export format: its title, media type, suffix and writer."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from typing import Generic, TypeVar

P = TypeVar("P")


@dataclass(frozen=True, kw_only=True)
class Exporter(Generic[P]):
    """One format of one kind of plan.

    title: what the file holds.  write(plan, created_utc): the file's bytes; created_utc is
    the date the file states.  Raises OutsideCoverage when orbit or attitude is unknown while
    a target is tracked.
    """

    title: str
    media_type: str
    suffix: str
    write: Callable[[P, datetime], bytes]
