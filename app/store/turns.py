"""Who of this process may write to SQLite now?  One at a time; all hear when nothing moves."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

from app.store.failures import StoreUnavailable

# Long enough for what another process may write at once, short enough to be told in two seconds.
PATIENCE_S = 1.2
# Time in which what kept somebody waiting in vain isn't tried again.
_REST_S = 0.5


class Patience:
    """Remembers when all who tried waited in vain."""

    def __init__(self) -> None:
        self._until_s = 0.0

    def require(self) -> None:
        """Raises StoreUnavailable while there is no use in trying."""
        if time.monotonic() < self._until_s:
            raise StoreUnavailable("the database was not to be reached just now; ask again later")

    def lose(self) -> None:
        """Somebody waited in vain."""
        self._until_s = time.monotonic() + _REST_S


class Turns:
    """A queue of writers: it moves as long as one of them gets through."""

    def __init__(self, patience: Patience) -> None:
        self._lock = threading.Lock()
        self._patience = patience
        self._done = 0

    @contextmanager
    def turn(self) -> Iterator[None]:
        """Raises StoreUnavailable when no writer got through for PATIENCE_S."""
        done = self._done
        while not self._lock.acquire(timeout=PATIENCE_S):
            self._patience.require()
            if done == self._done:
                self._patience.lose()
                self._patience.require()
            done = self._done
        try:
            self._patience.require()
            yield
        finally:
            self._done += 1
            self._lock.release()
