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

from app.store.sqlite_write_lock import Outage

# More than a lock is waited for, which the server tells itself; less than two seconds in all.
SILENCE_MAX_S = 1.6

_Result = TypeVar("_Result")


class SilentServer(psycopg.OperationalError):
    """It said nothing for too long; psycopg's own patience with one is at least 2 s."""


class BoundedConnection(psycopg.Connection[TupleRow]):
    """Hangs up on a server that says nothing for `silence_max_s`, and while it is made."""

    silence_max_s = SILENCE_MAX_S
    outage: Outage

    @classmethod
    def _connect_gen(cls, *how: Any, **more: Any) -> Any:  # noqa: ANN401 (psycopg's)
        return _bound_exchange(super()._connect_gen(*how, **more), SILENCE_MAX_S)

    def wait(
        self,
        gen: Generator[Any, Any, _Result],
        *how: Any,  # noqa: ANN401 (psycopg's: other versions have others)
        **more: Any,  # noqa: ANN401
    ) -> _Result:
        """All that a connection waits for, it waits for here."""
        try:
            return super().wait(_bound_exchange(gen, self.silence_max_s), *how, **more)
        except SilentServer:
            self.outage.begin()
            self.pgconn.finish()
            raise


def _bound_exchange(
    exchange: Generator[Any, Any, _Result], silence_max_s: float
) -> Generator[Any, Any, _Result]:
    """psycopg resumes an exchange ten times a second, by 0 when there was nothing.

    Raises SilentServer.
    """
    heard_s = time.monotonic()
    try:
        wanted = next(exchange)
        while True:
            ready = yield wanted
            now_s = time.monotonic()
            if ready:
                heard_s = now_s
            elif now_s - heard_s > silence_max_s:
                raise SilentServer("timeout expired")
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
        try:
            connection = BoundedConnection.connect(*words, **options)
        except SilentServer:
            outage.begin()
            raise
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
