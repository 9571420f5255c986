"""One request to a service and what its reply means, without doing any input or output.

Each call is a generator that yields what to ask and is sent the reply; `Client` and
`AsyncClient` carry them out, each in its own way.  A service that is busy (429, 503) is asked
again when it says, one that can't be reached after a pause that grows; a POST carries an
Idempotency-Key, so that asking twice makes one plan.
"""

import json
import time
import uuid
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Any, TypeVar

from slewtrack.answers import Members
from slewtrack.problems import NoAnswer, Problem, Refused, problem_of

T = TypeVar("T")
Json = bytes | Mapping[str, Any]

SILENCE_S = 150.0  # a search for opportunities may take 120 s before it answers
PAUSE_S, PAUSE_MAX_S = 0.5, 8.0


@dataclass(frozen=True, kw_only=True)
class Ask:
    """One HTTP request.

    parts: of a multipart body, (name, file's name, bytes, media type).  after_s: to wait before.
    silence_s: most time without a byte of the answer.  on_line: is given each line of a good
    answer as it comes; the reply's body is empty then.
    """

    method: str
    path: str
    query: Mapping[str, str] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    body: bytes | None = None
    parts: Sequence[tuple[str, str, bytes, str]] = ()
    after_s: float = 0.0
    silence_s: float = SILENCE_S
    on_line: Callable[[str], None] | None = None


@dataclass(frozen=True, kw_only=True)
class Reply:
    """The answer to it; headers by their names in lower case."""

    status: int
    headers: Mapping[str, str]
    body: bytes


Call = Generator[Ask, Reply, T]


def good(ask: Ask, patience_s: float) -> Call[Reply]:
    """The reply when it is good; raises Refused, or NoAnswer when patience is at its end."""
    until_s = time.monotonic() + patience_s
    pause_s = PAUSE_S
    while True:
        why: Refused | NoAnswer
        try:
            reply = yield ask
        except NoAnswer as lost:
            why, after_s = lost, pause_s
        else:
            if reply.status < 400:
                return reply
            why = Refused(refusal_of(reply))
            if reply.status not in (429, 503):
                raise why
            after_s = _retry_after_s(reply.headers.get("retry-after", ""), pause_s)
        if time.monotonic() + after_s > until_s:
            raise why
        ask = replace(ask, after_s=after_s)
        pause_s = min(2.0 * pause_s, PAUSE_MAX_S)


def document(ask: Ask, patience_s: float) -> Call[Members]:
    """The JSON object of a good reply."""
    return _members(ask, (yield from good(ask, patience_s)))


def _members(ask: Ask, reply: Reply) -> Members:
    try:
        members = json.loads(reply.body)
    except ValueError:
        members = None
    if not isinstance(members, dict):
        raise NoAnswer(f"{ask.method} {ask.path} isn't answered by a slewtrack service")
    return members


def refusal_of(reply: Reply) -> Problem:
    try:
        members = json.loads(reply.body)
    except ValueError:  # of a proxy, perhaps
        members = None
    if not isinstance(members, dict):
        members = {"detail": f"the service answered with the status {reply.status}"}
    return problem_of({"status": reply.status, **members})


def _retry_after_s(text: str, else_s: float) -> float:
    """Seconds, or until a date: RFC 9110, 10.2.3."""
    if text.strip().isdecimal():
        return float(text)
    try:
        return max((parsedate_to_datetime(text) - datetime.now(UTC)).total_seconds(), 0.0)
    except (ValueError, TypeError):
        return else_s


def body_of(request: Json) -> bytes:
    """As it stands, or the dictionary as JSON."""
    return request if isinstance(request, bytes) else json.dumps(request).encode()


def post(
    path: str, request: Json, *, query: Mapping[str, str] | None = None, prefer: str | None = None
) -> Ask:
    """A request under a key of its own."""
    headers = {"Content-Type": "application/json", "Idempotency-Key": uuid.uuid4().hex}
    if prefer is not None:
        headers["Prefer"] = prefer
    return Ask(method="POST", path=path, query=query or {}, headers=headers, body=body_of(request))
