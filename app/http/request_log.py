"""The outermost layer of every request: its id, log line, metrics and last resort; HEAD as GET.

Whatever an answer comes from, refusals on admission and bugs included, it
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
from app.http.problems import PROBLEM_TYPE, problem_answer
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
        scope["state"] = dict(scope.get("state", {}))  # of this request, not the connection's
        request_id = request_id_of(Headers(scope=scope).get(REQUEST_ID))
        remember_request_id(scope, request_id)
        began_s, status = time.perf_counter(), 0

        async def send_with_headers(message: Message) -> None:
            nonlocal status
            if message["type"] == "http.response.start":
                status = message["status"]
                headers = MutableHeaders(scope=message)
                headers[REQUEST_ID] = request_id
                harden(headers)
            await send(message)

        with (
            structlog.contextvars.bound_contextvars(request_id=request_id),
            self._metrics.http_in_flight.track_inprogress(),
        ):
            try:
                await self._app(scope, receive, send_with_headers)
            except ClientDisconnect:
                pass
            except Exception as error:  # the log gets all of it, the client none
                if not isinstance(error, StoreUnavailable):
                    log.error("bug", exc_info=error)
                if status:  # too late for another: break off, so that none takes it for whole
                    raise
                problem = problem_of(error) if isinstance(error, StoreUnavailable) else bug()
                await problem_answer(Request(scope), problem)(scope, receive, send_with_headers)
            finally:
                self._report(scope, status or CLIENT_GONE, time.perf_counter() - began_s)

    def _report(self, scope: Scope, status: int, took_s: float) -> None:
        problem: str | None = scope["state"].get(PROBLEM_TYPE)
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


def _shown_path(scope: Scope) -> str:
    """As it was sent, in ASCII, so that no terminal is steered by it; no query, which may tell."""
    raw: bytes = scope.get("raw_path") or scope["path"].encode("ascii", "backslashreplace")
    return raw[:_PATH_SHOWN].decode("ascii", "replace")


class HeadAsGet:
    """ASGI middleware: below it there is no HEAD, which has GET's headers and nothing else.

    Source: RFC 9110, section 9.3.2.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] != "HEAD":
            await self._app(scope, receive, send)
            return
        inner = {**scope, "method": "GET"}

        async def send_head(message: Message) -> None:
            if message["type"] == "http.response.start":
                await send(message)
                # At once: a stream ends by it, since nobody listens on.
                await send({"type": "http.response.body", "body": b""})

        try:
            await self._app(inner, receive, send_head)
        finally:
            if "route" in inner:  # for the log and the metrics
                scope["route"] = inner["route"]
