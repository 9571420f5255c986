"""One request to a service and the meaning of its reply, without input or output.

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
from http import HTTPStatus
from pathlib import Path
from typing import Any, TypedDict, TypeVar
from urllib.parse import quote

from slewtrack.client.problems import BadAnswer, NoAnswer, Problem, Refused, problem_of
from slewtrack.client.reading import MISREAD, Members, ParsedAnswer, object_of

T = TypeVar("T")
File = bytes | Path
Json = File | Mapping[str, Any]

SILENCE_S = 150.0  # a search for opportunities may take 120 s before it answers
PAUSE_S, PAUSE_MAX_S = 0.5, 8.0
ANSWER_S = 3600.0  # by a slow network
ANSWER_MAX_BYTES = 256 * 2**20  # the longest table as CZML takes half of it
LINE_MAX_BYTES = 2**20
FOR_GOOD = "urn:slewtrack:problem:store-damaged"  # no use in asking again


@dataclass(frozen=True, kw_only=True)
class Ask:
    """One HTTP request.

    parts: of a multipart body, (name, file's name, bytes, media type).  after_s: to wait before.
    silence_s: most time without a byte of the answer.  until_s: when the whole of it must be there,
    by the monotonic clock; ANSWER_S after it is asked unless said.  on_line: is given each line of
    a good answer as it comes; the reply's body is empty then.
    """

    method: str
    path: str
    query: Mapping[str, str] = field(default_factory=dict)
    headers: Mapping[str, str] = field(default_factory=dict)
    body: bytes | None = None
    parts: Sequence[tuple[str, str, bytes, str]] = ()
    after_s: float = 0.0
    silence_s: float = SILENCE_S
    until_s: float | None = None
    on_line: Callable[[str], None] | None = None


@dataclass(frozen=True, kw_only=True)
class Reply:
    """The answer to it; headers by their names in lower case."""

    status: int
    headers: Mapping[str, str]
    body: bytes


Call = Generator[Ask, Reply, T]


TOO_LONG = "the answer took longer than it may"


class Intake:
    """The body of one answer as it comes; raises BadAnswer where it is longer than it may be."""

    def __init__(self, ask: Ask, status: int) -> None:
        self._on_line = ask.on_line if status < HTTPStatus.BAD_REQUEST else None
        self._most = ANSWER_MAX_BYTES if self._on_line is None else LINE_MAX_BYTES
        self._held = bytearray()

    def take(self, part: bytes) -> None:
        """One after the other; whatever `on_line` raises comes through."""
        self._held += part
        if self._on_line is not None:
            *lines, rest = self._held.split(b"\n")
            self._held = rest
            for line in lines:
                self._on_line(line.removesuffix(b"\r").decode(errors="replace"))
        if len(self._held) > self._most:
            raise BadAnswer(f"an answer or a line of it has more than {self._most} bytes")

    @property
    def body(self) -> bytes:
        """What wasn't handed on."""
        return b"" if self._on_line is not None else bytes(self._held)


def good(ask: Ask, patience_s: float) -> Call[Reply]:
    """The reply when it is good; raises Refused, or NoAnswer when patience is at its end."""
    until_s = time.monotonic() + patience_s
    if ask.until_s is not None:
        until_s = min(until_s, ask.until_s)
    pause_s = PAUSE_S
    while True:
        why: Refused | NoAnswer
        try:
            reply = yield ask
        except NoAnswer as lost:
            why, after_s = lost, pause_s
        else:
            if reply.status < HTTPStatus.MULTIPLE_CHOICES:
                return reply
            if reply.status < HTTPStatus.BAD_REQUEST:
                raise _bad(ask)
            why = Refused(refusal_of(reply))
            if reply.status not in (429, 503) or why.problem.type == FOR_GOOD:
                raise why
            after_s = _retry_after_s(reply.headers.get("retry-after", ""), pause_s)
        if time.monotonic() + after_s > until_s:
            raise why
        ask = replace(ask, after_s=after_s)
        pause_s = min(2.0 * pause_s, PAUSE_MAX_S)


def document(ask: Ask, patience_s: float, read: Callable[[Members], T]) -> Call[T]:
    """What `read` makes of the JSON object of a good reply; raises BadAnswer where it can't."""
    reply = yield from good(ask, patience_s)
    try:
        return read(ParsedAnswer(reply.body))
    except MISREAD as error:
        raise _bad(ask) from error


def _bad(ask: Ask) -> BadAnswer:
    return BadAnswer(f"{ask.method} {ask.path} isn't answered as a slewtrack service answers")


def refusal_of(reply: Reply) -> Problem:
    """With the status of the answer, whatever its body says."""
    try:
        return problem_of({**object_of(json.loads(reply.body)), "status": reply.status})
    except MISREAD:  # of a proxy, perhaps
        detail = f"the service answered with the status {reply.status}"
        return problem_of({"detail": detail, "status": reply.status})


def _retry_after_s(text: str, else_s: float) -> float:
    """Seconds, or until a date: RFC 9110, 10.2.3."""
    if text.strip().isdecimal():
        return float(text)
    try:
        return max((parsedate_to_datetime(text) - datetime.now(UTC)).total_seconds(), 0.0)
    except (ValueError, TypeError, OverflowError):
        return else_s


def address(path: str, *parts: object) -> str:
    """Below a path; a part is a text or has an `id`, and is never more than one step of it."""
    texts = (str(getattr(part, "id", part)) for part in parts)
    return "/".join((path, *(quote(text, safe="").replace(".", "%2E") for text in texts)))


def content_of(file: File) -> bytes:
    """As it stands, or what stands at the path."""
    return file.read_bytes() if isinstance(file, Path) else file


def body_of(request: Json) -> bytes:
    """The same, or the dictionary as JSON."""
    if isinstance(request, Mapping):
        return json.dumps(dict(request), default=dict).encode()  # answers within it, too
    return content_of(request)


def post(
    path: str, request: Json, *, query: Mapping[str, str] | None = None, prefer: str | None = None
) -> Ask:
    """A request under a key of its own."""
    headers = {"Content-Type": "application/json", "Idempotency-Key": uuid.uuid4().hex}
    if prefer is not None:
        headers["Prefer"] = prefer
    return Ask(method="POST", path=path, query=query or {}, headers=headers, body=body_of(request))


class Filters(TypedDict, total=False):
    """Each left out or None lets everything through.

    state: queued, running, done, refused, failed or cancelled.
    name: is a part of the name.  target: of a target's.  text: of the name, platform's or a
    target's.
    after: those that end after this time; before: those that begin before it.  Both are of what
    was asked for, not of when it came: UTC text or an aware datetime.
    campaign: id of one, whose passes are listed; plans of the platform only.
    """

    state: str | None
    name: str | None
    target: str | None
    text: str | None
    after: datetime | str | None
    before: datetime | str | None
    campaign: str | None


def query_of(filters: Mapping[str, object]) -> dict[str, str]:
    """As the service takes them; raises ValueError for a time without its zone."""
    return {name: _text(name, value) for name, value in filters.items() if value is not None}


def _text(name: str, value: object) -> str:
    if not isinstance(value, datetime):
        return str(value)
    if value.utcoffset() is None:
        raise ValueError(f"{name} must be an aware datetime, as datetime(..., tzinfo=UTC) is")
    return value.isoformat()
