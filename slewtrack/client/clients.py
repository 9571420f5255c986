"""The clients of a running service: one waits for each call, the other is awaited."""

import time
from typing import Self

import anyio
import httpx

from slewtrack.client.asking import TOO_LONG, Ask, Intake, Reply
from slewtrack.client.calls import (
    PLATFORM,
    SPACECRAFT,
    AsyncCarrier,
    Calls,
    Exchange,
    ServiceCalls,
)
from slewtrack.client.connection import (
    PATIENCE_S,
    Service,
    in_time,
    left_s,
    reply_of,
    request_of,
    start_clock,
)
from slewtrack.client.problems import NoAnswer


class Client(Calls):
    """A service, asked and waited for; close it, or use it in `with`.

    url: default: the environment's SLEWTRACK_URL, else this machine's port 8000.
    key: an API key, default: SLEWTRACK_KEY; none is needed on loopback.
    patience_s: for how long a service that is busy or can't be reached is asked again.
    progress: of what takes long, called with a `Progress` at each step.
    timeout_s: how long to wait, then `NotFinished`; the work goes on.
    spacecraft: the same calls for the imaging spacecraft, whose plans are kept apart.
    """

    def __init__(
        self,
        url: str | None = None,
        key: str | None = None,
        *,
        patience_s: float = PATIENCE_S,
        transport: httpx.BaseTransport | None = None,
    ) -> None:
        service = Service(url, key, patience_s=patience_s)
        self._http = httpx.Client(transport=transport, **service.options)
        super().__init__(Exchange(self._answer, service.meaning, patience_s))

    async def _answer(self, ask: Ask) -> Reply:
        time.sleep(ask.after_s)
        start_clock(ask)
        with self._http.stream(**request_of(ask), extensions={"trace": in_time}) as answer:
            intake = Intake(ask, answer.status_code)
            for part in answer.iter_bytes():
                intake.take(part)
            return reply_of(answer, intake.body)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End its connections."""
        self._http.close()


class AsyncClient(ServiceCalls, AsyncCarrier):
    """A service, asked and awaited; the same as `Client` otherwise."""

    def __init__(
        self,
        url: str | None = None,
        key: str | None = None,
        *,
        patience_s: float = PATIENCE_S,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        service = Service(url, key, patience_s=patience_s)
        self._http = httpx.AsyncClient(transport=transport, **service.options)
        super().__init__(Exchange(self._answer, service.meaning, patience_s), PLATFORM)
        self.spacecraft = AsyncCarrier(self._exchange, SPACECRAFT)

    async def _answer(self, ask: Ask) -> Reply:
        await anyio.sleep(ask.after_s)
        with anyio.move_on_after(left_s(ask)):  # the head that comes byte by byte, too
            async with self._http.stream(**request_of(ask)) as answer:
                intake = Intake(ask, answer.status_code)
                async for part in answer.aiter_bytes():
                    intake.take(part)
                return reply_of(answer, intake.body)
        raise NoAnswer(TOO_LONG)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """End its connections."""
        await self._http.aclose()
