"""The opportunities that were found, stored once and never changed."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, insert, select

from app.store.models import SearchRow

_LEVEL = 3


@dataclass(frozen=True, kw_only=True)
class StoredSearch:
    """What was found, packed.

    head: the answer's JSON without its id and its windows, zlib.  windows: JSON, one a line, zlib.
    """

    head: bytes
    windows: bytes

    def unpacked(self) -> tuple[bytes, list[bytes]]:
        """The head, and the windows one by one."""
        return zlib.decompress(self.head), zlib.decompress(self.windows).splitlines()


def packed(head: bytes, windows: Sequence[bytes]) -> StoredSearch:
    """As it is stored."""
    return StoredSearch(
        head=zlib.compress(head), windows=zlib.compress(b"\n".join(windows), _LEVEL)
    )


def store(connection: Connection, job_id: str, search: StoredSearch) -> None:
    """Of a job that is done."""
    values = {"id": job_id, "head": search.head, "windows": search.windows}
    connection.execute(insert(SearchRow).values(values))


def get(connection: Connection, job_id: str) -> StoredSearch | None:
    """By its id."""
    query = select(SearchRow.head, SearchRow.windows).where(SearchRow.id == job_id)
    row = connection.execute(query).one_or_none()
    return None if row is None else StoredSearch(**row._mapping)
