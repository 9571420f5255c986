"""Finds the key of a secret, at a cost that wrong secrets can't drive up.

Within its failures a minute each secret of an address is looked up in the database.  Beyond
them only one that a list of all good keys knows, which is read once a second at most: a good key
is answered however many wrong ones come from the same address, and a revoked one never.
"""

import asyncio
import time
from collections.abc import Awaitable, Callable

from app.store.api_keys import Key, digest

LIST_AGE_MAX_S = 1.0

FindKey = Callable[[str], Awaitable[Key | None]]
ListDigests = Callable[[], Awaitable[frozenset[str]]]


class KeyLookup:
    """Keys as the database has them.

    find_key: the good key of a secret.  list_digests: those of all good keys.
    """

    def __init__(
        self,
        find_key: FindKey,
        list_digests: ListDigests,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._find_key = find_key
        self._list_digests = list_digests
        self._clock_s = clock_s
        self._digests: frozenset[str] = frozenset()
        self._listed_s = float("-inf")
        self._listing = asyncio.Lock()

    async def find(self, secret: str, *, sparing: bool) -> Key | None:
        """The good key; sparing: look only for what may be one."""
        if sparing and digest(secret) not in await self._good():
            return None
        return await self._find_key(secret)

    async def _good(self) -> frozenset[str]:
        async with self._listing:
            now_s = self._clock_s()
            if now_s - self._listed_s >= LIST_AGE_MAX_S:
                self._listed_s = now_s  # also when it fails: a sick database isn't asked on and on
                self._digests = await self._list_digests()
            return self._digests
