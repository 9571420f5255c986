"""Waiting of tests for a state, however long a loaded machine takes to come there."""

import time
import uuid
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from fastapi.testclient import TestClient

T = TypeVar("T")
PATIENCE_S = 500.0  # longer than anything takes that comes about, kernels compiled beside it


def eventually(met: Callable[[], T]) -> T:
    """The first true value of a condition."""
    until_s = time.monotonic() + PATIENCE_S
    while time.monotonic() < until_s:
        if value := met():
            return value
        time.sleep(0.02)
    raise AssertionError("it never came about")


def alive(pid: int) -> bool:
    """Whether the process is more than an entry nobody has read yet."""
    try:
        return "State:\tZ" not in Path(f"/proc/{pid}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False


class PatientClient(TestClient):
    """Asks again under the same key until what it asked for is made, unless it says `Prefer`."""

    def post(self, url, **given):
        headers = given.pop("headers", {})
        if "Prefer" in headers:
            return super().post(url, headers=headers, **given)
        headers = {"Prefer": "wait=60", "Idempotency-Key": uuid.uuid4().hex} | headers
        ask = super().post
        return eventually(
            lambda: (answer := ask(url, headers=headers, **given)).status_code != 202 and answer
        )

    def made(self, url, **given):
        """What a request makes."""
        answer = self.post(url, **given)
        assert answer.status_code == 201, answer.text
        return answer.json()
