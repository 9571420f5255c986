"""A plan as the child that made it hands it back; loads no database."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class NewPlan:
    """A plan as it is stored.

    state: `failed` where the judge rejects the table.  document: the answer's JSON without the
    table and without what only the service knows, zlib.  table_columns: `app.store.packed`.
    iterations: of the solver over all slews, where they are counted.
    """

    name: str
    state: Literal["done", "failed"]
    input_sha256: str
    versions: dict[str, str]
    document: bytes
    table_columns: bytes
    planned_utc: datetime
    iterations: int | None = None
