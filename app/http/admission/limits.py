"""Limits on one caller's requests, a minute and at a time, and on the bodies of all.

A caller is a key, or an address where none is needed.  Counts are this process's own.
"""

import asyncio
import ipaddress
import math
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus

from starlette.exceptions import HTTPException
from starlette.types import Message, Receive

CALLERS_KEPT = 10_000  # the longest silent one is forgotten first
_IPV6_NETWORK_BITS = 64  # what one customer is given: an address of it is no identity


class RateLimit:
    """Requests per minute and caller; a minute's worth may come at once (token bucket).

    text: what a refusal says, with `per_minute` and `wait_s`.
    """

    def __init__(
        self,
        text: str = "{per_minute} requests a minute are answered; ask again in {wait_s} s",
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._text = text
        self._clock_s = clock_s
        self._spent: OrderedDict[str, tuple[float, float]] = OrderedDict()

    def charge(self, caller: str, per_minute: int) -> None:
        """One request; raises 429 with the wait when nothing is left."""
        used, at_s = self._now(caller, per_minute)
        if used + 1.0 > per_minute:
            wait_s = math.ceil((used + 1.0 - per_minute) * 60.0 / per_minute)
            raise HTTPException(
                HTTPStatus.TOO_MANY_REQUESTS,
                self._text.format(per_minute=per_minute, wait_s=wait_s),
                {"Retry-After": str(wait_s)},
            )
        self._spent[caller] = (used + 1.0, at_s)
        self._spent.move_to_end(caller)
        if len(self._spent) > CALLERS_KEPT:
            self._spent.popitem(last=False)

    def give_back(self, caller: str, per_minute: int) -> None:
        """One request that doesn't count after all."""
        used, at_s = self._now(caller, per_minute)
        self._spent[caller] = (max(0.0, used - 1.0), at_s)

    def has_room(self, caller: str, per_minute: int) -> bool:
        """Whether one more would be let through; spends nothing."""
        used, _ = self._now(caller, per_minute)
        return used + 1.0 <= per_minute

    def _now(self, caller: str, per_minute: int) -> tuple[float, float]:
        now_s = self._clock_s()
        used, at_s = self._spent.get(caller, (0.0, now_s))
        return max(0.0, used - (now_s - at_s) * per_minute / 60.0), now_s


class ConcurrencyLimit:
    """Requests of one caller in work at the same time.

    text: what a refusal says, with `most`.
    """

    def __init__(
        self, text: str = "{most} requests at a time are answered; wait for one to end"
    ) -> None:
        self._text = text
        self._at_work: Counter[str] = Counter()

    @contextmanager
    def one_more(self, caller: str, most: int) -> Iterator[None]:
        """Holds a place; raises 429 when all are taken."""
        if self._at_work[caller] >= most:
            raise HTTPException(
                HTTPStatus.TOO_MANY_REQUESTS,
                self._text.format(most=most),
                {"Retry-After": "1"},
            )
        self._at_work[caller] += 1
        try:
            yield
        finally:
            self._at_work[caller] -= 1
            if not self._at_work[caller]:
                del self._at_work[caller]


def network_of(address: str) -> str:
    """Whom an address belongs to, as far as an address can tell."""
    try:
        found = ipaddress.ip_address(address)
    except ValueError:
        return address
    if found.version == 6 and found.ipv4_mapped is None:
        return str(ipaddress.ip_network((found, _IPV6_NETWORK_BITS), strict=False))
    return str(found)


class HeldBytes:
    """Bytes of bodies now in memory, of all requests together."""

    def __init__(self, most: int) -> None:
        self.most = most
        self.now = 0


class GuardedBody:
    """An ASGI `receive` that refuses a body which comes too slowly or finds no room."""

    def __init__(self, receive: Receive, held: HeldBytes, timeout_s: float) -> None:
        self._receive = receive
        self._held = held
        self._mine = 0
        self._timeout_s = timeout_s
        self._until_s = asyncio.get_running_loop().time() + timeout_s
        self._complete = False

    async def receive(self) -> Message:
        if self._complete:  # what now comes is the end of the connection, however late
            return await self._receive()
        try:
            async with asyncio.timeout_at(self._until_s):
                message = await self._receive()
        except TimeoutError:
            raise HTTPException(
                HTTPStatus.REQUEST_TIMEOUT,
                f"the whole body must come within {self._timeout_s:g} s",
                {"Connection": "close"},
            ) from None
        self._complete = not message.get("more_body", False)
        self._hold(len(message.get("body", b"")))
        return message

    def release(self) -> None:
        self._held.now -= self._mine
        self._mine = 0

    def _hold(self, count: int) -> None:
        if self._held.now + count > self._held.most:
            raise HTTPException(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"the bodies of all requests at work may have {self._held.most} bytes together; "
                "ask again when others are done",
            )
        self._held.now += count
        self._mine += count
