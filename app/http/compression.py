"""Answers in the content coding a client prefers: zstd or gzip.

Source: RFC 9110, sections 8.4, 8.8.3.3 and 12.5.3; RFC 8878 (zstd).
"""

import os
import zlib
from collections.abc import Callable
from typing import Literal, Protocol

import anyio
import anyio.to_thread
import zstandard
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

Coding = Literal["zstd", "gzip"]
CODINGS: tuple[Coding, ...] = ("zstd", "gzip")  # the quicker first
SMALLEST_BYTES = 1000  # less goes in one packet as it is
# Windows of 78 MB become 24 MB in 0.16 s of a core by zstd's level 1 (by 3: 26 MB in 0.43 s), and
# 29 MB in 0.6 s by gzip's level 1 (by 4: 26 MB in 1.1 s, by 6: 25 MB in 2.1 s); a plan of 73 kB
# becomes 33 kB in 0.4 ms by gzip's level 1 (by 4: 32 kB in 1.0 ms).
_ZSTD_LEVEL, _GZIP_LEVEL = 1, 1
_GZIP_FORMAT = 31  # of zlib's window bits
_AT_ONCE_BYTES = 64 * 1024  # in a millisecond; more would keep others waiting
_NOT_MODIFIED = 304
_PLAIN_TYPES = frozenset({"application/json", "application/javascript"})
_PLAIN_SUFFIXES = ("+json", "+xml")
_EVENT_STREAM = "text/event-stream"  # each event goes out as it happens


class Packer(Protocol):
    """What zlib's and zstandard's compressors have in common."""

    def compress(self, data: bytes, /) -> bytes:
        """What is ready of the data so far."""

    def flush(self) -> bytes:
        """The rest."""


_PACKERS: dict[Coding, Callable[[], Packer]] = {
    "zstd": lambda: zstandard.ZstdCompressor(level=_ZSTD_LEVEL).compressobj(),
    "gzip": lambda: zlib.compressobj(_GZIP_LEVEL, zlib.DEFLATED, _GZIP_FORMAT),
}


class Compression:
    """ASGI middleware: what goes through it is text, and long enough to be worth it."""

    def __init__(self, app: ASGIApp) -> None:
        self._app = app
        self._threads = anyio.CapacityLimiter(os.cpu_count() or 1)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        coding = preferred_coding(Headers(scope=scope).get("accept-encoding", ""))
        await self._app(scope, receive, _Answer(coding, send, self._threads).send)


class _Answer:
    """One answer on its way out; its head waits until the body tells whether it is long."""

    def __init__(self, coding: Coding | None, send: Send, threads: anyio.CapacityLimiter) -> None:
        self._coding = coding
        self._send = send
        self._threads = threads
        self._head: Message | None = None
        self._packer: Packer | None = None

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            if _may_differ(message):
                self._head = message  # goes out with the body's first part
            else:
                await self._send(message)
            return
        head, self._head = self._head, None
        if head is not None:
            self._begin(head, message)
        if self._packer is not None:
            message = {**message, "body": await self._packed(self._packer, message)}
        if head is not None:
            if self._packer is not None and not message.get("more_body"):
                MutableHeaders(scope=head)["Content-Length"] = str(len(message["body"]))
            await self._send(head)
        await self._send(message)

    def _begin(self, head: Message, first: Message) -> None:
        """Choose how the body is sent, and let the head say so."""
        headers = MutableHeaders(scope=head)
        headers.add_vary_header("Accept-Encoding")
        is_short = not first.get("more_body") and len(first.get("body", b"")) < SMALLEST_BYTES
        if self._coding is None or (is_short and head["status"] != _NOT_MODIFIED):
            return
        # Of the same content in another coding: no longer the same bytes.
        tag = headers.get("etag", "")
        if tag.startswith('"'):
            headers["ETag"] = f"W/{tag}"
        if head["status"] == _NOT_MODIFIED:
            return
        headers["Content-Encoding"] = self._coding
        del headers["accept-ranges"]
        del headers["content-length"]
        self._packer = _PACKERS[self._coding]()

    async def _packed(self, packer: Packer, message: Message) -> bytes:
        body: bytes = message.get("body", b"")
        is_last = not message.get("more_body")

        def pack() -> bytes:
            return packer.compress(body) + (packer.flush() if is_last else b"")

        if len(body) <= _AT_ONCE_BYTES:
            return pack()
        return await anyio.to_thread.run_sync(pack, limiter=self._threads)


def preferred_coding(accept_encoding: str) -> Coding | None:
    """Which of ours an Accept-Encoding header weighs most; None for the answer as it is."""
    weights: dict[str, float] = {}
    for part in accept_encoding.lower().split(","):
        name, *parameters = (word.strip() for word in part.split(";"))
        weights[name] = _weight(parameters)
    offered = {coding: weights.get(coding, weights.get("*", 0.0)) for coding in CODINGS}
    best = max(CODINGS, key=lambda coding: offered[coding])
    if offered[best] > 0.0 and offered[best] >= weights.get("identity", 0.0):
        return best
    return None


def _weight(parameters: list[str]) -> float:
    """What can't be read as one counts as 0: the answer as it is can be read by all."""
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name.strip() == "q":
            try:
                return float(value)
            except ValueError:
                return 0.0
    return 1.0


def _may_differ(head: Message) -> bool:
    """Whether an answer may be sent in another coding than it is."""
    headers = Headers(raw=head["headers"])
    if head["status"] == _NOT_MODIFIED:
        return True
    if head["status"] in (204, 206) or "content-encoding" in headers:
        return False
    media_type = headers.get("content-type", "").split(";")[0].strip().lower()
    return media_type != _EVENT_STREAM and (
        media_type.startswith("text/")
        or media_type in _PLAIN_TYPES
        or media_type.endswith(_PLAIN_SUFFIXES)
    )
