"""What do the KVN and XML readers of an OEM hand over, and how do they complain?"""

from dataclasses import dataclass
from typing import NoReturn

from planner.errors import InvalidMessage


@dataclass
class RawSegment:
    """Texts of one segment as they stand in the message; `lines` numbers the rows."""

    line: int
    metadata: dict[str, str]
    epochs: list[str]
    rows: list[list[str]]
    lines: list[int]


def refuse(line: int, what: str) -> NoReturn:
    """Say what is wrong with the message, and in which line."""
    raise InvalidMessage(f"OEM line {line}: {what}")
