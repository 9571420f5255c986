"""Where the databases of a service under attack are made, and what lies between the two."""

import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from sqlalchemy import create_engine, make_url, text

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from relay import Relay

PASSWORD = "canary-password"  # which a server that trusts loopback ignores


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
