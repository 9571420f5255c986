"""The result of work of any kind, as the child that did it hands it back."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from app.store.job import Listing


@dataclass(frozen=True, kw_only=True)
class Part:
    """A job of its own that a result waits for.

    name, listing: what lists tell of it.  facts: of a campaign's pass its number, times, looks,
    and what was left out.
    """

    request: bytes
    name: str = ""
    listing: Listing = field(default_factory=Listing)
    facts: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Result:
    """What a job's work makes.

    content: stored as it is: the document, which is JSON, zlib, or of some runs of flights packed
    columns; a plan's table, packed; and the document in the words of an imaging session.
    state: `failed` where the judge rejects a plan's table.
    listing: what lists tell from now on; None for what they tell already.
    iterations: of the solver over all slews, where they are counted.
    """

    content: tuple[bytes, ...]
    state: Literal["done", "failed"] = "done"
    listing: Listing | None = None
    parts: tuple[Part, ...] = ()
    iterations: int | None = None

    @property
    def document(self) -> bytes:
        """The answer's JSON without the table and without what only the service knows, zlib."""
        return self.content[0]

    @property
    def table_columns(self) -> bytes:
        """Of a plan."""
        return self.content[1]
