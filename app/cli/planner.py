"""The questions a command asks, whoever answers: this process, or a running service."""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

Members = Mapping[str, Any]


class ParsedAnswer(dict[str, Any]):
    """Members, with the text that held them."""

    def __init__(self, text: bytes) -> None:
        super().__init__(json.loads(text))
        self.text = text


class WorkProgress(Protocol):
    """How far work is: its stage, and how many parts of how many are done."""

    @property
    def stage(self) -> str | None: ...
    @property
    def done(self) -> int | None: ...
    @property
    def of(self) -> int | None: ...


OnProgress = Callable[[WorkProgress], None]


class Flown(Protocol):
    """Flights of a plan; members: of the whole answer."""

    @property
    def members(self) -> Members: ...


class Made(Flown, Protocol):
    """A plan; passed: its verification."""

    @property
    def id(self) -> str: ...
    @property
    def passed(self) -> bool: ...


class Planner(Protocol):
    """`slewtrack.Client`, whose docs tell of each call, and `app.cli.local.Local`."""

    def plan(self, request: bytes, *, progress: OnProgress | None = None) -> Made: ...
    def check(self, request: bytes) -> Members: ...
    def export(self, plan_id: str, format_name: str) -> bytes: ...
    def fly(self, plan_id: str, request: bytes, *, progress: OnProgress | None = None) -> Flown: ...
    def compare(self, request: Members, csv: bytes) -> Members: ...
    def draw_comparison(self, request: Members, csv: bytes, format_name: str) -> bytes: ...


@contextmanager
def planner_at(url: str | None) -> Iterator[Planner]:
    """The service at this address, or this process without one."""
    if url is None:
        from app.cli.local import Local

        yield Local()
        return
    from app.cli.service import service

    with service(url) as client:
        yield client
