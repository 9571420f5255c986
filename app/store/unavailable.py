"""Refusals of the database, for any request; known to children, who have none."""

from typing import ClassVar

from planner.base.errors import Blame, Refusal


class StoreUnavailable(Refusal):
    """The database can't be read or written as it is now; what for is the same later."""

    slug: ClassVar[str] = "store-unavailable"
    title: ClassVar[str] = "The database can't be used now"
    blame: ClassVar[Blame] = "busy"


class StoreDamaged(StoreUnavailable):
    """What the database holds can't be read, now or later."""

    slug: ClassVar[str] = "store-damaged"
    title: ClassVar[str] = "The database is damaged"

    def __init__(self, detail: str = "the database is damaged; restore it from a backup") -> None:
        super().__init__(detail)
