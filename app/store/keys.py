"""The API keys stored."""

from collections.abc import Sequence
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import RowMapping, exists, insert, select, update

from app.store import audit
from app.store.api_keys import Key, KeyScope, digest, id_in, matches, new_secret
from app.store.database import Database
from app.store.models import KeyRow
from planner.base.errors import InvalidInput


class KeyStore:
    """The keys of one database; what changes them is written down in the audit log."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def create(
        self,
        name: str,
        scopes: Sequence[KeyScope],
        *,
        rate_per_minute: int | None = None,
        concurrency: int | None = None,
    ) -> tuple[Key, str]:
        """A new key and its secret, which nobody can be told again."""
        key_id, secret = new_secret()
        values: dict[str, Any] = {
            "id": key_id,
            "name": name,
            "secret_sha256": digest(secret),
            "scopes": list(scopes),
            "created_utc": datetime.now(UTC),
            "rate_per_minute": rate_per_minute,
            "concurrency": concurrency,
        }
        with self._database.writing() as connection:
            connection.execute(insert(KeyRow).values(**values))
            whose = f"{name} ({', '.join(scopes)})"
            audit.record(connection, key_id=None, action="key.create", subject=key_id, detail=whose)
        return Key(**values | {"scopes": tuple(scopes)}), secret

    def all(self) -> list[Key]:
        """Revoked ones, too, the oldest first."""
        query = select(KeyRow.__table__).order_by(KeyRow.created_utc, KeyRow.id)
        with self._database.reading() as connection:
            return [_key(row) for row in connection.execute(query).mappings()]

    def find(self, secret: str) -> Key | None:
        key_id = id_in(secret)
        if key_id is None:
            return None
        query = select(KeyRow.__table__).where(KeyRow.id == key_id)
        with self._database.reading() as connection:
            row = connection.execute(query).mappings().one_or_none()
        key = None if row is None else _key(row)
        return key if key is not None and matches(key, secret) else None

    def good_digests(self) -> frozenset[str]:
        query = select(KeyRow.secret_sha256).where(KeyRow.revoked_utc.is_(None))
        with self._database.reading() as connection:
            return frozenset(connection.execute(query).scalars())

    def any_valid(self) -> bool:
        query = select(exists().where(KeyRow.revoked_utc.is_(None)))
        with self._database.reading() as connection:
            return bool(connection.execute(query).scalar_one())

    def revoke(self, key_id: str) -> None:
        """From the next request on; raises InvalidInput when there is nothing to revoke."""
        with self._database.writing() as connection:
            done = connection.execute(
                update(KeyRow)
                .where(KeyRow.id == key_id, KeyRow.revoked_utc.is_(None))
                .values(revoked_utc=datetime.now(UTC))
            )
            if done.rowcount == 0:
                raise InvalidInput(
                    f"no valid key has the id {key_id[:80]!r}; `slewtrack keys list` shows all",
                    field="ID",
                )
            audit.record(connection, key_id=None, action="key.revoke", subject=key_id)


def _key(row: RowMapping) -> Key:
    return Key(**dict(row) | {"scopes": tuple(row["scopes"])})
