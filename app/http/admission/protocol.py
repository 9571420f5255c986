"""Keeps connections from being held open, flooded or read in two ways.

Stands between asyncio and uvicorn's HTTP/1.1 by h11, of which it knows no more than that it is a
protocol.  It adds what uvicorn leaves out: time limits on heads and on a client's reading of
answers, caps on connections and on what waits to be sent, and refusals as problems.
"""

import asyncio
import socket
import sys
from http import HTTPStatus
from typing import Any, ClassVar

import h11
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.http.admission.admission import HEAD_BYTES_MAX
from app.http.headers import REQUEST_ID, harden, remember_request_id, request_id_of
from app.http.problems import http_error
from app.settings import Settings

# What the kernel holds back of an answer: little, so that we see a slow client read on.
_UNSENT_IN_KERNEL_BYTES = 64 * 1024
_STATE = "connection"  # of each request

_DETAILS = {
    HTTPStatus.BAD_REQUEST: "this is not HTTP/1.1 as RFC 9112 has it",
    HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: (
        f"the head of a request, or of a chunk, may have {HEAD_BYTES_MAX} bytes"
    ),
    HTTPStatus.NOT_IMPLEMENTED: "of transfer codings only chunked is read",
}


class GuardedProtocol(asyncio.Protocol):
    """One connection.  What the class holds is set once, before the server starts.

    by_h11: uvicorn's own protocol, made with the arguments that it makes ours with.
    """

    by_h11: ClassVar[type[asyncio.Protocol]]
    settings: ClassVar[Settings]
    held: ClassVar[set["GuardedProtocol"]]

    def __init__(self, *, app_state: dict[str, Any], **kwargs: Any) -> None:  # noqa: ANN401
        kwargs["app_state"] = app_state | {_STATE: self}
        self._inner = self.by_h11(**kwargs)
        self._loop = asyncio.get_running_loop()
        self._at_work = 0  # requests that have come and aren't answered
        self._has_begun = False  # the answer to the last of them
        self._is_read = asyncio.Event()  # all that was to be sent
        self._is_read.set()
        self._deadline: asyncio.TimerHandle | None = None
        self._write_deadline: asyncio.TimerHandle | None = None
        self.stuck_since_s = 0.0

    @property
    def unsent_bytes(self) -> int:
        """Of answers, in our memory."""
        return self._transport.get_write_buffer_size()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        transport.set_write_buffer_limits(high=0)  # so that we hear of anything that waits
        line: socket.socket = transport.get_extra_info("socket")
        if line.family in (socket.AF_INET, socket.AF_INET6):
            line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _UNSENT_IN_KERNEL_BYTES)
        self._inner.connection_made(_Transport(self, transport))
        if len(self.held) >= (most := self.settings.max_connections):
            detail = f"{most} connections are served at a time; ask again later"
            self.refuse(HTTPStatus.SERVICE_UNAVAILABLE, detail)
        else:
            self.held.add(self)
            self._watch_head()

    def connection_lost(self, exc: Exception | None) -> None:
        self.held.discard(self)
        self._stop_head_clock()
        self._stop_write_clock()
        self._is_read.set()
        self._inner.connection_lost(exc)

    def eof_received(self) -> bool | None:
        return self._inner.eof_received()

    def data_received(self, data: bytes) -> None:
        if self._transport.is_closing():
            return
        try:
            self._inner.data_received(data)
        except h11.LocalProtocolError:  # no answer fits where one has begun
            self._transport.close()
        if not self._at_work:
            self._watch_head()

    def pause_writing(self) -> None:
        self._inner.pause_writing()
        self._is_read.clear()
        self.stuck_since_s = self._loop.time()
        self._watch_reading(self.unsent_bytes)
        self._cut_slowest()

    def resume_writing(self) -> None:
        self._stop_write_clock()
        self._is_read.set()
        self._inner.resume_writing()

    def _cut_slowest(self) -> None:
        """Answers may take up so much memory together; one that is alone may take more."""
        stuck = {one for one in self.held - {self} if one.unsent_bytes}
        while stuck and sum(one.unsent_bytes for one in self.held) > self.settings.max_unsent_bytes:
            slowest = min(stuck, key=lambda one: one.stuck_since_s)
            stuck.remove(slowest)
            slowest._transport.abort()

    async def answer(self, app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
        """A request whose head has come, once what was answered before it has been read."""
        self._stop_head_clock()
        self._at_work += 1

        async def begin_and_send(message: Message) -> None:
            self._has_begun = True
            await send(message)

        try:
            await self._is_read.wait()
            self._has_begun = False
            await app(scope, receive, begin_and_send)
        finally:
            self._at_work -= 1

    def _watch_head(self) -> None:
        """The clock runs from the first wait for a head until it has come."""
        if self._deadline is None and not self._transport.is_closing():
            within_s, late = self.settings.head_timeout_s, HTTPStatus.REQUEST_TIMEOUT
            detail = f"the head of a request must come within {within_s:g} s"
            self._deadline = self._loop.call_later(within_s, self.refuse, late, detail)

    def _stop_head_clock(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _watch_reading(self, unsent_bytes: int) -> None:
        """The clock runs as long as something waits, anew whenever some of it was taken."""
        self._write_deadline = self._loop.call_later(
            self.settings.write_timeout_s, self._look_at_reading, unsent_bytes
        )

    def _look_at_reading(self, unsent_bytes: int) -> None:
        if self.unsent_bytes >= unsent_bytes:
            self._transport.abort()
        else:
            self.stuck_since_s = self._loop.time()
            self._watch_reading(self.unsent_bytes)

    def _stop_write_clock(self) -> None:
        if self._write_deadline is not None:
            self._write_deadline.cancel()
            self._write_deadline = None

    def refuse(self, status: HTTPStatus, detail: str) -> None:
        """Answer for the application, which never saw the request, and hang up."""
        self._stop_head_clock()
        if not (self._at_work and self._has_begun):
            self._transport.write(_refusal(status, detail))
        self._transport.close()


class _Transport(asyncio.Transport):
    """The connection as uvicorn sees it: what it would say for itself of a request is a problem."""

    def __init__(self, guard: GuardedProtocol, transport: asyncio.Transport) -> None:
        self._guard = guard
        self._transport = transport

    def __getattribute__(self, name: str) -> Any:  # noqa: ANN401 (whatever the transport has)
        if name in ("write", "_guard", "_transport"):
            return super().__getattribute__(name)
        return getattr(self._transport, name)

    def write(self, data: bytes | bytearray | memoryview) -> None:
        if self._transport.is_closing():
            return
        error = sys.exception()
        if not isinstance(error, h11.RemoteProtocolError):
            self._transport.write(data)
            return
        status = HTTPStatus(error.error_status_hint)
        self._guard.refuse(status, _DETAILS.get(status, status.description))


async def answer_guarded(app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
    """As an ASGI application: through the connection on which the request came."""
    connection = scope.get("state", {}).get(_STATE)
    if scope["type"] == "http" and isinstance(connection, GuardedProtocol):
        await connection.answer(app, scope, receive, send)
    else:
        await app(scope, receive, send)


def _refusal(status: HTTPStatus, detail: str) -> bytes:
    request_id = request_id_of(None)
    scope: Scope = {"type": "http", "state": {}}
    remember_request_id(scope, request_id)
    headers = {"Connection": "close", REQUEST_ID: request_id}
    answer = http_error(Request(scope), HTTPException(status, detail, headers))
    harden(answer.headers)
    first = f"HTTP/1.1 {status.value} {status.phrase}\r\n".encode("ascii")
    told = b"".join(b"%s: %s\r\n" % header for header in answer.raw_headers)
    return first + told + b"\r\n" + bytes(answer.body)
