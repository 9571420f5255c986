"""Where the databases of a service under attack are made, and what lies between the two."""

import contextlib
import select
import socket
import threading
import time
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from sqlalchemy import create_engine, make_url, text

PASSWORD = "canary-password"  # which a server that trusts loopback ignores


class Relay:
    """Passes a port of loopback on to a server; can hang up, or fall silent."""

    def __init__(self, host: str, port: int) -> None:
        self._target = (host, port)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._pairs: list[tuple[socket.socket, socket.socket]] = []
        self.refuses = self.is_silent = False
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            here, _ = self._listener.accept()
            if self.refuses:
                here.close()
                continue
            there = socket.create_connection(self._target)
            self._pairs.append((here, there))
            threading.Thread(target=self._pass_on, args=(here, there), daemon=True).start()

    def _pass_on(self, here: socket.socket, there: socket.socket) -> None:
        other = {here: there, there: here}
        with contextlib.suppress(OSError, ValueError), here, there:
            while True:
                for end in select.select([here, there], [], [], 1.0)[0]:
                    while self.is_silent:
                        time.sleep(0.05)
                    data = end.recv(65536)
                    if not data:
                        return
                    other[end].sendall(data)

    def hang_up(self) -> None:
        for pair in self._pairs:
            for end in pair:
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
        self._pairs.clear()


@dataclass(frozen=True, kw_only=True)
class Database:
    """One database of the service's own; the relay lies between the two, if there is a server."""

    url: str
    direct_url: str = field(repr=False, default="")
    relay: Relay | None = None


@dataclass(frozen=True)
class Server:
    """Where databases are made; SQLite, in the service's own folder, without a URL."""

    url: str

    @property
    def kind(self) -> str:
        return "postgresql" if self.url else "sqlite"

    @property
    def name(self) -> str:
        return "PostgreSQL" if self.url else "SQLite    "

    @contextmanager
    def database(self) -> Iterator[Database]:
        """An empty one."""
        if not self.url:
            yield Database(url="")
            return
        name = f"hostile_{uuid.uuid4().hex[:12]}"
        engine = create_engine(self.url, isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            connection.execute(text(f"CREATE DATABASE {name}"))
        direct = make_url(self.url).set(database=name)
        relay = Relay(direct.host or "127.0.0.1", direct.port or 5432)
        relayed = direct.set(host="127.0.0.1", port=relay.port, password=PASSWORD)
        try:
            yield Database(
                url=relayed.render_as_string(hide_password=False),
                direct_url=direct.render_as_string(hide_password=False),
                relay=relay,
            )
        finally:
            relay.hang_up()
            with engine.connect() as connection:
                connection.execute(text(f"DROP DATABASE {name} WITH (FORCE)"))
            engine.dispose()
