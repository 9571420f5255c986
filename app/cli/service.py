"""The command line's calls to a running service, with its refusals, progress and plans."""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rich.console import Console

from app.cli.plan_report import print_report
from app.cli.progress_bar import progress_bar
from planner.base.errors import InvalidInput, Refusal
from slewtrack.client import BadAnswer, Client, NoAnswer, Problem, Progress, Refused, ServiceError

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


@contextmanager
def told_progress() -> Iterator[Callable[[Progress], None]]:
    """As a bar."""
    with progress_bar("planning") as tell:
        yield lambda now: tell(now.stage or now.state, now.done, now.of)


def print_kept(console: Console, members: Mapping[str, Any]) -> None:
    """The report of a plan as the service answers it."""
    table = members["table"]
    print_report(console, members, table["epoch"], len(table["t_s"]))


def table_only_csv(content: bytes) -> bytes:
    """Without the lines that say what the columns don't."""
    lines = content.splitlines(keepends=True)
    return b"".join(line for line in lines if not line.startswith(b"#"))


def json_of(members: Mapping[str, Any]) -> bytes:
    """What a service answered."""
    return json.dumps(members).encode() + b"\n"
