"""Answers HEAD wherever GET is, with the same headers and nothing else.

Source: RFC 9110, section 9.3.2.
"""

from starlette.types import ASGIApp, Message, Receive, Scope, Send


class HeadAsGet:
    """ASGI middleware: below it there is no HEAD."""

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
