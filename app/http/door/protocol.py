"""Keeps connections from being held open, flooded or read in two ways.

Uvicorn's HTTP/1.1 by h11, with what uvicorn leaves out: time limits on heads, on what a client
still sends after its answer and on its reading of answers, caps on connections and on what waits
to be sent, one answer at a time on each, and refusals as problems.
"""

import asyncio
import json
import socket
import sys
import uuid
from http import HTTPStatus
from typing import Any, ClassVar

import h11
from starlette.datastructures import MutableHeaders
from uvicorn.protocols.http.h11_impl import H11Protocol

from app.http.door.connections import connections_to_cut, state_of, to_give_way
from app.http.door.headers import REQUEST_ID, harden
from app.http.door.limits import network_of
from app.http.door.request_form import HEAD_BYTES_MAX
from app.http.problems import PROBLEM_JSON, RETRY_AFTER_S

_LINGER_S = 5.0  # for a client to read its refusal while it still sends
# What the kernel holds back of an answer: little, so that we see a slow client read on.
_UNSENT_IN_KERNEL_BYTES = 64 * 1024

_DETAILS = {
    HTTPStatus.BAD_REQUEST: "this is not HTTP/1.1 as RFC 9112 has it",
    HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE: (
        f"the head of a request, or of a chunk, may have {HEAD_BYTES_MAX} bytes"
    ),
    HTTPStatus.NOT_IMPLEMENTED: "of transfer codings only chunked is read",
}


class GuardedProtocol(H11Protocol):
    """One connection.  The settings of the class are set once, before the server starts."""

    connections_max: ClassVar[int]
    head_timeout_s: ClassVar[float]
    write_timeout_s: ClassVar[float]
    unsent_max_bytes: ClassVar[int]
    will_look_at_unsent: ClassVar[bool] = False

    def __init__(self, *args: Any, **kwargs: Any) -> None:  # noqa: ANN401 (uvicorn's own)
        super().__init__(*args, **kwargs)
        self.app_state = self.app_state | state_of(self)
        self.has_key = self.is_let_in = False
        self.network = ""
        self.since_s = self.stuck_since_s = self.loop.time()
        self._deadline: asyncio.TimerHandle | None = None
        self._write_deadline: asyncio.TimerHandle | None = None
        self._goes_on_when_read = False

    @property
    def waits_for_client(self) -> bool:
        """For a head, a body or the reading of an answer."""
        if self.flow.write_paused or self.cycle is None:
            return True
        return bool(self.cycle.response_complete or self.cycle.more_body)

    @property
    def unsent_bytes(self) -> int:
        """Of answers, in our memory."""
        return self.transport.get_write_buffer_size()

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        transport.set_write_buffer_limits(high=0)  # so that we hear of anything that waits
        _hold_little_back(transport.get_extra_info("socket"))
        self.network = network_of(self.client[0] if self.client else "local")
        if len(self.connections) > self.connections_max and not self._find_place():
            self._refuse(HTTPStatus.SERVICE_UNAVAILABLE, self._full())
        else:
            self._watch_clock()

    def connection_lost(self, exc: Exception | None) -> None:
        self._stop_clock()
        self._stop_write_clock()
        super().connection_lost(exc)

    def pause_writing(self) -> None:
        super().pause_writing()
        self.stuck_since_s = self.loop.time()
        self._watch_reading(self.unsent_bytes)
        if not type(self).will_look_at_unsent:  # once for all that pause in this turn of the loop
            type(self).will_look_at_unsent = True
            self.loop.call_soon(self._cut_slowest)

    def _cut_slowest(self) -> None:
        type(self).will_look_at_unsent = False
        for slow in connections_to_cut(self._held(), self.unsent_max_bytes):
            slow.transport.abort()

    def resume_writing(self) -> None:
        self._stop_write_clock()
        super().resume_writing()
        if self._goes_on_when_read:
            self._goes_on_when_read = False
            self.on_response_complete()

    def data_received(self, data: bytes) -> None:
        if self.transport.is_closing():
            return
        super().data_received(data)
        self._watch_clock()

    def on_response_complete(self) -> None:
        if self.flow.write_paused and not self.transport.is_closing():
            self._goes_on_when_read = True  # the next request of a pipeline waits for that
            return
        super().on_response_complete()
        self._watch_clock()

    def send_400_response(self, msg: str) -> None:
        """Where uvicorn ends up with everything h11 can't read."""
        error = sys.exception()
        hint = getattr(error, "error_status_hint", HTTPStatus.BAD_REQUEST)
        status = HTTPStatus(hint)
        self._refuse(status, _DETAILS.get(status, status.description))

    def _watch_clock(self) -> None:
        """The clock runs from the first wait for a head or a late body until it has come."""
        if not self._waits_for_client():
            self._stop_clock()
        elif self._deadline is None:
            limit_s = _LINGER_S if self._is_answered() else self.head_timeout_s
            self._deadline = self.loop.call_later(limit_s, self._too_late)

    def _waits_for_client(self) -> bool:
        if self.transport.is_closing():
            return False
        if self._is_answered():
            return True
        if self.conn.their_state is not h11.IDLE:
            return False
        # Between two requests uvicorn's keep-alive limit holds, until the first byte comes.
        return self.cycle is None or bool(self.conn.trailing_data[0])

    def _is_answered(self) -> bool:
        """The answer is out and the request still isn't whole."""
        done = self.cycle is not None and self.cycle.response_complete
        return done and self.conn.their_state is h11.SEND_BODY

    def _stop_clock(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _too_late(self) -> None:
        self._deadline = None
        if self._is_answered():
            self.transport.close()
        else:
            self._refuse(
                HTTPStatus.REQUEST_TIMEOUT,
                f"the head of a request must come within {self.head_timeout_s:g} s",
            )

    def _watch_reading(self, unsent_bytes: int) -> None:
        """The clock runs as long as something waits, anew whenever some of it was taken."""
        self._write_deadline = self.loop.call_later(
            self.write_timeout_s, self._look_at_reading, unsent_bytes
        )

    def _look_at_reading(self, unsent_bytes: int) -> None:
        if self.unsent_bytes >= unsent_bytes:
            self.transport.abort()
        else:
            self.stuck_since_s = self.loop.time()
            self._watch_reading(self.unsent_bytes)

    def _stop_write_clock(self) -> None:
        if self._write_deadline is not None:
            self._write_deadline.cancel()
            self._write_deadline = None

    def _find_place(self) -> bool:
        """Whether another connection gave way."""
        other = to_give_way(one for one in self._held() if one is not self)
        if other is None:
            return False
        self.connections.discard(other)
        other.give_way()
        return True

    def give_way(self) -> None:
        """End what keeps others out."""
        if self.cycle is not None and self.cycle.response_started:
            self.transport.abort()
            return
        self._refuse(HTTPStatus.SERVICE_UNAVAILABLE, self._full())
        if self.cycle is not None:
            self.cycle.disconnected = True  # what the application answers comes too late

    def _held(self) -> list["GuardedProtocol"]:
        return [one for one in self.connections if isinstance(one, GuardedProtocol)]

    def _full(self) -> str:
        return (
            f"{self.connections_max} connections are served at a time, and one that keeps the "
            "service waiting gives way to others; ask again later"
        )

    def _refuse(self, status: HTTPStatus, detail: str) -> None:
        """Answer for the application, which never saw the request, and hang up."""
        answering = self.cycle is not None and self.cycle.response_started
        if self.conn.our_state in (h11.IDLE, h11.SEND_RESPONSE) and not (
            answering and not self.cycle.response_complete
        ):
            for part in _refusal(status, detail):
                self.transport.write(self.conn.send(part) or b"")
        self.transport.close()


def _hold_little_back(connection: socket.socket) -> None:
    if connection.family in (socket.AF_INET, socket.AF_INET6):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _UNSENT_IN_KERNEL_BYTES)


def _refusal(status: HTTPStatus, detail: str) -> tuple[h11.Event, ...]:
    instance = uuid.uuid4()
    problem = {
        "type": "about:blank",
        "title": status.phrase,
        "status": status.value,
        "detail": detail,
        "instance": instance.urn,
    }
    body = json.dumps(problem).encode("ascii")
    headers = MutableHeaders(
        {
            "Content-Type": PROBLEM_JSON,
            "Content-Length": str(len(body)),
            "Connection": "close",
            REQUEST_ID: str(instance),
        }
    )
    if status == HTTPStatus.SERVICE_UNAVAILABLE:
        headers["Retry-After"] = str(RETRY_AFTER_S)
    harden(headers)
    return (
        h11.Response(status_code=status, headers=headers.raw, reason=status.phrase),
        h11.Data(data=body),
        h11.EndOfMessage(),
    )
