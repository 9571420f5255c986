"""What a service tells of work while it goes on: server-sent events, read line by line.

Source: HTML Living Standard, section 9.2.
"""

import json
import time
from collections.abc import Callable, Mapping
from typing import Any

from slewtrack.answers import Progress

OnProgress = Callable[[Progress], None]
SILENCE_S = 45.0  # the service says something every 15 s


class TimeIsUp(Exception):
    """The caller waits no longer."""


class Events:
    """Those of one job; progress is told them, and until_s ends the listening."""

    def __init__(self, progress: OnProgress | None, until_s: float | None) -> None:
        self._progress = progress
        self._until_s = until_s
        self._event: dict[str, str] = {}
        self._state = "queued"
        self.last_id: str | None = None
        self.has_ended = False

    @property
    def is_wanted(self) -> bool:
        """Whether anybody is told of them."""
        return self._progress is not None

    @property
    def headers(self) -> dict[str, str]:
        """Of the request for what comes after those heard."""
        self._event = {}  # one cut short by a lost connection comes again
        after = {} if self.last_id is None else {"Last-Event-ID": self.last_id}
        return {"Accept": "text/event-stream", **after}

    @property
    def silence_s(self) -> float:
        """How long to listen for nothing."""
        left_s = SILENCE_S if self._until_s is None else self._until_s - time.monotonic()
        return min(max(left_s, 0.1), SILENCE_S)

    def take(self, line: str) -> None:
        """Raises TimeIsUp, or whatever the caller's own function does."""
        if line:
            name, _, value = line.partition(":")
            self._event[name] = value.removeprefix(" ")
        else:
            event, self._event = self._event, {}
            if "data" in event:
                self.last_id = event.get("id", self.last_id)
                self._tell(event.get("event", ""), json.loads(event["data"]))
        if self._until_s is not None and time.monotonic() >= self._until_s:
            raise TimeIsUp

    def _tell(self, kind: str, data: Mapping[str, Any]) -> None:
        if kind == "state":
            self._state = data["state"]
            self.has_ended = self._state not in ("queued", "running")
        elif kind == "progress":
            self._state = "running"
        if self._progress is not None:
            told = {name: data.get(name) for name in ("stage", "done", "of", "percent")}
            self._progress(Progress(state=self._state, **told))
