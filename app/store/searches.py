"""The windows that searches found, stored in pages: who reads one needs no more."""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

from sqlalchemy import Connection

from app.store import results
from app.store.packed import unzip

PAGE_WINDOWS = 500  # a megabyte, unpacked in 10 ms
_LEVEL = 3  # of 78 MB of windows 22.6 MB in 1.4 s; 6 makes 20.1 in 4.6 s


@dataclass(frozen=True, kw_only=True)
class StoredWindows:
    """head: the answer's JSON without its id and its windows.  windows: JSON, some of them."""

    head: bytes
    window_count: int
    windows: list[bytes]


def packed(head: bytes, windows: Sequence[bytes]) -> list[bytes]:
    """As it is stored: the windows' number and the head, then the pages, one window a line."""
    pages = [
        zlib.compress(b"\n".join(windows[first : first + PAGE_WINDOWS]), _LEVEL)
        for first in range(0, len(windows), PAGE_WINDOWS)
    ]
    return [zlib.compress(b"%d\n" % len(windows) + head), *pages]


def get(
    connection: Connection, job_id: str, first: int = 0, stop: int | None = None
) -> StoredWindows | None:
    """By its id: the windows from the number `first` to before `stop`, all unless said."""
    found = results.document(connection, job_id)
    if found is None:
        return None
    count, _, head = unzip(found).partition(b"\n")
    stop = int(count) if stop is None else min(stop, int(count))
    page = first // PAGE_WINDOWS
    pages = results.get(connection, job_id, 1 + page, 1 - (-stop // PAGE_WINDOWS))
    windows = [window for packed in pages for window in unzip(packed).split(b"\n")]
    before = page * PAGE_WINDOWS
    return StoredWindows(
        head=head,
        window_count=int(count),
        windows=windows[first - before : max(stop - before, 0)],
    )
