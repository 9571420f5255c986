"""Bounds on request bodies: the time in which one must arrive, and the bytes held of all."""

import asyncio
from http import HTTPStatus

from starlette.exceptions import HTTPException
from starlette.types import Message, Receive


class HeldBytes:
    """Bytes of bodies now in memory, of all requests together."""

    def __init__(self, most: int) -> None:
        self.most = most
        self.now = 0


class GuardedBody:
    """An ASGI `receive` that refuses a body which comes too slowly or finds no room."""

    def __init__(self, receive: Receive, held: HeldBytes, timeout_s: float) -> None:
        self._receive = receive
        self._held = held
        self._mine = 0
        self._timeout_s = timeout_s
        self._until_s = asyncio.get_running_loop().time() + timeout_s
        self._complete = False

    async def receive(self) -> Message:
        if self._complete:  # what now comes is the end of the connection, however late
            return await self._receive()
        try:
            async with asyncio.timeout_at(self._until_s):
                message = await self._receive()
        except TimeoutError:
            raise HTTPException(
                HTTPStatus.REQUEST_TIMEOUT,
                f"the whole body must come within {self._timeout_s:g} s",
                {"Connection": "close"},
            ) from None
        self._complete = not message.get("more_body", False)
        self._hold(len(message.get("body", b"")))
        return message

    def release(self) -> None:
        """The request is answered."""
        self._held.now -= self._mine
        self._mine = 0

    def _hold(self, count: int) -> None:
        if self._held.now + count > self._held.most:
            raise HTTPException(
                HTTPStatus.SERVICE_UNAVAILABLE,
                f"the bodies of all requests at work may have {self._held.most} bytes together; "
                "ask again when others are done",
            )
        self._held.now += count
        self._mine += count
