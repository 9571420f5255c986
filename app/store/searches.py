"""The windows that searches found, stored once and never changed."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import Connection, insert, select

from app.store.models import SearchPageRow, SearchRow
from app.store.packed import unzip

PAGE_WINDOWS = 500  # a megabyte, unpacked in 10 ms: whoever reads a page needs no more
_LEVEL = 3  # of 78 MB of windows 22.6 MB in 1.4 s; 6 makes 20.1 in 4.6 s


@dataclass(frozen=True, kw_only=True)
class PackedSearch:
    """What was found, as it is stored: see `SearchRow`."""

    head: bytes
    window_count: int
    pages: tuple[bytes, ...]


@dataclass(frozen=True, kw_only=True)
class StoredWindows:
    """head: the answer's JSON without its id and its windows.  windows: JSON, some of them."""

    head: bytes
    window_count: int
    windows: list[bytes]


def packed(head: bytes, windows: Sequence[bytes]) -> PackedSearch:
    """As it is stored."""
    return PackedSearch(
        head=zlib.compress(head),
        window_count=len(windows),
        pages=tuple(
            zlib.compress(b"\n".join(windows[first : first + PAGE_WINDOWS]), _LEVEL)
            for first in range(0, len(windows), PAGE_WINDOWS)
        ),
    )


def store(connection: Connection, job_id: str, search: PackedSearch) -> None:
    """Of a job that is done."""
    values = {"id": job_id, "head": search.head, "window_count": search.window_count}
    connection.execute(insert(SearchRow).values(values))
    if search.pages:
        pages = [
            {"search_id": job_id, "number": number, "windows": windows}
            for number, windows in enumerate(search.pages)
        ]
        connection.execute(insert(SearchPageRow), pages)


def get(
    connection: Connection, job_id: str, first: int = 0, stop: int | None = None
) -> StoredWindows | None:
    """By its id: the windows from the number `first` to before `stop`, all unless said."""
    found = connection.execute(
        select(SearchRow.head, SearchRow.window_count).where(SearchRow.id == job_id)
    ).one_or_none()
    if found is None:
        return None
    head, count = found
    stop = count if stop is None else min(stop, count)
    page = first // PAGE_WINDOWS
    pages = connection.scalars(
        select(SearchPageRow.windows)
        .where(
            SearchPageRow.search_id == job_id,
            SearchPageRow.number >= page,
            SearchPageRow.number * PAGE_WINDOWS < stop,
        )
        .order_by(SearchPageRow.number)
    )
    windows = [window for packed in pages for window in unzip(packed).split(b"\n")]
    before = page * PAGE_WINDOWS
    return StoredWindows(
        head=unzip(head),
        window_count=count,
        windows=windows[first - before : max(stop - before, 0)],
    )
