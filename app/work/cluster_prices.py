"""Passes of a fleet's campaign priced by the workers of a cluster, one of which is choosing."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from typing import TYPE_CHECKING

from app.versions import VERSION
from planner.planning.campaigns.joined import FleetPart, Joined
from planner.planning.campaigns.pricing import Ask, AskedPass, PricedPasses, PricedPath, Question

if TYPE_CHECKING:
    from distributed import Client

# A worker of another version never gets a task: its plans would say the wrong version.
SLOT = f"slewtrack-{VERSION}"
WORKER_OF = "SLEWTRACK_WORKER_OF"  # the scheduler's address, in children of its workers
CONNECT_S = 5.0
_LOST = (CancelledError, OSError, TimeoutError)


@contextmanager
def priced_by_workers(joined: Joined) -> Iterator[Ask]:
    """By all workers, in a child of one of several; else, or where they are lost, by this process,
    which answers the same."""
    with _connected() as client:
        yield joined.priced_passes.answers if client is None else _Workers(client, joined).answers


def _connected() -> "AbstractContextManager[Client | None]":
    scheduler = os.environ.get(WORKER_OF)
    if scheduler is None:
        return nullcontext()
    from distributed import Client

    with suppress(*_LOST):
        return Client(scheduler, timeout=CONNECT_S, set_as_default=False, name="slewtrack")
    return nullcontext()


class _Workers:
    """Each keeps the networks of some carriers, and prices their passes in one task a round."""

    def __init__(self, client: "Client", joined: Joined) -> None:
        self._client, self._here = client, joined.priced_passes
        workers = client.scheduler_info(n_workers=-1)["workers"]
        own_version = sorted(one for one, told in workers.items() if SLOT in told["resources"])
        addresses = own_version[: len(joined.carriers)] if len(own_version) > 1 else []
        carriers, self._parts = range(len(joined.carriers)), []
        for first, address in enumerate(addresses):
            part = joined.part(carriers[first :: len(addresses)])
            [sent] = client.scatter([part], workers=[address], direct=True, hash=False)
            passes = client.submit(FleetPart.priced_passes, sent, workers=[address], pure=False)
            self._parts.append((address, part, sent, passes))

    def answers(self, question: Question, asked: Sequence[AskedPass]) -> Sequence[PricedPath]:
        """An `Ask`."""
        tasks = []
        for place in self._parts:
            address, part, _, passes = place
            own, put = part.own(asked), PricedPasses.answers
            there = self._client.submit(put, passes, question, own, workers=[address], pure=False)
            tasks.append((place, own, there))
        found: dict[int, PricedPath] = {}
        for place, own, there in tasks:
            try:
                found |= zip([one.number for one in own], there.result(), strict=True)
            except _LOST:
                self._parts.remove(place)  # priced here from now on
        rest = [one for one in asked if one.number not in found]
        found |= zip([one.number for one in rest], self._here.answers(question, rest), strict=True)
        return [found[one.number] for one in asked]
