"""The clients of a running service: one waits for each call, the other is awaited."""

import math
import os
import time
from collections.abc import Callable
from contextvars import ContextVar
from functools import partial
from typing import Any, Self
from urllib.parse import urlsplit

import anyio
import httpx

from slewtrack.client.asking import ANSWER_S, TOO_LONG, Ask, Intake, Reply
from slewtrack.client.calls import (
    PLANS,
    SPACECRAFT_PLANS,
    AsyncCarrier,
    Calls,
    Exchange,
    ServiceCalls,
)
from slewtrack.client.problems import BadAnswer, NoAnswer

URL = "http://127.0.0.1:8000"
PATIENCE_S = 60.0
_CONNECT_S = 10.0
LEAST_S = 0.1  # for an answer that may be there already
_PART_BYTES = 2**16  # of what is sent, before the time is looked at again
_until_s: ContextVar[float] = ContextVar("_until_s", default=math.inf)


class Service:
    """Where the service is.

    url: default: the environment's SLEWTRACK_URL, else this machine's port 8000.
    key: an API key, default: SLEWTRACK_KEY; none is needed on loopback.
    """

    def __init__(self, url: str | None = None, key: str | None = None) -> None:
        self.url = (url or os.environ.get("SLEWTRACK_URL") or URL).rstrip("/")
        parts = urlsplit(self.url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"url must be http://HOST:PORT or https://HOST, not {self.url!r}")
        secret = key or os.environ.get("SLEWTRACK_KEY")
        self.options: dict[str, Any] = {
            "base_url": self.url,
            "headers": {"Authorization": f"Bearer {secret}"} if secret else {},
            # A proxy of the environment can't reach what only this machine can.
            "trust_env": parts.hostname not in ("localhost", "127.0.0.1", "::1"),
        }

    def meaning(self, error: Exception) -> Exception:
        """What is thrown into a call for what came out of an exchange."""
        told = str(error) or type(error).__name__
        if isinstance(error, httpx.TransportError):
            return NoAnswer(
                f"{self.url} gives no answer: {told}; is `slewtrack serve` running there?"
            )
        if isinstance(error, httpx.RequestError | httpx.InvalidURL):
            return BadAnswer(f"{self.url} can't be asked so, or answers unreadably: {told}")
        return error


def left_s(ask: Ask) -> float:
    return ANSWER_S if ask.until_s is None else max(ask.until_s - time.monotonic(), LEAST_S)


def start_clock(ask: Ask) -> None:
    """Of what this thread reads and writes by a connection whose opening `in_time` was told."""
    _until_s.set(time.monotonic() + left_s(ask))


def in_time(event: str, told: dict[str, Any]) -> None:
    """Httpcore's `trace`: a connection that opens ends each exchange when its clock says.

    httpx's own timeouts bound each read and write; a head that comes byte by byte has many.
    Source: https://www.encode.io/httpcore/extensions/#trace
    """
    if event.endswith(("connect_tcp.complete", "start_tls.complete")):
        stream = told["return_value"]  # an httpcore.NetworkStream
        stream.read = partial(_read, stream.read)
        stream.write = partial(_write, stream.write)


def _read(read: Callable[..., bytes], max_bytes: int, timeout: float | None = None) -> bytes:
    return read(max_bytes, _bounded(timeout))


def _write(write: Callable[..., None], buffer: bytes, timeout: float | None = None) -> None:
    for begin in range(0, len(buffer), _PART_BYTES):
        write(buffer[begin : begin + _PART_BYTES], _bounded(timeout))


def _bounded(timeout_s: float | None) -> float:
    left_s = _until_s.get() - time.monotonic()
    if left_s <= 0.0:
        raise NoAnswer(TOO_LONG)
    return left_s if timeout_s is None else min(timeout_s, left_s)


def request_of(ask: Ask) -> dict[str, Any]:
    """The arguments of httpx's `stream`."""
    whole_s = left_s(ask)
    timeout = httpx.Timeout(min(ask.silence_s, whole_s), connect=min(_CONNECT_S, whole_s))
    parts = [(name, (file, body, kind)) for name, file, body, kind in ask.parts]
    return {
        "method": ask.method,
        "url": ask.path,
        "params": dict(ask.query),
        "headers": dict(ask.headers),
        "content": ask.body,
        "files": parts or None,
        "timeout": timeout,
    }


def reply_of(answer: httpx.Response, body: bytes) -> Reply:
    """What httpx got, its body as it was taken in."""
    headers = {name.lower(): value for name, value in answer.headers.items()}
    return Reply(status=answer.status_code, headers=headers, body=body)


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
        service = Service(url, key)
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
        service = Service(url, key)
        self._http = httpx.AsyncClient(transport=transport, **service.options)
        super().__init__(Exchange(self._answer, service.meaning, patience_s), PLANS)
        self.spacecraft = AsyncCarrier(self._exchange, SPACECRAFT_PLANS)

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
