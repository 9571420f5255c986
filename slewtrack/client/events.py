"""The events of work in a service: server-sent events, read line by line.

Source: HTML Living Standard, section 9.2.
"""

import json
import time
from collections.abc import Callable

from slewtrack.client.answers import OPEN_STATES, Progress
from slewtrack.client.problems import BadAnswer
from slewtrack.client.reading import MISREAD, read

OnProgress = Callable[[Progress], None]
SILENCE_S = 45.0  # the service says something every 15 s


class TimeIsUp(Exception):
    """The caller waits no longer."""


class Events:
    """Those of one job; progress is told them, and until_s ends the listening."""

    def __init__(self, progress: OnProgress | None, until_s: float | None) -> None:
        self.progress = progress
        self.until_s = until_s
        self._event: dict[str, str] = {}
        self._state = "queued"
        self.last_id: str | None = None
        self.has_ended = False

    @property
    def headers(self) -> dict[str, str]:
        """Of the request for what comes after those heard."""
        self._event = {}  # one cut short by a lost connection comes again
        after = {} if self.last_id is None else {"Last-Event-ID": self.last_id}
        return {"Accept": "text/event-stream", **after}

    @property
    def silence_s(self) -> float:
        """How long to listen for nothing."""
        left_s = SILENCE_S if self.until_s is None else self.until_s - time.monotonic()
        return min(max(left_s, 0.1), SILENCE_S)

    def take(self, line: str) -> None:
        """Raises TimeIsUp, BadAnswer, or whatever the caller's own function does."""
        if line:
            name, _, value = line.partition(":")
            if name in ("id", "event", "data"):
                self._event[name] = value.removeprefix(" ")
        else:
            event, self._event = self._event, {}
            if "data" in event:
                self.last_id = event.get("id", self.last_id)
                now = self._read(event.get("event", ""), event["data"])
                if self.progress is not None:
                    self.progress(now)
        if self.until_s is not None and time.monotonic() >= self.until_s:
            raise TimeIsUp

    def _read(self, kind: str, text: str) -> Progress:
        try:
            data = json.loads(text)
            if kind == "progress":
                self._state = "running"
            now = read(Progress, data if kind == "state" else {**data, "state": self._state})
        except MISREAD as error:
            raise BadAnswer("an event isn't told as a slewtrack service tells it") from error
        if kind == "state":
            self.has_ended = now.state not in OPEN_STATES
        self._state = now.state
        return now
