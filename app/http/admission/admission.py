"""The checks a request must pass before the service looks at what it asks."""

import asyncio
import math
from collections import Counter
from contextlib import AbstractContextManager, nullcontext
from http import HTTPStatus

from fastapi import Request
from starlette.datastructures import Headers
from starlette.exceptions import HTTPException
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.http.admission.access import PROBES, Access
from app.http.admission.limits import (
    ConcurrencyLimit,
    GuardedBody,
    HeldBytes,
    RateLimit,
    network_of,
)
from app.http.problems import http_error, service_stops
from app.settings import Settings

# Event streams stay open for as long as work takes: they have places of their own, so many for
# each that requests have, and never keep a request out.
STREAMS_SHARE = 0.5

HEADERS_MAX = 100
HEAD_BYTES_MAX = 32 * 1024
QUERY_BYTES_MAX = 8192
PATH_BYTES_MAX = 2048
_ONCE = (b"authorization", b"content-length", b"content-type", b"host", b"transfer-encoding")


def require_valid_head(scope: Scope) -> None:
    """Raise 400, 414, 415, 431 or 505, each with the cap."""
    if not scope["http_version"].startswith("1."):
        raise HTTPException(HTTPStatus.HTTP_VERSION_NOT_SUPPORTED, "HTTP/1.1 is spoken here")
    headers: list[tuple[bytes, bytes]] = scope["headers"]
    if len(headers) > HEADERS_MAX:
        raise HTTPException(
            HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE,
            f"a request may have {HEADERS_MAX} header fields; send fewer",
        )
    if sum(len(name) + len(value) for name, value in headers) > HEAD_BYTES_MAX:
        raise HTTPException(
            HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE,
            f"the header fields of a request may have {HEAD_BYTES_MAX} bytes",
        )
    path = scope.get("raw_path") or scope["path"].encode()
    for part, most in ((path, PATH_BYTES_MAX), (scope["query_string"], QUERY_BYTES_MAX)):
        if len(part) > most:
            raise HTTPException(
                HTTPStatus.REQUEST_URI_TOO_LONG,
                f"an address may have {PATH_BYTES_MAX} bytes of path and {QUERY_BYTES_MAX} of "
                "query; send large things in the body",
            )
    if "\0" in scope["path"]:
        raise _bad("the address holds a null byte; remove %00")
    _require_one_meaning(headers)


def _require_one_meaning(headers: list[tuple[bytes, bytes]]) -> None:
    """Two readers of one connection, a proxy and we, must see the same requests in it."""
    times = Counter(name for name, _ in headers)
    for name in _ONCE:
        if times[name] > 1:
            raise _bad(f"the header {name.decode()} is given {times[name]} times; send it once")
    if times[b"content-length"] and times[b"transfer-encoding"]:
        raise _bad("send Content-Length or Transfer-Encoding, not both")
    coding = dict(headers).get(b"content-encoding", b"identity").strip().lower()
    if coding not in (b"identity", b""):
        raise HTTPException(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            "compressed requests are not read; send the body without Content-Encoding",
            {"Accept-Encoding": "identity"},  # RFC 9110, section 12.5.3
        )


def _bad(detail: str) -> HTTPException:
    # Where the request ends is in doubt: nothing more is read from this connection.
    return HTTPException(HTTPStatus.BAD_REQUEST, detail, {"Connection": "close"})


class Admission:
    """ASGI middleware: shape of the head, who asks, how often, how slowly."""

    def __init__(
        self, app: ASGIApp, access: Access, settings: Settings, stopping: asyncio.Event
    ) -> None:
        self._app = app
        self._stopping = stopping
        self._access = access
        self._settings = settings
        self._held = HeldBytes(settings.max_held_bytes)
        self._rate = RateLimit()
        self._at_once = ConcurrencyLimit()
        self._streams = ConcurrencyLimit(
            "{most} event streams at a time are answered; close one, or ask for the work itself, "
            "which is not counted with them"
        )
        self._line = asyncio.Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        body = GuardedBody(receive, self._held, self._settings.body_timeout_s)
        begun = False

        async def begin_and_send(message: Message) -> None:
            nonlocal begun
            begun = True
            await send(message)

        try:
            require_valid_head(scope)
            if scope["path"] not in PROBES and "authorization" not in Headers(scope=scope):
                async with (
                    self._line
                ):  # one a turn of the loop: a crowd costs those with keys little
                    await asyncio.sleep(0)
            with await self._place(scope):
                await self._app(scope, body.receive, begin_and_send)
        except HTTPException as refusal:
            too_much = refusal.status_code == HTTPStatus.TOO_MANY_REQUESTS
            if too_much and scope["state"].get("key_id") is None:
                # What it has sent on ahead would be refused too, one by one, before others.
                refusal.headers = {**(refusal.headers or {}), "Connection": "close"}
            await http_error(Request(scope), refusal)(scope, receive, send)
        except asyncio.CancelledError:
            if not self._stopping.is_set():
                raise
            if not begun:  # else the connection breaks off, so that none takes it for whole
                await http_error(Request(scope), service_stops())(scope, receive, send)
        finally:
            body.release()

    async def _place(self, scope: Scope) -> AbstractContextManager[None]:
        if scope["path"] in PROBES:  # an orchestrator has no key and must not be locked out
            return nullcontext()
        address = network_of((scope.get("client") or ("local",))[0])
        caller = await self._access.caller(scope, address)
        key, settings = caller.key, self._settings
        scope["state"]["key_id"] = key.id if key else None
        per_minute = (key and key.rate_per_minute) or settings.rate_per_minute
        self._rate.charge(caller.name, per_minute)
        most = (key and key.concurrency) or settings.concurrency_per_key
        path: str = scope["path"]
        if scope["method"] == "GET" and path.startswith("/v1/") and path.endswith("/events"):
            return self._streams.one_more(caller.name, math.ceil(most * STREAMS_SHARE))
        return self._at_once.one_more(caller.name, most)
