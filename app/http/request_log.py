"""The outermost layer of every request: its id, log line, metrics and last resort.

Whatever an answer comes from, refusals of the gate and bugs included, it
carries the id and the security headers.
"""

import time

import structlog
from fastapi import Request
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import ClientDisconnect
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.answers.problem import bug, problem_of
from app.http.headers import REQUEST_ID, harden, remember_request_id, request_id_of
from app.http.metrics import UNMATCHED, Metrics
from app.http.problems import problem_answer, problem_type
from app.log.logs import log
from app.store.unavailable import StoreUnavailable

_PATH_SHOWN = 200
CLIENT_GONE = 499  # as nginx logs it; never sent
_QUIET = frozenset({"/healthz", "/readyz", "/metrics"})  # asked every few seconds for ever


class RequestLog:
    """ASGI middleware, the outermost of ours."""

    def __init__(self, app: ASGIApp, metrics: Metrics) -> None:
        self._app = app
        self._metrics = metrics

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        this = _Answer(scope, send)
        began_s = time.perf_counter()
        with (
            structlog.contextvars.bound_contextvars(request_id=this.request_id),
            self._metrics.http_in_flight.track_inprogress(),
        ):
            try:
                await self._app(scope, receive, this.send)
            except ClientDisconnect:
                this.status = this.status or CLIENT_GONE
            except Exception as error:  # noqa: BLE001 (the edge: the log gets all, the client none)
                await this.fail(error, receive)
            finally:
                self._report(scope, this, time.perf_counter() - began_s)

    def _report(self, scope: Scope, answer: "_Answer", took_s: float) -> None:
        status = int(answer.status or CLIENT_GONE)
        problem = problem_type(scope)
        route = getattr(scope.get("route"), "path", UNMATCHED)
        self._metrics.count_answer(
            method=scope["method"], route=route, status=status, took_s=took_s, problem=problem
        )
        write = log.debug if scope["path"] in _QUIET and status < 400 else log.info
        write(
            "request",
            method=scope["method"],
            path=_shown_path(scope),
            status=status,
            took_ms=round(took_s * 1e3, 1),
            client=(scope.get("client") or ("local",))[0],
            key_id=scope["state"].get("key_id"),
            problem=problem,
        )


class _Answer:
    """What becomes of one request's answer on its way out."""

    def __init__(self, scope: Scope, send: Send) -> None:
        self.status = 0
        self._scope = scope
        self._send = send
        scope["state"] = dict(scope.get("state", {}))  # of this request, not the connection's
        self.request_id = request_id_of(Headers(scope=scope).get(REQUEST_ID))
        remember_request_id(scope, self.request_id)

    async def send(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.status = message["status"]
            headers = MutableHeaders(scope=message)
            headers[REQUEST_ID] = self.request_id
            harden(headers)
        await self._send(message)

    async def fail(self, error: Exception, receive: Receive) -> None:
        """By our fault, or the database's: before the request was let in, or after its answer."""
        if isinstance(error, StoreUnavailable):
            problem = problem_of(error)
        else:
            problem = bug()
            log.error("bug", exc_info=error)
        if self.status:  # too late for another answer: break off, so that none takes it for whole
            raise error
        answer = problem_answer(Request(self._scope), problem)
        await answer(self._scope, receive, self.send)


def _shown_path(scope: Scope) -> str:
    """As it was sent, in ASCII, so that no terminal is steered by it; no query, which may tell."""
    raw: bytes = scope.get("raw_path") or scope["path"].encode("ascii", "backslashreplace")
    return raw[:_PATH_SHOWN].decode("ascii", "replace")
