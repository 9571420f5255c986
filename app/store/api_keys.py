"""An API key, and the digest by which its secret is recognised without being kept.

A secret holds 256 random bits, so its plain SHA-256 can't be turned back by guessing: salts and
slow hashes protect passwords people choose, and would only slow each request down.
"""

import hashlib
import hmac
import secrets
from dataclasses import dataclass
from datetime import datetime
from typing import Literal, get_args

KeyScope = Literal["read", "write", "admin"]
SCOPES: tuple[KeyScope, ...] = get_args(KeyScope)  # each holds those before it

PREFIX = "slewtrack"  # so that scanners for lost secrets, and people, know one when they see it
_SECRET_BYTES = 32
_ID_BYTES = 6
_SECRET_CHARACTERS_MAX = 200


@dataclass(frozen=True, kw_only=True)
class Key:
    """A key as the database knows it; the limits are the service's where None."""

    id: str
    name: str
    secret_sha256: str
    scopes: tuple[KeyScope, ...]
    created_utc: datetime
    revoked_utc: datetime | None = None
    rate_per_minute: int | None = None
    concurrency: int | None = None

    def may(self, needed: KeyScope) -> bool:
        """Whether one of the scopes is or includes the one needed."""
        return any(SCOPES.index(scope) >= SCOPES.index(needed) for scope in self.scopes)


def new_secret() -> tuple[str, str]:
    """A key's id and its secret, which begins with the prefix and the id."""
    key_id = secrets.token_hex(_ID_BYTES)
    return key_id, f"{PREFIX}_{key_id}_{secrets.token_urlsafe(_SECRET_BYTES)}"


def id_in(secret: str) -> str | None:
    """The id a secret claims to belong to; None for what can't be one of ours."""
    parts = secret.split("_", 2)
    if len(secret) > _SECRET_CHARACTERS_MAX or len(parts) != 3 or parts[0] != PREFIX:
        return None
    return parts[1]


def digest(secret: str) -> str:
    return hashlib.sha256(secret.encode()).hexdigest()


def matches(key: Key, secret: str) -> bool:
    """In a time that tells nothing of where the two differ; False for a revoked key."""
    return hmac.compare_digest(key.secret_sha256, digest(secret)) and key.revoked_utc is None
