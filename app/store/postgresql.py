"""Connections to PostgreSQL that don't wait for ever for a server that fell silent.

Stopped, or behind a network that passes nothing on: TCP alone tells after minutes, if at all.
"""

import time
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import psycopg
from psycopg.rows import TupleRow
from sqlalchemy import Connection, Dialect, Engine, event
from sqlalchemy.pool import ConnectionPoolEntry

from app.store.turns import Outage

# More than a lock is waited for, which the server tells itself; less than two seconds in all.
SILENCE_MAX_S = 1.6

_Result = TypeVar("_Result")


class BoundedConnection(psycopg.Connection[TupleRow]):
    """Hangs up on a server that says nothing for `silence_max_s`."""

    silence_max_s = SILENCE_MAX_S
    outage: Outage

    def wait(
        self,
        gen: Generator[Any, Any, _Result],
        *how: Any,  # noqa: ANN401 (psycopg's: other versions have others)
        **more: Any,  # noqa: ANN401
    ) -> _Result:
        """All that a connection waits for, it waits for here."""
        return super().wait(self._bounded(gen), *how, **more)

    def _bounded(self, exchange: Generator[Any, Any, _Result]) -> Generator[Any, Any, _Result]:
        """psycopg resumes an exchange ten times a second, by 0 when there was nothing."""
        heard_s = time.monotonic()
        try:
            wanted = next(exchange)
            while True:
                ready = yield wanted
                now_s = time.monotonic()
                if ready:
                    heard_s = now_s
                elif now_s - heard_s > self.silence_max_s:
                    self.outage.begin()
                    self.pgconn.finish()
                    raise psycopg.OperationalError("timeout expired")
                wanted = exchange.send(ready)
        except StopIteration as end:
            result: _Result = end.value
            return result


def bound_silence(engine: Engine) -> None:
    """Have all its connections hang up on a silent server, and none be made just after."""
    outage = Outage()

    def connect(
        _: Dialect, __: ConnectionPoolEntry, words: tuple[Any, ...], options: dict[str, Any]
    ) -> BoundedConnection:
        outage.require_over()
        connection = BoundedConnection.connect(*words, **options)
        connection.outage = outage
        return connection

    event.listen(engine, "do_connect", connect)


@contextmanager
def any_silence(connection: Connection) -> Iterator[None]:
    """For what may take the server long: changing whole tables."""
    driver = connection.connection.driver_connection
    assert isinstance(driver, BoundedConnection)
    driver.silence_max_s = float("inf")
    try:
        yield
    finally:
        driver.silence_max_s = SILENCE_MAX_S
