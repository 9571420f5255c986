"""The command line's calls to a running service, whose refusals are told as if from here."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Timer

import httpx

from app.cli.one_line import say
from planner.base.errors import InvalidInput, Refusal
from slewtrack.client import BadAnswer, Client, NoAnswer, Problem, Refused, ServiceError
from slewtrack.client.asking import Ask, Reply

SERVER_ERROR = 500
ID_CHARACTERS = 36
SOUGHT_MAX = 2000  # plans, the latest first
SILENCE_S = 2.0  # before somebody who waits is told for whom


class RefusedThere(Refusal):
    """What a service refused, told as if it had been refused here."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.detail, field=problem.field)
        self.problem = problem
        self.is_failure = problem.status >= SERVER_ERROR


class TellingClient(Client):
    """Says once whom it waits for; whoever can't be reached from the first is given up at once."""

    _has_answered = _has_told = False

    async def _answer(self, ask: Ask) -> Reply:
        slow = Timer(SILENCE_S, self._tell)
        slow.daemon = True
        if ask.on_line is None:  # events come when there are some
            slow.start()
        try:
            reply = await super()._answer(ask)
        except (httpx.ConnectError, httpx.ConnectTimeout) as error:
            if self._has_answered:
                raise
            raise InvalidInput(str(self._exchange.meaning(error)), field="--url") from None
        finally:
            slow.cancel()
        self._has_answered = True
        return reply

    def named(self, plan: str, _: Path | None = None) -> str:
        """The id of the one plan whose id begins so; raises InvalidInput."""
        if len(plan) >= ID_CHARACTERS:
            return plan
        found = [job.id for job in self.plans(limit=SOUGHT_MAX) if job.id.startswith(plan)]
        if len(found) != 1:
            how = f"{len(found)} plans begin" if found else "there is no plan whose id begins"
            detail = f"{how} with {plan[:40]!r}; `slewtrack list --wide` has them"
            raise InvalidInput(detail, field="ID")
        return found[0]

    def _tell(self) -> None:
        if not self._has_told:
            self._has_told = True
            say(f"waiting for {self._http.base_url} ...")


@contextmanager
def service(url: str | None) -> Iterator[TellingClient]:
    """The service at an address; raises Refusals."""
    try:
        client = TellingClient(url)
    except ValueError as error:
        raise InvalidInput(str(error), field="--url") from None
    with client:
        try:
            yield client
        except Refused as refused:
            raise RefusedThere(refused.problem) from None
        except (NoAnswer, BadAnswer) as error:
            raise InvalidInput(str(error), field="--url") from None
        except ServiceError as error:
            raise Refusal(str(error)) from None
