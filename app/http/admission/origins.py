"""The other origins whose web pages may use the service.

Source: Fetch standard, section 3.2 (CORS protocol); RFC 6454 (origins).
"""

from http import HTTPStatus

from fastapi import Response
from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.http.admission.headers import harden

_ASKS_FIRST = "access-control-request-method"
_PREFLIGHT = {
    "Access-Control-Allow-Methods": "GET, HEAD, POST, DELETE",
    "Access-Control-Allow-Headers": "Accept, Authorization, Content-Type, Idempotency-Key, "
    "If-None-Match, Last-Event-ID, Prefer, X-Request-ID",
    "Access-Control-Max-Age": "600",
}
_EXPOSED = (
    "Allow, Content-Disposition, ETag, Link, Location, Preference-Applied, Retry-After, "
    "WWW-Authenticate, X-Request-ID"
)


class Origins:
    """ASGI middleware: tells browsers that pages of these origins may read the answers.

    They need a key like anybody else, where one is needed.  Others' pages get no such word, and
    without a key no answer.
    """

    def __init__(self, app: ASGIApp, allowed: frozenset[str]) -> None:
        self._app = app
        self._allowed = allowed

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or not self._allowed:
            await self._app(scope, receive, send)
            return
        asked = Headers(scope=scope)
        origin = asked.get("origin", "")
        is_allowed = origin.lower() in self._allowed

        async def send_with_word(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                headers.add_vary_header("Origin")
                if is_allowed:
                    headers["Access-Control-Allow-Origin"] = origin
                    headers["Access-Control-Expose-Headers"] = _EXPOSED
            await send(message)

        if is_allowed and scope["method"] == "OPTIONS" and _ASKS_FIRST in asked:
            answer = Response(status_code=HTTPStatus.NO_CONTENT, headers=_PREFLIGHT)
            harden(answer.headers)
            await answer(scope, receive, send_with_word)
        else:
            await self._app(scope, receive, send_with_word)
