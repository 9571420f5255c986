"""The order in which connections are closed when there are too many, or too much waits to be sent.

Never one whose last request came with a good key: first those that keep us waiting, then those
that showed nothing yet or only look at pages; of the network that holds most of them the one held
longest.
"""

from collections import Counter
from collections.abc import Iterable
from typing import Protocol, TypeVar

from starlette.types import Scope

_STATE = "connection"


class OpenConnection(Protocol):
    """A connection.

    has_key: whether its last request came with a good key; is_let_in: whether it may use more than
    pages.  waits_for_client: for a head, a body or the reading of an answer.  since_s: when it
    began, stuck_since_s when its client last took something of an answer that waits;
    unsent_bytes: what waits.
    """

    has_key: bool
    is_let_in: bool
    network: str
    since_s: float
    stuck_since_s: float

    @property
    def waits_for_client(self) -> bool: ...
    @property
    def unsent_bytes(self) -> int: ...


Connection = TypeVar("Connection", bound=OpenConnection)


def to_give_way(connections: Iterable[Connection]) -> Connection | None:
    """The one that leaves its place to a newcomer; None when all have a key or are at work."""
    keyless = [one for one in connections if not one.has_key]
    waiting = [one for one in keyless if one.waits_for_client]
    candidates = waiting or [one for one in keyless if not one.is_let_in]
    count_by = Counter(one.network for one in candidates)
    return min(candidates, key=lambda one: (-count_by[one.network], one.since_s), default=None)


def connections_to_cut(
    connections: Iterable[Connection], unsent_max_bytes: int
) -> list[Connection]:
    """Those whose answers take up more memory than all together may; one at least may stay."""
    stuck = sorted(
        (one for one in connections if one.unsent_bytes),
        key=lambda one: (one.has_key, one.stuck_since_s),
    )
    unsent_bytes = sum(one.unsent_bytes for one in stuck)
    cut = []
    for one in stuck[:-1]:
        if unsent_bytes <= unsent_max_bytes:
            break
        cut.append(one)
        unsent_bytes -= one.unsent_bytes
    return cut


def state_of(connection: OpenConnection) -> dict[str, OpenConnection]:
    """What the state of each request on it holds, for `remember`."""
    return {_STATE: connection}


def connection_of(scope: Scope) -> OpenConnection | None:
    """Of a request; None is served without a server, in tests."""
    connection: OpenConnection | None = scope["state"].get(_STATE)
    return connection


def remember(scope: Scope, *, has_key: bool, is_let_in: bool) -> None:
    """What the request showed, for its connection."""
    connection = connection_of(scope)
    if connection is not None:
        connection.has_key = has_key
        connection.is_let_in = is_let_in
