"""Limits on the rate of one caller's requests, and on their number at a time.

A caller is a key, or an address where none is needed.  Counts are this process's own.
"""

import ipaddress
import math
import time
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus

from starlette.exceptions import HTTPException

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
