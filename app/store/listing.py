"""The members of a job in lists, beside its name and state, and the words that filters search."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import datetime
from typing import Any

TARGETS_LISTED = 20


@dataclass(frozen=True, kw_only=True)
class Listing:
    """As it was asked for, and once it is made as that turned out.

    platform: its name, or the spacecraft's.  start_utc, stop_utc: of what is looked at, first to
    last.  targets: as people know them, each once.
    probability_in_frame: the least of any session's.
    """

    platform: str = ""
    start_utc: datetime | None = None
    stop_utc: datetime | None = None
    targets: tuple[str, ...] = ()
    probability_in_frame: float | None = None

    def columns(self, name: str) -> dict[str, Any]:
        """Of a `JobRow` with this name."""
        return {
            "platform": self.platform,
            "start_utc": self.start_utc,
            "stop_utc": self.stop_utc,
            "targets": list(self.targets[:TARGETS_LISTED]),
            "target_count": len(self.targets),
            "probability_in_frame": self.probability_in_frame,
            "words": _words((name, self.platform, *self.targets)),
            "target_words": _words(self.targets),
        }


def folded(text: str) -> str:
    """Upper and lower case alike, on every database."""
    return text.casefold()


def _words(texts: Iterable[str]) -> str:
    """One a line: no text that is kept holds a line's end."""
    return folded("\n".join(texts))
