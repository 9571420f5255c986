"""The command line's calls to a running service, whose refusals are told as if from here."""

from collections.abc import Iterator
from contextlib import contextmanager

from planner.base.errors import InvalidInput, Refusal
from slewtrack.client import BadAnswer, Client, NoAnswer, Problem, Refused, ServiceError

SERVER_ERROR = 500


class RefusedThere(Refusal):
    """What a service refused, told as if it had been refused here."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem.detail, field=problem.field)
        self.problem = problem
        self.is_failure = problem.status >= SERVER_ERROR


@contextmanager
def service(url: str | None) -> Iterator[Client]:
    """The service at an address; raises Refusals."""
    try:
        client = Client(url)
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
