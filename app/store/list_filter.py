"""The filter of a list of jobs, as SQL conditions."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy import ColumnElement

from app.ids import JobState
from app.store.listing import folded
from app.store.models import JobRow


@dataclass(frozen=True, kw_only=True)
class ListFilter:
    """None: whatever.

    name: in the job's.  target: in a target's.  text: in the name, the platform's or a target's.
    Upper and lower case are alike in target and text.
    begins_before_utc, ends_after_utc: of what is looked at.
    """

    state: JobState | None = None
    name: str | None = None
    target: str | None = None
    text: str | None = None
    begins_before_utc: datetime | None = None
    ends_after_utc: datetime | None = None

    def conditions(self) -> Iterator[ColumnElement[bool]]:
        """All of which it meets."""
        if self.state is not None:
            yield JobRow.state == self.state
        if self.name is not None:
            yield JobRow.name.contains(self.name, autoescape=True)
        if self.target is not None:
            yield JobRow.target_words.contains(folded(self.target), autoescape=True)
        if self.text is not None:
            yield JobRow.words.contains(folded(self.text), autoescape=True)
        if self.begins_before_utc is not None:
            yield JobRow.start_utc < self.begins_before_utc
        if self.ends_after_utc is not None:
            yield JobRow.stop_utc > self.ends_after_utc


EVERY_ROW = ListFilter()
