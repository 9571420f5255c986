"""Where a service is, and one exchange with it as httpx has it."""

import os
from typing import Any
from urllib.parse import urlsplit

import httpx

from slewtrack.asking import Ask, Reply
from slewtrack.problems import NoAnswer

URL = "http://127.0.0.1:8000"
PATIENCE_S = 60.0
_CONNECT_S = 10.0


class Service:
    """Where the service is, and how patient we are with it.

    url: default: the environment's SLEWTRACK_URL, else this machine's port 8000.
    key: an API key, default: SLEWTRACK_KEY; none is needed on loopback.
    patience_s: for how long a service that is busy or can't be reached is asked again.
    """

    def __init__(
        self, url: str | None = None, key: str | None = None, *, patience_s: float = PATIENCE_S
    ) -> None:
        self.url = (url or os.environ.get("SLEWTRACK_URL") or URL).rstrip("/")
        parts = urlsplit(self.url)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"url must be http://HOST:PORT or https://HOST, not {self.url!r}")
        self.patience_s = patience_s
        secret = key or os.environ.get("SLEWTRACK_KEY")
        self.options: dict[str, Any] = {
            "base_url": self.url,
            "headers": {"Authorization": f"Bearer {secret}"} if secret else {},
            # A proxy of the environment can't reach what only this machine can.
            "trust_env": parts.hostname not in ("localhost", "127.0.0.1", "::1"),
        }

    def lost(self, error: httpx.TransportError) -> NoAnswer:
        """What a broken connection means to a call."""
        told = str(error) or type(error).__name__
        return NoAnswer(f"{self.url} gives no answer: {told}; is `slewtrack serve` running there?")


def request_of(ask: Ask) -> dict[str, Any]:
    """The arguments of httpx's `stream`."""
    timeout = httpx.Timeout(ask.silence_s, connect=_CONNECT_S)
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
    """What httpx got."""
    headers = {name.lower(): value for name, value in answer.headers.items()}
    return Reply(status=answer.status_code, headers=headers, body=body)
