"""The lock of writers to SQLite: one at a time; all are refused when nothing moves."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from app.store.unavailable import StoreUnavailable

# Long enough for what another process may write at once, short enough to be told in two seconds.
PATIENCE_S = 1.2
# Time in which what kept somebody waiting in vain isn't tried again.
_REST_S = 0.5


class Outage:
    """Remembers when all who tried waited in vain."""

    def __init__(self) -> None:
        self._until_s = 0.0

    def require_over(self) -> None:
        """Raises StoreUnavailable while there is no use in trying."""
        if time.monotonic() < self._until_s:
            raise StoreUnavailable("the database was not to be reached just now; ask again later")

    def begin(self) -> None:
        """Somebody waited in vain."""
        self._until_s = time.monotonic() + _REST_S


class WriteLock:
    """A queue of writers: it moves as long as one of them gets through."""

    def __init__(self, outage: Outage) -> None:
        self._lock = threading.Lock()
        self._outage = outage
        self._done = 0

    @contextmanager
    def hold(self) -> Iterator[None]:
        """Raises StoreUnavailable when no writer got through for PATIENCE_S."""
        done = self._done
        while not self._lock.acquire(timeout=PATIENCE_S):
            self._outage.require_over()
            if done == self._done:
                self._outage.begin()
                self._outage.require_over()
            done = self._done
        try:
            self._outage.require_over()
            yield
        finally:
            self._done += 1
            self._lock.release()
